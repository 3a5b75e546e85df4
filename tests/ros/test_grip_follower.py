# SPDX-License-Identifier: Apache-2.0
"""Grips from contact and friction, solved in the background."""

import math

import pytest
from ros.grip_stand_ins import RANGE, Bench, figures

from spiral_core.errors import NotGrippableError
from spiral_gripper_ros.planning.grip_follower import (
    GRAVITY_TOLERANCE,
    SETTLING,
    InUse,
)
from spiral_gripper_ros.planning.object_pose import SeenObject


@pytest.fixture
def grips(gripper):
    return Bench(gripper)


def test_the_table_is_filled_from_the_middle_one_after_the_other(grips):
    assert grips.follower.answer(InUse(0.02), 5.0e4, 5.5e4) is None
    grips.fill()
    radii = [question.radius for question, _ in grips.pool.asked]
    middle = math.sqrt(0.00515 * 0.0388)
    assert radii[:3] == pytest.approx([middle, 0.00515, 0.0388])
    assert sorted(radii[3:]) == pytest.approx(
        [math.sqrt(0.00515 * middle), math.sqrt(0.0388 * middle)]
    )
    answer = grips.follower.answer(InUse(0.02), 5.0e4, 5.5e4)
    assert answer.away > 0.0
    assert not answer.at_pose
    assert grips.follower.answer(InUse(0.0395), 5.0e4, 5.5e4) is None
    grips.follow()
    assert len(grips.pool.asked) == 5


def test_a_radius_that_is_not_held_leaves_its_neighborhood_unknown(grips):
    grips.follow()
    grips.pool.answer(figures())
    for outcome in (figures(), NotGrippableError(0.0388, "not held", -1.0, None)):
        grips.follow()
        grips.pool.answer(outcome)
    grips.follow()
    assert grips.follower.answer(InUse(0.01), 5.0e4, 5.5e4) is None  # not compared yet
    grips.pool.answer(figures())
    grips.follow()
    assert len(grips.pool.asked) == 4
    assert grips.follower.answer(InUse(0.01), 5.0e4, 5.5e4) is not None
    assert grips.follower.answer(InUse(0.03), 5.0e4, 5.5e4) is None
    assert grips.follower.window(0.03, 5.0e4) is None
    assert grips.follower.window(0.01, 5.0e4) == pytest.approx((4.9e4, 6.0e4, 8.0e4))


def test_an_object_that_contact_never_wraps_is_refused_with_its_reason(grips):
    never = NotGrippableError(0.02, "the tube passes by", 0.0, None)
    grips.follow(InUse(0.02))
    grips.follow(InUse(0.02), elapsed=1.0)
    grips.pool.answer(figures())  # of the table, whose middle had been asked for
    grips.follow(InUse(0.02))
    grips.pool.answer(never)
    assert grips.follower.refusal(InUse(0.02)) is None
    assert grips.follow(InUse(0.02))
    assert grips.follower.refusal(InUse(0.0201)) is never
    assert grips.follower.refusal(InUse(0.021)) is None
    grips.follow(gravity=(0.0, 9.80665, 0.0))
    assert grips.follower.refusal(InUse(0.02)) is None


def test_a_defect_is_raised_once_and_not_asked_for_again(grips):
    grips.follow()
    grips.pool.answer(ZeroDivisionError("broken on purpose"))
    with pytest.raises(ZeroDivisionError):
        grips.follow()
    grips.follow()
    assert grips.pool.asked[1][0].radius != grips.pool.asked[0][0].radius


def test_the_object_in_use_is_solved_once_it_has_settled(grips):
    grips.fill()
    grips.follow(InUse(0.02))
    grips.follow(InUse(0.0201), elapsed=0.8 * SETTLING)
    assert len(grips.pool.asked) == 5
    grips.follow(InUse(0.02), elapsed=SETTLING)
    assert grips.pool.asked[5][0].radius == 0.02
    grips.pool.answer(figures(force=9.0))
    grips.follow(InUse(0.02))
    assert grips.follower.answer(InUse(0.02), 5.0e4, 5.0e4).normal_force == pytest.approx(9.0)
    assert grips.follower.answer(InUse(0.021), 5.0e4, 5.0e4).normal_force == pytest.approx(1.0)
    grips.follow(InUse(0.02))
    assert len(grips.pool.asked) == 6


def test_an_object_that_is_seen_is_solved_at_its_place_and_the_table_does_not_stand_for_it(grips):
    grips.fill()
    seen = SeenObject((0.1, 0.02, 0.0), (0.0, 0.0, 1.0), 0.0)
    grips.follow(InUse(0.02, seen))
    grips.follow(InUse(0.02, seen), elapsed=SETTLING)
    assert grips.pool.asked[5][0].pose == (seen.center, seen.axis)
    assert grips.follower.answer(InUse(0.02, seen), 5.0e4, 5.0e4) is None
    grips.pool.answer(figures())
    grips.follow(InUse(0.02, seen))
    answer = grips.follower.answer(InUse(0.02, seen), 5.0e4, 5.0e4)
    assert answer.at_pose
    turned = SeenObject(seen.center, (0.0, 0.0, -1.0), 5.0)
    assert grips.follower.answer(InUse(0.02, turned), 5.0e4, 5.0e4) is not None
    moved = SeenObject((0.1, 0.023, 0.0), seen.axis, 5.0)
    assert grips.follower.answer(InUse(0.02, moved), 5.0e4, 5.0e4) is None


def test_another_gravity_makes_another_table(grips):
    grips.fill()
    grips.follow(gravity=(9.80665 - 0.9 * GRAVITY_TOLERANCE, 0.0, 0.0))
    assert grips.follower.answer(InUse(0.02), 5.0e4, 5.5e4) is not None
    sideways = (0.0, 0.0, -9.80665)
    grips.follow(gravity=sideways)
    assert grips.follower.answer(InUse(0.02), 5.0e4, 5.5e4) is None
    grips.follow(gravity=sideways, elapsed=SETTLING)
    assert grips.pool.asked[-1][0].gripper.gravity == sideways


def test_while_the_arm_turns_nothing_is_asked_and_no_question_waits_behind_another(grips):
    grips.follow()
    job = grips.pool.asked[0][1]
    assert job.set_running_or_notify_cancel()  # it cannot be taken back
    for angle in range(20):
        turned = (9.80665 * math.cos(angle), 0.0, 9.80665 * math.sin(angle))
        grips.follow(gravity=turned)
    grips.follow(gravity=turned, elapsed=SETTLING)
    assert len(grips.pool.asked) == 1
    assert not grips.pool.is_wanted()  # so that its process ends it
    job.set_result(figures())
    grips.follow(gravity=turned)
    assert len(grips.pool.asked) == 2
    assert grips.pool.asked[1][0].gripper.gravity == turned
    assert grips.pool.is_wanted()
    grips.follower.end()
    assert not grips.pool.is_wanted()
    assert grips.pool.asked[1][1].cancelled()


@pytest.mark.parametrize(("count", "radii"), [(0, RANGE), (1, RANGE), (3, (0.0, math.inf))])
def test_without_a_table_only_the_object_in_use_is_solved(gripper, count, radii):
    bench = Bench(gripper, count)
    bench.follow(radii=radii)
    assert not bench.pool.asked
    bench.follow(InUse(0.02), radii=radii)
    bench.follow(InUse(0.02), radii=radii, elapsed=2.0 * SETTLING)
    assert len(bench.pool.asked) == (0 if count == 0 else 1)
    if count:
        bench.pool.answer(figures())
        bench.follow(InUse(0.02), radii=radii)
        assert bench.follower.entry(InUse(0.02)) is not None
