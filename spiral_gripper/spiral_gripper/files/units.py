# SPDX-License-Identifier: Apache-2.0
"""Quantities with units: text such as ``"4.7625 mm"`` to SI numbers.

A quantity is one decimal number or one fraction ("3/16 in"), then a product of units with small
whole exponents. The units are those of :data:`UNITS`: metric ones with their prefixes, and the
inch-pound units of tubes, gauges and scales. A library of units costs a tenth of a second to load.
"""

from __future__ import annotations

import difflib
import math
import re
from decimal import Decimal
from enum import Enum
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from spiral_core import InvalidInputError
from spiral_core.validation import require_finite

PLAIN_NUMBER = "a plain finite number, such as 1.05 (no unit, no percent)"

# A longer exponent is no length of anything, and would leave the range of decimals.
_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?"
_DECIMAL = re.compile(_NUMBER)
_DECIMAL_COMMA = re.compile(r"\s*[+-]?[0-9]+,(?![0-9]{3}\b)[0-9]+[^0-9,.]*$")
_QUANTITY = re.compile(
    rf"(?P<number>{_NUMBER})(?:/(?P<divisor>0*[1-9][0-9]*))?\s*(?P<unit>[^\s0-9.,+/-].*)"
)
_SYMBOL = r"[A-Za-zµμ°%][A-Za-zµμ]*(?:_[A-Za-z0-9]+)*"
_FACTOR = re.compile(
    rf"(?P<joint>^|[ \t]*[*/·][ \t]*|[ \t]+)(?P<symbol>{_SYMBOL})"
    r"(?:(?:\^|\*\*)(?P<power>-?[1-9])|(?P<bare>-?[2-4])(?![A-Za-z0-9_]))?"
)
# Units of absolute pressure, and units that state gauge pressure explicitly.
_GAUGE = "pressures are gauge pressures: "
_REFERENCED = {
    "psia": f'{_GAUGE}subtract 14.7 psi and write "psi"',
    "bara": f'{_GAUGE}subtract 1.013 bar and write "bar"',
    "bar(a)": f'{_GAUGE}subtract 1.013 bar and write "bar"',
    "kpaa": f'{_GAUGE}subtract 101.3 kPa and write "kPa"',
    "psig": f'{_GAUGE}write "psi"',
    "barg": f'{_GAUGE}write "bar"',
    "bar(g)": f'{_GAUGE}write "bar"',
    "kpag": f'{_GAUGE}write "kPa"',
}
_SUPERSCRIPTS = str.maketrans({"²": "2", "³": "3", "⁴": "4", "μ": "µ"})

# Unit, its size in SI units, exponents of meter, kilogram, second and radian. The first seven take
# the prefixes below.
_TABLE = """
m 1 1 0 0 0
g 0.001 0 1 0 0
s 1 0 0 1 0
rad 1 0 0 0 1
N 1 1 1 -2 0
Pa 1 -1 1 -2 0
bar 1e5 -1 1 -2 0
in,inch,inches 0.0254 1 0 0 0
ft,foot,feet 0.3048 1 0 0 0
thou,mil 0.0000254 1 0 0 0
deg,degree,degrees,° 0.01745329251994329576923690768 0 0 0 1
turn 6.283185307179586476925286767 0 0 0 1
lb 0.45359237 0 1 0 0
oz 0.028349523125 0 1 0 0
lbf 4.4482216152605 1 1 -2 0
kgf 9.80665 1 1 -2 0
gram_force,gf 0.00980665 1 1 -2 0
psi 6894.757293168361336722673443 -1 1 -2 0
atm 101325 -1 1 -2 0
torr 133.3223684210526315789473684 -1 1 -2 0
mmHg 133.322387415 -1 1 -2 0
inHg 3386.38864034 -1 1 -2 0
standard_gravity 9.80665 1 0 -2 0
min,minute 60 0 0 1 0
h 3600 0 0 1 0
"""
_PREFIXES = "n 1e-9,µ 1e-6,u 1e-6,m 1e-3,c 1e-2,d 0.1,h 1e2,k 1e3,M 1e6,G 1e9"
_PREFIXED = 7
# What a unit measures: exponents of meter, kilogram, second and radian.
Exponents = tuple[int, ...]


def _all_units() -> dict[str, tuple[Decimal, Exponents]]:
    """Return the size of every unit in SI units, and what it measures."""
    units = {}
    for count, line in enumerate(_TABLE.split("\n")[1:-1]):
        names, size, *exponents = line.split()
        kind = tuple(int(exponent) for exponent in exponents)
        units.update(dict.fromkeys(names.split(","), (Decimal(size), kind)))
        if count < _PREFIXED:
            for prefix, scale in (each.split() for each in _PREFIXES.split(",")):
                units[f"{prefix}{names}"] = (Decimal(scale) * Decimal(size), kind)
    return units


UNITS = MappingProxyType(_all_units())
_RATIOS = frozenset({"%", "percent", "dB", "ppm"})


class Dimension(Enum):
    """The dimension of a quantity: its name, SI unit, and usual units.

    Example:
        >>> Dimension.PRESSURE.si_unit, Dimension.PRESSURE.usual_units
        ('Pa', ('kPa', 'psi', 'bar', 'mbar', 'MPa', 'Pa'))
    """

    LENGTH = ("length", "m", "4.7625 mm", ("mm", "in", "cm", "m", "ft"))
    PRESSURE = ("pressure", "Pa", "55 kPa", ("kPa", "psi", "bar", "mbar", "MPa", "Pa"))
    ANGLE = ("angle", "rad", "60 deg", ("deg", "rad"))
    DENSITY = ("density", "kg/m^3", "0.94 g/cm^3", ("g/cm^3", "kg/m^3"))
    ACCELERATION = ("acceleration", "m/s^2", "9.81 m/s^2", ("m/s^2", "standard_gravity"))
    FLEXURAL_STIFFNESS = ("stiffness", "N m^2", "2e-4 N m^2", ("N m^2", "N mm^2"))
    CURVATURE = ("curvature", "rad/m", "20 rad/m", ("rad/m", "deg/m"))
    MASS = ("mass", "kg", "200 g", ("g", "kg", "lb", "oz"))
    FORCE = ("force", "N", "2 N", ("N", "mN", "kN", "lbf", "gram_force"))
    TIME = ("time", "s", "2 s", ("s", "ms", "min"))
    PRESSURE_RATE = ("pressure rate", "Pa/s", "20 kPa/s", ("kPa/s", "psi/s", "bar/s", "Pa/s"))
    MASS_PER_LENGTH = ("mass per length", "kg/m", "1.5 g/m", ("g/m", "kg/m"))

    def __init__(
        self, quantity: str, si_unit: str, example: str, usual_units: tuple[str, ...]
    ) -> None:
        self.quantity = quantity
        self.si_unit = si_unit
        self.example = example
        self.usual_units = usual_units

    @property
    def requirement(self) -> str:
        """The form of a value of this dimension, to complete "must be ..."."""
        return f'{self.noun} with its unit, such as "{self.example}"'

    @property
    def noun(self) -> str:
        """The quantity with its article, such as ``a length``."""
        return f"{'an' if self.quantity[0] in 'aeiou' else 'a'} {self.quantity}"


def parse_quantity(text: object, dimension: Dimension, field: str | None = None) -> float:
    """Return a quantity written as text, in SI units.

    Args:
        text: a number or fraction and a unit: ``"4.7625 mm"``, ``"3/16 in"``, ``"1e-4 N m^2"``.
            Anything but text is refused: a bare number has no unit.
        dimension: what the quantity must measure.
        field: name to put into the error; the dimension's own name if not given.

    Returns:
        The value in ``dimension.si_unit``, rounded once.

    Raises:
        InvalidInputError: no unit, an unknown unit, a unit of another dimension, not a number,
            or not finite. Percent is refused in every dimension.

    Example:
        >>> parse_quantity("8 psi", Dimension.PRESSURE)
        55158.05834534689
        >>> parse_quantity(8, Dimension.PRESSURE)
        Traceback (most recent call last):
            ...
        spiral_core.errors.InvalidInputError: pressure must be a pressure with its unit, such as \
"55 kPa" (write "8 kPa" or "8 psi" or whichever unit is meant), got 8
    """
    name = dimension.quantity if field is None else field
    magnitude, unit = _split(text, dimension, name)
    try:
        factor = _si_factor(unit, dimension)
    except _UnitProblemError as problem:
        requirement = f"{dimension.requirement} ({problem})"
        raise InvalidInputError(name, text, requirement) from None
    value = float(magnitude * factor)
    if not math.isfinite(value):
        raise InvalidInputError(name, text, f"{dimension.requirement}, and finite")
    return value


def parse_number(text: str, field: str = "number") -> float:
    """Return a plain decimal number written as text; a refusal names the field.

    Raises:
        InvalidInputError: a unit, percent or anything else beside the number, or not finite.

    Example:
        >>> parse_number("1.05")
        1.05
    """
    if _DECIMAL.fullmatch(text) is None or not math.isfinite(float(text)):
        raise InvalidInputError(field, text, PLAIN_NUMBER)
    return float(text)


def unit_of(text: str, dimension: Dimension) -> str:
    """Return the unit a quantity was written in, as written.

    Raises:
        InvalidInputError: ``text`` is not a number and a unit.

    Example:
        >>> unit_of("8 psi", Dimension.PRESSURE)
        'psi'
    """
    return _split(text, dimension, dimension.quantity)[1]


def convert_from_si(value: float, unit: str, dimension: Dimension) -> float:
    """Return an SI value expressed in another unit of the same dimension.

    Args:
        value: the value in ``dimension.si_unit``.
        unit: the unit wanted, such as ``"psi"``.
        dimension: what the value measures.

    Raises:
        InvalidInputError: ``unit`` is unknown or measures something else.

    Example:
        >>> convert_from_si(0.5, "mm", Dimension.LENGTH)
        500.0
    """
    size = Decimal(require_finite(dimension.quantity, value))
    try:
        return float(size / _si_factor(unit, dimension))
    except _UnitProblemError as problem:
        requirement = f"a unit of {dimension.quantity} ({problem})"
        raise InvalidInputError("unit", unit, requirement) from None


class _UnitProblemError(Exception):
    """Why a unit cannot be used; the text completes a requirement in parentheses."""


def _split(text: object, dimension: Dimension, name: str) -> tuple[Decimal, str]:
    """Return the number and the unit's text of a quantity."""
    match = _QUANTITY.fullmatch(text.strip()) if isinstance(text, str) else None
    if match is not None:
        return Decimal(match["number"]) / Decimal(match["divisor"] or 1), match["unit"]
    hint, first, second = "", *dimension.usual_units[:2]
    if _DECIMAL_COMMA.match(str(text)):
        hint = f' (decimals follow a point, not a comma: "{str(text).replace(",", ".")}")'
    elif _DECIMAL.fullmatch(str(text)):
        hint = f' (write "{text} {first}" or "{text} {second}" or whichever unit is meant)'
    raise InvalidInputError(name, text, dimension.requirement + hint)


def _si_factor(unit_text: str, dimension: Dimension) -> Decimal:
    """Return the SI value of one ``unit_text``."""
    if unit_text.casefold() in _REFERENCED and dimension is Dimension.PRESSURE:
        raise _UnitProblemError(_REFERENCED[unit_text.casefold()])
    for ratio in re.findall(_SYMBOL, unit_text):
        if ratio in _RATIOS:
            raise _UnitProblemError(f'"{ratio}" is a ratio, not {dimension.noun}')
    factor, kind = _unit(unit_text, dimension)
    if kind != _unit(dimension.si_unit, dimension)[1]:
        measured = next((d.noun for d in Dimension if _unit(d.si_unit, d)[1] == kind), "")
        found = f"is {measured}, " if measured else "is "
        suggestion = _suggestion(unit_text, dimension, exact=True)
        raise _UnitProblemError(f'"{unit_text}" {found}not {dimension.noun}{suggestion}')
    return factor


@lru_cache(maxsize=256)
def _unit(unit_text: str, dimension: Dimension) -> tuple[Decimal, Exponents]:
    """Return the SI value of a product of units, and what it measures."""
    text, place = unit_text.translate(_SUPERSCRIPTS), 0
    factors = []
    while place < len(text):
        found = _FACTOR.match(text, place)
        if found is None or (place == 0) != (found["joint"] == ""):
            raise _UnitProblemError(f'"{unit_text}" is not a unit')
        power = int(found["power"] or found["bare"] or 1)
        factors.append((found["symbol"], -power if "/" in found["joint"] else power))
        place = found.end()
    size, total = Decimal(1), np.zeros(4, dtype=int)
    for symbol, power in factors:
        factor, kind = _known(symbol, unit_text, dimension)
        size *= factor**power
        total += power * np.array(kind)
    return size, tuple(total.tolist())


def _known(symbol: str, unit_text: str, dimension: Dimension) -> tuple[Decimal, Exponents]:
    """Return a unit of the table; letters may be in the wrong case if only one can be meant."""
    if symbol in UNITS:
        return UNITS[symbol]
    meant = [name for name in UNITS if name.casefold() == symbol.casefold()]
    if len(meant) == 1 and len(symbol) > 1:
        return UNITS[meant[0]]
    suggestion = _suggestion(unit_text, dimension)
    raise _UnitProblemError(f'there is no unit "{symbol}"{suggestion}')


def _suggestion(unit_text: str, dimension: Dimension, exact: bool = False) -> str:
    """Return ``; did you mean "psi"?`` if a usual unit is near (or differs only in its case)."""
    usual = {unit.casefold(): unit for unit in dimension.usual_units}
    matches = difflib.get_close_matches(unit_text.casefold(), usual, 1, 1.0 if exact else 0.6)
    return f'; did you mean "{usual[matches[0]]}"?' if matches else ""
