# SPDX-License-Identifier: Apache-2.0
"""Stand-ins for what the control logic is given: a planner known by heart, a regulator."""

import math
from dataclasses import dataclass
from enum import Enum

from spiral_core import NotGrippableError, WrapRegime


@dataclass(frozen=True)
class FakePlan:
    pressure: float
    highest_good: float
    loss: float
    recommended: float | None

    @property
    def wrap(self):
        return self


class FakePlanner:
    """Wraps radii from 10 to 40 mm with 1000 Pa m / radius: 100 kPa to 25 kPa.

    What is good, lost and recommended are multiples of that.
    """

    radius_range = (0.01, 0.04)
    error = recommended = None
    highest_good = loss = math.inf

    def __init__(self, product=1.0e3):
        self.product, self.asked = product, []

    def plan(self, radius):
        self.asked.append(radius)
        if self.error is not None:
            raise self.error
        nearest = min(max(radius, 0.01), 0.04)
        if radius != nearest:
            raise NotGrippableError(radius, "out of range", -1.0, nearest)
        wrap = self.product / radius
        recommended = self.recommended and self.recommended * wrap
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

    pressure, fault, latched = 0.0, RegulatorFault.NONE, False

    def step(self, command, elapsed):
        """Let a command act for a while [s] and return what is measured."""
        self.latched = self.latched and command != 0.0
        if self.fault is not RegulatorFault.STUCK:
            arrives = 0.7 if self.fault is RegulatorFault.LEAK else 1.0
            goal = 0.0 if self.latched else arrives * command
            self.pressure += (goal - self.pressure) * -math.expm1(-elapsed / 0.05)
        return {
            RegulatorFault.LOST: None,
            RegulatorFault.NAN: math.nan,
            RegulatorFault.ABSOLUTE: self.pressure + 101325.0,
        }.get(self.fault, self.pressure)


def regime_at(pressure, perfect):
    """Return the regime at a pressure: within 2 % of the perfect wrap's it is one."""
    if abs(pressure - perfect) <= 0.02 * perfect:
        return WrapRegime.PERFECT_WRAP
    return WrapRegime.OVERHANG if pressure < perfect else WrapRegime.CURLING
