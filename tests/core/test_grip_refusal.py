# SPDX-License-Identifier: Apache-2.0
"""What a refusal says of its cause."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

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
from spiral_core.grip.places import find_place, held_radii, what_helps
from spiral_gripper import load_gripper

pytestmark = pytest.mark.long


def rough(closing: Closing) -> GripSetup:
    """Return a thick-walled gripper whose tube friction stops before it is wrapped."""
    tube = Tube(inner_radius=4e-3, wall_thickness=1.2e-3, length=0.42)
    actuator = Actuator(tube, FiberAngles(np.radians(87.0), np.radians(65.0)), NeoHookean(190e3))
    gripper = gripper_from_actuator("thick", actuator, density=1100.0, pressure_max=200e3)
    return lay_into_coil(gripper, 0.025, friction=0.5, closing=closing)


def test_a_refusal_says_that_friction_is_the_cause() -> None:
    with pytest.raises(NotGrippableError, match="friction holds the tube back"):
        solve_grip(rough(Closing.SLOW))
    solve_grip(rough(Closing.FRICTIONLESS), (), pressures=())
    thin = replace(rough(Closing.SLOW), closing=Closing.FRICTIONLESS)
    aside = replace(thin, obstacle=thin.obstacle.moved(translation=(0.0, 0.15, 0.0)))
    with pytest.raises(NotGrippableError) as error:
        solve_grip(aside)
    assert "friction" not in str(error.value)


def windows_that_hold(
    monkeypatch: pytest.MonkeyPatch, ranges: list[tuple[float, float]]
) -> list[float]:
    """Let grips on radii within the ranges be wrapped; return the list of those that are tried."""
    tried: list[float] = []

    def window(setup: GripSetup, **_: object) -> SimpleNamespace:
        radius = setup.obstacle.shape.feature_radius
        tried.append(radius)
        if not any(low <= radius <= high for low, high in ranges):
            raise NotGrippableError(radius, "nothing is", -1.0, None)
        return SimpleNamespace(onset_wrap=5e4)

    monkeypatch.setattr(places, "grip_window", window)
    return tried


@pytest.mark.parametrize(
    "ranges",
    [
        [(0.0, 1.0)],
        [(0.0, 0.021)],
        [(0.0123, 0.0217)],
        [(0.0, 0.0117), (0.0203, 0.0261)],
        [(0.0131, 0.0177), (0.0222, 1.0)],
    ],
)
def test_the_radii_that_are_held_end_where_contact_ends(
    monkeypatch: pytest.MonkeyPatch, ranges: list[tuple[float, float]]
) -> None:
    """Every end is held, and next to it, by a percent, is what is not held or was not tried."""
    tried = windows_that_hold(monkeypatch, ranges)
    found = held_radii(load_gripper("paper_design_70"))
    least, most = min(tried), max(tried)
    assert len(found) == len(ranges)
    for (low, high), (begin, end) in zip(found, ranges, strict=True):
        assert max(begin, least) <= low <= max(1.01 * begin, least)
        assert min(end / 1.01, most) <= high <= min(end, most)
    assert len(tried) < 60


def test_no_radius_is_tried_that_a_closed_coil_has_no_hole_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    gripper = replace(load_gripper("paper_design_70"), pressure_max=200e3)
    tried = windows_that_hold(monkeypatch, [])
    assert held_radii(gripper) == ()
    assert min(tried) == 0.1 * gripper.tube.outer_radius > 10.0 * WrapCurve(gripper).radius_min
    assert max(tried) == WrapCurve(gripper).radius_max


LEANING = (-0.719 * 9.81, 0.678 * 9.81, 0.152 * 9.81)


# Where the tip touches, of those that are tried near a coil of prototype_p1.
BEST_PLACE = (0.34, 0.03, -0.04)


@pytest.fixture
def holding(monkeypatch: pytest.MonkeyPatch) -> tuple[list[GripSetup], list[GripSetup]]:
    """Setups that are closed, and those among them that are to be held: fill the second."""
    closed: list[GripSetup] = []
    held: list[GripSetup] = []

    def window(setup: GripSetup, **_: object) -> SimpleNamespace:
        closed.append(setup)
        there = np.linalg.norm(np.subtract(setup.obstacle.position, BEST_PLACE))
        point = SimpleNamespace(tip_gap=there, contact_length=0.0)
        return SimpleNamespace(onset_wrap=5e4 if setup in held else None, points=(point,))

    monkeypatch.setattr(places, "grip_window", window)
    return closed, held


@pytest.mark.parametrize("axis", [None, (1.0, 0.0, 0.0)])
def test_places_near_the_coil_are_tried_the_nearest_first_then_around_the_best(
    holding: tuple[list[GripSetup], list[GripSetup]], axis: tuple[float, float, float] | None
) -> None:
    setup = lay_into_coil(replace(load_gripper("prototype_p1"), object_axis=axis), 0.0165)
    closed, held = holding
    assert find_place(setup) is None
    assert closed[0] is setup
    assert len(closed) == 40
    shifts = [np.subtract(one.obstacle.position, setup.obstacle.position) for one in closed]
    missed = [np.linalg.norm(np.subtract(one.obstacle.position, BEST_PLACE)) for one in closed]
    assert np.mean(missed[-13:]) < 0.5 * np.mean(missed[1:17])
    assert min(missed) < 0.5 * min(missed[:17])
    assert np.linalg.matrix_rank(shifts) == 3
    reach = 1.5 * (0.0165 + setup.gripper.tube.outer_radius)
    assert 0.6 * reach < np.abs(shifts).max() <= np.sqrt(3.0) * reach
    tilts = [np.arccos(min(1.0, one.axis @ setup.axis)) for one in closed]
    if axis is None:
        assert np.radians(5.0) < max(tilts) <= np.radians(14.2)
        assert np.linalg.norm(shifts[1]) < np.linalg.norm(shifts[16])
    else:
        assert max(tilts) < 1e-7
    places = closed.copy()
    held += [places[9], places[7]]
    assert find_place(setup) == places[7]
    held.append(setup)
    assert find_place(setup) is setup


def test_a_roll_helps_before_another_direction_does(
    holding: tuple[list[GripSetup], list[GripSetup]],
) -> None:
    gripper = replace(load_gripper("prototype_p1"), gravity=LEANING, object_axis=(0.0, 0.0, 1.0))
    setup = lay_into_coil(gripper, 0.0165)
    closed, held = holding
    assert "nor would" in what_helps(setup)
    *rolled, fitted = closed
    assert fitted.gripper == replace(gripper, object_axis=None)
    # The base rolled by 90 degrees about x: what lay along z lies along its y.
    x, y, z = LEANING
    assert np.allclose(rolled[1].gripper.gravity, (x, z, -y))
    assert np.allclose(rolled[1].gripper.object_axis or (), (0.0, 1.0, 0.0))
    held.append(fitted)
    assert "along the direction that fits the coil" in what_helps(setup)
    held.append(rolled[1])
    assert "rolled by 90 deg" in what_helps(setup)


@pytest.mark.slow
def test_an_object_that_is_held_elsewhere_is_found_there() -> None:
    setup = lay_into_coil(replace(load_gripper("prototype_p1"), gravity=LEANING), 0.0165)
    assert grip_window(setup).onset_wrap is None
    found = find_place(setup)
    assert found is not None
    assert grip_window(found).onset_wrap is not None
