# SPDX-License-Identifier: Apache-2.0
"""The winding sheet: the angle that a fiber of this pitch has on the tube's outside."""

from __future__ import annotations

import math

import pytest
from core.actuator_cases import actuator

from spiral_core.actuator.actuator import windings_of


@pytest.mark.parametrize("beta", [-70.0, 10.0, 50.0, 89.0])
def test_pitch_turns_and_length_unroll_to_the_angle(beta: float) -> None:
    wound = actuator(88.0, beta)
    _, winding = windings_of(wound)
    around = 2.0 * math.pi * wound.tube.outer_radius
    assert math.atan2(around, winding.pitch) == pytest.approx(math.radians(abs(beta)), rel=1e-12)
    assert winding.turns * winding.pitch == pytest.approx(wound.tube.length, rel=1e-12)
    assert winding.fiber_length == pytest.approx(
        math.hypot(wound.tube.length, around * winding.turns), rel=1e-12
    )
    assert winding.hand == ("right" if beta > 0.0 else "left")


def test_steeper_windings_are_longer() -> None:
    first, second = windings_of(actuator(88.0, 60.0))
    assert first.fiber_length > second.fiber_length
    assert first.pitch < second.pitch
