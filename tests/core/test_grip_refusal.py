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
    NeoHookean,
    NotGrippableError,
    Tube,
    gripper_from_actuator,
    lay_into_coil,
    solve_grip,
)

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
