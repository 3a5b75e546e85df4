# SPDX-License-Identifier: Apache-2.0
"""The rod in time with obstacles: it falls on them, sticks, slides, moves with them and leaves."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from core.test_motion import LENGTH, SECTION, TUBE, WEIGHT

from spiral_core import (
    Clamped,
    Cylinder,
    Damping,
    Free,
    Obstacle,
    Plane,
    Rod,
    RodLoad,
    RodProblem,
    solve_motion,
)
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.rod.motion import solve
from spiral_core.rod.motion.inertia import UNDAMPED
from spiral_core.rod.motion.motion import EventKind, MotionStatus

pytestmark = pytest.mark.long


@pytest.mark.parametrize(("ratio", "expected"), [(0.5, 0.5), (2.0, 1.0)])
def test_a_rod_on_a_plane_that_accelerates_sticks_or_slides(ratio: float, expected: float) -> None:
    friction = 0.3
    limit = friction * 9.81
    floor = Obstacle(Plane(), position=(0.0, 0.0, -5e-3), friction=friction)
    rod = Rod(LENGTH, SECTION, radius=5e-3, friction_radius=0.0)

    def pushed(time: float) -> RodProblem:
        moved = floor.moved((0.5 * ratio * limit * time**2, 0.0, 0.0))
        return RodProblem(rod, WEIGHT, base=Free(), obstacles=(moved,))

    points = np.column_stack((np.linspace(0.0, LENGTH, 13), np.zeros(13), np.zeros(13)))
    lying = solve_contact(pushed(0.0), start=points, elements=12)
    motion = solve_motion(pushed, TUBE, np.linspace(0.0, 0.2, 21), start=lying, damping=UNDAMPED)
    assert motion.status is MotionStatus.COMPLETED
    speed = motion.frames[-1].velocities[:, 0].mean()
    assert speed == pytest.approx(expected * limit * 0.2, rel=0.02)  # Euler while it touches
    slips = [event for event in motion.events if event.kind is EventKind.SLIP]
    assert bool(slips) == (ratio > 1.0)


@pytest.mark.parametrize("step", [0.008, 0.002])
def test_a_rod_and_its_object_in_acceleration_move_as_in_tilted_gravity(step: float) -> None:
    push = np.array((1.0, 0.0, 0.0))
    tilted = RodLoad(distributed=tuple(np.array(WEIGHT.distributed) - TUBE.mass * push))

    def coiling(time: float, load: RodLoad, place: np.ndarray) -> RodProblem:
        rod = Rod(LENGTH, SECTION, 5e-3, (8.0 + 4.0 * time, 0.0, 40.0 + 20.0 * time))
        center = tuple(place + np.array((0.0, 0.019, 0.0)))
        round_it = Obstacle.along(Cylinder(0.012), center, (1.0, 0.0, 0.0), friction=0.3)
        return RodProblem(rod, load, base=Clamped(tuple(place)), obstacles=(round_it,))

    start = solve_contact(coiling(0.0, WEIGHT, np.zeros(3)), elements=40)
    times = np.linspace(0.0, 0.5, 6)
    given = {"start": start, "damping": Damping(0.016, 0.0), "longest_step": step}
    stood = solve_motion(lambda t: coiling(t, tilted, np.zeros(3)), TUBE, times, **given)
    moved = solve_motion(lambda t: coiling(t, WEIGHT, 0.5 * t**2 * push), TUBE, times, **given)
    away = moved.positions - 0.5 * times[:, None, None] ** 2 * push
    # The forces of inertia act at nodes, the weight along elements: (1/40)^2.
    assert np.abs(away - stood.positions).max() < 1e-4 * LENGTH
    assert moved.events[-1].time == pytest.approx(stood.events[-1].time, abs=0.002)


def test_a_falling_rod_touches_when_it_must_and_rests_where_statics_says() -> None:
    floor = Obstacle(Plane(), position=(0.0, 0.0, -0.1))
    light = RodProblem(Rod(LENGTH, SECTION, radius=5e-3), obstacles=(floor,))
    heavy = replace(light, load=WEIGHT)
    motion = solve_motion(
        lambda _: heavy, TUBE, np.linspace(0.0, 8.0, 81), elements=30,
        start=solve_contact(light, elements=30), damping=Damping(0.05, 0.0, 2.0),
    )  # fmt: skip
    assert motion.status is MotionStatus.COMPLETED
    first = motion.events[0]
    assert first.kind is EventKind.TOUCH
    assert first.within < 1e-3
    # Free fall from 95 mm; the clamp only slows the tip, and its whip only speeds it up a little.
    assert 0.9 < first.time / math.sqrt(2.0 * 0.095 / 9.81) < 1.6
    rest = solve_contact(heavy, elements=30)
    assert np.abs(motion.positions[-1] - rest.positions).max() < 1e-4 * LENGTH
    assert min(frame.state.gaps.min() for frame in motion.frames) > -1e-6


def test_steps_of_the_least_length_are_taken_whatever_their_error(monkeypatch) -> None:
    floor = Obstacle(Plane(), position=(0.0, 0.0, -5e-3), friction=0.3)
    lying = RodProblem(Rod(LENGTH, SECTION, radius=5e-3), WEIGHT, obstacles=(floor,))
    line = np.column_stack((np.linspace(0.0, LENGTH, 5), np.zeros(5), np.zeros(5)))
    start = solve_contact(lying, start=line, elements=4)
    tried, advanced = [], solve.advanced

    def rough(*given):
        tried.append(given[2])
        assert len(tried) < 1000
        return advanced(*given)[0], 1.0

    monkeypatch.setattr(solve, "advanced", rough)
    # Steps grow to half of the longest; then the last two are longer by rounding alone.
    times = (0.0, 0.05, 0.05 + 0.01 + 2.5e-12)
    motion = solve_motion(lambda _: lying, TUBE, times, start=start)
    assert motion.status is MotionStatus.COMPLETED
    assert 1.0 < max(tried) / (0.5 * solve.DEFAULT_LONGEST_STEP) < 1.0 + 1e-6


def test_a_rod_is_let_go_beside_an_obstacle() -> None:
    floor = Obstacle(Plane(), position=(0.0, 0.0, -0.03), friction=0.3)
    heavy = RodProblem(Rod(LENGTH, SECTION, radius=5e-3), WEIGHT, obstacles=(floor,))
    line = np.column_stack((np.linspace(0.0, LENGTH, 13), np.zeros(13), np.zeros(13)))
    motion = solve_motion(lambda _: heavy, TUBE, (0.0, 0.2), start=line)
    first, last = (frame.state for frame in motion.frames)
    assert motion.status is MotionStatus.COMPLETED
    np.testing.assert_allclose(first.gaps[0], 0.025)
    assert not first.contact_forces.any()
    assert last.touching.any()


def test_a_floor_that_falls_away_is_lost_at_once() -> None:
    starts, fall = 0.0503, 5.0 * 9.81

    def dropped(time: float) -> RodProblem:
        depth = 0.5 * fall * max(0.0, time - starts) ** 2
        floor = Obstacle(Plane(), position=(0.0, 0.0, -5e-3 - depth), friction=0.3)
        rod = Rod(LENGTH, SECTION, radius=5e-3, friction_radius=0.0)
        return RodProblem(rod, WEIGHT, base=Free(), obstacles=(floor,))

    points = np.column_stack((np.linspace(0.0, LENGTH, 13), np.zeros(13), np.zeros(13)))
    lying = solve_contact(dropped(0.0), start=points, elements=12)
    motion = solve_motion(dropped, TUBE, np.linspace(0.0, 0.15, 16), start=lying, damping=UNDAMPED)
    (loss,) = motion.events
    assert loss.kind is EventKind.LOSS
    assert loss.obstacle == 0
    assert loss.within <= 0.03 * solve.DEFAULT_LONGEST_STEP * (1.0 + 1e-9)
    assert 0.0 <= loss.time - starts < 1e-3  # of first order in steps of 5 ms while it touches
    assert motion.contact_fractions[5] == 1.0
    assert motion.contact_fractions[6] == 0.0
    # From then on it falls by itself.
    speeds = motion.frames[-1].velocities[:, 2]
    np.testing.assert_allclose(speeds, -9.81 * (0.15 - starts), rtol=2e-2)
