# SPDX-License-Identifier: Apache-2.0
"""The Python client, against a node in a process of its own, and where something is wrong."""

import math
from dataclasses import replace

import pytest
from ros.control_bench import rows
from ros.harness import DEADLINE, NODE, all_finite, wait_until
from ros.records import agrees, told

from spiral_core import InvalidInputError
from spiral_gripper_msgs.msg import PlannedWrap
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


def test_wrap_wait_rearm_release_and_press(grip, active):
    active.wrap(0.02)
    grip.wrap(None)  # the radius that is followed
    results = [grip.wait(DEADLINE)]
    assert grip.press(3.0e4)
    results.append(grip.wait(DEADLINE))
    active.change("pressure.settle_time", 2.0)
    active.regulator = lambda pressure: pressure
    active.wait_until(lambda: active.status.measured_pressure, "measurement")
    assert grip.wrap(0.02)
    while not grip.is_done():
        active.spin(0.1)
    results.append(grip.wait(DEADLINE))
    assert results[-1] == grip.result()
    agrees("results", told(*(replace(one, elapsed=0.0) for one in results)))
    wait_until(lambda: grip.status.state == State.GRASPING)
    assert all_finite(grip.feedback(), grip.status)
    with pytest.raises(RequestRefusedError, match="rearm is refused"):
        grip.rearm()
    assert grip.planned.plan
    active.release()
    assert active.wait_for_state(State.RELEASED)
    wait_until(lambda: not grip.planned.plan)
    grip.release()
    wait_until(lambda: grip.status.state == State.RELEASED)
    grip.rearm()


def test_polling_sees_the_way_a_short_wait_ends_nothing_and_cancel_holds_if_it_is_to(
    slow, monkeypatch
):
    slow.wrap(0.02, timeout=600.0, abort_policy="hold")
    monkeypatch.setattr(spiral_gripper, "SILENCE", DEADLINE)
    with pytest.raises(NoAnswerError, match="it goes on") as caught:
        slow.wait(0.2)
    assert caught.value.timeout == 0.2
    wait_until(lambda: not slow.is_done() and slow.feedback() and slow.feedback().progress > 0.0)
    assert slow.result() is None
    assert slow.cancel()
    result = slow.wait(DEADLINE)
    assert (result.outcome, result.measured_pressure) == (WrapOutcome.CANCELED, None)
    assert result.pressure_command > 0.0
    assert not slow.cancel()


def test_a_plan_is_asked_with_everything_that_the_service_takes(nowhere, monkeypatch):
    asked, answer = [], PlanWrap.Response(plans=[PlannedWrap()])
    monkeypatch.setattr(Connection, "call", lambda *question: asked.append(question) or answer)
    nowhere.plan(0.02, 2.0e3, payload=0.1, friction=0.5, compute_grip=True)
    ((*_, request, patience),) = asked
    agrees("asked", f"{told(request)}{patience}")


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("error", [KeyboardInterrupt(), NoAnswerError("no answer", 0.1)])
def test_a_goal_whose_answer_comes_too_late_is_canceled(active, shared, monkeypatch, error):
    def silent(*_):
        raise error

    monkeypatch.setattr(spiral_gripper, "GLANCE", DEADLINE)
    with SpiralGripper(shared.get_namespace()) as hasty:
        hasty.wait_until_active(DEADLINE)
        with monkeypatch.context() as patch:
            patch.setattr(Connection, "answer", silent)
            with pytest.raises(type(error), match=r"^$|may still start; it is canceled as soon as"):
                hasty.wrap(0.02, timeout=600.0)
        assert isinstance(error, NoAnswerError) or hasty.cancel()
    assert active.wait_for_state(State.RELEASED, Reason.GRASP_CANCELED)


def test_an_inactive_node_is_told_from_one_that_does_not_exist(active, connection):
    assert active.transition("deactivate")
    with pytest.raises(NoAnswerError, match="not active") as caught:
        connection.wait_until_active(0.5)
    assert f"ros2 lifecycle set {active.get_namespace()}/{NODE} configure" in str(caught.value)


def test_without_a_node_or_a_wrap_the_error_says_how_to_start_one(nowhere, namespace):
    start = f"namespace {namespace}(.|\n)*spiral_gripper_node --ros-args -r __ns:={namespace}"
    questions = ("wait_until_active 0.2", "wrap 0.02", "plan 0.02", "release", "rearm")

    def ask(error, match):
        for name, *figures in map(str.split, questions):
            with pytest.raises(error, match=match):
                getattr(nowhere, name)(*map(float, figures))

    ask(NoAnswerError, start)
    assert nowhere.status is nowhere.result() is nowhere.feedback() is None
    assert nowhere.is_done() is not nowhere.cancel()
    with pytest.raises(RequestRefusedError, match="no wrap has been started"):
        nowhere.wait(1.0)
    for _ in range(2):
        nowhere.close()
    ask(RequestRefusedError, "this SpiralGripper is closed")


@pytest.mark.parametrize("bad", ["bad name!", "/a/", "~", None])
def test_a_bad_namespace_is_refused_without_a_warning(bad):
    with pytest.raises(InvalidInputError, match="namespace must be a ROS namespace"):
        SpiralGripper(bad)


# What is called with a bad figure, and the name of the figure.
FIGURES = """
wrap radius
plan radius
wrap timeout
wait timeout
wait_until_active timeout
wrap overpressure
press pressure
plan payload
plan friction
wrap abort_policy
"""


@pytest.mark.parametrize("row", rows(FIGURES))
def test_a_bad_figure_is_refused_before_it_is_sent(nowhere, row):
    method, name = row.split()
    radius = {"radius": 0.02} if method in ("wrap", "plan") else {}
    zero = [0.0] * (name in ("radius", "timeout"))
    for bad in (math.nan, -0.02, "0.02", True, *zero):
        with pytest.raises(InvalidInputError, match=name):
            getattr(nowhere, method)(**radius | {name: bad})
        with pytest.raises(InvalidInputError, match="answer_timeout"):
            SpiralGripper(answer_timeout=bad)
