# SPDX-License-Identifier: Apache-2.0
"""Rods in contact against closed forms, at an order, and against an independent minimization."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from core import reference_contact as exact
from core.contact_paths import SPAN
from core.reference_minimum import Case, least_energy
from numpy.typing import NDArray

from spiral_core import (
    Clamped,
    Cylinder,
    InvalidInputError,
    Obstacle,
    Pinned,
    Plane,
    Rod,
    RodLoad,
    RodProblem,
    RodState,
    Section,
    Sphere,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

Array = NDArray[np.float64]
# Of the rods here, unless said otherwise.
BENDING, TORSIONAL = 1.0, 0.7
ROUND = Section((TORSIONAL, BENDING, BENDING))
PULLED = RodLoad(tip_force=(0.0, 0.0, -1.0))


def over_cylinder(elements: int) -> RodState:
    """Return a cantilever of length 1 pressed over a cylinder below it by its tip force."""
    cylinder = Obstacle.along(Cylinder(0.48), (0.0, 0.0, -0.5), (0.0, 1.0, 0.0))
    problem = RodProblem(
        Rod(1.0, ROUND, radius=0.02),
        RodLoad(tip_force=(0.0, 0.0, -4.0)),
        obstacles=(cylinder,),
    )
    return solve_contact(problem, elements=elements)


def test_cantilever_over_a_cylinder() -> None:
    free, tip = exact.cantilever_over_cylinder(BENDING, 1.0, 0.5, 4.0)
    errors = []
    for elements in (20, 40, 80):
        state = over_cylinder(elements)
        errors.append(np.abs(state.positions[-1, [0, 2]] - tip).max())
        step = 1.0 / elements
        assert state.contact_lengths[0] == pytest.approx(1.0 - free, abs=step)
        # The tip's force presses where the rod lifts off, and its tension on the arc before that;
        # what the clamped node would bear is in its reaction.
        turn = (1.0 - free) / 0.5
        pressed = 4.0 * (math.cos(turn) + math.sin(turn) * turn)
        assert state.normal_forces.sum() == pytest.approx(pressed, rel=0.5 / elements)
    assert errors[0] < 1e-5
    assert max(errors) == errors[0]
    assert math.log2(errors[0] / errors[-1]) > 2.5  # measured: order 1.7, then 1.3


def order(errors: list[float]) -> float:
    """Return the order between the first and the last of errors on 1, 2, 4, ... times elements."""
    return math.log2(errors[0] / errors[-1]) / (len(errors) - 1)


def coil(elements: int) -> tuple[float, float]:
    """Return the errors of angle [rad] and line force of a helix that its tip's load keeps even."""
    section = exact.Section(1.0, 0.7, curvature=9.0, torsion=-4.0)
    rho, radius = 0.12, 0.02
    angle = exact.relaxed_angle(section, rho, -1.2)
    helix = exact.helix_on_cylinder(section, rho, angle)
    sin, cos = math.sin(angle), math.cos(angle)
    length = 2.0 * 2.0 * math.pi * rho / abs(sin)
    axis = np.array((cos, 0.0, sin))
    turn = sin * length / rho
    inward, around = np.array((0.0, 1.0, 0.0)), np.array((sin, 0.0, -cos))
    normal = math.cos(turn) * inward - math.sin(turn) * around
    tangent = cos * axis + sin * (math.cos(turn) * around + math.sin(turn) * inward)
    across = np.cross(tangent, normal)
    force = helix.tension * tangent + helix.binormal_force * across
    moment = helix.axial_moment * tangent + helix.binormal_moment * across
    problem = RodProblem(
        Rod(length, ROUND, radius, rest_strain=(section.torsion, 0.0, section.curvature)),
        RodLoad(tip_force=(*force.tolist(),), tip_moment=(*moment.tolist(),)),
        obstacles=(Obstacle.along(Cylinder(rho - radius), (0.0, rho, 0.0), (*axis.tolist(),)),),
    )
    s = np.linspace(0.0, length, elements + 1)[:, None]
    turns = sin * s / rho
    start = s * cos * axis + rho * ((1.0 - np.cos(turns)) * inward + np.sin(turns) * around)
    state = solve_contact(problem, start=start, elements=elements)
    middle = slice(elements // 4, 3 * elements // 4)
    angles = np.arccos(state.tangents[middle] @ axis)
    forces = state.normal_forces[0, middle] / state.node_lengths[middle]
    return np.abs(angles + angle).max(), np.abs(forces / helix.line_force - 1.0).max()


def test_helix_on_a_cylinder_is_of_second_order_and_more() -> None:
    """Contact at nodes gives the ends' sections a moment that is off by q h^2 / 12."""
    errors = [coil(elements) for elements in (40, 80, 160)]
    assert order([angle for angle, _ in errors]) > 2.3  # measured: 2.5
    assert order([force for _, force in errors]) > 2.3  # measured: 2.9
    assert max(errors[-1]) < 2e-6


def test_rod_buckled_in_a_tube_presses_outward() -> None:
    bending, rho, radius, angle = 0.3, 0.01, 0.004, 0.35
    push, line_force = exact.helix_in_tube(bending, rho, angle)
    length = 5.0 * 2.0 * math.pi * rho / math.sin(angle)
    tube = Obstacle(Cylinder(rho + radius, inside=True))
    misses = []
    for elements in (100, 200):
        s = np.linspace(0.0, length, elements + 1)
        around = s * math.sin(angle) / rho
        inside = 0.98 * rho
        start = np.column_stack(
            (inside * np.cos(around), inside * np.sin(around), s * math.cos(angle))
        )
        problem = RodProblem(
            Rod(length, Section((0.2, bending, bending)), radius),
            RodLoad(tip_force=(0.0, 0.0, -push)),
            base=Pinned((inside, 0.0, 0.0)),
            obstacles=(tube,),
        )
        state = solve_contact(problem, start=start, elements=elements)
        middle = elements // 2
        x, y, _ = state.positions[middle]
        assert state.contact_forces[0, middle, :2] @ (x, y) < 0.0
        force = state.normal_forces[0, middle] / state.node_lengths[middle]
        assert force == pytest.approx(line_force, rel=4e-4 * (100.0 / elements) ** 2)
        misses.append(abs(math.acos(state.tangents[middle, 2]) - angle))
    assert math.log2(misses[0] / misses[1]) == pytest.approx(4.0, abs=0.3)


def lifted(elements: int) -> RodState:
    """Return a rod pulled over a cylinder, from afar.

    Pinned far away, so that the reaction's line is the asymptote that the closed form has.
    """
    rho, radius, force = 0.3, 0.02, 40.0
    length = 14.0 * math.sqrt(BENDING / force) + 1.2 * rho
    cylinder = Obstacle.along(Cylinder(rho - radius), (0.5 * length, 0.0, -rho), (0.0, 1.0, 0.0))

    def turned(angle: float) -> RodProblem:
        pull = (force * math.cos(angle), 0.0, -force * math.sin(angle))
        rod = Rod(length, ROUND, radius)
        return RodProblem(rod, RodLoad(tip_force=pull), Pinned(), obstacles=(cylinder,))

    return follow_contact([turned(a) for a in (0.0, 0.75, 1.5)], elements=elements).states[-1]


def lift_off(state: RodState) -> tuple[float, float]:
    """Return the arc [rad] in contact and the sum of normal forces, of the closed form."""
    psi = exact.lift_off_angle(BENDING, 0.3, 40.0)
    reaction = -state.base_reaction[:3]
    arc = 1.5 + math.atan2(reaction[2], reaction[0]) - 2.0 * psi
    return arc, 40.0 * (2.0 * math.sin(psi) + math.cos(psi) * arc)


@pytest.mark.slow
def test_rod_pulled_over_a_cylinder_lifts_off() -> None:
    state = lifted(320)
    arc, total = lift_off(state)
    length, psi = state.arc_lengths[-1], exact.lift_off_angle(BENDING, 0.3, 40.0)
    assert np.linalg.norm(state.base_reaction[:3]) == pytest.approx(40.0, rel=2e-5)
    assert state.normal_forces[0].sum() == pytest.approx(total, rel=2e-5)
    assert state.contact_lengths[0] == pytest.approx(0.3 * arc, abs=2.0 * length / 320)
    # Beyond lift-off the shear bends the rod away with the cube of the distance.
    beyond = (6.0 * BENDING * 2e-4 / (40.0 * math.sin(psi))) ** (1.0 / 3.0)
    within = 0.3 * arc + 2.0 * beyond
    assert state.lengths_within(2e-4)[0] == pytest.approx(within, abs=0.2 * length / 320)
    # Nothing but contact's constant curvature between the two lift-off points.
    bent = np.linalg.norm(state.moments[state.touching[0]], axis=1)
    assert bent == pytest.approx(BENDING / 0.3, rel=0.1)


@pytest.mark.slow
def test_resultants_of_a_lift_off_are_of_order_one_and_a_half() -> None:
    """It lies somewhere between two nodes: single errors scatter, so root mean squares count."""

    def misses(counts: range) -> float:
        states = [lifted(elements) for elements in counts]
        off = [state.normal_forces[0].sum() / lift_off(state)[1] - 1.0 for state in states]
        return math.sqrt(np.mean(np.square(off)))

    shrunk = misses(range(40, 64, 4)) / misses(range(160, 256, 16))
    assert math.log(shrunk, 4.0) > 1.4  # measured: 1.6


def dragged(
    elements: int, lever: float | None, sign: float, load: RodLoad = PULLED
) -> tuple[Array, Array]:
    """Return angles and tensions (n,) of a rope where it lies on a bar that turns under it.

    All of the rope slides; no zone sticks. Its bending stiffness counts where it lifts off only.
    """
    radius, bar, bending = 0.02, 0.05, 1e-4
    around, hanging = radius + bar, 4.0 * (radius + bar)
    length = 2.0 * hanging + math.pi * around
    rod = Rod(length, Section((bending,) * 3), radius, friction_radius=lever)
    smooth = Obstacle.along(Cylinder(bar), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    rough = replace(smooth, friction=0.3)

    def problem(obstacle: Obstacle) -> RodProblem:
        return RodProblem(rod, load, Pinned((-around, 0.0, -hanging)), obstacles=(obstacle,))

    def draped(s: float) -> tuple[float, float, float]:
        angle = min(max((s - hanging) / around, 0.0), math.pi)
        below = min(s - hanging, 0.0) + min(length - hanging - s, 0.0)
        return (-around * math.cos(angle), 0.0, around * math.sin(angle) + below)

    start = np.array([draped(s) for s in np.linspace(0.0, length, elements + 1)])
    loose = solve_contact(problem(smooth), start=start, elements=elements)
    turns = [rough.moved(rotation=(0.0, 0.01 * sign * step, 0.0)) for step in range(1, 6)]
    state = follow_contact([problem(one) for one in turns], start=loose).states[-1]
    tension = np.sum(state.forces * state.tangents, axis=1)
    angles = np.arctan2(state.positions[:, 2], state.positions[:, 0])
    inner = np.flatnonzero(state.touching[0] & (angles > 1.1) & (angles < 2.0))
    assert not state.sticking[0, inner].any()
    return angles[inner], tension[inner]


def exponent_of(rope: tuple[Array, Array]) -> float:
    """Return the exponent with which tension grows with the angle."""
    angles, tension = rope
    return abs(math.log(tension[-1] / tension[0]) / (angles[-1] - angles[0]))


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("weight", "observed"), [(0.0, 4.0), (3.5, 2.0)])
def test_tension_of_a_sliding_rope_grows_by_friction_and_weight(
    weight: float, observed: float, sign: float
) -> None:
    """dT/dphi = r w cos phi + k (T + r w sin phi), k = +-mu: T = A e^(k phi) + r w (a sin + b cos).

    Its ends hang: with T = w h there, h_2 = h_1 e^(mu pi) + r 2 mu / (1 + mu^2) (e^(mu pi) + 1).
    Without weight it is the capstan equation.
    """
    around, mu = 0.07, 0.3
    load = RodLoad((0.0, 0.0, -weight), (0.0, 0.0, -3.0 if weight else -1.0))

    def miss(elements: int) -> float:
        angles, tension = dragged(elements, 0.0, sign, load)
        k = mu if tension[0] > tension[-1] else -mu
        a, b = (1.0 - mu**2) / (1.0 + mu**2), -2.0 * k / (1.0 + mu**2)
        rest = tension - around * weight * (a * np.sin(angles) + b * np.cos(angles))
        own = rest * np.exp(-k * angles)
        return float(np.ptp(own) / own.mean())

    errors = [miss(elements) for elements in (100, 200, 400)]
    assert order(errors) == pytest.approx(observed, abs=0.3)
    assert weight or errors[0] < 1e-6


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_thick_rope_gains_less_tension_since_friction_turns_its_section(sign: float) -> None:
    """Friction at the surface: T ~ exp(lambda phi) inside, between layers where it lifts off."""
    exponent = exact.thick_capstan_exponent(0.3, 0.07, 0.02)
    assert exponent < 0.75 * 0.3
    errors = [abs(exponent_of(dragged(n, None, sign)) / exponent - 1.0) for n in (50, 100, 400)]
    assert errors[-1] < 3e-5
    assert errors[0] > 20.0 * errors[-1]


def pressed(friction: float) -> RodProblem:
    """Return a cantilever pressed over a cylinder below it by its tip force, out of its plane."""
    cylinder = Obstacle.along(Cylinder(0.48), (0.25, 0.0, -0.55), (0.2, 1.0, 0.0), friction)
    rod = Rod(1.0, ROUND, radius=0.02, rest_strain=(0.4, 0.0, 0.3))
    return RodProblem(rod, RodLoad(tip_force=(0.0, 0.5, -4.0)), obstacles=(cylinder,))


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("elements", [20, 30, 40])
def test_estimated_error_bounds_the_true_one(elements: int, friction: float) -> None:
    """Against eight times as many elements."""
    problem = pressed(friction)
    state = solve_contact(problem, elements=elements, estimate_error=True)
    fine = solve_contact(problem, elements=8 * elements)
    off = np.linalg.norm(fine.positions[::8] - state.positions, axis=1).max()
    assert off < state.discretization_error < 20.0 * off
    assert solve_contact(problem, elements=elements).discretization_error is None


def test_error_is_estimated_from_a_state_but_for_friction() -> None:
    """The slips up to a state are not known on other elements."""
    smooth = solve_contact(pressed(0.0), elements=20, estimate_error=True)
    again = solve_contact(pressed(0.0), start=smooth, estimate_error=True)
    assert again.discretization_error == pytest.approx(smooth.discretization_error, rel=1e-3)
    with pytest.raises(InvalidInputError, match="estimate_error"):
        solve_contact(pressed(0.3), start=smooth, estimate_error=True)


def test_beam_on_three_supports_has_the_reactions_of_the_three_moment_equation() -> None:
    """Clamped level, and propped by a cylinder at its middle and a sphere at its end."""
    weight, span = 1e-3, 0.2
    props = (
        Obstacle.along(Cylinder(0.02), (span, 0.0, -0.02 - SPAN.radius), (0.0, 1.0, 0.0)),
        Obstacle(Sphere(0.02), (2.0 * span - 1e-6, 0.0, -0.02 - SPAN.radius)),
    )
    problem = RodProblem(SPAN, RodLoad((0.0, 0.0, -weight)), obstacles=props)
    state = solve_contact(problem, elements=80)
    parts = (state.base_reaction[2], *state.contact_forces.sum(axis=1)[:, 2])
    # Clapeyron: 13, 32 and 11 of 28 w l; the rod sags by 1e-5 of its length.
    expected = np.array((13.0, 32.0, 11.0)) / 28.0 * weight * span
    assert parts == pytest.approx(expected, rel=2e-3)
    assert sum(parts) == pytest.approx(2.0 * weight * span, rel=1e-9)


def test_floor_drags_the_rod_with_coulombs_force() -> None:
    floor = Obstacle(Plane(), (0.0, 0.0, -0.03), friction=0.3)
    here = RodProblem(SPAN, RodLoad((0.0, 0.0, -0.5)), obstacles=(floor,))
    gone = replace(here, obstacles=(floor.moved((-0.01, 0.0, 0.0)),))
    lying, dragged = follow_contact([here, gone], elements=40).states
    pressed = dragged.normal_forces.sum()
    assert dragged.on_obstacle().force[0] == pytest.approx(0.3 * pressed, rel=1e-6)
    assert not dragged.sticking.any()
    assert abs(lying.on_obstacle().force[0]) <= 0.3 * (1.0 + 1e-9) * lying.normal_forces.sum()


def test_spun_cylinder_bears_the_torque_of_sliding_friction() -> None:
    """The torque is mu N R, of the radius of the cylinder, at whose surface friction acts."""
    cylinder = Obstacle.along(Cylinder(0.03), (0.2, 0.0, -0.07), (0.0, 1.0, 0.0), friction=0.2)
    here = RodProblem(
        SPAN, RodLoad((0.0, 0.0, -0.5)), base=Pinned(), tip=Pinned((0.385, 0.0, -0.02)),
        obstacles=(cylinder,),
    )  # fmt: skip
    spun = replace(here, obstacles=(cylinder.moved(rotation=(0.0, -1.0, 0.0)),))
    state = follow_contact([here, spun], elements=60).states[-1]
    around = state.on_obstacle().torque[1]
    assert around == pytest.approx(0.2 * state.normal_forces.sum() * 0.03, rel=1e-6)
    assert not state.sticking[state.touching].any()


def test_clamp_turned_step_by_step_winds_the_rod_up() -> None:
    """A straight rod between two clamps, one of which turns by five turns about the rod."""
    length = 0.4
    rod = Rod(length, Section((4e-4, 2.7e-4, 2.7e-4)))
    angles = np.linspace(0.0, 1.6 * math.pi, 9)
    stations = [
        RodProblem(
            rod,
            base=Clamped(),
            tip=Clamped((length, 0.0, 0.0), (math.sin(a / 2), 0.0, 0.0, math.cos(a / 2))),
        )
        for a in angles
    ]
    states = follow_contact(stations, elements=24).states
    for angle, state in zip(angles, states, strict=True):
        # Below Greenhill's moment, 2 pi EI / L for pins, it stays straight: M = GJ angle / L.
        assert state.tip_reaction[3] == pytest.approx(4e-4 * angle / length, abs=1e-9)
        assert np.abs(state.positions[:, 1:]).max() < 1e-9


def random_case(index: int) -> Case:
    """Return a cantilever that its weight and tip force press onto a cylinder below it."""
    rng = np.random.default_rng([13, index])
    reach = rng.uniform(0.1, 0.5)
    along = rng.uniform(0.3, 0.8)
    azimuth = rng.uniform(-0.6, 0.6)
    axis = np.array([math.sin(azimuth), math.cos(azimuth), rng.uniform(-0.4, 0.4)])
    axis /= np.linalg.norm(axis)
    # So far below that the straight rod is clear of it, wherever its axis passes.
    down = np.array([0.0, 0.0, -1.0])
    across = down - (down @ axis) * axis
    point = np.array([along, 0.0, 0.0]) + (1.05 * reach + 0.02) * across / np.linalg.norm(across)
    return Case(
        length=1.0,
        stiffness=np.array([TORSIONAL, BENDING, BENDING]),
        rest_strain=rng.uniform(-1.0, 1.0, 3),
        weight=rng.uniform(4.0, 12.0) * (down + 0.3 * rng.uniform(-1.0, 1.0, 3)),
        tip_force=rng.uniform(-2.0, 2.0, 3),
        point=point,
        axis=axis,
        reach=reach,
    )


@pytest.mark.slow
@pytest.mark.parametrize("index", range(20))
def test_rod_on_a_cylinder_is_where_an_independent_minimization_finds_it(index: int) -> None:
    case = random_case(index)
    radius = 0.01
    tx, ty, tz = case.rest_strain
    wx, wy, wz = case.weight
    fx, fy, fz = case.tip_force
    px, py, pz = case.point
    problem = RodProblem(
        Rod(1.0, ROUND, radius, rest_strain=(tx, ty, tz)),
        RodLoad((wx, wy, wz), tip_force=(fx, fy, fz)),
        obstacles=(Obstacle.along(Cylinder(case.reach - radius), (px, py, pz), tuple(case.axis)),),
    )
    state = solve_contact(problem, elements=80)
    assert state.stable
    finest = least_energy(case, 80)
    assert state.touching.any() == finest.forces.any()  # one of them misses the cylinder
    coarse = least_energy(case, 40)
    # The reference's own error, of second order, is a third of what halving its elements changes.
    off = np.abs(state.positions - finest.positions).max()
    own = np.abs(coarse.positions - finest.positions[::2]).max()
    assert off < 1.5 * own + 2e-5
    assert state.normal_forces.sum() == pytest.approx(finest.forces.sum(), rel=0.02, abs=1e-6)
