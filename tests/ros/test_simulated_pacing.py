# SPDX-License-Identifier: Apache-2.0
"""How simulated time passes."""

import pytest

from spiral_core import InvalidInputError
from spiral_gripper_ros.simulation.pacing import LONGEST_STEP, STEP, Pacing, RateGate


def test_as_the_source_of_time_every_step_is_the_same_whatever_the_machine_does():
    pacing = Pacing(publishes_clock=True)
    assert {pacing.step(reading) for reading in (0.0, 100.0, 5.0, 5.0)} == {STEP}
    for _ in range(996):
        pacing.step(0.0)
    assert pacing.now == 10.0
    assert pacing.nanoseconds == 10_000_000_000


@pytest.mark.parametrize(
    ("readings", "expected"),
    [
        ((1000.0, 1000.01, 1000.05), [0.0, 0.01, 0.04]),
        # Time never runs backwards, and a simulator that is held up loses it.
        ((100.0, 50.0, 50.1, 3600.0, 3600.1), [0.0, 0.0, 0.1, LONGEST_STEP, 0.1]),
    ],
)
def test_as_a_follower_time_passes_as_on_the_clock(readings, expected):
    pacing = Pacing(publishes_clock=False)
    assert [pacing.step(reading) for reading in readings] == pytest.approx(expected, abs=1e-9)
    assert pacing.now == pytest.approx(sum(expected), abs=1e-9)
    with pytest.raises(InvalidInputError):
        pacing.step(float("nan"))


def test_what_is_due_with_a_rate_keeps_it_on_average_and_makes_nothing_up():
    every = RateGate()
    assert sum(every.due(0.01 * tick, rate=30.0) for tick in range(1000)) == 300
    assert every.due(1000.0, rate=30.0)
    assert not every.due(1000.01, rate=30.0)
