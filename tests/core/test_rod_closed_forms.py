# SPDX-License-Identifier: Apache-2.0
"""Rods against closed forms: helices, elastica, beams, cables."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from core.contact_cases import down, line
from core.rod_cases import COUPLED, SIX
from numpy.linalg import norm
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


STRAINS = (-13.5, 4.0, 21.0), (1e-9, 0.0, 21.0), (1e-7, 0.0, 1e-8), (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("strain", "elements", "section"), [*product(STRAINS, (2, 3, 100), (PLAIN, COUPLED))]
)
def test_an_unloaded_rod_is_the_exact_helix(strain, elements, section):
    """The exponential of its twist."""
    length = min(0.36, 1.2 * elements / max(1.0, math.hypot(*strain)))
    rod = Rod(length, section, rest_strain=strain)
    state = solve_rod(rod, elements=elements, estimate_error=False)
    twist = np.zeros((4, 4))
    twist[:3, :3], twist[0, 3] = np.cross(np.eye(3), strain), 1.0
    frames = expm(state.arc_lengths[:, None, None] * twist)
    assert_allclose(state.positions, frames[:, :3, 3], rtol=0.0, atol=1e-9 * length)
    turned = Rotation.from_quat(state.orientations).as_matrix()
    # The tolerance on the moments, 1e-8 EI/L, lets an orientation be off by as much at worst.
    assert_allclose(turned, frames[:, :3, :3], rtol=0.0, atol=1e-8)
    assert_allclose(state.strains, np.tile(strain, (elements + 1, 1)), atol=1e-6)
    assert abs(state.energy) < 1e-12
    assert state.folds == 0


def elastica(load):
    """Return a cantilever of P L^2 / EI = load, across: Bisshopp and Drucker (1945).

    With m = k^2 = (1 + sin(tip slope)) / 2 and sin(theta) = 1 / (sqrt(2) k):
    K(k) - F(theta, k) = sqrt(load).
    """

    root = math.sqrt(load)

    def theta(m):
        return math.asin(1.0 / math.sqrt(2.0 * m))

    m = brentq(lambda m: ellipk(m) - ellipkinc(theta(m), m) - root, 0.5 + 1e-12, 1.0 - 1e-12)
    across = 1.0 - 2.0 / root * (ellipe(m) - ellipeinc(theta(m), m))
    force = (0.0, load * BENDING / LENGTH**2, 0.0)
    tip = LENGTH * np.array((math.sqrt(4.0 * m - 2.0) / root, across, 0.0))
    return RodProblem(Rod(LENGTH, PLAIN), RodLoad(tip_force=force)), tip


def column(load):
    """Return a straight column under so many times its load, whose tip lies on a circle.

    Euler's elastica: K(k) = sqrt(P / EI) L = pi / 2 sqrt(P / P_c).
    """
    root = 0.5 * math.pi * math.sqrt(load) / LENGTH
    m = brentq(lambda m: ellipk(m) - root * LENGTH, 1e-12, 0.999999)
    problem = RodProblem(Rod(LENGTH, PLAIN), RodLoad(tip_force=(-BENDING * root**2, 0.0, 0.0)))
    return problem, [2.0 * ellipe(m) / root - LENGTH, 2.0 * math.sqrt(m) / root]


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
            down(0.0, SMALL),
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
    # Near the critical load the error of the elements counts more.
    **{f"column {load}": (*column(load), (1e-6, 3e-5)) for load in (1.001, 1.1, 1.5)},
}


@pytest.mark.parametrize("element", [None, RodElement.MIXED])
@pytest.mark.parametrize("name", TIPS)
def test_a_tip_lies_where_closed_forms_have_it(name, element):
    problem, expected, off = TIPS[name]
    state = solve_rod(problem, elements=100, element=element)
    tip = state.tip_position - state.positions[0]
    if len(expected) == 2:
        tip = np.array((tip[0], norm(tip[1:])))
    assert (np.abs(tip - expected) < off).all()
    assert {*problem.rod.breaks} <= {*state.arc_lengths.round(15)}


def test_point_loads_and_couples_bend_a_held_beam():
    """Pinned and guided along itself, with a force and a couple anywhere: Bernoulli's beam."""
    force, couple, at, where = 2e-4, 3e-5, 0.17, 0.31
    problem = RodProblem(
        Rod(LENGTH, PLAIN),
        base=Pinned(),
        tip=Guided((LENGTH, 0.0, 0.0)),
        point_loads=(
            PointLoad(at, (0.0, 0.0, -force)),
            PointLoad(where, moment=(0.0, couple, 0.0)),
        ),
    )
    state = solve_rod(problem, elements=10)
    base = (force * (LENGTH - at) - couple) / LENGTH
    held = state.base_reaction[2], state.tip_reaction[2]
    assert held == pytest.approx((base, force - base), rel=1e-4)
    # Bending about y at the nodes: the moment of what lies before; it jumps by the couple.
    s = state.arc_lengths
    assert {at, where} <= {*s}
    bent = np.abs(base * s - force * np.maximum(s - at, 0.0) + couple * (s > where))
    off = np.abs(np.abs(state.moments[:, 1]) - bent)[s != where]
    assert off.max() < 1e-4 * force * LENGTH
    assert max(imbalance(problem, state)) < 1e-12


# Cowper (1966) for E = 2 (1 + 0.3) G, solid, of half the radius inside, and thin: of a millionth.
@pytest.mark.parametrize(
    ("bore", "coefficient"), [(0.0, 0.8863636), (1e-3, 0.6202290), (1.999998e-3, 0.5306122)]
)
def test_round_section_has_the_stiffness_of_its_shape(bore, coefficient):
    section = Section.round(2e-3, 1.3e6, 0.5e6, bore)
    area, inertia = (math.pi / n * (2e-3 ** (2 * n) - bore ** (2 * n)) for n in (1, 2))
    assert section.stiffness[:2] == pytest.approx((0.5e6 * inertia, 0.65e6 * inertia))
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
    assert Section(tuple(map(tuple, matrix))) == SIX
    scaled = Section.inextensible(24e-4, 20e-4, sideways=8e-4, coupling=16e-4)
    assert COUPLED.scaled(4.0) == scaled


@pytest.mark.parametrize("flexibility", [1.0, 1e-2])
def test_cable_hangs_as_a_catenary_however_flexible(flexibility):
    """Elements are up to 100 times as long as sqrt(EI / F)."""
    span, weight = 0.8, 3.0
    u = brentq(lambda u: math.sinh(u) / u - 1.0 / span, 1e-3, 5.0)
    sag = 0.5 * span / u * (math.cosh(u) - 1.0)
    parabola = line(span, 60)
    parabola[:, 2] = -4.0 * sag / span**2 * parabola[:, 0] * (span - parabola[:, 0])
    rod, far = Rod(1.0, Section((1e-5 * flexibility,) * 3)), Pinned((span, 0.0, 0.0))
    problem = RodProblem(rod, down(weight), Pinned(), far)
    state = solve_rod(problem, start=parabola, elements=50)
    # Bending stiffness lifts the lowest point in proportion; 50 elements leave 1e-6.
    assert -state.positions[:, 2].min() == pytest.approx(sag, abs=2e-4 * flexibility + 2e-6)
    assert max(imbalance(problem, state)) < 1e-6 * weight
