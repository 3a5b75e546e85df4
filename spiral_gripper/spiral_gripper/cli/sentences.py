# SPDX-License-Identifier: Apache-2.0
"""Error messages of the command line: in the units and with the option names that were typed."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Final, NamedTuple

from spiral_core.errors import InvalidInputError, NotGrippableError, SpiralError
from spiral_gripper.files.units import Dimension, convert_from_si, parse_quantity, unit_of

# Units in messages of the library, and the units shown unless the user typed another one.
_USUAL: Final = {
    "m": (Dimension.LENGTH, "mm"),
    "Pa": (Dimension.PRESSURE, "kPa"),
    "rad": (Dimension.ANGLE, "deg"),
}
_QUANTITY: Final = re.compile(
    r"(?<![\w.])(?P<number>-?\d+(?:\.\d+)?(?:e[+-]?\d+)?) "
    r"(?P<unit>Pa|rad|m)(?![\w^/·]| [a-zA-Z]*\^)"
)
# Names of the core's arguments that are not those of the options.
_OPTIONS: Final = {
    "turns_required": "turns",
    "fiber_angle_alpha": "alpha",
    "fiber_angles_beta": "beta",
    "betas": "beta",
    "fiber_angles_gamma": "gamma",
    "gammas": "gamma",
    "radii": "radius",
    "friction_coefficient": "friction",
}
# Larger than this in the usual unit, a number is easier to read in SI.
_LONGEST: Final = 1e5


class TypedValue(NamedTuple):
    """A value that was typed.

    Attributes:
        value: the value in SI.
        text: the text that was typed.
        dimension: name of the :class:`spiral_gripper.Dimension`; empty for a plain number.
    """

    value: float
    text: str
    dimension: str


def sentence(error: SpiralError, givens: Mapping[str, list[TypedValue]]) -> str:
    """Return the message of an error in the user's units and with the options' names.

    Args:
        error: raised by the core or by the readers of files.
        givens: what was typed, by the parameter's name.

    Example:
        >>> error = NotGrippableError(0.06, "too thick for 1.05 turns", -0.02218, 0.0378211)
        >>> print(sentence(error, {"radius": [TypedValue(0.06, "6 cm", "LENGTH")]}))
        an object of radius 6 cm cannot be gripped: too thick for 1.05 turns; the nearest \
grippable radius is 3.782 cm
    """
    units = _units(givens)
    if isinstance(error, NotGrippableError):
        return _not_grippable(error, givens, units)
    if isinstance(error, InvalidInputError):
        return _invalid(error, givens, units)
    return _in_units(str(error), units)


def shown_in(value: float, unit: str, units: Mapping[str, str] | None = None) -> str:
    """Return a value as people read it.

    Args:
        value: in SI.
        unit: ``"m"``, ``"Pa"`` or ``"rad"``.
        units: unit wanted by SI unit; the usual one where none is.
    """
    dimension, usual = _USUAL[unit]
    wanted = (units or {}).get(unit, usual)
    converted = convert_from_si(value, wanted, dimension)
    if abs(converted) >= _LONGEST:
        return f"{value:.4g} {unit}"
    return f"{converted:.4g} {wanted}"


def _inward(error: NotGrippableError, units: Mapping[str, str]) -> str:
    """Return the nearest radius with four digits, rounded away from the one that was refused."""
    nearest = error.nearest_radius or 0.0
    text = shown_in(nearest, "m", units)
    shown = parse_quantity(text, Dimension.LENGTH)
    if (shown - nearest) * (error.radius - nearest) <= 0.0:
        return text
    last_digit = 10.0 ** (math.floor(math.log10(nearest)) - 3)
    return shown_in(shown + math.copysign(last_digit, nearest - error.radius), "m", units)


def _not_grippable(
    error: NotGrippableError, givens: Mapping[str, list[TypedValue]], units: Mapping[str, str]
) -> str:
    asked = _typed(error.radius, givens) or shown_in(error.radius, "m", units)
    constraint = _in_units(error.constraint, units)
    text = f"an object of radius {asked} cannot be gripped: {constraint}"
    if error.nearest_radius is None:
        return text
    return f"{text}; the nearest grippable radius is {_inward(error, units)}"


def _invalid(
    error: InvalidInputError, givens: Mapping[str, list[TypedValue]], units: Mapping[str, str]
) -> str:
    """Return a refused value under the option's name, as it was typed."""
    name = _OPTIONS.get(error.field, error.field)
    requirement = _in_units(error.requirement, units)
    for parameter, typed in givens.items():
        if _OPTIONS.get(parameter, parameter) != name:
            continue
        for one in typed:
            if one.value == error.value:
                return f"--{name.replace('_', '-')} must be {requirement}, got {one.text}"
    if error.field == "alpha, beta" and isinstance(error.value, tuple):
        pair = ", ".join(shown_in(angle, "rad", units) for angle in error.value)
        return f"{name} must be {requirement}, got {pair}"
    return _in_units(str(error), units)


def _typed(value: float, givens: Mapping[str, list[TypedValue]]) -> str | None:
    """Return how a value was typed, or None if it was not."""
    every = (one for typed in givens.values() for one in typed)
    return next((one.text for one in every if one.dimension and one.value == value), None)


def _units(givens: Mapping[str, list[TypedValue]]) -> dict[str, str]:
    """Return the unit that was typed first for each kind of quantity, by SI unit."""
    units: dict[str, str] = {}
    for typed in givens.values():
        for one in typed:
            for si, (dimension, _) in _USUAL.items():
                if one.dimension == dimension.name:
                    units.setdefault(si, unit_of(one.text, dimension))
    return units


def _in_units(text: str, units: Mapping[str, str]) -> str:
    """Return a text with its quantities in the user's units."""
    return _QUANTITY.sub(lambda found: shown_in(float(found["number"]), found["unit"], units), text)
