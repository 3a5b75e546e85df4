# SPDX-License-Identifier: Apache-2.0
"""Sign changes of functions, located to the last float: scan, then bisect."""

from __future__ import annotations

from collections.abc import Callable, Sequence

# A minimum is only defined to the square root of the float's precision: 1e-8 of the width.
MINIMUM_STEPS = 40


def last_positive(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the float next to the sign change of ``function`` on the side of ``low``.

    Bisection down to neighboring floats, 60-odd evaluations: slower than the clever methods, and
    unable to fail. The result is the caller's safe side of the root.

    Args:
        function: positive at ``low``, not positive (or NaN) at ``high``; neither is evaluated.
        low: start of the bracket.
        high: end of the bracket, > ``low``.

    Returns:
        A point where the function is positive, while at the next float it is not.

    Example:
        >>> last_positive(lambda x: 2.0 - x * x, 1.0, 2.0)
        1.414213562373095
    """
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return low
        if function(middle) > 0.0:
            low = middle
        else:
            high = middle


def first_sign_change(function: Callable[[float], float], nodes: Sequence[float]) -> float | None:
    """Return where ``function`` first stops being positive over increasing ``nodes``.

    A dip below zero between two nodes is found too, if the nodes resolve the minimum as one.

    Args:
        function: continuous and positive at ``nodes[0]``.
        nodes: increasing points, close enough to show every minimum of the function.

    Returns:
        The last point at which it is still positive, to one float; None if it stays positive.

    Example:
        >>> round(first_sign_change(lambda x: (x - 1.5) ** 2 - 1e-6, [0.0, 1.0, 2.0, 3.0]), 9)
        1.499
    """
    values: list[float] = []
    for index, node in enumerate(nodes):
        values.append(function(node))
        if index >= 2 and values[-3] > values[-2] <= values[-1]:
            lowest = minimum(function, nodes[index - 2], node)
            if not function(lowest) > 0.0:
                return last_positive(function, nodes[index - 2], lowest)
        if not values[-1] > 0.0:
            return last_positive(function, nodes[index - 1], node) if index else node
    return None


def minimum(
    function: Callable[[float], float], low: float, high: float, steps: int = MINIMUM_STEPS
) -> float:
    """Return the minimum of a function with one minimum in between, by golden-section search."""
    ratio = 0.6180339887498949
    left, right = high - ratio * (high - low), low + ratio * (high - low)
    value_left, value_right = function(left), function(right)
    for _ in range(steps):
        if value_left < value_right:
            high, right, value_right = right, left, value_left
            left = high - ratio * (high - low)
            value_left = function(left)
        else:
            low, left, value_left = left, right, value_right
            right = low + ratio * (high - low)
            value_right = function(right)
    return 0.5 * (low + high)
