# SPDX-License-Identifier: Apache-2.0
"""Rods against closed forms: helices, elastica, beams, cables."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.rod_cases import COUPLED, six, straight_rod
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

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
    RodCertificate,
    RodLoad,
    RodProblem,
    Section,
    solve_rod,
)

LENGTH, BENDING = 0.5, 3e-4
PLAIN = Section((2e-4, BENDING, BENDING))
SMALL = 2e-6


def helix(strain: tuple[float, float, float], sites: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and rotations of a rod of constant strain: the exponential of its twist."""
    u = np.array(strain)
    twist = np.zeros((4, 4))
    twist[:3, :3] = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
    twist[0, 3] = 1.0
    frames = expm(sites[:, None, None] * twist)
    return frames[:, :3, 3], frames[:, :3, :3]


@pytest.mark.parametrize("elements", [2, 3, 7, 24, 100])
@pytest.mark.parametrize(
    "strain",
    [
        (-13.5, 0.0, 21.0),
        (13.5, 4.0, 21.0),
        (0.0, 0.0, 21.0),
        (15.0, 0.0, 0.0),
        (1e-9, 0.0, 21.0),
        (-13.5, 0.0, 1e-9),
        (1e-7, 0.0, 1e-8),
        (0.0, 0.0, 0.0),
    ],
)
@pytest.mark.parametrize("section", [PLAIN, COUPLED], ids=["plain", "coupled"])
def test_an_unloaded_rod_is_the_exact_helix(
    strain: tuple[float, float, float], elements: int, section: Section
) -> None:
    length = min(0.36, 1.2 * elements / max(1.0, math.hypot(*strain)))
    rod = Rod(length, section, rest_strain=strain)
    state = solve_rod(rod, elements=elements, estimate_error=False)
    positions, rotations = helix(strain, state.arc_lengths)
    assert state.stable
    assert np.abs(state.positions - positions).max() < 1e-9 * length
    turned = Rotation.from_quat(state.orientations).as_matrix()
    # The tolerance on the moments, 1e-8 EI/L, lets an orientation be off by as much at worst.
    assert np.abs(turned - rotations).max() < 1e-8
    np.testing.assert_allclose(state.strains, np.tile(strain, (elements + 1, 1)), atol=1e-6)
    assert abs(state.energy) < 1e-12
    assert state.folds == 0


def small(section: object, load: RodLoad, **given: object) -> RodProblem:
    return RodProblem(Rod(LENGTH, section), load, **given)


def stepped(s: np.ndarray) -> np.ndarray:
    """Return the stiffness of a beam whose first 200 mm are five times as stiff."""
    return np.where(s < 0.2, 5.0, 1.0)[:, None] * BENDING * (0.7, 1.0, 1.0)


DOWN = (0.0, 0.0, -SMALL)
TILT = 0.7
# Unlike stiffnesses, turned by the clamp: components along both axes superpose.
FLAT = Section((2e-4, 2e-4, 8e-4))
TILTED = Clamped((0, 0, 0), (math.sin(TILT / 2), 0.0, 0.0, math.cos(TILT / 2)))
CANTILEVER = LENGTH**3 / 3.0
# A small load, and where it brings the tip.
DEFLECTIONS = {
    "shearing": (
        small(Section(PLAIN.stiffness, shear=0.01), RodLoad(tip_force=DOWN)),
        (0, -SMALL * (CANTILEVER / BENDING + LENGTH / 0.01)),
    ),
    "flat, turned": (
        small(FLAT, RodLoad(tip_force=DOWN), base=TILTED),
        (
            SMALL * CANTILEVER * math.sin(TILT) * math.cos(TILT) * (1 / 2e-4 - 1 / 8e-4),
            -SMALL * CANTILEVER * (math.sin(TILT) ** 2 / 8e-4 + math.cos(TILT) ** 2 / 2e-4),
        ),
    ),
    # The moment-area theorem.
    "stepped": (
        RodProblem(Rod(LENGTH, stepped, breaks=(0.2,)), RodLoad(tip_force=DOWN)),
        (0, -SMALL / 3.0 / BENDING * ((LENGTH**3 - 0.027) / 5.0 + 0.027)),
    ),
}


@pytest.mark.parametrize("elements", [10, 20])
@pytest.mark.parametrize("name", DEFLECTIONS)
def test_small_deflections_are_those_of_beam_theory(name: str, elements: int) -> None:
    problem, expected = DEFLECTIONS[name]
    state = solve_rod(problem, elements=elements)
    assert all(np.abs(state.arc_lengths - at).min() < 1e-15 for at in problem.rod.breaks)
    # What is left out is of second order in the deflection.
    assert state.tip_position[1:] == pytest.approx(expected, rel=2e-5, abs=1e-10)


SIX = np.diag((2e-4, 3e-4, 3e-4, 40.0, 20.0, 20.0))
SIX[0, 3] = SIX[3, 0] = 0.03


def test_a_pulled_rod_stretches_and_twists_by_its_coupling() -> None:
    """A helix of fibers twists so."""
    force, moment = 2.0, 1e-4
    load = RodLoad(tip_force=(force, 0.0, 0.0), tip_moment=(moment, 0.0, 0.0))
    state = solve_rod(Rod(LENGTH, Section(SIX)), load, elements=10)
    twist, stretch = np.linalg.solve(SIX[::3, ::3], (moment, force))
    assert state.tip_position[0] == pytest.approx(LENGTH * (1.0 + stretch), rel=1e-9)
    half = 0.5 * (twist * LENGTH % math.tau)
    assert abs(state.orientations[-1, 0]) == pytest.approx(abs(np.sin(half)), rel=1e-3)


@pytest.mark.parametrize("load", [0.5, 2.0, 5.0, 10.0])
def test_a_cantilever_under_a_tip_force_follows_elliptic_integrals(load: float) -> None:
    """P L^2 / EI = load, across: Bisshopp and Drucker (1945)."""

    # With m = k^2 = (1 + sin(tip slope)) / 2 and sin(theta) = 1 / (sqrt(2) k):
    # K(k) - F(theta, k) = sqrt(load).
    def miss(m: float) -> float:
        theta = math.asin(1.0 / math.sqrt(2.0 * m))
        return float(ellipk(m) - ellipkinc(theta, m)) - math.sqrt(load)

    m = brentq(miss, 0.5 + 1e-12, 1.0 - 1e-12, xtol=1e-14)
    theta = math.asin(1.0 / math.sqrt(2.0 * m))
    across = 1.0 - 2.0 / math.sqrt(load) * float(ellipe(m) - ellipeinc(theta, m))
    along = math.sqrt(2.0 * (2.0 * m - 1.0) / load)
    force = load * BENDING / LENGTH**2
    state = solve_rod(Rod(LENGTH, PLAIN), RodLoad(tip_force=(0.0, force, 0.0)), elements=100)
    # At N = 100 the scheme's own error is a few 1e-7 of the length.
    np.testing.assert_allclose(
        state.tip_position / LENGTH, [along, across, 0.0], atol=2e-6 * max(1.0, load / 5.0)
    )
    assert state.moments[0, 2] == pytest.approx(force * along * LENGTH, rel=1e-5)


def test_hanging_straight_is_stable_and_carries_the_weight() -> None:
    state = solve_rod(straight_rod(), RodLoad(distributed=(0.3, 0.0, 0.0), tip_force=(0.1, 0, 0)))
    np.testing.assert_allclose(state.positions[:, 0], state.arc_lengths, atol=1e-15)
    np.testing.assert_allclose(state.forces[:, 0], 0.1 + 0.3 * (0.5 - state.arc_lengths))
    assert state.certificate is RodCertificate.STRICT_MINIMUM
    # All energy is the load's: -F L - w L^2 / 2.
    assert state.energy == pytest.approx(-0.1 * 0.5 - 0.3 * 0.125, rel=1e-12)


@pytest.mark.parametrize("end", ["base", "tip"])
def test_hanging_rod_stretches_under_its_weight(end: str) -> None:
    """By w L^2 / 2 EA, and by F L / EA of a force at its free end."""
    rod = Rod(LENGTH, Section(PLAIN.stiffness, extension=40.0))
    weight, force = 3.0, 2.0
    if end == "base":
        problem = RodProblem(rod, RodLoad((weight, 0.0, 0.0), (force, 0.0, 0.0)))
        grown = solve_rod(problem, elements=40).positions[-1, 0] - LENGTH
    else:
        problem = RodProblem(
            rod,
            RodLoad((-weight, 0.0, 0.0)),
            base=Free(),
            tip=Clamped(),
            point_loads=(PointLoad(0.0, (-force, 0.0, 0.0)),),
        )
        grown = -solve_rod(problem, elements=40).positions[0, 0] - LENGTH
    assert grown == pytest.approx((0.5 * weight * LENGTH + force) * LENGTH / 40.0, rel=1e-9)


def test_rest_strain_that_jumps_at_a_break_is_followed_exactly() -> None:
    """Unloaded: a quarter circle, then a straight piece."""
    at = 0.2
    curvature = 0.5 * math.pi / at

    def strain(s: np.ndarray) -> np.ndarray:
        return np.column_stack((0.0 * s, 0.0 * s, np.where(s < at, curvature, 0.0)))

    for radius in (0.0, 1e-6):  # either element
        rod = Rod(LENGTH, PLAIN, radius, rest_strain=strain, breaks=(at,))
        tip = solve_rod(RodProblem(rod), elements=20).tip_position
        expected = (1.0 / curvature, 1.0 / curvature + LENGTH - at, 0.0)
        assert tip == pytest.approx(expected, abs=1e-6)


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
    state = solve_rod(problem, elements=10)
    assert {at, where} <= set(state.arc_lengths.tolist())
    held = (force * (LENGTH - at) - couple) / LENGTH
    assert state.base_reaction[2] == pytest.approx(held, rel=1e-4)
    assert state.tip_reaction[2] == pytest.approx(force - held, rel=1e-4)
    # Bending about y at the nodes: the moment of what lies before; it jumps by the couple.
    s = state.arc_lengths
    bent = held * s - force * np.maximum(s - at, 0.0)
    inner = ~np.isin(s, (where,))
    expected = np.where(s > where, bent + couple, bent)
    found = np.abs(state.moments[:, 1])
    assert found[inner] == pytest.approx(np.abs(expected)[inner], abs=1e-4 * force * LENGTH)
    assert max(imbalance(problem, state)) < 1e-12


def test_point_load_presses_where_it_acts() -> None:
    """A rod on the floor, and a weight on it."""
    problem = RodProblem(
        Rod(LENGTH, PLAIN, 2e-3),
        RodLoad((0.0, 0.0, -0.02)),
        obstacles=(Obstacle(Plane(), (0.0, 0.0, -2e-3)),),
        point_loads=(PointLoad(0.23, (0, 0, -1.0)),),
    )
    state = solve_rod(problem, elements=50)
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


def test_parts_of_a_section_are_those_of_its_matrix() -> None:
    """At given forces: the condensed stiffness, the compliance, and the moment by the force."""
    section = six(1.0)
    matrix = np.array(section.stiffness)
    inverse = np.linalg.inv(matrix)
    stiffness, compliance, coupling = section.parts
    np.testing.assert_allclose(np.linalg.inv(stiffness), inverse[:3, :3], rtol=1e-9)
    np.testing.assert_allclose(compliance, np.linalg.inv(matrix[3:, 3:]), rtol=1e-12)
    np.testing.assert_allclose(-stiffness @ inverse[:3, 3:], coupling, rtol=1e-9)
    assert not Section((1.0, 2.0, 3.0)).parts[2].any()


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
    state = solve_rod(problem, start=parabola, elements=50)
    assert state.stable
    # Bending stiffness lifts the lowest point in proportion; 50 elements leave 1e-6.
    assert -state.positions[:, 2].min() == pytest.approx(sag, abs=2e-4 * flexibility + 2e-6)
    assert max(imbalance(problem, state)) < 1e-6 * weight * length
