# SPDX-License-Identifier: Apache-2.0
"""Parameters as dataclasses: each field with its type, default, description and range."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields
from enum import Enum
from typing import Any, ClassVar, TypeAlias, TypeVar

from spiral_core.errors import InvalidInputError

ParameterValue: TypeAlias = bool | int | float | str | tuple[float, ...]
ParametersT = TypeVar("ParametersT", bound="Parameters")

# Fastest acceleration that is still believed to be gravity plus the arm's own motion [m/s^2]:
# twice what arms of this payload reach.
GRAVITY_LIMIT = 50.0
# Heaviest object that a goal, a request or a parameter may name [kg].
LARGEST_PAYLOAD = 100.0
GRAVITY_REQUIREMENT = f"3 finite numbers of norm at most {GRAVITY_LIMIT:g} m/s^2"


@dataclass(frozen=True, slots=True)
class ParameterSpec:
    """One parameter: type, default and allowed values.

    Args:
        name: as ``ros2 param`` knows it, with its namespaces: "pressure.cap".
        default: its type is the parameter's type; () is an array of floats that is not set.
        description: what it does, with its unit.
        low, high: bounds of a number, both allowed; a default of NaN allows NaN too: not set.
        choices: what a string may be; empty: anything, but "" only if that is the default.
        read_only: fixed when the node starts.
    """

    name: str
    default: ParameterValue
    description: str
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    read_only: bool = False

    @property
    def span(self) -> str:
        """What a value may be, in words; empty: anything of its type."""
        return ", ".join(self.choices) if self.low is None else f"{self.low:g} to {self.high:g}"


@dataclass(frozen=True, slots=True)
class Parameters:
    """Values of the parameters of a node, each within its range.

    Its subclasses are the tables of parameters: each field is made by :func:`parameter`, or has
    another table as its factory, whose ``NAMESPACE`` is the field's name.

    Raises:
        InvalidInputError: a value is not what its parameter may be.

    Example:
        >>> @dataclass(frozen=True, slots=True)
        ... class Leak(Parameters):
        ...     NAMESPACE = "leak."
        ...     time: float = parameter(0.2, "Time constant [s].", 0.01, 100.0)
        >>> @dataclass(frozen=True, slots=True)
        ... class Valve(Parameters):
        ...     leak: Leak = field(default_factory=Leak)
        >>> Valve.from_names({"leak.time": 0.1}).leak.time, Valve.specs()[0].name
        (0.1, 'leak.time')
        >>> Valve.refusal({"leak.time": float("nan")})
        'leak.time must be a number from 0.01 to 100, got nan'
    """

    # What ROS has before the names of the fields.
    NAMESPACE: ClassVar[str] = ""

    def __post_init__(self) -> None:
        for one in fields(self):
            if one.default_factory is not MISSING:
                continue
            spec, value = self._spec(one), getattr(self, one.name)
            requirement = unmet_requirement(spec, value)
            if requirement is not None:
                raise InvalidInputError(spec.name, value, requirement)

    @classmethod
    def specs(cls) -> tuple[ParameterSpec, ...]:
        """Return the specification of each parameter, those of namespaces included."""
        specs: list[ParameterSpec] = []
        for one in fields(cls):
            kind: Any = one.default_factory
            specs += [cls._spec(one)] if kind is MISSING else kind.specs()
        return tuple(specs)

    @classmethod
    def from_names(cls: type[ParametersT], values: Mapping[str, ParameterValue]) -> ParametersT:
        """Return the parameters with some values, by name; names of others are ignored."""
        given: dict[str, Any] = {}
        for one in fields(cls):
            kind: Any = one.default_factory
            name = cls.NAMESPACE + one.name
            if kind is not MISSING:
                given[one.name] = kind.from_names(values)
            elif name in values:
                given[one.name] = values[name]
        return cls(**given)

    @classmethod
    def refusal(cls, proposed: Mapping[str, ParameterValue]) -> str | None:
        """Return why some values, by name, cannot be set, or None if they can.

        Names of other parameters are not judged.
        """
        try:
            cls.from_names(proposed)
        except InvalidInputError as error:
            return str(error)
        return None

    @classmethod
    def _spec(cls, one: Field[Any]) -> ParameterSpec:
        return ParameterSpec(cls.NAMESPACE + one.name, **one.metadata)


def parameter(
    default: ParameterValue,
    description: str,
    low: float | None = None,
    high: float | None = None,
    **more: Any,  # noqa: ANN401
) -> Any:  # noqa: ANN401
    """Return a field of :class:`Parameters`, with the arguments of :class:`ParameterSpec`."""
    given = {"default": default, "description": description, "low": low, "high": high}
    return field(default=default, metadata=given | more)


def choice(default: Enum, description: str) -> Any:  # noqa: ANN401
    """Return a field that is one of the values of an enumeration."""
    return parameter(default.value, description, choices=tuple(one.value for one in type(default)))


def gravity_problem(components: Iterable[float]) -> str | None:
    """Return what is wrong with three components of gravity [m/s^2], or None.

    Example:
        >>> gravity_problem((0.0, 0.0, 98.1))
        'gravity must be 3 finite numbers of norm at most 50 m/s^2, got (0.0, 0.0, 98.1)'
    """
    vector = tuple(components)
    if len(vector) == 3 and math.hypot(*vector) <= GRAVITY_LIMIT:  # not NaN
        return None
    return str(InvalidInputError("gravity", vector, GRAVITY_REQUIREMENT))


def may_be_unset(spec: ParameterSpec) -> bool:
    """Return whether a parameter is a number that is not set by default."""
    return isinstance(spec.default, float) and math.isnan(spec.default)


def unmet_requirement(spec: ParameterSpec, value: ParameterValue) -> str | None:
    """Return what a value of a parameter would have to be, or None if it is that."""
    low, high = spec.low, spec.high
    if low is not None and high is not None:
        is_unset = may_be_unset(spec) and value != value
        is_within = isinstance(value, (int, float)) and low <= value <= high
        if isinstance(value, bool) or not (is_unset or is_within):
            return f"a number from {low:g} to {high:g}"
    if spec.choices and value not in spec.choices:
        return f"one of {', '.join(spec.choices)}"
    if isinstance(spec.default, str) and spec.default and not value:
        return "text that is not empty"
    if isinstance(spec.default, tuple) and isinstance(value, tuple) and value:
        return None if gravity_problem(value) is None else GRAVITY_REQUIREMENT
    return None
