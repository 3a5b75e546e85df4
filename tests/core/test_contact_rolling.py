# SPDX-License-Identifier: Apache-2.0
"""Friction at a tube's surface, which may roll it, and on its axis: two independent methods."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from core.contact_cases import BENDING, LENGTH, OUTER, grip, rest_strain, wrap_stretch

from benchmarks.explicit import Coil
from spiral_core.rod.contact.solve import follow_contact, solve_contact

RADIUS, FRACTION, FRICTION, ELEMENTS = 0.015, 1.1, 0.3, 60
MILLIMETERS = 3


@pytest.mark.slow
@pytest.mark.parametrize("lever", [OUTER, 0.0], ids=["surface", "axis"])
def test_pull_out_force_is_that_of_an_explicit_simulation(lever: float) -> None:
    """A coil closes without friction and its cylinder is pulled away from the base.

    Where friction acts decides: at the axis it excludes rolling and the force is 2.6 times larger.
    """
    wrapped = wrap_stretch(RADIUS)
    fits = np.array(rest_strain(wrapped))
    curled = np.array(rest_strain(1.0 + FRACTION * (wrapped - 1.0)))
    coil = Coil(LENGTH, BENDING * np.array((2 / 3, 1, 1)), OUTER, RADIUS, fits, lever, ELEMENTS)
    damping, coil.damping = coil.damping, coil.damping / 30.0
    coil.go(150_000, curled)
    _, pressed = coil.go(150_000)
    coil.friction, coil.damping = FRICTION, damping

    def station(friction: float, shift: float = 0.0):
        problem = grip(RADIUS, FRACTION, friction, -shift)
        return replace(problem, rod=replace(problem.rod, friction_radius=lever))

    closed = solve_contact(station(0.0), elements=ELEMENTS)
    # A sixtieth of the coil in an element: the reference's frames lie half of one apart.
    assert pressed == pytest.approx(closed.normal_forces.sum(), rel=0.05)
    shifts = [1e-3 * i for i in range(MILLIMETERS + 1)]
    states = follow_contact([station(FRICTION, shift) for shift in shifts], start=closed).states
    torsion, _, curvature = fits
    axis = np.array((torsion, 0.0, curvature)) / math.hypot(torsion, curvature)
    for _ in states[1:]:
        along, _ = coil.go(200_000, move=-1e-3)
    ours = states[-1].on_obstacle().force @ axis
    assert along == pytest.approx(ours, rel=0.04)
    assert ours == pytest.approx(0.595 if lever else 1.597, rel=0.03)
