# SPDX-License-Identifier: Apache-2.0
"""The last two steps of a command: the rate limit, then the cap."""

from __future__ import annotations

import math

from spiral_gripper_ros.control.limits import Limits

# Longest time one step may use for ramping [s]. A process that was stalled, suspended or whose
# clock leapt forward thus resumes its ramp instead of jumping to the target; five periods of the
# slowest publish rate anyone should use (50 Hz is the default) are 0.1 s.
LONGEST_STEP = 0.1


def ramped_pressure(previous: float, goal: float, elapsed: float, limits: Limits) -> float:
    """Return the next command on the way from ``previous`` to ``goal``.

    Args:
        previous: last command [Pa].
        goal: where it should go [Pa].
        elapsed: time since the last command [s]; more than ``LONGEST_STEP`` counts as that much,
            less than zero as nothing.
        limits: the rates [Pa/s] and the cap [Pa].

    Returns:
        The command [Pa], 0 <= command <= ``limits.pressure_cap``; 0 if any number is not finite.

    Example:
        >>> limits = Limits(pressure_cap=1.0e5, pressure_rate_up=1.0e5)
        >>> ramped_pressure(previous=0.0, goal=5.0e4, elapsed=0.02, limits=limits)
        2000.0
        >>> ramped_pressure(previous=0.0, goal=float("nan"), elapsed=0.02, limits=limits)
        0.0
    """
    if not (math.isfinite(previous) and math.isfinite(goal) and math.isfinite(elapsed)):
        return 0.0
    step = min(max(elapsed, 0.0), LONGEST_STEP)
    highest = previous + limits.pressure_rate_up * step
    lowest = previous - limits.pressure_rate_down * step
    return capped_pressure(min(max(goal, lowest), highest), limits.pressure_cap)


def capped_pressure(pressure: float, cap: float) -> float:
    """Return ``pressure`` if 0 <= pressure <= cap, else the nearer bound; 0 if one is not finite.

    ``min`` and ``max`` pass NaN on, depending on the order of their arguments; this does not.

    Example:
        >>> capped_pressure(1.2e5, cap=1.0e5), capped_pressure(float("nan"), cap=1.0e5)
        (100000.0, 0.0)
    """
    if not (math.isfinite(pressure) and math.isfinite(cap) and pressure > 0.0 and cap > 0.0):
        return 0.0
    return pressure if pressure <= cap else cap
