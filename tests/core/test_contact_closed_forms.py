# SPDX-License-Identifier: Apache-2.0
"""Rods in contact against closed forms, at an order, and against an independent minimization."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from core.contact_cases import bar, down
from core.contact_paths import SPAN
from core.reference_minimum import least_energy
from numpy.linalg import norm
from numpy.polynomial.legendre import leggauss
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

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
    length, height = free(turn)
    tip = rho * math.sin(turn) + u / rho, rho * math.cos(turn) - rho - height
    # The tip's force presses where the rod lifts off, and its tension on the arc before that;
    # what the clamped node would bear is in its reaction.
    pressed = 4.0 * (math.cos(turn) + math.sin(turn) * turn)
    problem = RodProblem(
        Rod(1.0, ROUND, radius=0.02), down(0.0, 4.0), obstacles=(bar(rho - 0.02, 0.0, -rho),)
    )
    errors = []
    for elements in (20, 40, 80):
        state = solve_contact(problem, elements=elements)
        errors.append(np.abs(state.positions[-1, [0, 2]] - tip).max())
        assert state.contact_lengths[0] == pytest.approx(1.0 - length, abs=1.0 / elements)
        assert state.normal_forces.sum() == pytest.approx(pressed, rel=0.5 / elements)
    assert max(errors) == errors[0] < 1e-5
    assert order(errors) > 1.25  # measured: 1.7, then 1.3


def helices(problem, rho, angle, counts):
    """Return the states of a rod that is laid as a helix about z, at ``angle`` to it."""
    for elements in counts:
        s = np.linspace(0.0, problem.rod.length, elements + 1)
        turned = s * math.sin(angle) / rho
        x, y = problem.base.position[0] * np.array((np.cos(turned), np.sin(turned)))
        start = np.column_stack((x, y, s * math.cos(angle)))
        yield solve_contact(problem, start=start, elements=elements)


def test_helix_on_a_cylinder_is_of_second_order_and_more():
    """Kirchhoff's equations of an even one, without force along the axis as with free ends.

    Its tip's load keeps it even; nodes give the ends' sections a moment off by q h^2 / 12.
    """
    rho, angle = 0.12, -1.25
    sin, cos = math.sin(angle), math.cos(angle)
    curvature, torsion = sin * sin / rho, sin * cos / rho
    along, across = TORSIONAL * (torsion + 4.0), BENDING * (curvature - 9.0)
    shear = along * curvature - across * torsion
    tension = -shear * math.tan(angle)
    line = tension * curvature - torsion * shear
    length = 4.0 * math.pi * rho / abs(sin)
    # After whole turns both ends are in one frame: tangent, normal, binormal.
    frame = np.array(((0.0, sin, cos), (-1.0, 0.0, 0.0), (0.0, -cos, sin)))
    force, moment = np.array(((tension, 0.0, shear), (along, 0.0, across))) @ frame
    problem = RodProblem(
        Rod(length, ROUND, 0.02, rest_strain=(-4.0, 0.0, 9.0)),
        RodLoad(tip_force=force, tip_moment=moment),
        base=Clamped((rho, 0.0, 0.0), (*Rotation.from_matrix(frame.T).as_quat(),)),
        obstacles=(Obstacle(Cylinder(rho - 0.02)),),
    )
    errors = []
    for state in helices(problem, rho, angle, (40, 80, 160)):
        elements = len(state.positions) - 1
        middle = slice(elements // 4, 3 * elements // 4)
        angles = np.arccos(state.tangents[middle, 2])
        forces = state.normal_forces[0, middle] / state.node_lengths[middle]
        errors.append((np.abs(angles + angle).max(), np.abs(forces / line - 1.0).max()))
    for one in zip(*errors, strict=True):
        assert order(one) > 2.3  # measured: 2.5 and 2.9
        assert one[-1] < 2e-6


def test_rod_buckled_in_a_tube_presses_outward():
    """Free of moment about the axis and of torque at its ends, for any angle.

    At small ones theta^2 = F rho^2 / (2 EI) and q = rho F^2 / (4 EI).
    """
    bending, rho, angle = 0.3, 0.01, 0.35
    push = 2.0 * bending * math.sin(angle) ** 2 * math.cos(angle) / rho**2
    line = bending * math.sin(angle) ** 4 / rho**3
    problem = RodProblem(
        Rod(10.0 * math.pi * rho / math.sin(angle), Section((0.2, bending, bending)), 0.004),
        down(0.0, push),
        base=Pinned((0.98 * rho, 0.0, 0.0)),
        obstacles=(Obstacle(Cylinder(rho + 0.004, inside=True)),),
    )
    misses = []
    for state in helices(problem, rho, angle, (100, 200)):
        middle = len(state.positions) // 2
        assert state.contact_forces[0, middle, :2] @ state.positions[middle, :2] < 0.0
        force = state.normal_forces[0, middle] / state.node_lengths[middle]
        assert force == pytest.approx(line, rel=4e-4 * (50.0 / middle) ** 2)
        misses.append(abs(math.acos(state.tangents[middle, 2]) - angle))
    assert order(misses) == pytest.approx(4.0, abs=0.3)


@pytest.mark.slow
def test_rod_pulled_over_a_cylinder_lifts_off():
    """Pinned far away, so that the reaction's line is the asymptote that the closed form has.

    A long straight rod still turns by psi after it lifts off, by the point force F sin(psi):
    sin(psi / 2) = sqrt(EI / F) / (2 rho).
    """
    rho, radius, force = 0.3, 0.02, 40.0
    length = 14.0 * math.sqrt(BENDING / force) + 1.2 * rho
    cylinder = bar(rho - radius, 0.5 * length, -rho)
    pulls = [(force * math.cos(a), 0.0, -force * math.sin(a)) for a in (0.0, 0.75, 1.5)]
    rod = Rod(length, ROUND, radius)
    ways = [RodProblem(rod, RodLoad(tip_force=f), Pinned(), obstacles=(cylinder,)) for f in pulls]
    state = follow_contact(ways, elements=320).states[-1]
    psi, step = 2.0 * math.asin(math.sqrt(BENDING / force) / (2.0 * rho)), length / 320
    reaction = -state.base_reaction[:3]
    assert norm(reaction) == pytest.approx(force, rel=2e-5)
    arc = 1.5 + math.atan2(reaction[2], reaction[0]) - 2.0 * psi
    total = force * (2.0 * math.sin(psi) + math.cos(psi) * arc)
    assert state.normal_forces.sum() == pytest.approx(total, rel=2e-5)
    assert state.contact_lengths[0] == pytest.approx(rho * arc, abs=2.0 * step)
    # Beyond lift-off the shear bends the rod away with the cube of the distance.
    beyond = (6.0 * BENDING * 2e-4 / (force * math.sin(psi))) ** (1.0 / 3.0)
    assert state.lengths_within(2e-4).sum() == pytest.approx(
        rho * arc + 2.0 * beyond, abs=0.2 * step
    )


def rope(length, around, hanging, elements):
    """Return places (n, 3) of a rope laid over a bar across the y axis."""
    s = np.linspace(0.0, length, elements + 1)
    angle = np.clip((s - hanging) / around, 0.0, math.pi)
    below = np.minimum(s - hanging, 0.0) - np.maximum(s - hanging - math.pi * around, 0.0)
    return np.column_stack((-around * np.cos(angle), 0.0 * s, around * np.sin(angle) + below))


AROUND, FRICTION = 0.07, 0.3


THICK = 0.02 / AROUND
# Friction at the surface turns the section: a mu lambda^2 + lambda - mu (1 - a) = 0, a = r / rho.
ROLLED = math.sqrt(1.0 + 4.0 * FRICTION**2 * THICK * (1.0 - THICK)) - 1.0


@pytest.mark.parametrize(
    ("lever", "exponent", "weight", "sign", "observed"),
    [
        (0.0, FRICTION, 0.0, 1.0, 4.0),
        (0.0, FRICTION, 3.5, 1.0, 2.0),
        (0.0, FRICTION, 3.5, -1.0, 2.0),
        # Between layers where it lifts off.
        (None, ROLLED / (2.0 * FRICTION * THICK), 0.0, 1.0, 2.0),
    ],
)
def test_tension_of_a_sliding_rope_grows_by_friction_and_weight(
    lever, exponent, weight, sign, observed
):
    """A rope hangs over a bar that turns under it: all of it slides, and it bends easily.

    dT/dphi = r w cos phi + k (T + r w sin phi), k = +-mu: T = A e^(k phi) + r w (a sin + b cos).
    Its ends hang: with T = w h there, h_2 = h_1 e^(mu pi) + r 2 mu / (1 + mu^2) (e^(mu pi) + 1).
    Without weight it is the capstan equation.
    """
    errors, hanging = [], 4.0 * AROUND
    length, smooth = 2.0 * hanging + math.pi * AROUND, bar(AROUND - 0.02, 0.0, 0.0)
    rough = replace(smooth, friction=FRICTION)
    for elements in (100, 200, 400):
        start = rope(length, AROUND, hanging, elements)
        problem = RodProblem(
            Rod(length, Section((1e-4,) * 3), 0.02, friction_radius=lever),
            down(weight, 3.0 if weight else 1.0),
            Pinned((*start[0],)),
            obstacles=(smooth,),
        )
        turns = [rough.moved(rotation=(0.0, 0.01 * sign * step, 0.0)) for step in range(1, 6)]
        state = follow_contact(
            [replace(problem, obstacles=(one,)) for one in turns],
            start=solve_contact(problem, start=start, elements=elements),
        ).states[-1]
        angles = np.arctan2(state.positions[:, 2], state.positions[:, 0])
        inner = np.flatnonzero(state.touching[0] & (angles > 1.1) & (angles < 2.0))
        assert not state.sticking[0, inner].any()
        angles, tension = angles[inner], np.sum(state.forces * state.tangents, axis=1)[inner]
        k = math.copysign(exponent, tension[0] - tension[-1])
        a, b = (1.0 - k**2) / (1.0 + k**2), -2.0 * k / (1.0 + k**2)
        own = tension - AROUND * weight * (a * np.sin(angles) + b * np.cos(angles))
        own *= np.exp(-k * angles)
        errors.append(float(np.ptp(own) / own.mean()))
    assert order(errors) == pytest.approx(observed, abs=0.3)
    assert errors[0] < (1e-6 if observed == 4.0 else 2e-4)


@pytest.mark.parametrize("elements", [20, 40])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_estimated_error_bounds_the_true_one(elements, friction):
    """Against eight times as many elements; a cantilever pressed over a cylinder, out of its plane.

    The slips up to a state are not known on other elements.
    """
    cylinder = Obstacle.along(Cylinder(0.48), (0.25, 0.0, -0.55), (0.2, 1.0, 0.0), friction)
    rod = Rod(1.0, ROUND, radius=0.02, rest_strain=(0.4, 0.0, 0.3))
    problem = RodProblem(rod, RodLoad(tip_force=(0.0, 0.5, -4.0)), obstacles=(cylinder,))
    state = solve_contact(problem, elements=elements, estimate_error=True)
    fine = solve_contact(problem, elements=8 * elements)
    off = norm(fine.positions[::8] - state.positions, axis=1).max()
    assert off < state.discretization_error < 20.0 * off
    if friction:
        with pytest.raises(InvalidInputError, match="estimate_error"):
            solve_contact(problem, start=state, estimate_error=True)
    else:
        again = solve_contact(problem, start=state, estimate_error=True)
        assert again.discretization_error == pytest.approx(state.discretization_error, rel=1e-3)


def test_beam_on_three_supports_has_the_reactions_of_the_three_moment_equation():
    """Clamped level, and propped by a cylinder at its middle and a sphere at its end."""
    span, under = 0.2, -0.02 - SPAN.radius
    end = Obstacle(Sphere(0.02), (2.0 * span - 1e-6, 0.0, under))
    problem = RodProblem(SPAN, down(1e-3), obstacles=(bar(0.02, span, under), end))
    state = solve_contact(problem, elements=80)
    parts = (state.base_reaction[2], *state.contact_forces.sum(axis=1)[:, 2])
    # Clapeyron: 13, 32 and 11 of 28 w l; the rod sags by 1e-5 of its length.
    assert np.divide(parts, 1e-3 * span / 28.0) == pytest.approx((13.0, 32.0, 11.0), rel=2e-3)


def test_spun_cylinder_bears_the_torque_of_sliding_friction():
    """The torque is mu N R, of the radius of the cylinder, at whose surface friction acts."""
    cylinder = bar(0.03, 0.2, -0.07, 0.2)
    here = RodProblem(SPAN, down(0.5), Pinned(), Pinned((0.385, 0.0, -0.02)), (cylinder,))
    spun = replace(here, obstacles=(cylinder.moved(rotation=(0.0, -1.0, 0.0)),))
    state = follow_contact([here, spun], elements=60).states[-1]
    expected = 0.2 * state.normal_forces.sum() * 0.03
    assert state.on_obstacle().torque[1] == pytest.approx(expected, rel=1e-6)
    assert not state.sticking[state.touching].any()


@pytest.mark.slow
@pytest.mark.parametrize("index", range(20))
def test_rod_on_a_cylinder_is_where_an_independent_minimization_finds_it(index):
    """A cantilever that its weight and tip force press onto a cylinder below it."""
    rng = np.random.default_rng([13, index])
    reach, along, azimuth, lean = rng.uniform((0.1, 0.3, -0.6, -0.4), (0.5, 0.8, 0.6, 0.4))
    axis = np.array((math.sin(azimuth), math.cos(azimuth), lean))
    # So far below that the straight rod is clear of it, wherever its axis passes.
    down = np.array((0.0, 0.0, -1.0))
    across = np.cross(axis, np.cross(down, axis))
    point = (along, 0.0, 0.0) + (1.05 * reach + 0.02) * across / norm(across)
    strain, aside, pull = rng.uniform(-1.0, 1.0, (3, 3))
    problem = RodProblem(
        Rod(1.0, ROUND, 0.01, rest_strain=strain),
        RodLoad(rng.uniform(4.0, 12.0) * (down + 0.3 * aside), tip_force=2.0 * pull),
        obstacles=(Obstacle.along(Cylinder(reach - 0.01), (*point,), axis),),
    )
    state = solve_contact(problem, elements=80)
    (finest, forces), (coarse, _) = (least_energy(problem, count) for count in (80, 40))
    assert state.touching.any() == forces.any()  # one of them misses the cylinder
    # The reference's own error, of second order, is a third of what halving its elements changes.
    off, own = np.abs(state.positions - finest).max(), np.abs(coarse - finest[::2]).max()
    assert off < 1.5 * own + 2e-5
    assert state.normal_forces.sum() == pytest.approx(forces.sum(), rel=0.02, abs=1e-6)
