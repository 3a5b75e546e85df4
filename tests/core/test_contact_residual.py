# SPDX-License-Identifier: Apache-2.0
"""What `residual` says is computed anew, from what a state shows and closed forms alone.

Its parts: forces in balance at each node, moments likewise, and for each obstacle and node that may
touch: no penetration (gap >= 0), no pull (normal force >= 0), complementarity (their product is
zero: twice 1e-10 of force scale times L / N counts as the tolerance, 1e-8), Coulomb's cone
(friction at most mu times the normal force, and as much, against the slip, where it slides). Chords
of elements, the last part, follow from the shape: the mean of both ends' strains to second order.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from core.contact_cases import OUTER, grip
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from spiral_core import (
    Clamped,
    Cylinder,
    Guided,
    Obstacle,
    Plane,
    PointLoad,
    Rod,
    RodLoad,
    RodProblem,
    RodState,
    Section,
    Sphere,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

Array = NDArray[np.float64]
LENGTH, RADIUS, BENDING = 0.5, 3e-3, 3e-4
ROD = Rod(LENGTH, Section((2e-4, BENDING, 5e-4)), RADIUS, rest_strain=(1.0, 0.5, 2.0))
BAR, BALL, FLOOR = (0.2, 0.0, -0.05), (0.4, -0.012, -0.072), -0.06
FRICTION = (0.3, 0.2, 0.4)


def problem(push: float) -> RodProblem:
    """Return a rod pressed onto a bar, a ball and the floor, and pushed aside at its tip."""
    obstacles = (
        Obstacle.along(Cylinder(0.03), BAR, (0.0, 1.0, 0.0), FRICTION[0]),
        Obstacle(Sphere(0.02), BALL, friction=FRICTION[1]),
        Obstacle(Plane(), (0.0, 0.0, FLOOR), friction=FRICTION[2]),
    )
    loads = tuple(PointLoad(at, (0.0, 0.0, -0.06)) for at in (0.1, 0.25, 0.35, 0.45))
    return RodProblem(
        ROD,
        RodLoad(tip_force=(0.0, push, -0.02), tip_moment=(1e-4, 0.0, 0.0)),
        base=Clamped(),
        obstacles=obstacles,
        point_loads=loads,
    )


@cache
def states() -> tuple[RodState, RodState]:
    """Return two states, one increment apart."""
    path = follow_contact([problem(0.0), problem(4e-3), problem(4.2e-3)], elements=50)
    assert not path.events
    return path.states[-2], path.states[-1]


def normals_and_gaps(points: Array) -> list[tuple[Array, Array]]:
    """Return outward normals (n, 3) and gaps (n,) to bar, ball and floor: school geometry."""
    flat = points - np.array(BAR)
    flat[:, 1] = 0.0
    round_ = points - np.array(BALL)
    far, near = (np.linalg.norm(away, axis=1) for away in (flat, round_))
    up = np.tile((0.0, 0.0, 1.0), (len(points), 1))
    return [
        (flat / far[:, None], far - 0.03 - RADIUS),
        (round_ / near[:, None], near - 0.02 - RADIUS),
        (up, points[:, 2] - FLOOR - RADIUS),
    ]


def nodal(state: RodState, problem: RodProblem) -> tuple[Array, Array]:
    """Return the outer forces and moments (n, 3) at each node, contact and reactions with them."""
    forces, moments = np.zeros((2, *state.positions.shape))
    forces[-1] += problem.load.tip_force
    moments[-1] += problem.load.tip_moment
    for load in problem.point_loads:
        forces[np.argmin(np.abs(state.arc_lengths - load.at))] += load.force
    for (normal, _), push in zip(
        normals_and_gaps(state.positions), state.contact_forces, strict=True
    ):
        forces += push
        moments += np.cross(-RADIUS * normal, push)  # at the surface
    forces[0] += state.base_reaction[:3]
    moments[0] += state.base_reaction[3:]
    return forces, moments


def parts(state: RodState, problem: RodProblem) -> dict[str, float]:
    """Return the residual's parts, in its units."""
    loads = np.linalg.norm([load.force for load in problem.point_loads], axis=1).sum() + 0.02
    force_scale = max(BENDING / LENGTH**2, loads)
    moment_scale = max(BENDING / LENGTH, force_scale * LENGTH / 50)
    forces, moments = nodal(state, problem)
    beyond = np.cumsum(forces[::-1], axis=0)[::-1]  # all at this node and farther out
    inner = np.vstack((beyond[1:], np.zeros(3)))
    # forces at a node are the mean of both sides
    mean = 0.5 * (beyond + inner)
    mean[0], mean[-1] = inner[0], beyond[-1]
    found = {"forces": np.abs(state.forces - mean).max() / force_scale}
    chords = np.diff(state.positions, axis=0)
    # the moment just after a node is that of all beyond, about it
    after = np.zeros_like(moments)
    for i in range(len(after) - 2, -1, -1):
        after[i] = after[i + 1] + moments[i + 1] + np.cross(chords[i], inner[i])
    shown = Rotation.from_quat(state.orientations).apply(state.moments)
    found["moments"] = np.abs(shown - after)[:-1].max() / moment_scale
    found["base"] = np.abs(after[0] + moments[0]).max() / moment_scale
    worst = dict.fromkeys(("gap", "pull", "apart", "cone"), 0.0)
    for j, (normal, gap) in enumerate(normals_and_gaps(state.positions)):
        push, open_ = state.contact_forces[j][1:], gap[1:]
        pressed = np.sum(push * normal[1:], axis=1)
        rubbed = np.linalg.norm(push - pressed[:, None] * normal[1:], axis=1)
        slides = state.touching[j][1:] & ~state.sticking[j][1:]
        cone = np.where(slides, np.abs(rubbed - FRICTION[j] * pressed), 0.0)
        cone = np.maximum(cone, rubbed - FRICTION[j] * pressed)
        worst["gap"] = max(worst["gap"], -open_.min() / (0.1 * LENGTH))
        worst["pull"] = max(worst["pull"], -pressed.min() / force_scale)
        both = np.abs(pressed * open_).max() / (force_scale * LENGTH / 50)
        worst["apart"] = max(worst["apart"], both / 2e-10 * 1e-8)
        worst["cone"] = max(worst["cone"], cone.max() / force_scale)
    return found | worst


def test_residual_is_that_of_its_parts() -> None:
    before, state = states()
    assert (state.touching.sum(axis=1) > 0).all()  # all three obstacles are touched
    assert (state.touching & ~state.sticking).any()
    assert (state.touching & state.sticking).any()
    assert state.residual < 1e-8
    for step in (before, state):
        asked = problem(4e-3 if step is before else 4.2e-3)
        for name, value in parts(step, asked).items():
            assert value < max(10.0 * step.residual, 1e-9), name


@pytest.mark.parametrize("part", ["forces", "moments", "gap", "apart", "cone"])
def test_parts_notice_what_is_off(part: str) -> None:
    """A state changed by a ten-millionth or a millionth of itself fails."""
    state, asked = states()[1], problem(4.2e-3)
    pushes = state.contact_forces.copy()
    node = int(np.argmax(np.where(state.sticking[2], 0.0, state.normal_forces[2])))
    if part == "gap":
        changed = replace(state, positions=state.positions - np.array((0.0, 0.0, 1e-7)))
    elif part == "apart":
        changed = replace(state, positions=state.positions + np.array((0.0, 0.0, 1e-7)))
    elif part == "moments":
        changed = replace(state, moments=state.moments * (1.0 + 1e-5))
    else:
        pushes[2, node] *= 1.0 + 1e-5
        if part == "cone":
            pushes[2, node, 1] *= 1.01
        changed = replace(state, contact_forces=pushes)
    assert parts(changed, asked)[part] > 1e-7


def test_friction_is_against_the_slip() -> None:
    """The way of the surface's material point from the state before, along the obstacle."""
    before, state = states()
    arms = normals_and_gaps(before.positions)
    turn = Rotation.from_quat(state.orientations) * Rotation.from_quat(before.orientations).inv()
    seen = 0
    for j, (normal, _) in enumerate(arms):
        way = state.positions - before.positions + turn.apply(-RADIUS * normal) + RADIUS * normal
        now = normals_and_gaps(state.positions)[j][0]
        way -= now * np.sum(way * now, axis=1)[:, None]
        push = state.contact_forces[j] - state.normal_forces[j][:, None] * now
        for i in np.flatnonzero(state.touching[j] & ~state.sticking[j] & before.touching[j]):
            size = np.linalg.norm(push[i]) * np.linalg.norm(way[i])
            assert push[i] @ way[i] < -0.999 * size
            seen += 1
    assert seen


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_obstacles_far_away_change_nothing(friction: float) -> None:
    """To 1e-8: shape, forces, reactions and energy are those without them."""
    load = RodLoad((0.0, 0.05, -0.3), (0.0, 0.01, 0.0))
    for tip in (None, Guided((0.4, 0.0, 0.0))):
        alone = RodProblem(ROD, load) if tip is None else RodProblem(ROD, load, tip=tip)
        far = (
            Obstacle.along(Cylinder(0.03), (0.0, 0.0, 3.0), (0.0, 1.0, 0.0), friction),
            Obstacle(Plane(), (0.0, 0.0, -2.0), friction=friction),
        )
        plain = solve_contact(alone, elements=40)
        state = solve_contact(replace(alone, obstacles=far), elements=40)
        assert not state.touching.any()
        assert not state.contact_forces.any()
        np.testing.assert_allclose(state.positions, plain.positions, atol=1e-8 * LENGTH)
        np.testing.assert_allclose(state.orientations, plain.orientations, atol=1e-8)
        scale = np.abs(plain.moments).max()
        np.testing.assert_allclose(state.moments, plain.moments, atol=1e-8 * scale)
        np.testing.assert_allclose(state.base_reaction, plain.base_reaction, atol=1e-8)
        assert state.energy == pytest.approx(plain.energy, rel=1e-9)


@pytest.mark.parametrize("elements", [60, 120])
def test_straight_elements_dip_by_no_more_than_stated(elements: int) -> None:
    """Between two touching nodes by h^2 / 8 (R + r), across the axis of the cylinder less."""
    asked = grip(0.015, 1.2)
    (obstacle,) = asked.obstacles
    state = solve_contact(asked, elements=elements)
    at = np.linspace(0.0, 1.0, 11)[:, None, None]
    points = (1.0 - at) * state.positions[:-1] + at * state.positions[1:]
    axis = Rotation.from_quat(obstacle.orientation).apply((0.0, 0.0, 1.0))
    away = np.linalg.norm(np.cross(points - np.asarray(obstacle.position), axis), axis=-1)
    dip = 0.015 + OUTER - away.min()
    stated = (asked.rod.length / elements) ** 2 / (8.0 * (0.015 + OUTER))
    assert 0.5 * stated < dip < stated
    assert state.gaps[:, 1:].min() > -1e-12  # at nodes nothing
