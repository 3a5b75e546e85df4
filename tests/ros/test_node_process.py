# SPDX-License-Identifier: Apache-2.0
"""The node's process among others: parents, second commanders, late regulators, a cold cache."""

import itertools
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from rcl_interfaces.srv import ListParameters
from rclpy.node import Node
from ros.harness import DEADLINE, FAST_RAMP, PATIENT, START_DEADLINE, RunningNode
from std_msgs.msg import Float64

from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.process.node_process import NODE, SIMULATOR
from spiral_gripper_ros.process.program import choose_transport
from spiral_gripper_ros.process.stop_signals import STARTED_BY, Parent

# Starts what its arguments say, and waits: what `ros2 run` does.
STARTER = "import subprocess, sys; subprocess.Popen(sys.argv[1:]).wait()"
REGULATOR = "spiral_gripper_ros.regulators.main"


def test_a_node_ends_with_the_process_that_started_it(client, namespace):
    parameters = {**FAST_RAMP, **PATIENT, "exit_with_parent": "true"}
    given = [part for name in parameters for part in ("-p", f"{name}:={parameters[name]}")]
    node = [sys.executable, "-m", NODE, "--ros-args", "-r", f"__ns:={namespace}", *given]
    parent = subprocess.Popen([sys.executable, "-c", STARTER, *node])
    client.wait_until_active()
    assert client.wrap(0.02).pressure_command > 0.0
    parent.kill()
    parent.wait()
    client.wait_until(lambda: client.pressures[-1] == 0.0, "the vent")
    client.wait_until(lambda: client.count_publishers("pressure_command") == 0, "its end")


def test_a_node_ends_if_what_launched_it_has_ended_before_it_could_look(namespace):
    launch = subprocess.Popen([sys.executable, "-c", ""])
    launch.wait()
    environment = {STARTED_BY: str(launch.pid)}
    with RunningNode(namespace, {"exit_with_parent": "true"}, environment=environment) as node:
        assert node.wait(START_DEADLINE), node.log()
        assert "the process that started this one has gone" in node.log()


def test_a_launch_that_still_runs_keeps_its_node(monkeypatch):
    monkeypatch.setenv(STARTED_BY, str(os.getpid()))
    assert not Parent().has_gone
    monkeypatch.setenv(STARTED_BY, "not a number")
    assert not Parent().has_gone


def test_without_the_parameter_a_node_survives_its_parent(client, namespace):
    node = [sys.executable, "-m", NODE, "--ros-args", "-r", f"__ns:={namespace}"]
    parent = subprocess.Popen([sys.executable, "-c", STARTER, *node], stdout=subprocess.PIPE)
    client.wait_until_active()
    children = Path(f"/proc/{parent.pid}/task/{parent.pid}/children").read_text().split()
    parent.kill()
    client.hear_more(50)
    subprocess.run(["kill", "-INT", *children], check=True)
    client.wait_until(lambda: client.count_publishers("pressure_command") == 0, "its end")
    parent.communicate()


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


def test_a_second_commander_is_noticed_whenever_it_comes(node, namespace, capfd):
    node._diagnosis.tell()
    assert "publish pressure_command" not in capfd.readouterr().err
    other = Node("other", namespace=namespace)
    other.create_publisher(Float64, "pressure_command", 1)
    deadline = time.monotonic() + DEADLINE
    while node.count_publishers("pressure_command") < 2:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    sent = []
    node.runtime.outputs.publish_diagnostics = sent.append
    for _ in range(3):
        node._diagnosis.tell()
    other.destroy_node()
    assert capfd.readouterr().err.count("2 nodes publish pressure_command") == 1
    assert "2 nodes publish pressure_command" in sent[-1].status[0].message
    assert sent[-1].status[0].level == b"\x01"


def test_a_regulator_that_joins_during_a_wrap_hears_the_present_command(active):
    command = active.wrap(0.02).pressure_command
    heard = []
    late = active.create_subscription(Float64, "pressure_command", heard.append, 1)
    active.wait_until(lambda: heard, "a command")
    active.destroy_subscription(late)
    assert heard[0].data == command


def test_a_node_that_has_commanded_nothing_vents_nothing(client, namespace, tmp_path):
    """Another node may command the same regulator meanwhile."""
    broken = tmp_path / "broken.yaml"
    broken.write_text("name: [")
    parameters = {"autostart": "false", "gripper": str(broken)}
    with RunningNode(namespace, parameters) as node:
        assert not client.transition("configure")
        assert client.set_parameter("gripper", "paper_design_70").successful
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


def test_the_environment_may_choose_another_transport():
    chosen = {}
    choose_transport(chosen)
    assert chosen == {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
    own = {"FASTDDS_BUILTIN_TRANSPORTS": "DEFAULT"}
    choose_transport(own)
    assert own == {"FASTDDS_BUILTIN_TRANSPORTS": "DEFAULT"}
    profiles = {"FASTRTPS_DEFAULT_PROFILES_FILE": "mine.xml"}
    choose_transport(profiles)
    assert profiles == {"FASTRTPS_DEFAULT_PROFILES_FILE": "mine.xml"}


@pytest.mark.parametrize("autostart", ["true", "false"])
def test_a_first_start_says_that_it_compiles_and_can_be_stopped(
    client, namespace, tmp_path, autostart
):
    environment = {"NUMBA_CACHE_DIR": str(tmp_path)}
    with RunningNode(namespace, {"autostart": autostart}, environment=environment) as node:
        client.wait_until(lambda: "numerical kernels" in node.log(), "the line about it")
        assert "not active" in client.release().message
        assert node.stop(signal.SIGINT) == 0, node.log()
        assert "kernels are compiled" not in node.log()
        assert "Traceback" not in node.log()


def test_kernels_that_cannot_be_kept_are_not_compiled_within_the_node(namespace):
    environment = {"NUMBA_CACHE_DIR": "/proc/no/such/folder"}
    with RunningNode(namespace, environment=environment) as node:
        assert node.wait(START_DEADLINE)
        assert node.exit_code == 1
        assert "set NUMBA_CACHE_DIR to a folder that can be written" in node.log()
        assert "kernels are compiled" not in node.log()


def test_a_node_that_was_killed_takes_the_pressure_over_and_drops_nothing(client, namespace):
    """The regulator remembers the last command, and measures it."""
    regulator = client.create_publisher(Float64, "measured_pressure", 1)
    measured = Float64()

    def measure():
        if client.pressures:
            measured.data = client.pressures[-1]
        regulator.publish(measured)

    timer = client.create_timer(0.02, measure)
    parameters = {**FAST_RAMP, **PATIENT, "activation": "take_over"}
    with RunningNode(namespace, parameters) as node:
        client.wait_until_active()
        held = client.wrap(0.02).pressure_command
        os.kill(node.process_id, signal.SIGKILL)
        assert node.wait(DEADLINE)
    client.pressures[:] = [held]
    with RunningNode(namespace, parameters):
        client.wait_for_state(State.TAKEN_OVER)
        client.hear_more(20)
        assert min(client.pressures) > 0.99 * held
    client.destroy_timer(timer)


@pytest.mark.parametrize("first", [(2.5e5,), (101325.0,), (0.0, 6.275e4)])
def test_first_readings_that_cannot_be_held_are_waited_out(client, namespace, first):
    regulator = client.create_publisher(Float64, "measured_pressure", 1)
    readings = itertools.cycle(first)

    def measure():
        regulator.publish(Float64(data=next(readings)))

    timer = client.create_timer(0.02, measure)
    with RunningNode(namespace, {**FAST_RAMP, **PATIENT, "activation": "take_over"}):
        client.wait_for_state(State.WAITING)
        client.spin(1.0)
        assert not client.pressures
        readings = itertools.repeat(3.0e4)
        client.wait_for_state(State.TAKEN_OVER)
        client.hear_more(20)
        assert client.pressures == pytest.approx([3.0e4] * len(client.pressures), rel=0.02)
    client.destroy_timer(timer)


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
    compile_all = "from spiral_gripper_ros.planning.planner import compile_all; compile_all()"
    subprocess.check_call([sys.executable, "-c", compile_all], env=environment)
    count = "from spiral_gripper.kernels import kernels_are_compiled as c; print(c())"
    found = subprocess.check_output([sys.executable, "-c", count], env=environment)
    assert found.strip() == b"True"
