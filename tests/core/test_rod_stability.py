# SPDX-License-Identifier: Apache-2.0
"""Buckling, certificates, and rods of every kind solved."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.rod_cases import gripper_rod, random_direction

from spiral_core import Rod, RodLoad, Section, solve_rod
from spiral_core.rod._arrays import discretize
from spiral_core.rod._elimination import newton_pass, scales_of

GREENHILL = (
    2.25 * 1.8663508588738948**2
)  # j, the first zero of the Bessel function J(-1/3), squared


@pytest.mark.parametrize("elements", [12, 24, 48])
def test_the_critical_length_of_an_upright_rod_is_greenhills(elements: int) -> None:
    """Bisection on the sign of the straight state's pivot."""

    def pivot(length: float) -> float:
        rod = Rod(length, Section.inextensible(1.0, 0.7))
        system = discretize(rod, RodLoad(distributed=(-1.0, 0.0, 0.0)), (elements,))
        q = np.zeros((elements + 1, 4))
        q[:, 3] = 1.0
        gains, offsets = np.empty((elements - 1, 9)), np.empty((elements, 3))
        return float(newton_pass(q, system, 0.0, scales_of(system), gains, offsets).pivot)

    low, high = 1.5, 2.5
    assert pivot(low) > 0.0 > pivot(high)
    while high - low > 1e-13:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if pivot(middle) > 0.0 else (low, middle)
    # Of fourth order: measured 0.2 (h / L)^4, that is 9e-6, 6e-7 and 4e-8.
    assert low == pytest.approx(GREENHILL ** (1.0 / 3.0), rel=0.25 / elements**4 + 5e-9)


@pytest.mark.parametrize(("critical", "bent"), [(0.9, False), (0.99, False), (1.05, True)])
def test_an_upright_rod_stays_straight_or_ends_bent(critical: float, bent: bool) -> None:
    length = critical * GREENHILL ** (1.0 / 3.0)
    rod = Rod(length, Section.inextensible(1.0, 0.7))
    state = solve_rod(rod, RodLoad(distributed=(-1.0, 0.0, 0.0)))
    assert state.stable
    aside = math.hypot(*state.tip_position[1:]) / length
    assert aside > 0.1 if bent else aside < 1e-9
    if bent:
        straight = 0.5 * length**2
        assert state.energy < straight - 1e-4


def test_planar_rods_fall_out_of_plane() -> None:
    """Without torsion the plane is a symmetry; where it holds no minimum the rod must leave it."""
    rng = np.random.default_rng(5)
    for _ in range(60):
        angle = rng.uniform(0.0, 2.0 * math.pi)
        case = gripper_rod(
            length=rng.uniform(0.1, 1.0),
            modulus=rng.uniform(0.5e6, 3.0e6),
            curvature=rng.uniform(3.0, 60.0),
            torsion=0.0,
            gravity=(math.cos(angle), math.sin(angle), 0.0),
        )
        assert solve_rod(case.rod, case.load, estimate_error=False).stable


def test_three_hundred_random_rods_are_solved_and_certified() -> None:
    rng = np.random.default_rng(20)
    iterations = []
    for _ in range(300):
        curvature = rng.uniform(3.0, 60.0)
        length = rng.uniform(0.1, 1.0)
        case = gripper_rod(length, gravity=random_direction(rng))
        assert not callable(case.load.distributed)
        weight = length * math.hypot(*case.load.distributed) * rng.uniform(0.0, 1.0)
        x, y, z = random_direction(rng)
        case = gripper_rod(
            length=length,
            modulus=rng.uniform(0.5e6, 3.0e6),
            curvature=curvature,
            torsion=rng.uniform(-0.95, 0.95) * curvature,
            gravity=random_direction(rng),
            tip_force=(weight * x, weight * y, weight * z),
        )
        state = solve_rod(case.rod, case.load, estimate_error=False)
        assert state.stable
        assert state.residual <= 1e-8
        assert np.isfinite(state.positions).all()
        iterations.append(state.iterations)
    assert np.median(iterations) < 90  # measured: 62, most of them on few elements


@pytest.mark.parametrize("moment", [(0.0, 2e-3, 0.0), (3e-4, 2e-4, -5e-4), (1e-3, 0.0, 0.0)])
def test_dead_tip_moments_are_reached(moment: tuple[float, float, float]) -> None:
    """Some need the moment on from the start of the path, some need it to grow."""
    case = gripper_rod(tip_moment=moment)
    assert solve_rod(case.rod, case.load).stable


def test_a_varied_rod_reaches_its_dead_tip_moment() -> None:
    rod = Rod(
        0.4,
        Section.varying(lambda s: 2.5e-4 * (1.0 + 0.5 * s), lambda s: 1.7e-4 * (1.0 - 0.8 * s)),
        rest_strain=lambda s: np.column_stack((-12.0 + 9.0 * s, 3.0 * s, 22.0 - 20.0 * s)),
    )
    load = RodLoad(
        distributed=lambda s: np.column_stack((0.2 + 0.3 * s, 0.1 * s, -0.2 + s * s)),
        tip_force=(0.01, -0.02, 0.015),
        tip_moment=(3e-4, 2e-4, -5e-4),
    )
    assert solve_rod(rod, load, elements=60).stable
