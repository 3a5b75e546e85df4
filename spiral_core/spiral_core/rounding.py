# SPDX-License-Identifier: Apache-2.0
"""Rounding to significant digits towards one side: printed ends of a range must lie inside it."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, Context


def rounded_down(value: float, digits: int) -> float:
    """Return the largest number of so many significant digits that is at most ``value``.

    Example:
        >>> rounded_down(0.0378219, 4), rounded_down(-1.25, 2)
        (0.03782, -1.3)
    """
    return float(Context(digits, ROUND_FLOOR).create_decimal(repr(float(value))))


def rounded_up(value: float, digits: int) -> float:
    """Return the smallest number of so many significant digits that is at least ``value``.

    Example:
        >>> rounded_up(0.0378219, 4), rounded_up(12.0, 2)
        (0.03783, 12.0)
    """
    return float(Context(digits, ROUND_CEILING).create_decimal(repr(float(value))))
