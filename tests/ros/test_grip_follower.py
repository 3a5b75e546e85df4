# SPDX-License-Identifier: Apache-2.0
"""Grips from contact and friction, solved in the background."""

import math
from concurrent.futures import Future

import pytest
from core.grip_cases import DOWN, figures, table_of

from spiral_core import NotGrippableError
from spiral_gripper_ros.planning.grip_follower import (
    SETTLING,
    GripFollower,
    InUse,
)
from spiral_gripper_ros.planning.object_pose import SeenObject
from spiral_gripper_ros.planning.worker import EndedError

RATE = 1.5e4


class Bench:
    """A follower whose questions are answered here, one after the other."""

    def __init__(self, gripper):
        self.asked, self.now, self.gravity, self.rate, self.is_on = [], 100.0, DOWN, RATE, True
        table = table_of([0.01, 0.03], [figures()] * 2)
        self.follower = GripFollower(gripper, DOWN, table, None, self)

    def submit(self, solve, question, is_wanted):
        self.is_wanted = is_wanted
        self.asked.append((question, Future()))
        return self.asked[-1][1]

    def answer(self, outcome):
        future = self.asked[-1][1]
        (future.set_exception if isinstance(outcome, Exception) else future.set_result)(outcome)

    def follow(self, in_use=None, elapsed=0.1):
        self.now += elapsed
        return self.follower.follow(self.now, self.gravity, self.rate, in_use, is_on=self.is_on)

    def settle(self, in_use):
        """Follow an object until it is asked about; return the question."""
        self.follow(in_use)
        self.follow(in_use, SETTLING)
        return self.asked[-1][0]

    def known(self, radius, seen=None):
        return self.follower.answer(InUse(radius, seen), self.gravity, 5.0e4, 5.0e4)

    def force(self, radius, seen=None):
        answer = self.known(radius, seen)
        return answer and answer.normal_force


@pytest.fixture
def grips(gripper):
    return Bench(gripper)


def test_the_table_is_known_at_once_near_its_gravity_only(grips):
    assert grips.force(0.02) == pytest.approx(1.0)
    assert grips.force(0.0395) is None
    assert grips.follower.table(DOWN).window(0.01, 5.0e4) == (4.9e4, 6.0e4, 8.0e4)
    for angle, is_known in ((0.09, True), (0.12, False), (0.0, True)):
        grips.gravity = (9.80665 * math.cos(angle), 0.0, 9.80665 * math.sin(angle))
        grips.follow()
        assert (grips.follower.table(grips.gravity) is not None) is is_known
        assert (grips.force(0.02) is not None) is is_known
    assert not grips.asked


def test_settling_times_of_the_table_are_those_of_its_ramp(grips):
    for rate, is_known in ((RATE, True), (2.0 * RATE, False)):
        grips.rate = rate
        grips.follow()
        assert (not math.isnan(grips.known(0.02).settling)) is is_known


def test_a_defect_is_raised_once_and_not_asked_for_again_but_what_was_killed_is(grips):
    grips.settle(InUse(0.02))
    grips.answer(EndedError("its process was killed"))
    grips.follow(InUse(0.02))
    grips.answer(ZeroDivisionError("broken on purpose"))
    with pytest.raises(ZeroDivisionError):
        grips.follow(InUse(0.02))
    grips.follow(InUse(0.02))
    assert [question.radius for question, _ in grips.asked] == [0.02] * 2


def test_an_object_that_cannot_be_held_is_told_once(grips):
    refusal = NotGrippableError(0.02, "the tube passes by", 0.0, None)
    grips.settle(InUse(0.02))
    grips.answer(refusal)
    assert [grips.follow(InUse(0.02)) for _ in range(2)] == [True, False]
    assert grips.follower.found(InUse(0.02)) is refusal


def test_the_object_in_use_is_solved_once_it_has_settled(grips):
    grips.follow(InUse(0.03))
    grips.follow(InUse(0.02), 0.8 * SETTLING)
    grips.follow(InUse(0.0201), 0.8 * SETTLING)
    assert not grips.asked
    grips.follow(InUse(0.02), 0.3 * SETTLING)
    assert grips.asked[0][0].radius == 0.02
    grips.answer(figures(force=9.0))
    grips.settle(InUse(0.02))
    assert (grips.force(0.02), grips.force(0.021)) == pytest.approx((9.0, 1.0))
    assert len(grips.asked) == 1


def test_an_object_that_is_seen_is_solved_at_its_place_and_the_table_does_not_stand_for_it(grips):
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
    held = InUse(0.02)
    grips.settle(held)
    job = grips.asked[0][1]
    assert job.set_running_or_notify_cancel()  # it cannot be taken back
    for angle in range(20):
        grips.gravity = (9.80665 * math.cos(angle), 0.0, 9.80665 * math.sin(angle))
        grips.follow(held)
    grips.follow(held, SETTLING)
    assert len(grips.asked) == 1
    assert not grips.is_wanted()  # so that its process ends it
    job.set_result(figures())
    grips.follow(held)
    assert len(grips.asked) == 2
    assert grips.asked[1][0].gripper.gravity == grips.gravity
    assert grips.is_wanted()
    grips.follower.end()
    assert not grips.is_wanted()
    assert grips.asked[1][1].cancelled()


def test_switched_off_nothing_is_known_and_nothing_asked(grips):
    grips.settle(InUse(0.02))
    grips.is_on = False
    grips.follow(InUse(0.02))
    assert not grips.is_wanted()
    assert grips.force(0.02) is None
    grips.follow(InUse(0.02), 2.0 * SETTLING)
    assert len(grips.asked) == 1
    grips.is_on = True
    grips.follow(InUse(0.02))
    assert grips.force(0.02) == pytest.approx(1.0)
    assert len(grips.asked) == 2
