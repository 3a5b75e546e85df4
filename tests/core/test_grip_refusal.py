# SPDX-License-Identifier: Apache-2.0
"""What a refusal says of its cause, and what would be held instead."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from core.actuator_cases import actuator
from numpy.linalg import norm
from numpy.testing import assert_allclose

from spiral_core import (
    Closing,
    NeoHookean,
    NotGrippableError,
    PressureLaw,
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
PAPER, PROTOTYPE = load_gripper("paper_design_70"), load_gripper("prototype_p1")


def rough(closing=Closing.SLOW):
    """Return a thick-walled gripper whose tube friction stops before it is wrapped."""
    tube, law = Tube(4e-3, 1.2e-3, 0.42), PressureLaw.SECTION
    thick = actuator(87.0, 65.0, NeoHookean(190e3), tube=tube, pressure_law=law)
    gripper = gripper_from_actuator("thick", thick, density=1100.0, pressure_max=200e3)
    return lay_into_coil(gripper, 0.025, friction=0.5, closing=closing)


def aside():
    """Return an object next to which the coil closes."""
    setup = lay_into_coil(PAPER, 0.025, closing=Closing.FRICTIONLESS)
    return replace(setup, obstacle=setup.obstacle.moved((0.0, 0.2, 0.0)))


def weak():
    return replace(aside(), gripper=replace(PAPER, pressure_max=45e3), tip_pressure=None)


def test_a_refusal_says_its_cause():
    for make, reason in [
        (rough, "never with more than a tenth of the tube.*friction holds the tube back"),
        (aside, "passes the object by"),
        (weak, "does not touch up to the pressure limit"),
        (lambda: lay_into_coil(PAPER, 0.06), "too thick"),
    ]:
        with pytest.raises(NotGrippableError, match=reason) as refusal:
            solve_grip(make())
        assert ("friction" in str(refusal.value)) == ("friction" in reason)
        assert refusal.value.margin <= 0.0
        if make is rough:
            assert solve_grip(rough(Closing.FRICTIONLESS), (), pressures=()).onset_wrap > 0.0


def test_an_object_that_the_tip_passes_by_is_given_up():
    """No need to go to the pressure limit."""
    window = grip_window(aside())
    assert window.end is WindowEnd.PASSED_BY
    tip = window.setup.tip_pressure
    assert 1.6 * tip <= window.top < 1.75 * tip < window.setup.gripper.pressure_max


@pytest.mark.parametrize("ranges", [[(0.0, 0.021)], [(0.0131, 0.0177), (0.0222, 1.0)], []])
def test_the_radii_that_are_held_end_where_contact_ends(monkeypatch, ranges):
    """Every end is held, and next to it, by a percent, is what is not held or was not tried.

    None is tried that a closed coil has no hole for.
    """
    gripper, tried = replace(PAPER, pressure_max=200e3), []

    def is_held(radius):
        return any(low <= radius <= high for low, high in ranges)

    def window(setup, **_):
        tried.append(setup.obstacle.shape.feature_radius)
        if not is_held(tried[-1]):
            raise NotGrippableError(tried[-1], "nothing is", -1.0, None)
        return SimpleNamespace(onset_wrap=5e4)

    monkeypatch.setattr(places, "grip_window", window)
    found, curve = np.array(held_radii(gripper)), WrapCurve(gripper)
    least, most = min(tried), max(tried)
    assert least == 0.1 * gripper.tube.outer_radius > 10.0 * curve.radius_min
    assert (most, len(tried) < 60) == (curve.radius_max, True)
    ends = np.clip(np.array(ranges), least, most)
    assert all(map(is_held, found.flat))
    assert_allclose(found, ends, 0.01)
    for radius in (0.0185, 0.0198, 0.0215):
        if not is_held(radius):
            nearest = nearest_held_radius(lay_into_coil(gripper, radius))
            exact = min(np.ravel(ranges), key=lambda end: abs(end - radius), default=None)
            assert nearest == (exact and pytest.approx(exact, rel=0.01))
            assert nearest is None or is_held(nearest)


LEANING = (-0.719 * 9.81, 0.678 * 9.81, 0.152 * 9.81)


# Where the tip touches, of those that are tried near a coil of prototype_p1.
BEST_PLACE = (0.34, 0.03, -0.04)


@pytest.fixture
def holding(monkeypatch):
    """Setups that are closed, and those among them that are to be held: fill the second."""
    closed, held = [], []

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
    setup = lay_into_coil(replace(PROTOTYPE, object_axis=axis), 0.0165)
    closed, held = holding
    assert find_place(setup) is None
    assert closed[0] is setup
    shifts = np.array([one.obstacle.position for one in closed]) - setup.obstacle.position
    missed = norm(shifts + setup.obstacle.position - BEST_PLACE, axis=1)
    assert np.mean(missed[-13:]) < 0.5 * np.mean(missed[1:17])
    assert np.linalg.matrix_rank(shifts) == 3
    reach = 1.5 * (0.0165 + setup.gripper.tube.outer_radius)
    assert 0.6 * reach < np.abs(shifts).max() <= np.sqrt(3.0) * reach
    tilt = max(np.arccos(min(1.0, one.axis @ setup.axis)) for one in closed)
    low, high = (0.0, 1e-7) if axis else np.radians((5.0, 14.2))
    assert low <= tilt <= high
    held += closed[9], closed[7]
    assert find_place(setup) == held[1]


def test_a_roll_helps_before_another_direction_does(holding):
    gripper = PROTOTYPE.with_mount(LEANING, (0.0, 0.0, 1.0))
    setup = lay_into_coil(gripper, 0.0165)
    closed, held = holding
    assert "nor would" in what_helps(setup)
    *rolled, fitted = closed
    assert fitted.gripper == replace(gripper, object_axis=None)
    # The base rolled by 90 degrees about x: what lay along z lies along its y.
    x, y, z = LEANING
    mount = rolled[1].gripper.gravity, rolled[1].gripper.object_axis
    assert_allclose(np.ravel(mount), (x, z, -y, 0.0, 1.0, 0.0), atol=1e-12)
    held.append(fitted)
    assert "along the direction that fits the coil" in what_helps(setup)
    held.append(rolled[1])
    assert "rolled by 90 deg" in what_helps(setup)


@pytest.mark.slow
def test_an_object_that_is_held_elsewhere_is_found_there():
    setup = lay_into_coil(PROTOTYPE.with_mount(LEANING, None), 0.0165)
    assert grip_window(setup).onset_wrap is None
    assert grip_window(find_place(setup)).onset_wrap is not None
