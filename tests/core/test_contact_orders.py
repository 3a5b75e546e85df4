# SPDX-License-Identifier: Apache-2.0
"""Closed forms of contact and friction are approached at an order; estimates bound the error."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from core import reference_contact as exact
from numpy.typing import NDArray

from spiral_core import (
    Cylinder,
    InvalidInputError,
    Obstacle,
    Pinned,
    Rod,
    RodLoad,
    RodProblem,
    RodState,
    Section,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

Array = NDArray[np.float64]
ROUND = Section((0.7, 1.0, 1.0))
PULLED = RodLoad(tip_force=(0.0, 0.0, -1.0))


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


def lifted(elements: int) -> RodState:
    """Return a rod pulled over a cylinder, from afar."""
    rho, radius, force = 0.3, 0.02, 40.0
    length = 14.0 * math.sqrt(1.0 / force) + 1.2 * rho
    cylinder = Obstacle.along(Cylinder(rho - radius), (0.5 * length, 0.0, -rho), (0.0, 1.0, 0.0))

    def turned(angle: float) -> RodProblem:
        pull = (force * math.cos(angle), 0.0, -force * math.sin(angle))
        rod = Rod(length, ROUND, radius)
        return RodProblem(rod, RodLoad(tip_force=pull), Pinned(), obstacles=(cylinder,))

    return follow_contact([turned(a) for a in (0.0, 0.75, 1.5)], elements=elements).states[-1]


@pytest.mark.slow
def test_resultants_of_a_lift_off_are_of_order_one_and_a_half() -> None:
    """It lies somewhere between two nodes: single errors scatter, so root mean squares count."""
    psi = exact.lift_off_angle(1.0, 0.3, 40.0)

    def miss(elements: int) -> float:
        state = lifted(elements)
        reaction = -state.base_reaction[:3]
        arc = 1.5 + math.atan2(reaction[2], reaction[0]) - 2.0 * psi
        total = 40.0 * (2.0 * math.sin(psi) + math.cos(psi) * arc)
        return state.normal_forces[0].sum() / total - 1.0

    few = np.array([miss(elements) for elements in range(40, 64, 4)])
    many = np.array([miss(elements) for elements in range(160, 256, 16)])
    shrunk = math.sqrt(np.mean(few**2) / np.mean(many**2))
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
def test_tension_of_a_sliding_rope_grows_as_the_capstan_equation_has_it(sign: float) -> None:
    errors = [abs(exponent_of(dragged(n, 0.0, sign)) - 0.3) for n in (100, 200, 400)]
    assert order(errors) == pytest.approx(4.0, abs=0.3)
    assert errors[0] < 1e-6


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_tension_of_a_heavy_sliding_rope_grows_by_its_weight_too(sign: float) -> None:
    """dT/dphi = r w cos phi + k (T + r w sin phi), k = +-mu: T = A e^(k phi) + r w (a sin + b cos).

    Its ends hang: with T = w h there, h_2 = h_1 e^(mu pi) + r 2 mu / (1 + mu^2) (e^(mu pi) + 1).
    """
    around, weight, mu = 0.07, 3.5, 0.3
    load = RodLoad((0.0, 0.0, -weight), (0.0, 0.0, -3.0))

    def miss(elements: int) -> float:
        angles, tension = dragged(elements, 0.0, sign, load)
        k = mu if tension[0] > tension[-1] else -mu
        a, b = (1.0 - mu**2) / (1.0 + mu**2), -2.0 * k / (1.0 + mu**2)
        rest = tension - around * weight * (a * np.sin(angles) + b * np.cos(angles))
        own = rest * np.exp(-k * angles)
        return float(np.ptp(own) / own.mean())

    errors = [miss(elements) for elements in (100, 200, 400)]
    assert order(errors) == pytest.approx(2.0, abs=0.3)


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
