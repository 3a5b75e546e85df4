# SPDX-License-Identifier: Apache-2.0
"""Every path of ``contact_paths``: its laws, recomputed; its images; the work of what moves."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from core.contact_cases import bar, floor
from core.contact_paths import (
    BETWEEN,
    HEAVY,
    HELD,
    LINE,
    PATHS,
    PLACE,
    SPAN,
    Path,
    agree,
    held,
)
from core.recorded import recorded
from numpy.linalg import norm
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.contact_paths import MIRROR, backwards, imbalance, mirrored, moved
from benchmarks.rounding import followed as followed_otherwise
from spiral_core import (
    Capsule,
    Clamped,
    Free,
    Guided,
    Obstacle,
    Profile,
    Rod,
    RodLoad,
    RodProblem,
    RodState,
    Section,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

pytestmark = pytest.mark.long

Array = NDArray[np.float64]


@cache
def states(name):
    """Return the states of a named path."""
    return PATHS[name].followed()


def moments_of(state):
    """Return the moments inside (n, 3), and the base's."""
    turned = Rotation.from_quat(state.orientations).apply(state.moments)
    return np.vstack((turned, state.base_reaction[3:]))


@pytest.mark.parametrize("name", PATHS)
def test_states_are_in_balance_and_keep_the_laws_of_contact(name):
    """No penetration, no pull, no force at a distance; friction within Coulomb's cone, or on it.

    Recomputed, in the units of the residual, they are off by no more than it says.
    """
    last = states(name)[-1]
    found = last.tip_position, last.base_reaction, last.contact_forces, last.discretization_error
    recorded(f"contact/{name}", [*found, last.self_clearance, last.lengths_within(5e-3)])
    for state, problem in zip(states(name), PATHS[name].stations, strict=True):
        rod, load, count = problem.rod, problem.load, len(state.positions) - 1
        assert state.stable
        assert state.residual < 1e-8
        loads = [load.tip_force, *(each.force for each in problem.point_loads)]
        bending, inside = rod.section.matrix[1, 1], 0.1 * norm(state.forces, axis=1).max()
        force_scale = max(bending / rod.length**2, norm(loads, axis=1).sum(), inside)
        moment_scale = max(bending / rod.length, force_scale * rod.length / count)
        lever = rod.radius if rod.friction_radius is None else rod.friction_radius
        forces, moments = np.zeros((2, count + 1, 3))
        forces[-1], moments[-1] = load.tip_force, load.tip_moment
        for each in problem.point_loads:
            node = np.argmin(np.abs(state.arc_lengths - each.at))
            forces[node] += each.force
            moments[node] += each.moment
        off = []
        for j, obstacle in enumerate(problem.obstacles):
            push, frame = state.contact_forces[j], Rotation.from_quat(obstacle.orientation)
            local = frame.inv().apply(state.positions - obstacle.position)
            distance, normal, _ = obstacle.shape.distance(local)
            normal, gap = frame.apply(normal), distance - rod.radius
            pressed = np.sum(push * normal, axis=1)
            assert_allclose(state.gaps[j], gap, atol=1e-9)
            agree(state.normal_forces[j], pressed, 1e-9)
            cone = norm(push - pressed[:, None] * normal, axis=1) - obstacle.friction * pressed
            slides = state.touching[j] & ~state.sticking[j]
            cone[slides] = np.abs(cone[slides])
            apart = 50.0 * np.abs(pressed * gap) / rod.length * count
            off += [-gap[1:] / (0.1 * rod.length)]
            off += [part[1:] / force_scale for part in (apart, -pressed, cone)]
            forces += push
            moments += np.cross(-lever * normal, push)
        weight = norm(load.distributed) * rod.length
        allowed = (30.0 if weight else 10.0) * max(state.residual, 1e-10)
        assert np.max(off, initial=0.0) < allowed
        scale = max(weight, state.normal_forces.sum())
        # The sum for the weight's moment is of fourth order; the solve's is not at stake.
        force, moment = imbalance(problem, state)
        assert max(force, moment / (4.0 * rod.length)) <= 1e-6 * scale
        if weight or not problem.obstacles:
            continue
        # Without weight a node's balance has no error of the elements. Forces at a node are the
        # mean of both sides; the moment just after it is that of all beyond, about it.
        forces[0] += state.base_reaction[:3]
        moments[0] += state.base_reaction[3:]
        after = np.tri(count + 1).T  # sums of each row and of all after it
        beyond = after @ forces
        inner = np.vstack((beyond[1:], np.zeros(3)))
        mean = 0.5 * (beyond + inner)
        mean[0], mean[-1] = inner[0], beyond[-1]
        levers = np.cross(np.diff(state.positions, axis=0), inner[:-1])
        turned = after[1:, 1:] @ (moments[1:] + levers)
        assert_allclose(state.forces, mean, rtol=0.0, atol=allowed * force_scale)
        bent = moments_of(state)[:-2] - turned
        assert np.abs(np.vstack((bent, turned[0] + moments[0]))).max() < allowed * moment_scale


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


def beside(problem):
    """Return the problem with an obstacle far away."""
    return replace(problem, obstacles=(*problem.obstacles, floor(-3.0, 0.4)))


# The image of a problem; and by what its answer is multiplied, turned or flipped, and shifted.
IMAGES = {
    "moved": (lambda p: moved(p, SHIFT, ROTATION), 1.0, ROTATION.as_matrix(), SHIFT),
    "mirrored": (mirrored, 1.0, MIRROR, np.zeros(3)),
    "larger": (larger, LARGER, np.eye(3), np.zeros(3)),
    "beside": (beside, 1.0, np.eye(3), np.zeros(3)),
}


@pytest.mark.parametrize("image", IMAGES)
@pytest.mark.parametrize("name", PATHS)
def test_image_of_a_problem_has_the_image_of_its_answer(name, image):
    """Slips and tolerances scale along."""
    asked, size, turn, shift = IMAGES[image]
    plain, path = states(name)[-1], PATHS[name]
    state = replace(path, stations=[asked(each) for each in path.stations]).followed()[-1]
    forces, moments = size**2 * turn.T, size**3 * np.linalg.det(turn) * turn.T
    near = 1e-8 if image == "beside" else 1e-7
    agree(state.positions, size * plain.positions @ turn.T + shift, near)
    own = len(plain.contact_forces)
    agree(state.contact_forces[:own], plain.contact_forces @ forces, 1e-5)
    assert not state.touching[own:].any()
    agree(moments_of(state), moments_of(plain) @ moments)
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
    for end, node in ((problem.base, 0), (problem.tip, -1)):
        force, moment = np.split((state.base_reaction, state.tip_reaction)[node], 2)
        off = state.positions[node] - getattr(end, "position", state.positions[node])
        freely = {Free: np.eye(3), Guided: np.outer(LINE, LINE)}.get(type(end), np.zeros((3, 3)))
        assert norm(freely @ force) < 1e-8 * weight
        assert norm(off - freely @ off) < 1e-12
        assert type(end) is not Guided or norm(off) > 1e-4  # it has slid along
        if (held := getattr(end, "orientation", None)) is None:
            assert norm(moment) < 1e-8 * weight * HELD.length
        else:
            assert state.orientations[node] == pytest.approx(held, abs=1e-12)


@pytest.mark.parametrize("tip", ["clamped", "pinned", "guided", "guided, not turning"])
def test_moving_an_end_step_by_step_does_the_work_of_its_reaction(tip):
    """Trapezoidal rule over steps of 2.5 mm."""
    first = held("clamped", tip)
    way = PLACE + np.linspace(0.0, 0.06, 25)[:, None] * (-1.0, 0.4, 0.2)
    stations = [replace(first, tip=replace(first.tip, position=(*p,))) for p in way.tolist()]
    found = Path(stations, elements=24).followed()
    # A guided end is shifted across its line only; along it, it goes where it likes.
    work = sum(
        0.5 * (a.tip_reaction + b.tip_reaction)[:3] @ (b.tip_position - a.tip_position)
        for a, b in pairwise(found)
    )
    assert found[-1].energy - found[0].energy == pytest.approx(work, rel=1e-3)
    assert abs(work) > 1e-4


@pytest.mark.parametrize(
    "shape", [Capsule(0.03, 0.02), Profile((-0.1, -0.03, 0.03, 0.1), (0.03, 0.035, 0.025, 0.04))]
)
def test_lifted_and_turned_shape_does_the_work_of_its_forces(shape):
    """Into a rod between two clamps, without friction: energy is work.

    What is left is of the trapezoidal sum, between whose points nodes begin to touch.
    """
    move = np.array(((0.0, 4e-3, 0.02), (0.15, 0.1, 0.2)))
    low = Obstacle.along(shape, (0.21, 0.003, -0.053), (0.3, 1.0, 0.1))
    load = RodLoad((0.0, 0.02, -0.5))
    stations = [
        RodProblem(SPAN, load, tip=Clamped((0.39, 0.0, 0.0)), obstacles=(low.moved(*part * move),))
        for part in np.linspace(0.0, 1.0, 17)
    ]
    found = Path(stations, elements=40).followed()
    pairs = [(on.force, on.torque) for on in map(RodState.on_obstacle, found)]
    power = np.sum(pairs * move, axis=(1, 2))
    gained = found[-1].energy - found[0].energy
    assert np.abs(pairs)[:, 1].max() > 1e-6
    assert -np.mean(0.5 * (power[1:] + power[:-1])) == pytest.approx(gained, rel=0.01)


@pytest.mark.parametrize(
    ("friction", "turn"),
    # Between stations things go straight: those that also turn about each other slip a little.
    [(0.4, (0.0, 0.0, 0.0)), (0.0, (0.3, -0.4, 0.8))],
)
def test_arm_that_carries_a_rod_and_a_bar_changes_nothing_in_it(friction, turn):
    """A bar presses on the slack rod's arch; without gravity, which would not turn along."""
    under = bar(0.03, 0.16, -0.2, friction)
    clear = replace(held("clamped", "clamped", RodLoad()), obstacles=(under,))
    pushed = replace(clear, obstacles=(under.moved((0.0, 0.0, 0.1)),))
    start = follow_contact([clear, pushed], elements=24).states[-1]
    assert start.normal_forces.sum() > 1e-3
    turned = [Rotation.from_rotvec(np.multiply(part, turn)) for part in (0.25, 0.5, 1.0)]
    shift = np.array((0.4, -0.4, 0.2))
    ways = [moved(pushed, p * shift, q) for p, q in zip((0.25, 0.5, 1.0), turned, strict=True)]
    last = follow_contact(ways, start=start).states[-1]
    assert_allclose(last.positions, turned[-1].apply(start.positions) + shift, atol=1e-8)
    assert last.energy == pytest.approx(start.energy, rel=1e-7)


def test_obstacle_far_away_changes_no_status():
    """A way may fail at its first increment, before anything has touched."""
    pressed = RodProblem(Rod(0.5, Section((1e-3,) * 3), 2e-3), tip=Clamped((0.45, 0.0, 0.0)))
    alone, state = (solve_contact(p, elements=40, throw=False) for p in (pressed, beside(pressed)))
    assert state.status is alone.status


@pytest.mark.parametrize("index", [3, 29, 38])
def test_path_with_friction_ends_where_it_did_however_it_is_asked(index):
    """The increments of a path follow from its states, not from passes that rounding changes.

    ``python -m benchmarks.rounding`` asks 200 of them; 29 and 38 ended 3e-6 L apart.
    """
    path, last = followed_otherwise(index, "perturbed")
    plain = states(f"random {index}")[-1]
    assert not path.events
    assert_allclose(last, plain.positions, rtol=0.0, atol=1e-7 * float(plain.arc_lengths[-1]))
