# SPDX-License-Identifier: Apache-2.0
"""Closing in time: pneumatics against closed forms, courses, and what a rate costs."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from core.contact_cases import INNER, LENGTH, gripper
from core.recorded import recorded, said

from benchmarks.closings import random_closing
from spiral_core import (
    Cylinder,
    GripSetup,
    InvalidInputError,
    Obstacle,
    Orifice,
    PressureCourse,
    RodStatus,
    Supply,
    close_on,
    enclosed_volume,
    growing_advice,
    holding_force,
    lay_into_coil,
)
from spiral_core.grip.closing import (
    ATMOSPHERE,
    REFERENCE_DENSITY,
    REFERENCE_PRESSURE,
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
FLOW = 1e-9 * REFERENCE_PRESSURE / VOLUME  # choked, as a part of the pressure upstream [1/s]
FILL = FLOW * (5e5 + ATMOSPHERE)  # choked up to half of that


@pytest.mark.parametrize(
    ("dead", "growth", "start", "end", "expected"),
    [
        (0.0, 0.0, 0.0, 1.9e5, 1.9e5 / FILL),
        (0.0, 0.0, 4e5, 2e5, math.log((4e5 + ATMOSPHERE) / (2e5 + ATMOSPHERE)) / FLOW),
        (VOLUME, 0.0, 0.0, 1e5, 2e5 / FILL),
        # d(pV)/dp = V + p V': V = V0 (1 + p / p0) doubles at p0
        (0.0, 1e-5, 0.0, 1e5, (2.0 * (1e5 + ATMOSPHERE) - ATMOSPHERE) / FILL),
        (0.0, 0.0, 0.0, 5.1e5, math.inf),  # the supply's pressure is not passed
    ],
)
def test_a_volume_fills_evenly_and_empties_exponentially_while_the_flow_is_choked(
    dead, growth, start, end, expected
):
    supply = Supply(Orifice(1e-9, 0.5), 5e5, dead)
    found = supply.time_to_fill(lambda p: VOLUME * (1.0 + growth * p), start, end)
    assert found == pytest.approx(expected, rel=1e-4)  # 400 samples


def test_subsonic_flow_follows_the_ellipse_and_dies_at_equal_pressures():
    orifice = Orifice(2e-9, 0.2)
    for share in (0.8, 0.5, 0.2, 0.005, 1.0):
        flow = orifice.mass_flow(2e5, share * 2e5)
        part = math.sqrt(1.0 - max(0.0, (share - 0.2) / 0.8) ** 2)
        assert flow == pytest.approx(2e-9 * REFERENCE_DENSITY * 2e5 * part)
        assert orifice.mass_flow(share * 2e5, 2e5) == -flow
    supply = Supply(orifice, 5e5)  # it and the atmosphere are reached nevertheless
    for start, end in ((0.0, 5e5), (1e5, 0.0)):
        assert math.isfinite(supply.time_to_fill(lambda _: VOLUME, start, end))
    line = orifices_in_series(orifice, Orifice(4e-9, 0.4))
    # C^-3 = 1 + 1/8, and b is the mean with these weights
    assert line.conductance == pytest.approx(2e-9 * (8.0 / 9.0) ** (1.0 / 3.0), rel=1e-12)
    assert line.critical_ratio == pytest.approx((0.2 + 0.4 / 8.0) / 1.125, rel=1e-12)


def test_the_enclosed_volume_begins_at_rest_and_grows():
    rest = math.pi * INNER**2 * LENGTH
    assert enclosed_volume(gripper(), 0.0) == pytest.approx(rest)
    assert 1.05 * rest < enclosed_volume(gripper(), 5e4) < 2.0 * rest


def laid(*gravity, radius=0.02, elements=40):
    """Return a gripper on a cylinder in its coil, and a pressure beyond the wrap's."""
    down = gravity or (1.0, 0.0, 0.0)
    down = (*np.multiply(9.80665 / max(np.linalg.norm(down), 1e-9), down).tolist(),)
    setup = lay_into_coil(replace(gripper(), gravity=down), radius, elements=elements)
    return setup, 1.15 * setup.tip_pressure


def test_a_fast_closing_holds_less_than_a_slow_one():
    setup, pressure = laid()
    fast = close_on(setup, PressureCourse.ramp(10.0 * pressure, pressure, 2.0))
    assert fast.is_complete
    touches = [e for f in fast.frames for e in f.events if e.kind is EventKind.TOUCH]
    assert fast.time_to_touch == touches[0].time  # located, between two frames
    for frame in fast.frames:  # an interior point presses every node a little
        pressed = frame.state.normal_forces > 0.0
        assert frame.state.gaps[pressed].max(initial=0.0) < 1e-7
    slow = slow_closing(setup, pressure)
    assert fast.holding_force().force < 0.5 * holding_force(slow).force
    assert not fast.is_orderly(slow)
    with pytest.raises(InvalidInputError, match="pressures"):
        close_on(setup, PressureCourse.ramp(1e4, 2.0 * setup.gripper.pressure_max, 1.0))
    for impossible in (-1.0, math.nan, 2.0 * setup.gripper.pressure_max):
        with pytest.raises(InvalidInputError, match="pressure"):
            next(growing_advice(setup, impossible, (1e4,)))


def test_an_object_where_only_the_straight_tube_would_run_is_closed_on():
    setup, pressure = laid(-0.1, -0.02, 1.0, radius=0.0111, elements=60)
    bare = setup.closing_problem(0.0)
    straight = solve_contact(bare, elements=60, throw=False)
    assert straight.status is RodStatus.INSIDE_OBSTACLE
    free, hanging = solve_contact(replace(bare, obstacles=()), elements=60), hanging_tube(setup)
    assert hanging.stable
    np.testing.assert_allclose(hanging.positions, free.positions, atol=1e-6 * LENGTH)
    assert close_on(setup, PressureCourse.ramp(1e6, 0.4 * pressure, 0.05)).is_complete


def test_a_grip_is_judged_where_the_tube_rests():
    setup, pressure = laid()
    at_rest = next(closing_frames(setup, PressureCourse((0.0, 1.0), (2e4, 2e4)))).state
    np.testing.assert_allclose(
        at_rest.positions, slow_closing(setup, 2e4).state.positions, atol=1e-6 * LENGTH
    )
    moving = close_on(setup, PressureCourse.ramp(2e4, pressure, 0.02))
    last, rest = moving.frames[-1], moving.grip_at_rest()
    assert np.abs(last.velocities).max() > 1e-3
    assert rest.state.stable
    assert 1e-6 < np.abs(rest.state.positions - last.state.positions).max() < 0.02
    held = moving.holding_force()
    assert held.force == pytest.approx(holding_force(rest).force)
    times = moving.time_to_touch, moving.settling_time, len(moving.frames)
    recorded("closing/judged", [times, held.end, rest.regime])
    # Impacts multiply what rounding leaves: the wrap is a frame earlier or later.
    recorded("closing/wrapped", [moving.time_to_wrap], within=0.02)
    cut = replace(moving, frames=moving.frames[:-1])  # as after an interrupt
    assert cut.time_to_wrap is None
    in_the_way, _ = laid(-0.09, -0.01, -1.0, radius=0.0387)
    recorded("closing/refused", [said(closing_spread, cut), said(hanging_tube, in_the_way)])


@pytest.mark.slow
@pytest.mark.parametrize(("rate", "orderly"), [(8e4, False), (4e4, False), (2e4, True)])
def test_a_disorderly_closing_scatters_and_an_orderly_one_does_not(rate, orderly):
    setup = lay_into_coil(load_gripper("prototype_p2"), 0.012)
    closing = close_on(setup, PressureCourse.ramp(rate, 1.15 * setup.tip_pressure, 2.0))
    assert closing.is_orderly(slow_closing(setup, closing.point.pressure)) == orderly
    spread = closing_spread(closing)
    least, most = spread.normal_force
    ranges = [(least, most), spread.contact_fraction, *spread.holding_forces.values()]
    assert all(high < 1.05 * low for low, high in ranges) == orderly
    assert least <= closing.point.normal_force <= most


@pytest.mark.parametrize(
    ("gravity", "rise", "pressure"),
    [
        ((-1.0, 0.0, 0.0), 0.1, 5e4),
        ((0.0, 0.0, 0.0), 0.1, 5e4),
        ((), 1e-6, 5e4),
        ((), 0.1, 0.0),
        (None, 0.1, 5e4),
    ],
)
def test_symmetric_mounts_and_jumps_are_closed_to_the_end(gravity, rise, pressure):
    """On a cylinder, too, that touches the hanging tube's tip crosswise.

    Without pressure the tube stays where it hangs.
    """
    if gravity is None:
        reach = LENGTH + 0.02 + gripper().tube.outer_radius
        below = Obstacle.along(Cylinder(0.02), (reach, 0.0, 0.0), (0.0, 0.0, 1.0), 0.3)
        setup = GripSetup(gripper(), below, elements=40)
    else:
        setup, _ = laid(*gravity)
    closing = close_on(setup, PressureCourse((0.0, rise, 0.2), (0.0, pressure, pressure)))
    assert closing.is_complete
    first = closing.frames[0].state.positions
    for frame in closing.frames:
        assert np.isfinite(frame.velocities).all()
        assert frame.residual <= 1e-4
        assert frame.state.gaps[0, 1:].min() > -1e-6
        assert pressure > 0.0 or np.abs(frame.state.positions - first).max() < 1e-8
    assert pressure > 0.0 or (closing.settling_time, closing.time_to_wrap) == (0.0, None)


@pytest.mark.slow
def test_a_tube_that_strikes_with_many_nodes_goes_on():
    """Contact forces reach 500 times the scale of forces; steps were not solved from 0.267 s on."""
    frames = list(islice(closing_frames(*random_closing(320)), 58))
    assert frames[-1].time > 0.29
