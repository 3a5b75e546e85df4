# SPDX-License-Identifier: Apache-2.0
"""Checks of arguments: each returns the value as a plain float, or raises InvalidInputError.

All checks refuse NaN, infinities, booleans and strings.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from contextlib import suppress
from numbers import Real
from typing import Any

from spiral_core.errors import InvalidInputError
from spiral_core.message import Message, Quantity
from spiral_core.rounding import rounded_down, rounded_up

# A direction that a file states with about seven digits still counts as a unit vector.
UNIT_NORM_TOLERANCE = 1e-6
# What differs by less from one is one: it stays as it is, however often it is kept.
ROUNDING = 1e-15


def require_finite(field: str, value: object) -> float:
    """Return ``value`` as a float if it is a finite real number.

    Args:
        field: name to put into the error.
        value: any object; a bool is not a number here.

    Returns:
        The value as a float, unchanged.

    Raises:
        InvalidInputError: not a real number, NaN or infinite.

    Example:
        >>> require_finite("torsion", -3)
        -3.0
    """
    return _checked(field, value, "a finite number")


def require_positive(field: str, value: object) -> float:
    """Return ``value`` as a float if it is finite and > 0; otherwise raise InvalidInputError.

    Example:
        >>> require_positive("length", 0.36)
        0.36
    """
    requirement = "a positive finite number"
    number = _checked(field, value, requirement)
    if not number > 0.0:
        raise InvalidInputError(field, value, requirement)
    return number


def require_non_negative(field: str, value: object) -> float:
    """Return ``value`` as a float if it is finite and >= 0; otherwise raise InvalidInputError.

    Example:
        >>> require_non_negative("pressure", 0)
        0.0
    """
    requirement = "a non-negative finite number"
    number = _checked(field, value, requirement)
    if not number >= 0.0:
        raise InvalidInputError(field, value, requirement)
    return number


def require_in_range(field: str, value: object, low: float, high: float, unit: str = "1") -> float:
    """Return ``value`` as a float if ``low <= value <= high``; otherwise raise InvalidInputError.

    The unit is that of all three, for the message.

    Example:
        >>> require_in_range("friction_coefficient", 0.5, 0.0, 2.0)
        0.5
    """
    if type(value) is float and low <= value <= high and math.isfinite(value):
        return value
    ends = Quantity(low, unit, rounded_up), Quantity(high, unit, rounded_down)
    requirement = Message("a number from {} to {}", *ends)
    number = _checked(field, value, requirement)
    if not low <= number <= high:
        outwards = rounded_up if number > high else rounded_down
        raise InvalidInputError(field, value, requirement, unit, outwards)
    return number


def require_vector(field: str, value: object, size: int) -> tuple[float, ...]:
    """Return ``value`` as a tuple of ``size`` floats.

    Args:
        field: name to put into the error.
        value: a list, tuple or one-dimensional array of finite real numbers.
        size: how many components it must have.

    Returns:
        The components, unchanged.

    Raises:
        InvalidInputError: another number of components, or one that is not a finite number.

    Example:
        >>> require_vector("gravity", [0, 0, -9.81], 3)
        (0.0, 0.0, -9.81)
    """
    if (
        type(value) is tuple
        and len(value) == size
        and all(type(item) is float and -math.inf < item < math.inf for item in value)
    ):
        return value  # the usual case, told without a call for each
    requirement = f"{size} finite numbers"
    if not isinstance(value, Iterable) or isinstance(value, bytes | Set | Mapping | Iterator):
        raise InvalidInputError(field, value, requirement)
    try:
        components = tuple(_checked(field, item, requirement) for item in value)
    except (InvalidInputError, TypeError):  # numpy refuses to iterate a 0-d array with TypeError
        raise InvalidInputError(field, value, requirement) from None
    if len(components) != size:
        raise InvalidInputError(field, value, requirement)
    return components


def keep_vector(owner: object, field: str, size: int) -> None:
    """Check a field of a frozen dataclass and keep it as a tuple: arrays have no truth value.

    Raises:
        InvalidInputError: it is no vector of this size.
    """
    object.__setattr__(owner, field, require_vector(field, getattr(owner, field), size))


def keep_unit_vector(owner: object, field: str, size: int = 3) -> None:
    """Check a field of a frozen dataclass as :func:`require_unit_vector`, and keep what it returns.

    Raises:
        InvalidInputError: it is no unit vector of this size.
    """
    object.__setattr__(owner, field, require_unit_vector(field, getattr(owner, field), size))


def require_direction(field: str, value: object) -> tuple[float, float, float]:
    """Return the unit vector along three components.

    Args:
        field: name to put into the error.
        value: a list, tuple or one-dimensional array of finite real numbers, of any length > 0.

    Raises:
        InvalidInputError: it is no vector, or zero.

    Example:
        >>> require_direction("object_axis", [0.0, 3.0, 4.0])
        (0.0, 0.6, 0.8)
    """
    x, y, z = require_vector(field, value, 3)
    norm = require_positive(f"norm of {field}", math.hypot(x, y, z))
    return (x / norm, y / norm, z / norm)


def require_unit_vector(field: str, value: object, size: int = 3) -> tuple[float, ...]:
    """Return ``value`` as a tuple of norm 1 to rounding; it must have norm 1 to 1e-6 already.

    Raises:
        InvalidInputError: not ``size`` finite numbers, or of another norm.

    Example:
        >>> require_unit_vector("object_axis", (0.6, 0.0, 0.8))
        (0.6, 0.0, 0.8)
    """
    components = require_vector(field, value, size)
    norm = math.hypot(*components)
    if not abs(norm - 1.0) <= UNIT_NORM_TOLERANCE:
        raise InvalidInputError(field, value, f"{size} numbers whose norm is 1")
    if abs(norm - 1.0) < ROUNDING:
        return components
    return tuple(component / norm for component in components)


def require_all(
    field: str, values: Sequence[Any], kinds: tuple[type, ...], what: str
) -> Sequence[Any]:
    """Return a tuple or list whose values are all of one of the kinds.

    Raises:
        InvalidInputError: it is not.
    """
    if not isinstance(values, (tuple, list)) or not all(isinstance(v, kinds) for v in values):
        raise InvalidInputError(field, values, f"a tuple of {what}")
    return values


def require_kind(field: str, value: object, *kinds: type) -> None:
    """Refuse what is not of one of the kinds.

    Example:
        >>> require_kind("radius", "20 mm", int, float)
        Traceback (most recent call last):
        ...
        spiral_core.errors.InvalidInputError: radius must be an int or float, got '20 mm'
    """
    if not isinstance(value, kinds):
        names = " or ".join(kind.__name__ for kind in kinds)
        article = "an" if names[0] in "AEIOUaeiou" else "a"
        raise InvalidInputError(field, value, f"{article} {names}")


def _checked(field: str, value: object, requirement: str) -> float:
    """Return ``value`` as a finite float, or raise with the caller's ``requirement``."""
    number = math.nan
    if type(value) is float:  # almost always, and much faster to tell than the general case
        number = value
    elif isinstance(value, Real) and not isinstance(value, bool):
        with suppress(OverflowError):  # an int past the largest float
            number = float(value)
    if not math.isfinite(number):
        raise InvalidInputError(field, value, requirement)
    return number
