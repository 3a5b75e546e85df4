# SPDX-License-Identifier: Apache-2.0
"""Arguments that once passed in silence and came back as zero or not a number."""

from __future__ import annotations

import math

import pytest
from core.actuator_cases import actuator
from core.gripper_cases import paper_gripper

from spiral_core import (
    CalibrationModel,
    InvalidInputError,
    Section,
    energy_from_stretch,
    line_force,
)

NUMBERS = (-1.0, 0.0, math.nan, math.inf, "1", True)


@pytest.mark.parametrize("value", NUMBERS)
@pytest.mark.parametrize("field", ["bending_stiffness", "torsional_stiffness"])
def test_a_models_stiffness_is_positive(field: str, value: object) -> None:
    with pytest.raises(InvalidInputError) as caught:
        CalibrationModel(actuator(), **{field: value})  # type: ignore[arg-type]
    assert caught.value.field == field


@pytest.mark.parametrize("stretch", NUMBERS)
def test_energy_needs_a_stretch(stretch: object) -> None:
    with pytest.raises(InvalidInputError) as caught:
        energy_from_stretch(actuator(), stretch)  # type: ignore[arg-type]
    assert caught.value.field == "stretch"


def test_line_force_needs_radii_and_an_angle() -> None:
    gripper = paper_gripper("P1")
    shape = gripper.unloaded_shape(5e4)
    stiffness = Section.inextensible(3e-4, 2e-4)
    good = {"radius": 0.02, "helix_angle": 1.0, "outer_radius": 0.005}
    assert math.isfinite(line_force(stiffness, shape, **good))
    for field in good:
        with pytest.raises(InvalidInputError) as caught:
            line_force(stiffness, shape, **good | {field: math.nan})
        assert caught.value.field == field
