# SPDX-License-Identifier: Apache-2.0
"""Buckling, certificates, neutral modes, and rods of every kind solved."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from core.rod_cases import drawn, gripper_rod, random_direction
from numpy.linalg import norm
from scipy.spatial.transform import Rotation

from spiral_core import Rod, RodElement, RodLoad, RodProblem, Section, solve_rod
from spiral_core.rod.state import RodCertificate

# 9/4 times the square of the first zero of the Bessel function J(-1/3).
GREENHILL = 2.25 * 1.8663508588738948**2
ROUND = Section.inextensible(1.0, 0.66)
UNLIKE = Section.inextensible(1.0, 0.66, sideways=1.001)
UPRIGHT = RodLoad((-1.0, 0.0, 0.0))


@pytest.mark.parametrize("elements", [12, 48])
def test_the_critical_length_of_an_upright_rod_is_greenhills(elements):
    """Straight below it, bent above it."""
    # Of fourth order: measured 0.2 (h / L)^4, that is 9e-6, 6e-7 and 4e-8.
    off = 0.22 / elements**4 + 1e-6
    straight, bent = (
        solve_rod(Rod(GREENHILL ** (1.0 / 3.0) * part, ROUND), UPRIGHT, elements=elements)
        for part in (1.0 - off, 1.0 + off)
    )
    assert norm(straight.tip_position[1:]) < 1e-6 < norm(bent.tip_position[1:])
    assert straight.smallest_pivot < 1e-4  # it vanishes there


@pytest.mark.parametrize(
    ("tilt", "heaviness"), [*product((0.0, 1e-12, 1e-9, 1e-3), (9.0, 60.0, 1000.0))]
)
def test_a_straight_rod_buckles_to_the_side_it_leans_to(tilt, heaviness):
    """Upright: a circle of equal minima. However small a tilt, it picks one of them."""
    load = RodLoad((-heaviness * math.cos(tilt), 0.6 * heaviness * math.sin(tilt), 0.0))
    state = solve_rod(Rod(1.0, ROUND), load)
    if tilt == 0.0:
        for one in (state, solve_rod(Rod(1.0, ROUND), load, element=RodElement.MIXED)):
            assert one.neutral_modes == 1
            assert one.certificate is RodCertificate.STABLE_UP_TO_ROTATION
        # Turned about the axis it is one of the same energy, and as good a solution.
        turn = Rotation.from_rotvec((1.1, 0.0, 0.0))
        there = (turn * Rotation.from_quat(state.orientations) * turn.inv()).as_quat()
        turned = solve_rod(Rod(1.0, ROUND), load, start=replace(state, orientations=there))
        assert (turned.folds, turned.neutral_modes) == (0, 1)
        assert turned.energy == pytest.approx(state.energy, rel=1e-12)
        assert turned.tip_position == pytest.approx(turn.apply(state.tip_position), abs=1e-9)
        return
    assert state.certificate is RodCertificate.STRICT_MINIMUM or tilt < 1e-6
    _, y, z = state.tip_position
    assert abs(z) <= 0.01
    assert math.hypot(y, z) > 0.05
    assert state.positions[:, 1].sum() > 0.0  # the load pulls it to +y


RNG = np.random.default_rng(20)
MANY = {
    "upright": [gripper_rod(x, gravity=(-1.0, 0.0, 0.0)) for x in np.linspace(0.3, 1.0, 15)],
    # Straight, twisted and bent.
    "along axes": [
        RodProblem(Rod(1.0, section, rest_strain=strain), RodLoad(size * axis, (pull, 0, 0)))
        for section, axis, size, pull, strain in product(
            (ROUND, UNLIKE),
            np.eye(3),
            (-200, -20, 20, 200),
            (-5, 0, 5),
            ((0, 0, 0), (9, 0, 0), (0, 0, 14)),
        )
    ],
    # Some moments need to be on from the start of the path, some need to grow.
    "dead moments": [
        gripper_rod(tip_moment=moment)
        for moment in ((0.0, 2e-3, 0.0), (3e-4, 2e-4, -5e-4), (1e-3, 0.0, 0.0))
    ],
    # The plane is a symmetry: where it holds no minimum the rod must leave it.
    "planar": [
        drawn(
            RNG,
            (3.0, 0.1, 0.5e6, 0.0),
            (60.0, 1.0, 3.0e6, 0.0),
            gravity=(math.cos(angle), math.sin(angle), 0.0),
        )
        for angle in RNG.uniform(0.0, math.pi, 30)
    ],
    # Of any shape, under its weight and a force of about that at its tip.
    "loaded": [
        drawn(
            RNG,
            (3.0, 0.1, 0.5e6, -0.95),
            (60.0, 1.0, 3.0e6, 0.95),
            tip_force=np.multiply(pull, random_direction(RNG)),
        )
        for pull in RNG.uniform(0.0, 0.144, 150)
    ],
    # It moves far under a small imbalance.
    "soft": [
        gripper_rod(length, 0.5e6, curvature, gravity=(-1.0, *lean))
        for length, curvature, *lean in RNG.uniform(
            (0.8, 3.0, -2e-4, -2e-4), (1.0, 10.0, 2e-4, 2e-4), (10, 4)
        )
    ],
}


@pytest.mark.parametrize("kind", MANY)
def test_rods_of_every_kind_are_solved_and_certified(kind):
    """And in their shapes, not only in their forces: polished further, the tip stays."""
    for case in MANY[kind]:
        state = solve_rod(case)
        assert state.certificate is RodCertificate.STRICT_MINIMUM or case.rod.section is ROUND
        assert state.residual <= 1e-8
        assert state.last_step <= 1e-6
        again = solve_rod(case, start=state, estimate_error=False)
        moved = norm(again.tip_position - state.tip_position)
        assert moved < 1e-6 * case.rod.length + state.discretization_error
