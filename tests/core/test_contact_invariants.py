# SPDX-License-Identifier: Apache-2.0
"""Every path of ``contact_paths``: its laws, recomputed; its images; the work of what moves.

What `residual` says is computed anew, from what a state shows. Its parts: forces in balance at each
node, moments likewise, and for each obstacle and node that may touch: no penetration (gap >= 0), no
pull (normal force >= 0), complementarity (their product is zero: twice 1e-10 of force scale times
L / N counts as the tolerance, 1e-8), Coulomb's cone (friction at most mu times the normal force,
and as much, against the slip, where it slides). Chords of elements, the last part, follow from the
shape: the mean of both ends' strains to second order.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from core.contact_cases import OUTER, grip
from core.contact_paths import (
    BETWEEN,
    HEAVY,
    HELD,
    LINE,
    PATHS,
    SHAPES,
    TURN,
    Array,
    Path,
    held,
    way_of_end,
    way_of_shape,
)
from scipy.spatial.transform import Rotation

from benchmarks.contact_paths import MIRROR, backwards, imbalance, mirrored, moved
from benchmarks.rounding import followed as followed_otherwise
from spiral_core import (
    Clamped,
    Cylinder,
    Free,
    Guided,
    Obstacle,
    Plane,
    RodLoad,
    RodProblem,
    RodState,
    Section,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

pytestmark = pytest.mark.long

ROTATION = Rotation.from_rotvec((0.4, -1.1, 2.0))
SHIFT = np.array((0.3, -0.2, 0.15))
LARGER = 10.0
TOUCHING = [name for name in PATHS if name not in BETWEEN]
# Without weight a node's balance has no error of the elements.
POINT_LOADED = ["pressed down", "pulled out, weightless"]


def followed(path: Path) -> tuple[RodState, ...]:
    """Return the states of a path on which nothing snaps."""
    found = follow_contact(
        path.stations, elements=path.elements, largest_increment=path.largest_increment
    )
    assert not found.events
    return found.states


@cache
def states(name: str) -> tuple[RodState, ...]:
    """Return the states of a named path."""
    return followed(PATHS[name])


def laws(state: RodState, problem: RodProblem) -> list[tuple[Array, Array, Array]]:
    """Return normals (n, 3), gaps (n,) and the pushes across the normals (n, 3) of obstacles."""
    found = []
    for obstacle, push in zip(problem.obstacles, state.contact_forces, strict=True):
        frame = Rotation.from_quat(obstacle.orientation)
        local = frame.inv().apply(state.positions - np.asarray(obstacle.position))
        distance, normal, _ = obstacle.shape.distance(local)
        normal = frame.apply(normal)
        pressed = np.sum(push * normal, axis=1)[:, None]
        found.append((normal, distance - problem.rod.radius, push - pressed * normal))
    return found


def parts(state: RodState, problem: RodProblem) -> dict[str, float]:
    """Return the residual's parts, in its units."""
    rod, load, count = problem.rod, problem.load, len(state.positions) - 1
    bending = rod.section.matrix[1, 1]
    loads = [load.tip_force, *(each.force for each in problem.point_loads)]
    inside = 0.1 * np.linalg.norm(state.forces, axis=1).max()
    force_scale = max(bending / rod.length**2, np.linalg.norm(loads, axis=1).sum(), inside)
    moment_scale = max(bending / rod.length, force_scale * rod.length / count)
    lever = rod.radius if rod.friction_radius is None else rod.friction_radius
    forces, moments = np.zeros((2, *state.positions.shape))
    forces[-1], moments[-1] = load.tip_force, load.tip_moment
    for each in problem.point_loads:
        forces[np.argmin(np.abs(state.arc_lengths - each.at))] += each.force
    worst = dict.fromkeys(("gap", "pull", "apart", "cone"), 0.0)
    for j, (normal, gap, rubbed) in enumerate(laws(state, problem)):
        push, friction = state.contact_forces[j], problem.obstacles[j].friction
        forces += push
        moments += np.cross(-lever * normal, push)
        pressed, size = np.sum(push * normal, axis=1)[1:], np.linalg.norm(rubbed, axis=1)[1:]
        slides = (state.touching[j] & ~state.sticking[j])[1:]
        cone = size - friction * pressed
        cone = np.maximum(cone, np.where(slides, np.abs(cone), 0.0))
        worst["gap"] = max(worst["gap"], -gap[1:].min() / (0.1 * rod.length))
        worst["pull"] = max(worst["pull"], -pressed.min() / force_scale)
        both = np.abs(pressed * gap[1:]).max() / (force_scale * rod.length / count)
        worst["apart"] = max(worst["apart"], both / 2e-10 * 1e-8)
        worst["cone"] = max(worst["cone"], cone.max() / force_scale)
    forces[0] += state.base_reaction[:3]
    moments[0] += state.base_reaction[3:]
    beyond = np.cumsum(forces[::-1], axis=0)[::-1]  # all at this node and farther out
    inner = np.vstack((beyond[1:], np.zeros(3)))
    # forces at a node are the mean of both sides
    mean = 0.5 * (beyond + inner)
    mean[0], mean[-1] = inner[0], beyond[-1]
    chords = np.diff(state.positions, axis=0)
    # the moment just after a node is that of all beyond, about it
    after = np.zeros_like(moments)
    for i in range(count - 1, -1, -1):
        after[i] = after[i + 1] + moments[i + 1] + np.cross(chords[i], inner[i])
    shown = Rotation.from_quat(state.orientations).apply(state.moments)
    return worst | {
        "forces": np.abs(state.forces - mean).max() / force_scale,
        "moments": np.abs(shown - after)[:-1].max() / moment_scale,
        "base": np.abs(after[0] + moments[0]).max() / moment_scale,
    }


@pytest.mark.parametrize("name", POINT_LOADED)
def test_residual_is_that_of_its_parts(name: str) -> None:
    stations = PATHS[name].stations
    for state, problem in list(zip(states(name), stations, strict=True))[-2:]:
        assert state.residual < 1e-8
        assert (state.touching.sum(axis=1) > 0).all()
        assert (state.touching & ~state.sticking).any()
        for part, value in parts(state, problem).items():
            assert value < max(10.0 * state.residual, 1e-9), part
    assert any((state.touching & state.sticking).any() for state in states(name))


@pytest.mark.parametrize("part", ["forces", "moments", "gap", "apart", "cone"])
def test_parts_notice_what_is_off(part: str) -> None:
    """A state changed by a ten-millionth or a millionth of itself fails."""
    state, asked = states("pressed down")[-1], PATHS["pressed down"].stations[-1]
    pushes = state.contact_forces.copy()
    node = int(np.argmax(np.where(state.sticking[2], 0.0, state.normal_forces[2])))
    pushes[2, node] *= 1.0 + 1e-5
    pushes[2, node, 1] *= 1.01
    changes = {
        "gap": {"positions": state.positions - np.array((0.0, 0.0, 1e-7))},
        "apart": {"positions": state.positions + np.array((0.0, 0.0, 1e-7))},
        "moments": {"moments": state.moments * (1.0 + 1e-5)},
    }
    changed = replace(state, **changes.get(part, {"contact_forces": pushes}))
    assert parts(changed, asked)[part] > 1e-7


@pytest.mark.parametrize("name", PATHS)
def test_state_is_in_balance_and_nothing_passes_through(name: str) -> None:
    state, problem = states(name)[-1], PATHS[name].stations[-1]
    assert state.stable
    weight = np.linalg.norm(problem.load.distributed) * problem.rod.length
    scale = max(weight, state.normal_forces.sum())
    force, moment = imbalance(problem, state)
    assert force < 1e-6 * scale
    # The sum for the weight's moment is of fourth order; the solve's is not at stake.
    assert moment < 4e-6 * scale * problem.rod.length
    assert state.gaps[:, 1:].min(initial=1.0) > -1e-3 * problem.rod.radius
    for (_, gap, rubbed), push, obstacle in zip(
        laws(state, problem), state.normal_forces, problem.obstacles, strict=True
    ):
        np.testing.assert_allclose(state.gaps[problem.obstacles.index(obstacle)], gap, atol=1e-9)
        assert push.min() >= -1e-9 * scale
        assert (np.linalg.norm(rubbed, axis=1) - obstacle.friction * push).max() < 1e-6 * scale


@pytest.mark.parametrize("name", TOUCHING)
def test_friction_is_against_the_slip(name: str) -> None:
    """The way of the surface's material point from the state before, along the obstacle."""
    before, state = states(name)[-2:]
    old, new = PATHS[name].stations[-2:]
    seen, radius = 0, new.rod.radius
    turn = Rotation.from_quat(state.orientations) * Rotation.from_quat(before.orientations).inv()
    pairs = zip(laws(before, old), laws(state, new), old.obstacles, new.obstacles, strict=True)
    for j, ((was, _, _), (now, _, push), there, here) in enumerate(pairs):
        assert here.orientation == there.orientation
        way = state.positions - before.positions + radius * (was - turn.apply(was))
        way -= np.subtract(here.position, there.position)
        way -= now * np.sum(way * now, axis=1)[:, None]
        sliding = state.touching[j] & ~state.sticking[j] & before.touching[j]
        for i in np.flatnonzero(sliding & (np.linalg.norm(way, axis=1) > 1e-9)):
            size = np.linalg.norm(push[i]) * np.linalg.norm(way[i])
            # On a long way its direction changes.
            assert push[i] @ way[i] < -(0.999 if name == "pressed down" else 0.5) * size
            seen += 1
    assert seen or name.startswith("random")  # what moves last there may touch nothing


@pytest.mark.parametrize("name", PATHS)
def test_moved_problem_has_the_moved_answer(name: str) -> None:
    plain, path = states(name)[-1], PATHS[name]
    problem = path.stations[-1]
    stations = [moved(station, SHIFT, ROTATION) for station in path.stations]
    state = followed(replace(path, stations=stations))[-1]
    length = problem.rod.length
    expected = ROTATION.apply(plain.positions) + SHIFT
    np.testing.assert_allclose(state.positions, expected, atol=1e-7 * length)
    scale = np.abs(plain.contact_forces).max(initial=1e-12)
    for got, was in zip(state.contact_forces, plain.contact_forces, strict=True):
        np.testing.assert_allclose(got, ROTATION.apply(was), atol=1e-5 * scale)
    np.testing.assert_allclose(
        state.moments, plain.moments, atol=1e-6 * np.abs(plain.moments).max()
    )
    if not name.startswith("random"):  # where a node has stopped, rounding decides which it is
        np.testing.assert_array_equal(state.sticking, plain.sticking)
    # The potential energy has the work of the loads over the shift in it.
    forces = [p.force for p in stations[-1].point_loads] + [stations[-1].load.tip_force]
    lifted = np.sum(forces, axis=0) + np.multiply(stations[-1].load.distributed, length)
    assert state.energy == pytest.approx(plain.energy - lifted @ SHIFT, rel=1e-6)


@pytest.mark.parametrize("name", PATHS)
def test_mirrored_problem_has_the_mirrored_answer(name: str) -> None:
    plain, path = states(name)[-1], PATHS[name]
    state = followed(replace(path, stations=[mirrored(each) for each in path.stations]))[-1]
    length = path.stations[-1].rod.length
    np.testing.assert_allclose(state.positions, plain.positions @ MIRROR, atol=1e-7 * length)
    scale = np.abs(plain.contact_forces).max(initial=1e-12)
    np.testing.assert_allclose(
        state.contact_forces, plain.contact_forces @ MIRROR, atol=1e-5 * scale
    )
    turned = -plain.moments @ MIRROR
    np.testing.assert_allclose(state.moments, turned, atol=1e-6 * np.abs(turned).max())
    assert state.base_reaction[3:] == pytest.approx(
        -plain.base_reaction[3:] @ MIRROR, abs=1e-6 * np.abs(turned).max()
    )


def grown(problem: RodProblem) -> RodProblem:
    """Return the larger problem: lengths times 10, EI times 1e4, and forces times 100."""
    a = LARGER

    def times(factor: float, values: object) -> tuple[float, ...]:
        return tuple((factor * np.asarray(values)).tolist())

    def larger(thing: object, **factors: float) -> object:
        there = {n: f for n, f in factors.items() if getattr(thing, n, None) is not None}
        changed = {n: f * np.asarray(getattr(thing, n)) for n, f in there.items()}
        return replace(
            thing, **{n: tuple(v.tolist()) if v.ndim else float(v) for n, v in changed.items()}
        )

    rod, section = problem.rod, problem.rod.section
    units = np.array((a**2, a**2, a**2, a, a, a))[: len(section.stiffness)]
    full = np.asarray(section.stiffness)
    stiffness = np.outer(units, units) * full if full.ndim == 2 else units**2 * full
    forces = {"force": a**2, "moment": a**3}
    return replace(
        problem,
        rod=replace(
            larger(rod, length=a, radius=a, rest_strain=1.0 / a),
            section=Section(stiffness, a**2 * section.extension, a**2 * section.shear),
        ),
        load=larger(problem.load, distributed=a, tip_force=a**2, tip_moment=a**3),
        base=larger(problem.base, position=a),
        tip=larger(problem.tip, position=a),
        obstacles=tuple(
            replace(larger(each, position=a), shape=larger(each.shape, radius=a, length=a))
            for each in problem.obstacles
        ),
        point_loads=tuple(larger(each, at=a, **forces) for each in problem.point_loads),
    )


@pytest.mark.parametrize("name", PATHS)
def test_larger_rod_of_the_same_proportions_has_the_same_shape(name: str) -> None:
    """Slips and tolerances scale along."""
    plain, path = states(name)[-1], PATHS[name]
    state = followed(replace(path, stations=[grown(each) for each in path.stations]))[-1]
    length = LARGER * path.stations[-1].rod.length
    np.testing.assert_allclose(state.positions, LARGER * plain.positions, atol=1e-7 * length)
    forces = LARGER**2 * plain.normal_forces
    np.testing.assert_allclose(
        state.normal_forces, forces, atol=1e-5 * np.abs(forces).max(initial=1e-12)
    )
    assert state.energy == pytest.approx(LARGER**3 * plain.energy, rel=1e-6)


@pytest.mark.parametrize("name", BETWEEN)
def test_rod_read_from_its_other_end_is_the_same_rod(name: str) -> None:
    one, other = states(name)[-1], solve_contact(backwards(BETWEEN[name]), elements=48)
    np.testing.assert_allclose(other.positions[::-1], one.positions, atol=1e-9)
    np.testing.assert_allclose(other.base_reaction, one.tip_reaction, atol=1e-9)
    assert other.energy == pytest.approx(one.energy, rel=1e-9)


@pytest.mark.parametrize("name", BETWEEN)
def test_end_is_where_it_is_held_and_bears_only_what_it_holds(name: str) -> None:
    problem, state = BETWEEN[name], states(name)[-1]
    weight = np.linalg.norm(HEAVY.distributed) * HELD.length
    for end, node, reaction in (
        (problem.base, 0, state.base_reaction),
        (problem.tip, -1, state.tip_reaction),
    ):
        off = state.positions[node] - np.asarray(getattr(end, "position", state.positions[node]))
        assert np.linalg.norm(np.cross(off, LINE)) < 1e-12
        assert isinstance(end, Guided) or np.linalg.norm(off) < 1e-12
        if getattr(end, "orientation", None) is None:
            assert np.linalg.norm(reaction[3:]) < 1e-8 * weight * HELD.length
        else:
            assert state.orientations[node] == pytest.approx(end.orientation, abs=1e-12)
            assert np.linalg.norm(reaction[3:]) > 1e-4 * weight * HELD.length
        if isinstance(end, Guided):
            assert np.linalg.norm(off) > 1e-4  # it has slid along
            assert abs(reaction[:3] @ LINE) < 1e-8 * weight
        if isinstance(end, Free):
            assert np.linalg.norm(reaction) < 1e-8 * weight


@pytest.mark.parametrize("base", ["clamped", "pinned"])
@pytest.mark.parametrize("tip", ["clamped", "pinned", "guided", "guided, not turning"])
def test_moving_an_end_step_by_step_does_the_work_of_its_reaction(base: str, tip: str) -> None:
    """Trapezoidal rule over 12 steps of 5 mm; halving them divides what is left by four."""
    left = []
    for count in (12, 24):
        found = followed(Path(way_of_end(base, tip, count), elements=24))
        forces = np.array([state.tip_reaction[:3] for state in found])
        # A guided end is shifted across its line only; along it, it goes where it likes.
        places = np.array([state.positions[-1] for state in found])
        work = np.sum(0.5 * (forces[1:] + forces[:-1]) * np.diff(places, axis=0))
        left.append(abs(found[-1].energy - found[0].energy - work))
        assert abs(work) > 1e-4
    assert left[1] < 1e-3 * abs(work)
    assert left[0] / left[1] == pytest.approx(4.0, rel=0.3)


@pytest.mark.parametrize("name", SHAPES)
def test_moved_and_turned_shape_does_the_work_of_its_forces(name: str) -> None:
    """Without friction energy is work.

    What is left is of the trapezoidal sum, between whose points nodes begin to touch.
    """
    left = []
    for count in (8, 16):
        stations = way_of_shape(name, count)
        found = followed(Path(stations, elements=40))
        turns = [Rotation.from_quat(each.obstacles[0].orientation) for each in stations[:2]]
        turn = (turns[1] * turns[0].inv()).as_rotvec()
        step = np.subtract(stations[1].obstacles[0].position, stations[0].obstacles[0].position)
        pairs = [state.on_obstacle() for state in found]
        power = np.array([each.force @ step + each.torque @ turn for each in pairs])
        gained = found[-1].energy - found[0].energy
        left.append(abs(gained + np.sum(0.5 * (power[1:] + power[:-1]))))
        assert np.abs([each.torque for each in pairs]).max() > 1e-6 or name == "sphere"
        assert found[-1].contact_lengths[0] > 0.0
    assert max(left) < 0.03 * abs(gained)
    assert left[1] < 0.01 * abs(gained)


@pytest.mark.parametrize(
    ("friction", "turn"),
    # Between stations things go straight: those that also turn about each other slip a little.
    [(0.4, (0.0, 0.0, 0.0)), (0.0, (0.3, -0.4, 0.8))],
)
def test_arm_that_carries_a_rod_and_a_bar_changes_nothing_in_it(
    friction: float, turn: tuple[float, ...]
) -> None:
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
    np.testing.assert_allclose(last.positions, expected, atol=1e-8)
    assert last.energy == pytest.approx(start.energy, rel=1e-7)


@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize("tip", [Free(), Guided((0.3, 0.0, 0.0)), Clamped((0.33, 0, 0), TURN)])
def test_obstacles_far_away_change_nothing(friction: float, tip: object) -> None:
    """To 1e-8: shape, forces, reactions and energy are those without them."""
    alone = RodProblem(HELD, RodLoad((0.0, 0.05, -0.3)), tip=tip)
    far = (
        Obstacle.along(Cylinder(0.03), (0.0, 0.0, 3.0), (0.0, 1.0, 0.0), friction),
        Obstacle(Plane(), (0.0, 0.0, -2.0), friction=friction),
    )
    plain = solve_contact(alone, elements=40)
    state = solve_contact(replace(alone, obstacles=far), elements=40)
    assert not state.touching.any()
    assert not state.contact_forces.any()
    for name in ("positions", "orientations", "moments", "forces", "base_reaction"):
        expected = getattr(plain, name)
        np.testing.assert_allclose(
            getattr(state, name), expected, atol=1e-8 * np.abs(expected).max()
        )
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


@pytest.mark.parametrize("index", [3, 29, 38])
def test_path_with_friction_ends_where_it_did_however_it_is_asked(index: int) -> None:
    """The increments of a path follow from its states, not from passes that rounding changes.

    ``python -m benchmarks.rounding`` asks 200 of them; 29 and 38 ended 3e-6 L apart.
    """
    path, last = followed_otherwise(index, "perturbed")
    plain = states(f"random {index}")[-1]
    assert not path.events
    np.testing.assert_allclose(
        last, plain.positions, rtol=0.0, atol=1e-7 * float(plain.arc_lengths[-1])
    )
