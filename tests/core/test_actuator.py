# SPDX-License-Identifier: Apache-2.0
"""The actuator's defaults and what it refuses."""

from __future__ import annotations

import dataclasses

from core.actuator_cases import LATEX, PAPER_TUBE, degrees

from spiral_core import Actuator, CurvatureForm, FreeActuation
from spiral_core.actuator.actuator import ActuationModel

ACTUATOR = Actuator(PAPER_TUBE, degrees(88.0, 60.0), LATEX)


def test_defaults_are_the_papers_form_with_the_twist_shear() -> None:
    assert ACTUATOR.curvature_form is CurvatureForm.FIRST_ORDER
    assert ACTUATOR.twist_shear is True


def test_straight_fiber_follows_the_tube_unless_placed() -> None:
    wider = dataclasses.replace(PAPER_TUBE, inner_radius=6.0e-3)
    assert dataclasses.replace(ACTUATOR, tube=wider).fiber_radius == 6.0e-3
    placed = dataclasses.replace(ACTUATOR, straight_fiber_radius=5.5e-3)
    assert dataclasses.replace(placed, tube=wider).fiber_radius == 5.5e-3


def test_free_actuation_is_an_actuation_model() -> None:
    assert isinstance(FreeActuation(ACTUATOR), ActuationModel)
    assert not isinstance(ACTUATOR, ActuationModel)
