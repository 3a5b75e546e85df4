# SPDX-License-Identifier: Apache-2.0
"""Rounding for print: ends of a range towards its inside, shares in percent."""

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


def signed_percent(share: float) -> str:
    """Return a share in percent with its sign; one that rounds to zero has no minus.

    Example:
        >>> signed_percent(-0.2), signed_percent(-1e-12)
        ('-20.0 %', '+0.0 %')
    """
    return f"{round(100.0 * share, 1) + 0.0:+.1f} %"
