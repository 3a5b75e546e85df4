# SPDX-License-Identifier: Apache-2.0
"""Start and stop of node processes: signals, bad starts, lifecycle managers."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from ros.control_bench import rows
from ros.grasp_goals import Goals, refused, started
from ros.harness import DEADLINE, START_DEADLINE, RunningNode

from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.process.node_process import NODE, SIMULATOR
from spiral_gripper_ros.process.stop_signals import STOP_SIGNALS, StopSignals


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT])
def test_each_stop_signal_interrupts_a_start_and_is_noted_from_then_on(number):
    before = {one: signal.getsignal(one) for one in STOP_SIGNALS}
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # as without nohup
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
        for item in before.items():
            signal.signal(*item)


def test_a_stop_signal_makes_a_vent_the_last_command(client, namespace, tmp_path):
    path = tmp_path / "shared.yaml"
    path.write_text("/**:\n  ros__parameters:\n    camera: x\n    pressure.rate_up: 500.0\n")
    with RunningNode(namespace, arguments=["--params-file", str(path)]) as node:
        client.wait_until_active()
        assert "camera is not a parameter of this node" in node.log()
        goals = Goals(client)
        goal = started(goals.grasp(0.02))
        assert node.stop(signal.SIGTERM) == 0
        refused(goal, Reason.NOT_ACTIVE)
        client.wait_for_vent()
        client.wait_for_state(State.INACTIVE)
        client.spin(0.2)
        assert client.pressures[-1] == 0.0
        assert "Traceback" not in node.log()
        goals.close()


def test_a_node_that_has_commanded_nothing_vents_nothing(client, namespace, tmp_path):
    """Another node may command the same regulator meanwhile; without autostart it only waits."""
    broken = tmp_path / "broken.yaml"
    broken.write_text("name: [")
    with RunningNode(namespace, {"gripper": str(broken)}) as node:
        assert node.wait(START_DEADLINE) == 1
    with RunningNode(namespace, {"autostart": False, "gripper": str(broken)}) as node:
        assert not client.transition("configure")
        client.change("gripper", "paper_design_70")
        client.wait_until(lambda: client.count_publishers("pressure_command") == 1, "its topic")
        for transition in ("configure", "cleanup", "configure", "inactive_shutdown"):
            assert client.transition(transition)
        assert node.stop() == 0
    with RunningNode(namespace, {"autostart": False}) as node:
        assert client.transition("configure")
        assert not client.rearm().success
        client.change("gripper", "prototype_p1")
        client.wait_until(lambda: client.plan_wrap(0.02).success, "the other gripper")
        client.spin(0.3)
        assert client.pressures == []
        assert client.release().success
        client.wait_until(lambda: client.pressures == [0.0], "the vent of a release")
        assert client.transition("activate")
        client.wait_until_active()
        assert client.transition("active_shutdown")
        client.wait_for_vent()
        assert node.stop() == 0


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
    assert (ended.returncode, "Traceback" in ended.stderr) == (1, False)
    assert said in ended.stderr
