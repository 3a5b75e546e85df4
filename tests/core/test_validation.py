# SPDX-License-Identifier: Apache-2.0
"""What the checks at the border let through, and what they refuse."""

import math
from fractions import Fraction

import numpy as np
import pytest
from core.actuator_cases import repeatable
from hypothesis import given
from hypothesis import strategies as st

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
CHECKS = [
    require_finite,
    require_positive,
    require_non_negative,
    lambda field, value: require_in_range(field, value, -1e300, 1e300),
]
NOT_NUMBERS = [
    NAN, INF, -INF, True, np.True_, "1.0", b"1", None, 1j, [1.0], np.array(1.0), 10**400,
]  # fmt: skip
NOT_VECTORS = [
    "123", b"123", 3.0, None, [1.0, 2.0], [1.0, 2.0, 3.0, 4.0], [1.0, 2.0, NAN], (1.0, 2.0, INF),
    [1, 2, True], np.eye(3), np.array(1.0), [[1.0], [2.0], [3.0]],
]  # fmt: skip


@pytest.mark.parametrize("check", CHECKS)
def test_any_real_number_becomes_a_float_and_nothing_else(check):
    for value in (2, 2.0, np.float32(2.0), np.int64(2), Fraction(2)):
        result = check("length", value)
        assert (type(result), result) == (float, 2.0)
    for value in NOT_NUMBERS:
        with pytest.raises(InvalidInputError) as caught:
            check("length", value)
        assert caught.value.field == "length"
        assert caught.value.value is value


@repeatable
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_signs_are_told_apart(value):
    assert require_finite("x", value) == value
    for check, accepted in ((require_positive, value > 0.0), (require_non_negative, value >= 0.0)):
        if accepted:
            assert check("x", value) == value
        else:
            with pytest.raises(InvalidInputError, match="got"):
                check("x", value)


def test_range_includes_its_ends():
    for value in (1.0, 2.0, 1, 2):
        assert require_in_range("x", value, 1.0, 2.0) == value
    for outside in (math.nextafter(1.0, 0.0), math.nextafter(2.0, 3.0), 3):
        with pytest.raises(InvalidInputError, match="x must be a number from 1 to 2, got"):
            require_in_range("x", outside, 1.0, 2.0)


def test_vectors_become_tuples_of_floats_and_unit_vectors_are_normalized():
    for value in ([0, 0, -9.81], (0.0, 0.0, -9.81), np.array([0.0, 0.0, -9.81])):
        result = require_vector("gravity", value, 3)
        assert result == (0.0, 0.0, -9.81)
        assert {type(component) for component in result} == {float}
    norm = math.hypot(*require_unit_vector("axis", (0.6000001, 0.0, 0.8)))
    assert norm == pytest.approx(1.0, rel=1e-15)
    for wrong in ((0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.6, 0.0, 0.80001)):
        with pytest.raises(InvalidInputError, match="whose norm is 1"):
            require_unit_vector("axis", wrong)


@pytest.mark.parametrize("value", NOT_VECTORS, ids=repr)
def test_what_is_no_vector_is_refused(value):
    with pytest.raises(InvalidInputError, match="gravity must be 3 finite numbers, got") as caught:
        require_vector("gravity", value, 3)
    assert caught.value.value is value
