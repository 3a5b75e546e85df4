# SPDX-License-Identifier: Apache-2.0
"""The Python client, against a node in a process of its own, and where something is wrong."""

import math
import warnings

import pytest
from rclpy.action import ActionClient
from rclpy.client import Client
from ros.client_harness import PATIENCE, QUESTIONS, RADIUS, wait_for_pressure, wait_until
from ros.harness import NODE, all_finite

from spiral_core import InvalidInputError
from spiral_core.errors import SpiralError
from spiral_gripper_msgs.msg import PlannedWrap
from spiral_gripper_msgs.srv import PlanWrap
from spiral_gripper_ros.client import (
    AbortPolicy,
    NoAnswerError,
    RequestRefusedError,
    SpiralGripper,
    WrapOutcome,
    spiral_gripper,
)
from spiral_gripper_ros.client.connection import Connection
from spiral_gripper_ros.control.states import Reason, State


def test_wrap_wait_rearm_release(grip, active, curve):
    assert active.set_parameter("pressure.settle_time", 2.0).successful
    active.regulator = lambda pressure: pressure
    active.wait_until(lambda: active.status.measured_pressure, "measurement")
    assert grip.wrap(RADIUS)
    while not grip.is_done():
        active.spin(0.1)
    result = grip.wait(PATIENCE)
    assert result == grip.result()
    assert (result.outcome, result.reason) == (WrapOutcome.SUCCEEDED, Reason.NONE)
    assert result.object_radius == RADIUS
    assert result.pressure_command == pytest.approx(curve.pressure_from_radius(RADIUS))
    assert result.measured_pressure == pytest.approx(result.pressure_command, abs=1.0e3)
    assert result.turns > 1.0
    assert result.contact_length > 0.1
    assert result.line_force > 0.0
    assert "wraps 0.02 m" in result.message
    wait_until(lambda: grip.status.state == State.GRASPING)
    assert all_finite(grip.feedback(), grip.status)
    with pytest.raises(RequestRefusedError, match="rearm is refused"):
        grip.rearm()
    grip.release()
    wait_until(lambda: grip.status.state == State.RELEASED)
    grip.rearm()
    assert active.wait_for_state(State.WAITING)


def test_polling_sees_the_way_to_the_target_and_a_short_wait_ends_nothing(
    slow, active, monkeypatch
):
    slow.wrap(RADIUS, timeout=600.0)
    monkeypatch.setattr(spiral_gripper, "SILENCE", PATIENCE)
    with pytest.raises(NoAnswerError, match="it goes on") as caught:
        slow.wait(0.2)
    assert caught.value.timeout == 0.2
    assert slow.result() is None
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
    assert (slow.result().outcome, slow.result().measured_pressure) == (WrapOutcome.SUCCEEDED, None)


def test_a_plan_moves_nothing_and_what_cannot_be_wrapped_is_a_result(grip, active, curve):
    plan = grip.plan(RADIUS, overpressure=2.0e3)
    assert plan.success
    assert plan.figures[0].pressure == pytest.approx(curve.pressure_from_radius(RADIUS) + 2.0e3)
    assert not grip.plan(0.2).success
    active.hear_more()
    assert active.status.state == State.WAITING
    assert grip.wrap(0.2)
    result = grip.wait(PATIENCE)
    assert (result.outcome, result.reason) == (WrapOutcome.FAILED, Reason.RADIUS_TOO_LARGE)
    assert "above the grippable range" in result.message


def test_a_plan_is_asked_with_everything_that_the_service_takes(nowhere, monkeypatch):
    asked = []
    answer = PlanWrap.Response(plans=[PlannedWrap()])
    monkeypatch.setattr(Connection, "call", lambda *question: asked.append(question) or answer)
    nowhere.plan(RADIUS, 2.0e3, payload=0.1, friction=0.5, compute_grip=True)
    nowhere.plan(RADIUS)
    (*_, request, patience), (*_, bare, none) = asked
    (one,), (other,) = request.objects, bare.objects
    assert (one.radius, *request.overpressure, *one.payload) == (RADIUS, 2.0e3, 0.1)
    assert (*one.friction_coefficient, request.compute_grip) == (0.5, True)
    given = (*bare.overpressure, *other.payload, *other.friction_coefficient)
    assert (given, bare.compute_grip) == ((), False)
    assert patience > none == 0.0


def test_the_radius_that_is_followed_or_a_pressure_can_be_asked_for(grip, active):
    active.wrap(RADIUS)
    grip.wrap(None)
    assert grip.wait(PATIENCE).object_radius == RADIUS
    assert grip.press(3.0e4)
    result = grip.wait(PATIENCE)
    assert result.outcome is WrapOutcome.SUCCEEDED, result.message
    assert (result.pressure_command, result.object_radius, result.turns) == (3.0e4, None, None)


@pytest.mark.parametrize("policy", [None, "hold", AbortPolicy.HOLD])
def test_cancel_vents_or_holds(slow, policy):
    slow.wrap(RADIUS, abort_policy=policy)
    wait_for_pressure(slow)
    assert slow.cancel()
    result = slow.wait(PATIENCE)
    assert (result.outcome, result.reason) == (WrapOutcome.CANCELED, Reason.GRASP_CANCELED)
    assert (result.pressure_command > 0.0) is (policy is not None)
    assert not slow.cancel()


def test_a_newer_wrap_takes_over_and_its_timeout_is_a_result(slow):
    slow.wrap(0.03, timeout=600.0)
    slow.wrap(RADIUS, timeout=0.2)
    result = slow.wait(PATIENCE)
    assert (result.reason, result.object_radius) == (Reason.GRASP_TIMEOUT, RADIUS)


def test_a_wrap_interrupted_before_its_answer_is_known_is_canceled(slow, active, monkeypatch):
    def interrupted(*_):
        active.wait_until(lambda: active.status.state == State.GRASPING, "the goal's acceptance")
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Connection, "answer", interrupted)
        with pytest.raises(KeyboardInterrupt):
            slow.wrap(RADIUS)
    assert slow.cancel()
    active.wait_for_state(State.RELEASED)


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("closes", [False, True])
def test_a_goal_that_is_accepted_too_late_is_canceled_also_while_closing(
    active, shared, monkeypatch, closes
):
    def silent(*_):
        raise NoAnswerError("grasp does not answer", 0.1)

    if closes:
        monkeypatch.setattr(spiral_gripper, "GLANCE", PATIENCE)
    with SpiralGripper(shared.get_namespace()) as hasty:
        hasty.wait_until_active(PATIENCE)
        with monkeypatch.context() as patch:
            patch.setattr(Connection, "answer", silent)
            with pytest.raises(NoAnswerError, match="may still start; it is canceled as soon as"):
                hasty.wrap(RADIUS, timeout=600.0)
        if not closes:
            assert hasty.is_done()
            active.wait_for_state(State.GRASPING)

            def has_ended():
                assert hasty.status is not None  # a call, within which it hears of the goal
                active.spin(0.05)
                return active.status.state != State.GRASPING

            wait_until(has_ended)
    assert active.wait_for_state(State.RELEASED, Reason.GRASP_CANCELED)


def test_a_node_that_is_gone_is_noticed_while_polling(slow, monkeypatch):
    slow.wrap(RADIUS, timeout=600.0)
    monkeypatch.setattr(ActionClient, "server_is_ready", lambda _: False)
    monkeypatch.setattr(Client, "service_is_ready", lambda _: False)
    with pytest.raises(NoAnswerError, match="no gripper's node answers"):
        slow.is_done()
    monkeypatch.undo()
    assert slow.cancel()


def test_an_inactive_node_is_told_from_one_that_does_not_exist(active, connection):
    assert active.transition("deactivate")
    with pytest.raises(NoAnswerError, match="not active") as caught:
        connection.wait_until_active(0.5)
    assert f"ros2 lifecycle set {active.get_namespace()}/{NODE} configure" in str(caught.value)


@pytest.mark.parametrize("question", QUESTIONS)
def test_without_a_node_or_a_wrap_the_error_says_how_to_start_one(nowhere, namespace, question):
    with pytest.raises(NoAnswerError) as caught:
        question(nowhere)
    assert f"no gripper's node answers in the namespace {namespace}" in str(caught.value)
    assert f"spiral_gripper_node --ros-args -r __ns:={namespace}" in str(caught.value)
    assert isinstance(caught.value, SpiralError)
    assert isinstance(caught.value, TimeoutError)
    assert nowhere.status is nowhere.result() is nowhere.feedback() is None
    assert nowhere.is_done()
    assert not nowhere.cancel()
    with pytest.raises(RequestRefusedError, match="no wrap has been started"):
        nowhere.wait(1.0)
    for _ in range(2):
        nowhere.close()
    with pytest.raises(RequestRefusedError, match="this SpiralGripper is closed"):
        question(nowhere)


@pytest.mark.parametrize("bad", ["bad name!", "/1", "/a/", "~", "//a", None, 3])
def test_a_bad_namespace_is_refused_without_a_warning(bad):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InvalidInputError, match="namespace must be a ROS namespace"):
            SpiralGripper(bad)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -0.02, "0.02", True])
@pytest.mark.parametrize(
    ("name", "question"),
    [
        ("radius", lambda gripper, bad: gripper.wrap(bad)),
        ("radius", lambda gripper, bad: gripper.plan(bad)),
        ("timeout", lambda gripper, bad: gripper.wrap(RADIUS, timeout=bad)),
        ("timeout", lambda gripper, bad: gripper.wait(bad)),
        ("timeout", lambda gripper, bad: gripper.wait_until_active(bad)),
        ("answer_timeout", lambda gripper, bad: SpiralGripper(answer_timeout=bad)),
        ("overpressure", lambda gripper, bad: gripper.wrap(RADIUS, overpressure=bad)),
        ("pressure", lambda gripper, bad: gripper.press(bad)),
        ("payload", lambda gripper, bad: gripper.plan(RADIUS, payload=bad)),
        ("friction", lambda gripper, bad: gripper.plan(RADIUS, friction=bad)),
        ("abort_policy", lambda gripper, bad: gripper.wrap(RADIUS, abort_policy=bad)),
    ],
)
def test_a_bad_figure_is_refused_before_it_is_sent(nowhere, bad, name, question):
    for value in (bad, 0.0) if name in ("radius", "timeout", "answer_timeout") else (bad,):
        with pytest.raises(InvalidInputError, match=name):
            question(nowhere, value)
