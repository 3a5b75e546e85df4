# SPDX-License-Identifier: Apache-2.0
"""Constraints of a design, and how much room each leaves."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from spiral_core.message import Message, Quantity
from spiral_core.rounding import signed_percent

# Relative rounding of the searches behind the figures; a limit met to this is met.
TOLERANCE = 1e-9


class Constraint(Enum):
    """The constraints on a design; the value is the name that is printed."""

    STRAIN = "strain limit"
    PRESSURE = "pressure limit"
    OBJECT_LENGTH = "object length"
    LENGTH = "gripper length"
    TURN_CLEARANCE = "clearance between turns"
    SMALLEST_RADIUS = "smallest radius of the actuator"
    LARGEST_RADIUS = "largest radius of the coil"
    TURNS = "turns"
    PAYLOAD = "payload"
    WRAPPED = "objects wrapped with contact"
    TOLERANCE = "shift of the objects"

    @property
    def unit(self) -> str:
        """SI unit of its figures."""
        return _UNITS.get(self, "m")

    @property
    def is_upper(self) -> bool:
        """Whether the figure must stay below its bound (or else above)."""
        return self not in _LOWER

    @property
    def wanted(self) -> str:
        """How the figure must compare with its bound, in words."""
        return "at most" if self.is_upper else "at least"

    @property
    def is_met_just_so(self) -> bool:
        """Whether a design that meets it does so just so, and its margin says nothing."""
        return self in (Constraint.TURNS, Constraint.LARGEST_RADIUS, Constraint.WRAPPED)


_UNITS = {
    Constraint.STRAIN: "1",
    Constraint.PRESSURE: "Pa",
    Constraint.TURNS: "1",
    Constraint.PAYLOAD: "kg",
    Constraint.WRAPPED: "1",
}
_LOWER = (
    Constraint.TURN_CLEARANCE,
    Constraint.LARGEST_RADIUS,
    Constraint.TURNS,
    Constraint.PAYLOAD,
    Constraint.WRAPPED,
    Constraint.TOLERANCE,
)


@dataclass(frozen=True, slots=True)
class Margin:
    """A figure of a design next to its bound.

    Args:
        constraint: what is compared.
        value: the design's figure, in the constraint's unit.
        bound: the limit it must keep, > 0.

    Example:
        >>> margin = Margin(Constraint.PRESSURE, value=120.0e3, bound=100.0e3)
        >>> margin.room, margin.relative, margin.is_met
        (-20000.0, -0.2, False)
    """

    constraint: Constraint
    value: float
    bound: float

    @property
    def room(self) -> float:
        """Distance to the bound in the constraint's unit; negative: violated."""
        return self.bound - self.value if self.constraint.is_upper else self.value - self.bound

    @property
    def relative(self) -> float:
        """``room`` as a fraction of the bound."""
        return self.room / self.bound

    @property
    def is_met(self) -> bool:
        """Whether the bound is kept."""
        return self.relative >= -TOLERANCE

    @property
    def sentence(self) -> str:
        """The comparison in words, for reports."""
        name, wanted, unit = self.constraint.value, self.constraint.wanted, self.constraint.unit
        value, bound = Quantity(self.value, unit), Quantity(self.bound, unit)
        verdict = "met" if self.is_met else "violated"
        share = signed_percent(self.relative)
        return Message("{}: {}, {} {} ({}, {})", name, value, wanted, bound, verdict, share)


def tightest(margins: tuple[Margin, ...]) -> Margin:
    """Return the margin that binds: the smallest relative one of those that the design can choose.

    A constraint that is met just so counts only when it is violated.
    """
    counted = [m for m in margins if not (m.constraint.is_met_just_so and m.is_met)]
    return min(counted or margins, key=lambda margin: margin.relative)
