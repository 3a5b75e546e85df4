# SPDX-License-Identifier: Apache-2.0
"""Grips of some radii, what they say of any other, and where that is refined."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from core.grip_cases import figures, solved_table, table_of
from core.gripper_cases import paper_gripper
from core.recorded import recorded
from numpy.testing import assert_allclose

from spiral_core import Pull, WrapRegime, grip_window, holding_force, lay_into_coil
from spiral_core.grip.curve import GripQuestion
from spiral_core.grip.table import EDGE, TOLERANCE, Blend
from spiral_core.grip.tabulate import MOST_REFINED, solve_curve


def test_what_is_told_at_every_edge_of_a_grip_is_recorded():
    """At a radius of the table and between two; at the edges of wrap, curling and loss."""
    grip = figures()
    found = {
        f"{pressure:.0f}": [
            grip.answer(pressure, at_pose=True),
            blend(0.02, 0.8 * pressure, grip, grip),
            grip.shape(pressure),
        ]
        for pressure in (4.7e4, 48990, 59990, 7.6e4, 8e4)
    }
    recorded("table/answers", found)
    endless = figures(curling=None, loss=None).answer(1e9, at_pose=False)
    assert (endless.regime, endless.loss) == (WrapRegime.PERFECT_WRAP, inf)
    # Below the first of its pressures nothing holds, whatever holds there.
    assert replace(grip, away=grip.away + 0.4).answer(4.7e4, at_pose=False).away == 0.0
    assert replace(grip, shapes=None).shape(5.5e4) is None


def blend(radius, pressure, low, high, tip=4.0e4):
    return Blend([0.01, 0.03], [low, high], radius, tip).answer(pressure)


def test_pressures_are_compared_as_multiples_of_the_tip_criterions():
    answer = blend(0.02, 4.4e4, figures(), figures())  # 1.1 of 40 kPa, as 55 kPa of 50
    exact = figures().answer(5.5e4, at_pose=False).away
    found = answer.away, answer.onset_wrap, answer.loss
    assert_allclose(found, (exact, 0.98 * 4.0e4, 1.6 * 4.0e4))
    # A twentieth of the way from one radius to the other, a twentieth of the difference counts.
    assert_allclose(blend(0.011, 4.4e4, figures(), figures(force=3.0)).away, 1.1 * exact)
    # Good grips between two radii end between theirs, here at 1.2 and 1.1 of the tip criterion's.
    grips = [figures(), figures(tip=3.0e4, curling=3.3e4)]
    grips = [replace(g, highest_good=0.99 * g.highest_good) for g in grips]
    _, good, _ = Blend([0.01, 0.03], grips, 0.02, 4.0e4).window
    assert_allclose(good, 0.99 * 4.0e4 * 0.5 * (1.2 + 1.1))
    # Where only one neighbor loses the grip, that one counts.
    lost = blend(0.011, 4.85e4, figures(loss=None), figures(loss=6.0e4))
    assert_allclose((lost.loss, lost.away), (4.8e4, 0.0))


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


def away(table, radius):
    answer = table.answer(radius, 5.0e4, 5.5e4)
    return None if answer is None else answer.away


def test_it_is_refined_until_every_answer_keeps_the_tolerance_or_it_is_full(monkeypatch):
    exact = figures().answer(5.5e4, at_pose=False).away
    for force, counts, share in (
        (lambda radius: 1.0 + 10.0 * radius, {5}, 1.0),  # the middles only
        (lambda radius: 1.0 / radius, range(5, MOST_REFINED * 3), 1.0),
        # A jump that no table resolves.
        (lambda radius: 1.0 if radius < 0.025 else 3.0, {25}, 0.9),
    ):
        table = solved_table(monkeypatch, force, 3)
        radii = np.linspace(1.0001 * table.radii[0], 0.9999 * table.radii[-1], 500)
        known = [found / force(radius) for radius in radii if (found := away(table, radius))]
        assert_allclose(known, exact, TOLERANCE)
        assert len(table.radii) in counts
        assert share <= len(known) / len(radii)
        assert (away(table, 0.025) is None) is (share < 1.0)
        assert table.window(0.025, 5.0e4) is not None


def test_nothing_is_answered_before_each_of_its_forces_has_been_compared():
    grip = figures()
    table = table_of([0.01, 0.02, 0.04], [grip] * 3, error=inf)
    for changed in ([], ["normal_forces"], ["away"], ["towards"], ["down"]):
        known = table.halved(
            0, 0.014, replace(grip, **{name: 2.0 * getattr(grip, name) for name in changed})
        )
        answers = [away(known, radius) is None for radius in (0.012, 0.016)]
        assert answers == [bool(changed)] * 2
        assert away(table, 0.012) is None  # another thread may be reading it
        assert away(known, 0.03) is away(known, 0.041) is known.window(0.041, 5.0e4) is None


def test_where_radii_are_held_is_located_and_what_is_not_held_is_not_answered(monkeypatch):
    table = solved_table(monkeypatch, lambda radius: None if radius > 0.03 else 1.0, 3)
    held = [away(table, radius) is not None for radius in (0.015, 0.03 / (1.0 + EDGE), 0.0301)]
    assert held == [True, True, False]
    assert table.window(0.0301, 5.0e4) is None
    assert table.window(table.nearest_held(0.03), 5.0e4)


def test_next_to_radii_that_are_not_held_none_is_and_the_nearest_held_is_named():
    grip = figures()
    table = table_of([0.01, 0.02, 0.03, 0.04, 0.05], [grip, None, None, grip, grip])
    wrong = [each for each in range(9, 52) if table.is_not_held(1e-3 * each)]
    empty = table_of([0.01, 0.02], [None, None]).nearest_held(0.01)
    assert table_of([0.01, 0.02], [None, grip]).is_not_held(0.0099)
    nearest = [table.nearest_held(radius) for radius in (0.024, 0.026)]
    assert (wrong, nearest, empty) == ([*range(11, 40)], [0.01, 0.04], None)
