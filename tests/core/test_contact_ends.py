# SPDX-License-Identifier: Apache-2.0
"""Every kind of end, at either end of the rod: what it holds, what it leaves free, how it moves."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.contact_paths import backwards, imbalance, moved
from spiral_core import (
    Clamped,
    Cylinder,
    Free,
    Guided,
    Obstacle,
    Pinned,
    Rod,
    RodLoad,
    RodProblem,
    Section,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

LENGTH, WEIGHT = 0.4, (0.05, 0.02, -0.4)
# Every coupling of twist and both bendings, and it stretches.
SECTION = Section(
    ((1.7e-4, 2e-5, 1e-5), (2e-5, 2.7e-4, 3e-5), (1e-5, 3e-5, 3.4e-4)), extension=30.0, shear=10.0
)
ROD = Rod(LENGTH, SECTION, 3e-3, rest_strain=(3.0, -1.0, 4.0))
LINE = (0.6, 0.0, 0.8)
KINDS = {
    "clamped": Clamped,
    "pinned": lambda place, _: Pinned(place),
    "guided": lambda place, _: Guided(place, LINE),
    "guided, not turning": lambda place, turn: Guided(place, LINE, turn),
    "free": lambda _, __: Free(),
}
FIXING = {"clamped", "pinned"}
# What one end must add to the other so that nothing is left to fall or to spin.
PAIRS = [
    (base, tip)
    for base, tip in product(KINDS, KINDS)
    if {base, tip} & FIXING and {base, tip} != {"pinned", "free"}
]
PLACE, TURN = (0.33, 0.02, 0.01), (0.0, 0.0, math.sin(0.15), math.cos(0.15))


def held(base: str, tip: str) -> RodProblem:
    """Return a rod that hangs between two ends of these kinds."""
    return RodProblem(
        ROD,
        RodLoad(WEIGHT),
        KINDS[base]((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
        KINDS[tip](PLACE, TURN),
    )


@pytest.mark.parametrize(("base", "tip"), PAIRS)
def test_rod_read_from_its_other_end_is_the_same_rod(base: str, tip: str) -> None:
    problem = held(base, tip)
    one = solve_contact(problem, elements=24)
    other = solve_contact(backwards(problem), elements=24)
    np.testing.assert_allclose(other.positions[::-1], one.positions, atol=1e-9)
    np.testing.assert_allclose(other.base_reaction, one.tip_reaction, atol=1e-9)
    assert other.energy == pytest.approx(one.energy, rel=1e-9)


@pytest.mark.parametrize(("base", "tip"), PAIRS)
def test_end_is_where_it_is_held_and_bears_only_what_it_holds(base: str, tip: str) -> None:
    problem = held(base, tip)
    state = solve_contact(
        problem, elements=48
    )  # the moment of the weight is a sum of fourth order: 4e-7
    weight = np.linalg.norm(WEIGHT) * LENGTH
    force, moment = imbalance(problem, state)
    assert force < 1e-6 * weight
    assert moment < 1e-6 * weight * LENGTH
    for kind, end, node, reaction in (
        (base, problem.base, 0, state.base_reaction),
        (tip, problem.tip, -1, state.tip_reaction),
    ):
        off = state.positions[node] - np.asarray(getattr(end, "position", state.positions[node]))
        turns = kind in ("pinned", "guided", "free")
        assert np.linalg.norm(np.cross(off, LINE)) < 1e-12
        assert kind.startswith("guided") or np.linalg.norm(off) < 1e-12
        if turns:
            assert np.linalg.norm(reaction[3:]) < 1e-8 * weight * LENGTH
        else:
            assert state.orientations[node] == pytest.approx(end.orientation, abs=1e-12)
            assert np.linalg.norm(reaction[3:]) > 1e-4 * weight * LENGTH
        if kind.startswith("guided"):
            assert np.linalg.norm(off) > 1e-4  # it has slid along
            assert abs(reaction[:3] @ LINE) < 1e-8 * weight
        if kind == "free":
            assert np.linalg.norm(reaction) < 1e-8 * weight


@pytest.mark.parametrize("base", ["clamped", "pinned"])
@pytest.mark.parametrize("tip", ["clamped", "pinned", "guided", "guided, not turning"])
def test_moving_an_end_step_by_step_does_the_work_of_its_reaction(base: str, tip: str) -> None:
    """Trapezoidal rule over 12 steps of 5 mm; halving them divides what is left by four."""
    first = held(base, tip)
    left = []
    for count in (12, 24):
        way = np.linspace(0.0, 0.06, count + 1)[:, None] * (-1.0, 0.4, 0.2)
        stations = [
            replace(first, tip=replace(first.tip, position=tuple(np.add(PLACE, d)))) for d in way
        ]
        path = follow_contact(stations, elements=24)
        assert not path.events
        forces = np.array([state.tip_reaction[:3] for state in path.states])
        # A guided end is shifted across its line only; along it, it goes where it likes.
        places = np.array([state.positions[-1] for state in path.states])
        work = np.sum(0.5 * (forces[1:] + forces[:-1]) * np.diff(places, axis=0))
        left.append(abs(path.states[-1].energy - path.states[0].energy - work))
        assert abs(work) > 1e-4
    assert left[1] < 1e-3 * abs(work)
    assert left[0] / left[1] == pytest.approx(4.0, rel=0.3)


def test_clamp_turned_step_by_step_winds_the_rod_up() -> None:
    """A straight rod between two clamps, one of which turns by five turns about the rod."""
    rod = Rod(LENGTH, Section((4e-4, 2.7e-4, 2.7e-4)))
    angles = np.linspace(0.0, 1.6 * math.pi, 9)
    stations = [
        RodProblem(
            rod,
            base=Clamped(),
            tip=Clamped((LENGTH, 0.0, 0.0), (math.sin(a / 2), 0.0, 0.0, math.cos(a / 2))),
        )
        for a in angles
    ]
    states = follow_contact(stations, elements=24).states
    for angle, state in zip(angles, states, strict=True):
        # Below Greenhill's moment, 2 pi EI / L for pins, it stays straight: M = GJ angle / L.
        assert state.tip_reaction[3] == pytest.approx(4e-4 * angle / LENGTH, abs=1e-9)
        assert np.abs(state.positions[:, 1:]).max() < 1e-9


@pytest.mark.parametrize(
    ("friction", "shift", "turn"),
    # Between stations things go straight: those that also turn about each other slip a little.
    [(0.4, (0.4, -0.4, 0.2), (0.0, 0.0, 0.0)), (0.0, (0.4, -0.4, 0.2), (0.3, -0.4, 0.8))],
)
def test_arm_that_carries_a_rod_and_a_bar_changes_nothing_in_it(
    friction: float, shift: tuple[float, ...], turn: tuple[float, ...]
) -> None:
    """A bar presses on the slack rod's arch; without gravity, which would not turn along."""
    bar = Obstacle.along(Cylinder(0.03), (0.16, 0.0, 0.2), (0.0, 1.0, 0.0), friction)
    clear = replace(held("clamped", "clamped"), load=RodLoad(), obstacles=(bar,))
    pushed = replace(clear, obstacles=(bar.moved((0.0, 0.0, -0.065)),))
    start = follow_contact([clear, pushed], elements=24).states[-1]
    assert start.normal_forces.sum() > 1e-3
    stations = [
        moved(pushed, part * np.array(shift), Rotation.from_rotvec(part * np.array(turn)))
        for part in (0.25, 0.5, 1.0)
    ]
    last = follow_contact(stations, start=start).states[-1]
    expected = Rotation.from_rotvec(turn).apply(start.positions) + np.array(shift)
    np.testing.assert_allclose(last.positions, expected, atol=1e-8)
    assert last.energy == pytest.approx(start.energy, rel=1e-7)
