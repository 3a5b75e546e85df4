# SPDX-License-Identifier: Apache-2.0
"""Rods in contact against closed forms, and against an independent minimization."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core import reference_contact as exact
from core.reference_minimum import Case, least_energy
from scipy.optimize import brentq

from spiral_core import (
    Cylinder,
    Obstacle,
    Pinned,
    Rod,
    RodLoad,
    RodProblem,
    RodState,
    Section,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

# Of the rods here, unless said otherwise.
BENDING, TORSIONAL = 1.0, 0.7
ROUND = Section((TORSIONAL, BENDING, BENDING))


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


def axial_moment(section: exact.Section, rho: float, angle: float, axial: float) -> float:
    """Return the moment about the axis of a wrapped helix with the axial force ``axial``."""
    binormal = exact.helix_on_cylinder(section, rho, angle, 0.0).binormal_force
    tension = (axial - binormal * math.sin(angle)) / math.cos(angle)
    helix = exact.helix_on_cylinder(section, rho, angle, tension)
    around = tension * math.sin(angle) - binormal * math.cos(angle)
    along = helix.axial_moment * math.cos(angle) + helix.binormal_moment * math.sin(angle)
    return rho * around + along


@pytest.mark.slow
@pytest.mark.parametrize("axial", [0.0, 3.0])
def test_coil_rests_on_a_cylinder_as_the_uniform_helix(axial: float) -> None:
    """Clamped at its own angle; the free end's influence fades within a turn.

    A frictionless cylinder bears neither force nor moment along its axis, so both are those of the
    tip in every section: with them Kirchhoff's helix has one angle.
    """
    section = exact.Section(BENDING, TORSIONAL, curvature=9.0, torsion=-4.0)
    rho, radius = 0.12, 0.02
    relaxed = exact.relaxed_angle(section, rho, -1.1)
    angle = brentq(lambda a: axial_moment(section, rho, a, axial), relaxed - 0.1, relaxed + 0.1)
    binormal = exact.helix_on_cylinder(section, rho, angle, 0.0).binormal_force
    tension = (axial - binormal * math.sin(angle)) / math.cos(angle)
    helix = exact.helix_on_cylinder(section, rho, angle, tension)
    length = 3.0 * 2.0 * math.pi * rho / abs(math.sin(angle))
    axis = (math.cos(angle), 0.0, -abs(math.sin(angle)))
    fx, fy, fz = (axial * a for a in axis)
    cylinder = Obstacle.along(Cylinder(rho - radius), (0.0, rho, 0.0), axis)
    rod = Rod(length, ROUND, radius, rest_strain=(section.torsion, 0.0, section.curvature))
    coiled = RodProblem(rod, obstacles=(cylinder,))
    pulled = RodProblem(rod, RodLoad(tip_force=(fx, fy, fz)), obstacles=(cylinder,))
    state = follow_contact([coiled, pulled], elements=120).states[-1]
    assert state.stable
    inner = slice(10, 31)
    line_force = state.normal_forces[0, inner] / state.node_lengths[inner]
    angles = np.arccos(state.tangents[inner] @ np.asarray(axis))
    assert angles == pytest.approx(abs(angle), abs=1e-4)
    assert line_force == pytest.approx(helix.line_force, rel=2e-3)
    assert state.moments[20, 0] == pytest.approx(helix.axial_moment, rel=1e-3)


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


@pytest.mark.slow
def test_rod_pulled_over_a_cylinder_lifts_off() -> None:
    """Pinned far away, so that the reaction's line is the asymptote that the closed form has."""
    rho, radius, force = 0.3, 0.02, 40.0
    psi = exact.lift_off_angle(BENDING, rho, force)
    length = 14.0 * math.sqrt(BENDING / force) + 1.2 * rho
    cylinder = Obstacle.along(Cylinder(rho - radius), (0.5 * length, 0.0, -rho), (0.0, 1.0, 0.0))

    def turned(angle: float) -> RodProblem:
        pull = (force * math.cos(angle), 0.0, -force * math.sin(angle))
        rod = Rod(length, ROUND, radius)
        return RodProblem(rod, RodLoad(tip_force=pull), Pinned(), obstacles=(cylinder,))

    state = follow_contact([turned(angle) for angle in (0.0, 0.75, 1.5)], elements=320).states[-1]
    reaction = -state.base_reaction[:3]
    assert np.linalg.norm(reaction) == pytest.approx(force, rel=2e-5)
    turn = 1.5 + math.atan2(reaction[2], reaction[0])
    arc = turn - 2.0 * psi
    total = 2.0 * force * math.sin(psi) + force * math.cos(psi) * arc
    assert state.normal_forces[0].sum() == pytest.approx(total, rel=2e-5)
    assert state.contact_lengths[0] == pytest.approx(rho * arc, abs=2.0 * length / 320)
    # Beyond lift-off the shear bends the rod away with the cube of the distance.
    gap = 0.01 * radius
    beyond = (6.0 * BENDING * gap / (force * math.sin(psi))) ** (1.0 / 3.0)
    within = rho * arc + 2.0 * beyond
    assert state.lengths_within(gap)[0] == pytest.approx(within, abs=0.2 * length / 320)
    # Nothing but contact's constant curvature between the two lift-off points.
    bent = np.linalg.norm(state.moments[state.touching[0]], axis=1)
    assert bent == pytest.approx(BENDING / rho, rel=0.1)


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
