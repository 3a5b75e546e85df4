# SPDX-License-Identifier: Apache-2.0
"""Where a rod touches itself: the distance between elements, and what passes on the way.

Unloaded rods have the shape that their rest strain gives them: any curve can be asked for.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.contact_paths import mirrored, moved
from spiral_core import Clamped, Rod, RodProblem, RodState, RodStatus, Section
from spiral_core.rod.contact.solve import follow_contact, solve_contact

pytestmark = pytest.mark.long

Array = np.ndarray
RADIUS = 0.01
SECTION = Section((1e-3, 1e-3, 1e-3))


def brute_force(state: RodState) -> float:
    """Return the least distance of places on elements apart: all pairs of 21 points on each."""
    curve, sites = state.positions, state.arc_lengths
    at = np.linspace(0.0, 1.0, 21)[:, None]
    points = curve[:-1, None] + at * np.diff(curve, axis=0)[:, None]
    nodes = np.linalg.norm(curve[:, None] - curve[None], axis=2)
    least = nodes[np.abs(sites[:, None] - sites) > np.pi * RADIUS].min(initial=np.inf)
    for i in range(len(points)):
        apart = np.nonzero(sites[:-1] - sites[i + 1] > np.pi * RADIUS)[0]
        if apart.size:
            away = np.linalg.norm(points[i][:, None, None] - points[apart], axis=-1)
            least = min(least, float(away.min()))
    return least


def coiled(turns: float, pitch: float, seed: int) -> RodProblem:
    """Return a coil of 5 cm radius whose rest strain wavers."""
    length = 2.0 * np.pi * turns * math.hypot(0.05, pitch / (2.0 * np.pi))
    twist, bend = np.array((pitch / (2.0 * np.pi), 0.05)) / (0.05**2 + (pitch / 2.0 / np.pi) ** 2)
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, 3)

    def strain(s: Array) -> Array:
        waves = np.sin(2.0 * np.pi * np.outer(s, (7.0, 5.0, 3.0)) + phase)
        return (twist, 0.0, bend) + 0.3 * waves

    return RodProblem(Rod(length, SECTION, RADIUS, rest_strain=strain))


@pytest.mark.parametrize("elements", [40, 60, 121])
def test_clearance_is_that_of_all_places_on_elements_apart(elements: int) -> None:
    """Elements of 0.8 to 4 radii.

    Points miss the nearest place by at most half of their distance h / 20 on both: its square
    adds at most h^2 / 800 to that of the least distance. What is far counts as two radii.
    """
    touching = clear = 0
    for seed, turns in enumerate((0.3, 2.0, *np.linspace(3.0, 4.5, 8))):
        state = solve_contact(
            coiled(turns, 0.024 - 0.002 * (seed % 4), seed), elements=elements, throw=False
        )
        expected, found = brute_force(state), state.self_clearance + 2.0 * RADIUS
        assert found <= max(expected, 0.0) + 1e-12
        missed = np.diff(state.arc_lengths).max() ** 2 / 800.0
        assert found >= min(math.sqrt(max(0.0, expected**2 - missed)), 4.0 * RADIUS)
        assert (state.status is RodStatus.SELF_CONTACT) is (state.self_clearance < 0.0)
        touching += state.self_clearance < 0.0
        clear += 0.0 < state.self_clearance < 2.0 * RADIUS
    assert touching
    assert clear


@pytest.mark.parametrize("h", [0.05, 0.5, 1.0, 1.6, 2.5, 5.0, 40.0])
@pytest.mark.parametrize("bend", [0.0, 0.2])
def test_neighbors_do_not_touch(h: float, bend: float) -> None:
    """Straight, and in an arc of at least two radii: elements that share a node, and the next.

    What is far counts as two radii; a rod shorter than pi radii cannot touch itself.
    """
    length = 11 * h * RADIUS
    bent = (0.0, 0.0, min(bend, h / 2.0) / (h * RADIUS))
    rod = Rod(length, SECTION, RADIUS, rest_strain=bent)
    state = solve_contact(RodProblem(rod), elements=11)
    assert state.self_clearance > 0.0
    if length < np.pi * RADIUS:
        assert state.self_clearance == math.inf
    elif bend == 0.0:
        expected = min(brute_force(state), 4.0 * RADIUS) - 2.0 * RADIUS
        assert state.self_clearance == pytest.approx(expected, abs=1e-12)
    assert solve_contact(RodProblem(replace(rod, radius=0.0)), elements=11).self_clearance == (
        math.inf
    )


def hairpin() -> RodProblem:
    """Return two straight legs at 2.1 radii, joined by a bend of two and a half."""
    bend = np.pi * 1.05 * RADIUS
    legs = 0.15

    def strain(s: Array) -> Array:
        inner = (s > legs) & (s < legs + bend)
        return np.column_stack((0.0 * s, 0.0 * s, np.where(inner, np.pi / bend, 0.0)))

    rod = Rod(2.0 * legs + bend, SECTION, RADIUS, rest_strain=strain, breaks=(legs, legs + bend))
    return RodProblem(rod)


@pytest.mark.parametrize("elements", [60, 91])
def test_clearance_is_of_the_shape_not_of_its_pose_or_direction(elements: int) -> None:
    """Parallel legs are as far apart as they are, whether their nodes are opposite or not."""
    problem = hairpin()
    state = solve_contact(problem, elements=elements)
    assert state.self_clearance == pytest.approx(0.1 * RADIUS, abs=5e-6)
    turn = Rotation.from_rotvec((0.3, -1.0, 2.0))
    base = Clamped((1.0, 2.0, -3.0), tuple(turn.as_quat().tolist()))
    there = solve_contact(replace(problem, base=base), elements=elements)
    assert there.self_clearance == pytest.approx(state.self_clearance, abs=1e-12)
    coil = RodProblem(Rod(1.0, SECTION, RADIUS, rest_strain=(1.5, 0.0, 20.0)))
    found = solve_contact(coil, elements=elements).self_clearance
    assert 0.0 < found < 2.0 * RADIUS
    image = solve_contact(mirrored(coil), elements=elements).self_clearance
    assert image == pytest.approx(found, abs=1e-12)


def test_coil_that_turns_as_a_whole_does_not_cross_itself() -> None:
    """Nodes move straight, which brings turns that nearly touch nearer by a tenth."""
    coil = RodProblem(Rod(1.0, SECTION, RADIUS, rest_strain=(2.04, 0.0, 25.0)))
    start = solve_contact(coil, elements=160)
    assert 0.0 < start.self_clearance < 0.1 * RADIUS
    for axis in np.eye(3):
        turned = moved(coil, np.zeros(3), Rotation.from_rotvec(0.9 * axis))
        path = follow_contact([coil, turned], start=start)
        assert path.self_contact is None
        assert path.states[-1].self_clearance == pytest.approx(start.self_clearance, abs=1e-9)
