# SPDX-License-Identifier: Apache-2.0
"""What a refusal says of its cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from spiral_core import (
    Actuator,
    Closing,
    FiberAngles,
    GripSetup,
    GripWindow,
    NeoHookean,
    NotGrippableError,
    Tube,
    WrapCurve,
    grip_window,
    gripper_from_actuator,
    lay_into_coil,
    solve_grip,
)
from spiral_core.grip import refusal
from spiral_core.grip.refusal import held_radii
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


def test_the_radii_that_are_held_end_where_contact_ends() -> None:
    gripper = replace(load_gripper("prototype_p1"), pressure_max=50e3)
    ((low, high),), curve = held_radii(gripper), WrapCurve(gripper)
    assert low == curve.radius_min
    assert 1.02 * low < high < 0.6 * curve.radius_max
    for radius, held in (
        (low, True),
        (0.5 * (low + high), True),
        (high, True),
        (1.01 * high, False),
    ):
        assert (grip_window(lay_into_coil(gripper, radius)).onset_wrap is not None) is held


def test_no_radius_is_tried_that_a_closed_coil_has_no_hole_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    gripper = replace(load_gripper("paper_design_70"), pressure_max=200e3)
    tried: list[float] = []

    def fail(setup: GripSetup, **_: object) -> GripWindow:
        tried.append(setup.obstacle.shape.feature_radius)
        raise NotGrippableError(tried[-1], "nothing is", -1.0, None)

    monkeypatch.setattr(refusal, "grip_window", fail)
    assert held_radii(gripper) == ()
    assert min(tried) == 0.1 * gripper.tube.outer_radius > 10.0 * WrapCurve(gripper).radius_min
    assert max(tried) == WrapCurve(gripper).radius_max
