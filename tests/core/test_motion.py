# SPDX-License-Identifier: Apache-2.0
"""The rod in time: frequencies, order, energy, momentum, damping, and what it falls on."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from core.contact_cases import bar, down, floor, line
from core.recorded import recorded
from numpy.testing import assert_allclose

from spiral_core import (
    Clamped,
    Cylinder,
    Damping,
    Free,
    Guided,
    Inertia,
    InvalidInputError,
    Obstacle,
    Pinned,
    Rod,
    RodLoad,
    RodProblem,
    Section,
    solve_motion,
    vibration_modes,
)
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.rod.motion.inertia import UNDAMPED
from spiral_core.rod.motion.motion import EventKind, MotionStatus
from spiral_core.rod.motion.solve import DEFAULT_LONGEST_STEP

pytestmark = pytest.mark.long

LENGTH, BENDING, RADIUS, MASS, GRAVITY, FRICTION = 0.36, 2.7e-4, 5e-3, 0.0283, 9.81, 0.3
TUBE = Inertia(MASS, MASS * 1.3e-5)
WEIGHT = down(MASS * GRAVITY)
ROD = Rod(LENGTH, Section((2.0 / 3.0 * BENDING, BENDING, BENDING)), RADIUS)
STRAIGHT, HELIX = RodProblem(ROD), RodProblem(replace(ROD, rest_strain=(8.0, 0.0, 40.0)))
PRESSED = RodProblem(ROD, down(1e-3), obstacles=(bar(0.01, LENGTH, -0.015, 0.5),))
BEAM = math.sqrt(BENDING / MASS) / LENGTH**2 / math.tau


@pytest.mark.parametrize(
    ("problem", "gyration", "expected"),
    [
        # The roots of cos cosh = -1; pinned at the end too, of tan = tanh.
        (STRAIGHT, 1e-8, 1.8751040687**2 * BEAM),
        (STRAIGHT, 1e-8, 7.8547574382**2 * BEAM),
        (PRESSED, 1e-8, 3.9266023**2 * BEAM),
        # It twists as a shaft.
        (STRAIGHT, 1.3e-5, math.sqrt(BENDING / (3.0 * MASS * 1.3e-5)) / (4.0 * LENGTH)),
    ],
)
def test_a_straight_cantilever_vibrates_as_theory_has_it(problem, gyration, expected):
    errors = []
    for elements in (30, 60):
        state = solve_contact(problem, elements=elements)
        found = vibration_modes(state, Inertia(MASS, MASS * gyration), 12).frequencies
        errors.append(np.abs(found / expected - 1.0).min())
    assert errors[1] < 3e-3  # lumped masses: of second order in the element's length
    assert problem is PRESSED or errors[0] / errors[1] == pytest.approx(4.0, rel=0.25)


def test_a_rod_that_may_turn_as_a_whole_or_has_a_moment_as_load_has_no_vibrations():
    section = Section.inextensible(3e-4, 2e-4)
    rod, upright = Rod(0.4, section), (0.0, 0.0, 0.0, 1.0)
    load = 4.0 * np.pi**2 * 3e-4 / 0.4**2  # Euler's, of a rod clamped at both ends
    for problem in (
        RodProblem(rod, base=Pinned(), tip=Guided((0.4, 0.0, 0.0))),
        RodProblem(
            rod,
            RodLoad(tip_force=(-1.02 * load, 0.0, 0.0)),
            tip=Guided((0.4, 0.0, 0.0), orientation=upright),
        ),
        RodProblem(rod, RodLoad(tip_moment=(0.0, 0.0, 1e-3))),  # has no energy
    ):
        state = solve_contact(problem, elements=20)
        with pytest.raises(InvalidInputError, match="state must be one that"):
            vibration_modes(state, TUBE, 2)


def test_air_does_not_slow_a_rod_without_radius():
    modes, of_thin = (
        vibration_modes(solve_contact(RodProblem(rod), elements=12), TUBE, 2)
        for rod in (ROD, replace(ROD, radius=0.0))
    )
    assert of_thin.frequencies == pytest.approx(modes.frequencies, rel=1e-9)
    swing = of_thin.swings[0]
    assert (swing.air_creeping, swing.air_inertial) == (0.0, 0.0)


def test_a_helical_cantilever_swings_at_an_eigenvalue_of_its_hessian():
    """And keeps its energy."""
    rest = solve_contact(HELIX, elements=24)
    modes = vibration_modes(rest, TUBE, 1)

    # Under a load along a mode's shape a rod bends into that mode alone.
    def along(sites):
        return 1e-4 * np.transpose(
            [np.interp(sites, rest.arc_lengths, c) for c in modes.shapes[0].T]
        )

    bent = solve_contact(replace(HELIX, load=RodLoad(along)), elements=24)
    given = {"start": bent, "damping": UNDAMPED, "longest_step": 0.002}
    motion = solve_motion(lambda _: HELIX, TUBE, np.linspace(0.0, 2.0, 201), **given)
    moved = (motion.positions - rest.positions)[:, -1]
    phase = math.tau * modes.frequencies[0] * motion.times
    # 0.1 % in frequency
    assert_allclose(moved @ moved[0] / (moved[0] @ moved[0]), np.cos(phase), rtol=0.0, atol=0.02)
    kinetic, elastic = np.transpose([(f.kinetic_energy, f.state.energy) for f in motion.frames])
    # The method takes from vibrations that no step resolves.
    assert np.ptp(kinetic + elastic) < 0.02 * kinetic.max()


def driven(time):
    """Return a tube that coils up while its base rises, smoothly."""
    s = min(time, 1.0)
    b = s**4 * (35.0 - 84.0 * s + 70.0 * s**2 - 20.0 * s**3)
    rod = replace(ROD, rest_strain=(3.0 * b, 0.0, 8.0 * b))
    return RodProblem(rod, WEIGHT, base=Clamped((0.0, 0.0, 0.05 * b)))


@pytest.mark.parametrize("damping", [UNDAMPED, Damping(0.02, 0.0), Damping(0.0, 0.0, 3.0)])
def test_motion_without_contact_is_of_second_order_in_time(damping):
    given = {"damping": damping, "elements": 16, "tolerance": 1.0}
    ends = [
        solve_motion(driven, TUBE, np.arange(0.0, 0.9 + 1e-9, step), longest_step=step, **given)
        for step in (0.02, 0.01, 0.005)
    ]
    coarse, fine = np.abs(np.diff([end.positions[-1] for end in ends], axis=0)).max(axis=(1, 2))
    assert coarse / fine == pytest.approx(4.0, rel=0.15)


def test_the_estimated_error_bounds_the_true_one():
    exact, *motions = (
        solve_motion(driven, TUBE, (0.0, 0.9), elements=16, tolerance=tolerance)
        for tolerance in (1e-8, 1e-4, 1e-6)
    )
    recorded("motion/driven", [[m.positions[-1], m.frames[-1].error, m.events] for m in motions])
    for motion in motions:
        true = np.abs(motion.positions[-1] - exact.positions[-1]).max()
        assert 0.05 * motion.frames[-1].error < true < 2.0 * motion.frames[-1].error


def test_the_base_takes_the_change_of_momentum():
    def lifted(time):
        return RodProblem(ROD, WEIGHT, Clamped((0.0, 0.0, 0.5 * time**3)))

    given = {"elements": 20, "longest_step": 1e-3, "damping": UNDAMPED}
    motion = solve_motion(lifted, TUBE, np.linspace(0.0, 0.6, 601), **given)
    lengths = motion.frames[0].state.node_lengths
    momentum = MASS * np.array([lengths @ frame.velocities for frame in motion.frames])
    forces = [f.state.base_reaction[:3] for f in motion.frames] + LENGTH * np.array(
        WEIGHT.distributed
    )
    impulse = 1e-3 * np.cumsum(0.5 * (forces[1:] + forces[:-1]), axis=0)
    scale = np.abs(momentum).max()
    assert scale > 5e-4
    assert_allclose(impulse[50:], momentum[51:] - momentum[0], atol=0.02 * scale)


def test_a_rod_may_change_and_a_motion_that_cannot_go_on_says_so():
    def changes(time):
        return HELIX if time else STRAIGHT

    def jumps(time):
        return replace(STRAIGHT, base=Clamped((0.0, 0.0, 1.0 if time > 0.05 else 0.0)))

    assert solve_motion(changes, TUBE, (0.0, 0.01), elements=12).status is MotionStatus.COMPLETED
    motion = solve_motion(jumps, TUBE, (0.0, 0.04, 0.1), elements=8)
    assert motion.status is MotionStatus.STALLED
    assert len(motion.frames) == 2


def over_floor(depth=RADIUS, along=0.0, **given):
    """Return a rod that may fall on a floor."""
    below = floor(-depth, FRICTION, along)
    return RodProblem(replace(ROD, friction_radius=0.0), WEIGHT, obstacles=(below,), **given)


def from_lying(problem, end):
    """Return the motion of a rod that nothing holds, from rest on its floor; it cannot roll."""
    lying = solve_contact(problem(0.0), start=line(LENGTH, 12), elements=12)
    return solve_motion(problem, TUBE, np.arange(0.0, end, 0.01), start=lying, damping=UNDAMPED)


@pytest.mark.parametrize(("ratio", "expected"), [(0.5, 0.5), (2.0, 1.0)])
def test_a_rod_on_a_plane_that_accelerates_sticks_or_slides(ratio, expected):
    limit = FRICTION * GRAVITY
    motion = from_lying(
        lambda time: over_floor(along=0.5 * ratio * limit * time**2, base=Free()), 0.201
    )
    assert motion.status is MotionStatus.COMPLETED
    speed = motion.frames[-1].velocities[:, 0].mean()
    assert speed == pytest.approx(expected * limit * 0.2, rel=0.02)  # Euler while it touches
    assert (EventKind.SLIP in [event.kind for event in motion.events]) == (ratio > 1.0)


def test_a_floor_that_falls_away_is_lost_at_once():
    starts = 0.0503

    def falls(time):
        return over_floor(RADIUS + 2.5 * GRAVITY * max(0.0, time - starts) ** 2, base=Free())

    motion = from_lying(falls, 0.151)
    (loss,) = motion.events
    assert (loss.kind, loss.obstacle) == (EventKind.LOSS, 0)
    assert loss.within <= 0.03 * DEFAULT_LONGEST_STEP * (1.0 + 1e-9)
    assert 0.0 <= loss.time - starts < 1e-3  # of first order in steps of 5 ms while it touches
    assert motion.contact_fractions[5:7] == pytest.approx((1.0, 0.0))
    # From then on it falls by itself.
    assert_allclose(motion.frames[-1].velocities[:, 2], -GRAVITY * (0.15 - starts), rtol=2e-2)


def test_a_rod_and_its_object_in_acceleration_move_as_in_tilted_gravity():
    push, times = np.array((1.0, 0.0, 0.0)), np.linspace(0.0, 0.5, 6)

    def coiled(load, way):
        def coiling(time):
            rod = replace(ROD, rest_strain=(8.0 + 4.0 * time, 0.0, 40.0 + 20.0 * time))
            place = 0.5 * time**2 * way
            peg = Obstacle.along(Cylinder(0.012), (0.0, 0.019, 0.0), (1.0, 0.0, 0.0), FRICTION)
            peg = peg.moved(place)
            return RodProblem(rod, load, Clamped((*place,)), obstacles=(peg,))

        start = solve_contact(replace(coiling(0.0), load=WEIGHT), elements=40)
        given = {"start": start, "damping": Damping(0.016, 0.0), "longest_step": 8e-3}
        return solve_motion(coiling, TUBE, times, **given)

    stood = coiled(RodLoad(WEIGHT.distributed - MASS * push), 0.0 * push)
    moved = coiled(WEIGHT, push)
    away = moved.positions - 0.5 * times[:, None, None] ** 2 * push
    # The forces of inertia act at nodes, the weight along elements: (1/40)^2.
    assert_allclose(away, stood.positions, rtol=0.0, atol=1e-4 * LENGTH)
    recorded("motion/coiled", [moved.positions, *moved.events[:4]])
    assert moved.events[-1].time == pytest.approx(stood.events[-1].time, abs=0.002)


def test_the_long_time_limit_is_the_static_state():
    """Let go as its rest strain has it; and beside a smooth floor, as it lies in a centerline."""
    for problem, start in (
        (replace(HELIX, load=WEIGHT), solve_contact(HELIX, elements=40)),
        (RodProblem(ROD, WEIGHT, obstacles=(floor(-0.1),)), line(LENGTH, 30)),
    ):
        given = {"start": start, "damping": Damping(0.05, 1.0, 2.0), "longest_step": 0.1}
        motion = solve_motion(
            lambda _, problem=problem: problem, TUBE, np.linspace(0.0, 60.0, 81), **given
        )
        assert motion.status is MotionStatus.COMPLETED
        rest = solve_contact(problem, elements=len(motion.positions[0]) - 1)
        assert_allclose(motion.positions[-1], rest.positions, rtol=0.0, atol=1e-4 * LENGTH)
    first = motion.events[0]
    assert first.kind is EventKind.TOUCH
    assert first.within < 1e-3
    # Free fall from 95 mm; the clamp only slows the tip, and its whip only speeds it up a little.
    assert 0.9 < first.time / math.sqrt(2.0 * 0.095 / GRAVITY) < 1.6
    assert min(frame.state.gaps.min() for frame in motion.frames) > -1e-6
