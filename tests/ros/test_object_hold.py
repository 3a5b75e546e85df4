# SPDX-License-Identifier: Apache-2.0
"""The simulated object slips when more pulls at it than holds it."""

import pytest
from ros.grip_stand_ins import Pool, figures

from spiral_core.errors import NotGrippableError
from spiral_gripper_ros.planning.grip_follower import SETTLING
from spiral_gripper_ros.simulation.object_hold import ObjectHold
from spiral_gripper_ros.simulation.simulated_gripper import Grip

RADIUS, PRESSURE = 0.02, 5.25e4
HOLDS = 0.5  # along gravity, at that pressure [N]


class Bench:
    def __init__(self, gripper):
        self.pool, self.now = Pool(), 0.0
        self.hold = ObjectHold(gripper, None, self.pool)

    def judge(self, load, grip=Grip.PERFECT_WRAP, radius=RADIUS, pressure=PRESSURE):
        self.now += SETTLING
        return self.hold.judge(self.now, grip, radius, pressure, load)


@pytest.fixture
def bench(gripper):
    return Bench(gripper)


@pytest.fixture
def solved(bench):
    bench.judge(0.1)
    bench.judge(0.1)
    bench.pool.answer(figures())
    return bench


def test_without_a_load_nothing_is_solved_and_nothing_slips(bench):
    for _ in range(5):
        assert bench.judge(0.0) is Grip.PERFECT_WRAP
    assert not bench.pool.asked


def test_until_the_grip_is_known_nothing_slips(bench):
    for _ in range(5):
        assert bench.judge(1e3) is Grip.PERFECT_WRAP
    assert len(bench.pool.asked) == 1
    bench.pool.answer(NotGrippableError(RADIUS, "not held", -1.0, None))
    assert bench.judge(1e3) is Grip.PERFECT_WRAP


def test_an_object_slips_when_more_pulls_than_holds_and_is_gone_until_the_gripper_opens(solved):
    assert solved.judge(0.99 * HOLDS) is Grip.PERFECT_WRAP
    assert solved.judge(1.01 * HOLDS) is Grip.SLIPPED
    assert solved.judge(0.01) is Grip.SLIPPED
    assert solved.judge(0.01, grip=Grip.OVERHANG) is Grip.OVERHANG
    assert solved.judge(0.01) is Grip.PERFECT_WRAP


def test_where_the_grip_is_lost_the_object_slips(solved):
    assert solved.judge(0.01, grip=Grip.CURLING, pressure=7.9e4) is Grip.CURLING
    assert solved.judge(0.01, grip=Grip.CURLING, pressure=8.1e4) is Grip.SLIPPED


def test_another_object_has_not_slipped(solved):
    assert solved.judge(9.0) is Grip.SLIPPED
    assert solved.judge(0.01, radius=0.021) is Grip.PERFECT_WRAP
    assert solved.judge(9.0, radius=None, grip=Grip.NO_OBJECT) is Grip.NO_OBJECT
