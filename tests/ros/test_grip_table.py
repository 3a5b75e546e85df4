# SPDX-License-Identifier: Apache-2.0
"""Grips of some radii, and what they say of any other."""

import math
from dataclasses import replace

import numpy as np
import pytest
from ros.grip_stand_ins import figures

from spiral_core import Pull, WrapRegime, grip_window, holding_force, lay_into_coil
from spiral_gripper import load_gripper
from spiral_gripper_ros.planning.grip_figures import GripQuestion
from spiral_gripper_ros.planning.grip_solution import solve_figures
from spiral_gripper_ros.planning.grip_table import (
    GripEntry,
    blended_answer,
    blended_window,
    neighbors,
)


@pytest.mark.parametrize(
    ("pressure", "regime"),
    [
        (0.0, WrapRegime.OVERHANG),
        (4.899e4, WrapRegime.OVERHANG),
        (4.9e4, WrapRegime.PERFECT_WRAP),
        (5.999e4, WrapRegime.PERFECT_WRAP),
        (6.0e4, WrapRegime.CURLING),
        (7.999e4, WrapRegime.CURLING),
        (8.0e4, WrapRegime.OVERHANG),
    ],
)
def test_the_regime_is_that_of_the_contact(pressure, regime):
    assert figures().regime(pressure) is regime
    assert GripEntry(figures(), 0.0).answer(pressure, at_pose=True).regime is regime


def test_what_never_curls_and_is_never_lost_stays_wrapped():
    grip = figures(curling=None, loss=None)
    assert grip.regime(1e9) is WrapRegime.PERFECT_WRAP
    answer = GripEntry(grip, 0.0).answer(5.0e4, at_pose=False)
    assert (answer.onset_curling, answer.loss) == (math.inf, math.inf)


def test_forces_lie_between_those_computed_and_are_zero_below_and_when_lost():
    entry = GripEntry(figures(), 7.0)
    middle = entry.answer(5.0e4, at_pose=False)
    assert (middle.away, middle.towards, middle.down) == pytest.approx((0.5, 0.05, 0.25))
    assert (middle.contact_length, middle.normal_force) == pytest.approx((0.1, 1.0))
    assert middle.computed_at == 7.0
    assert entry.answer(4.7e4, at_pose=False).away == 0.0
    lost = entry.answer(8.0e4, at_pose=False)
    assert (lost.away, lost.normal_force, lost.contact_length) == (0.0, 0.0, 0.0)


def test_the_drawn_tube_is_blended_between_pressures():
    grip = figures()
    assert grip.shape(0.0).positions[0, 0] == 0.0
    assert grip.shape(3.75e4).positions[2, 1] == pytest.approx(3.75e4)
    assert grip.shape(7.5e4).positions[0, 0] == pytest.approx(7.5e4)
    assert grip.shape(7.6e4) is None
    norms = np.linalg.norm(grip.shape(1.0e4).orientations, axis=1)
    assert norms == pytest.approx(1.0)


def blend(radius, pressure, low=None, high=None, tip=4.0e4):
    entries = [GripEntry(low or figures(), 3.0), GripEntry(high or figures(), 5.0)]
    return blended_answer([0.01, 0.03], entries, radius, tip, pressure)


def test_at_the_radii_of_the_table_the_answer_is_that_of_its_grips():
    thin, thick = figures(), figures(tip=3.0e4, curling=3.5e4, loss=None, force=0.5)
    alone = GripEntry(thin, 3.0).answer(5.5e4, at_pose=False)
    assert blend(0.01, 5.5e4, thin, thick, tip=5.0e4).away == pytest.approx(alone.away)
    answer = blend(0.03, 3.2e4, thin, thick, tip=3.0e4)
    alone = GripEntry(thick, 3.0).answer(3.2e4, at_pose=False)
    assert (answer.away, answer.normal_force) == pytest.approx((alone.away, alone.normal_force))
    assert answer.onset_curling == pytest.approx(3.5e4)


def test_pressures_are_compared_as_multiples_of_the_tip_criterions():
    answer = blend(0.02, 4.4e4)  # 1.1 of 40 kPa, as 55 kPa of 50
    assert answer.away == pytest.approx(GripEntry(figures(), 0.0).answer(5.5e4, at_pose=False).away)
    assert answer.onset_wrap == pytest.approx(0.98 * 4.0e4)
    assert answer.loss == pytest.approx(1.6 * 4.0e4)
    assert answer.computed_at == 3.0


def test_where_only_one_neighbor_loses_the_grip_that_one_counts():
    answer = blend(0.011, 4.4e4, figures(loss=None), figures(loss=6.0e4))
    assert answer.loss == pytest.approx(4.8e4)
    assert blend(0.02, 4.85e4, figures(loss=None), figures(loss=6.0e4)).away == 0.0


@pytest.mark.parametrize(
    ("radius", "places"),
    [(0.01, (0, 1)), (0.02, (1, 2)), (0.04, (1, 2)), (0.015, (0, 1)), (0.009, None), (0.041, None)],
)
def test_the_neighbors_of_a_radius(radius, places):
    assert neighbors((0.01, 0.02, 0.04), radius) == places


def test_good_grips_between_two_radii_end_between_theirs():
    grips = (figures(), figures(tip=3.0e4, curling=3.3e4))  # at 1.2 and 1.1 of the tip criterion's
    entries = [
        GripEntry(replace(grip, highest_good=0.99 * grip.highest_good), 0.0) for grip in grips
    ]
    _, good, _ = blended_window([0.01, 0.03], entries, 0.02, 4.0e4)
    assert good == pytest.approx(0.99 * 4.0e4 * 0.5 * (1.2 + 1.1))


@pytest.mark.slow
def test_forces_between_those_computed_are_hardly_above_what_holds_and_not_far_below():
    gripper = load_gripper("paper_design_70")
    entry = GripEntry(solve_figures(GripQuestion(gripper, 0.02)), 0.0)
    window = grip_window(lay_into_coil(gripper, 0.02))
    for multiple in (1.0, 1.025, 1.1, 1.35):
        point = window.at(multiple * window.onset_wrap)
        told = entry.answer(point.pressure, at_pose=False)
        for pull in (Pull.AWAY, Pull.TOWARDS, Pull.DOWN):
            ratio = getattr(told, pull.name.lower()) / holding_force(point, pull).force
            assert 0.9 < ratio < 1.05, (multiple, pull)
