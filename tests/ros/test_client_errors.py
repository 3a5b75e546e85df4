# SPDX-License-Identifier: Apache-2.0
"""The Python client where something is wrong: an argument, the node, the time."""

import math
import time
import warnings

import pytest
from ros.client_harness import PATIENCE, QUESTIONS, RADIUS, wait_until
from ros.harness import NODE

from spiral_core import InvalidInputError
from spiral_core.errors import SpiralError
from spiral_gripper_ros.client import (
    NoAnswerError,
    RequestRefusedError,
    SpiralGripper,
    spiral_gripper,
)
from spiral_gripper_ros.control.states import Reason, State


def test_a_wait_that_is_too_short_says_so_and_the_wrap_goes_on(slow, monkeypatch):
    slow.wrap(RADIUS, timeout=600.0)
    monkeypatch.setattr(spiral_gripper, "SILENCE", PATIENCE)
    with pytest.raises(NoAnswerError, match="it goes on") as caught:
        slow.wait(0.2)
    assert caught.value.timeout == 0.2
    assert slow.result() is None
    wait_until(lambda: slow.status.state == State.GRASPING)
    assert slow.cancel()


@pytest.mark.usefixtures("slow")
def test_a_goal_that_is_accepted_too_late_is_canceled(active, shared, monkeypatch):
    with SpiralGripper(shared.get_namespace(), answer_timeout=0.1) as hasty:
        hasty.wait_until_active(PATIENCE)
        wrap_and_hear_nothing(hasty, monkeypatch)
        assert hasty.is_done()
        active.wait_for_state(State.GRASPING)

        def has_ended():
            assert hasty.status is not None  # a call, within which it hears of the goal
            active.spin(0.05)
            return active.status.state != State.GRASPING

        wait_until(has_ended)
    assert active.wait_for_state(State.RELEASED, Reason.GRASP_CANCELED)


@pytest.mark.usefixtures("slow")
def test_closing_waits_a_moment_for_a_late_answer(active, shared, monkeypatch):
    monkeypatch.setattr(spiral_gripper, "GLANCE", PATIENCE)
    with SpiralGripper(shared.get_namespace(), answer_timeout=0.1) as hasty:
        hasty.wait_until_active(PATIENCE)
        wrap_and_hear_nothing(hasty, monkeypatch)
    assert active.wait_for_state(State.RELEASED, Reason.GRASP_CANCELED)


def wrap_and_hear_nothing(gripper, monkeypatch):
    """Send a goal whose answer is not heard in time."""
    with monkeypatch.context() as patch:
        patch.setattr(gripper._link._executor, "spin_once", time.sleep)
        with pytest.raises(NoAnswerError, match="it may still start; it is canceled as soon as"):
            gripper.wrap(RADIUS, timeout=600.0)


@pytest.mark.parametrize("policy", ["keep", "", 1, []])
def test_another_abort_policy_is_refused_with_the_choices(nowhere, policy):
    with pytest.raises(InvalidInputError, match='abort_policy must be "vent", "hold" or None'):
        nowhere.wrap(RADIUS, abort_policy=policy)


def test_closing_twice_is_harmless_and_a_closed_one_says_so(namespace):
    gripper = SpiralGripper(namespace)
    gripper.close()
    gripper.close()
    for question in (*QUESTIONS, lambda gripper: gripper.status):
        with pytest.raises(RequestRefusedError, match="this SpiralGripper is closed"):
            question(gripper)


@pytest.mark.parametrize("bad", ["bad name!", "/1", "/a/", "~", "//a", None, 3])
def test_a_bad_namespace_is_refused_without_a_warning(bad):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InvalidInputError, match="namespace must be a ROS namespace"):
            SpiralGripper(bad)


def test_a_node_that_is_gone_is_noticed_while_polling(slow, monkeypatch):
    slow.wrap(RADIUS, timeout=600.0)
    monkeypatch.setattr(slow._grasp, "server_is_ready", lambda: False)
    monkeypatch.setattr(slow._vent, "service_is_ready", lambda: False)
    with pytest.raises(NoAnswerError, match="no gripper's node answers"):
        slow.is_done()
    monkeypatch.undo()
    assert slow.cancel()


@pytest.mark.parametrize("bad", [math.nan, math.inf, 0.0, -0.02, "0.02", True])
def test_a_bad_figure_is_refused_before_it_is_sent(nowhere, bad):
    with pytest.raises(InvalidInputError, match="radius"):
        nowhere.wrap(bad)
    with pytest.raises(InvalidInputError, match="radius"):
        nowhere.plan(bad)
    with pytest.raises(InvalidInputError, match="timeout"):
        nowhere.wrap(RADIUS, timeout=bad)
    with pytest.raises(InvalidInputError, match="timeout"):
        nowhere.wait(bad)
    with pytest.raises(InvalidInputError, match="timeout"):
        nowhere.wait_until_active(bad)
    with pytest.raises(InvalidInputError, match="answer_timeout"):
        SpiralGripper(answer_timeout=bad)
    if bad != 0.0:
        with pytest.raises(InvalidInputError, match="overpressure"):
            nowhere.wrap(RADIUS, overpressure=-1.0 if bad == 1.0 else bad)


@pytest.mark.parametrize("question", QUESTIONS)
def test_where_there_is_no_node_the_error_says_where_and_how_to_start_one(nowhere, question):
    with pytest.raises(NoAnswerError) as caught:
        question(nowhere)
    text = str(caught.value)
    namespace = nowhere._link.node.get_namespace()
    assert f"no gripper's node answers in the namespace {namespace}" in text
    assert f"spiral_gripper_node --ros-args -r __ns:={namespace}" in text
    assert isinstance(caught.value, SpiralError)
    assert isinstance(caught.value, TimeoutError)
    assert nowhere.status is None


def test_an_inactive_node_is_told_from_one_that_does_not_exist(active, connection):
    assert active.transition("deactivate")
    with pytest.raises(NoAnswerError, match="not active") as caught:
        connection.wait_until_active(0.5)
    assert f"ros2 lifecycle set {active.get_namespace()}/{NODE} configure" in str(caught.value)
