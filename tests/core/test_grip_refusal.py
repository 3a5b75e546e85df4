# SPDX-License-Identifier: Apache-2.0
"""What a refusal says of its cause, and what would be held instead."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.linalg import norm

from spiral_core import (
    Actuator,
    Closing,
    FiberAngles,
    GripSetup,
    NeoHookean,
    NotGrippableError,
    Tube,
    WrapCurve,
    grip_window,
    gripper_from_actuator,
    lay_into_coil,
    solve_grip,
)
from spiral_core.grip import places
from spiral_core.grip.places import find_place, held_radii, nearest_held_radius, what_helps
from spiral_core.grip.window import WindowEnd
from spiral_gripper import load_gripper

pytestmark = pytest.mark.long


def rough(closing=Closing.SLOW):
    """Return a thick-walled gripper whose tube friction stops before it is wrapped."""
    tube = Tube(inner_radius=4e-3, wall_thickness=1.2e-3, length=0.42)
    actuator = Actuator(tube, FiberAngles(np.radians(87.0), np.radians(65.0)), NeoHookean(190e3))
    gripper = gripper_from_actuator("thick", actuator, density=1100.0, pressure_max=200e3)
    return lay_into_coil(gripper, 0.025, friction=0.5, closing=closing)


def aside():
    """Return an object next to which the coil closes."""
    setup = lay_into_coil(load_gripper("paper_design_70"), 0.025, closing=Closing.FRICTIONLESS)
    return replace(setup, obstacle=setup.obstacle.moved((0.0, 0.2, 0.0)))


def weak():
    gripper = replace(load_gripper("paper_design_70"), pressure_max=45e3)
    return replace(aside(), gripper=gripper, tip_pressure=None)


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (rough, "never with more than a tenth of the tube.*friction holds the tube back"),
        (aside, "passes the object by"),
        (weak, "does not touch up to the pressure limit"),
        (lambda: lay_into_coil(load_gripper("paper_design_70"), 0.06), "too thick"),
    ],
)
def test_a_refusal_says_its_cause(make, reason):
    with pytest.raises(NotGrippableError, match=reason) as refusal:
        solve_grip(make())
    assert ("friction" in str(refusal.value)) == ("friction" in reason)
    assert refusal.value.margin <= 0.0


def test_what_friction_holds_back_is_held_without():
    assert solve_grip(rough(Closing.FRICTIONLESS), (), pressures=()).onset_wrap > 0.0


def test_an_object_that_the_tip_passes_by_is_given_up():
    """No need to go to the pressure limit."""
    window = grip_window(aside())
    assert window.end is WindowEnd.PASSED_BY
    tip = window.setup.tip_pressure
    assert 1.6 * tip <= window.top < 1.75 * tip < window.setup.gripper.pressure_max


@pytest.mark.parametrize(
    "ranges",
    [
        [(0.0, 0.021)],
        [(0.0131, 0.0177), (0.0222, 1.0)],
        [],
    ],
)
def test_the_radii_that_are_held_end_where_contact_ends(monkeypatch, ranges):
    """Every end is held, and next to it, by a percent, is what is not held or was not tried.

    None is tried that a closed coil has no hole for.
    """
    gripper = replace(load_gripper("paper_design_70"), pressure_max=200e3)
    tried: list[float] = []

    def window(setup, **_):
        """Let grips on radii within the ranges be wrapped."""
        radius = setup.obstacle.shape.feature_radius
        tried.append(radius)
        if not any(low <= radius <= high for low, high in ranges):
            raise NotGrippableError(radius, "nothing is", -1.0, None)
        return SimpleNamespace(onset_wrap=5e4)

    monkeypatch.setattr(places, "grip_window", window)
    found = held_radii(gripper)
    least, most = min(tried), max(tried)
    assert least == 0.1 * gripper.tube.outer_radius > 10.0 * WrapCurve(gripper).radius_min
    assert most == WrapCurve(gripper).radius_max
    assert len(found) == len(ranges)
    for (low, high), (begin, end) in zip(found, ranges, strict=True):
        assert max(begin, least) <= low <= max(1.01 * begin, least)
        assert min(end / 1.01, most) <= high <= min(end, most)
    assert len(tried) < 60
    for radius in (0.0185, 0.0198, 0.0215):
        nearest = nearest_held_radius(lay_into_coil(gripper, radius))
        ends = [end for pair in ranges for end in pair]
        exact = min(ends, key=lambda end: abs(end - radius), default=None)
        if any(low <= radius <= high for low, high in ranges):
            continue  # held itself
        assert nearest == (exact and pytest.approx(exact, rel=0.01))
        assert nearest is None or any(low <= nearest <= high for low, high in ranges)


LEANING = (-0.719 * 9.81, 0.678 * 9.81, 0.152 * 9.81)


# Where the tip touches, of those that are tried near a coil of prototype_p1.
BEST_PLACE = (0.34, 0.03, -0.04)


@pytest.fixture
def holding(monkeypatch):
    """Setups that are closed, and those among them that are to be held: fill the second."""
    closed: list[GripSetup] = []
    held: list[GripSetup] = []

    def window(setup, **_):
        closed.append(setup)
        there = norm(np.subtract(setup.obstacle.position, BEST_PLACE))
        point = SimpleNamespace(tip_gap=there, contact_length=0.0)
        onset = 5e4 if setup in held else None
        return SimpleNamespace(setup=setup, onset_wrap=onset, points=(point,))

    monkeypatch.setattr(places, "grip_window", window)
    return closed, held


@pytest.mark.parametrize("axis", [None, (1.0, 0.0, 0.0)])
def test_places_near_the_coil_are_tried_the_nearest_first_then_around_the_best(holding, axis):
    setup = lay_into_coil(replace(load_gripper("prototype_p1"), object_axis=axis), 0.0165)
    closed, held = holding
    assert find_place(setup) is None
    assert closed[0] is setup
    assert len(closed) == 40
    tried = np.array([one.obstacle.position for one in closed])
    shifts, missed = tried - tried[0], norm(tried - BEST_PLACE, axis=1)
    assert np.mean(missed[-13:]) < 0.5 * np.mean(missed[1:17])
    assert np.linalg.matrix_rank(shifts) == 3
    reach = 1.5 * (0.0165 + setup.gripper.tube.outer_radius)
    assert 0.6 * reach < np.abs(shifts).max() <= np.sqrt(3.0) * reach
    assert axis or norm(shifts[1]) < norm(shifts[16])
    tilt = max(np.arccos(min(1.0, one.axis @ setup.axis)) for one in closed)
    low, high = (0.0, 1e-7) if axis else np.radians((5.0, 14.2))
    assert low <= tilt <= high
    tenth, eighth = closed[9], closed[7]
    held += [tenth, eighth]
    assert find_place(setup) == eighth
    held.append(setup)
    assert find_place(setup) is setup


def test_a_roll_helps_before_another_direction_does(holding):
    gripper = replace(load_gripper("prototype_p1"), gravity=LEANING, object_axis=(0.0, 0.0, 1.0))
    setup = lay_into_coil(gripper, 0.0165)
    closed, held = holding
    assert "nor would" in what_helps(setup)
    *rolled, fitted = closed
    assert fitted.gripper == replace(gripper, object_axis=None)
    # The base rolled by 90 degrees about x: what lay along z lies along its y.
    x, y, z = LEANING
    assert rolled[1].gripper.gravity == pytest.approx((x, z, -y))
    assert rolled[1].gripper.object_axis == pytest.approx((0.0, 1.0, 0.0))
    held.append(fitted)
    assert "along the direction that fits the coil" in what_helps(setup)
    held.append(rolled[1])
    assert "rolled by 90 deg" in what_helps(setup)


@pytest.mark.slow
def test_an_object_that_is_held_elsewhere_is_found_there():
    setup = lay_into_coil(replace(load_gripper("prototype_p1"), gravity=LEANING), 0.0165)
    assert grip_window(setup).onset_wrap is None
    assert grip_window(find_place(setup)).onset_wrap is not None
