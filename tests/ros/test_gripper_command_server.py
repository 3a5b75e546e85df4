# SPDX-License-Identifier: Apache-2.0
"""Real goals of control_msgs' shape, to a node that has found a control_msgs."""

import importlib
import os
import re
import sys
import types

import pytest
from action_msgs.msg import GoalStatus
from rclpy.parameter import Parameter
from ros.compiled_control_msgs import PACKAGE, compile_control_msgs
from ros.grasp_goals import Goals
from ros.harness import Client, RunningNode, all_finite

from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.node.gripper_node import GripperNode

pytestmark = pytest.mark.slow

OPEN = 0.1
DIAMETER = 0.04
SUCCEEDED, ABORTED = GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_ABORTED
CANCELED = GoalStatus.STATUS_CANCELED


@pytest.fixture(scope="module")
def control_msgs(tmp_path_factory):
    """A compiled control_msgs, importable here and by nodes while this module is tested."""
    path = str(compile_control_msgs(tmp_path_factory.mktemp(PACKAGE)))
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(path)
        patch.setenv("PYTHONPATH", path, prepend=os.pathsep)
        yield importlib.import_module(f"{PACKAGE}.action")
        for name in [name for name in sys.modules if name.split(".")[0] == PACKAGE]:
            patch.delitem(sys.modules, name)


@pytest.fixture(scope="module")
def facade(control_msgs):
    """A node that has found control_msgs, its client, and goals to both of its actions."""
    client = Client("/facade")
    with RunningNode("/facade") as node:
        client.wait_until_active()
        client.node = node
        client.gripper = Goals(client, control_msgs.GripperCommand, "gripper_cmd")
        client.joint = Goals(client, control_msgs.ParallelGripperCommand, "parallel_gripper_cmd")
        client.grasps = Goals(client)
        yield client
        assert node.stop() == 0, node.log()
        log = node.log()
        assert "Traceback" not in log
        assert "gripper_cmd is offered as control_msgs/action/GripperCommand" in log
        assert "parallel_gripper_cmd is offered as" in log
        for goals in (client.gripper, client.joint, client.grasps):
            goals.close()
    client.close()


@pytest.fixture
def active(facade):
    facade.restore()
    facade.change("pressure.settle_time", 0.1)
    facade.log_start = len(facade.node.log())
    return facade


def command(client, position, max_effort=0.0):
    goal = client.gripper.kind.Goal()
    goal.command.position, goal.command.max_effort = position, max_effort
    return client.gripper.send(goal)


def joint_command(client, **fields):
    goal = client.joint.kind.Goal()
    for name, value in fields.items():
        setattr(goal.command, name, value)
    return client.joint.send(goal)


def refused(client, goal, words):
    """Assert that a goal has failed without a claim, and that the log says why."""
    status, result = goal.end()
    assert (status, result.reached_goal, result.stalled) == (ABORTED, False, False)
    assert all_finite(result)
    told = re.compile(f"gripper_cmd: .*{re.escape(words)}")
    client.wait_until(
        lambda: told.search(client.node.log()[client.log_start :]), f"the log to say: {words}"
    )
    return result


def measure(client, pressure):
    """Answer each command with at least this measured pressure [Pa] from now on."""
    client.regulator = lambda commanded: max(commanded, pressure)
    client.wait_until(lambda: client.statuses and client.status.measured_pressure, "measurement")


def test_a_position_wraps_the_object_of_that_diameter_and_opening_releases_it(active):
    active.change("pressure.rate_up", 2.0e5)
    for _ in range(2):  # the second grips again after the release
        goal = command(active, DIAMETER)
        status, result = goal.end()
        assert (status, result.reached_goal, result.stalled) == (SUCCEEDED, True, False)
        assert result.position == pytest.approx(DIAMETER, rel=1e-6)
        assert result.effort > 0.0
        assert (goal.feedback[0].position, goal.feedback[0].effort) == (OPEN, 0.0)
        status, result = command(active, OPEN).end()
        assert (status, result.reached_goal) == (SUCCEEDED, True)
        assert (result.position, result.effort) == (OPEN, 0.0)
        assert active.wait_for_state(State.RELEASED).pressure_command == 0.0
    active.change("gripper_cmd.open_position", 0.05)
    status, result = command(active, 0.06).end()
    assert (status, result.position) == (SUCCEEDED, 0.05)


def test_a_joint_is_wrapped_and_opened_too(active):
    goal = joint_command(active, name=["grip"], position=[DIAMETER], velocity=[0.1])
    status, result = goal.end()
    assert (status, result.reached_goal, result.stalled) == (SUCCEEDED, True, False)
    state = result.state
    assert state.name == ["grip"]
    assert list(state.position) == [pytest.approx(DIAMETER, rel=1e-6)]
    assert state.effort[0] > 0.0
    assert state.header.stamp.sec > 0
    assert goal.feedback[0].state.position[0] == OPEN
    assert "velocity is not used" in active.node.log()
    state = joint_command(active, position=[OPEN]).end()[1].state
    assert (list(state.position), list(state.name)) == ([OPEN], ["spiral_gripper_opening"])
    refused(active, joint_command(active, name=["a", "b"], position=[0.02, 0.02]), "one position")


@pytest.mark.parametrize("is_held", [False, True])
def test_what_cannot_be_gripped_is_refused_and_moves_nothing(active, is_held):
    """Nor does it deny what is held."""
    if is_held:
        command(active, DIAMETER).end()
    active.hear_more()
    state, held = active.status.state, active.pressures[-1]
    active.pressures.clear()
    for position, max_effort, words in (
        (0.09, 0.0, "above the grippable range"),
        (DIAMETER, 0.001, "more than max_effort"),
    ):
        result = refused(active, command(active, position, max_effort), words)
        assert result.position == pytest.approx(DIAMETER if is_held else OPEN, rel=1e-6)
        assert (result.effort > 0.0) == is_held
    active.hear_more()
    assert active.status.state == state
    assert set(active.pressures) == {held}


def test_a_command_that_is_canceled_holds_what_it_has(active):
    assert active.wrap(0.03).pressure_command > 0.0
    active.change("pressure.rate_up", 500.0)
    goal = command(active, 0.03)
    active.wait_for_state(State.GRASPING)
    assert goal.cancel()
    assert goal.end()[0] == CANCELED
    held = active.wait_for_state(State.GRASPING, Reason.GRASP_CANCELED).pressure_command
    assert held > 1.0e4
    active.hear_more(10)
    assert active.status.pressure_command == held


def test_opening_succeeds_in_a_fault_which_has_vented_already(active):
    active.change("pressure.fault_policy", "vent")
    measure(active, 0.0)
    active.regulator = lambda pressure: 0.0
    active.send_radius(0.02)
    active.wait_for_state(State.FAULT)
    status, result = command(active, OPEN).end()
    assert (status, result.reached_goal) == (SUCCEEDED, True)


@pytest.mark.parametrize(
    ("act", "end"),
    [
        (lambda client, goal: measure(client, 0.0), SUCCEEDED),
        (lambda client, goal: client.grasps.grasp(0.02), "told to grip again"),
    ],
)
def test_opening_waits_until_the_measured_pressure_is_gone(active, act, end):
    # So long after a wrap it is no fault, which would forbid a grasp, that the pressure stays.
    active.change("pressure.settle_time", 60.0)
    measure(active, 0.0)
    active.wrap(0.02)
    measure(active, 4.0e4)
    goal = command(active, OPEN)
    active.wait_until(lambda: len(goal.feedback) >= 3, "some feedback")
    assert not goal.is_done
    assert goal.feedback[-1].position < OPEN
    act(active, goal)
    if isinstance(end, str):
        assert refused(active, goal, end).position < OPEN
    else:
        assert goal.end()[0] == end
        assert active.wait_for_state(State.RELEASED).pressure_command == 0.0


def test_opening_fails_if_the_measured_pressure_stays(active):
    active.change("grasp.timeout", 0.3)
    measure(active, 4.0e4)
    assert refused(active, command(active, OPEN), "after the release").position < OPEN


@pytest.mark.usefixtures("control_msgs")
def test_one_name_has_the_type_that_the_parameter_says(namespace, capfd):
    chosen = [Parameter("gripper_cmd.type", value="ParallelGripperCommand")]
    GripperNode(namespace=namespace, parameter_overrides=chosen).destroy_node()
    log = capfd.readouterr().err
    assert ": gripper_cmd is offered as control_msgs/action/ParallelGripperCommand" in log
    assert "parallel_gripper_cmd" not in log


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (None, ["control_msgs is not installed"]),
        # One without type support, as if it were built for another Python.
        (
            types.SimpleNamespace(GripperCommand=int),
            ["control_msgs cannot be used, gripper_cmd is not offered", "has no Parallel"],
        ),
    ],
)
def test_without_a_usable_control_msgs_the_node_does_without_and_says_so(
    namespace, monkeypatch, capfd, found, said
):
    monkeypatch.setitem(sys.modules, PACKAGE, types.ModuleType(PACKAGE))
    monkeypatch.setitem(sys.modules, f"{PACKAGE}.action", found)
    GripperNode(namespace=namespace).destroy_node()
    log = capfd.readouterr().err
    assert all(words in log for words in said)
