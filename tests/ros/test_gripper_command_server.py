# SPDX-License-Identifier: Apache-2.0
"""Real goals of control_msgs' shape, to a node that has found a control_msgs."""

import importlib
import math
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
        assert "Traceback" not in node.log()
        for goals in (client.gripper, client.joint, client.grasps):
            goals.close()
    client.close()


@pytest.fixture
def active(facade):
    facade.restore()
    assert facade.set_parameter("pressure.settle_time", 0.1).successful
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
    assert status == ABORTED
    assert not result.reached_goal
    assert not result.stalled
    assert all_finite(result)
    told = re.compile(f"gripper_cmd: .*{re.escape(words)}")
    client.wait_until(
        lambda: told.search(client.node.log()[client.log_start :]), f"the log to say: {words}"
    )
    return result


def test_both_actions_are_offered_and_the_log_says_so(active):
    log = active.node.log()
    assert "gripper_cmd is offered as control_msgs/action/GripperCommand" in log
    assert "parallel_gripper_cmd is offered as control_msgs/action/ParallelGripperCommand" in log


def test_a_position_wraps_the_object_of_that_diameter(active, curve):
    assert active.set_parameter("pressure.rate_up", 2.0e5).successful
    goal = command(active, DIAMETER)
    status, result = goal.end()
    assert status == SUCCEEDED
    assert result.reached_goal
    assert not result.stalled
    assert result.position == pytest.approx(DIAMETER, rel=1e-6)
    assert result.effort > 0.0
    wanted = pytest.approx(curve.pressure_from_radius(0.02))
    active.wait_until(lambda: active.status.pressure_command == wanted, "its pressure")
    assert goal.feedback[0].position == OPEN
    assert goal.feedback[0].effort == 0.0
    assert not any(feedback.reached_goal or feedback.stalled for feedback in goal.feedback)
    assert all_finite(result, *goal.feedback)


def test_opening_releases_and_the_next_position_grips_again(active):
    assert command(active, DIAMETER).end()[0] == SUCCEEDED
    status, result = command(active, OPEN).end()
    assert status == SUCCEEDED
    assert result.reached_goal
    assert (result.position, result.effort) == (OPEN, 0.0)
    assert active.wait_for_state(State.RELEASED).pressure_command == 0.0
    status, result = command(active, DIAMETER).end()
    assert status == SUCCEEDED
    assert result.position == pytest.approx(DIAMETER, rel=1e-6)


def test_the_parameter_says_what_is_open(active):
    assert active.set_parameter("gripper_cmd.open_position", 0.05).successful
    status, result = command(active, 0.06).end()
    assert (status, result.position) == (SUCCEEDED, 0.05)
    assert active.wait_for_state(State.RELEASED)


@pytest.mark.parametrize(
    ("position", "max_effort", "words"),
    [
        (0.09, 0.0, "above the grippable range"),
        (0.002, 0.0, "below the grippable range"),
        (math.nan, 0.0, "position must be a finite number"),
        (0.0, 0.0, "position must be the object's diameter"),
        (DIAMETER, 0.001, "more than max_effort"),
    ],
)
def test_what_cannot_be_gripped_is_refused_and_moves_nothing(active, position, max_effort, words):
    refused(active, command(active, position, max_effort), words)
    active.hear_more()
    assert active.status.state == State.WAITING
    assert set(active.pressures) == {0.0}


def test_a_command_that_is_canceled_holds_what_it_has(active):
    assert active.wrap(0.03).pressure_command > 0.0
    assert active.set_parameter("pressure.rate_up", 500.0).successful
    goal = command(active, 0.03)
    active.wait_for_state(State.GRASPING)
    assert goal.cancel()
    assert goal.end()[0] == GoalStatus.STATUS_CANCELED
    held = active.wait_for_state(State.GRASPING, Reason.GRASP_CANCELED).pressure_command
    assert held > 1.0e4
    active.hear_more(10)
    assert active.status.pressure_command == held


def test_a_refused_command_does_not_deny_what_is_held(active):
    status, reached = command(active, DIAMETER).end()
    assert status == SUCCEEDED
    result = refused(active, command(active, 0.09), "above the grippable range")
    assert (result.position, result.effort) == (reached.position, reached.effort)
    assert result.effort > 0.0


def test_opening_succeeds_in_a_fault_which_has_vented_already(active):
    assert active.set_parameter("pressure.fault_policy", "vent").successful
    active.regulator = lambda pressure: 0.0
    active.wait_until(
        lambda: active.status is not None and active.status.measured_pressure, "measurement"
    )
    active.send_radius(0.02)
    active.wait_for_state(State.FAULT)
    status, result = command(active, OPEN).end()
    assert (status, result.reached_goal) == (SUCCEEDED, True)


def test_a_command_is_replaced_like_a_grasp(active):
    assert active.set_parameter("pressure.rate_up", 500.0).successful
    goal = command(active, DIAMETER)
    active.wait_for_state(State.GRASPING)
    newer = active.grasps.grasp(0.025)
    refused(active, goal, "a newer grasp goal has taken over")
    assert newer.cancel()


def test_opening_waits_until_the_measured_pressure_is_gone(active):
    rest = [4.0e4]
    active.regulator = lambda pressure: max(pressure, rest[0])
    active.wait_until(
        lambda: active.status is not None and active.status.measured_pressure, "measurement"
    )
    goal = command(active, OPEN)
    active.wait_until(lambda: len(goal.feedback) >= 3, "some feedback")
    assert not goal.is_done
    assert goal.feedback[-1].position < OPEN
    rest[0] = 0.0
    status, result = goal.end()
    assert (status, result.reached_goal, result.position) == (SUCCEEDED, True, OPEN)


def test_opening_fails_if_the_measured_pressure_stays(active):
    assert active.set_parameter("grasp.timeout", 0.3).successful
    active.regulator = lambda pressure: 4.0e4
    active.wait_until(
        lambda: active.status is not None and active.status.measured_pressure, "measurement"
    )
    assert refused(active, command(active, OPEN), "after the release").position < OPEN


def test_a_grasp_replaces_an_opening_that_waits(active):
    # So long after a wrap it is no fault, which would forbid the grasp, that the pressure stays.
    assert active.set_parameter("pressure.settle_time", 60.0).successful
    active.regulator = lambda pressure: pressure
    active.wait_until(
        lambda: active.status is not None and active.status.measured_pressure, "measurement"
    )
    active.wrap(0.02)
    active.regulator = lambda pressure: 4.0e4
    goal = command(active, OPEN)
    active.wait_until(lambda: goal.feedback, "feedback")
    newer = active.grasps.grasp(0.02)
    refused(active, goal, "told to grip again")
    newer.cancel()


def test_an_opening_can_be_canceled_and_stays_released(active):
    active.regulator = lambda pressure: 4.0e4
    active.wait_until(
        lambda: active.status is not None and active.status.measured_pressure, "measurement"
    )
    goal = command(active, OPEN)
    assert goal.cancel()
    assert goal.end()[0] == GoalStatus.STATUS_CANCELED
    assert active.wait_for_state(State.RELEASED).pressure_command == 0.0


def test_an_inactive_node_refuses(active):
    assert active.transition("deactivate")
    active.spin(0.1)
    active.pressures.clear()
    refused(active, command(active, OPEN), "the node is not active")
    refused(active, command(active, DIAMETER), "the node is not active")
    active.spin(0.1)
    assert active.pressures == []
    assert active.transition("cleanup")
    refused(active, command(active, DIAMETER), "configure it first")


def test_a_deactivation_ends_an_opening_that_waits(active):
    active.regulator = lambda pressure: 4.0e4
    active.wait_until(
        lambda: active.status is not None and active.status.measured_pressure, "measurement"
    )
    goal = command(active, OPEN)
    assert active.transition("deactivate")
    refused(active, goal, "the node is not active")


def test_a_joint_is_wrapped_and_opened_too(active):
    assert active.set_parameter("pressure.rate_up", 2.0e5).successful
    goal = joint_command(active, name=["grip"], position=[DIAMETER], effort=[100.0])
    status, result = goal.end()
    assert status == SUCCEEDED
    assert result.reached_goal
    assert not result.stalled
    assert result.state.name == ["grip"]
    assert list(result.state.position) == [pytest.approx(DIAMETER, rel=1e-6)]
    assert result.state.effort[0] > 0.0
    assert result.state.header.stamp.sec > 0
    assert goal.feedback[0].state.position[0] == OPEN
    assert all_finite(result, *goal.feedback)
    status, result = joint_command(active, position=[OPEN]).end()
    assert (status, list(result.state.position)) == (SUCCEEDED, [OPEN])
    assert list(result.state.name) == ["spiral_gripper_opening"]  # the goal has none


def test_a_joint_command_that_is_none_is_refused(active):
    goal = joint_command(active, name=["a", "b"], position=[0.02, 0.02])
    refused(active, goal, "one position")


def test_a_velocity_is_not_used_and_the_log_says_so(active):
    assert joint_command(active, position=[DIAMETER], velocity=[0.1]).end()[0] == SUCCEEDED
    assert "velocity is not used" in active.node.log()


def test_one_name_has_the_type_that_the_parameter_says(control_msgs, namespace, capfd):
    del control_msgs
    chosen = [Parameter("gripper_cmd.type", value="ParallelGripperCommand")]
    node = GripperNode(namespace=namespace, parameter_overrides=chosen)
    node.destroy_node()
    log = capfd.readouterr().err
    assert ": gripper_cmd is offered as control_msgs/action/ParallelGripperCommand" in log
    assert "parallel_gripper_cmd" not in log


# --- without control_msgs ----------------------------------------------------------------------


def test_without_control_msgs_the_node_does_without_and_says_so(namespace, monkeypatch, capfd):
    monkeypatch.setitem(sys.modules, f"{PACKAGE}.action", None)
    node = GripperNode(namespace=namespace)
    services = [name for name, _ in node.get_service_names_and_types() if "gripper_cmd" in name]
    node.destroy_node()
    assert not [name for name in services if name.startswith(namespace)]
    assert "control_msgs is not installed" in capfd.readouterr().err


def test_a_control_msgs_that_cannot_be_used_does_not_stop_the_node(namespace, monkeypatch, capfd):
    class GripperCommand:
        """Has no type support, as if it were built for another Python."""

    broken = types.ModuleType(f"{PACKAGE}.action")
    broken.GripperCommand = GripperCommand
    monkeypatch.setitem(sys.modules, PACKAGE, types.ModuleType(PACKAGE))
    monkeypatch.setitem(sys.modules, f"{PACKAGE}.action", broken)
    node = GripperNode(namespace=namespace)
    node.destroy_node()
    log = capfd.readouterr().err
    assert "control_msgs cannot be used, gripper_cmd is not offered" in log
    assert "control_msgs has no ParallelGripperCommand" in log
