# SPDX-License-Identifier: Apache-2.0
"""A rod that could go to either side goes to one of them."""

from __future__ import annotations

import math

import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from spiral_core import (
    ContactProblem,
    ElasticRod,
    Obstacle,
    RodLoad,
    Section,
    Sphere,
    solve_contact,
)

pytestmark = pytest.mark.long


@pytest.mark.parametrize("load", [1.001, 1.1, 1.5])
def test_straight_column_above_its_load_is_eulers_elastica(load: float) -> None:
    """Its tip's place by elliptic integrals: K(k) = sqrt(P / EI) L = pi / 2 sqrt(P / P_c)."""
    length, bending = 0.5, 1e-3
    force = load * math.pi**2 * bending / (4.0 * length**2)
    root = math.sqrt(force / bending)
    k = brentq(lambda k: ellipk(k * k) - root * length, 1e-6, 0.999999)
    height, aside = 2.0 * ellipe(k * k) / root - length, 2.0 * k / root
    rod = ElasticRod(length, Section((bending, bending, bending)))
    state = solve_contact(ContactProblem(rod, RodLoad(tip_force=(-force, 0.0, 0.0))), elements=40)
    assert state.stable
    x, y, z = state.tip_position
    # 40 elements are off by 1e-6; near the critical load that counts more.
    assert x == pytest.approx(height, abs=1e-5)
    assert math.hypot(y, z) == pytest.approx(aside, abs=1e-4)


def test_rod_on_top_of_a_ball_falls_beside_it() -> None:
    ball = Obstacle(Sphere(0.03), (0.2, 0.0, -0.05))
    rod = ElasticRod(0.4, Section((1e-3, 1e-3, 1e-3)), 2e-3)
    problem = ContactProblem(rod, RodLoad((0.0, 0.0, -3.0)), obstacles=(ball,))
    state = solve_contact(problem, elements=60)
    assert state.stable
    assert not state.touching.any()
    assert state.tip_position[2] < -0.35
