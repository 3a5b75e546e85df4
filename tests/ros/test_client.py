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
from spiral_gripper_msgs.msg import ObjectToWrap, PlannedWrap
from spiral_gripper_msgs.srv import PlanWrap
from spiral_gripper_ros.client import (
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
    assert result.outcome is WrapOutcome.SUCCEEDED
    assert result.object_radius == RADIUS
    assert result.pressure_command == pytest.approx(curve.pressure_from_radius(RADIUS))
    assert result.measured_pressure == pytest.approx(result.pressure_command, abs=1.0e3)
    assert result.turns > 1.0
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
    wait_until(lambda: not slow.is_done() and slow.feedback() and slow.feedback().progress > 0.0)
    assert slow.result() is None
    assert active.set_parameter("pressure.rate_up", 2.0e6).successful
    wait_until(slow.is_done)
    assert (slow.result().outcome, slow.result().measured_pressure) == (WrapOutcome.SUCCEEDED, None)


def test_a_plan_is_asked_with_everything_that_the_service_takes(nowhere, monkeypatch):
    asked, answer = [], PlanWrap.Response(plans=[PlannedWrap()])
    monkeypatch.setattr(Connection, "call", lambda *question: asked.append(question) or answer)
    nowhere.plan(RADIUS, 2.0e3, payload=0.1, friction=0.5, compute_grip=True)
    nowhere.plan(RADIUS)
    one = ObjectToWrap(radius=RADIUS, payload=[0.1], friction_coefficient=[0.5])
    more = {"overpressure": [2.0e3], "compute_grip": True}
    full = PlanWrap.Request(objects=[one], backbone=True, **more)
    bare = PlanWrap.Request(objects=[ObjectToWrap(radius=RADIUS)], backbone=True)
    assert [question[-2] for question in asked] == [full, bare]
    assert asked[0][-1] > asked[1][-1] == 0.0  # patience


def test_the_radius_that_is_followed_or_a_pressure_can_be_asked_for(grip, active):
    active.wrap(RADIUS)
    grip.wrap(None)
    assert grip.wait(PATIENCE).object_radius == RADIUS
    assert grip.press(3.0e4)
    result = grip.wait(PATIENCE)
    assert result.outcome is WrapOutcome.SUCCEEDED, result.message
    assert (result.pressure_command, result.object_radius, result.turns) == (3.0e4, None, None)


def test_cancel_holds_if_it_is_to(slow):
    slow.wrap(RADIUS, abort_policy="hold")
    wait_for_pressure(slow)
    assert slow.cancel()
    result = slow.wait(PATIENCE)
    assert (result.outcome, result.reason) == (WrapOutcome.CANCELED, Reason.GRASP_CANCELED)
    assert result.pressure_command > 0.0
    assert not slow.cancel()


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
def test_a_goal_that_is_accepted_too_late_is_canceled(active, shared, monkeypatch):
    def silent(*_):
        raise NoAnswerError("grasp does not answer", 0.1)

    monkeypatch.setattr(spiral_gripper, "GLANCE", PATIENCE)
    with SpiralGripper(shared.get_namespace()) as hasty:
        hasty.wait_until_active(PATIENCE)
        with monkeypatch.context() as patch:
            patch.setattr(Connection, "answer", silent)
            with pytest.raises(NoAnswerError, match="may still start; it is canceled as soon as"):
                hasty.wrap(RADIUS, timeout=600.0)
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
    assert nowhere.status is nowhere.result() is nowhere.feedback() is None
    assert nowhere.is_done()
    assert not nowhere.cancel()
    with pytest.raises(RequestRefusedError, match="no wrap has been started"):
        nowhere.wait(1.0)
    for _ in range(2):
        nowhere.close()
    with pytest.raises(RequestRefusedError, match="this SpiralGripper is closed"):
        question(nowhere)


@pytest.mark.parametrize("bad", ["bad name!", "/1", "/a/", "~", "//a", None])
def test_a_bad_namespace_is_refused_without_a_warning(bad):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InvalidInputError, match="namespace must be a ROS namespace"):
            SpiralGripper(bad)


# What is called with a bad figure, and the name of the figure.
FIGURES = """
wrap radius; plan radius; wrap timeout; wait timeout; wait_until_active timeout; wrap overpressure
press pressure; plan payload; plan friction; wrap abort_policy
"""


@pytest.mark.parametrize("bad", [math.nan, -0.02, "0.02", True])
@pytest.mark.parametrize("row", FIGURES.strip().replace("\n", "; ").split("; "))
def test_a_bad_figure_is_refused_before_it_is_sent(nowhere, bad, row):
    method, name = row.split()
    radius = {"radius": RADIUS} if method in ("wrap", "plan") else {}
    for value in (bad, 0.0) if name in ("radius", "timeout") else (bad,):
        with pytest.raises(InvalidInputError, match=name):
            getattr(nowhere, method)(**radius | {name: value})
    with pytest.raises(InvalidInputError, match="answer_timeout"):
        SpiralGripper(answer_timeout=bad)
