# SPDX-License-Identifier: Apache-2.0
"""The coiled range: known axes, every sub-branch, snaps, and that each refusal is true."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from core.gripper_cases import linear_gripper, paper_gripper

from spiral_core import (
    MeasuredActuation,
    NoCoilError,
    NotGrippableError,
    WrapCurve,
    solve_rod,
)
from spiral_core.wrap.coil import coil_from_state
from spiral_core.wrap.curve import RADIUS_TOLERANCE
from spiral_core.wrap.scan import PressureScan

G = 9.80665
AXIS = (1.0, 0.0, 0.0)
TILTED = (G / math.sqrt(1.25), 0.5 * G / math.sqrt(1.25), 0.0)
OUTER_RADIUS = 4.7625e-3 + 0.79375e-3


@pytest.fixture(scope="module")
def known() -> WrapCurve:
    """Return the curve of a tilted gripper whose object's direction is known."""
    return WrapCurve(paper_gripper("P1", TILTED, AXIS))


def test_every_radius_about_a_known_axis_is_answered(known: WrapCurve) -> None:
    for radius in np.linspace(known.radius_min, known.radius_max, 200).tolist():
        wrap = known.wrap_for_radius(radius)
        contact = radius + OUTER_RADIUS
        assert abs(wrap.object_radius - radius) <= 2.0 * RADIUS_TOLERANCE * contact
        assert wrap.turns >= 1.05 - 1e-6
        assert wrap.state.stable


def test_of_several_pressures_the_lowest_is_taken(known: WrapCurve) -> None:
    pressures = np.linspace(known.pressure_min, known.pressure_max, 400)
    wraps = [known.wrap_at_pressure(float(p)) for p in pressures]
    coiled = [w.turns > 1.051 and w.object_radius > 1e-4 for w in wraps]
    radii = [w.object_radius for w in wraps]
    for radius in (0.008, 0.012, 0.018, 0.025, 0.035):
        first = next(
            i
            for i in range(len(wraps) - 1)
            if coiled[i]
            and coiled[i + 1]
            and min(radii[i : i + 2]) <= radius <= max(radii[i : i + 2])
        )
        found = known.pressure_from_radius(radius)
        assert pressures[first] <= found <= pressures[first + 1]


def test_a_short_part_of_the_range_before_a_leap_of_the_turns_is_found() -> None:
    # Near 21.25 kPa the tangent of the coil's last turn comes so near to the axis that a part of
    # that turn no longer counts: some 200 Pa of valid wraps lie below, between two samples.
    gravity = (-6.767843461129852, -4.813767935064768, -5.214817098948359)
    curve = WrapCurve(paper_gripper("P2", gravity))
    pressures = np.linspace(20.9e3, 21.3e3, 161).tolist()
    wraps = [curve.wrap_at_pressure(pressure) for pressure in pressures]
    island = [wrap for wrap in wraps if wrap.turns >= 1.05 + 1e-4]
    assert 10 < len(island) < 100
    for wrap in island:
        assert curve.is_coiled(wrap.pressure)
        assert curve.pressure_from_radius(wrap.object_radius) <= wrap.pressure * (1.0 + 1e-7)
    for wrap in wraps:
        assert wrap.turns >= 1.05 - 1e-4 or not curve.is_coiled(wrap.pressure)


def test_a_tangent_that_turns_back_at_the_least_sine_grazes_it() -> None:
    curve = WrapCurve(paper_gripper("P2"))
    wrap = curve.wrap_at_pressure(30.0e3)
    sines = np.linalg.norm(np.cross(wrap.state.tangents, wrap.axis), axis=1)
    above = sines - 0.5 * sines[-1]
    places = [i for i in range(1, len(sines) - 1) if sines[i] <= min(sines[i - 1], sines[i + 1])]
    assert wrap.turn_count_margin == pytest.approx(
        min((above[i] for i in places), key=abs), abs=1e-9
    )
    assert abs(wrap.turn_count_margin) < 0.3
    rising = replace(wrap, axis=(0.0, 0.0, 1.0), state=curve.state_at_pressure(0.0))
    assert rising.turn_count_margin == math.inf or rising.turn_count_margin > 0.0


def test_a_radius_that_turns_back_next_to_the_limit_is_seen() -> None:
    axis = (-0.016933259856470175, -0.01774736315593301, 0.9996991026362106)
    gripper = paper_gripper("P2", (0.0, 0.0, G), axis)
    whole = WrapCurve(gripper)
    pressures = np.linspace(0.9 * whole.pressure_max, whole.pressure_max, 500)
    radii = np.array([whole.wrap_at_pressure(float(p)).object_radius for p in pressures])
    (turning, *_) = (i for i in range(1, 499) if radii[i - 1] > radii[i] < radii[i + 1])
    # A limit past the extreme by less than a sample's distance.
    curve = WrapCurve(replace(gripper, pressure_max=1.001 * float(pressures[turning])))
    assert curve.radius_min <= (1.0 + 1e-4) * radii[turning]  # other elements
    assert curve.pressure_from_radius(curve.radius_min) < 0.9999 * curve.gripper.pressure_max


def test_the_axis_that_a_coil_takes_is_a_good_axis_for_it() -> None:
    fitted = WrapCurve(paper_gripper("70 degrees")).wrap_for_radius(0.02)
    along = WrapCurve(paper_gripper("70 degrees", object_axis=fitted.axis)).wrap_for_radius(0.02)
    assert along.pressure <= fitted.pressure * (1.0 + 1e-6)
    assert along.object_radius == pytest.approx(0.02, rel=1e-7)


def test_gaps_of_the_range_are_refused_with_their_reason(known: WrapCurve) -> None:
    gap = np.linspace(known.pressure_min, known.pressure_max, 400)
    outside = next(p for p in gap.tolist() if not known.is_coiled(p))
    with pytest.raises(NoCoilError):
        known.radius_from_pressure(outside)


def test_a_tube_that_snaps_is_answered_on_both_sides() -> None:
    curve = WrapCurve(paper_gripper("P2", (-0.1187 * G, -0.4911 * G, 0.863 * G)))
    (snap,) = curve.snap_pressures
    assert curve.pressure_min < snap < curve.pressure_max
    for pressure in (0.999 * snap, 1.0001 * snap, 1.001 * snap):
        wrap = curve.wrap_at_pressure(pressure)
        found = curve.wrap_for_radius(wrap.object_radius)
        assert found.object_radius == pytest.approx(wrap.object_radius, rel=1e-7)
    before, after = (curve.state_at_pressure(f * snap).tip_position for f in (0.999, 1.001))
    assert np.linalg.norm(after - before) > 0.02


def test_the_reason_is_what_ends_the_range() -> None:
    closing = WrapCurve(linear_gripper(curvature=250.0, torsion=-30.0))
    limited = WrapCurve(linear_gripper())
    for curve, radius, reason in (
        (closing, 1e-6, "the coil closes on itself"),
        (limited, 1e-3, "pressure limit of 100000 Pa"),
        (limited, 1.0, "1.05 turns of this length"),
    ):
        with pytest.raises(NotGrippableError, match=reason) as caught:
            curve.wrap_for_radius(radius)
        assert caught.value.margin < 0.0
        printed = re.search(r"nearest grippable radius is (\S+) m", str(caught.value))
        assert printed is not None
        curve.wrap_for_radius(float(printed[1]))


def test_the_thinnest_radii_in_range_are_answered() -> None:
    curve = WrapCurve(linear_gripper(curvature=250.0, torsion=-30.0, weight=0.24))
    for radius in np.linspace(curve.radius_min, 2e-5, 25).tolist():
        assert curve.wrap_for_radius(radius).object_radius == pytest.approx(radius, abs=1e-10)


def test_turns_that_leave_no_room_are_not_called_too_few() -> None:
    with pytest.raises(NoCoilError) as caught:
        WrapCurve(linear_gripper(curvature=250.0, torsion=-30.0, turns_required=18.0))
    rate = math.hypot(250.0, 30.0)
    closes = 1.0e5 * 250.0 / rate**2 / OUTER_RADIUS
    assert caught.value.turns < 18.0
    # Between the samples of the range, 1 % of it apart.
    assert caught.value.closes_at == pytest.approx(closes, rel=0.02)
    assert caught.value.turns == pytest.approx(0.5 * rate * closes / 1e5 / 2 / math.pi, rel=0.02)


def test_a_coil_that_opens_again_is_not_called_closed_from_there_on() -> None:
    gripper = paper_gripper("P2", (0.0, G, 0.0), AXIS)
    with pytest.raises(NoCoilError) as caught:
        WrapCurve(gripper)
    error, scan = caught.value, PressureScan(gripper)
    assert error.closes_at < error.pressure
    assert not scan.wrap_at(error.closes_at).object_radius > 1e-3 * OUTER_RADIUS
    assert scan.wrap_at(error.pressure).object_radius > 1e-3 * OUTER_RADIUS
    assert f"; at {error.closes_at:.6g} Pa the coil has closed on itself;" in str(error)


def measured(curvatures: tuple[float, ...], torsions: tuple[float, ...]) -> WrapCurve:
    """Return the curve of a gripper whose actuation is given at even pressures to 100 kPa."""
    pressures = tuple(np.linspace(0.0, 1.0e5, len(curvatures)).tolist())
    actuation = MeasuredActuation(pressures, curvatures, torsions, 0.5)
    return WrapCurve(
        replace(linear_gripper(weight=0.24, gravity=(G, 0.0, 0.0)), actuation=actuation)
    )


def test_a_gripper_that_twists_before_it_bends_is_answered() -> None:
    curve = measured((0.0, 0.0, 10.0, 30.0, 50.0), (0.0, -10.0, -15.0, -20.0, -20.0))
    assert curve.wrap_for_radius(0.02).object_radius == pytest.approx(0.02, rel=1e-7)
    straight = curve.wrap_at_pressure(1.0e4)
    assert straight.object_radius == math.inf
    assert straight.state.stable


def test_pressures_that_change_nothing_are_stepped_over() -> None:
    curve = measured(
        (0.0, 0.0, 20.0, 20.0, 45.0, 50.0, 50.0), (0.0, 0.0, -9.0, -9.0, -18.0, -20.0, -20.0)
    )
    for radius in np.linspace(curve.radius_min, curve.radius_max, 30).tolist():
        assert curve.wrap_for_radius(radius).object_radius == pytest.approx(radius, rel=1e-7)
    with pytest.raises(NoCoilError, match="no pressure up to 100000 Pa bends the gripper"):
        measured((0.0, 0.0, 0.0), (0.0, -5.0, -9.0))


def test_a_coil_that_is_closed_from_the_first_is_not_called_short_of_turns() -> None:
    """A fiber wound so steeply that its helix is narrower than the tube."""
    with pytest.raises(NoCoilError, match="no pressure up to 100000 Pa leaves room") as caught:
        measured((0.0, 15.0, 30.0), (-350.0, -340.0, -330.0))
    assert caught.value.turns == 0.0


@pytest.mark.parametrize("pressure", [1e-300, 1e-12, 1e-3])
def test_almost_no_pressure_wraps_nothing(pressure: float) -> None:
    wrap = WrapCurve(paper_gripper("P2")).wrap_at_pressure(pressure)
    assert not math.isnan(wrap.object_radius)
    assert wrap.turns < 0.5


def test_turns_about_an_axis_near_the_tangents_do_not_depend_on_the_elements() -> None:
    """Where a tangent passes close to the axis its azimuth turns fast, within an element too."""
    curve = WrapCurve(paper_gripper("P2", object_axis=(-0.34407862, -0.69744658, 0.62863198)))
    wrap = curve.wrap_at_pressure(103_972.9)
    shape, gripper = wrap.unloaded_shape, curve.gripper
    fine = solve_rod(gripper.rod(shape), gripper.load(shape), elements=2000, start=wrap.state)
    assert wrap.turns == pytest.approx(coil_from_state(fine, wrap.axis).total_turns, abs=5e-3)
