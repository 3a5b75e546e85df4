# SPDX-License-Identifier: Apache-2.0
"""The rod in time: frequencies, order, energy, momentum, damping, and bad input."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from spiral_core import (
    Clamped,
    Cylinder,
    Damping,
    Inertia,
    Obstacle,
    Rod,
    RodLoad,
    RodProblem,
    Section,
    solve_motion,
    vibration_modes,
)
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.rod.motion.inertia import UNDAMPED
from spiral_core.rod.motion.motion import MotionStatus

pytestmark = pytest.mark.long

LENGTH, BENDING = 0.36, 2.7e-4
SECTION = Section((2.0 / 3.0 * BENDING, BENDING, BENDING))
SLENDER = Inertia(mass=0.0283, rotary=0.0283 * 1e-8)
TUBE = Inertia(mass=0.0283, rotary=0.0283 * 1.3e-5)
STRAIGHT = RodProblem(Rod(LENGTH, SECTION, radius=5e-3))
HELIX = RodProblem(Rod(LENGTH, SECTION, radius=5e-3, rest_strain=(8.0, 0.0, 40.0)))
WEIGHT = RodLoad(distributed=(0.0, 0.0, -0.0283 * 9.81))


def beam_frequency(root):
    """Return what beam theory has for a root beta L [Hz]."""
    return (root / LENGTH) ** 2 * math.sqrt(BENDING / SLENDER.mass) / math.tau


@pytest.mark.parametrize(("mode", "root"), [(0, 1.8751040687), (2, 7.8547574382)])
def test_a_straight_cantilever_vibrates_as_beam_theory_has_it(mode, root):
    """Its roots are those of cos cosh = -1; modes come in pairs."""
    errors = []
    for elements in (30, 60):
        state = solve_contact(STRAIGHT, elements=elements)
        found = vibration_modes(state, SLENDER, 6).frequencies[2 * mode]
        errors.append(abs(found / beam_frequency(root) - 1.0))
    assert errors[1] < 1e-3  # lumped masses: of second order in the element's length
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.25)


def test_a_straight_cantilever_twists_as_a_shaft():
    found = vibration_modes(solve_contact(STRAIGHT, elements=60), TUBE, 12).frequencies
    expected = math.sqrt(2.0 / 3.0 * BENDING / (2.0 * TUBE.rotary)) / (4.0 * LENGTH)
    # second order in 1/60; bending modes come in pairs beside it
    assert np.abs(found / expected - 1.0).min() < 1e-4


def test_air_does_not_slow_a_rod_without_radius():
    thin = replace(STRAIGHT, rod=replace(STRAIGHT.rod, radius=0.0))
    modes, of_thin = (
        vibration_modes(solve_contact(rod, elements=12), TUBE, 2) for rod in (STRAIGHT, thin)
    )
    assert of_thin.frequencies == pytest.approx(modes.frequencies, rel=1e-9)
    swing = of_thin.swings[0]
    assert (swing.air_creeping, swing.air_inertial) == (0.0, 0.0)


def test_a_rod_pressed_on_a_pin_vibrates_as_one_that_is_held_there():
    """A beam, clamped and pinned at its end: the root of tan = tanh."""
    pin = Obstacle.along(Cylinder(0.01), (LENGTH, 0.0, -0.015), (0.0, 1.0, 0.0), 0.5)
    pressed = RodLoad(distributed=(0.0, 0.0, -1e-3))
    state = solve_contact(RodProblem(STRAIGHT.rod, pressed, obstacles=(pin,)), elements=80)
    assert state.touching.any(axis=0).nonzero()[0].tolist() == [80]
    modes = vibration_modes(state, SLENDER, 4)
    # of second order in 1/80
    assert modes.frequencies[0] == pytest.approx(beam_frequency(3.9266023), rel=2e-3)
    assert np.abs(modes.shapes[:, -1]).max() < 1e-5


def test_a_helical_cantilever_swings_at_an_eigenvalue_of_its_hessian():
    """And keeps its energy."""
    rest = solve_contact(HELIX, elements=24)
    modes = vibration_modes(rest, TUBE, 1)

    # Under a load along a mode's shape a rod bends into that mode alone.
    def along(sites):
        shape = 1e-4 * modes.shapes[0]
        return np.column_stack([np.interp(sites, rest.arc_lengths, c) for c in shape.T])

    bent = solve_contact(replace(HELIX, load=RodLoad(distributed=along)), elements=24)
    motion = solve_motion(
        lambda _: HELIX, TUBE, np.linspace(0.0, 2.0, 201), start=bent, damping=UNDAMPED,
        longest_step=0.002,
    )  # fmt: skip
    moved = motion.positions - rest.positions
    signal = moved[:, -1] @ moved[0, -1] / np.sum(moved[0, -1] ** 2)
    phase = math.tau * modes.frequencies[0] * motion.times
    assert np.abs(signal - np.cos(phase)).max() < 0.02  # 0.1 % in frequency
    energies = [frame.kinetic_energy + frame.state.energy for frame in motion.frames]
    swung = max(frame.kinetic_energy for frame in motion.frames)
    assert np.ptp(energies) < 0.02 * swung  # the method takes from vibrations that no step resolves


def driven(time):
    """Return a tube that coils up while its base rises, smoothly."""
    s = min(time, 1.0)
    b = s**4 * (35.0 - 84.0 * s + 70.0 * s**2 - 20.0 * s**3)
    rod = Rod(LENGTH, SECTION, radius=5e-3, rest_strain=(3.0 * b, 0.0, 8.0 * b))
    return RodProblem(rod, WEIGHT, base=Clamped((0.0, 0.0, 0.05 * b)))


@pytest.mark.parametrize("damping", [UNDAMPED, Damping(0.02, 0.0), Damping(0.0, 0.0, 3.0)])
def test_motion_without_contact_is_of_second_order_in_time(damping):
    ends = [
        solve_motion(
            driven, TUBE, np.arange(0.0, 0.9 + 1e-9, step), damping=damping, elements=16,
            longest_step=step, tolerance=1.0,
        ).positions[-1]
        for step in (0.02, 0.01, 0.005)
    ]  # fmt: skip
    coarse, fine = np.abs(ends[0] - ends[1]).max(), np.abs(ends[1] - ends[2]).max()
    assert coarse / fine == pytest.approx(4.0, rel=0.15)


def test_the_estimated_error_bounds_the_true_one():
    exact, *motions = (
        solve_motion(driven, TUBE, (0.0, 0.9), elements=16, tolerance=tolerance)
        for tolerance in (1e-8, 1e-4, 1e-6)
    )
    for motion in motions:
        true = np.abs(motion.positions[-1] - exact.positions[-1]).max()
        assert 0.05 * motion.frames[-1].error < true < 2.0 * motion.frames[-1].error


def test_the_long_time_limit_is_the_static_state():
    heavy = replace(HELIX, load=WEIGHT)
    rest, start = (solve_contact(problem, elements=40) for problem in (heavy, HELIX))
    motion = solve_motion(
        lambda _: heavy, TUBE, (0.0, 60.0), start=start, damping=Damping(0.05, 1.0, 2.0),
        longest_step=0.1,
    )  # fmt: skip
    assert np.abs(motion.positions[-1] - rest.positions).max() < 1e-6 * LENGTH


def test_the_base_takes_the_change_of_momentum():
    def lifted(time):
        return replace(STRAIGHT, load=WEIGHT, base=Clamped((0.0, 0.0, 0.5 * time**3)))

    times = np.linspace(0.0, 0.6, 601)
    motion = solve_motion(lifted, TUBE, times, elements=20, longest_step=1e-3, damping=UNDAMPED)
    masses = TUBE.mass * motion.frames[0].state.node_lengths[:, None]
    momentum = np.array([np.sum(masses * f.velocities, axis=0) for f in motion.frames])
    forces = np.array([f.state.base_reaction[:3] for f in motion.frames])
    weight = np.array(WEIGHT.distributed) * LENGTH
    impulse = np.cumsum(0.5 * (forces[1:] + forces[:-1]) + weight, axis=0) * 1e-3
    scale = np.abs(momentum).max()
    assert scale > 5e-4
    np.testing.assert_allclose(impulse[50:], momentum[51:] - momentum[0], atol=0.02 * scale)


def test_a_rod_may_change_and_a_motion_that_cannot_go_on_says_so():
    def changes(time):
        return HELIX if time else STRAIGHT

    assert solve_motion(changes, TUBE, (0.0, 0.01), elements=12).status is MotionStatus.COMPLETED

    def jumps(time):
        return replace(STRAIGHT, base=Clamped((0.0, 0.0, 1.0 if time > 0.05 else 0.0)))

    motion = solve_motion(jumps, TUBE, (0.0, 0.04, 0.1), elements=8)
    assert motion.status is MotionStatus.STALLED
    assert len(motion.frames) == 2
