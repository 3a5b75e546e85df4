# SPDX-License-Identifier: Apache-2.0
"""Error messages of the command line: in the units and with the option names that were typed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final, NamedTuple

from spiral_core.errors import InvalidInputError, NotGrippableError, SpiralError
from spiral_core.rounding import rounded_down, rounded_up
from spiral_gripper.files.errors import FileProblemsError
from spiral_gripper.files.shown import reworded, scale_of, shown, units_shown
from spiral_gripper.files.units import Dimension, unit_of

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
    with units_shown(typed_units(givens)):
        if isinstance(error, NotGrippableError):
            return _not_grippable(error, givens)
        if isinstance(error, InvalidInputError):
            return _invalid(error, givens)
        if isinstance(error, FileProblemsError):  # what a file says is quoted as it is written
            parts = (line.partition(", got ") for line in str(error).splitlines())
            return "\n".join(f"{reworded(reason)}{got}{value}" for reason, got, value in parts)
        return reworded(str(error))


def _not_grippable(error: NotGrippableError, givens: Mapping[str, list[TypedValue]]) -> str:
    """Return what cannot be gripped; the nearest radius is rounded away from the refused one."""
    asked = _typed(error.radius, givens) or shown(error.radius, "m")
    text = f"an object of radius {asked} cannot be gripped: {reworded(error.constraint)}"
    if error.nearest_radius is None:
        return text
    factor, unit = scale_of("m")
    inward = rounded_down if error.radius > error.nearest_radius else rounded_up
    nearest = inward(factor * error.nearest_radius, 4)
    return f"{text}; the nearest grippable radius is {nearest:.4g} {unit}"


def _invalid(error: InvalidInputError, givens: Mapping[str, list[TypedValue]]) -> str:
    """Return a refused value under the option's name, as it was typed."""
    name, requirement = _OPTIONS.get(error.field, error.field), reworded(error.requirement)
    for parameter, typed in givens.items():
        if _OPTIONS.get(parameter, parameter) != name:
            continue
        for one in typed:
            if one.value == error.value:
                told = re.sub(r"\w+_\w+", lambda word: _option(word[0], givens), requirement)
                return f"{_option(parameter, givens)} must be {told}, got {one.text}"
    if error.field == "alpha, beta" and isinstance(error.value, tuple):
        pair = ", ".join(shown(angle, "rad") for angle in error.value)
        return f"{name} must be {requirement}, got {pair}"
    return reworded(str(error))


def _option(parameter: str, givens: Mapping[str, list[TypedValue]]) -> str:
    """Return the option of a parameter that was typed; other words as they are."""
    if parameter not in givens:
        return parameter
    return f"--{_OPTIONS.get(parameter, parameter).replace('_', '-')}"


def _typed(value: float, givens: Mapping[str, list[TypedValue]]) -> str | None:
    """Return how a value was typed, or None if it was not."""
    every = (one for typed in givens.values() for one in typed)
    return next((one.text for one in every if one.dimension and one.value == value), None)


def typed_units(givens: Mapping[str, list[TypedValue]]) -> dict[Dimension, str]:
    """Return the unit that was typed first for each kind of quantity."""
    units: dict[Dimension, str] = {}
    for one in (one for typed in givens.values() for one in typed if one.dimension):
        dimension = Dimension[one.dimension]
        units.setdefault(dimension, unit_of(one.text, dimension))
    return units
