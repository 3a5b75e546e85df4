# SPDX-License-Identifier: Apache-2.0
"""Grips from contact and friction, solved in the background."""

import math
from concurrent.futures import Future
from types import SimpleNamespace

import pytest
from core.grip_cases import DOWN, figures, table_of
from ros.control_bench import Steps, rows

from spiral_core import NotGrippableError
from spiral_gripper_ros.planning.grip_follower import SETTLING, GripFollower, InUse
from spiral_gripper_ros.planning.object_pose import SeenObject
from spiral_gripper_ros.planning.worker import EndedError

RATE = 1.5e4
CENTER, AXIS = (0.1, 0.02, 0.0), (0.0, 0.0, 1.0)
SEEN = {
    "there": SeenObject(CENTER, AXIS, 0.0),
    "opposite": SeenObject(CENTER, (0.0, 0.0, -1.0), 5.0),
    "tilted": SeenObject(CENTER, (0.0, 0.06, 0.998), 5.0),
    "shifted": SeenObject((0.1, 0.023, 0.0), AXIS, 5.0),
}


class Bench(Steps):
    """A follower whose questions are answered here, one after the other."""

    is_wanted = None

    def __init__(self, gripper):
        self.asked, self.now, self.gravity, self.rate, self.is_on = [], 100.0, DOWN, RATE, True
        table = table_of([0.01, 0.03], [figures()] * 2)
        self.follower = GripFollower(gripper, DOWN, table, None, self)

    def submit(self, solve, question, is_wanted):
        self.is_wanted, self.job = is_wanted, Future()
        self.asked.append(question)
        return self.job

    def give(self, **values):
        vars(self).update(values)

    def turn(self, angle):
        self.gravity = (9.80665 * math.cos(angle), 0.0, 9.80665 * math.sin(angle))

    def look(self, radius=0.02, elapsed=0.1, seen=None):
        """Follow an object for a part of the time in which it settles."""
        self.in_use = InUse(radius, SEEN.get(seen))
        self.now += elapsed * SETTLING
        return self.follower.follow(
            self.now, self.gravity, self.rate, self.in_use, is_on=self.is_on
        )

    def settle(self, radius=0.02, seen=None):
        """Follow an object until it is asked about."""
        self.look(radius, seen=seen)
        self.look(radius, 1.0, seen)

    def starts(self):
        assert self.job.set_running_or_notify_cancel()  # it cannot be taken back

    def answer(self, force=1.0):
        self.job.set_result(figures(force=force))

    @property
    def words(self):
        """What has been asked, the force and the time to settle that are known, what is wanted."""
        plan = SimpleNamespace(
            wrap=SimpleNamespace(object_radius=self.in_use.radius),
            laid=SimpleNamespace(pressure=5.0e4),
            gripper=SimpleNamespace(gravity=self.gravity),
        )
        known = self.follower.answer(plan, self.in_use.seen, 5.0e4)
        told = f"{known.normal_force:g} {known.settling:g}" if known else "- -"
        return f"{len(self.asked)} {told} {self.is_wanted and self.is_wanted()}"


@pytest.fixture
def grips(gripper):
    return Bench(gripper)


# The table is known at once near its gravity, with the times of its ramp. What is in use is solved
# once it has settled, then at its place if it is seen, for which the table does not stand. While
# the arm turns nothing is asked, and no question waits behind another.
COURSES = """
0 1 0.075 None: look
0 - - None: look 0.0395
0 1 0.075 None: turn 0.09; look
0 - - None: turn 0.12; look
0 1 0.075 None: turn 0.12; look; turn 0; look
0 1 nan None: give rate=3e4; look
0 1 0.075 None: look 0.03 1; look 0.02 0.8; look 0.0201 0.8
1 1 nan False: settle; starts; give rate=3e4; look
1 1 0.075 True: look 0.03 1; look 0.02 0.8; look 0.0201 0.8; look 0.02 0.3
1 9 0.075 True: settle; answer 9; settle
1 1 0.075 True: settle; answer 9; settle; look 0.021
1 - - True: settle seen=there
2 - - True: settle seen=there; answer; look seen=there
2 9 0.075 True: settle seen=there; answer; look seen=there; answer 9; look seen=opposite
2 - - True: settle seen=there; answer; look seen=there; answer 9; look seen=tilted
2 - - True: settle seen=there; answer; look seen=there; answer 9; look seen=shifted
2 1 0.075 True: settle seen=there; answer; look seen=there; answer 9; settle
2 9 0.075 True: settle; answer; settle seen=there; answer 9; settle; look seen=there
1 - - False: settle; starts; turn 1; look; turn 2; look; turn 3; look; turn 4; settle
2 - - True: settle; starts; turn 1; look; turn 2; look; turn 3; look; settle; answer; look
1 - - False: settle; give is_on=no; settle
2 1 0.075 True: settle; give is_on=no; settle; give is_on=yes; look
"""


@pytest.mark.parametrize("row", rows(COURSES))
def test_what_is_known_and_asked_follows_the_object_in_use(grips, row):
    expected, steps = row.split(": ")
    grips.follow(steps)
    assert grips.words == expected
    for question in grips.asked[-1:]:
        assert question.gripper.gravity in (DOWN, grips.gravity)
    poses = [None, (CENTER, AXIS) if "seen" in row else None]
    assert [question.pose for question in grips.asked] == poses[: len(grips.asked)]
    grips.follower.end()
    assert not grips.is_wanted or not grips.is_wanted()
    assert not grips.asked or grips.job.running() or grips.job.done()


def test_a_defect_is_raised_once_and_not_asked_for_again_but_what_was_killed_is(grips):
    grips.settle()
    grips.job.set_exception(EndedError("its process was killed"))
    grips.look()
    grips.job.set_exception(ZeroDivisionError("broken on purpose"))
    with pytest.raises(ZeroDivisionError):
        grips.look()
    grips.settle()
    assert [question.radius for question in grips.asked] == [0.02] * 2
    # What cannot be held is told once.
    refusal = NotGrippableError(0.03, "the tube passes by", 0.0, None)
    grips.settle(0.03)
    grips.job.set_exception(refusal)
    assert [grips.look(0.03) for _ in range(2)] == [True, False]
    assert grips.follower.found(InUse(0.03), DOWN) is refusal
    # Its grip where it is seen changes neither that nor any plan.
    grips.settle(0.03, "there")
    grips.answer()
    assert not grips.look(0.03, seen="there")
    assert grips.follower.found(grips.in_use, DOWN)
    assert grips.follower.found(InUse(0.03), DOWN) is refusal
    assert grips.follower.found(InUse(0.03), (0.0, 0.0, 9.80665)) is None
