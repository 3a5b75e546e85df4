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
@given(st.floats(1e-6, 3.9))
def test_last_positive_is_next_to_the_root(root: float) -> None:
    found = last_positive(lambda x: root - x, 0.0, 4.0)
    assert found < root <= math.nextafter(found, math.inf)


@repeatable
@given(st.floats(0.01, 3.99))
def test_first_of_several_roots_is_found(root: float) -> None:
    found = first_sign_change(lambda x: (root - x) * (root + 0.5 - x), NODES)
    assert found == pytest.approx(root, rel=1e-14)


@repeatable
@given(st.floats(0.2, 3.8), st.floats(1e-3, 0.05))
def test_dip_between_two_nodes_is_found(center: float, half_width: float) -> None:
    found = first_sign_change(lambda x: (x - center) ** 2 - half_width**2, NODES)
    assert found == pytest.approx(center - half_width, rel=1e-10)


@repeatable
@given(st.floats(0.2, 3.8))
def test_minimum_above_zero_is_no_root(center: float) -> None:
    assert first_sign_change(lambda x: (x - center) ** 2 + 1e-6, NODES) is None


def test_function_that_starts_at_zero_ends_there() -> None:
    assert first_sign_change(lambda x: -x, NODES) == 0.0


def test_nan_counts_as_not_positive() -> None:
    found = first_sign_change(lambda x: 1.0 if x < 2.0 else math.nan, NODES)
    assert found == math.nextafter(2.0, 0.0)


def test_constant_function_needs_one_evaluation_a_node() -> None:
    calls = []

    def constant(x: float) -> float:
        calls.append(x)
        return 1.0

    assert first_sign_change(constant, NODES) is None
    assert calls == NODES
