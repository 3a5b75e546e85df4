# SPDX-License-Identifier: Apache-2.0
"""A closing in time against an independent simulation: explicit, with springs that slide."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from core.contact_cases import BENDING, LENGTH, OUTER, grip, rest_strain, wrap_stretch

from benchmarks.explicit import Coil
from spiral_core import Damping, Inertia, RodProblem, solve_motion

RADIUS, FRICTION, ELEMENTS = 0.015, 0.3, 60
MASS, ROTARY, DRAG = 0.0283, 0.0283 * 1.3e-5, 2.0
# Time of the closing and after it [s]; the pull [m/s] and how long it lasts [s].
CLOSES, RESTS, PULL, PULLS = 4.0, 2.0, 0.01, 1.0


@pytest.mark.slow
def test_a_closing_within_four_seconds_is_that_of_an_explicit_simulation() -> None:
    wrapped = wrap_stretch(RADIUS)
    fits = np.array(rest_strain(wrapped))
    curled = np.array(rest_strain(1.0 + 1.1 * (wrapped - 1.0)))
    axis = fits / np.linalg.norm(fits)
    away = axis * np.sign(fits[0])  # the coil advances this way
    coil = Coil(
        LENGTH, BENDING * np.array((2 / 3, 1, 1)), OUTER, RADIUS, fits, 0.0, ELEMENTS, FRICTION,
        MASS, ROTARY, DRAG,
    )  # fmt: skip
    coil.straighten()
    coil.go(int(CLOSES / coil.step), curled)
    coil.go(int(RESTS / coil.step))
    touching = coil.touching()
    pulls = 5
    moves = PULL * PULLS / pulls * float(away @ axis)
    theirs = [coil.go(int(PULLS / pulls / coil.step), move=moves)[0] for _ in range(pulls)]

    def problem(time: float) -> RodProblem:
        closed = grip(RADIUS, 1.1, FRICTION)
        strain = min(time / CLOSES, 1.0) * curled
        rod = replace(closed.rod, rest_strain=tuple(strain.tolist()), friction_radius=0.0)
        shift = PULL * max(0.0, time - CLOSES - RESTS) * away
        (obstacle,) = closed.obstacles
        return replace(closed, rod=rod, obstacles=(obstacle.moved(tuple(shift.tolist())),))

    line = np.zeros((ELEMENTS + 1, 3))
    line[:, 0] = np.linspace(0.0, LENGTH, ELEMENTS + 1)
    closed = CLOSES + RESTS
    times = [0.0, closed, *(closed + np.linspace(0.0, PULLS, 21)[1:])]
    damping = Damping(0.0, 0.0, DRAG)
    motion = solve_motion(problem, Inertia(MASS, ROTARY), times, damping=damping, start=line)
    ours = [frame.state.on_obstacle().force @ away for frame in motion.frames[1:]]
    assert motion.contact_fractions[1] == pytest.approx(touching, abs=0.05)
    assert max(ours, key=abs) == pytest.approx(max(theirs, key=abs) * (away @ axis), rel=0.05)
    assert abs(max(ours, key=abs)) == pytest.approx(1.6, rel=0.05)
