# SPDX-License-Identifier: Apache-2.0
"""Checks of radius estimates: range, jumps and age."""

from __future__ import annotations

import math

from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.states import Reason, Refusal


class RadiusGate:
    r"""Judges radius estimates before anything is computed from them.

    Jumps are judged against a *believed* radius b(t) that moves towards every finite, grippable
    estimate no faster than ``radius_rate_limit``: an estimate r is refused while
    \|r - b\| > ``radius_jump_limit``. An outlier therefore changes nothing, a real step of the
    object is believed (\|step\| - jump_limit) / rate_limit seconds later, and both hold at any
    message rate.
    """

    def __init__(self) -> None:
        self._believed: float | None = None
        self._time = 0.0

    def reset(self) -> None:
        """Forget what was believed: the next grippable estimate is taken as it is."""
        self._believed = None

    def refusal(
        self, now: float, radius: float, grippable: tuple[float, float], limits: Limits
    ) -> Refusal | None:
        """Return why ``radius`` is refused, or None if it is accepted.

        Args:
            now: time [s], never decreasing.
            radius: estimate [m]; anything a float can be.
            grippable: smallest and largest radius that can be gripped [m].
            limits: jump and rate limit [m, m/s].

        Example:
            >>> refusal = RadiusGate().refusal(0.0, 0.09, (0.01, 0.04), Limits(pressure_cap=1e5))
            >>> refusal.text.partition("; ")[2]
            'the nearest grippable radius is 0.04 m'
        """
        return impossible_radius(radius, grippable) or self._jump(now, radius, limits)

    def _jump(self, now: float, radius: float, limits: Limits) -> Refusal | None:
        if self._believed is None:
            self._believed, self._time = radius, now
            return None
        reach = limits.radius_rate_limit * max(now - self._time, 0.0)
        self._believed += min(max(radius - self._believed, -reach), reach)
        self._time = now
        distance = abs(radius - self._believed)
        if distance <= limits.radius_jump_limit:
            return None
        return Refusal(
            Reason.RADIUS_JUMP,
            f"object_radius {radius:.6g} m is {distance:.3g} m from the {self._believed:.6g} m "
            f"that {limits.radius_rate_limit:.3g} m/s allow by now; "
            f"up to {limits.radius_jump_limit:.3g} m is accepted",
        )


def impossible_radius(radius: float, grippable: tuple[float, float]) -> Refusal | None:
    """Return why no gripper of this range [m] could hold ``radius`` [m], or None.

    Example:
        >>> impossible_radius(-0.02, grippable=(0.01, 0.04)).text
        'object_radius must be positive, got -0.02 m'
    """
    smallest, largest = grippable
    beyond = "the grippable range; the nearest grippable radius is"
    for holds, reason, text in (
        (math.isfinite(radius), Reason.RADIUS_NOT_FINITE, f"must be a finite number, got {radius}"),
        (radius > 0.0, Reason.RADIUS_NOT_POSITIVE, f"must be positive, got {radius:.6g} m"),
        (
            radius >= smallest,
            Reason.RADIUS_TOO_SMALL,
            f"{radius:.6g} m is below {beyond} {smallest:.6g} m",
        ),
        (
            radius <= largest,
            Reason.RADIUS_TOO_LARGE,
            f"{radius:.6g} m is above {beyond} {largest:.6g} m",
        ),
    ):
        if not holds:
            return Refusal(reason, f"object_radius {text}")
    return None


def age_problem(topic: str, age: float, parameter: str, limit: float) -> str:
    """Return why what was heard at an age [s] is not used; empty if it is young enough.

    Example:
        >>> age_problem("object_radius_stamped", 0.7, "radius.age_limit", 0.5)
        'object_radius_stamped is 0.7 s old, more than radius.age_limit = 0.5 s'
        >>> age_problem("object_radius_stamped", 0.1, "radius.age_limit", 0.5)
        ''
    """
    if abs(age) <= limit:
        return ""
    how = f"{age:.3g} s old" if age > 0.0 else f"{-age:.3g} s ahead of this clock"
    return f"{topic} is {how}, more than {parameter} = {limit:g} s"
