# SPDX-License-Identifier: Apache-2.0
"""Stretch, shear, unlike and coupled stiffness, breaks, point loads and couples: closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from benchmarks.contact_paths import imbalance
from spiral_core import (
    Clamped,
    Free,
    Guided,
    Obstacle,
    Pinned,
    Plane,
    PointLoad,
    Rod,
    RodLoad,
    RodProblem,
    Section,
)
from spiral_core.rod.contact.solve import solve_contact

LENGTH, BENDING = 0.5, 3e-4
PLAIN = Section((2e-4, BENDING, BENDING))


@pytest.mark.parametrize("end", ["base", "tip"])
def test_hanging_rod_stretches_under_its_weight(end: str) -> None:
    """By w L^2 / 2 EA, and by F L / EA of a force at its free end."""
    rod = Rod(LENGTH, Section((2e-4, BENDING, BENDING), extension=40.0))
    weight, force = 3.0, 2.0
    if end == "base":
        problem = RodProblem(rod, RodLoad((weight, 0.0, 0.0), (force, 0.0, 0.0)))
        grown = solve_contact(problem, elements=40).positions[-1, 0] - LENGTH
    else:
        problem = RodProblem(
            rod,
            RodLoad((-weight, 0.0, 0.0)),
            base=Free(),
            tip=Clamped(),
            point_loads=(PointLoad(0.0, (-force, 0.0, 0.0)),),
        )
        grown = -solve_contact(problem, elements=40).positions[0, 0] - LENGTH
    assert grown == pytest.approx((0.5 * weight * LENGTH + force) * LENGTH / 40.0, rel=1e-9)


def test_short_beam_is_timoshenkos() -> None:
    """Tip deflection F L^3 / 3 EI + F L / kappa GA, for small forces."""
    force, shear = 1e-5, 0.01
    rod = Rod(LENGTH, Section((2e-4, BENDING, BENDING), shear=shear))
    state = solve_contact(RodProblem(rod, RodLoad(tip_force=(0.0, 0.0, -force))), elements=8)
    sunk = force * LENGTH**3 / (3.0 * BENDING) + force * LENGTH / shear
    assert -state.positions[-1, 2] == pytest.approx(sunk, rel=1e-4)


def test_coupled_stiffness_bends_and_twists_by_its_inverse() -> None:
    """A couple at the tip of a rod gives every section the strain K^-1 m, in its own frame."""
    rows = ((2e-4, 4e-5, -3e-5), (4e-5, 3e-4, 5e-5), (-3e-5, 5e-5, 6e-4))
    moment = np.array((2e-8, -1e-8, 3e-8))
    x, y, z = moment
    problem = RodProblem(Rod(LENGTH, Section(rows)), RodLoad(tip_moment=(x, y, z)))
    state = solve_contact(problem, elements=16)
    strain = np.linalg.solve(np.array(rows), moment)
    turned = 2.0 * state.orientations[-1, :3]
    assert turned == pytest.approx(strain * LENGTH, rel=1e-4)  # small angles


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.1])
def test_flat_rod_bends_out_of_the_plane_of_its_force(angle: float) -> None:
    """Unlike stiffnesses, turned by the clamp: components along both axes superpose."""
    flat, high, force = 2e-4, 8e-4, 1e-5
    rod = Rod(LENGTH, Section((2e-4, flat, high)))
    turn = (math.sin(0.5 * angle), 0.0, 0.0, math.cos(0.5 * angle))
    problem = RodProblem(rod, RodLoad(tip_force=(0.0, 0.0, -force)), base=Clamped((0, 0, 0), turn))
    tip = solve_contact(problem, elements=12).tip_position
    # Bending about z moves along y, and about y along z; both axes are turned by the angle.
    along_y, along_z = -force * math.sin(angle), -force * math.cos(angle)
    y, z = along_y * LENGTH**3 / (3.0 * high), along_z * LENGTH**3 / (3.0 * flat)
    expected = (
        y * math.cos(angle) - z * math.sin(angle),
        y * math.sin(angle) + z * math.cos(angle),
    )
    assert tip[1:] == pytest.approx(expected, rel=1e-4, abs=1e-9)


def test_stepped_beam_bends_as_its_two_parts() -> None:
    """Stiffness and radius jump at a break; small deflection by the moment-area theorem."""
    at, stiff, force = 0.2, 5.0 * BENDING, 1e-5

    def section(s: np.ndarray) -> np.ndarray:
        return np.where(s < at, stiff, BENDING)[:, None] * (0.7, 1.0, 1.0)

    rod = Rod(LENGTH, section, breaks=(at,))
    problem = RodProblem(rod, RodLoad(tip_force=(0.0, 0.0, -force)))
    sunk = force / 3.0 * ((LENGTH**3 - (LENGTH - at) ** 3) / stiff + (LENGTH - at) ** 3 / BENDING)
    for elements in (5, 10):
        state = solve_contact(problem, elements=elements)
        assert at in state.arc_lengths
        assert -state.positions[-1, 2] == pytest.approx(sunk, rel=1e-5)


def test_rest_strain_that_jumps_at_a_break_is_followed_exactly() -> None:
    """Unloaded: a quarter circle, then a straight piece."""
    at = 0.2
    curvature = 0.5 * math.pi / at

    def strain(s: np.ndarray) -> np.ndarray:
        return np.column_stack((0.0 * s, 0.0 * s, np.where(s < at, curvature, 0.0)))

    rod = Rod(LENGTH, PLAIN, rest_strain=strain, breaks=(at,))
    tip = solve_contact(RodProblem(rod), elements=20).tip_position
    radius = 1.0 / curvature
    assert tip == pytest.approx((radius, radius + LENGTH - at, 0.0), abs=1e-6)


def test_point_loads_and_couples_bend_a_held_beam() -> None:
    """Pinned and guided along itself, with a force and a couple anywhere: Bernoulli's beam."""
    force, couple, at, where = 2e-4, 3e-5, 0.17, 0.31
    problem = RodProblem(
        Rod(LENGTH, PLAIN),
        base=Pinned(),
        tip=Guided((LENGTH, 0.0, 0.0)),
        point_loads=(
            PointLoad(at, force=(0.0, 0.0, -force)),
            PointLoad(where, moment=(0.0, couple, 0.0)),
        ),
    )
    state = solve_contact(problem, elements=10)
    assert {at, where} <= set(state.arc_lengths.tolist())
    held = (force * (LENGTH - at) - couple) / LENGTH
    assert state.base_reaction[2] == pytest.approx(held, rel=1e-4)
    assert state.tip_reaction[2] == pytest.approx(force - held, rel=1e-4)
    # Bending about y at the nodes: the moment of what lies before; it jumps by the couple.
    s = state.arc_lengths
    bent = held * s - force * np.maximum(s - at, 0.0)
    inner = ~np.isin(s, (where,))
    found = state.moments[:, 1]
    expected = np.where(s > where, bent + couple, bent)
    assert np.abs(found)[inner] == pytest.approx(np.abs(expected)[inner], abs=1e-4 * force * LENGTH)
    assert max(imbalance(problem, state)) < 1e-12


def test_point_load_presses_where_it_acts() -> None:
    """A rod on the floor, and a weight on it."""
    floor = Obstacle(Plane(), (0.0, 0.0, -2e-3))
    rod = Rod(LENGTH, PLAIN, 2e-3)
    problem = RodProblem(
        rod,
        RodLoad((0.0, 0.0, -0.02)),
        obstacles=(floor,),
        point_loads=(PointLoad(0.23, (0, 0, -1.0)),),
    )
    state = solve_contact(problem, elements=50)
    node = int(np.argmin(np.abs(state.arc_lengths - 0.23)))
    assert state.normal_forces[0, node] == pytest.approx(1.0 + 0.02 * LENGTH / 50, rel=1e-2)
    assert np.abs(state.positions[:, 2]).max() < 1e-9


@pytest.mark.parametrize("bore", [0.0, 1e-3, 1.999998e-3])
def test_round_section_has_the_stiffness_of_its_shape(bore: float) -> None:
    """Cowper's shear coefficients of a solid round and of a thin tube are his limits."""
    radius, young, shear_modulus = 2e-3, 1.3e6, 0.5e6
    nu = 0.3  # E / 2G - 1
    section = Section.round(radius, young, shear_modulus, bore)
    area = math.pi * (radius**2 - bore**2)
    inertia = 0.25 * math.pi * (radius**4 - bore**4)
    twist, bending, _ = section.stiffness
    assert (twist, bending) == pytest.approx((2.0 * shear_modulus * inertia, young * inertia))
    assert section.extension == pytest.approx(young * area)
    m = (bore / radius) ** 2
    coefficient = 6 * (1 + nu) * (1 + m) ** 2 / ((7 + 6 * nu) * (1 + m) ** 2 + (20 + 12 * nu) * m)
    if bore == 0.0:
        coefficient = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu)
    if bore > 1.9e-3:
        coefficient = 2.0 * (1.0 + nu) / (4.0 + 3.0 * nu)
    # The thin tube's wall is a millionth of its radius.
    assert section.shear == pytest.approx(coefficient * shear_modulus * area, rel=1e-5)


@pytest.mark.parametrize("flexibility", [1.0, 1e-1, 1e-2])
def test_cable_hangs_as_a_catenary_however_flexible(flexibility: float) -> None:
    """Elements are up to 100 times as long as sqrt(EI / F)."""
    length, span, weight = 1.0, 0.8, 3.0
    bending = 1e-5 * flexibility
    u = brentq(lambda u: math.sinh(u) / u - length / span, 1e-3, 5.0)
    sag = 0.5 * span / u * (math.cosh(u) - 1.0)
    x = np.linspace(0.0, span, 61)
    parabola = np.column_stack((x, 0.0 * x, -4.0 * sag * x * (span - x) / span**2))
    problem = RodProblem(
        Rod(length, Section((bending, bending, bending))),
        RodLoad((0.0, 0.0, -weight)),
        Pinned(),
        Pinned((span, 0.0, 0.0)),
    )
    state = solve_contact(problem, start=parabola, elements=50)
    assert state.stable
    # Bending stiffness lifts the lowest point in proportion; 50 elements leave 1e-6.
    assert -state.positions[:, 2].min() == pytest.approx(sag, abs=2e-4 * flexibility + 2e-6)
    assert max(imbalance(problem, state)) < 1e-6 * weight * length
