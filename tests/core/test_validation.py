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

# Of the others test_refusals asks every field.
WRONG = [
    *(
        (require_in_range, wrong, 1.0, 2.0)
        for wrong in (-inf, np.True_, b"1", None, 1j, np.array(1.0), 10**400)
    ),
    *((require_in_range, each, 1.0, 2.0) for each in (nextafter(1.0, 0.0), nextafter(2.0, 3.0))),
    *((require_positive, each) for each in (0.0, -1e-300)),
    (require_non_negative, -1e-300),
    *(
        (require_vector, wrong, 3)
        for wrong in (
            *("123", 3.0, None, [1.0, 2.0], [1.0, 2.0, nan], [1, 2, True], np.eye(3)),
            *(kind((1.0, 2.0, 3.0)) for kind in (set, iter, dict.fromkeys)),
        )
    ),
    *((require_unit_vector, each) for each in ((0.0, 0.0, 0.0), (0.6, 0.0, 0.80001))),
]


def test_what_is_no_number_vector_or_direction_is_refused_as_it_came():
    for check, value, *given in WRONG:
        with pytest.raises(InvalidInputError, match="length must be") as caught:
            check("length", value, *given)
        assert (caught.value.field, caught.value.value is value) == ("length", True)


def test_any_real_number_becomes_a_float_and_a_direction_has_length_one():
    for value in (1, 1.0, 2, np.float32(2.0), np.int64(2), Fraction(2)):
        for check, *given in ((require_finite,), (require_in_range, 1.0, 2.0)):
            result = check("length", value, *given)
            assert (type(result), result) == (float, float(value))
    result = require_vector("gravity", np.array([0.0, 0.0, -9.81]), 3)
    assert (result, {*map(type, result)}) == ((0.0, 0.0, -9.81), {float})
    norm = hypot(*require_unit_vector("axis", (0.6000001, 0.0, 0.8)))
    assert_allclose(norm, 1.0, 1e-15)
