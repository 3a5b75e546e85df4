# SPDX-License-Identifier: Apache-2.0
"""The target of the command: a radius, its wrap, the pressure, and the ramp to it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from spiral_core.errors import SpiralError
from spiral_core.validation import require_positive
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.plan import Planner, WrapPlan
from spiral_gripper_ros.control.states import Reason, Refusal, refusal_from_error

# Pressure of a grip that contact does not know yet, as a multiple of the pressure of the bare wrap.
UNKNOWN_RATIO: Final = 1.1
# Longest time one step may use for ramping [s]. A process that was stalled, suspended or whose
# clock leapt forward thus resumes its ramp instead of jumping to the target; five periods of the
# slowest publish rate anyone should use (50 Hz is the default) are 0.1 s.
LONGEST_STEP = 0.1


class Target:
    """A radius in use, its plan and the pressure above it; empty at first.

    It changes only to a plan that keeps the cap; what cannot be planned changes nothing.

    Attributes:
        radius: in use [m], or None.
        plan: of its wrap, or None.
        overpressure: above the wrap's pressure [Pa].
        frozen: constant pressure in place of the plan's [Pa], or None.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self.radius: float | None = None
        self.plan: WrapPlan | None = None
        self.overpressure = 0.0
        self._planner: Planner | None = None  # for a plan within other limits
        self._demanded: float | None = None  # overpressure; None: the default one
        self._least = 0.0  # multiple of the tip criterion's pressure that is held at least
        self.frozen: float | None = None
        self._ceiling = math.inf  # the lowest cap since the last input
        self._outdated = True

    def outdate(self, planner: Planner | None = None) -> None:
        """Demand a new plan even for the radius in use: limits have changed, or the planner."""
        self._outdated = True
        if planner is not None:
            self._planner = planner

    def needs_plan(self, radius: float, hysteresis: float) -> bool:
        """Return whether a radius [m] needs a plan: outside the hysteresis [m], or outdated."""
        return self._outdated or self._is_other(radius, hysteresis)

    def _is_other(self, radius: float, hysteresis: float) -> bool:
        """Return whether a radius [m] is not the one in use, outside the hysteresis [m]."""
        return self.radius is None or not abs(radius - self.radius) <= hysteresis

    def set_radius(
        self,
        radius: float,
        planner: Planner,
        limits: Limits,
        overpressure: float | None = None,
    ) -> Refusal | None:
        """Plan for ``radius`` [m] and make it the target, or return why not and change nothing.

        Without an overpressure it is that of :func:`default_overpressure`. An object that stays
        in use is not held more loosely because its grip becomes known, or is no longer known, as
        when an arm turns.
        """
        try:
            plan = planner.plan(radius)
            pressure = require_positive("pressure", plan.pressure)
        except SpiralError as error:
            return refusal_from_error(error)
        demanded = overpressure or 0.0
        refusal = _above_cap(pressure, demanded, limits)
        if not refusal and demanded > 0.0 and not pressure + demanded < plan.loss:
            refusal = beyond_loss(pressure + demanded, plan.loss)
        if refusal:
            return refusal
        self._least = self._kept(radius, plan, limits)
        if overpressure is None:
            demanded = default_overpressure(plan, limits, self._least * plan.wrap.pressure)
        self.radius, self.plan, self.overpressure = radius, plan, demanded
        self._planner, self._demanded = planner, overpressure
        self.frozen, self._outdated = None, False
        return None

    def _kept(self, radius: float, plan: WrapPlan, limits: Limits) -> float:
        """Return the multiple of the tip criterion's pressure that is held at least.

        It is that of the moment at which the grip becomes known, or is no longer known; 0: none.
        """
        if self.plan is None or self._is_other(radius, limits.radius_hysteresis):
            return 0.0
        if self._demanded is not None or limits.grip_ratio is not None:
            return 0.0
        if (self.plan.recommended is None) is not (plan.recommended is None):
            return (self.plan.pressure + self.overpressure) / self.plan.wrap.pressure
        return self._least

    def lower(self, cap: float) -> None:
        """Stay below a cap [Pa], even if it is raised again, until :meth:`resume`."""
        self._ceiling = min(self._ceiling, cap)

    def resume(self) -> None:
        """Let a new input use the cap of its time."""
        self._ceiling = math.inf

    def freeze(self, pressure: float) -> None:
        """Keep a pressure [Pa] until the next call of :meth:`set_radius`."""
        self.frozen = pressure

    def beyond_cap(self, limits: Limits) -> Refusal | None:
        """Return why the limits do not allow the plan in use, or None if they do."""
        if self.plan is not None:
            return _above_cap(self.plan.pressure, self._demanded or 0.0, limits)
        return None if self.frozen is None else asks_above_cap(self.frozen, limits)

    def replan(self, limits: Limits) -> Refusal | None:
        """Plan again for the radius in use, with other limits or another planner."""
        if self.radius is None or self._planner is None:
            return None
        limits = replace(limits, pressure_cap=min(limits.pressure_cap, self._ceiling))
        return self.set_radius(self.radius, self._planner, limits, self._demanded)

    def pressure(self, cap: float) -> float:
        """Return the target's pressure, not above the cap; 0 without a plan [Pa]."""
        wanted = self.frozen
        if wanted is None:
            wanted = 0.0 if self.plan is None else self.plan.pressure + self.overpressure
        return capped_pressure(min(wanted, self._ceiling), cap)


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
    if not (0.0 < pressure < math.inf and 0.0 < cap < math.inf):
        return 0.0
    return pressure if pressure <= cap else cap


def default_overpressure(plan: WrapPlan, limits: Limits, least: float = 0.0) -> float:
    """Return the overpressure of a grip that names none [Pa].

    With a ``grip_ratio`` the pressure is that multiple of the bare wrap's, which presses on the
    object with next to nothing. Without one it is what contact recommends or, where that is not
    known, ``UNKNOWN_RATIO`` times the bare wrap's. It stays within the cap and the good grips.

    Args:
        plan: the wrap.
        limits: hold the ratio and the cap.
        least: pressure [Pa], where the good grips and the cap allow it.
    """
    ratio, wanted = limits.grip_ratio, plan.recommended
    if ratio is not None or wanted is None:
        wanted = (UNKNOWN_RATIO if ratio is None else ratio) * plan.pressure
    highest = min(max(wanted, least), limits.pressure_cap, plan.highest_good)
    return max(highest - plan.pressure, 0.0)


def beyond_loss(pressure: float, loss: float) -> Refusal:
    """Return that a pressure [Pa] is at or above the one at which the grip is lost [Pa]."""
    text = f"overpressure raises the wrap to {pressure:.6g} Pa, but its grip is lost at"
    return Refusal(Reason.INVALID_REQUEST, f"{text} {loss:.6g} Pa")


def asks_above_cap(pressure: float, limits: Limits) -> Refusal | None:
    """Return that a pressure that is asked for [Pa] is above the cap, or None if it is not."""
    if pressure <= limits.pressure_cap:
        return None
    text = f"pressure {pressure:.6g} Pa is above pressure.cap = {limits.pressure_cap:.6g} Pa"
    return Refusal(Reason.PRESSURE_CAP, text)


def _above_cap(pressure: float, overpressure: float, limits: Limits) -> Refusal | None:
    if pressure + overpressure <= limits.pressure_cap:
        return None
    extra = f" and {overpressure:.6g} Pa of overpressure" if overpressure > 0.0 else ""
    return Refusal(
        Reason.PRESSURE_CAP,
        f"the wrap needs {pressure:.6g} Pa{extra}, "
        f"above pressure.cap = {limits.pressure_cap:.6g} Pa",
    )
