# SPDX-License-Identifier: Apache-2.0
"""What twice the elements change of a grip is stated, and small."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from spiral_core import (
    Closing,
    Pull,
    grip_window,
    holding_force,
    lay_into_coil,
    solve_grip,
)
from spiral_core.grip.grip import refine
from spiral_gripper import load_gripper

pytestmark = pytest.mark.long


@pytest.mark.slow
def test_twice_the_elements_change_a_grip_by_what_is_stated() -> None:
    setup = lay_into_coil(load_gripper("paper_design_70"), 0.025, closing=Closing.FRICTIONLESS)
    tip = setup.tip_pressure
    stations = [fraction * tip for fraction in (0.5, 0.8, 0.92, 1.0, 1.08, 1.14)]
    window = grip_window(setup, stations)
    stated = refine(solve_grip(setup, (), pressures=(), window=window))
    finer = grip_window(replace(setup, elements=2 * setup.element_count), stations)
    assert stated.elements == setup.element_count
    changes = []
    for name in ("onset_wrap", "onset_curling"):
        coarse, fine = getattr(window, name), getattr(finer, name)
        changes.append(abs(coarse - fine) / fine)
    assert stated.window == pytest.approx(max(changes), abs=1e-12)
    # Onsets are located to 0.2 %; the mesh adds as much.
    assert 0.0 <= stated.window < 5e-3
    at = solve_grip(setup, (), pressures=(), window=window).recommended_pressure()
    forces = [holding_force(each.at(at), Pull.AWAY).force for each in (window, finer)]
    assert stated.force == pytest.approx(abs(forces[0] / forces[1] - 1.0), abs=1e-9)
    assert stated.force < 0.05
    assert 0.0 <= stated.penetration < 1e-6
    count = setup.element_count
    assert f"{count} and {2 * count} elements" in str(stated)
    # Only one of the two is lost: nothing finite could be stated.
    curled = replace(window, onset_curling=None)
    assert refine(solve_grip(setup, (), pressures=(), window=curled)).window == math.inf


def test_points_where_tube_and_object_cross_are_no_wrap() -> None:
    """Upright, seven nodes of 60 elements touch, each alone, and the tip: of 90 they are fewer."""
    upright = load_gripper("paper_design_70").with_mount((-9.80665, 0.0, 0.0), None)
    setup = lay_into_coil(upright, 0.012, elements=60)
    window = grip_window(setup)
    crossed = next(point for point in window.points if point.state.touching[0].sum() > 6)
    assert crossed.tip_gap < 1e-6
    assert crossed.largest_gap > 5e-3
    assert not crossed.is_wrapped
    finer = grip_window(replace(setup, elements=90), window.pressures[1:])
    assert window.onset_wrap == pytest.approx(finer.onset_wrap, rel=5e-3)  # located to 0.2 %
    assert window.lift_off is None
    grip = solve_grip(setup, (), pressures=(), window=window)
    assert window.at(grip.recommended_pressure()).is_wrapped
