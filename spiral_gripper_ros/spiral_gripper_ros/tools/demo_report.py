# SPDX-License-Identifier: Apache-2.0
"""The messages that the demo received, compared with the expected ones. No ROS."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from statistics import median

from spiral_gripper_ros.control.states import Reason

# What the demo's stream of radii contains.
EXPECTED_REFUSALS = frozenset(
    {
        Reason.RADIUS_NOT_FINITE,
        Reason.RADIUS_NOT_POSITIVE,
        Reason.RADIUS_TOO_SMALL,
        Reason.RADIUS_TOO_LARGE,
        Reason.RADIUS_JUMP,
        Reason.RADIUS_STALE,
    }
)
# The noise of the estimates and the node's hysteresis together move the radius by less [m].
RADIUS_SLACK = 3.0e-4


@dataclass(slots=True)
class DemoReport:
    """Collects what was received.

    Args:
        objects: radii that must have been wrapped perfectly [m], by what they are.
        pressure_max: what no command may exceed [Pa].
    """

    objects: dict[str, float]
    pressure_max: float
    pressures: list[float] = field(default_factory=list)
    refused: Counter[Reason] = field(default_factory=Counter)
    wrapped: list[tuple[float, float]] = field(default_factory=list)
    solve_times: list[float] = field(default_factory=list)

    def wrap(self, radius: float, pressure: float) -> None:
        """Note a perfect wrap of a radius [m] at a pressure [Pa]."""
        if not self.wrapped or self.wrapped[-1] != (radius, pressure):
            self.wrapped.append((radius, pressure))

    def pressure_for(self, radius: float) -> float | None:
        """Return the pressure [Pa] at which a radius [m] was wrapped, or None if it was not."""
        near = [p for r, p in self.wrapped if abs(r - radius) <= RADIUS_SLACK]
        return median(near) if near else None

    def problems(self) -> list[str]:
        """Return what did not happen as it should have, one line each."""
        found = [
            f"{reason.name} was never given as a reason"
            for reason in sorted(EXPECTED_REFUSALS - set(self.refused))
        ]
        found += [
            f"the {name} ({radius * 1e3:g} mm) was never wrapped"
            for name, radius in self.objects.items()
            if self.pressure_for(radius) is None
        ]
        if not all(math.isfinite(p) and 0.0 <= p <= self.pressure_max for p in self.pressures):
            found.append("a pressure outside its limits was commanded")
        if not self.pressures or self.pressures[-1] != 0.0:
            found.append("the last command was not a vent")
        return found

    def summary(self) -> list[str]:
        """Return the summary, one line each."""
        lines = [f"{len(self.pressures)} pressures received"]
        for name, radius in self.objects.items():
            pressure = self.pressure_for(radius)
            answer = "never wrapped" if pressure is None else f"{pressure / 1e3:.2f} kPa"
            lines.append(f"  {name}, {radius * 1e3:g} mm: {answer}")
        if self.solve_times:
            lines.append(
                "time of the solver for a new radius: "
                f"median {median(self.solve_times) * 1e3:.1f} ms, "
                f"worst {max(self.solve_times) * 1e3:.1f} ms"
            )
        reasons = ", ".join(
            f"{reason.name.lower().replace('_', ' ')} ({count}x)"
            for reason, count in sorted(self.refused.items())
        )
        lines.append(f"refused: {reasons or 'nothing'}")
        return lines
