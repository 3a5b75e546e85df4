# SPDX-License-Identifier: Apache-2.0
"""Quantities for display: in millimeters and kilopascals, or in the units that the user chose."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from types import MappingProxyType
from typing import NamedTuple, ParamSpec, TypeVar

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.message import Message, Quantity
from spiral_core.rod.types import Array
from spiral_core.rounding import rounded_down, rounded_up
from spiral_gripper.files.units import Dimension, convert_from_si

Given = ParamSpec("Given")
Result = TypeVar("Result")


class Scale(NamedTuple):
    """A unit to show figures in.

    Attributes:
        factor: what a figure in SI is multiplied by.
        unit: its name; empty for plain numbers.
    """

    factor: float
    unit: str


# SI unit -> unit that is shown unless the user chose another one.
_USUAL: Mapping[str, Scale] = MappingProxyType(
    {
        "m": Scale(1e3, "mm"),
        "Pa": Scale(1e-3, "kPa"),
        "rad": Scale(180.0 / math.pi, "deg"),
        "N m": Scale(1e3, "N mm"),
        "N m^2": Scale(1e6, "N mm^2"),
        "N/m": Scale(1e-3, "N/mm"),
        "Pa/s": Scale(1e-3, "kPa/s"),
        "1": Scale(1.0, ""),
    }
)
CHOSEN = tuple(Dimension[name] for name in ("PRESSURE", "LENGTH", "ANGLE", "FORCE", "MASS"))
# Larger than this, a number is easier to read in SI.
_LONGEST = 1e5
_present: ContextVar[Mapping[str, Scale]] = ContextVar("units", default=_USUAL)


def dimension_of(unit: str) -> Dimension:
    """Return the dimension of a unit in which figures can be shown.

    Raises:
        InvalidInputError: figures are not shown in it; the message lists the units that there are.

    Example:
        >>> dimension_of("psi").quantity
        'pressure'
    """
    for dimension in CHOSEN:
        if unit in dimension.usual_units:
            return dimension
    known = "; ".join(f"{each.quantity}: {', '.join(each.usual_units)}" for each in CHOSEN)
    raise InvalidInputError("units", unit, f"of these ({known})")


@contextmanager
def display_units(*units: str) -> Iterator[None]:
    """Show figures in these units while the block runs: in tables, reprs and pictures.

    Derived units follow: with psi, rates are in psi/s; with lbf and in, torques are in lbf in. The
    other quantities keep their usual units: kPa, mm, deg, N, kg.

    Args:
        units: at most one for each of pressure, length, angle, force and mass.

    Raises:
        InvalidInputError: one is no such unit, or two measure the same.

    Example:
        >>> with display_units("psi", "in"):
        ...     print(shown(55158.0, "Pa"), shown(0.0254, "m"), axis_label("pressure", "Pa"))
        8 psi 1 in pressure [psi]
    """
    names: dict[Dimension, str] = {}
    for unit in units:
        dimension = dimension_of(unit)
        if dimension in names:
            raise InvalidInputError("units", ",".join(units), f"one unit of {dimension.quantity}")
        names[dimension] = unit
    with units_shown(names):
        yield


@contextmanager
def units_shown(names: Mapping[Dimension, str]) -> Iterator[None]:
    """Show figures of these dimensions in these units while the block runs."""
    named = {
        dimension.si_unit: Scale(convert_from_si(1.0, unit, dimension), unit)
        for dimension, unit in names.items()
    }
    (p, pressure), (f, force), (m, length) = (
        named.get(si) or _USUAL.get(si) or Scale(1.0, si) for si in ("Pa", "N", "m")
    )
    derived = {
        "N m": Scale(f * m, f"{force} {length}"),
        "N m^2": Scale(f * m**2, f"{force} {length}^2"),
        "N/m": Scale(f / m, f"{force}/{length}"),
        "Pa/s": Scale(p, f"{pressure}/s"),
    }
    token = _present.set({**_USUAL, **derived, **named})
    try:
        yield
    finally:
        _present.reset(token)


def in_present_units(function: Callable[Given, Result]) -> Callable[Given, Result]:
    """Return a function that shows figures in the present units in any thread.

    Example:
        >>> with display_units("psi"):
        ...     later = in_present_units(lambda: shown(6894.757, "Pa"))
        >>> later()
        '1 psi'
    """
    present = _present.get()

    @wraps(function)
    def called(*arguments: Given.args, **named: Given.kwargs) -> Result:
        token = _present.set(present)
        try:
            return function(*arguments, **named)
        finally:
            _present.reset(token)

    return called


def scale_of(unit: str) -> Scale:
    """Return the unit in which figures of an SI unit are shown.

    Example:
        >>> scale_of("Pa")
        Scale(factor=0.001, unit='kPa')
    """
    return _present.get().get(unit, Scale(1.0, unit))


def number(value: float, unit: str, digits: int = 4) -> str:
    """Return an SI figure in the unit it is shown in, without the unit's name.

    Example:
        >>> number(0.0111, "m")
        '11.1'
    """
    return f"{scale_of(unit).factor * value:.{digits}g}"


def shown(
    value: float,
    unit: str,
    digits: int = 4,
    rounded: Callable[[float, int], float] | None = None,
) -> str:
    """Return an SI figure in the unit it is shown in, with the unit's name.

    Example:
        >>> shown(0.0111, "m"), shown(44034.0, "Pa"), shown(1.5, "1")
        ('11.1 mm', '44.03 kPa', '1.5')
    """
    factor, name = scale_of(unit)
    if (name == "mm" and abs(value) >= 1.0) or abs(factor * value) >= _LONGEST:
        factor, name = 1.0, "" if unit == "1" else unit
    return Quantity(value, unit, rounded).text(factor, name, digits)


def shown_message(said: object, typed: Mapping[Quantity, str] = MappingProxyType({})) -> str:
    """Return what the mechanics say with its quantities in the units they are shown in.

    Args:
        said: a text or an error; only a :class:`spiral_core.message.Message` has quantities.
        typed: quantities that are written as they were typed.

    Example:
        >>> with display_units("psi"):
        ...     print(shown_message(Message("at most {}", Quantity(6894.757, "Pa"))))
        at most 1 psi
    """
    text = str(said)
    if not isinstance(text, Message):
        return text
    return text.told(lambda q: typed.get(q) or shown(q.value, q.unit, rounded=q.rounded))


def shown_range(low: float, high: float) -> str:
    """Return a range of lengths [m] in the unit shown, its ends rounded into it if it is that long.

    Example:
        >>> shown_range(0.00457668, 0.0378219)
        '4.577 mm to 37.82 mm'
        >>> shown_range(0.030017, 0.030017)
        '30.02 mm to 30.02 mm'
    """
    factor, name = scale_of("m")
    if name == "mm" and high >= 1.0:
        factor, name = 1.0, "m"
    ends = rounded_up(factor * low, 4), rounded_down(factor * high, 4)
    if ends[0] > ends[1]:
        ends = factor * low, factor * high
    return " to ".join(f"{end:.4g} {name}" for end in ends)


def in_units(values: Array | list[float] | float, unit: str) -> Array:
    """Return SI figures in the unit they are shown in, for a picture.

    Example:
        >>> in_units([0.01, 0.02], "m").tolist()
        [10.0, 20.0]
    """
    return scale_of(unit).factor * np.asarray(values, dtype=np.float64)


def axis_label(name: str, unit: str) -> str:
    """Return the label of an axis, with the unit shown.

    Example:
        >>> axis_label("object radius", "m")
        'object radius [mm]'
    """
    return f"{name} [{scale_of(unit).unit}]"
