# SPDX-License-Identifier: Apache-2.0
"""Rods against closed forms: helices, elastica, beams, cables."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from core.contact_cases import down, line
from core.rod_cases import COUPLED
from numpy.linalg import norm
from numpy.testing import assert_allclose
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipeinc, ellipkinc

from spiral_core import (
    Clamped,
    Free,
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


@pytest.mark.parametrize(
    ("strain", "elements", "section"),
    [
        *product(
            ((-13.5, 4.0, 21.0), (1e-9, 0.0, 21.0), (1e-7, 0.0, 1e-8), (0.0, 0.0, 0.0)),
            (2, 3, 100),
            (PLAIN, COUPLED),
        )
    ],
)
def test_an_unloaded_rod_is_the_exact_helix(strain, elements, section):
    """The exponential of its twist."""
    length = min(0.36, 1.2 * elements / max(1.0, norm(strain)))
    state = solve_rod(Rod(length, section, rest_strain=strain), elements=elements)
    twist = np.zeros((4, 4))
    twist[:3, :3], twist[0, 3] = np.cross(np.eye(3), strain), 1.0
    frames = expm(state.arc_lengths[:, None, None] * twist)
    assert_allclose(state.positions, frames[:, :3, 3], rtol=0.0, atol=1e-9 * length)
    turned = Rotation.from_quat(state.orientations).as_matrix()
    # The tolerance on the moments, 1e-8 EI/L, lets an orientation be off by as much at worst.
    assert_allclose(turned, frames[:, :3, :3], rtol=0.0, atol=1e-8)
    assert abs(state.energy) < 1e-12


def elastica(load, lean):
    """Return a cantilever that a force of so many EI / L^2 presses, leaning, and where its tip is.

    Euler's column does not lean; Bisshopp and Drucker's (1945) cantilever does by a right angle.
    With m = k^2 = sin(tip slope to the force / 2)^2 and k sin(theta) = sin(lean / 2):
    K(k) - F(theta, k) = sqrt(load).
    """
    root, half = math.sqrt(load), math.sin(0.5 * lean)

    def rest(integral, m):
        return integral(0.5 * math.pi, m) - integral(math.asin(half / math.sqrt(m)), m)

    m = brentq(lambda m: rest(ellipkinc, m) - root, half**2 + 1e-12, 1.0 - 1e-12)
    tip = 2.0 / root * np.array((rest(ellipeinc, m), math.sqrt(m - half**2))) - (1.0, 0.0)
    sin, cos = math.sin(lean), math.cos(lean)
    turn = np.array(((cos, sin), (-sin, cos)))
    force = -load * BENDING / LENGTH**2 * turn[:, 0]
    return RodProblem(Rod(LENGTH, PLAIN), RodLoad(tip_force=(*force, 0.0))), LENGTH * turn @ tip


SMALL, CRITICAL = 2e-6, 0.25 * math.pi**2
# Where the tip comes to lie, along x and across it, and how nearly.
TIPS = [
    # What is left out is of second order in the deflection.
    (
        RodProblem(Rod(LENGTH, Section(PLAIN.stiffness, shear=0.01)), down(0.0, SMALL)),
        (LENGTH, SMALL * (LENGTH**3 / 3.0 / BENDING + LENGTH / 0.01)),
        (2e-7, 1e-9),
    ),
    # Hanging from its tip: by w L^2 / 2 EA and F L / EA.
    (
        RodProblem(
            *(Rod(LENGTH, Section(PLAIN.stiffness, extension=40.0)), RodLoad((-3.0, 0.0, 0.0))),
            *(Free(), Clamped()),
            point_loads=(PointLoad(0.0, (-2.0, 0.0, 0.0)),),
        ),
        (LENGTH * (1.0 + (0.5 * 3.0 * LENGTH + 2.0) / 40.0), 0.0),
        1e-10,
    ),
    # A quarter circle, then straight.
    (
        RodProblem(
            Rod(
                *(LENGTH, PLAIN, 1e-6),
                lambda s: np.where(s[:, None] < 0.2, (0.0, 0.0, 2.5 * math.pi), 0.0),
                breaks=(0.2,),
            )
        ),
        (0.4 / math.pi, 0.4 / math.pi + 0.3),
        1e-9,
    ),
    *((*elastica(load, 0.5 * math.pi), off) for load, off in ((0.5, 1e-6), (10.0, 2e-6))),
    # Near the critical load the error of the elements counts more.
    *((*elastica(load * CRITICAL, 0.0), (1e-6, 3e-5)) for load in (1.001, 1.1, 1.5)),
]


@pytest.mark.parametrize("element", [None, RodElement.MIXED])
@pytest.mark.parametrize(("problem", "expected", "off"), TIPS)
def test_a_tip_lies_where_closed_forms_have_it(problem, expected, off, element):
    state = solve_rod(problem, elements=100, element=element)
    along, *across = state.tip_position - state.positions[0]
    assert (np.abs(np.subtract((along, norm(across)), expected)) < off).all()


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
    assert section.scaled(2.0) == Section.round(2e-3, 2.6e6, 1e6, bore)


def test_flexible_cable_hangs_as_a_catenary():
    """Elements are up to 100 times as long as sqrt(EI / F)."""
    span, weight = 0.8, 3.0
    u = brentq(lambda u: math.sinh(u) / u - 1.0 / span, 1e-3, 5.0)
    sag = 0.5 * span / u * (math.cosh(u) - 1.0)
    parabola = line(span, 60)
    parabola[:, 2] = -4.0 * sag / span**2 * parabola[:, 0] * (span - parabola[:, 0])
    rod, far = Rod(1.0, Section((1e-7,) * 3)), Pinned((span, 0.0, 0.0))
    state = solve_rod(RodProblem(rod, down(weight), Pinned(), far), start=parabola, elements=50)
    # Bending stiffness lifts the lowest point by half of it; 50 elements leave 1e-6.
    assert -state.positions[:, 2].min() == pytest.approx(sag, abs=4e-6)
