# SPDX-License-Identifier: Apache-2.0
"""The errors of this package: each carries the figures behind its message as attributes.

Every error keeps its arguments in ``args``, so that it can be pickled between processes. Its
message is one line: what was wrong, which value, and what would be right. The string is a
:class:`spiral_core.message.Message`: a sentence in SI that can be shown in other units.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from numbers import Real

from spiral_core.message import Message, Quantity, joined
from spiral_core.rounding import rounded_down, rounded_up


class ActuationLimit(Enum):
    """Limits of the useful range of an actuation model; the value is the advice to the user."""

    FIBER_LOCKING = (
        "a fiber family has turned as far towards the axis as it can and locks; "
        "wind it at an angle farther from the axis or ask for less stretch"
    )
    STRAIGHT_FIBER_LOCKING = (
        "the straight fiber is too short for the twist; "
        "use an angle nearer 90 degrees, a smaller straight-fiber radius or less stretch"
    )
    VOLUME_MAXIMUM = (
        "the enclosed volume has reached its maximum, where more pressure extends no further; "
        "wind the fibers at angles farther from the axis or ask for less stretch"
    )
    LIMIT_POINT = (
        "the actuator balloons: past this stretch the pressure falls; "
        "use a stiffer or thicker wall, a fiber angle nearer 90 degrees, or less pressure"
    )
    MATERIAL_LIMIT = (
        "the elastomer's chains are fully extended; "
        "use a material with a larger extension limit or ask for less stretch"
    )
    MODEL_END = (
        "the tube is stretched farther than the model follows it; ask for less pressure or stretch"
    )
    DATA_END = "the measured actuation data end here; measure farther or ask for less pressure"


class SpiralError(Exception):
    """Base class of the errors that this package raises."""

    def __post_init__(self) -> None:
        self.args = (*vars(self).values(),)  # of a dataclass: given by name or not


@dataclass(eq=False, repr=False)
class InvalidInputError(SpiralError, ValueError):
    """A value that a caller gave does not meet its requirement.

    Attributes:
        field: name of the offending argument or field.
        value: the value as it was given.
        requirement: what would have been accepted, in words.
        unit: SI unit of the value, or of each of several; ``"1"`` where it has none.
        rounded: rounds the value for the message, outwards where it lies past a bound; None rounds
            to the nearest.

    Example:
        >>> print(InvalidInputError("wall_thickness", -1.0, "a positive finite number"))
        wall_thickness must be a positive finite number, got -1.0
        >>> print(InvalidInputError("pressure", -1.0, "at least 0", "Pa"))
        pressure must be at least 0, got -1 Pa
    """

    field: str
    value: object
    requirement: str
    unit: str = "1"
    rounded: Callable[[float, int], float] | None = None

    def __str__(self) -> str:
        got = _value_text(self.value, self.unit, self.rounded)
        return Message("{} must be {}, got {}", self.field, self.requirement, got)


@dataclass(eq=False, repr=False)
class ActuationLimitError(SpiralError):
    """A pressure or stretch lies past the end of the actuator's useful range.

    Attributes:
        limit: what ends the range; its value is advice.
        quantity: what was asked for: ``"pressure"`` [Pa], ``"stretch"`` or ``"first_invariant"``.
        value: the value asked for.
        bound: the largest value that is allowed.

    Example:
        >>> print(ActuationLimitError(ActuationLimit.DATA_END, "pressure", 2.0e5, 1.5e5))
        ... # doctest: +ELLIPSIS
        pressure 200000 Pa is past its limit 150000 Pa: the measured actuation data end here; ...
    """

    limit: ActuationLimit
    quantity: str
    value: float
    bound: float

    def __str__(self) -> str:
        unit = "Pa" if self.quantity == "pressure" else "1"
        value = Quantity(self.value, unit, rounded_up)
        bound = Quantity(self.bound, unit, rounded_down)
        template = "{} {} is past its limit {}: {}"
        return Message(template, self.quantity, value, bound, self.limit.value)


@dataclass(eq=False, repr=False)
class SolverError(SpiralError):
    """An iteration ended without an answer that can be trusted.

    Attributes:
        status: why it ended; the value of this enumeration member is the user's message.
        residual: what was left of the equation solved, in its own unit.
        iterations: how many iterations were spent.
    """

    status: Enum
    residual: float
    iterations: int

    def __str__(self) -> str:
        return f"{self.status.value} (residual {self.residual:.3g}, {self.iterations} iterations)"


@dataclass(eq=False, repr=False)
class NoCoilError(SpiralError):
    """No pressure within the limits coils the gripper often enough to wrap anything.

    Attributes:
        turns: the most turns it makes with room for an object inside the coil; 0 without any.
        turns_required: the turns that count as a wrap.
        pressure: where it makes them [Pa].
        closes_at: the lowest pressure found at which the coil has closed on itself [Pa]; None if it
            does not. About a given axis it may open again above.
        at_actuator_limit: whether the actuator has no more pressure to give.

    Example:
        >>> print(NoCoilError(0.4, 1.05, 5.0e4, closes_at=None, at_actuator_limit=True))
        the gripper makes 0.4 turns at most (at 50000 Pa) but 1.05 are required; lengthen it or \
ask for fewer turns
    """

    turns: float
    turns_required: float
    pressure: float
    closes_at: float | None = None
    at_actuator_limit: bool = False

    def __str__(self) -> str:
        pressure = Quantity(self.pressure, "Pa")
        if self.turns == 0.0 and self.closes_at is None:
            return Message("no pressure up to {} bends the gripper into a coil", pressure)
        if self.turns == 0.0:
            return Message(
                "no pressure up to {} leaves room for an object inside the coil; take a thinner "
                "tube, or a single fiber that is less steep",
                pressure,
            )
        room, past, stronger = "", "", ", raise the pressure limit"
        if self.closes_at is not None:
            room, stronger = "with room for an object ", ""
            closes_at = Quantity(self.closes_at, "Pa")
            past = Message("; at {} the coil has closed on itself", closes_at)
        elif self.at_actuator_limit:
            stronger = ""
        return Message(
            "the gripper makes {:g} turns at most {}(at {}) but {:.4g} are required{}; "
            "lengthen it{} or ask for fewer turns",
            rounded_down(self.turns, 3),
            room,
            pressure,
            self.turns_required,
            past,
            stronger,
        )


@dataclass(eq=False, repr=False)
class NotGrippableError(SpiralError):
    """No pressure wraps the gripper around an object of this radius.

    Attributes:
        radius: the object's radius [m].
        constraint: the condition that binds, in words.
        margin: how far that condition is missed, in the unit the words give (negative: missed).
        nearest_radius: the nearest radius that can be gripped [m]; None where its radius is not
            the reason. The text rounds it towards the inside of the range.

    Example:
        >>> print(NotGrippableError(0.005, "too thin for the pressure limit", -0.004, 0.009))
        an object of radius 0.005 m cannot be gripped: too thin for the pressure limit; \
the nearest grippable radius is 0.009 m
    """

    radius: float
    constraint: str
    margin: float
    nearest_radius: float | None

    def __str__(self) -> str:
        nearest = self.nearest_radius
        if nearest is None:
            return Message("the object cannot be gripped: {}", self.constraint)
        inward = rounded_up if nearest > self.radius else rounded_down
        return Message(
            "an object of radius {} cannot be gripped: {}; the nearest grippable radius is {}",
            Quantity(self.radius, "m"),
            self.constraint,
            Quantity(nearest, "m", inward),
        )


def _value_text(value: object, unit: str, rounded: Callable[[float, int], float] | None) -> object:
    """Return a value with its unit; without one its repr, on a line of at most 120 characters."""
    if isinstance(value, Message):
        return value
    if unit != "1":
        several = value if isinstance(value, (tuple, list)) else (value,)
        numbers = all(isinstance(one, Real) and not isinstance(one, bool) for one in several)
        if 0 < len(several) <= 6 and numbers:
            return joined(", ", (Quantity(one, unit, rounded) for one in several))
    text = " ".join(repr(value).split())
    return text if len(text) <= 120 else text[:117] + "..."
