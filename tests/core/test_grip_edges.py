# SPDX-License-Identifier: Apache-2.0
"""Grips next to their ends: an object wedged at the clamp, a loss above the limit, a curl."""

from __future__ import annotations

from dataclasses import replace

import pytest
from core.gripper_cases import paper_gripper
from numpy.testing import assert_allclose

from spiral_core import (
    Cylinder,
    GripSetup,
    NotGrippableError,
    Obstacle,
    WrapRegime,
    grip_window,
    lay_into_coil,
    solve_grip,
)
from spiral_core.grip.grip import RangeEnd
from spiral_core.grip.setup import hanging_tube
from spiral_core.grip.window import LOSS_MARGIN

GRIPPER = paper_gripper("70 degrees")


def test_an_object_wedged_at_the_clamp_is_in_the_way_on_any_elements():
    """The clamped end does not give way; farther along the tube it does, without forces."""
    level = GRIPPER.with_mount((0.0, 0.0, -9.80665), None)
    for elements in (60, 90, 180, 270):
        wedged, clear = (
            replace(lay_into_coil(level, radius), elements=elements) for radius in (0.021, 0.0218)
        )
        with pytest.raises(NotGrippableError, match="runs through where the object lies"):
            hanging_tube(wedged)
        assert not hanging_tube(clear).normal_forces.any()
    # Beside the hanging tube: at its base, near it, in its middle.
    outer = GRIPPER.tube.outer_radius
    for at, overlap, is_held in (
        (0.0, -0.01, True),
        (0.0, 0.01, False),
        (2.0, 0.01, False),
        (25.0, 0.09, True),
        (25.0, 0.11, False),
    ):
        place = (at * outer, 0.02 + (1.0 - overlap) * outer, 0.0)
        setup = GripSetup(GRIPPER, Obstacle.along(Cylinder(0.02), place, (0.0, 0.0, 1.0)))
        if is_held:
            assert hanging_tube(setup).normal_forces.sum() < 0.01
        else:
            with pytest.raises(NotGrippableError, match="runs through"):
                hanging_tube(setup)


def test_a_limit_below_the_loss_hides_nothing_of_its_margin():
    """The same range with a limit above the loss, below it, and between loss and margin."""
    grips = []
    for limit in (120.0e3, 110.316e3, 105.0e3, 95.0e3):
        setup = lay_into_coil(replace(GRIPPER, pressure_max=limit), 0.0122)
        grips.append(solve_grip(setup, ()))
    lost = grips[0].window.loss
    assert grips[1].window.loss is None
    for grip in grips[1:3]:
        assert_allclose(grip.window.loss_above, lost, 2e-3)
        assert_allclose(grip.recommended_range[1], (1.0 - LOSS_MARGIN) * lost, 2e-3)
        assert grip.range_end is RangeEnd.LOSS
    assert grips[3].window.loss_above is None
    assert (grips[3].recommended_range[1], grips[3].range_end) == (95.0e3, RangeEnd.LIMIT)


@pytest.mark.parametrize("elements", [90, 180])
def test_a_window_begins_where_the_end_is_no_longer_curled(elements):
    """Thin objects: from the wrap on it bridges half a tube, then less and less."""
    setup = replace(lay_into_coil(GRIPPER, 0.0074), elements=elements)
    window = grip_window(setup)
    assert window.onset_curling is None
    assert window.at(1.005 * window.onset_wrap).regime is WrapRegime.PERFECT_WRAP
    assert window.at(0.97 * window.onset_wrap).regime is WrapRegime.CURLING
