# SPDX-License-Identifier: Apache-2.0
"""The rod in time with obstacles: it falls on them, sticks, slides, moves with them and leaves."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from spiral_core import (
    Clamped,
    Cylinder,
    Damping,
    Free,
    Inertia,
    Obstacle,
    Plane,
    Rod,
    RodLoad,
    RodProblem,
    Section,
    solve_motion,
)
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.rod.motion import solve
from spiral_core.rod.motion.inertia import UNDAMPED
from spiral_core.rod.motion.motion import EventKind, MotionStatus

pytestmark = pytest.mark.long

LENGTH, RADIUS, MASS, GRAVITY, FRICTION = 0.36, 5e-3, 0.0283, 9.81, 0.3
TUBE = Inertia(MASS, MASS * 1.3e-5)
WEIGHT = RodLoad((0.0, 0.0, -MASS * GRAVITY))
ROD = Rod(LENGTH, Section((1.8e-4, 2.7e-4, 2.7e-4)), RADIUS)
LINE = np.linspace((0.0, 0.0, 0.0), (LENGTH, 0.0, 0.0), 13)


def over_floor(depth=RADIUS, along=0.0):
    """Return a clamped rod that may fall on a rough floor."""
    floor = Obstacle(Plane(), (along, 0.0, -depth), friction=FRICTION)
    return RodProblem(ROD, WEIGHT, obstacles=(floor,))


def from_lying(problem, times):
    """Return the motion of a rod that nothing holds, from rest on its floor; it cannot roll."""

    def free(time):
        return replace(problem(time), rod=replace(ROD, friction_radius=0.0), base=Free())

    lying = solve_contact(free(0.0), start=LINE, elements=12)
    return solve_motion(free, TUBE, times, start=lying, damping=UNDAMPED)


@pytest.mark.parametrize(("ratio", "expected"), [(0.5, 0.5), (2.0, 1.0)])
def test_a_rod_on_a_plane_that_accelerates_sticks_or_slides(ratio, expected):
    limit = FRICTION * GRAVITY
    motion = from_lying(
        lambda time: over_floor(along=0.5 * ratio * limit * time**2), np.linspace(0.0, 0.2, 21)
    )
    assert motion.status is MotionStatus.COMPLETED
    speed = motion.frames[-1].velocities[:, 0].mean()
    assert speed == pytest.approx(expected * limit * 0.2, rel=0.02)  # Euler while it touches
    assert (EventKind.SLIP in [event.kind for event in motion.events]) == (ratio > 1.0)


def test_a_floor_that_falls_away_is_lost_at_once():
    starts = 0.0503
    motion = from_lying(
        lambda time: over_floor(RADIUS + 2.5 * GRAVITY * max(0.0, time - starts) ** 2),
        np.linspace(0.0, 0.15, 16),
    )
    (loss,) = motion.events
    assert (loss.kind, loss.obstacle) == (EventKind.LOSS, 0)
    assert loss.within <= 0.03 * solve.DEFAULT_LONGEST_STEP * (1.0 + 1e-9)
    assert 0.0 <= loss.time - starts < 1e-3  # of first order in steps of 5 ms while it touches
    assert motion.contact_fractions[5:7] == pytest.approx((1.0, 0.0))
    # From then on it falls by itself.
    speeds = motion.frames[-1].velocities[:, 2]
    np.testing.assert_allclose(speeds, -GRAVITY * (0.15 - starts), rtol=2e-2)


def test_a_rod_and_its_object_in_acceleration_move_as_in_tilted_gravity():
    push = np.array((1.0, 0.0, 0.0))
    times = np.linspace(0.0, 0.5, 6)

    def coiled(load, way):
        def coiling(time):
            rod = replace(ROD, rest_strain=(8.0 + 4.0 * time, 0.0, 40.0 + 20.0 * time))
            place = 0.5 * time**2 * way
            beside = np.add(place, (0.0, 0.019, 0.0))
            peg = Obstacle.along(Cylinder(0.012), (*beside,), (1.0, 0.0, 0.0), FRICTION)
            return RodProblem(rod, load, Clamped((*place,)), obstacles=(peg,))

        start = solve_contact(replace(coiling(0.0), load=WEIGHT), elements=40)
        given = {"start": start, "damping": Damping(0.016, 0.0), "longest_step": 8e-3}
        return solve_motion(coiling, TUBE, times, **given)

    stood = coiled(RodLoad((*(WEIGHT.distributed - MASS * push),)), 0.0 * push)
    moved = coiled(WEIGHT, push)
    away = moved.positions - 0.5 * times[:, None, None] ** 2 * push
    # The forces of inertia act at nodes, the weight along elements: (1/40)^2.
    assert np.abs(away - stood.positions).max() < 1e-4 * LENGTH
    assert moved.events[-1].time == pytest.approx(stood.events[-1].time, abs=0.002)


def test_a_falling_rod_touches_when_it_must_and_rests_where_statics_says():
    """Let go beside the floor, as it lies in a centerline."""
    heavy = over_floor(0.1)
    heavy = replace(heavy, obstacles=(replace(heavy.obstacles[0], friction=0.0),))
    times = np.linspace(0.0, 8.0, 81)
    line = np.linspace((0.0, 0.0, 0.0), (LENGTH, 0.0, 0.0), 31)
    motion = solve_motion(lambda _: heavy, TUBE, times, start=line, damping=Damping(0.05, 0.0, 2.0))
    assert motion.status is MotionStatus.COMPLETED
    first = motion.events[0]
    assert first.kind is EventKind.TOUCH
    assert first.within < 1e-3
    # Free fall from 95 mm; the clamp only slows the tip, and its whip only speeds it up a little.
    assert 0.9 < first.time / math.sqrt(2.0 * 0.095 / GRAVITY) < 1.6
    rest = solve_contact(heavy, elements=30)
    assert np.abs(motion.positions[-1] - rest.positions).max() < 1e-4 * LENGTH
    assert min(frame.state.gaps.min() for frame in motion.frames) > -1e-6
