# SPDX-License-Identifier: Apache-2.0
"""A closing in time against an independent simulation: explicit, with springs that slide."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from core.contact_cases import LENGTH, OUTER, curled, grip, line
from core.test_contact_rolling import ELEMENTS, FITS, FRICTION, RADIUS, STIFFNESS
from numpy.testing import assert_allclose

from benchmarks.explicit import Coil
from spiral_core import Damping, Inertia, solve_motion

MASS, ROTARY, DRAG = 0.0283, 0.0283 * 1.3e-5, 2.0
CLOSES, CLOSED = 4.0, 6.0  # [s]; then it is pulled by 1 cm/s for 1 s


@pytest.mark.slow
def test_a_closing_within_four_seconds_is_that_of_an_explicit_simulation():
    bent, pull = np.array(curled(RADIUS, 1.1)), 0.01 * FITS / np.linalg.norm(FITS)
    pull *= np.sign(FITS[0])  # the coil advances this way
    coil = Coil(LENGTH, STIFFNESS, OUTER, RADIUS, FITS, 0.0, ELEMENTS, FRICTION, MASS, ROTARY, DRAG)
    coil.straighten()
    coil.go(int(CLOSES / coil.step), bent)
    coil.go(int((CLOSED - CLOSES) / coil.step))
    touching, moves = coil.touching(), 0.2 * 0.01 * np.sign(FITS[0])
    theirs = max((coil.go(int(0.2 / coil.step), move=moves)[0] for _ in range(5)), key=abs)

    def problem(time):
        wrapped = grip(RADIUS, 1.1, FRICTION)
        rod = replace(wrapped.rod, rest_strain=min(time / CLOSES, 1.0) * bent, friction_radius=0.0)
        moved = wrapped.obstacles[0].moved(max(0.0, time - CLOSED) * pull)
        return replace(wrapped, rod=rod, obstacles=(moved,))

    motion = solve_motion(
        problem,
        Inertia(MASS, ROTARY),
        [0.0, *np.linspace(CLOSED, CLOSED + 1.0, 21)],
        damping=Damping(0.0, 0.0, DRAG),
        start=line(LENGTH, ELEMENTS),
    )
    forces = (frame.state.on_obstacle().force @ FITS for frame in motion.frames[1:])
    ours = max(forces, key=abs) / np.linalg.norm(FITS)
    assert_allclose(motion.contact_fractions[1], touching, 0, 0.05)
    assert_allclose(ours, theirs, 0.05)
    assert_allclose(abs(ours), 1.6, 0.05)
