# SPDX-License-Identifier: Apache-2.0
"""What the checks at the border let through, and what they refuse."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from core.actuator_cases import actuator, repeatable
from core.design_cases import PAPER_EXAMPLE
from core.gripper_cases import paper_gripper
from hypothesis import given
from hypothesis import strategies as st

from spiral_core import MeasuredActuation, MooneyRivlin, PressureCourse
from spiral_core.calibration.model import CalibrationModel
from spiral_core.design.requirement import Elastomer
from spiral_core.errors import InvalidInputError
from spiral_core.validation import (
    require_finite,
    require_in_range,
    require_non_negative,
    require_positive,
    require_unit_vector,
    require_vector,
)

NAN, INF = math.nan, math.inf
NOT_NUMBERS = [
    NAN, INF, -INF, True, np.True_, "1.0", b"1", None, 1j, [1.0], np.array(1.0), 10**400,
]  # fmt: skip
NOT_VECTORS = [
    "123", b"123", 3.0, None, [1.0, 2.0], (1.0, 2.0, 3.0, 4.0), [1.0, 2.0, NAN], (1.0, 2.0, INF),
    [1, 2, True], np.eye(3), np.array(1.0), [[1.0], [2.0], [3.0]],
]  # fmt: skip


def refusal(check, value, *arguments):
    """Return how a check refuses a value, which its error must carry."""
    with pytest.raises(InvalidInputError) as caught:
        check("length", value, *arguments)
    assert caught.value.field == "length"
    assert caught.value.value is value
    return str(caught.value)


@pytest.mark.parametrize(
    ("check", "ends"),
    [
        (require_finite, ()),
        (require_positive, ()),
        (require_non_negative, ()),
        (require_in_range, (-1e300, 1e300)),
    ],
)
def test_any_real_number_becomes_a_float_and_nothing_else(check, ends):
    for value in (2, 2.0, np.float32(2.0), np.int64(2), Fraction(2)):
        result = check("length", value, *ends)
        assert (type(result), result) == (float, 2.0)
    for value in NOT_NUMBERS:
        refusal(check, value, *ends)


@repeatable
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_signs_are_told_apart(value):
    assert require_finite("x", value) == value
    for check, accepted in ((require_positive, value > 0.0), (require_non_negative, value >= 0.0)):
        if accepted:
            assert check("x", value) == value
        else:
            refusal(check, value)


def test_range_includes_its_ends():
    for value in (1.0, 2.0, 1, 2):
        assert require_in_range("x", value, 1.0, 2.0) == value
    for outside in (math.nextafter(1.0, 0.0), math.nextafter(2.0, 3.0), 3):
        said = refusal(require_in_range, outside, 1.0, 2.0)
        assert said.startswith("length must be a number from 1 to 2, got")


def test_vectors_become_tuples_of_floats_and_unit_vectors_are_normalized():
    for value in ([0, 0, -9.81], (0.0, 0.0, -9.81), np.array([0.0, 0.0, -9.81])):
        result = require_vector("gravity", value, 3)
        assert result == (0.0, 0.0, -9.81)
        assert {type(component) for component in result} == {float}
    for value in NOT_VECTORS:
        assert refusal(require_vector, value, 3).startswith("length must be 3 finite numbers, got")
    norm = math.hypot(*require_unit_vector("axis", (0.6000001, 0.0, 0.8)))
    assert norm == pytest.approx(1.0, rel=1e-15)
    for value in ((0.0, 0.0, 0.0), (0.6, 0.0, 0.80001)):
        assert "whose norm is 1" in refusal(require_unit_vector, value)


@pytest.mark.parametrize(
    ("field", "make"),
    [
        *(
            (field, lambda field=field: replace(PAPER_EXAMPLE, **{field: "3"}))
            for field in ("tubes", "elastomers", "fiber_angles_beta", "preference")
        ),
        ("curvature_form", lambda: replace(PAPER_EXAMPLE, curvature_form="exact")),
        ("pressure_law", lambda: Elastomer("e", MooneyRivlin(1e5, 1e4), 950.0, "section")),
        *(
            (field, lambda field=field: replace(paper_gripper("P1"), **{field: None}))
            for field in ("tube", "actuation", "stiffness")
        ),
        ("single_fibers", lambda: replace(actuator(), single_fibers=3)),
        ("pressures", lambda: MeasuredActuation(3.0, (0.0,), (0.0,), 0.3)),
        ("times", lambda: PressureCourse(3.0, (0.0, 1e4))),
        ("pressures", lambda: PressureCourse((0.0, 1.0), 1e4)),
        ("gripper", lambda: CalibrationModel(actuator(), gripper="mine.yaml")),
        ("quantities", lambda: CalibrationModel(actuator(), quantities="density")),
        ("fixed", lambda: CalibrationModel(actuator(), fixed=3)),
    ],
)
def test_what_is_of_another_kind_is_refused_by_name(field, make):
    with pytest.raises(InvalidInputError, match=f"^{field} must be a") as caught:
        make()
    assert caught.value.field == field
