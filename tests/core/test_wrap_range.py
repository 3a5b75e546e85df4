# SPDX-License-Identifier: Apache-2.0
"""The coiled range: known axes, every sub-branch, snaps, true refusals; its table of guesses."""

import re
from dataclasses import replace
from functools import partial
from math import hypot, inf, isnan, pi
from types import SimpleNamespace

import numpy as np
import pytest
from core.gripper_cases import linear_gripper, paper_gripper
from core.recorded import recorded, said
from core.wrap_cases import OUTER_RADIUS, TILTED, G, linear_curve, paper_curve
from numpy.linalg import norm
from numpy.testing import assert_allclose

from spiral_core import MeasuredActuation, NoCoilError, NotGrippableError, WrapCurve, solve_rod
from spiral_core.wrap.branch import BranchEnd, SubBranch
from spiral_core.wrap.coil import coil_from_state
from spiral_core.wrap.scan import PressureScan

AXIS = (1.0, 0.0, 0.0)
# Its coil closes on itself at this share of its pressure.
CLOSING = {"curvature": 250.0, "torsion": -30.0}
SHARE = 250.0 / (250.0**2 + 30.0**2) / OUTER_RADIUS


def test_of_several_pressures_the_lowest_is_taken_and_gaps_have_none():
    curve = paper_curve("P1", TILTED, AXIS)
    pressures = np.linspace(curve.pressure_min, curve.pressure_max, 400)
    wraps = [curve.wrap_at_pressure(pressure) for pressure in pressures]
    coiled = np.array([wrap.turns > 1.051 and wrap.object_radius > 1e-4 for wrap in wraps])
    radii = np.array([wrap.object_radius for wrap in wraps])
    for radius in (0.008, 0.012, 0.018, 0.025, 0.035):
        passed = (radii[:-1] - radius) * (radii[1:] - radius) <= 0.0
        first = int(np.argmax(passed & coiled[:-1] & coiled[1:]))
        assert pressures[first] <= curve.pressure_from_radius(radius) <= pressures[first + 1]
    with pytest.raises(NoCoilError):
        curve.radius_from_pressure(next(p for p in pressures if not curve.is_coiled(p)))


def test_a_short_part_of_the_range_before_a_leap_of_the_turns_is_found():
    # Near 21.25 kPa the tangent of the coil's last turn comes so near to the axis that a part of
    # that turn no longer counts: some 200 Pa of valid wraps lie below, between two samples.
    gravity = (-6.767843461129852, -4.813767935064768, -5.214817098948359)
    curve, island = paper_curve("P2", gravity), 0
    for pressure in np.linspace(20.9e3, 21.3e3, 161):
        wrap = curve.wrap_at_pressure(pressure)
        assert wrap.turns >= 1.05 - 1e-4 or not curve.is_coiled(pressure)
        if wrap.turns >= 1.05 + 1e-4:
            island += 1
            assert curve.is_coiled(pressure)
            assert curve.pressure_from_radius(wrap.object_radius) <= pressure * (1.0 + 1e-7)
    assert 10 < island < 100


def test_a_tangent_that_turns_back_at_the_least_sine_grazes_it():
    wrap = paper_curve().wrap_at_pressure(30.0e3)
    sines = norm(np.cross(wrap.state.tangents, wrap.axis), axis=1)
    inner = sines[1:-1]
    above = inner[inner <= np.minimum(sines[:-2], sines[2:])] - 0.5 * sines[-1]
    assert_allclose(wrap.turn_count_margin, min(above, key=abs), 0, 1e-9)


def test_a_radius_that_turns_back_next_to_the_limit_is_seen():
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


def test_a_tube_that_snaps_is_answered_on_both_sides():
    curve = paper_curve("P2", (-0.1187 * G, -0.4911 * G, 0.863 * G))
    (snap,) = curve.snap_pressures
    assert curve.pressure_min < snap < curve.pressure_max
    for factor in (0.999, 1.0001, 1.001):
        radius = curve.wrap_at_pressure(factor * snap).object_radius
        assert_allclose(curve.wrap_for_radius(radius).object_radius, radius, 1e-7)
    before, after = (curve.state_at_pressure(f * snap).tip_position for f in (0.999, 1.001))
    assert norm(after - before) > 0.02


def test_the_nearest_radius_is_named_with_what_ends_the_range():
    for options, end, beyond in [
        (CLOSING, "radius_min", -1e-9),
        ({}, "radius_min", -0.5),
        ({}, "radius_max", 1e-9),
    ]:
        curve = linear_curve(**options)
        nearest = getattr(curve, end)
        with pytest.raises(NotGrippableError) as caught:
            curve.wrap_for_radius(nearest * (1.0 + beyond))
        error = caught.value
        recorded(f"range/{end} {beyond}", [str(error), curve])
        assert error.nearest_radius == nearest
        assert_allclose(error.margin, -abs(error.radius - nearest), 1e-9)
        printed = re.search(r"nearest grippable radius is (\S+) m", str(error))
        curve.wrap_for_radius(float(printed[1]))


def measured(curvatures, torsions):
    """Return the curve of a gripper whose actuation is given at even pressures to 100 kPa."""
    pressures = np.linspace(0.0, 1.0e5, len(curvatures)).tolist()
    actuation = MeasuredActuation(pressures, curvatures, torsions, 0.5)
    heavy = linear_gripper(weight=0.24, gravity=(G, 0.0, 0.0))
    return WrapCurve(replace(heavy, actuation=actuation))


# It twists before it bends, and some pressures change nothing.
STEPS = ((0.0, 0.0, 20.0, 20.0, 45.0, 50.0, 50.0), (0.0, -10.0, -15.0, -15.0, -18.0, -20.0, -20.0))


def test_the_most_turns_with_room_inside_are_named():
    """As it closes on itself: turns that leave no room are not called too few."""
    cases = [
        (partial(linear_curve, length=0.1), 0.1 * hypot(50.0, 20.0), None),
        (
            partial(linear_curve, turns_required=18.0, **CLOSING),
            *(0.5 * SHARE * hypot(250.0, 30.0), 1e5 * SHARE),
        ),
        (partial(measured, (0.0, 0.0, 0.0), (0.0, -5.0, -9.0)), 0.0, None),
        # A fiber wound so steeply that its helix is narrower than the tube.
        (partial(measured, (0.0, 15.0, 30.0), (-350.0, -340.0, -330.0)), 0.0, None),
    ]
    recorded("range/turns", [said(make) for make, *_ in cases])
    for make, turns, closes in cases:
        with pytest.raises(NoCoilError) as caught:
            make()
        # Between the samples of the range, 1 % of it apart.
        rel = 0.02 if closes else 1e-6
        assert_allclose(caught.value.turns, turns / (2.0 * pi), rel)
        assert not turns or caught.value.closes_at == (closes and pytest.approx(closes, rel=rel))


def test_a_coil_that_opens_again_is_not_called_closed_from_there_on():
    gripper = paper_gripper("P2", (0.0, G, 0.0), AXIS)
    with pytest.raises(NoCoilError, match=r"; at .* Pa the coil has closed on itself;") as caught:
        WrapCurve(gripper)
    error, scan = caught.value, PressureScan(gripper)
    closed, opened = (scan.wrap_at(p).object_radius for p in (error.closes_at, error.pressure))
    assert error.closes_at < error.pressure
    assert not closed > 1e-3 * OUTER_RADIUS < opened


def test_the_radii_of_unusual_coils_are_answered():
    for make, most in [
        (partial(measured, *STEPS), 1.0),
        # Nearly closed on itself.
        (partial(linear_curve, weight=0.24, **CLOSING), 2e-5),
        # Eleven turns: the range is sampled as finely as the coil's turning asks for.
        (partial(linear_curve, length=1.3, weight=0.01, gravity=(0.0, G, 0.0)), 0.06),
    ]:
        curve = make()
        for radius in np.linspace(curve.radius_min, min(curve.radius_max, most), 25):
            assert_allclose(curve.wrap_for_radius(radius).object_radius, radius, 1e-7, 1e-10)
        assert most < 1.0 or curve.wrap_at_pressure(1.0e4).object_radius == inf


def test_almost_no_pressure_wraps_nothing():
    for pressure in [1e-300, 1e-12, 1e-3]:
        wrap = paper_curve().wrap_at_pressure(pressure)
        assert not isnan(wrap.object_radius)
        assert wrap.turns < 0.5


def test_turns_about_an_axis_near_the_tangents_do_not_depend_on_the_elements():
    """Where a tangent passes close to the axis its azimuth turns fast, within an element too."""
    curve = paper_curve(axis=(-0.34407862, -0.69744658, 0.62863198))
    wrap = curve.wrap_at_pressure(103_972.9)
    shape, gripper = wrap.unloaded_shape, curve.gripper
    fine = solve_rod(gripper.rod(shape), gripper.load(shape), elements=2000, start=wrap.state)
    assert_allclose(wrap.turns, coil_from_state(fine, wrap.axis).total_turns, 0, 5e-3)


@pytest.mark.parametrize("doubled", [False, True])
def test_guesses_are_near_and_within_their_bracket(doubled):
    """Solved radii scatter by their tolerance, and two wraps may be next to each other."""

    def curvature(pressure):
        """Return a curve like a gripper's: nearly linear, with a ripple from the tip's turning."""
        return 20.0 + 8e-4 * pressure + 1.5 * np.sin(9e-5 * pressure)

    samples = np.linspace(2.0e4, 1.0e5, 30)
    pressures = np.insert(samples, 1, samples[0] * (1.0 + 1e-7)) if doubled else samples
    radii = (1.0 + 1e-9 * (np.arange(len(pressures)) % 2)) / curvature(pressures) - OUTER_RADIUS
    wraps = [
        SimpleNamespace(pressure=p, object_radius=r, outer_radius=OUTER_RADIUS)
        for p, r in zip(pressures, radii, strict=True)
    ]
    branch = SubBranch(tuple(wraps), BranchEnd.TURNS, BranchEnd.CLOSED)
    for pressure in np.linspace(2.001e4, 0.999e5, 211):
        low, high, guess, _ = branch.bracket_and_guess(curvature(pressure))
        assert low <= guess <= high
        # The ripple's period is 25 samples, the ends see it from one side: 8 nodes leave this much.
        assert doubled or guess == pytest.approx(pressure, rel=3e-6)
