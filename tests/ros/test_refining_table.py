# SPDX-License-Identifier: Apache-2.0
"""The table of grips is refined where what lies between its radii is not known well enough."""

import math
from dataclasses import replace

import pytest
from ros.grip_stand_ins import figures

from spiral_gripper_ros.planning.grip_table import GripEntry, table_radii
from spiral_gripper_ros.planning.refining_table import MOST_REFINED, TOLERANCE, RefiningTable

RADII = table_radii(0.01, 0.04, 3)


def filled(grip_at, radii=RADII):
    """A table that is done, and the radii that were solved, in order."""
    table, solved = RefiningTable(radii), []
    while (radius := table.next_radius()) is not None:
        solved.append(radius)
        table = table.added(radius, grip_at(radius))
        assert len(solved) < 1000
    return table, solved


def of_force(law):
    """Grips whose forces follow a law of the radius."""
    return lambda radius: GripEntry(figures(force=law(radius)), 0.0)


def worst_error(table, law):
    """Return the largest relative error of what the table answers, and the share it answers."""
    radii = [0.01 + 0.03 * (i + 0.5) / 500 for i in range(500)]
    answers = [(radius, table.answer(radius, 5.0e4, 5.5e4)) for radius in radii]
    known = [(radius, answer.away) for radius, answer in answers if answer is not None]
    exact = figures().away[1] + (5.5 - 1.0) * (5.5e4 - 5.25e4) / 2.25e4
    errors = [abs(force / (law(radius) * exact) - 1.0) for radius, force in known]
    return max(errors, default=0.0), len(known) / len(radii)


def test_what_is_linear_needs_the_middles_only():
    table, solved = filled(of_force(lambda radius: 1.0 + 10.0 * radius))
    assert solved[:3] == pytest.approx([RADII[1], RADII[0], RADII[2]])
    assert len(solved) == 5
    assert worst_error(table, lambda radius: 1.0 + 10.0 * radius) == (pytest.approx(0.0), 1.0)


@pytest.mark.parametrize("power", [-2.0, -1.0, 3.0])
def test_it_is_refined_until_every_answer_keeps_the_tolerance(power):
    def law(radius):
        return (radius / 0.02) ** power

    table, solved = filled(of_force(law))
    error, share = worst_error(table, law)
    assert error <= TOLERANCE
    assert share == 1.0
    assert 5 < len(solved) <= MOST_REFINED * len(RADII)


def test_a_full_table_answers_only_where_it_keeps_the_tolerance():
    def law(radius):  # a jump that no table resolves
        return 1.0 if radius < 0.025 else 3.0

    table, solved = filled(of_force(law))
    error, share = worst_error(table, law)
    assert len(solved) == MOST_REFINED * len(RADII)
    assert error <= TOLERANCE
    assert 0.8 < share < 1.0
    assert table.answer(0.025, 5.0e4, 5.5e4) is None
    assert table.window(0.025, 5.0e4) is not None


def test_nothing_is_answered_before_it_has_been_compared():
    table = RefiningTable(RADII)
    for radius in RADII:
        assert table.answer(0.012, 5.0e4, 5.5e4) is None
        table = table.added(radius, GripEntry(figures(), 0.0))
    assert table.answer(0.012, 5.0e4, 5.5e4) is None
    before = table
    table = table.added(math.sqrt(RADII[0] * RADII[1]), GripEntry(figures(), 0.0))
    assert table.answer(0.012, 5.0e4, 5.5e4) is not None
    assert before.answer(0.012, 5.0e4, 5.5e4) is None  # another thread may be reading it
    assert table.answer(0.03, 5.0e4, 5.5e4) is None
    assert table.answer(0.041, 5.0e4, 5.5e4) is table.window(0.041, 5.0e4) is None


def test_what_is_not_held_is_neither_answered_nor_refined():
    def grip_at(radius):
        return None if radius > 0.03 else GripEntry(figures(), 0.0)

    table, solved = filled(grip_at)
    assert len(solved) == 4
    assert table.answer(0.015, 5.0e4, 5.5e4) is not None
    assert table.answer(0.03, 5.0e4, 5.5e4) is table.window(0.03, 5.0e4) is None


@pytest.mark.parametrize("name", ["normal_forces", "away", "towards", "down"])
def test_each_force_is_compared(name):
    table = RefiningTable(RADII)
    for radius in RADII:
        table = table.added(radius, GripEntry(figures(), 0.0))
    grip = figures()
    table = table.added(0.015, GripEntry(replace(grip, **{name: 2.0 * getattr(grip, name)}), 0.0))
    assert table.answer(0.012, 5.0e4, 5.5e4) is None
