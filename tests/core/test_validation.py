# SPDX-License-Identifier: Apache-2.0
"""What the checks at the border let through, and what they refuse."""

from fractions import Fraction
from math import hypot, inf, nan, nextafter

import numpy as np
import pytest
from numpy.testing import assert_allclose

from spiral_core.errors import InvalidInputError
from spiral_core.validation import (
    require_finite,
    require_in_range,
    require_non_negative,
    require_positive,
    require_unit_vector,
    require_vector,
)

NAN, INF = nan, inf
NOT_NUMBERS = [
    NAN, INF, -INF, True, np.True_, "1.0", b"1", None, 1j, np.array(1.0), 10**400
]  # fmt: skip
NOT_VECTORS = [
    "123", 3.0, None, [1.0, 2.0], (1.0, 2.0, 3.0, 4.0), [1.0, 2.0, NAN], [1, 2, True], np.eye(3)
]  # fmt: skip


def refuses(said, check, value, *arguments):
    """Expect how a check refuses a value, which its error must carry."""
    with pytest.raises(InvalidInputError, match=f"^length must be .*{said}") as caught:
        check("length", value, *arguments)
    assert (caught.value.field, caught.value.value is value) == ("length", True)


def test_any_real_number_becomes_a_float_and_nothing_else():
    for check, ends, outside in [
        (require_finite, (), ()),
        (require_positive, (), (0.0, -1e-300)),
        (require_non_negative, (), (-1e-300,)),
        (require_in_range, (1.0, 2.0), (nextafter(1.0, 0.0), nextafter(2.0, 3.0))),
    ]:
        for value in (1, 1.0, 2, np.float32(2.0), np.int64(2), Fraction(2)):
            result = check("length", value, *ends)
            assert (type(result), result) == (float, float(value))
        for value in (*NOT_NUMBERS, *outside):
            refuses("from 1 to 2, got" if ends else "", check, value, *ends)


def test_vectors_become_tuples_of_floats_and_unit_vectors_are_normalized():
    for value in ([0, 0, -9.81], np.array([0.0, 0.0, -9.81])):
        result = require_vector("gravity", value, 3)
        assert (result, {*map(type, result)}) == ((0.0, 0.0, -9.81), {float})
    for value in NOT_VECTORS:
        refuses("3 finite numbers, got", require_vector, value, 3)
    norm = hypot(*require_unit_vector("axis", (0.6000001, 0.0, 0.8)))
    assert_allclose(norm, 1.0, 1e-15)
    for value in ((0.0, 0.0, 0.0), (0.6, 0.0, 0.80001)):
        refuses("whose norm is 1", require_unit_vector, value)
