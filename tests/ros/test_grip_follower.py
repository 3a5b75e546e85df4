# SPDX-License-Identifier: Apache-2.0
"""Grips from contact and friction, solved in the background."""

import math
from concurrent.futures import Future

import pytest
from ros.grip_stand_ins import DOWN, figures

from spiral_gripper_ros.planning.grip_follower import (
    SETTLING,
    GripFollower,
    InUse,
)
from spiral_gripper_ros.planning.object_pose import SeenObject
from spiral_gripper_ros.planning.worker import EndedError

RANGE = (0.005, 0.04)


class Bench:
    """A follower whose questions are answered here, one after the other."""

    def __init__(self, gripper):
        self.asked, self.now, self.count, self.radii, self.gravity = [], 100.0, 3, RANGE, DOWN
        self.follower = GripFollower(gripper, DOWN, None, self)

    def submit(self, solve, question, is_wanted):
        self.is_wanted = is_wanted
        self.asked.append((question, Future()))
        return self.asked[-1][1]

    def answer(self, outcome):
        future = self.asked[-1][1]
        (future.set_exception if isinstance(outcome, Exception) else future.set_result)(outcome)

    def follow(self, in_use=None, elapsed=0.1):
        self.now += elapsed
        return self.follower.follow(self.now, self.gravity, self.radii, self.count, in_use)

    def fill(self, *outcomes):
        """Answer until the table is done: its radii, and the middle of each two."""
        self.follow()
        for outcome in outcomes or [figures()] * 5:
            self.answer(outcome)
            self.follow()

    def settle(self, in_use):
        """Follow an object until it is asked about; return the question."""
        self.follow(in_use)
        self.follow(in_use, SETTLING)
        return self.asked[-1][0]

    def force(self, radius, seen=None):
        answer = self.follower.answer(InUse(radius, seen), 5.0e4, 5.0e4)
        return answer and answer.normal_force


@pytest.fixture
def grips(gripper):
    return Bench(gripper)


def test_the_table_is_filled_from_the_middle_one_after_the_other(grips):
    assert grips.force(0.02) is None
    grips.fill()
    low, high = 0.00515, 0.0388
    middle, *others = (question.radius for question, _ in grips.asked)
    assert middle == pytest.approx(math.sqrt(low * high))
    between = [math.sqrt(low * middle), math.sqrt(high * middle)]
    assert sorted(others) == pytest.approx(sorted([low, high, *between]))
    assert grips.force(0.02) > 0.0
    assert grips.follower.window(0.01, 5.0e4) == pytest.approx((4.9e4, 6.0e4, 8.0e4))
    assert grips.force(0.0395) is None


def test_a_defect_is_raised_once_and_not_asked_for_again_but_what_was_killed_is(grips):
    grips.fill(EndedError("its process was killed"))
    grips.answer(ZeroDivisionError("broken on purpose"))
    with pytest.raises(ZeroDivisionError):
        grips.follow()
    grips.follow()
    killed, broken, other = (question.radius for question, _ in grips.asked)
    assert killed == broken != other


def test_the_object_in_use_is_solved_once_it_has_settled(grips):
    grips.fill()
    grips.follow(InUse(0.03))
    grips.follow(InUse(0.02), 0.8 * SETTLING)
    grips.follow(InUse(0.0201), 0.8 * SETTLING)
    assert len(grips.asked) == 5
    grips.follow(InUse(0.02), 0.3 * SETTLING)
    assert grips.asked[5][0].radius == 0.02
    grips.answer(figures(force=9.0))
    grips.settle(InUse(0.02))
    assert (grips.force(0.02), grips.force(0.021)) == pytest.approx((9.0, 1.0))
    assert len(grips.asked) == 6


def test_an_object_that_is_seen_is_solved_at_its_place_and_the_table_does_not_stand_for_it(grips):
    grips.fill()
    seen = SeenObject((0.1, 0.02, 0.0), (0.0, 0.0, 1.0), 0.0)
    assert grips.settle(InUse(0.02, seen)).pose == (seen.center, seen.axis)
    assert grips.force(0.02, seen) is None
    grips.answer(figures())
    grips.follow(InUse(0.02, seen))
    for center, axis, is_known in (
        (seen.center, (0.0, 0.0, -1.0), True),
        (seen.center, (0.0, 0.06, 0.998), False),
        ((0.1, 0.023, 0.0), seen.axis, False),
    ):
        assert (grips.force(0.02, SeenObject(center, axis, 5.0)) is not None) is is_known


def test_while_the_arm_turns_nothing_is_asked_and_no_question_waits_behind_another(grips):
    grips.follow()
    job = grips.asked[0][1]
    assert job.set_running_or_notify_cancel()  # it cannot be taken back
    for angle in range(20):
        grips.gravity = (9.80665 * math.cos(angle), 0.0, 9.80665 * math.sin(angle))
        grips.follow()
    grips.follow(elapsed=SETTLING)
    assert len(grips.asked) == 1
    assert not grips.is_wanted()  # so that its process ends it
    job.set_result(figures())
    grips.follow()
    assert len(grips.asked) == 2
    assert grips.asked[1][0].gripper.gravity == grips.gravity
    assert grips.is_wanted()
    grips.follower.end()
    assert not grips.is_wanted()
    assert grips.asked[1][1].cancelled()


@pytest.mark.parametrize(("count", "radii"), [(0, RANGE), (1, RANGE), (3, (0.0, math.inf))])
def test_without_a_table_only_the_object_in_use_is_solved(grips, count, radii):
    grips.count, grips.radii = count, radii
    grips.follow(elapsed=SETTLING)
    assert not grips.asked
    for _ in range(2):
        grips.follow(InUse(0.02), SETTLING)
    assert [question.radius for question, _ in grips.asked] == [0.02] * (count > 0)
