# SPDX-License-Identifier: Apache-2.0
"""Grips from contact and friction, solved in the background."""

import math
from concurrent.futures import Future

import pytest
from core.grip_cases import DOWN, figures, table_of

from spiral_core import NotGrippableError
from spiral_gripper_ros.planning.grip_follower import SETTLING, GripFollower, InUse
from spiral_gripper_ros.planning.object_pose import SeenObject
from spiral_gripper_ros.planning.worker import EndedError

HELD, RATE = InUse(0.02), 1.5e4


class Bench:
    """A follower whose questions are answered here, one after the other."""

    def __init__(self, gripper):
        self.asked, self.now, self.gravity, self.rate, self.is_on = [], 100.0, DOWN, RATE, True
        table = table_of([0.01, 0.03], [figures()] * 2)
        self.follower = GripFollower(gripper, DOWN, table, None, self)

    def submit(self, solve, question, is_wanted):
        self.is_wanted, self.job = is_wanted, Future()
        self.asked.append(question)
        return self.job

    def turn(self, angle):
        self.gravity = (9.80665 * math.cos(angle), 0.0, 9.80665 * math.sin(angle))

    def follow(self, in_use=None, *, elapsed=0.1):
        self.now += elapsed
        return self.follower.follow(self.now, self.gravity, self.rate, in_use, is_on=self.is_on)

    def settle(self, in_use=HELD):
        """Follow an object until it is asked about."""
        self.follow(in_use)
        self.follow(in_use, elapsed=SETTLING)

    def known(self, in_use=HELD):
        return self.follower.answer(in_use, self.gravity, 5.0e4, 5.0e4)


@pytest.fixture
def grips(gripper):
    return Bench(gripper)


def test_the_table_is_known_at_once_near_its_gravity_with_the_times_of_its_ramp(grips):
    assert grips.known().normal_force == pytest.approx(1.0)
    assert grips.known(InUse(0.0395)) is None
    assert grips.follower.table(DOWN).window(0.01, 5.0e4) == (4.9e4, 6.0e4, 8.0e4)
    for angle, is_known in ((0.09, True), (0.12, False), (0.0, True)):
        grips.turn(angle)
        grips.follow()
        assert (grips.follower.table(grips.gravity) is not None) is is_known
        assert (grips.known() is not None) is is_known
    assert grips.known().settling > 0.0
    grips.rate = 2.0 * RATE
    grips.follow()
    assert math.isnan(grips.known().settling)
    assert not grips.asked


def test_a_defect_is_raised_once_and_not_asked_for_again_but_what_was_killed_is(grips):
    grips.settle()
    grips.job.set_exception(EndedError("its process was killed"))
    grips.follow(HELD)
    grips.job.set_exception(ZeroDivisionError("broken on purpose"))
    with pytest.raises(ZeroDivisionError):
        grips.follow(HELD)
    grips.settle()
    assert [question.radius for question in grips.asked] == [0.02] * 2
    # What cannot be held is told once.
    refusal = NotGrippableError(0.03, "the tube passes by", 0.0, None)
    grips.settle(InUse(0.03))
    grips.job.set_exception(refusal)
    assert [grips.follow(InUse(0.03)) for _ in range(2)] == [True, False]
    assert grips.follower.found(InUse(0.03)) is refusal


def test_the_object_in_use_is_solved_once_it_has_settled(grips):
    for radius, part in ((0.03, 1.0), (0.02, 0.8), (0.0201, 0.8)):
        grips.follow(InUse(radius), elapsed=part * SETTLING)
        assert not grips.asked
    grips.follow(HELD, elapsed=0.3 * SETTLING)
    assert grips.asked[0].radius == 0.02
    grips.job.set_result(figures(force=9.0))
    grips.settle()
    forces = [grips.known(InUse(radius)).normal_force for radius in (0.02, 0.021)]
    assert forces == pytest.approx([9.0, 1.0])
    assert len(grips.asked) == 1


def test_an_object_that_is_seen_is_solved_at_its_place_and_the_table_does_not_stand_for_it(grips):
    center, axis = (0.1, 0.02, 0.0), (0.0, 0.0, 1.0)
    seen = InUse(0.02, SeenObject(center, axis, 0.0))
    grips.settle(seen)
    assert grips.asked[0].pose == (center, axis)
    assert grips.known(seen) is None
    grips.job.set_result(figures())
    grips.follow(seen)
    for place, direction, is_known in (
        (center, (0.0, 0.0, -1.0), True),
        (center, (0.0, 0.06, 0.998), False),
        ((0.1, 0.023, 0.0), axis, False),
    ):
        known = grips.known(InUse(0.02, SeenObject(place, direction, 5.0)))
        assert (known is not None) is is_known


def test_while_the_arm_turns_nothing_is_asked_and_no_question_waits_behind_another(grips):
    grips.settle()
    assert grips.job.set_running_or_notify_cancel()  # it cannot be taken back
    for angle in range(20):
        grips.turn(angle)
        grips.follow(HELD)
    grips.settle()
    assert len(grips.asked) == 1
    assert not grips.is_wanted()  # so that its process ends it
    grips.job.set_result(figures())
    grips.follow(HELD)
    assert [question.gripper.gravity for question in grips.asked] == [DOWN, grips.gravity]
    assert grips.is_wanted()
    grips.follower.end()
    assert not grips.is_wanted()
    assert grips.job.cancelled()


def test_switched_off_nothing_is_known_and_nothing_asked(grips):
    grips.settle()
    grips.is_on = False
    grips.settle()
    assert not grips.is_wanted()
    assert grips.known() is None
    assert len(grips.asked) == 1
    grips.is_on = True
    grips.follow(HELD)
    assert grips.known()
    assert len(grips.asked) == 2
