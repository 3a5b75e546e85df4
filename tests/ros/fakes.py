# SPDX-License-Identifier: Apache-2.0
"""Stand-ins for what the control logic is given: a planner known by heart, a regulator."""

import math
from dataclasses import dataclass
from enum import Enum

from spiral_core import NotGrippableError, WrapRegime


@dataclass(frozen=True)
class FakePlan:
    pressure: float
    highest_good: float = math.inf
    loss: float = math.inf
    recommended: float | None = None


class FakePlanner:
    """Wraps radii from 10 to 40 mm with 1000 Pa m / radius: 100 kPa to 25 kPa."""

    radius_range = (0.01, 0.04)

    def __init__(self, product: float = 1.0e3) -> None:
        self.product = product
        self.asked: list[float] = []
        self.error: Exception | None = None
        self.recommended: float | None = None  # both as multiples of the wrap
        self.highest_good = self.loss = math.inf

    def plan(self, radius: float) -> FakePlan:
        self.asked.append(radius)
        if self.error is not None:
            raise self.error
        low, high = self.radius_range
        if not low <= radius <= high:
            raise NotGrippableError(radius, "out of range", -1.0, low if radius < low else high)
        wrap = self.product / radius
        recommended = None if self.recommended is None else self.recommended * wrap
        return FakePlan(wrap, self.highest_good * wrap, self.loss * wrap, recommended)


class RegulatorFault(Enum):
    NONE = "sound"
    LEAK = "leak"  # 70 % of the pressure arrives
    STUCK = "stuck"  # the pressure stays where it is
    LOST = "lost"  # nothing is measured
    NAN = "unplugged"  # the sensor is unplugged
    ABSOLUTE = "absolute"  # the sensor measures absolute pressure


class FakeRegulator:
    """Follows the command with a first-order lag of 50 ms, and measures.

    Once its watchdog has vented (``latched``) it stays vented until 0 Pa is commanded.
    """

    TIME_CONSTANT = 0.05

    def __init__(self) -> None:
        self.pressure = 0.0
        self.fault = RegulatorFault.NONE
        self.latched = False

    def step(self, command: float, elapsed: float) -> float | None:
        """Let a command act for a while [s] and return what is measured."""
        self.latched = self.latched and command != 0.0
        command = 0.0 if self.latched else command
        goal = 0.7 * command if self.fault is RegulatorFault.LEAK else command
        if self.fault is not RegulatorFault.STUCK:
            self.pressure += (goal - self.pressure) * -math.expm1(-elapsed / self.TIME_CONSTANT)
        if self.fault is RegulatorFault.LOST:
            return None
        if self.fault is RegulatorFault.NAN:
            return math.nan
        return self.pressure + (101325.0 if self.fault is RegulatorFault.ABSOLUTE else 0.0)


def regime_at(pressure: float, perfect: float) -> WrapRegime:
    """Return the regime at a pressure: within 2 % of the perfect wrap's it is one."""
    if abs(pressure - perfect) <= 0.02 * perfect:
        return WrapRegime.PERFECT_WRAP
    return WrapRegime.OVERHANG if pressure < perfect else WrapRegime.CURLING
