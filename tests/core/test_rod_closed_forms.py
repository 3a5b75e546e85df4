# SPDX-License-Identifier: Apache-2.0
"""Rods against closed forms: helices, elastica, beams, cables."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.rod_cases import COUPLED, SIX, cross_matrix
from numpy.testing import assert_allclose
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from benchmarks.contact_paths import imbalance
from spiral_core import (
    Clamped,
    Free,
    Guided,
    Pinned,
    PointLoad,
    Rod,
    RodElement,
    RodLoad,
    RodProblem,
    Section,
    solve_rod,
)

LENGTH, BENDING = 0.5, 3e-4
PLAIN = Section((2e-4, BENDING, BENDING))


@pytest.mark.parametrize("elements", [2, 3, 100])
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
def test_an_unloaded_rod_is_the_exact_helix(strain, elements, section):
    """The exponential of its twist."""
    length = min(0.36, 1.2 * elements / max(1.0, math.hypot(*strain)))
    rod = Rod(length, section, rest_strain=strain)
    state = solve_rod(rod, elements=elements, estimate_error=False)
    twist = np.zeros((4, 4))
    twist[:3, :3], twist[0, 3] = cross_matrix(strain), 1.0
    frames = expm(state.arc_lengths[:, None, None] * twist)
    assert state.stable
    assert np.abs(state.positions - frames[:, :3, 3]).max() < 1e-9 * length
    turned = Rotation.from_quat(state.orientations).as_matrix()
    # The tolerance on the moments, 1e-8 EI/L, lets an orientation be off by as much at worst.
    assert np.abs(turned - frames[:, :3, :3]).max() < 1e-8
    assert_allclose(state.strains, np.tile(strain, (elements + 1, 1)), atol=1e-6)
    assert abs(state.energy) < 1e-12
    assert state.folds == 0


def elastica(load):
    """Return a cantilever of P L^2 / EI = load, across: Bisshopp and Drucker (1945).

    With m = k^2 = (1 + sin(tip slope)) / 2 and sin(theta) = 1 / (sqrt(2) k):
    K(k) - F(theta, k) = sqrt(load).
    """

    def theta(m):
        return math.asin(1.0 / math.sqrt(2.0 * m))

    m = brentq(
        lambda m: ellipk(m) - ellipkinc(theta(m), m) - math.sqrt(load),
        *(0.5 + 1e-12, 1.0 - 1e-12),
        xtol=1e-14,
    )
    across = 1.0 - 2.0 / math.sqrt(load) * (ellipe(m) - ellipeinc(theta(m), m))
    force = (0.0, load * BENDING / LENGTH**2, 0.0)
    along = math.sqrt(2.0 * (2.0 * m - 1.0) / load)
    problem = RodProblem(Rod(LENGTH, PLAIN), RodLoad(tip_force=force))
    return problem, [LENGTH * along, LENGTH * across, 0.0]


def quarter(s):
    """Return the rest strain of a quarter circle with a straight piece behind it."""
    return np.where(s[:, None] < 0.2, (0.0, 0.0, 2.5 * math.pi), 0.0)


SMALL = 2e-6
HANGING = Rod(LENGTH, Section(PLAIN.stiffness, extension=40.0))
# Where the tip comes to lie, and how nearly.
TIPS = {
    # What is left out is of second order in the deflection.
    "shearing": (
        RodProblem(
            Rod(LENGTH, Section(PLAIN.stiffness, shear=0.01)),
            RodLoad(tip_force=(0.0, 0.0, -SMALL)),
        ),
        [LENGTH, 0, -SMALL * (LENGTH**3 / 3.0 / BENDING + LENGTH / 0.01)],
        (2e-7, 1e-9, 1e-9),
    ),
    # By w L^2 / 2 EA and F L / EA.
    "hanging from its tip": (
        RodProblem(
            *(HANGING, RodLoad((-3.0, 0.0, 0.0)), Free(), Clamped()),
            point_loads=(PointLoad(0.0, (-2.0, 0.0, 0.0)),),
        ),
        [LENGTH * (1.0 + (0.5 * 3.0 * LENGTH + 2.0) / 40.0), 0, 0],
        1e-10,
    ),
    "a quarter circle, then straight": (
        RodProblem(Rod(LENGTH, PLAIN, 1e-6, rest_strain=quarter, breaks=(0.2,))),
        [0.4 / math.pi, 0.4 / math.pi + 0.3, 0.0],
        1e-9,
    ),
    **{f"elastica {load}": (*elastica(load), 1e-6 * max(1.0, load / 5.0)) for load in (0.5, 10.0)},
}


@pytest.mark.parametrize("name", TIPS)
def test_a_tip_lies_where_closed_forms_have_it(name):
    problem, expected, off = TIPS[name]
    state = solve_rod(problem, elements=100)
    assert (np.abs(state.tip_position - state.positions[0] - expected) < off).all()
    assert {*problem.rod.breaks} <= {*state.arc_lengths.round(15)}


@pytest.mark.parametrize("element", RodElement)
@pytest.mark.parametrize("load", [1.001, 1.1, 1.5])
def test_straight_column_under_its_load_is_eulers_elastica(load, element):
    """Its tip's place by elliptic integrals: K(k) = sqrt(P / EI) L = pi / 2 sqrt(P / P_c)."""
    root = 0.5 * math.pi * math.sqrt(load) / LENGTH
    k = brentq(lambda k: ellipk(k * k) - root * LENGTH, 1e-6, 0.999999)
    thrust = RodLoad(tip_force=(-BENDING * root**2, 0.0, 0.0))
    state = solve_rod(Rod(LENGTH, PLAIN), thrust, elements=40, element=element)
    assert state.stable
    x, y, z = state.tip_position
    # 40 elements are off by 1e-6; near the critical load that counts more.
    assert x == pytest.approx(2.0 * ellipe(k * k) / root - LENGTH, abs=1e-5)
    assert math.hypot(y, z) == pytest.approx(2.0 * k / root, abs=1e-4)


def test_point_loads_and_couples_bend_a_held_beam():
    """Pinned and guided along itself, with a force and a couple anywhere: Bernoulli's beam."""
    force, couple, at, where = 2e-4, 3e-5, 0.17, 0.31
    loads = PointLoad(at, (0.0, 0.0, -force)), PointLoad(where, moment=(0.0, couple, 0.0))
    problem = RodProblem(
        Rod(LENGTH, PLAIN), base=Pinned(), tip=Guided((LENGTH, 0.0, 0.0)), point_loads=loads
    )
    state = solve_rod(problem, elements=10)
    held = (force * (LENGTH - at) - couple) / LENGTH
    assert state.base_reaction[2] == pytest.approx(held, rel=1e-4)
    assert state.tip_reaction[2] == pytest.approx(force - held, rel=1e-4)
    # Bending about y at the nodes: the moment of what lies before; it jumps by the couple.
    s = state.arc_lengths
    assert {at, where} <= {*s}
    bent = np.abs(held * s - force * np.maximum(s - at, 0.0) + couple * (s > where))
    off = np.abs(np.abs(state.moments[:, 1]) - bent)[s != where]
    assert off.max() < 1e-4 * force * LENGTH
    assert max(imbalance(problem, state)) < 1e-12


NU = 0.3  # E / 2G - 1


@pytest.mark.parametrize(
    ("bore", "coefficient"),
    [
        (0.0, 6.0 * (1.0 + NU) / (7.0 + 6.0 * NU)),
        # m = 1 / 4
        (1e-3, 6.0 * (1.0 + NU) * 1.5625 / ((7.0 + 6.0 * NU) * 1.5625 + (20.0 + 12.0 * NU) / 4.0)),
        # The thin tube's wall is a millionth of its radius.
        (1.999998e-3, 2.0 * (1.0 + NU) / (4.0 + 3.0 * NU)),
    ],
)
def test_round_section_has_the_stiffness_of_its_shape(bore, coefficient):
    """Cowper's shear coefficients of a solid round and of a thin tube are his limits."""
    section = Section.round(2e-3, 1.3e6, 0.5e6, bore)
    area = math.pi * (2e-3**2 - bore**2)
    inertia = 0.25 * math.pi * (2e-3**4 - bore**4)
    assert section.stiffness[:2] == pytest.approx((1e6 * inertia, 1.3e6 * inertia))
    assert section.extension == pytest.approx(1.3e6 * area)
    assert section.shear == pytest.approx(coefficient * 0.5e6 * area, rel=1e-5)


def test_parts_of_a_section_are_those_of_its_matrix():
    """At given forces: the condensed stiffness, the compliance, and the moment by the force."""
    matrix = np.array(SIX.stiffness)
    inverse = np.linalg.inv(matrix)
    stiffness, compliance, coupling = SIX.parts
    assert_allclose(np.linalg.inv(stiffness), inverse[:3, :3], rtol=1e-9)
    assert_allclose(compliance, np.linalg.inv(matrix[3:, 3:]), rtol=1e-12)
    assert_allclose(-stiffness @ inverse[:3, 3:], coupling, rtol=1e-9)
    assert not PLAIN.parts[2].any()


@pytest.mark.parametrize("flexibility", [1.0, 1e-2])
def test_cable_hangs_as_a_catenary_however_flexible(flexibility):
    """Elements are up to 100 times as long as sqrt(EI / F)."""
    span, weight = 0.8, 3.0
    u = brentq(lambda u: math.sinh(u) / u - 1.0 / span, 1e-3, 5.0)
    sag = 0.5 * span / u * (math.cosh(u) - 1.0)
    x = np.linspace(0.0, span, 61)
    parabola = np.column_stack((x, 0.0 * x, -4.0 * sag * x * (span - x) / span**2))
    problem = RodProblem(
        Rod(1.0, Section((1e-5 * flexibility,) * 3)),
        RodLoad((0.0, 0.0, -weight)),
        *(Pinned(), Pinned((span, 0.0, 0.0))),
    )
    state = solve_rod(problem, start=parabola, elements=50)
    assert state.stable
    # Bending stiffness lifts the lowest point in proportion; 50 elements leave 1e-6.
    assert -state.positions[:, 2].min() == pytest.approx(sag, abs=2e-4 * flexibility + 2e-6)
    assert max(imbalance(problem, state)) < 1e-6 * weight
