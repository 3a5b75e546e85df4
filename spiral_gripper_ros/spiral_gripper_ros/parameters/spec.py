# SPDX-License-Identifier: Apache-2.0
"""The specification of one parameter: type, default and allowed values."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

from spiral_core.errors import InvalidInputError

ParameterValue: TypeAlias = bool | int | float | str | tuple[float, ...]

# Fastest acceleration that is still believed to be gravity plus the arm's own motion [m/s^2]:
# twice what arms of this payload reach.
GRAVITY_LIMIT = 50.0
GRAVITY_REQUIREMENT = f"3 finite numbers of norm at most {GRAVITY_LIMIT:g} m/s^2"


@dataclass(frozen=True, slots=True)
class ParameterSpec:
    """One parameter: type, default and allowed values.

    Args:
        name: as ``ros2 param`` knows it.
        default: its type is the parameter's type; () is an array of floats that is not set.
        description: what it does, with its unit.
        low, high: bounds of a number, both allowed; a default of NaN allows NaN too: not set.
        choices: what a string may be; empty: anything but "".
        read_only: fixed when the node starts.
    """

    name: str
    default: ParameterValue
    description: str
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    read_only: bool = False


def number_spec(
    name: str, default: float, low: float, high: float, text: str, *, read_only: bool = False
) -> ParameterSpec:
    """Return the parameter of a number between two bounds, with its description."""
    return ParameterSpec(name, default, text, low=low, high=high, read_only=read_only)


def choice_spec(name: str, default: Enum, text: str) -> ParameterSpec:
    """Return the parameter of one of the values of an enumeration."""
    return ParameterSpec(
        name, default.value, text, choices=tuple(policy.value for policy in type(default))
    )


def gravity_problem(components: Iterable[float]) -> str | None:
    """Return what is wrong with three components of gravity [m/s^2], or None.

    Example:
        >>> gravity_problem((0.0, 0.0, 98.1))
        'gravity must be 3 finite numbers of norm at most 50 m/s^2, got (0.0, 0.0, 98.1)'
    """
    vector = tuple(components)
    if (
        len(vector) == 3
        and all(map(math.isfinite, vector))
        and math.hypot(*vector) <= GRAVITY_LIMIT
    ):
        return None
    return str(InvalidInputError("gravity", vector, GRAVITY_REQUIREMENT))


def may_be_unset(spec: ParameterSpec) -> bool:
    """Return whether a parameter is a number that is not set by default."""
    return isinstance(spec.default, float) and math.isnan(spec.default)


def unmet_requirement(spec: ParameterSpec, value: ParameterValue) -> str | None:
    """Return what a value of a parameter would have to be, or None if it is that."""
    low, high = spec.low, spec.high
    if may_be_unset(spec) and isinstance(value, float) and math.isnan(value):
        return None
    if low is not None and high is not None and not _is_within(value, low, high):
        return f"a number from {low:g} to {high:g}"
    if spec.choices and value not in spec.choices:
        return f"one of {', '.join(spec.choices)}"
    if isinstance(spec.default, str) and not value:
        return "text that is not empty"
    if isinstance(spec.default, tuple) and isinstance(value, tuple) and value:
        return None if gravity_problem(value) is None else GRAVITY_REQUIREMENT
    return None


def _is_within(value: ParameterValue, low: float, high: float) -> bool:
    """Return whether a value is a number within bounds; true and false are none."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and low <= value <= high
