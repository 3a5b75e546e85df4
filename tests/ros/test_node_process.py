# SPDX-License-Identifier: Apache-2.0
"""The node's process among others: parents, second commanders, late regulators, a cold cache."""

import itertools
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from rcl_interfaces.srv import ListParameters
from rclpy.node import Node
from ros.harness import DEADLINE, FAST_RAMP, PATIENT, START_DEADLINE, RunningNode, tick
from std_msgs.msg import Float64

from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.process.node_process import NODE, SIMULATOR
from spiral_gripper_ros.process.program import choose_transport
from spiral_gripper_ros.process.stop_signals import STARTED_BY, Parent

# Starts what its arguments say, and waits: what `ros2 run` does.
STARTER = "import subprocess, sys; subprocess.Popen(sys.argv[1:]).wait()"
REGULATOR = "spiral_gripper_ros.regulators.main"
TAKE_OVER = {**FAST_RAMP, **PATIENT, "activation": "take_over"}


@pytest.mark.parametrize("ends", [True, False])
def test_a_node_ends_with_the_process_that_started_it(client, namespace, ends):
    """Without the parameter it survives its parent."""
    given = ["-r", f"__ns:={namespace}", "-p", f"exit_with_parent:={ends}"]
    node = [sys.executable, "-m", NODE, "--ros-args", *given]
    with subprocess.Popen([sys.executable, "-c", STARTER, *node]) as parent:
        client.wait_until_active()
        children = Path(f"/proc/{parent.pid}/task/{parent.pid}/children").read_text().split()
        client.wrap(0.02)
        parent.kill()
    if not ends:
        client.hear_more(50)
        subprocess.run(["kill", "-INT", *children], check=True)
    client.wait_for_vent()
    client.wait_until(lambda: client.count_publishers("pressure_command") == 0, "its end")


def test_a_node_ends_if_what_launched_it_has_ended_before_it_could_look(namespace, monkeypatch):
    launch = subprocess.Popen([sys.executable, "-c", ""])
    launch.wait()
    environment = {STARTED_BY: str(launch.pid)}
    with RunningNode(namespace, {"exit_with_parent": "true"}, environment=environment) as node:
        assert node.wait(START_DEADLINE), node.log()
        assert "the process that started this one has gone" in node.log()
    for running in (str(os.getpid()), "not a number"):
        monkeypatch.setenv(STARTED_BY, running)
        assert not Parent().has_gone


@pytest.mark.parametrize(
    ("module", "name", "code"),
    [
        (NODE, "spiral_gripper", 0),
        (SIMULATOR, "simulated_regulator", 0),
        (REGULATOR, "regulator", 1),  # no device hears its last vent
    ],
)
def test_a_command_without_any_arguments_starts(client, module, name, code):
    process = subprocess.Popen([sys.executable, "-m", module])
    client.call(ListParameters, f"/{name}/list_parameters", deadline=DEADLINE)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=DEADLINE) == code


def test_a_second_commander_is_noticed_whenever_it_comes(node, client, capfd):
    sent = []
    node.runtime.outputs.publish_diagnostics = sent.append
    tick(node)
    assert "publish pressure_command" not in capfd.readouterr().err
    other = Node("other", namespace=client.get_namespace())
    other.create_publisher(Float64, "pressure_command", 1)
    client.wait_until(lambda: node.count_publishers("pressure_command") == 2, "the other")
    for _ in range(3):
        tick(node)
    other.destroy_node()
    assert capfd.readouterr().err.count("2 nodes publish pressure_command") == 1
    (told,) = sent[-1].status
    assert "2 nodes publish pressure_command" in told.message
    assert told.level == b"\x01"


def test_a_node_that_has_commanded_nothing_vents_nothing(client, namespace, tmp_path):
    """Another node may command the same regulator meanwhile."""
    broken = tmp_path / "broken.yaml"
    broken.write_text("name: [")
    parameters = {"autostart": "false", "gripper": str(broken)}
    with RunningNode(namespace, parameters) as node:
        assert not client.transition("configure")
        client.change("gripper", "paper_design_70")
        client.wait_until(lambda: client.count_publishers("pressure_command") == 1, "its topic")
        for transition in ("configure", "cleanup", "configure", "inactive_shutdown"):
            assert client.transition(transition)
        assert node.stop() == 0, node.log()
    with RunningNode(namespace, {"gripper": str(broken)}) as node:
        client.wait_until(lambda: not node.running, "its end")
        assert node.exit_code == 1
    client.spin(0.1)
    assert client.pressures == []


def test_the_node_uses_no_shared_memory_unless_it_is_told_to(client, namespace):
    # For LOCALHOST, as the tests use it, rmw_fastrtps chooses transports of its own.
    environment = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    with RunningNode(namespace, environment=environment) as node:
        client.wait_until_active()
        assert "/dev/shm/fastrtps" not in Path(f"/proc/{node.process_id}/maps").read_text()
    for own in ({"FASTDDS_BUILTIN_TRANSPORTS": "DEFAULT"}, {"FASTRTPS_DEFAULT_PROFILES_FILE": "x"}):
        chosen = dict(own)
        choose_transport(chosen)
        assert chosen == own


@pytest.mark.parametrize("autostart", ["true", "false"])
def test_a_first_start_says_that_it_compiles_and_can_be_stopped(
    client, namespace, tmp_path, autostart
):
    environment = {"NUMBA_CACHE_DIR": str(tmp_path)}
    with RunningNode(namespace, {"autostart": autostart}, environment=environment) as node:
        client.wait_until(lambda: "numerical kernels" in node.log(), "the line about it")
        assert "not active" in client.release().message
        assert node.stop() == 0, node.log()
        assert "kernels are compiled" not in node.log()
        assert "Traceback" not in node.log()


def test_kernels_that_cannot_be_kept_are_not_compiled_within_the_node(namespace):
    environment = {"NUMBA_CACHE_DIR": "/proc/no/such/folder"}
    with RunningNode(namespace, environment=environment) as node:
        assert node.wait(START_DEADLINE)
        assert node.exit_code == 1
        assert "set NUMBA_CACHE_DIR to a folder that can be written" in node.log()
        assert "kernels are compiled" not in node.log()


@pytest.fixture
def measured(client):
    """Measured pressures without end: what is sent next is the next of ``readings``."""
    regulator = client.create_publisher(Float64, "measured_pressure", 1)
    client.readings = itertools.repeat(0.0)
    timer = client.create_timer(
        0.02, lambda: regulator.publish(Float64(data=next(client.readings)))
    )
    yield client
    client.destroy_timer(timer)


def test_a_node_that_was_killed_takes_the_pressure_over_and_drops_nothing(measured, namespace):
    """The regulator remembers the last command, and measures it."""
    measured.readings = iter(lambda: measured.pressures[-1] if measured.pressures else 0.0, None)
    with RunningNode(namespace, TAKE_OVER) as node:
        measured.wait_until_active()
        held = measured.wrap(0.02).pressure_command
        os.kill(node.process_id, signal.SIGKILL)
        assert node.wait(DEADLINE)
    measured.pressures[:] = [held]
    with RunningNode(namespace, TAKE_OVER):
        measured.wait_for_state(State.TAKEN_OVER)
        measured.hear_more(20)
        assert min(measured.pressures) > 0.99 * held


@pytest.mark.parametrize("first", [(2.5e5,), (101325.0,), (0.0, 6.275e4)])
def test_first_readings_that_cannot_be_held_are_waited_out(measured, namespace, first):
    measured.readings = itertools.cycle(first)
    with RunningNode(namespace, TAKE_OVER):
        measured.wait_for_state(State.WAITING)
        measured.spin(1.0)
        assert not measured.pressures
        measured.readings = itertools.repeat(3.0e4)
        measured.wait_for_state(State.TAKEN_OVER)
        measured.hear_more(20)
        assert measured.pressures == pytest.approx([3.0e4] * len(measured.pressures), rel=0.02)


def test_a_node_that_the_doctor_cannot_start_shows_its_log():
    code = (
        "from spiral_gripper_ros.tools import one_answer; one_answer.START_TIMEOUT = 20.0; "
        "one_answer.plan_by_new_node('none', 0.01)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "no gripper has this name" in done.stderr


@pytest.mark.slow
def test_what_is_counted_as_missing_is_compiled_and_kept(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    for code in (
        "from spiral_gripper_ros.planning.planner import compile_all; compile_all()",
        "from spiral_gripper.kernels import kernels_are_compiled as c; exit(not c())",
    ):
        subprocess.check_call([sys.executable, "-c", code], env=environment)
