# SPDX-License-Identifier: Apache-2.0
"""The rest shape's validation, and who counts as an actuation model."""

from __future__ import annotations

import math

import pytest
from core.actuator_cases import actuator

from spiral_core import ActuationModel, FreeActuation, InvalidInputError, UnloadedShape


def test_stretch_may_be_unknown() -> None:
    assert UnloadedShape(curvature=20.0, torsion=-10.0, backbone_length=0.5).stretch is None


def test_a_straight_shape_is_valid() -> None:
    assert (
        UnloadedShape(curvature=0.0, torsion=0.0, backbone_length=0.5, stretch=1.0).curvature == 0.0
    )


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("curvature", math.nan),
        ("torsion", math.inf),
        ("backbone_length", 0.0),
        ("backbone_length", -0.5),
        ("stretch", 0.0),
        ("stretch", math.nan),
    ],
)
def test_values_are_validated(field: str, value: float) -> None:
    values = {"curvature": 20.0, "torsion": -10.0, "backbone_length": 0.5, "stretch": 1.1}
    with pytest.raises(InvalidInputError) as caught:
        UnloadedShape(**(values | {field: value}))
    assert caught.value.field == field


def test_free_actuation_is_an_actuation_model() -> None:
    assert isinstance(FreeActuation(actuator()), ActuationModel)
    assert not isinstance(actuator(), ActuationModel)
