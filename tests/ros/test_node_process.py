# SPDX-License-Identifier: Apache-2.0
"""The node's process among others: parents, second commanders, late regulators, a cold cache."""

import os
import signal
import subprocess
import sys
from itertools import cycle
from pathlib import Path

import pytest
from rcl_interfaces.srv import ListParameters
from ros.harness import ALL, DEADLINE, FAST_RAMP, PATIENT, START_DEADLINE, RunningNode
from std_msgs.msg import Float64

from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.process.node_process import NODE
from spiral_gripper_ros.process.program import choose_transport
from spiral_gripper_ros.process.stop_signals import STARTED_BY, Parent

ADAPTER = "spiral_gripper_ros.regulators.main"
PYTHON = sys.executable, "-c"
# Starts what its arguments say, and waits: what `ros2 run` does.
STARTER = *PYTHON, "import subprocess, sys; subprocess.Popen(sys.argv[1:]).wait()"


@pytest.mark.parametrize("ends", [True, False])
def test_a_node_ends_with_the_process_that_started_it(client, namespace, ends):
    """Without the parameter it survives its parent."""
    given = ["-r", f"__ns:={namespace}", "-p", f"exit_with_parent:={ends}"]
    node = [sys.executable, "-m", NODE, "--ros-args", *given]
    with subprocess.Popen([*STARTER, *node]) as parent:
        client.wait_until_active()
        (child,) = Path(f"/proc/{parent.pid}/task/{parent.pid}/children").read_text().split()
        client.wrap(0.02)
        parent.kill()
    if not ends:
        client.hear_more(50)
        os.kill(int(child), signal.SIGINT)
    client.wait_for_vent()
    client.wait_until(lambda: client.count_publishers("pressure_command") == 0, "its end")


def test_an_adapter_ends_vented_with_the_launch_that_started_it(client, namespace):
    passed_on, starts = [], cycle([0.0] * 25 + [5.0e4] * 25)  # it waits for 0 Pa first
    client.create_subscription(
        Float64, "regulator/set_point", lambda one: passed_on.append(one.data), ALL
    )
    commands = client.create_publisher(Float64, "pressure_command", 1)

    def command():
        commands.publish(Float64(data=5.0e4 if 5.0e4 in passed_on else next(starts)))

    client.create_timer(0.02, command)
    adapter = [sys.executable, "-m", ADAPTER, "--ros-args", "-r", f"__ns:={namespace}"]
    environment = {**os.environ, STARTED_BY: str(os.getpid())}
    with subprocess.Popen([*STARTER, *adapter], env=environment) as parent:
        client.wait_until(lambda: 5.0e4 in passed_on, "a set-point")
        parent.kill()
    client.wait_until(lambda: client.count_publishers("regulator/set_point") == 0, "its end")
    client.spin()
    assert passed_on[-1] == 0.0


def test_a_node_ends_if_what_launched_it_has_ended_before_it_could_look(namespace, monkeypatch):
    launch = subprocess.Popen([*PYTHON, ""])
    environment = {STARTED_BY: str(launch.pid)}
    monkeypatch.setenv(STARTED_BY, str(launch.pid))
    os.waitid(os.P_PID, launch.pid, os.WEXITED | os.WNOWAIT)
    assert Parent().has_gone  # ended, but still there for whoever waits for it
    launch.wait()
    assert Parent().has_gone
    with RunningNode(namespace, {"exit_with_parent": True}, environment=environment) as node:
        assert node.wait(START_DEADLINE) == 0
        assert "the process that started this one has gone" in node.log()
    for running in (str(os.getpid()), "not a number"):
        monkeypatch.setenv(STARTED_BY, running)
        assert not Parent().has_gone


def test_a_command_without_any_arguments_starts(client):
    process = subprocess.Popen([sys.executable, "-m", NODE])
    client.call(ListParameters, "/spiral_gripper/list_parameters")
    process.send_signal(signal.SIGINT)
    assert process.wait(DEADLINE) == 0


def test_the_node_uses_no_shared_memory_unless_it_is_told_to(client, namespace):
    # For LOCALHOST, as the tests use it, rmw_fastrtps chooses transports of its own.
    environment = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    with RunningNode(namespace, environment=environment) as node:
        client.wait_until_active()
        assert "/dev/shm/fastrtps" not in Path(f"/proc/{node.pid}/maps").read_text()
    for own in ({"FASTDDS_BUILTIN_TRANSPORTS": "DEFAULT"}, {"FASTRTPS_DEFAULT_PROFILES_FILE": "x"}):
        chosen = dict(own)
        choose_transport(chosen)
        assert chosen == own


def test_a_first_start_says_that_it_compiles_and_can_be_stopped(client, namespace, tmp_path):
    with RunningNode(namespace, environment={"NUMBA_CACHE_DIR": str(tmp_path)}) as node:
        client.wait_until(lambda: "numerical kernels" in node.log(), "the line about it")
        assert "not active" in client.release().message
        assert node.stop() == 0
        assert "kernels are compiled" not in node.log()
        assert "Traceback" not in node.log()


def test_kernels_that_cannot_be_kept_are_not_compiled_within_the_node(namespace):
    with RunningNode(namespace, environment={"NUMBA_CACHE_DIR": "/proc/no/folder"}) as node:
        assert node.wait(START_DEADLINE) == 1
        assert "set NUMBA_CACHE_DIR to a folder that can be written" in node.log()
        assert "kernels are compiled" not in node.log()


def test_a_node_that_was_killed_takes_the_pressure_over_and_drops_nothing(client, namespace):
    """The regulator remembers the last command, and measures it."""
    client.create_timer(0.02, lambda: client.send_measured([0.0, *client.pressures][-1]))
    given = {**FAST_RAMP, **PATIENT, "activation": "take_over"}
    with RunningNode(namespace, given) as node:
        client.wait_until_active()
        held = client.wrap(0.02).pressure_command
        node.stop(signal.SIGKILL)
    client.pressures[:] = [held]
    with RunningNode(namespace, given):
        client.wait_for_state(State.TAKEN_OVER)
        client.hear_more(20)
        assert min(client.pressures) > 0.99 * held


def test_a_node_that_the_doctor_cannot_start_shows_its_log():
    code = (
        "from spiral_gripper_ros.tools import one_answer; one_answer.START_TIMEOUT = 20.0; "
        "one_answer.plan_by_new_node('none', 0.01)"
    )
    done = subprocess.run([*PYTHON, code], capture_output=True, text=True, check=False)
    assert "no gripper has this name" in done.stderr


@pytest.mark.slow
def test_what_is_counted_as_missing_is_compiled_and_kept(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    for code in (
        "from spiral_gripper_ros.planning.planner import compile_all; compile_all()",
        "from spiral_gripper.kernels import kernels_are_compiled as c; exit(not c())",
    ):
        subprocess.check_call([*PYTHON, code], env=environment)
