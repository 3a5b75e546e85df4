# SPDX-License-Identifier: Apache-2.0
"""The action `grasp`: real goals to a node in a process of its own."""

import math

import pytest
from action_msgs.msg import GoalStatus
from lifecycle_msgs.msg import State as LifecycleState
from ros.grasp_goals import Goals, refused, started
from ros.harness import RunningNode, all_finite

from spiral_gripper_msgs.action import Grasp
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.states import Reason, State

RADIUS = 0.02
SUCCEEDED, CANCELED = GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED


@pytest.fixture(scope="module")
def connection(shared):
    goals = Goals(shared)
    yield goals
    goals.close()


@pytest.fixture
def goals(active, connection):
    """Goals to a freshly activated node that takes a wrap for reached soon after its command is."""
    assert active.set_parameter("pressure.settle_time", 0.1).successful
    return connection


@pytest.fixture
def slow(goals):
    """The same, but a wrap takes minutes."""
    assert goals.client.set_parameter("pressure.rate_up", 500.0).successful
    return goals


def ideal(pressure):
    return pressure


def measure(goals, regulator):
    """Answer each command with a measured pressure from now on."""
    client = goals.client
    client.regulator = regulator
    client.wait_until(
        lambda: client.status is not None and client.status.measured_pressure, "a measured pressure"
    )


def vented(client):
    client.wait_until(lambda: client.pressures and client.pressures[-1] == 0.0, "a vent")
    client.spin(0.1)
    return client.pressures[-1] == 0.0


# --- success -----------------------------------------------------------------------------------


def test_a_goal_wraps_the_object_and_says_so(goals, curve):
    wrap = curve.wrap_for_radius(RADIUS)
    goal = goals.grasp(RADIUS)
    status, result = goal.end()
    assert status == SUCCEEDED
    assert result.success
    assert result.reason == Reason.NONE
    assert result.pressure_command == pytest.approx(wrap.pressure, rel=1e-9)
    assert not result.measured_pressure
    (figures,) = result.figures
    assert figures.object_radius == RADIUS
    assert figures.turns == pytest.approx(wrap.turns, rel=1e-6)
    assert figures.contact_length == pytest.approx(wrap.contact_length)
    assert figures.line_force > 0.0
    assert result.elapsed > 0.0
    assert "as commanded" in result.message
    assert all_finite(result, *goal.feedback)


def test_what_is_wrapped_is_held_and_no_radius_is_followed(goals):
    _, result = goals.grasp(RADIUS).end()
    for _ in range(20):
        goals.client.send_radius(0.03)
        goals.client.hear_more(1)
    status = goals.client.status
    assert status.state == State.GRASPING
    assert list(status.object_radius) == [RADIUS]
    assert status.pressure_command == status.pressure_target == result.pressure_command
    assert status.wrapped


def test_a_measured_pressure_decides_when_it_is_known(goals):
    # What is measured here comes as late as this process is held up.
    assert goals.client.set_parameter("pressure.settle_time", 2.0).successful
    measure(goals, ideal)
    status, result = goals.grasp(RADIUS).end()
    assert status == SUCCEEDED, result.message
    assert list(result.measured_pressure) == pytest.approx([result.pressure_command], abs=1.0e3)
    assert "as measured" in result.message


def test_feedback_tells_the_way_to_the_target_and_is_not_too_much(goals, curve):
    assert goals.client.set_parameter("pressure.rate_up", 5.0e4).successful
    assert goals.client.set_parameter("pressure.settle_time", 1.0).successful
    goal = goals.grasp(RADIUS)
    _, result = goal.end()
    progress = [feedback.progress for feedback in goal.feedback]
    assert progress == sorted(progress)
    assert progress[0] < 0.1 < progress[-1] <= 1.0
    assert {feedback.state for feedback in goal.feedback} == {State.GRASPING}
    target = curve.pressure_from_radius(RADIUS)
    for feedback in goal.feedback:
        assert feedback.pressure_target == pytest.approx(target, rel=1e-9)
    assert goal.feedback[0].regime == GripStatus.REGIME_OVERHANG
    assert goal.feedback[-1].regime == GripStatus.REGIME_PERFECT_WRAP
    assert 3 <= len(goal.feedback) <= 2 + result.elapsed / 0.1


def test_overpressure_is_held_above_the_wrap_and_holds_more(goals, curve):
    _, loose = goals.grasp(RADIUS).end()
    status, tight = goals.grasp(RADIUS, overpressure=[1.0e4]).end()
    assert status == SUCCEEDED, tight.message
    assert tight.pressure_command == pytest.approx(curve.pressure_from_radius(RADIUS) + 1.0e4)
    assert tight.figures[0].line_force > loose.figures[0].line_force


def test_the_radius_that_is_followed_is_a_mode(goals):
    target = goals.client.wrap(RADIUS).pressure_target
    status, result = goals.send(Grasp.Goal(mode=Grasp.Goal.MODE_FOLLOWED)).end()
    assert status == SUCCEEDED
    assert result.figures[0].object_radius == RADIUS
    assert result.pressure_command == target


def test_a_pressure_is_reached_within_ramp_and_cap_whatever_it_wraps(goals):
    goals.client.wrap(RADIUS)
    goal = goals.send(Grasp.Goal(mode=Grasp.Goal.MODE_PRESSURE, pressure=3.0e4))
    status, result = goal.end()
    assert status == SUCCEEDED, result.message
    assert result.pressure_command == 3.0e4
    assert not result.figures
    assert not result.grip
    goals.client.send_radius(RADIUS)
    goals.client.hear_more()
    status = goals.client.status
    assert (status.state, status.wrapped) == (State.GRASPING, False)
    assert not status.object_radius
    assert status.pressure_command == status.pressure_target == 3.0e4
    assert goals.client.set_parameter("pressure.cap", 2.0e4).successful
    status = goals.client.wait_for_state(State.GRASPING, Reason.PRESSURE_CAP)
    goals.client.wait_until(lambda: goals.client.pressures[-1] == 2.0e4, "the cap")
    assert goals.grasp(RADIUS).end()[1].reason == Reason.PRESSURE_CAP


def test_ten_goals_in_a_row(goals, curve):
    for number in range(10):
        radius = 0.012 + 0.002 * number
        status, result = goals.grasp(radius).end()
        assert status == SUCCEEDED, result.message
        assert result.pressure_command == pytest.approx(curve.pressure_from_radius(radius))


def test_a_goal_ends_a_release(goals):
    goals.client.release()
    assert goals.client.wait_for_state(State.RELEASED)
    status, _ = goals.grasp(RADIUS).end()
    assert status == SUCCEEDED
    assert goals.client.wait_for_state(State.GRASPING).pressure_command > 0.0


def test_while_a_goal_runs_the_node_answers_and_commands(slow):
    goal = started(slow.grasp(RADIUS, timeout=[600.0]))
    before = len(slow.client.pressures)
    assert slow.client.plan_wrap(0.03).success
    slow.client.wait_until(lambda: len(slow.client.pressures) > before + 20, "more commands")
    assert not goal.is_done
    assert goal.cancel()


# --- cancel, failure ---------------------------------------------------------------------------


def test_cancel_vents_at_once_by_default(slow):
    goal = started(slow.grasp(RADIUS))
    assert goal.cancel()
    status, result = goal.end()
    assert (status, result.reason) == (CANCELED, Reason.GRASP_CANCELED)
    assert not result.success
    assert result.pressure_command == 0.0
    status = slow.client.wait_for_state(State.RELEASED, Reason.GRASP_CANCELED)
    assert status.pressure_command == status.pressure_target == 0.0
    assert slow.grasp(RADIUS).cancel()


def test_cancel_with_the_policy_hold_leaves_the_pressure_as_it_is(slow):
    goal = started(slow.grasp(RADIUS, abort_policy=Grasp.Goal.ABORT_HOLD))
    assert goal.cancel()
    status, result = goal.end()
    assert (status, result.reason) == (CANCELED, Reason.GRASP_CANCELED)
    assert result.pressure_command > 0.0
    slow.client.statuses.clear()
    status = slow.client.wait_for_state(State.GRASPING, Reason.GRASP_CANCELED)
    assert status.pressure_command == status.pressure_target == result.pressure_command


def test_the_parameter_says_what_a_failure_does_if_the_goal_does_not(slow):
    assert slow.client.set_parameter("grasp.abort_policy", "hold").successful
    goal = started(slow.grasp(RADIUS))
    assert goal.cancel()
    assert goal.end()[1].pressure_command > 0.0


def test_a_goal_that_has_ended_cannot_be_canceled(goals):
    goal = goals.grasp(RADIUS)
    goal.end()
    assert not goal.cancel()
    assert goals.client.wait_for_state(State.GRASPING).pressure_command > 0.0


def test_a_goal_that_takes_too_long_fails_and_vents(slow):
    text = refused(slow.grasp(RADIUS, timeout=[0.3]), Reason.GRASP_TIMEOUT)
    assert "0.3 s" in text
    assert slow.client.wait_for_state(State.RELEASED, Reason.GRASP_TIMEOUT).pressure_command == 0.0


def test_without_a_timeout_the_parameter_counts(slow):
    assert slow.client.set_parameter("grasp.timeout", 0.2).successful
    refused(slow.grasp(RADIUS), Reason.GRASP_TIMEOUT)


def test_a_pressure_that_does_not_come_fails_the_goal(goals):
    measure(goals, lambda pressure: 0.5 * pressure)
    refused(goals.grasp(RADIUS), Reason.PRESSURE_LOW)
    assert goals.client.wait_for_state(State.RELEASED, Reason.PRESSURE_LOW).pressure_command == 0.0


def test_a_newer_goal_replaces_the_older(slow):
    first = started(slow.grasp(RADIUS))
    second = slow.grasp(0.025)
    assert "newer" in refused(first, Reason.GRASP_REPLACED)
    slow.client.wait_until(
        lambda: list(slow.client.status.object_radius) == [0.025], "the newer goal"
    )
    assert slow.client.status.state == State.GRASPING
    assert slow.client.set_parameter("pressure.rate_up", 2.0e6).successful
    assert second.end()[0] == SUCCEEDED


def test_a_release_ends_the_goal(slow):
    goal = started(slow.grasp(RADIUS))
    assert slow.client.release().success
    refused(goal, Reason.RELEASED)
    assert slow.client.wait_for_state(State.RELEASED).pressure_command == 0.0


@pytest.mark.parametrize("transitions", [("deactivate",), ("deactivate", "cleanup")])
def test_deactivation_and_cleanup_end_the_goal(slow, transitions):
    goal = started(slow.grasp(RADIUS))
    for transition in transitions:
        assert slow.client.transition(transition)
    refused(goal, Reason.NOT_ACTIVE)
    assert vented(slow.client)


def test_another_gripper_ends_the_goal(slow):
    goal = started(slow.grasp(RADIUS))
    assert slow.client.set_parameter("gripper", "prototype_p1").successful
    refused(goal, Reason.RECONFIGURED)
    assert vented(slow.client)


def test_a_node_that_is_stopped_ends_its_goal(client, namespace):
    with RunningNode(namespace, {"pressure.rate_up": 500.0}) as node:
        client.wait_until_active()
        goals = Goals(client)
        goal = started(goals.grasp(RADIUS))
        assert node.stop() == 0, node.log()
        refused(goal, Reason.NOT_ACTIVE)
        assert vented(client)
        assert "Traceback" not in node.log()
        goals.close()


# --- refusal -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"object_radius": math.nan}, Reason.RADIUS_NOT_FINITE),
        ({"object_radius": -math.inf}, Reason.RADIUS_NOT_FINITE),
        ({"object_radius": -0.02}, Reason.RADIUS_NOT_POSITIVE),
        ({"object_radius": 0.001}, Reason.RADIUS_TOO_SMALL),
        ({"object_radius": 0.2}, Reason.RADIUS_TOO_LARGE),
        ({"object_radius": RADIUS, "overpressure": [1.0e6]}, Reason.PRESSURE_CAP),
        ({"object_radius": RADIUS, "overpressure": [-1.0]}, Reason.INVALID_REQUEST),
        ({"object_radius": RADIUS, "overpressure": [math.nan]}, Reason.INVALID_REQUEST),
        ({"object_radius": RADIUS, "payload": [-1.0]}, Reason.INVALID_REQUEST),
        ({"object_radius": RADIUS, "timeout": [-1.0]}, Reason.INVALID_REQUEST),
        ({"object_radius": RADIUS, "timeout": [0.0]}, Reason.INVALID_REQUEST),
        ({"object_radius": RADIUS, "timeout": [math.inf]}, Reason.INVALID_REQUEST),
        ({"object_radius": RADIUS, "abort_policy": 3}, Reason.INVALID_REQUEST),
        ({"object_radius": RADIUS, "mode": 3}, Reason.INVALID_REQUEST),
        ({}, Reason.RADIUS_NOT_POSITIVE),
        ({"mode": Grasp.Goal.MODE_FOLLOWED}, Reason.NO_RADIUS),
        ({"mode": Grasp.Goal.MODE_PRESSURE, "pressure": math.nan}, Reason.INVALID_REQUEST),
        ({"mode": Grasp.Goal.MODE_PRESSURE, "pressure": 1.0e6}, Reason.PRESSURE_CAP),
        (
            {"mode": Grasp.Goal.MODE_PRESSURE, "pressure": 1.0e4, "overpressure": [1.0]},
            Reason.INVALID_REQUEST,
        ),
    ],
)
def test_a_goal_that_cannot_be_done_says_why_and_changes_nothing(goals, fields, reason):
    refused(goals.send(Grasp.Goal(**fields)), reason)
    goals.client.hear_more()
    status = goals.client.status
    assert (status.state, status.reason) == (State.WAITING, Reason.NO_RADIUS)
    assert set(goals.client.pressures) == {0.0}


def test_a_refused_goal_leaves_the_running_one_alone(slow):
    first = started(slow.grasp(RADIUS))
    refused(slow.grasp(0.2), Reason.RADIUS_TOO_LARGE)
    assert slow.client.set_parameter("pressure.rate_up", 2.0e6).successful
    assert first.end()[0] == SUCCEEDED


def test_an_inactive_node_refuses(goals):
    assert goals.client.transition("deactivate")
    assert "activate" in refused(goals.grasp(RADIUS), Reason.NOT_ACTIVE)
    assert goals.client.transition("cleanup")
    assert "configure" in refused(goals.grasp(RADIUS), Reason.NOT_ACTIVE)
    assert goals.client.lifecycle_state() == LifecycleState.PRIMARY_STATE_UNCONFIGURED
