# SPDX-License-Identifier: Apache-2.0
"""Start and stop of node processes: signals, bad starts, lifecycle managers."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from lifecycle_msgs.msg import State as LifecycleState
from ros.control_bench import rows
from ros.grasp_goals import Goals, refused, started
from ros.harness import DEADLINE, RunningNode

from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.process.node_process import NODE, SIMULATOR
from spiral_gripper_ros.process.stop_signals import STOP_SIGNALS, StopSignals


@pytest.mark.usefixtures("hangups")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT])
def test_each_stop_signal_interrupts_a_start_and_is_noted_from_then_on(number):
    before = {one: signal.getsignal(one) for one in STOP_SIGNALS}
    signals = StopSignals()
    try:
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
        signals.defer()
        signal.raise_signal(number)
        assert signals.requested
        signals.ignore()
        signal.raise_signal(number)
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)


def test_a_stop_signal_makes_a_vent_the_last_command(client, namespace):
    with RunningNode(namespace, {"pressure.rate_up": 500.0}) as node:
        client.wait_until_active()
        goals = Goals(client)
        goal = started(goals.grasp(0.02))
        assert node.stop(signal.SIGTERM) == 0, node.log()
        refused(goal, Reason.NOT_ACTIVE)
        client.wait_for_vent()
        client.wait_for_state(State.INACTIVE)
        client.spin(0.2)
        assert client.pressures[-1] == 0.0
        assert "Traceback" not in node.log()
        goals.close()


def test_an_inactive_node_publishes_nothing_but_its_vents(client, namespace):
    """Without autostart it waits for its manager."""
    with RunningNode(namespace, {"autostart": "false"}) as node:
        assert client.lifecycle_state() == LifecycleState.PRIMARY_STATE_UNCONFIGURED
        assert client.transition("configure")
        assert not client.rearm().success
        client.change("gripper", "prototype_p1")
        client.wait_until(lambda: client.plan_wrap(0.02).success, "the other gripper")
        client.spin(0.3)
        assert not client.pressures
        assert client.release().success
        client.wait_until(lambda: client.pressures == [0.0], "the vent of a release")
        assert client.transition("activate")
        client.wait_until_active()
        assert client.transition("active_shutdown")
        assert client.lifecycle_state() == LifecycleState.PRIMARY_STATE_FINALIZED
        client.wait_for_vent()
        assert node.stop() == 0, node.log()


STARTS = f"""
{NODE} --gripper p1: unknown arguments
{NODE} --ros-args -r __ns:=left: ROS does not start
{SIMULATOR} --ros-args --params-file none.yaml: ROS does not start
{NODE} --ros-args --params-file other.yaml: no parameters for /spiral_gripper, only for
{NODE} --ros-args -p griper:=prototype_p1: did you mean gripper?
{NODE} --ros-args -p gripper:=no_such_gripper: no gripper has this name
"""


@pytest.mark.parametrize("row", rows(STARTS))
def test_a_start_that_cannot_be_ends_with_the_reason(tmp_path, monkeypatch, row):
    arguments, said = row.split(": ")
    monkeypatch.chdir(tmp_path)
    Path("other.yaml").write_text("/other:\n  ros__parameters:\n    pressure.cap: 20000.0\n")
    command = [sys.executable, "-m", *arguments.split()]
    ended = subprocess.run(command, check=False, capture_output=True, text=True, timeout=DEADLINE)
    assert ended.returncode == 1
    assert said in ended.stderr
    assert "Traceback" not in ended.stderr


def test_a_foreign_name_in_a_file_for_every_node_is_a_warning(client, namespace, tmp_path):
    path = tmp_path / "shared.yaml"
    path.write_text("/**:\n  ros__parameters:\n    camera: x\n    radius.timeout: 7.0\n")
    with RunningNode(namespace, arguments=["--params-file", str(path)]) as node:
        client.wait_until_active()
        assert client.get_parameter_of_node("radius.timeout") == 7.0
        assert "camera is not a parameter of this node" in node.log()
