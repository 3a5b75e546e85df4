# SPDX-License-Identifier: Apache-2.0
"""The Python client, against a node in a process of its own."""

import math

import pytest
from ros.client_harness import PATIENCE, RADIUS, wait_for_pressure, wait_until
from ros.harness import all_finite

from spiral_core import InvalidInputError
from spiral_gripper_msgs.msg import PlannedWrap
from spiral_gripper_msgs.srv import PlanWrap
from spiral_gripper_ros.client import (
    AbortPolicy,
    RequestRefusedError,
    SpiralGripper,
    WrapOutcome,
    WrapResult,
)
from spiral_gripper_ros.control.states import Reason, State


def test_wrap_wait_release(grip, curve):
    assert grip.wrap(RADIUS)
    result = grip.wait(PATIENCE)
    assert result == grip.result()
    assert result.outcome is WrapOutcome.SUCCEEDED
    assert result.reason is Reason.NONE
    assert result.object_radius == RADIUS
    assert result.pressure_command == pytest.approx(curve.pressure_from_radius(RADIUS))
    assert result.measured_pressure is None
    assert result.turns > 1.0
    assert result.contact_length > 0.1
    assert result.line_force > 0.0
    assert "wraps 0.02 m" in result.message
    wait_until(lambda: grip.status.state == State.GRASPING)
    assert all_finite(grip.feedback(), grip.status)
    grip.release()
    wait_until(lambda: grip.status.state == State.RELEASED)


def test_a_measured_pressure_is_in_the_result(grip, active):
    assert active.set_parameter("pressure.settle_time", 2.0).successful
    active.regulator = lambda pressure: pressure
    active.wait_until(
        lambda: active.status is not None and active.status.measured_pressure, "measurement"
    )
    grip.wrap(RADIUS)
    while not grip.is_done():
        active.spin(0.1)
    result = grip.result()
    assert result.outcome is WrapOutcome.SUCCEEDED
    assert result.measured_pressure == pytest.approx(result.pressure_command, abs=1.0e3)


def test_polling_sees_the_way_to_the_target(slow, active):
    slow.wrap(RADIUS, timeout=600.0)
    progress = []

    def is_done():
        done = slow.is_done()
        if slow.feedback() is not None:
            progress.append(slow.feedback().progress)
        return done

    wait_until(lambda: is_done() or len(set(progress)) >= 3)
    assert slow.result() is None
    assert active.set_parameter("pressure.rate_up", 2.0e6).successful
    wait_until(is_done)
    assert progress == sorted(progress)
    assert slow.result().outcome is WrapOutcome.SUCCEEDED


def test_what_cannot_be_wrapped_is_a_result_with_its_reason(grip):
    assert grip.wrap(0.2)
    result = grip.wait(PATIENCE)
    assert result.outcome is WrapOutcome.FAILED
    assert result.reason is Reason.RADIUS_TOO_LARGE
    assert "above the grippable range" in result.message


def test_a_plan_moves_nothing_and_says_what_would_be(grip, active, curve):
    plan = grip.plan(RADIUS, overpressure=2.0e3)
    assert plan.success
    assert plan.figures[0].pressure == pytest.approx(curve.pressure_from_radius(RADIUS) + 2.0e3)
    assert not grip.plan(0.2).success
    active.hear_more()
    assert active.status.state == State.WAITING


def test_a_plan_is_asked_with_everything_that_the_service_takes(grip, monkeypatch):
    asked = []
    answer = PlanWrap.Response(plans=[PlannedWrap()])
    monkeypatch.setattr(grip._link, "call", lambda *question: asked.append(question) or answer)
    grip.plan(RADIUS, 2.0e3, payload=0.1, friction=0.5, compute_grip=True)
    grip.plan(RADIUS)
    (_, request, patience), (_, bare, none) = asked
    (one,), (other,) = request.objects, bare.objects
    assert (one.radius, *request.overpressure, *one.payload) == (RADIUS, 2.0e3, 0.1)
    assert (*one.friction_coefficient, request.compute_grip) == (0.5, True)
    given = (*bare.overpressure, *other.payload, *other.friction_coefficient)
    assert (given, bare.compute_grip) == ((), False)
    assert patience > none == 0.0
    with pytest.raises(InvalidInputError, match="payload"):
        grip.plan(RADIUS, payload=-1.0)
    with pytest.raises(InvalidInputError, match="friction"):
        grip.plan(RADIUS, friction=math.nan)


def test_the_radius_that_is_followed_can_be_pinned(grip, active):
    active.wrap(RADIUS)
    grip.wrap(None)
    assert grip.wait(PATIENCE).object_radius == RADIUS


def test_a_pressure_can_be_asked_for_whatever_it_wraps(grip, active):
    assert grip.press(3.0e4)
    result = grip.wait(PATIENCE)
    assert result.outcome is WrapOutcome.SUCCEEDED, result.message
    assert (result.pressure_command, result.object_radius, result.turns) == (3.0e4, None, None)
    active.wait_until(lambda: active.pressures[-1] == 3.0e4, "the pressure")


def test_cancel_vents_or_holds(slow):
    slow.wrap(RADIUS)
    assert slow.cancel()
    result = slow.wait(PATIENCE)
    assert (result.outcome, result.reason) == (WrapOutcome.CANCELED, Reason.GRASP_CANCELED)
    assert result.pressure_command == 0.0
    assert not slow.cancel()
    slow.wrap(RADIUS, abort_policy=AbortPolicy.HOLD)
    wait_for_pressure(slow)
    assert slow.cancel()
    assert slow.wait(PATIENCE).pressure_command > 0.0


def test_a_newer_wrap_takes_over(slow, active):
    slow.wrap(0.03, timeout=600.0)
    assert active.set_parameter("pressure.rate_up", 2.0e6).successful
    slow.wrap(RADIUS)
    result = slow.wait(PATIENCE)
    assert (result.outcome, result.object_radius) == (WrapOutcome.SUCCEEDED, RADIUS)


def test_the_wraps_own_timeout_is_a_result(slow):
    slow.wrap(RADIUS, timeout=0.2)
    assert slow.wait(PATIENCE).reason is Reason.GRASP_TIMEOUT


def test_cancel_is_sent_at_once(slow, monkeypatch):
    slow.wrap(RADIUS, timeout=600.0)
    sent = []
    cancel = slow._goal.cancel_goal_async
    spin_once = slow._link._executor.spin_once
    monkeypatch.setattr(slow._goal, "cancel_goal_async", lambda: sent.append("sent") or cancel())
    monkeypatch.setattr(
        slow._link._executor, "spin_once", lambda *args: sent.append("spun") or spin_once(*args)
    )
    assert slow.cancel()
    assert sent[0] == "sent"


def test_a_wrap_interrupted_before_its_answer_is_known_is_canceled(slow, active, monkeypatch):
    def interrupted(*_):
        active.wait_until(lambda: active.status.state == State.GRASPING, "the goal's acceptance")
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(slow._link, "answer", interrupted)
        with pytest.raises(KeyboardInterrupt):
            slow.wrap(RADIUS)
    assert slow.cancel()
    active.wait_for_state(State.RELEASED)


@pytest.mark.parametrize("policy", ["hold", AbortPolicy.HOLD])
def test_the_abort_policy_may_be_a_word(slow, policy):
    slow.wrap(RADIUS, abort_policy=policy)
    wait_for_pressure(slow)
    assert slow.cancel()
    assert slow.wait(PATIENCE).pressure_command > 0.0


def test_without_a_wrap_there_is_nothing_to_wait_for(shared):
    with SpiralGripper(shared.get_namespace()) as gripper:
        assert gripper.is_done()
        assert gripper.result() is None
        assert gripper.feedback() is None
        assert not gripper.cancel()
        with pytest.raises(RequestRefusedError, match="no wrap has been started"):
            gripper.wait(1.0)


def test_rearm_follows_radii_again_and_is_refused_while_grasping(grip, active):
    grip.release()
    grip.rearm()
    assert active.wait_for_state(State.WAITING)
    grip.wrap(RADIUS)
    grip.wait(PATIENCE)
    with pytest.raises(RequestRefusedError, match="rearm is refused"):
        grip.rearm()


def test_a_result_cannot_be_changed(grip):
    grip.wrap(RADIUS)
    result = grip.wait(PATIENCE)
    assert isinstance(result, WrapResult)
    with pytest.raises(AttributeError):
        result.turns = 5.0
