# SPDX-License-Identifier: Apache-2.0
"""Rods in contact against closed forms, at an order, and against an independent minimization."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from core import reference_contact as exact
from core.contact_paths import SPAN
from core.reference_minimum import least_energy
from numpy.linalg import norm
from numpy.typing import NDArray
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

Array = NDArray[np.float64]
# Of the rods here, unless said otherwise.
BENDING, TORSIONAL = 1.0, 0.7
ROUND = Section((TORSIONAL, BENDING, BENDING))
ACROSS = (0.0, 1.0, 0.0)


def order(errors):
    """Return the order between the first and the last of errors on 1, 2, 4, ... times elements."""
    return math.log2(errors[0] / errors[-1]) / (len(errors) - 1)


def test_cantilever_over_a_cylinder():
    """Pressed down by its tip force."""
    cylinder = Obstacle.along(Cylinder(0.48), (0.0, 0.0, -0.5), ACROSS)
    load = RodLoad(tip_force=(0.0, 0.0, -4.0))
    free, tip = exact.cantilever_over_cylinder(BENDING, 1.0, 0.5, 4.0)
    # The tip's force presses where the rod lifts off, and its tension on the arc before that;
    # what the clamped node would bear is in its reaction.
    turn = (1.0 - free) / 0.5
    pressed = 4.0 * (math.cos(turn) + math.sin(turn) * turn)
    errors = []
    for elements in (20, 40, 80):
        problem = RodProblem(Rod(1.0, ROUND, radius=0.02), load, obstacles=(cylinder,))
        state = solve_contact(problem, elements=elements)
        errors.append(np.abs(state.positions[-1, [0, 2]] - tip).max())
        assert state.contact_lengths[0] == pytest.approx(1.0 - free, abs=1.0 / elements)
        assert state.normal_forces.sum() == pytest.approx(pressed, rel=0.5 / elements)
    assert max(errors) == errors[0] < 1e-5
    assert order(errors) > 1.25  # measured: 1.7, then 1.3


def wound(s, rho, angle):
    """Return places (n, 3) of a helix about z, at ``angle`` to it."""
    turned = s * math.sin(angle) / rho
    return np.column_stack((rho * np.cos(turned), rho * np.sin(turned), s * math.cos(angle)))


def test_helix_on_a_cylinder_is_of_second_order_and_more():
    """Its tip's load keeps it even; nodes give the ends' sections a moment off by q h^2 / 12."""
    strain, rho, angle = (-4.0, 0.0, 9.0), 0.12, -1.25
    force, moment, line = exact.helix_on_cylinder((TORSIONAL, BENDING), strain[::2], rho, angle)
    length = 4.0 * math.pi * rho / abs(math.sin(angle))
    # After whole turns both ends are in one frame: tangent, normal, binormal.
    tangent, inward = (0.0, math.sin(angle), math.cos(angle)), (-1.0, 0.0, 0.0)
    frame = np.array((tangent, inward, np.cross(tangent, inward)))
    problem = RodProblem(
        Rod(length, ROUND, 0.02, rest_strain=strain),
        RodLoad(tip_force=(*(force @ frame),), tip_moment=(*(moment @ frame),)),
        base=Clamped((rho, 0.0, 0.0), (*Rotation.from_matrix(frame.T).as_quat(),)),
        obstacles=(Obstacle(Cylinder(rho - 0.02)),),
    )
    errors = []
    for elements in (40, 80, 160):
        start = wound(np.linspace(0.0, length, elements + 1), rho, angle)
        state = solve_contact(problem, start=start, elements=elements)
        middle = slice(elements // 4, 3 * elements // 4)
        angles = np.arccos(state.tangents[middle, 2])
        forces = state.normal_forces[0, middle] / state.node_lengths[middle]
        errors.append((np.abs(angles + angle).max(), np.abs(forces / line - 1.0).max()))
    for one in zip(*errors, strict=True):
        assert order(one) > 2.3  # measured: 2.5 and 2.9
        assert one[-1] < 2e-6


def test_rod_buckled_in_a_tube_presses_outward():
    bending, rho, angle = 0.3, 0.01, 0.35
    push, line_force = exact.helix_in_tube(bending, rho, angle)
    length = 10.0 * math.pi * rho / math.sin(angle)
    problem = RodProblem(
        Rod(length, Section((0.2, bending, bending)), 0.004),
        RodLoad(tip_force=(0.0, 0.0, -push)),
        base=Pinned((0.98 * rho, 0.0, 0.0)),
        obstacles=(Obstacle(Cylinder(rho + 0.004, inside=True)),),
    )
    misses = []
    for elements in (100, 200):
        start = wound(np.linspace(0.0, length, elements + 1), rho, angle) * (0.98, 0.98, 1.0)
        state = solve_contact(problem, start=start, elements=elements)
        middle = elements // 2
        assert state.contact_forces[0, middle, :2] @ state.positions[middle, :2] < 0.0
        force = state.normal_forces[0, middle] / state.node_lengths[middle]
        assert force == pytest.approx(line_force, rel=4e-4 * (100.0 / elements) ** 2)
        misses.append(abs(math.acos(state.tangents[middle, 2]) - angle))
    assert order(misses) == pytest.approx(4.0, abs=0.3)


@pytest.mark.slow
def test_rod_pulled_over_a_cylinder_lifts_off():
    """Pinned far away, so that the reaction's line is the asymptote that the closed form has."""
    rho, radius, force = 0.3, 0.02, 40.0
    length = 14.0 * math.sqrt(BENDING / force) + 1.2 * rho
    cylinder = Obstacle.along(Cylinder(rho - radius), (0.5 * length, 0.0, -rho), ACROSS)
    pulls = [(force * math.cos(a), 0.0, -force * math.sin(a)) for a in (0.0, 0.75, 1.5)]
    rod = Rod(length, ROUND, radius)
    ways = [RodProblem(rod, RodLoad(tip_force=f), Pinned(), obstacles=(cylinder,)) for f in pulls]
    state = follow_contact(ways, elements=320).states[-1]
    psi, step = exact.lift_off_angle(BENDING, rho, force), length / 320
    reaction = -state.base_reaction[:3]
    assert norm(reaction) == pytest.approx(force, rel=2e-5)
    arc = 1.5 + math.atan2(reaction[2], reaction[0]) - 2.0 * psi
    total = force * (2.0 * math.sin(psi) + math.cos(psi) * arc)
    assert state.normal_forces.sum() == pytest.approx(total, rel=2e-5)
    assert state.contact_lengths[0] == pytest.approx(rho * arc, abs=2.0 * step)
    # Beyond lift-off the shear bends the rod away with the cube of the distance.
    beyond = (6.0 * BENDING * 2e-4 / (force * math.sin(psi))) ** (1.0 / 3.0)
    assert state.lengths_within(2e-4)[0] == pytest.approx(rho * arc + 2.0 * beyond, abs=0.2 * step)
    # Nothing but contact's constant curvature between the two lift-off points.
    bent = norm(state.moments[state.touching[0]], axis=1)
    assert bent == pytest.approx(BENDING / rho, rel=0.1)


def rope(length, around, hanging, elements):
    """Return places (n, 3) of a rope laid over a bar across the y axis."""
    s = np.linspace(0.0, length, elements + 1)
    angle = np.clip((s - hanging) / around, 0.0, math.pi)
    below = np.minimum(s - hanging, 0.0) - np.maximum(s - hanging - math.pi * around, 0.0)
    return np.column_stack((-around * np.cos(angle), 0.0 * s, around * np.sin(angle) + below))


AROUND, FRICTION = 0.07, 0.3


def dragged(elements, lever=None, sign=1.0, weight=0.0):
    """Return angles and tensions (n,) of a rope where it lies on a bar that turns under it.

    All of the rope slides; no zone sticks. Its bending stiffness counts where it lifts off only.
    """
    radius, hanging = 0.02, 4.0 * AROUND
    length = 2.0 * hanging + math.pi * AROUND
    rod = Rod(length, Section((1e-4,) * 3), radius, friction_radius=lever)
    smooth = Obstacle.along(Cylinder(AROUND - radius), (0.0, 0.0, 0.0), ACROSS)
    load = RodLoad((0.0, 0.0, -weight), (0.0, 0.0, -3.0 if weight else -1.0))
    start = rope(length, AROUND, hanging, elements)
    problem = RodProblem(rod, load, Pinned((*start[0],)), obstacles=(smooth,))
    loose = solve_contact(problem, start=start, elements=elements)
    rough = replace(smooth, friction=FRICTION)
    turns = [rough.moved(rotation=(0.0, 0.01 * sign * step, 0.0)) for step in range(1, 6)]
    ways = [replace(problem, obstacles=(one,)) for one in turns]
    state = follow_contact(ways, start=loose).states[-1]
    tension = np.sum(state.forces * state.tangents, axis=1)
    angles = np.arctan2(state.positions[:, 2], state.positions[:, 0])
    inner = np.flatnonzero(state.touching[0] & (angles > 1.1) & (angles < 2.0))
    assert not state.sticking[0, inner].any()
    return angles[inner], tension[inner]


@pytest.mark.parametrize(
    ("weight", "sign", "observed"), [(0.0, 1.0, 4.0), (3.5, 1.0, 2.0), (3.5, -1.0, 2.0)]
)
def test_tension_of_a_sliding_rope_grows_by_friction_and_weight(weight, sign, observed):
    """dT/dphi = r w cos phi + k (T + r w sin phi), k = +-mu: T = A e^(k phi) + r w (a sin + b cos).

    Its ends hang: with T = w h there, h_2 = h_1 e^(mu pi) + r 2 mu / (1 + mu^2) (e^(mu pi) + 1).
    Without weight it is the capstan equation.
    """
    errors = []
    for elements in (100, 200, 400):
        angles, tension = dragged(elements, 0.0, sign, weight)
        k = FRICTION if tension[0] > tension[-1] else -FRICTION
        a, b = (1.0 - k**2) / (1.0 + k**2), -2.0 * k / (1.0 + k**2)
        rest = tension - AROUND * weight * (a * np.sin(angles) + b * np.cos(angles))
        own = rest * np.exp(-k * angles)
        errors.append(float(np.ptp(own) / own.mean()))
    assert order(errors) == pytest.approx(observed, abs=0.3)
    assert weight or errors[0] < 1e-6


def test_thick_rope_gains_less_tension_since_friction_turns_its_section():
    """Friction at the surface: T ~ exp(lambda phi) inside, between layers where it lifts off."""
    exponent = exact.thick_capstan_exponent(FRICTION, AROUND, 0.02)
    errors = []
    for elements in (50, 400):
        angles, tension = dragged(elements)
        found = abs(math.log(tension[-1] / tension[0]) / (angles[-1] - angles[0]))
        errors.append(abs(found / exponent - 1.0))
    assert errors[1] < 3e-5 < 0.05 * errors[0]


@pytest.mark.parametrize(("elements", "friction"), [(20, 0.0), (40, 0.0), (20, 0.3), (40, 0.3)])
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
    assert fine.discretization_error is None
    if friction > 0.0:
        with pytest.raises(InvalidInputError, match="estimate_error"):
            solve_contact(problem, start=state, estimate_error=True)
    else:
        again = solve_contact(problem, start=state, estimate_error=True)
        assert again.discretization_error == pytest.approx(state.discretization_error, rel=1e-3)


def test_beam_on_three_supports_has_the_reactions_of_the_three_moment_equation():
    """Clamped level, and propped by a cylinder at its middle and a sphere at its end."""
    weight, span, under = 1e-3, 0.2, -0.02 - SPAN.radius
    props = (
        Obstacle.along(Cylinder(0.02), (span, 0.0, under), ACROSS),
        Obstacle(Sphere(0.02), (2.0 * span - 1e-6, 0.0, under)),
    )
    problem = RodProblem(SPAN, RodLoad((0.0, 0.0, -weight)), obstacles=props)
    state = solve_contact(problem, elements=80)
    parts = (state.base_reaction[2], *state.contact_forces.sum(axis=1)[:, 2])
    # Clapeyron: 13, 32 and 11 of 28 w l; the rod sags by 1e-5 of its length.
    assert parts == pytest.approx(np.array((13.0, 32.0, 11.0)) / 28.0 * weight * span, rel=2e-3)


def test_spun_cylinder_bears_the_torque_of_sliding_friction():
    """The torque is mu N R, of the radius of the cylinder, at whose surface friction acts."""
    cylinder = Obstacle.along(Cylinder(0.03), (0.2, 0.0, -0.07), ACROSS, friction=0.2)
    ends = Pinned(), Pinned((0.385, 0.0, -0.02))
    here = RodProblem(SPAN, RodLoad((0.0, 0.0, -0.5)), *ends, (cylinder,))
    spun = replace(here, obstacles=(cylinder.moved(rotation=(0.0, -1.0, 0.0)),))
    state = follow_contact([here, spun], elements=60).states[-1]
    around = state.on_obstacle().torque[1]
    assert around == pytest.approx(0.2 * state.normal_forces.sum() * 0.03, rel=1e-6)
    assert not state.sticking[state.touching].any()


@pytest.mark.slow
@pytest.mark.parametrize("index", range(20))
def test_rod_on_a_cylinder_is_where_an_independent_minimization_finds_it(index):
    """A cantilever that its weight and tip force press onto a cylinder below it."""
    rng = np.random.default_rng([13, index])
    reach, along, azimuth = rng.uniform(0.1, 0.5), rng.uniform(0.3, 0.8), rng.uniform(-0.6, 0.6)
    axis = np.array([math.sin(azimuth), math.cos(azimuth), rng.uniform(-0.4, 0.4)])
    axis /= norm(axis)
    # So far below that the straight rod is clear of it, wherever its axis passes.
    down = np.array([0.0, 0.0, -1.0])
    across = down - (down @ axis) * axis
    point = np.array([along, 0.0, 0.0]) + (1.05 * reach + 0.02) * across / norm(across)
    strain = rng.uniform(-1.0, 1.0, 3)
    weight = rng.uniform(4.0, 12.0) * (down + 0.3 * rng.uniform(-1.0, 1.0, 3))
    pull = rng.uniform(-2.0, 2.0, 3)
    problem = RodProblem(
        Rod(1.0, ROUND, 0.01, rest_strain=(*strain,)),
        RodLoad((*weight,), tip_force=(*pull,)),
        obstacles=(Obstacle.along(Cylinder(reach - 0.01), (*point,), (*axis,)),),
    )
    state = solve_contact(problem, elements=80)
    assert state.stable
    (finest, forces), (coarse, _) = (least_energy(problem, count) for count in (80, 40))
    assert state.touching.any() == forces.any()  # one of them misses the cylinder
    # The reference's own error, of second order, is a third of what halving its elements changes.
    off, own = np.abs(state.positions - finest).max(), np.abs(coarse - finest[::2]).max()
    assert off < 1.5 * own + 2e-5
    assert state.normal_forces.sum() == pytest.approx(forces.sum(), rel=0.02, abs=1e-6)
