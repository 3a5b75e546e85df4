# SPDX-License-Identifier: Apache-2.0
"""Sign changes to the last float, and dips that fall between two nodes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.actuator_cases import repeatable
from hypothesis import given
from hypothesis import strategies as st

from spiral_core.numerics.roots import first_sign_change, last_positive

NODES = np.linspace(0.0, 4.0, 41).tolist()


@repeatable
@given(st.floats(0.2, 3.8), st.floats(1e-3, 0.05))
def test_the_first_root_is_found_to_the_last_float(root, half):
    """And a dip between two nodes; a minimum above zero is no root."""
    for found in (
        last_positive(lambda x: root - x, 0.0, 4.0),
        first_sign_change(lambda x: root - x, NODES),
    ):
        assert found < root <= math.nextafter(found, math.inf)
    several = first_sign_change(lambda x: (root - x) * (root + 0.5 - x), NODES)
    assert several == pytest.approx(root, rel=1e-14)
    dip = first_sign_change(lambda x: (x - root) ** 2 - half**2, NODES)
    assert dip == pytest.approx(root - half, rel=1e-10)
    assert first_sign_change(lambda x: (x - root) ** 2 + 1e-6, NODES) is None


def test_zero_at_the_start_and_nan_are_not_positive():
    assert first_sign_change(lambda x: -x, NODES) == 0.0
    found = first_sign_change(lambda x: 1.0 if x < 2.0 else math.nan, NODES)
    assert found == math.nextafter(2.0, 0.0)
