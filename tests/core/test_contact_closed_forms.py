# SPDX-License-Identifier: Apache-2.0
"""Rods in contact against closed forms, at an order, and against an independent minimization."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.contact_cases import bar, down
from core.contact_paths import SPAN
from core.reference_minimum import least_energy
from numpy.linalg import norm
from numpy.polynomial.legendre import leggauss
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipe, ellipk

from spiral_core import (
    Clamped,
    Cylinder,
    InvalidInputError,
    Obstacle,
    Pinned,
    Rod,
    RodLoad,
    RodProblem,
    Section,
    Sphere,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

# Of the rods here, unless said otherwise.
BENDING, TORSIONAL = 1.0, 0.7
ROUND = Section((TORSIONAL, BENDING, BENDING))


def order(errors):
    """Return the order between the first and the last of errors on 1, 2, 4, ... times elements."""
    return math.log2(errors[0] / errors[-1]) / (len(errors) - 1)


def test_cantilever_over_a_cylinder():
    """Clamped level on top of it and pressed down by a dead force P at its tip.

    It lies on the cylinder to a slope a, and with u = EI / P its free part of curvature k has
    sin(slope) = sin a + u (1 / rho^2 - k^2) / 2 and ds = -u dk / cos(slope).
    """
    rho, u = 0.5, 0.25
    nodes, weights = leggauss(30)

    def free(turn):
        """Return the free part's length and height, whose curvature falls from 2 to 0."""
        sine = math.sin(turn) + 0.5 * u * (4.0 - (1.0 + nodes) ** 2)
        pieces = u * weights / np.sqrt(1.0 - sine**2)
        return pieces.sum(), pieces @ sine

    turn = brentq(lambda a: rho * a + free(a)[0] - 1.0, 0.0, 0.52)
    tip = rho * math.sin(turn) + u / rho, rho * math.cos(turn) - rho - free(turn)[1]
    # The tip's force presses where the rod lifts off, and its tension on the arc before that;
    # what the clamped node would bear is in its reaction.
    pressed = 4.0 * (math.cos(turn) + math.sin(turn) * turn)
    # Beyond lift-off the shear bends it away with the cube of the distance.
    near = rho * turn + (6.0 * 1e-4 / (4.0 * math.cos(turn))) ** (1.0 / 3.0)
    problem = RodProblem(
        Rod(1.0, ROUND, radius=0.02), down(0.0, 4.0), obstacles=(bar(rho - 0.02, 0.0, -rho),)
    )
    errors = []
    for elements in (20, 40, 80):
        state = solve_contact(problem, elements=elements)
        errors.append(np.abs(state.positions[-1, [0, 2]] - tip).max())
        assert state.contact_lengths[0] == pytest.approx(rho * turn, abs=1.0 / elements)
        assert state.lengths_within(1e-4).sum() == pytest.approx(near, abs=0.1 / elements)
        assert state.normal_forces.sum() == pytest.approx(pressed, rel=0.5 / elements)
    assert max(errors) == errors[0] < 1e-5
    assert order(errors) > 1.25  # measured: 1.7, then 1.3


def even():
    """Return an even helix on a cylinder without force along the axis, as with free ends.

    Kirchhoff's equations; its tip's load keeps it even. Problem, radius, angle to the axis, force
    per length, its least order, and how far off the solve may be.
    """
    rho, angle = 0.12, -1.25
    sin, cos = math.sin(angle), math.cos(angle)
    curvature, torsion = sin * sin / rho, sin * cos / rho
    along, across = TORSIONAL * (torsion + 4.0), BENDING * (curvature - 9.0)
    shear = along * curvature - across * torsion
    tension = -shear * math.tan(angle)
    # After whole turns both ends are in one frame: tangent, normal, binormal.
    frame = np.array(((0.0, sin, cos), (-1.0, 0.0, 0.0), (0.0, -cos, sin)))
    force, moment = np.array(((tension, 0.0, shear), (along, 0.0, across))) @ frame
    problem = RodProblem(
        Rod(4.0 * math.pi * rho / abs(sin), ROUND, 0.02, rest_strain=(-4.0, 0.0, 9.0)),
        RodLoad(tip_force=force, tip_moment=moment),
        base=Clamped((rho, 0.0, 0.0), Rotation.from_matrix(frame.T).as_quat()),
        obstacles=(Obstacle(Cylinder(rho - 0.02)),),
    )
    return problem, rho, angle, tension * curvature - torsion * shear, 2.5, 2e-6


def buckled():
    """Return a rod buckled in a tube, without moment about the axis and torque at its ends.

    For any angle; at small ones theta^2 = F rho^2 / (2 EI) and q = rho F^2 / (4 EI).
    """
    rho, angle = 0.01, 0.35
    sin = math.sin(angle)
    problem = RodProblem(
        Rod(10.0 * math.pi * rho / sin, ROUND, 0.004),
        down(0.0, 2.0 * BENDING * sin**2 * math.cos(angle) / rho**2),
        base=Pinned((0.98 * rho, 0.0, 0.0)),
        obstacles=(Obstacle(Cylinder(rho + 0.004, inside=True)),),
    )
    return problem, rho, angle, BENDING * sin**4 / rho**3, 3.7, 2e-5


@pytest.mark.parametrize(("problem", "rho", "angle", "line", "least", "off"), [even(), buckled()])
def test_helix_in_contact_is_of_second_order_and_more(problem, rho, angle, line, least, off):
    """Away from its ends, whose sections nodes give a moment off by q h^2 / 12."""
    errors = []
    for elements in (100, 200):
        s = np.linspace(0.0, problem.rod.length, elements + 1)
        turned = s * math.sin(angle) / rho
        x, y = problem.base.position[0] * np.array((np.cos(turned), np.sin(turned)))
        start = np.column_stack((x, y, s * math.cos(angle)))
        state = solve_contact(problem, start=start, elements=elements)
        middle = slice(2 * elements // 5, 3 * elements // 5)
        angles = np.arccos(state.tangents[middle, 2]) - abs(angle)
        forces = state.normal_forces[0, middle] / state.node_lengths[middle]
        errors.append((np.abs(angles).max(), np.abs(forces / line - 1.0).max()))
    for one in zip(*errors, strict=True):
        assert order(one) > least  # measured: 2.66 and 4.0
        assert one[-1] < off


def rope(length, around, hanging, elements):
    """Return places (n, 3) of a rope laid over a bar across the y axis."""
    s = np.linspace(-hanging, length - hanging, elements + 1)
    angle = np.clip(s / around, 0.0, math.pi)
    up = around * np.sin(angle) - np.abs(s - around * angle)
    return np.column_stack((-around * np.cos(angle), 0.0 * s, up))


AROUND, FRICTION = 0.07, 0.3
THICK = 0.02 / AROUND
# Friction at the surface turns the section: a mu lambda^2 + lambda - mu (1 - a) = 0, a = r / rho.
ROLLED = math.sqrt(1.0 + 4.0 * FRICTION**2 * THICK * (1.0 - THICK)) - 1.0


@pytest.mark.parametrize(
    ("lever", "k", "weight", "observed", "off"),
    [
        (0.0, FRICTION, 0.0, 4.0, 1e-6),
        (0.0, FRICTION, 3.5, 2.0, 2e-4),
        # Between layers where it lifts off.
        (None, ROLLED / (2.0 * FRICTION * THICK), 0.0, 2.0, 2e-4),
    ],
)
def test_tension_of_a_sliding_rope_grows_by_friction_and_weight(lever, k, weight, observed, off):
    """A rope hangs over a bar that turns under it: all of it slides, and it bends easily.

    dT/dphi = r w cos phi + k (T + r w sin phi), k = mu: T = A e^(k phi) + r w (a sin + b cos).
    Its ends hang: with T = w h there, h_2 = h_1 e^(mu pi) + r 2 mu / (1 + mu^2) (e^(mu pi) + 1).
    Without weight it is the capstan equation. The bar's torque is mu N times where friction acts.
    """
    errors, hanging = [], 4.0 * AROUND
    length, arm = 2.0 * hanging + math.pi * AROUND, AROUND - (0.02 if lever is None else 0.0)
    a, b = (1.0 - k**2) / (1.0 + k**2), -2.0 * k / (1.0 + k**2)
    for elements in (100, 200, 400):
        start = rope(length, AROUND, hanging, elements)
        smooth, *turns = (
            RodProblem(
                Rod(length, Section((1e-4,) * 3), 0.02, friction_radius=lever),
                down(weight, 3.0 if weight else 1.0),
                Pinned((*start[0],)),
                obstacles=(
                    bar(AROUND - 0.02, 0.0, 0.0, FRICTION * (turn > 0.0)).moved(
                        rotation=(0.0, turn, 0.0)
                    ),
                ),
            )
            for turn in np.linspace(0.0, 0.05, 6)
        )
        start = solve_contact(smooth, start=start, elements=elements)
        state = follow_contact(turns, start=start).states[-1]
        assert not state.sticking[state.touching].any()
        torque = FRICTION * state.normal_forces.sum() * arm
        assert state.on_obstacle().torque == pytest.approx((0.0, -torque, 0.0), rel=1e-6)
        angles = np.arctan2(state.positions[:, 2], state.positions[:, 0])
        inner = state.touching[0] & (angles > 1.1) & (angles < 2.0)
        angles, tension = angles[inner], np.sum(state.forces * state.tangents, axis=1)[inner]
        own = tension - AROUND * weight * (a * np.sin(angles) + b * np.cos(angles))
        own *= np.exp(-k * angles)
        errors.append(float(np.ptp(own) / own.mean()))
    assert order(errors) == pytest.approx(observed, abs=0.3)
    assert errors[0] < off


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_estimated_error_bounds_the_true_one(friction):
    """Against eight times as many elements; a cantilever pressed over a cylinder, out of its plane.

    The slips up to a state are not known on other elements.
    """
    problem = RodProblem(
        Rod(1.0, ROUND, radius=0.02, rest_strain=(0.4, 0.0, 0.3)),
        RodLoad(tip_force=(0.0, 0.5, -4.0)),
        obstacles=(Obstacle.along(Cylinder(0.48), (0.25, 0.0, -0.55), (0.2, 1.0, 0.0), friction),),
    )
    state = solve_contact(problem, elements=20, estimate_error=True)
    fine, found = solve_contact(problem, elements=160), state.discretization_error
    off = norm(fine.positions[::8] - state.positions, axis=1).max()
    assert off < found < 20.0 * off
    if friction:
        with pytest.raises(InvalidInputError, match="estimate_error"):
            solve_contact(problem, start=state, estimate_error=True)
    else:
        again = solve_contact(problem, start=state, estimate_error=True)
        assert again.discretization_error == pytest.approx(found, rel=1e-3)


@pytest.mark.parametrize("ends", [Pinned, Clamped])
@pytest.mark.parametrize("span", [0.999, 0.9, 0.6])
def test_a_rod_between_ends_nearer_than_its_length_is_the_elastica(ends, span):
    """Euler's column past its load: 2 E(k) / K(k) - 1 is the span, the force 4 K(k)^2 EI.

    Clamped, its points of inflection are a quarter of the length from the ends.
    """
    k2 = brentq(lambda k2: 2.0 * ellipe(k2) / ellipk(k2) - 1.0 - span, 1e-9, 0.9)
    force = (2.0 if ends is Pinned else 4.0) ** 2 * ellipk(k2) ** 2 * BENDING
    beside = (Obstacle(Sphere(0.1), (0.5, -0.4, -0.5)),)  # not touched
    held = {"base": ends(), "tip": ends((span, 0.0, 0.0)), "obstacles": beside}
    problem = RodProblem(Rod(1.0, ROUND), **held)
    state = solve_contact(problem, elements=60)
    assert state.stable
    assert state.base_reaction[0] == pytest.approx(force, rel=3e-3)
    assert norm(state.base_reaction[1:3]) < 1e-6 * force


def test_beam_on_three_supports_has_the_reactions_of_the_three_moment_equation():
    """Clamped level, and propped by a cylinder at its middle and a sphere at its end."""
    span, under = 0.2, -0.02 - SPAN.radius
    end = Obstacle(Sphere(0.02), (2.0 * span - 1e-6, 0.0, under))
    problem = RodProblem(SPAN, down(1e-3), obstacles=(bar(0.02, span, under), end))
    state = solve_contact(problem, elements=80)
    parts = (state.base_reaction[2], *state.contact_forces.sum(axis=1)[:, 2])
    # Clapeyron: 13, 32 and 11 of 28 w l; the rod sags by 1e-5 of its length.
    assert np.divide(parts, 1e-3 * span / 28.0) == pytest.approx((13.0, 32.0, 11.0), rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("index", range(20))
def test_rod_on_a_cylinder_is_where_an_independent_minimization_finds_it(index):
    """A cantilever that its weight and tip force press onto a cylinder below it."""
    rng = np.random.default_rng([13, index])
    reach, along, azimuth, lean = rng.uniform((0.1, 0.3, -0.6, -0.4), (0.5, 0.8, 0.6, 0.4))
    # So far below that the straight rod is clear of it.
    depth = (1.05 * reach + 0.02) * math.hypot(1.0, lean / math.cos(azimuth))
    axis = (math.sin(azimuth), math.cos(azimuth), lean)
    strain, aside, pull = rng.uniform(-1.0, 1.0, (3, 3))
    problem = RodProblem(
        Rod(1.0, ROUND, 0.01, rest_strain=strain),
        RodLoad(rng.uniform(4.0, 12.0) * (0.3 * aside - (0.0, 0.0, 1.0)), tip_force=2.0 * pull),
        obstacles=(Obstacle.along(Cylinder(reach - 0.01), (along, 0.0, -depth), axis),),
    )
    state = solve_contact(problem, elements=80)
    (finest, forces), (coarse, _) = (least_energy(problem, count) for count in (80, 40))
    # The reference's own error, of second order, is a third of what halving its elements changes.
    off, own = np.abs(state.positions - finest).max(), np.abs(coarse - finest[::2]).max()
    assert off < 1.5 * own + 2e-5
    assert state.normal_forces.sum() == pytest.approx(forces.sum(), rel=0.02, abs=1e-6)
