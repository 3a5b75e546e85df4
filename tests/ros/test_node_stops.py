# SPDX-License-Identifier: Apache-2.0
"""Start and stop of node processes: signals, bad starts, lifecycle managers."""

import signal
import subprocess
import sys

import pytest
from lifecycle_msgs.msg import State as LifecycleState
from ros.harness import DEADLINE, FAST_RAMP, RunningNode

from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.process.node_process import NODE, SIMULATOR


@pytest.mark.usefixtures("hangups")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT])
def test_a_stop_signal_makes_a_vent_the_last_command(client, namespace, number):
    with RunningNode(namespace, FAST_RAMP) as node:
        client.wait_until_active()
        assert client.wrap(0.02).pressure_command > 0.0
        assert node.stop(number) == 0
        client.wait_until(lambda: client.pressures[-1] == 0.0, "the vent")
        client.wait_for_state(State.INACTIVE)
        client.spin(0.2)
        assert client.pressures[-1] == 0.0
        assert "Traceback" not in node.log()


def test_without_autostart_it_waits_for_its_manager(client, namespace):
    with RunningNode(namespace, {"autostart": "false"}) as node:
        assert client.lifecycle_state() == LifecycleState.PRIMARY_STATE_UNCONFIGURED
        assert client.transition("configure")
        assert client.transition("activate")
        client.wait_until_active()
        assert client.transition("active_shutdown")
        assert client.lifecycle_state() == LifecycleState.PRIMARY_STATE_FINALIZED
        client.wait_until(lambda: client.pressures[-1] == 0.0, "the vent")
        assert node.stop() == 0, node.log()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"radius.timeout": "-1.0"}, "radius.timeout"),
        ({"gravity.vector": "[1.0, 2.0]"}, "3 finite numbers"),
        ({"gripper": "no_such_gripper"}, "no gripper has this name"),
        ({"griper": "prototype_p1"}, "did you mean gripper?"),
    ],
)
def test_a_start_that_cannot_be_ends_with_the_reason(client, namespace, parameters, message):
    with RunningNode(namespace, parameters) as node:
        client.wait_until(lambda: not node.running, "the end of the process")
        assert node.exit_code == 1
        assert message in node.log()
        assert "Traceback" not in node.log()
        assert not any(client.pressures)


@pytest.mark.parametrize("program", [NODE, SIMULATOR])
@pytest.mark.parametrize("arguments", [["-p", "pressure.cap:=20000.0"], ["--gripper", "p1"]])
def test_an_argument_that_nobody_reads_ends_the_start(program, arguments):
    ended = run(program, *arguments)
    assert ended.returncode == 1
    assert "unknown arguments" in ended.stderr
    assert arguments[1] in ended.stderr
    assert "Traceback" not in ended.stderr


@pytest.mark.parametrize("program", [NODE, SIMULATOR])
@pytest.mark.parametrize("arguments", [["-r", "__ns:=left"], ["-p", "gravity:=[0,0"]])
def test_ros_arguments_that_cannot_be_end_the_start_in_one_line(program, arguments):
    ended = run(program, "--ros-args", *arguments)
    assert ended.returncode == 1
    assert "ROS does not start" in ended.stderr
    assert "Traceback" not in ended.stderr


def test_a_parameter_file_for_another_node_ends_the_start(tmp_path):
    path = tmp_path / "other.yaml"
    path.write_text("/other:\n  ros__parameters:\n    pressure.cap: 20000.0\n")
    ended = run(NODE, "--ros-args", "--params-file", str(path))
    assert ended.returncode == 1
    assert "has no parameters for /spiral_gripper, only for /other" in ended.stderr
    assert "Traceback" not in ended.stderr


def test_a_parameter_file_that_is_missing_ends_the_start(tmp_path):
    ended = run(NODE, "--ros-args", "--params-file", str(tmp_path / "none.yaml"))
    assert ended.returncode == 1
    assert "ROS does not start" in ended.stderr


def test_a_foreign_name_in_a_file_for_every_node_is_a_warning(client, namespace, tmp_path):
    path = tmp_path / "shared.yaml"
    path.write_text("/**:\n  ros__parameters:\n    camera: x\n    radius.timeout: 7.0\n")
    with RunningNode(namespace, arguments=["--params-file", str(path)]) as node:
        client.wait_until_active()
        assert client.get_parameter_of_node("radius.timeout") == 7.0
        assert "camera is not a parameter of this node" in node.log()


def run(program, *arguments):
    command = [sys.executable, "-m", program, *arguments]
    return subprocess.run(command, check=False, capture_output=True, text=True, timeout=DEADLINE)


def test_an_inactive_node_publishes_nothing_but_its_vents(client, namespace):
    with RunningNode(namespace, {"autostart": "false"}) as node:
        assert client.transition("configure")
        client.spin(0.2)
        client.pressures.clear()
        assert not client.rearm().success
        assert client.set_parameter("gripper", "prototype_p1").successful
        client.spin(0.3)
        assert not client.pressures
        assert client.release().success
        client.wait_until(lambda: client.pressures == [0.0], "the vent of a release")
        assert node.stop() == 0, node.log()
