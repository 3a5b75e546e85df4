# SPDX-License-Identifier: Apache-2.0
"""Every path of ``contact_paths``: its laws, recomputed; its images; the work of what moves."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from functools import cache

import numpy as np
import pytest
from core.contact_paths import (
    BETWEEN,
    HEAVY,
    HELD,
    KINDS,
    LINE,
    PATHS,
    PLACE,
    SPAN,
    Path,
    held,
)
from numpy.linalg import norm
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.contact_paths import MIRROR, backwards, imbalance, mirrored, moved
from benchmarks.rounding import followed as followed_otherwise
from spiral_core import (
    Capsule,
    Clamped,
    Cone,
    Cylinder,
    Free,
    Guided,
    Obstacle,
    Plane,
    Profile,
    Rod,
    RodLoad,
    RodProblem,
    Section,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

pytestmark = pytest.mark.long

Array = NDArray[np.float64]


@cache
def states(name):
    """Return the states of a named path."""
    return PATHS[name].followed()


def agree(found, expected, within):
    """Check that two arrays are the same, to a part of the largest value."""
    size = np.abs(expected).max(initial=1e-12)
    assert_allclose(found, expected, rtol=0.0, atol=within * size)


def in_base_frame(state):
    """Return the moments inside (n, 3)."""
    return Rotation.from_quat(state.orientations).apply(state.moments)


def laws(state, problem):
    """Return normals (n, 3), gaps, pressing forces (n,) and friction (n, 3) of each obstacle."""
    found = []
    for obstacle, push in zip(problem.obstacles, state.contact_forces, strict=True):
        frame = Rotation.from_quat(obstacle.orientation)
        local = frame.inv().apply(state.positions - np.asarray(obstacle.position))
        distance, normal, _ = obstacle.shape.distance(local)
        normal = frame.apply(normal)
        pressed = np.sum(push * normal, axis=1)
        gap = distance - problem.rod.radius
        found.append((normal, gap, pressed, push - pressed[:, None] * normal))
    return found


@pytest.mark.parametrize("name", PATHS)
def test_state_is_in_balance_and_keeps_the_laws_of_contact(name):
    """No penetration, no pull, no force at a distance; friction within Coulomb's cone, or on it."""
    state, problem = states(name)[-1], PATHS[name].stations[-1]
    rod = problem.rod
    assert state.stable
    weight = norm(problem.load.distributed) * rod.length
    scale = max(weight, state.normal_forces.sum())
    force, moment = imbalance(problem, state)
    assert force < 1e-6 * scale
    # The sum for the weight's moment is of fourth order; the solve's is not at stake.
    assert moment < 4e-6 * scale * rod.length
    for j, (_, gap, pressed, rubbed) in enumerate(laws(state, problem)):
        assert_allclose(state.gaps[j], gap, atol=1e-9)
        assert_allclose(state.normal_forces[j], pressed, atol=1e-9 * scale)
        assert gap[1:].min() > -1e-3 * rod.radius
        assert pressed.min() >= -1e-9 * scale
        assert np.abs(pressed * gap)[1:].max() < 1e-8 * scale * rod.length
        spare = problem.obstacles[j].friction * pressed - norm(rubbed, axis=1)
        assert spare.min() > -1e-6 * scale
        slides = state.touching[j] & ~state.sticking[j]
        assert spare[1:][slides[1:]].max(initial=0.0) < 1e-6 * scale


def parts(state, problem):
    """Return the residual's parts, in its units: of each obstacle, and of the rod."""
    rod, load, count = problem.rod, problem.load, len(state.positions) - 1
    bending = rod.section.matrix[1, 1]
    loads = [load.tip_force, *(each.force for each in problem.point_loads)]
    inside = 0.1 * norm(state.forces, axis=1).max()
    force_scale = max(bending / rod.length**2, norm(loads, axis=1).sum(), inside)
    moment_scale = max(bending / rod.length, force_scale * rod.length / count)
    lever = rod.radius if rod.friction_radius is None else rod.friction_radius
    forces, moments = np.zeros((2, *state.positions.shape))
    forces[-1], moments[-1] = load.tip_force, load.tip_moment
    for each in problem.point_loads:
        node = np.argmin(np.abs(state.arc_lengths - each.at))
        forces[node] += each.force
        moments[node] += each.moment
    off = []
    for j, (normal, gap, pressing, rubbed) in enumerate(laws(state, problem)):
        push = state.contact_forces[j]
        forces += push
        moments += np.cross(-lever * normal, push)
        cone = norm(rubbed, axis=1) - problem.obstacles[j].friction * pressing
        slides = state.touching[j] & ~state.sticking[j]
        cone = np.maximum(cone, np.where(slides, np.abs(cone), 0.0))[1:]
        apart = np.abs(pressing * gap)[1:].max() / (force_scale * rod.length / count)
        off += [-gap[1:].min() / (0.1 * rod.length), 50.0 * apart]
        off += [-pressing[1:].min() / force_scale, cone.max() / force_scale]
    forces[0] += state.base_reaction[:3]
    moments[0] += state.base_reaction[3:]
    beyond = np.cumsum(forces[::-1], axis=0)[::-1]  # all at this node and farther out
    inner = np.vstack((beyond[1:], np.zeros(3)))
    # forces at a node are the mean of both sides
    mean = 0.5 * (beyond + inner)
    mean[0], mean[-1] = inner[0], beyond[-1]
    # the moment just after a node is that of all beyond, about it
    levers = np.cross(np.diff(state.positions, axis=0), inner[:-1])
    after = np.cumsum((moments[1:] + levers)[::-1], axis=0)[::-1]
    off.append(np.abs(state.forces - mean).max() / force_scale)
    off.append(np.abs(in_base_frame(state)[:-1] - after).max() / moment_scale)
    return [*off, np.abs(after[0] + moments[0]).max() / moment_scale]


# Without weight a node's balance has no error of the elements.
@pytest.mark.parametrize("name", ["pressed down", "pulled out, weightless"])
def test_residual_is_that_of_its_parts(name):
    stations = PATHS[name].stations
    for state, problem in list(zip(states(name), stations, strict=True))[-2:]:
        assert state.residual < 1e-8
        assert (state.touching.sum(axis=1) > 0).all()
        assert (state.touching & ~state.sticking).any()
        assert max(parts(state, problem)) < max(10.0 * state.residual, 1e-9)
    assert any((state.touching & state.sticking).any() for state in states(name))


# Lengths are multiplied by 10, EI by 1e4, forces by 100.
LARGER = 10.0
POWERS = {
    "length": 1, "radius": 1, "position": 1, "at": 1, "rest_strain": -1, "distributed": 1,
    "tip_force": 2, "tip_moment": 3, "force": 2, "moment": 3, "extension": 2, "shear": 2,
}  # fmt: skip


def larger(thing):
    """Return a problem, or a part of one, with all its fields in these units."""
    if isinstance(thing, tuple):
        return tuple(map(larger, thing))
    if not is_dataclass(thing):
        return thing
    found = {one.name: larger(getattr(thing, one.name)) for one in fields(thing)}
    for name in POWERS.keys() & found.keys():
        found[name] = (LARGER ** POWERS[name] * np.asarray(getattr(thing, name))).tolist()
    if isinstance(thing, Section):
        full = np.asarray(thing.stiffness)
        units = LARGER ** np.array((2, 2, 2, 1, 1, 1))[: len(full)]
        found["stiffness"] = full * (np.outer(units, units) if full.ndim == 2 else units**2)
    return replace(thing, **found)


ROTATION = Rotation.from_rotvec((0.4, -1.1, 2.0))
SHIFT = np.array((0.3, -0.2, 0.15))
# The image of a problem; and by what its answer is multiplied, turned or flipped, and shifted.
IMAGES = {
    "moved": (lambda p: moved(p, SHIFT, ROTATION), 1.0, ROTATION.as_matrix(), SHIFT),
    "mirrored": (mirrored, 1.0, MIRROR, np.zeros(3)),
    "larger": (larger, LARGER, np.eye(3), np.zeros(3)),
}


@pytest.mark.parametrize("image", IMAGES)
@pytest.mark.parametrize("name", PATHS)
def test_image_of_a_problem_has_the_image_of_its_answer(name, image):
    """Slips and tolerances scale along."""
    asked, size, turn, shift = IMAGES[image]
    plain, path = states(name)[-1], PATHS[name]
    state = replace(path, stations=[asked(each) for each in path.stations]).followed()[-1]
    forces, moments = size**2 * turn.T, size**3 * np.linalg.det(turn) * turn.T
    length = size * path.stations[-1].rod.length
    expected = size * plain.positions @ turn.T + shift
    assert_allclose(state.positions, expected, atol=1e-7 * length)
    agree(state.contact_forces, plain.contact_forces @ forces, 1e-5)
    expected = in_base_frame(plain) @ moments
    agree(in_base_frame(state), expected, 1e-6)
    assert_allclose(
        state.base_reaction[3:], plain.base_reaction[3:] @ moments, atol=1e-6 * np.ptp(expected)
    )
    # The potential energy has the work of the loads over the shift in it.
    bears = (plain.base_reaction + plain.tip_reaction)[:3] + plain.contact_forces.sum(axis=(0, 1))
    energy = size**3 * plain.energy + bears @ forces @ shift
    assert state.energy == pytest.approx(energy, rel=1e-6)


@pytest.mark.parametrize("name", BETWEEN)
def test_rod_read_from_its_other_end_is_the_same_rod(name):
    one, other = states(name)[-1], solve_contact(backwards(BETWEEN[name]), elements=48)
    assert_allclose(other.positions[::-1], one.positions, atol=1e-9)
    assert_allclose(other.base_reaction, one.tip_reaction, atol=1e-9)
    assert other.energy == pytest.approx(one.energy, rel=1e-9)


@pytest.mark.parametrize("name", BETWEEN)
def test_end_is_where_it_is_held_and_bears_only_what_it_holds(name):
    problem, state = BETWEEN[name], states(name)[-1]
    weight = norm(HEAVY.distributed) * HELD.length
    for end, node, reaction in (
        (problem.base, 0, state.base_reaction),
        (problem.tip, -1, state.tip_reaction),
    ):
        force, moment = reaction[:3], norm(reaction[3:]) / HELD.length
        if isinstance(end, Free):
            assert norm(force) + moment < 1e-8 * weight
            continue
        off = state.positions[node] - end.position
        if isinstance(end, Guided):
            assert norm(np.cross(off, LINE)) < 1e-12
            assert norm(off) > 1e-4  # it has slid along
            assert abs(force @ LINE) < 1e-8 * weight
        else:
            assert norm(off) < 1e-12
        if getattr(end, "orientation", None) is None:
            assert moment < 1e-8 * weight
        else:
            assert state.orientations[node] == pytest.approx(end.orientation, abs=1e-12)
            assert moment > 1e-4 * weight


@pytest.mark.parametrize("tip", ["clamped", "pinned", "guided", "guided, not turning"])
def test_moving_an_end_step_by_step_does_the_work_of_its_reaction(tip):
    """Trapezoidal rule over 12 steps of 5 mm; halving them divides what is left by four."""
    left = []
    first = held("clamped", tip)
    for count in (12, 24):
        way = PLACE + np.linspace(0.0, 0.06, count + 1)[:, None] * (-1.0, 0.4, 0.2)
        stations = [replace(first, tip=replace(first.tip, position=(*p,))) for p in way.tolist()]
        found = Path(stations, elements=24).followed()
        forces = np.array([state.tip_reaction[:3] for state in found])
        # A guided end is shifted across its line only; along it, it goes where it likes.
        places = np.array([state.positions[-1] for state in found])
        work = np.sum(0.5 * (forces[1:] + forces[:-1]) * np.diff(places, axis=0))
        left.append(abs(found[-1].energy - found[0].energy - work))
        assert abs(work) > 1e-4
    assert left[1] < 1e-3 * abs(work)
    assert left[0] / left[1] == pytest.approx(4.0, rel=0.3)


@pytest.mark.parametrize(
    "shape",
    [
        Cylinder(0.03),
        Cone(0.03, 0.3),
        Profile((-0.1, -0.03, 0.03, 0.1), (0.03, 0.035, 0.025, 0.04)),
        Capsule(0.03, 0.02),
    ],
)
def test_lifted_and_turned_shape_does_the_work_of_its_forces(shape):
    """Into a rod between two clamps, without friction: energy is work.

    What is left is of the trapezoidal sum, between whose points nodes begin to touch.
    """
    step, turn = np.array((0.0, 4e-3, 0.02)), np.array((0.15, 0.1, 0.2))
    low = Obstacle.along(shape, (0.21, 0.003, -0.053), (0.3, 1.0, 0.1))
    problem = RodProblem(SPAN, RodLoad((0.0, 0.02, -0.5)), tip=Clamped((0.39, 0.0, 0.0)))
    ways = np.linspace(0.0, 1.0, 17)[:, None, None] * (step, turn)
    stations = [replace(problem, obstacles=(low.moved(*way.tolist()),)) for way in ways]
    found = Path(stations, elements=40).followed()
    pairs = [state.on_obstacle() for state in found]
    power = np.array([each.force @ step + each.torque @ turn for each in pairs])
    gained = found[-1].energy - found[0].energy
    assert np.abs([each.torque for each in pairs]).max() > 1e-6
    assert abs(gained + np.mean(0.5 * (power[1:] + power[:-1]))) < 0.01 * abs(gained)


@pytest.mark.parametrize(
    ("friction", "turn"),
    # Between stations things go straight: those that also turn about each other slip a little.
    [(0.4, (0.0, 0.0, 0.0)), (0.0, (0.3, -0.4, 0.8))],
)
def test_arm_that_carries_a_rod_and_a_bar_changes_nothing_in_it(friction, turn):
    """A bar presses on the slack rod's arch; without gravity, which would not turn along."""
    bar = Obstacle.along(Cylinder(0.03), (0.16, 0.0, 0.2), (0.0, 1.0, 0.0), friction)
    clear = replace(held("clamped", "clamped", RodLoad()), obstacles=(bar,))
    pushed = replace(clear, obstacles=(bar.moved((0.0, 0.0, -0.065)),))
    start = follow_contact([clear, pushed], elements=24).states[-1]
    assert start.normal_forces.sum() > 1e-3
    shift = np.array((0.4, -0.4, 0.2))
    stations = [
        moved(pushed, part * shift, Rotation.from_rotvec(part * np.array(turn)))
        for part in (0.25, 0.5, 1.0)
    ]
    last = follow_contact(stations, start=start).states[-1]
    expected = Rotation.from_rotvec(turn).apply(start.positions) + shift
    assert_allclose(last.positions, expected, atol=1e-8)
    assert last.energy == pytest.approx(start.energy, rel=1e-7)


@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize(
    "alone",
    [
        *(held("clamped", tip) for tip in KINDS),
        # Its way may fail at the first increment, before anything has touched.
        RodProblem(Rod(0.5, Section((1e-3,) * 3), 2e-3), tip=Clamped((0.45, 0.0, 0.0))),
    ],
)
def test_obstacle_far_away_changes_nothing(alone, friction):
    far = Obstacle(Plane(), (0.0, 0.0, -3.0), friction=friction)
    plain, state = (
        solve_contact(replace(alone, obstacles=obstacles), elements=40, throw=False)
        for obstacles in ((), (far,))
    )
    assert state.status is plain.status
    if plain.stable:
        assert not state.touching.any()
        for name in ("positions", "orientations", "moments", "forces", "base_reaction"):
            agree(getattr(state, name), getattr(plain, name), 1e-8)
        assert state.energy == pytest.approx(plain.energy, rel=1e-9)


@pytest.mark.parametrize("index", [3, 29, 38])
def test_path_with_friction_ends_where_it_did_however_it_is_asked(index):
    """The increments of a path follow from its states, not from passes that rounding changes.

    ``python -m benchmarks.rounding`` asks 200 of them; 29 and 38 ended 3e-6 L apart.
    """
    path, last = followed_otherwise(index, "perturbed")
    plain = states(f"random {index}")[-1]
    assert not path.events
    assert_allclose(last, plain.positions, rtol=0.0, atol=1e-7 * float(plain.arc_lengths[-1]))
