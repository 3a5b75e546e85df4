# SPDX-License-Identifier: Apache-2.0
"""What the checks at the border let through, and what they refuse."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from core.actuator_cases import actuator
from core.design_cases import PAPER_EXAMPLE
from core.gripper_cases import paper_gripper

from spiral_core import MeasuredActuation, PressureCourse
from spiral_core.calibration.model import CalibrationModel
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
    NAN, INF, -INF, True, np.True_, "1.0", b"1", None, 1j, np.array(1.0), 10**400,
]  # fmt: skip
NOT_VECTORS = [
    "123", 3.0, None, [1.0, 2.0], (1.0, 2.0, 3.0, 4.0), [1.0, 2.0, NAN], [1, 2, True], np.eye(3),
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


def test_range_includes_its_ends():
    assert require_in_range("x", 1.0, 1.0, 2.0) == 1.0
    assert require_in_range("x", 2, 1.0, 2.0) == 2.0
    for outside in (math.nextafter(1.0, 0.0), math.nextafter(2.0, 3.0)):
        said = refusal(require_in_range, outside, 1.0, 2.0)
        assert said.startswith("length must be a number from 1 to 2, got")


def test_vectors_become_tuples_of_floats_and_unit_vectors_are_normalized():
    for value in ([0, 0, -9.81], np.array([0.0, 0.0, -9.81])):
        result = require_vector("gravity", value, 3)
        assert (result, {*map(type, result)}) == ((0.0, 0.0, -9.81), {float})
    for value in NOT_VECTORS:
        assert refusal(require_vector, value, 3).startswith("length must be 3 finite numbers, got")
    norm = math.hypot(*require_unit_vector("axis", (0.6000001, 0.0, 0.8)))
    assert norm == pytest.approx(1.0, rel=1e-15)
    for value in ((0.0, 0.0, 0.0), (0.6, 0.0, 0.80001)):
        assert "whose norm is 1" in refusal(require_unit_vector, value)


@pytest.mark.parametrize(
    ("thing", "names", "value"),
    [
        (
            PAPER_EXAMPLE,
            "tubes elastomers fiber_angles_beta preference curvature_form",
            "3",
        ),
        (PAPER_EXAMPLE.elastomers[0], "pressure_law", "section"),
        (paper_gripper("P1"), "tube actuation stiffness", None),
        (actuator(), "single_fibers", 3),
        (
            MeasuredActuation((0.0, 1.0, 2.0), (0.0, 1.0, 2.0), (0.0, 0.0, 0.0), 0.3),
            "pressures",
            3.0,
        ),
        (PressureCourse((0.0, 1.0), (0.0, 1e4)), "times pressures", 3.0),
        (CalibrationModel(actuator()), "gripper quantities fixed", 3),
    ],
)
def test_what_is_of_another_kind_is_refused_by_name(thing, names, value):
    for field in names.split():
        with pytest.raises(InvalidInputError, match=f"^{field} must be a") as caught:
            replace(thing, **{field: value})
        assert caught.value.field == field
