# SPDX-License-Identifier: Apache-2.0
"""A closing in time against an independent simulation: explicit, with springs that slide."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from core.contact_cases import LENGTH, OUTER, curled, grip
from core.test_contact_rolling import ELEMENTS, FITS, FRICTION, RADIUS, STIFFNESS

from benchmarks.explicit import Coil
from spiral_core import Damping, Inertia, solve_motion

MASS, ROTARY, DRAG = 0.0283, 0.0283 * 1.3e-5, 2.0
# Time of the closing and after it [s]; the pull [m/s] and how long it lasts [s].
CLOSES, RESTS, PULL, PULLS = 4.0, 2.0, 0.01, 1.0


@pytest.mark.slow
def test_a_closing_within_four_seconds_is_that_of_an_explicit_simulation():
    bent = np.array(curled(RADIUS, 1.1))
    axis = FITS / np.linalg.norm(FITS)
    away = axis * np.sign(FITS[0])  # the coil advances this way
    coil = Coil(LENGTH, STIFFNESS, OUTER, RADIUS, FITS, 0.0, ELEMENTS, FRICTION, MASS, ROTARY, DRAG)
    coil.straighten()
    coil.go(int(CLOSES / coil.step), bent)
    coil.go(int(RESTS / coil.step))
    touching = coil.touching()
    moves = 0.2 * PULL * PULLS * float(away @ axis)
    theirs = [coil.go(int(0.2 * PULLS / coil.step), move=moves)[0] for _ in range(5)]

    def problem(time):
        wrapped = grip(RADIUS, 1.1, FRICTION)
        strain = min(time / CLOSES, 1.0) * bent
        rod = replace(wrapped.rod, rest_strain=(*strain.tolist(),), friction_radius=0.0)
        shift = PULL * max(0.0, time - CLOSES - RESTS) * away
        return replace(wrapped, rod=rod, obstacles=(wrapped.obstacles[0].moved((*shift,)),))

    line = np.linspace((0.0, 0.0, 0.0), (LENGTH, 0.0, 0.0), ELEMENTS + 1)
    closed = CLOSES + RESTS
    times = [0.0, closed, *(closed + np.linspace(0.0, PULLS, 21)[1:])]
    damping = Damping(0.0, 0.0, DRAG)
    motion = solve_motion(problem, Inertia(MASS, ROTARY), times, damping=damping, start=line)
    ours = [frame.state.on_obstacle().force @ away for frame in motion.frames[1:]]
    assert motion.contact_fractions[1] == pytest.approx(touching, abs=0.05)
    assert max(ours, key=abs) == pytest.approx(max(theirs, key=abs) * (away @ axis), rel=0.05)
    assert abs(max(ours, key=abs)) == pytest.approx(1.6, rel=0.05)
