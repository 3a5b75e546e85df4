# SPDX-License-Identifier: Apache-2.0
"""Grips of some radii, what they say of any other, and where that is refined."""

import math
from dataclasses import replace

import numpy as np
import pytest
from core.grip_cases import figures, solved_table, table_of
from core.gripper_cases import paper_gripper

from spiral_core import (
    InvalidInputError,
    Pull,
    WrapRegime,
    grip_window,
    holding_force,
    lay_into_coil,
)
from spiral_core.grip.curve import GripQuestion
from spiral_core.grip.table import EDGE, TOLERANCE, Blend
from spiral_core.grip.tabulate import MOST_REFINED, solve_curve

NEVER_LOST = figures(curling=None, loss=None)


REGIMES = """
48990 OVERHANG; 49000 PERFECT_WRAP; 59990 PERFECT_WRAP; 60000 CURLING; 79990 CURLING; 80000 OVERHANG
"""


@pytest.mark.parametrize("row", [*REGIMES.strip().split("; "), "1e9 NEVER_LOST", "nan OVERHANG"])
def test_the_regime_is_that_of_the_contact_at_radii_of_the_table_and_between(row):
    pressure, name = float(row.split()[0]), row.split()[1]
    grip = NEVER_LOST if pressure == 1e9 else figures()
    regime = WrapRegime.PERFECT_WRAP if pressure == 1e9 else WrapRegime[name]
    assert grip.regime(pressure) is regime
    answer = grip.answer(pressure, at_pose=True)
    assert answer.regime is regime
    assert (answer.onset_curling, answer.loss) == (grip.onset_curling, grip.loss)
    blended = blend(0.02, 0.8 * pressure, grip, grip)
    assert blended.regime is regime
    assert (answer.normal_force > 0.0) is (blended.normal_force > 0.0) is (pressure < grip.loss)


def test_forces_lie_between_those_computed_and_are_zero_below_and_when_lost():
    entry = replace(figures(), computed_at=7.0)
    for pressure, away, touching in ((4.7e4, 0.0, 0.088), (5.0e4, 0.5, 0.1), (8.0e4, 0.0, 0.0)):
        answer = entry.answer(pressure, at_pose=False)
        assert (answer.away, answer.towards, answer.down) == pytest.approx(
            (away, 0.1 * away, 0.5 * away)
        )
        held = (answer.contact_length, answer.normal_force, answer.computed_at)
        assert held == pytest.approx((touching, 10.0 * touching, 7.0))
    for pressure in (0.0, 5.5e4, 7.5e4):  # the tube is blended between its pressures
        assert entry.shape(pressure).positions == pytest.approx(np.full((3, 3), pressure))
    assert entry.shape(7.6e4) is entry.shape(-1.0) is None
    assert replace(entry, shapes=None).shape(5.5e4) is None
    # Below the first of its pressures nothing holds, whatever holds there.
    assert replace(entry, away=entry.away + 0.4).answer(4.7e4, at_pose=False).away == 0.0


def blend(radius, pressure, low, high, tip=4.0e4):
    return Blend([0.01, 0.03], [low, high], radius, tip).answer(pressure)


def test_pressures_are_compared_as_multiples_of_the_tip_criterions():
    answer = blend(0.02, 4.4e4, figures(), figures())  # 1.1 of 40 kPa, as 55 kPa of 50
    assert answer.away == pytest.approx(figures().answer(5.5e4, at_pose=False).away)
    assert (answer.onset_wrap, answer.loss) == pytest.approx((0.98 * 4.0e4, 1.6 * 4.0e4))
    # A twentieth of the way from one radius to the other, a twentieth of the difference counts.
    near = blend(0.011, 4.4e4, figures(), figures(force=3.0))
    assert near.away == pytest.approx(1.1 * answer.away)
    # Good grips between two radii end between theirs, here at 1.2 and 1.1 of the tip criterion's.
    grips = [figures(), figures(tip=3.0e4, curling=3.3e4)]
    grips = [replace(g, highest_good=0.99 * g.highest_good) for g in grips]
    _, good, _ = Blend([0.01, 0.03], grips, 0.02, 4.0e4).window
    assert good == pytest.approx(0.99 * 4.0e4 * 0.5 * (1.2 + 1.1))
    # Where only one neighbor loses the grip, that one counts.
    lost = blend(0.011, 4.85e4, figures(loss=None), figures(loss=6.0e4))
    assert (lost.loss, lost.away) == (pytest.approx(4.8e4), 0.0)


@pytest.mark.slow
def test_forces_between_those_computed_are_hardly_above_what_holds_and_not_far_below():
    gripper = paper_gripper("70 degrees")
    entry = solve_curve(GripQuestion(gripper, 0.02))
    window = grip_window(lay_into_coil(gripper, 0.02))
    for multiple in (1.0, 1.025, 1.1, 1.35):
        point = window.at(multiple * window.onset_wrap)
        told = entry.answer(point.pressure, at_pose=False)
        for pull in (Pull.AWAY, Pull.TOWARDS, Pull.DOWN):
            ratio = getattr(told, pull.name.lower()) / holding_force(point, pull).force
            assert 0.9 < ratio < 1.05, (multiple, pull)


# --- refinement ------------------------------------------------------------------------------

COUNT = 3


def away(table, radius):
    answer = table.answer(radius, 5.0e4, 5.5e4)
    return None if answer is None else answer.away


@pytest.mark.parametrize(
    ("force", "count", "share"),
    [
        (lambda radius: 1.0 + 10.0 * radius, 5, 1.0),  # the middles only
        (lambda radius: 1.0 / radius, None, 1.0),
        (lambda radius: 1.0 if radius < 0.025 else 3.0, MOST_REFINED * COUNT, 0.9),
    ],
)
def test_it_is_refined_until_every_answer_keeps_the_tolerance_or_it_is_full(
    monkeypatch, force, count, share
):
    table = solved_table(monkeypatch, force, COUNT)
    exact = figures().away[1] + (5.5 - 1.0) * (5.5e4 - 5.25e4) / 2.25e4
    radii = np.linspace(1.0001 * table.radii[0], 0.9999 * table.radii[-1], 500)
    known = [found / force(radius) for radius in radii if (found := away(table, radius))]
    assert known == pytest.approx(np.full(len(known), exact), rel=TOLERANCE)
    assert 5 <= len(table.radii) <= MOST_REFINED * COUNT
    assert count in (None, len(table.radii))
    assert share <= len(known) / len(radii)
    assert (away(table, 0.025) is None) is (share < 1.0)  # a jump that no table resolves
    assert table.window(0.025, 5.0e4) is not None


@pytest.mark.parametrize("name", [None, "normal_forces", "away", "towards", "down"])
def test_nothing_is_answered_before_each_of_its_forces_has_been_compared(name):
    grip = figures()
    table = table_of([0.01, 0.02, 0.04], [grip] * 3, error=math.inf)
    assert away(table, 0.012) is None
    differs = {} if name is None else {name: 2.0 * getattr(grip, name)}
    known = table.halved(0, 0.014, replace(grip, **differs))
    assert (away(known, 0.012) is None) is (away(known, 0.016) is None) is (name is not None)
    assert away(table, 0.012) is None  # another thread may be reading it
    assert away(known, 0.03) is away(known, 0.041) is known.window(0.041, 5.0e4) is None


def test_where_radii_are_held_is_located_and_what_is_not_held_is_not_answered(monkeypatch):
    table = solved_table(monkeypatch, lambda radius: None if radius > 0.03 else 1.0, COUNT)
    assert away(table, 0.015) is not None
    assert away(table, 0.03 / (1.0 + EDGE)) is not None
    assert away(table, 0.0301) is table.window(0.0301, 5.0e4) is None


def test_next_to_radii_that_are_not_held_none_is_and_the_nearest_held_is_named():
    grip = figures()
    table = table_of([0.01, 0.02, 0.03, 0.04, 0.05], [grip, None, None, grip, grip])
    wrong = [each for each in range(9, 52) if table.is_not_held(1e-3 * each)]
    assert wrong == list(range(11, 40))
    assert [table.nearest_held(radius) for radius in (0.024, 0.026)] == [0.01, 0.04]
    assert table_of([0.01, 0.02], [None, None]).nearest_held(0.01) is None


@pytest.mark.parametrize(
    ("radii", "grips", "named"),
    [([0.01], 1, "radii"), ([0.02, 0.01], 2, "radii"), ([0.0, 0.01], 2, "radii"),
     ([math.nan, 0.01], 2, "radii"), ([0.01, 0.02], 3, "grips")],
)  # fmt: skip
def test_radii_that_do_not_increase_and_missing_grips_are_refused(radii, grips, named):
    with pytest.raises(InvalidInputError, match=named):
        table_of(radii, [figures()] * grips)
