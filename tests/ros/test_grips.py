# SPDX-License-Identifier: Apache-2.0
"""What control loop, messages and clients make of grips."""

import math
import time
from concurrent.futures import Future
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from rclpy.parameter import Parameter
from ros.grip_stand_ins import DOWN, figures
from ros.harness import DEADLINE, all_finite, deliver, plan_request
from std_msgs.msg import Float64, Header

from spiral_core import NotGrippableError, WrapRegime
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_msgs.srv import PlanWrap
from spiral_gripper_ros.actions.gripper_command import contact_force
from spiral_gripper_ros.client.goals import result_of_wrap
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.states import Reason, Refusal, State
from spiral_gripper_ros.control.target import Target
from spiral_gripper_ros.messages.grip import grip_to_msg
from spiral_gripper_ros.messages.markers import scene_to_msg
from spiral_gripper_ros.node.plan_service import answer_plan_wrap
from spiral_gripper_ros.planning.grip_figures import GripQuestion
from spiral_gripper_ros.planning.grip_follower import InUse
from spiral_gripper_ros.planning.grip_table import GripEntry
from spiral_gripper_ros.planning.refining_table import RefiningTable
from spiral_gripper_ros.tools.commands import grip_lines


@pytest.fixture
def known(node):
    """A node in this process whose table has a grip at either end of the range."""
    loaded = node.runtime.loaded
    low, high = loaded.planner.radius_range
    follower = loaded.grips
    follower._count, follower._table = 0, RefiningTable((low, high))
    for radius in (low, high, math.sqrt(low * high)):
        tip = loaded.planner.plan(min(max(radius, 1.001 * low), 0.999 * high)).pressure
        grip = figures(tip, curling=1.05 * tip, loss=1.3 * tip)
        follower._table = follower._table.added(radius, GripEntry(grip, node.runtime.now()))
    node.told = {}
    node.runtime.outputs.publish = node.told.__setitem__
    return node


def follow(node, radius, **ratio):
    node.set_parameters([Parameter(f"grip.{name}", value=x) for name, x in ratio.items()])
    deadline = time.monotonic() + DEADLINE
    while True:
        deliver(node, "object_radius", Float64(data=radius))
        node._timer.callback()
        seen = node.runtime.control.snapshot()
        if seen.pressure_target and seen.pressure_command == seen.pressure_target:
            return seen
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_the_default_grip_stays_within_the_window(known):
    seen = follow(known, 0.02, ratio=1.2)
    assert seen.pressure_target == pytest.approx(1.05 * seen.plan.pressure, rel=1e-6)
    assert seen.wrapped
    (grip,) = known.told["wrap"].grip
    assert list(grip.onset_curling) == pytest.approx([seen.pressure_target])
    assert grip.holding_force_away > grip.holding_force_towards > 0.0
    assert not grip.payload_margin
    known.set_parameters([Parameter("grip.payload", value=1.0)])
    known._timer.callback()
    (grip,) = known.told["wrap"].grip
    weight = grip.holding_force_down[0] - grip.payload_margin[0]
    assert weight == pytest.approx(9.80665)
    assert all_finite(known.told["status"], known.told["wrap"])


@pytest.mark.parametrize(("onset", "curling", "part"), [(1.02, 1.1, 1.02), (0.8, 0.9, 0.9)])
def test_the_pressure_lies_within_the_window(known, onset, curling, part):
    tip = known.runtime.loaded.planner.plan(0.02).wrap.pressure
    widen(known, onset, curling)
    seen = follow(known, 0.02, ratio=1.0)
    assert seen.pressure_target == pytest.approx(part * tip, rel=1e-3)
    assert seen.plan.wrap.pressure == tip
    answer = answered(known)
    assert answer.figures[0].pressure == seen.pressure_target


def test_unless_told_a_ratio_the_node_commands_what_the_grip_recommends(known):
    tip = known.runtime.loaded.planner.plan(0.02).wrap.pressure
    widen(known, 0.98, 1.08)
    known.set_parameters([Parameter("grip.ratio", value=math.nan)])
    seen = follow(known, 0.02)
    assert seen.pressure_target == pytest.approx(1.03 * tip, rel=1e-3)
    assert answered(known).figures[0].pressure == seen.pressure_target


def test_a_small_tilt_leaves_the_window_known(known):
    widen(known, 0.98, 1.08)
    before = follow(known, 0.02, ratio=math.nan)
    tilt = math.radians(2.0)
    known.runtime.loaded.mount.want((9.80665 * math.cos(tilt), 9.80665 * math.sin(tilt), 0.0), 0.0)
    deadline = time.monotonic() + DEADLINE
    while (seen := known.runtime.control.snapshot()).plan is before.plan:
        known.runtime.take_planner()
        assert time.monotonic() < deadline
    assert seen.plan.wrap.pressure != before.plan.wrap.pressure
    assert seen.plan.recommended is not None
    assert seen.pressure_target == pytest.approx(1.03 * seen.plan.laid.pressure, rel=1e-3)


def widen(node, onset, curling):
    """Let the table's wraps begin and curl at these multiples of the tip criterion's pressure."""
    follower = node.runtime.loaded.grips
    for entry in follower._table._entries.values():
        tip = entry.figures.tip_pressure
        grip = replace(
            entry.figures,
            onset_wrap=onset * tip,
            onset_curling=curling * tip,
            highest_good=curling * tip,
        )
        object.__setattr__(entry, "figures", grip)


def test_a_radius_that_contact_never_wraps_is_refused_once_that_is_known(known):
    seen = follow(known, 0.02)
    held = seen.pressure_command
    never = NotGrippableError(0.02, "the tube passes by", 0.0, None)
    known.runtime.loaded.grips._job = InUse(0.02), answered_job(never)
    known._timer.callback()
    seen = known.runtime.control.snapshot()
    assert (seen.state, seen.refusal.reason) == (State.HOLDING, Reason.NOT_CERTIFIED)
    assert "the tube passes by" in seen.refusal.text
    assert seen.pressure_command == held
    assert not seen.wrapped
    deliver(known, "object_radius", Float64(data=0.02))
    assert known.runtime.control.snapshot().state is State.HOLDING
    answer = answered(known)
    assert not answer.success
    assert "the tube passes by" in answer.message
    deliver(known, "object_radius", Float64(data=0.022))
    assert known.runtime.control.snapshot().state is State.TRACKING


def answered_job(error):
    job = Future()
    job.set_exception(error)
    return job


def test_an_overpressure_that_loses_the_grip_is_refused_and_changes_nothing(known):
    plan = known.runtime.loaded.planner.plan(0.02)
    assert plan.loss == pytest.approx(1.3 * plan.pressure)
    target, planner, limits = Target(), known.runtime.loaded.planner, known.runtime.limits
    assert target.set_radius(0.02, planner, limits, 0.299 * plan.pressure) is None
    aimed = target.pressure(limits.pressure_cap)
    refused = target.set_radius(0.021, planner, limits, 0.31 * plan.pressure)
    assert refused.reason is Reason.INVALID_REQUEST
    assert "grip is lost at" in refused.text
    assert target.pressure(limits.pressure_cap) == aimed == pytest.approx(1.299 * plan.pressure)


def test_a_plan_with_an_overpressure_that_loses_the_grip_is_refused(known):
    plan = known.runtime.loaded.planner.plan(0.02)
    answers = [answered(known, overpressure=part * plan.pressure) for part in (0.299, 0.301)]
    assert [answer.success for answer in answers] == [True, False]
    assert answers[1].reason == Reason.INVALID_REQUEST
    assert "grip is lost at" in answers[1].message
    assert answers[0].figures[0].contact_length == answers[0].grip[0].contact_length > 0.0


def answered(node, **fields):
    """Return the answer of `plan_wrap` about an object of 20 mm, which needs no worker."""
    context = node._served._context(node.runtime.loaded)
    request = plan_request([0.02], **fields)
    return answer_plan_wrap(request, PlanWrap.Response(), context).plans[0]


def test_contact_and_effort_are_those_of_the_grip_once_it_is_known(known):
    seen = follow(known, 0.02, ratio=1.04)
    told = known.told["wrap"]
    assert told.plan[0].contact_length == told.grip[0].contact_length > 0.0
    planner = known.runtime.loaded.planner
    force = contact_force(seen.plan, planner, seen.pressure_target)
    assert force == pytest.approx(told.grip[0].normal_force)
    by_tip = planner.line_force(seen.plan.wrap, seen.pressure_target)
    assert force != pytest.approx(by_tip * seen.plan.wrap.contact_length, rel=0.01)


def test_a_goals_feedback_says_how_long_the_tube_will_swing(known):
    follow(known, 0.02)
    report = SimpleNamespace(progress=1.0, elapsed=1.0)
    feedback = known.goals._servers[0].feedback(None, report)
    assert feedback.settling_time == known.told["wrap"].grip[0].settling_time
    assert feedback.settling_time[0] > 0.0


def test_grips_are_solved_for_the_ramp_that_the_node_has(known, monkeypatch):
    asked = []
    monkeypatch.setattr(known.runtime.background, "solve_grip", lambda *asks: asked.append(asks))
    known.set_parameters([Parameter("pressure.rate_up", value=2.0e4)])
    known.runtime._solve_grip(GripQuestion(known.runtime.loaded.gripper, 0.02), bool)
    assert asked[0][0].rate == 2.0e4


def test_past_the_loss_nothing_is_wrapped(known):
    runtime, follower = known.runtime, known.runtime.loaded.grips
    seen = follow(known, 0.02)
    goal = GraspGoal(0.02, overpressure=0.4 * seen.plan.pressure)
    table, follower._table = follower._table, None  # it is solved after the goal has been accepted
    answer = runtime.control.start_grasp(runtime.now(), goal, runtime.loaded.planner)
    assert not isinstance(answer, Refusal)
    follower._table = table
    deadline = time.monotonic() + DEADLINE
    while runtime.control.snapshot().pressure_command < 1.31 * seen.plan.pressure:
        assert time.monotonic() < deadline
        known._timer.callback()
        time.sleep(0.01)
    known._timer.callback()
    assert not runtime.control.snapshot().wrapped
    assert known.told["wrap"].grip[0].holding_force_away == 0.0


def test_where_the_object_is_seen_the_regime_is_that_of_the_contact(known):
    runtime = known.runtime
    known.set_parameters([Parameter("object_pose.timeout", value=600.0)])
    seen = follow(known, 0.02)
    assert not known.told["wrap"].regime_from_contact
    runtime.objects.offer((0.1, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), runtime.now(), 0.0, 600.0)
    known._timer.callback()
    assert not known.told["wrap"].grip  # the table does not stand for a place of its own
    place = InUse(0.02, runtime.seen_object())
    grip = figures(0.8 * seen.plan.pressure, curling=0.9 * seen.plan.pressure, loss=None)
    runtime.loaded.grips._in_use = (place, GripEntry(grip, runtime.now()))
    known._timer.callback()
    assert known.told["wrap"].regime_from_contact
    assert known.told["wrap"].grip[0].at_pose
    assert known.told["status"].regime == GripStatus.REGIME_CURLING
    scene = known._display._scene(runtime.loaded, runtime.control.snapshot())
    assert scene.regime is WrapRegime.CURLING
    assert scene.placement.center == (0.1, 0.0, 0.0)


def test_the_tube_is_drawn_on_the_object_once_its_grip_is_solved(known):
    runtime = known.runtime
    seen = follow(known, 0.02)
    free = known._display._scene(runtime.loaded, seen)
    grip = figures(seen.plan.pressure, curling=None, loss=None)
    runtime.loaded.grips._in_use = (InUse(0.02), GripEntry(grip, runtime.now()))
    scene = known._display._scene(runtime.loaded, seen)
    assert scene.commanded.positions[0, 0] == pytest.approx(seen.pressure_command)
    assert scene.placement.center == (0.1, 0.0, 0.0)
    assert free.placement.center != scene.placement.center
    message = scene_to_msg(scene, 50, 1.0, Header())
    assert len(message.markers[0].points) == 3
    assert all_finite(*message.markers)


def test_the_message_says_it_all_and_every_number_is_finite():
    answer = GripEntry(figures(curling=None), 3.0).answer(5.25e4, at_pose=True)
    (message,) = grip_to_msg(answer, 10.0, 0.02, DOWN)
    assert all_finite(message)
    assert (message.at_pose, message.age) == (True, 7.0)
    assert (list(message.onset_curling), list(message.loss)) == ([], [8.0e4])
    assert list(message.holding_force_down) == pytest.approx([0.5])
    assert list(message.payload_margin) == pytest.approx([0.5 - 0.02 * 9.80665])
    assert list(grip_to_msg(answer, 10.0, 0.0, DOWN)[0].payload_margin) == pytest.approx([0.5])
    assert not grip_to_msg(answer, 10.0, None, DOWN)[0].payload_margin
    assert not grip_to_msg(answer, 10.0, None, (0.0, 0.0, 0.0))[0].holding_force_down
    assert not grip_to_msg(None, 10.0, 0.02, DOWN)


def test_no_time_to_settle_differs_from_one_that_is_not_known():
    for settling, told in ((0.0, [0.0]), (math.nan, [])):
        known = replace(figures(), settling=np.full(3, settling))
        answer = GripEntry(known, 3.0).answer(5.25e4, at_pose=True)
        assert list(grip_to_msg(answer, 10.0, 0.0, DOWN)[0].settling_time) == told
    lost = GripEntry(figures(), 3.0).answer(8.0e4, at_pose=True)
    assert not grip_to_msg(lost, 10.0, 0.0, DOWN)[0].settling_time


def test_a_shell_is_told_the_grip_in_lines():
    answer = GripEntry(figures(curling=None), 3.0).answer(5.25e4, at_pose=False)
    text = "\n".join(grip_lines(grip_to_msg(answer, 10.0, 0.0, DOWN)[0]))
    assert "110 mm of tube, 1.1 N in all" in text
    assert "from 49 kPa" in text
    assert "none up to the limit" in text
    assert "at 80 kPa" in text
    assert "1 N away from the base, 0.1 N towards it" in text
    assert "7 s ago, for friction 0.3" in text
    assert "not known" in grip_lines(None)[0]


@pytest.mark.parametrize("known", [True, False])
def test_a_python_program_is_told_the_forces_or_that_they_are_not_known(known):
    result = Grasp.Result(success=True)
    if known:
        answer = GripEntry(figures(), 3.0).answer(5.25e4, at_pose=False)
        result.grip = grip_to_msg(answer, 10.0, 0.0, DOWN)
    told = result_of_wrap(SimpleNamespace(status=GoalStatus.STATUS_SUCCEEDED, result=result))
    expected = (pytest.approx(1.0), pytest.approx(0.1)) if known else (None, None)
    assert (told.holding_force_away, told.holding_force_towards) == expected
