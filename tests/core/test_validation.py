# SPDX-License-Identifier: Apache-2.0
"""What the checks at the border let through, and what they refuse."""

from __future__ import annotations

import math
from collections.abc import Callable
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

NUMBER_CHECKS: list[Callable[[str, object], float]] = [
    require_finite,
    require_positive,
    require_non_negative,
    lambda field, value: require_in_range(field, value, -1e300, 1e300),
]
NOT_NUMBERS = [
    math.nan,
    math.inf,
    -math.inf,
    True,
    np.True_,
    "1.0",
    b"1",
    None,
    1j,
    [1.0],
    np.array(1.0),
    np.array([1.0]),
    10**400,
]


@pytest.mark.parametrize("check", NUMBER_CHECKS)
@pytest.mark.parametrize("value", NOT_NUMBERS, ids=repr)
def test_what_is_no_finite_number_is_refused(
    check: Callable[[str, object], float], value: object
) -> None:
    with pytest.raises(InvalidInputError) as caught:
        check("length", value)
    assert caught.value.field == "length"
    assert caught.value.value is value


@pytest.mark.parametrize("check", NUMBER_CHECKS)
@pytest.mark.parametrize("value", [2, 2.0, np.float32(2.0), np.int64(2), Fraction(2)], ids=repr)
def test_any_real_number_becomes_a_float(
    check: Callable[[str, object], float], value: object
) -> None:
    result = check("length", value)
    assert type(result) is float
    assert result == 2.0


@repeatable
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_signs_are_told_apart(value: float) -> None:
    assert require_finite("x", value) == value
    for check, accepted in ((require_positive, value > 0.0), (require_non_negative, value >= 0.0)):
        if accepted:
            assert check("x", value) == value
        else:
            with pytest.raises(InvalidInputError, match="got"):
                check("x", value)


def test_range_includes_its_ends() -> None:
    assert require_in_range("x", 1.0, 1.0, 2.0) == 1.0
    assert require_in_range("x", 2.0, 1.0, 2.0) == 2.0
    for outside in (math.nextafter(1.0, 0.0), math.nextafter(2.0, 3.0)):
        with pytest.raises(InvalidInputError, match="x must be a number from 1 to 2, got"):
            require_in_range("x", outside, 1.0, 2.0)


@pytest.mark.parametrize("value", [[0, 0, -9.81], (0.0, 0.0, -9.81), np.array([0.0, 0.0, -9.81])])
def test_vector_becomes_a_tuple_of_floats(value: object) -> None:
    result = require_vector("gravity", value, 3)
    assert result == (0.0, 0.0, -9.81)
    assert all(type(component) is float for component in result)


@pytest.mark.parametrize(
    "value",
    [
        "123",
        b"123",
        3.0,
        None,
        [1.0, 2.0],
        [1.0, 2.0, 3.0, 4.0],
        [1.0, 2.0, math.nan],
        [1, 2, True],
        np.eye(3),
        np.array(1.0),
        [[1.0], [2.0], [3.0]],
    ],
    ids=repr,
)
def test_what_is_no_vector_is_refused(value: object) -> None:
    with pytest.raises(InvalidInputError, match="gravity must be 3 finite numbers, got") as caught:
        require_vector("gravity", value, 3)
    assert caught.value.value is value


def test_unit_vector_is_normalized_to_rounding() -> None:
    result = require_unit_vector("axis", (0.6000001, 0.0, 0.8))
    assert math.hypot(*result) == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("value", [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.6, 0.0, 0.80001)])
def test_other_norms_are_refused(value: tuple[float, float, float]) -> None:
    with pytest.raises(InvalidInputError, match="whose norm is 1"):
        require_unit_vector("axis", value)
