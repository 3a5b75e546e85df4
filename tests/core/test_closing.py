# SPDX-License-Identifier: Apache-2.0
"""Closing in time: pneumatics against closed forms, courses, and what a rate costs."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from core.contact_cases import INNER, LENGTH, gripper

from benchmarks.closings import random_closing
from spiral_core import (
    Cylinder,
    GripSetup,
    InvalidInputError,
    NotGrippableError,
    Obstacle,
    Orifice,
    PressureCourse,
    Pull,
    RodStatus,
    Supply,
    close_on,
    enclosed_volume,
    grip_window,
    holding_force,
    lay_into_coil,
)
from spiral_core.grip.closing import (
    ATMOSPHERE,
    REFERENCE_DENSITY,
    REFERENCE_PRESSURE,
    TimedClosing,
    closing_frames,
    closing_spread,
    orifices_in_series,
    slow_closing,
)
from spiral_core.grip.setup import hanging_tube
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.rod.motion.motion import EventKind
from spiral_gripper import load_gripper

pytestmark = pytest.mark.long

VOLUME = 2.6e-5
SUPPLY = Supply(Orifice(1e-9, 0.5), 5e5)


def rigid(_: float) -> float:
    return VOLUME


def test_a_rigid_volume_fills_evenly_while_the_flow_is_choked() -> None:
    # 101 kPa inside, 601 kPa outside: choked up to half of that.
    rate = 1e-9 * (5e5 + ATMOSPHERE) * REFERENCE_PRESSURE / VOLUME
    assert SUPPLY.rates(rigid, 0.0)[0] == pytest.approx(rate, rel=1e-9)
    assert SUPPLY.time_to_fill(rigid, 0.0, 1.9e5) == pytest.approx(1.9e5 / rate, rel=1e-6)


def test_choked_venting_decays_exponentially() -> None:
    rate = 1e-9 * REFERENCE_PRESSURE / VOLUME
    time = SUPPLY.time_to_fill(rigid, 4e5, 2e5)
    expected = math.log((4e5 + ATMOSPHERE) / (2e5 + ATMOSPHERE)) / rate
    assert time == pytest.approx(expected, rel=1e-4)  # 400 samples


def test_subsonic_flow_follows_the_ellipse_and_dies_at_equal_pressures() -> None:
    orifice = Orifice(2e-9, 0.2)
    flow = orifice.mass_flow(2e5, 1.6e5)
    share = math.sqrt(1.0 - ((0.8 - 0.2) / 0.8) ** 2)
    assert flow == pytest.approx(2e-9 * REFERENCE_DENSITY * 2e5 * share)
    assert orifice.mass_flow(1.6e5, 2e5) == -flow
    assert orifice.mass_flow(2e5, 2e5) == 0.0
    assert orifice.mass_flow(2e5, 1e3) == pytest.approx(2e-9 * REFERENCE_DENSITY * 2e5)


def test_the_supply_pressure_is_reached_and_never_passed() -> None:
    assert math.isfinite(SUPPLY.time_to_fill(rigid, 0.0, 5e5))
    assert math.isinf(SUPPLY.time_to_fill(rigid, 0.0, 5.1e5))
    assert math.isfinite(SUPPLY.time_to_fill(rigid, 1e5, 0.0))


def test_a_dead_volume_and_a_growing_one_take_longer() -> None:
    alone = SUPPLY.time_to_fill(rigid, 0.0, 1e5)
    with_line = Supply(SUPPLY.orifice, 5e5, dead_volume=VOLUME)
    assert with_line.time_to_fill(rigid, 0.0, 1e5) == pytest.approx(2.0 * alone)
    # d(pV)/dp = V + p V': V = V0 (1 + p / p0) doubles at p0
    grown = SUPPLY.time_to_fill(lambda p: VOLUME * (1.0 + p / 1e5), 0.0, 1e5)
    assert grown == pytest.approx(alone * (2.0 * (1e5 + ATMOSPHERE) - ATMOSPHERE) / 1e5)
    line = orifices_in_series(Orifice(1e-9, 0.2), Orifice(1.0, 0.4))
    assert line.conductance == pytest.approx(1e-9)
    assert line.critical_ratio == pytest.approx(0.2)
    # C^-3 = 1 + 1/8, and b is the mean with these weights
    line = orifices_in_series(Orifice(1e-9, 0.2), Orifice(2e-9, 0.4))
    assert line.conductance == pytest.approx(1e-9 * (8.0 / 9.0) ** (1.0 / 3.0), rel=1e-12)
    assert line.critical_ratio == pytest.approx((0.2 + 0.4 / 8.0) / 1.125, rel=1e-12)


def test_the_enclosed_volume_begins_at_rest_and_grows() -> None:
    rest = math.pi * INNER**2 * LENGTH
    assert enclosed_volume(gripper(), 0.0) == pytest.approx(rest)
    work = enclosed_volume(gripper(), 5e4)
    assert 1.05 * rest < work < 2.0 * rest


def test_a_course_is_linear_between_its_points() -> None:
    course = PressureCourse((0.0, 2.0, 3.0), (0.0, 2e4, 1.4e4))
    assert [course.at(time) for time in (1.0, 2.5, 99.0)] == pytest.approx([1e4, 1.7e4, 1.4e4])
    assert PressureCourse.ramp(1e4, 2e4, 1.0) == PressureCourse((0.0, 2.0, 3.0), (0.0, 2e4, 2e4))


def test_a_fast_closing_holds_less_than_a_slow_one() -> None:
    setup = lay_into_coil(gripper(), 0.02)
    pressure = 1.15 * setup.tip_pressure
    slow = holding_force(slow_closing(setup, pressure)).force
    fast = close_on(setup, PressureCourse.ramp(10.0 * pressure, pressure, 2.0))
    assert fast.is_complete
    touches = [e for f in fast.frames for e in f.events if e.kind is EventKind.TOUCH]
    assert fast.time_to_touch == touches[0].time  # located, between two frames
    for frame in fast.frames:  # an interior point presses every node a little
        pressed = frame.state.normal_forces > 0.0
        assert frame.state.gaps[pressed].max(initial=0.0) < 1e-7
    early = next(i for i, c in enumerate(fast.contact_fractions) if c > 0.0)
    short = PressureCourse((0.0, fast.frames[early].time), (0.0, pressure))
    touched = TimedClosing(setup, short, fast.frames[: early + 1])
    assert touched.is_complete
    assert touched.time_to_wrap is None  # less than half a turn
    assert fast.holding_force().force < 0.5 * slow
    with pytest.raises(InvalidInputError, match="pressures"):
        close_on(setup, PressureCourse.ramp(1e4, 2.0 * setup.gripper.pressure_max, 1.0))


def mounted(gravity: tuple[float, float, float], radius: float) -> GripSetup:
    """Return a gripper held so that the straight tube would run through its object."""
    x, y, z = (9.80665 * c / math.hypot(*gravity) for c in gravity)
    return lay_into_coil(replace(gripper(), gravity=(x, y, z)), radius)


def test_an_object_where_only_the_straight_tube_would_run_is_closed_on() -> None:
    setup = mounted((-0.1, -0.02, 1.0), 0.0111)
    bare = setup.closing_problem(0.0)
    straight = solve_contact(bare, elements=setup.element_count, throw=False)
    assert straight.status is RodStatus.INSIDE_OBSTACLE
    hanging = hanging_tube(setup)
    free = solve_contact(replace(bare, obstacles=()), elements=setup.element_count)
    assert hanging.stable
    np.testing.assert_allclose(hanging.positions, free.positions, atol=1e-6 * 0.36)
    moved = close_on(setup, PressureCourse.ramp(1e6, 0.5 * setup.tip_pressure, 0.05))
    assert moved.is_complete


def test_an_object_in_the_way_of_the_hanging_tube_is_refused_by_name() -> None:
    setup = mounted((-0.09, -0.01, -1.0), 0.0387)
    for begin in (
        lambda: close_on(setup, PressureCourse.ramp(1e5, 1e4, 0.1)),
        lambda: slow_closing(setup, 1e4),
        lambda: grip_window(setup),
    ):
        with pytest.raises(NotGrippableError, match="runs through where the object lies"):
            begin()


def test_a_grip_is_judged_where_the_tube_rests() -> None:
    setup = lay_into_coil(gripper(), 0.02, elements=40)
    pressure = 1.15 * setup.tip_pressure
    moving = close_on(setup, PressureCourse.ramp(2e4, pressure, 0.02))
    last = moving.frames[-1]
    assert np.abs(last.velocities).max() > 1e-3
    assert moving.time_to_touch < moving.time_to_wrap < moving.course.duration
    with pytest.raises(InvalidInputError, match="complete"):
        closing_spread(replace(moving, frames=moving.frames[:-1]))
    cut = replace(moving, frames=moving.frames[:-1])  # as after an interrupt
    assert cut.time_to_wrap is None
    rest = moving.grip_at_rest()
    assert rest.state.stable
    assert rest.pressure == pressure
    assert 1e-6 < np.abs(rest.state.positions - last.state.positions).max() < 0.02
    assert moving.holding_force().force == pytest.approx(holding_force(rest).force)


def test_no_tube_rests_before_it_is_wrapped_at_the_final_pressure() -> None:
    """Slow enough, a tube that still closes has no part above 2 % of its length per second."""
    setup = lay_into_coil(gripper(), 0.02, elements=40)
    pressure = 1.15 * setup.tip_pressure
    slow = close_on(setup, PressureCourse.ramp(pressure / 12.0, pressure, 0.5))
    speeds = [np.abs(frame.velocities).max() for frame in slow.frames if frame.time > 11.0]
    assert max(speeds) < 0.02 * LENGTH
    assert slow.time_to_wrap <= slow.settling_time
    assert slow.settling_time >= 12.0


@pytest.mark.slow
def test_a_disorderly_closing_scatters_and_an_orderly_one_does_not() -> None:
    setup = lay_into_coil(load_gripper("prototype_p2"), 0.012)
    pressure, pull = 1.15 * setup.tip_pressure, Pull.AWAY
    for rate, orderly in ((4e4, False), (2e4, True)):
        closing = close_on(setup, PressureCourse.ramp(rate, pressure, 2.0))
        assert closing.is_orderly() == orderly
        low, high = closing_spread(closing).holding_forces[pull]
        assert (high < 1.05 * low) == orderly


def laid(gravity: tuple[float, float, float]) -> GripSetup:
    return lay_into_coil(replace(gripper(), gravity=gravity), 0.02, elements=40)


def under_the_tip(gap: float) -> GripSetup:
    """Return a cylinder straight under the hanging tube, crosswise."""
    reach = LENGTH + 0.02 + gripper().tube.outer_radius + gap
    obstacle = Obstacle.along(Cylinder(0.02), (reach, 0.0, 0.0), (0.0, 0.0, 1.0), 0.3)
    return GripSetup(gripper(), obstacle, elements=40)


RAMP = PressureCourse((0.0, 0.1, 0.2), (0.0, 5e4, 5e4))
STEP = PressureCourse((0.0, 1e-6, 0.2), (0.0, 5e4, 5e4))


@pytest.mark.parametrize(
    ("setup", "course"),
    [
        (lambda: laid((-9.80665, 0.0, 0.0)), RAMP),
        (lambda: laid((0.0, 0.0, 0.0)), RAMP),
        (lambda: laid((9.80665, 0.0, 0.0)), STEP),
        (lambda: under_the_tip(2e-3), RAMP),
        (lambda: under_the_tip(0.0), RAMP),
    ],
    ids=["upright", "no gravity", "step of pressure", "object under the tip", "touching the tip"],
)
def test_symmetric_mounts_and_jumps_are_closed_to_the_end(setup, course) -> None:
    closing = close_on(setup(), course)
    assert closing.is_complete
    for frame in closing.frames:
        assert np.isfinite(frame.velocities).all()
        assert frame.residual <= 1e-4
        assert frame.state.gaps[0, 1:].min() > -1e-6


@pytest.mark.slow
def test_a_tube_that_strikes_with_many_nodes_goes_on() -> None:
    """Contact forces reach 500 times the scale of forces; steps were not solved from 0.267 s on."""
    frames = list(islice(closing_frames(*random_closing(320)), 58))
    assert frames[-1].time > 0.29


def test_without_pressure_the_tube_stays_where_it_hangs() -> None:
    still = close_on(laid((9.80665, 0.0, 0.0)), PressureCourse((0.0, 0.5), (0.0, 0.0)))
    first, last = (frame.state.positions for frame in (still.frames[0], still.frames[-1]))
    np.testing.assert_allclose(last, first, atol=1e-8)
    assert still.settling_time == 0.0
    assert still.time_to_wrap is None
