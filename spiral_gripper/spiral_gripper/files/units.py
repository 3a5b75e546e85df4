# SPDX-License-Identifier: Apache-2.0
"""Quantities with units: text such as ``"4.7625 mm"`` to SI numbers.

The grammar is deliberately narrower than pint's: one decimal number or one fraction ("3/16 in"),
then a product of units with small whole exponents. Pint alone would read "1,5 mm" as 15 mm,
"±3 mm" as 3 mm, and compute sums and powers.
"""

from __future__ import annotations

import difflib
import math
import re
from decimal import Decimal
from enum import Enum
from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from spiral_core import InvalidInputError
from spiral_core.validation import require_finite

if TYPE_CHECKING:
    import pint

PLAIN_NUMBER = "a plain finite number, such as 1.05 (no unit, no percent)"

# A longer exponent is no length of anything, and would leave the range of decimals.
_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?"
_DECIMAL = re.compile(_NUMBER)
_DECIMAL_COMMA = re.compile(r"\s*[+-]?[0-9]+,(?![0-9]{3}\b)[0-9]+[^0-9,.]*$")
_QUANTITY = re.compile(
    rf"(?P<number>{_NUMBER})(?:/(?P<divisor>0*[1-9][0-9]*))?\s*(?P<unit>[^\s0-9.,+/-].*)"
)
_SYMBOL = r"[A-Za-zµμ°%][A-Za-zµμ]*(?:_[A-Za-z0-9]+)*"
_FACTOR = rf"{_SYMBOL}(?:(?:\^|\*\*)-?[1-9]|-?[2-4])?"
_UNIT = re.compile(rf"{_FACTOR}(?:[ \t]*[*/·][ \t]*{_FACTOR}|[ \t]+{_FACTOR})*")
_BARE_EXPONENT = re.compile(rf"(?P<symbol>{_SYMBOL})(?P<exponent>-?[2-4])(?![A-Za-z0-9_])")
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
_PSI, _DEGREE = "6894.757293168361336722673443", "0.01745329251994329576923690768"
# The usual units in SI units, with all the digits that pint gives. Importing pint and building its
# registry takes longer than many answers: only other units need it.
_USUAL_FACTORS = MappingProxyType(
    {
        "mm": "0.001", "in": "0.0254", "cm": "0.01", "m": "1", "ft": "0.3048",
        "kPa": "1e3", "psi": _PSI, "bar": "1e5", "mbar": "1e2", "MPa": "1e6", "Pa": "1",
        "deg": _DEGREE, "rad": "1", "g/cm^3": "1e3", "kg/m^3": "1",
        "m/s^2": "1", "standard_gravity": "9.80665", "N m^2": "1", "N mm^2": "1e-6",
        "rad/m": "1", "deg/m": _DEGREE,
        "g": "0.001", "kg": "1", "lb": "0.45359237", "oz": "0.028349523125",
        "N": "1", "mN": "0.001", "kN": "1e3", "lbf": "4.4482216152605", "gram_force": "0.00980665",
        "s": "1", "ms": "0.001", "min": "60",
        "kPa/s": "1e3", "psi/s": _PSI, "bar/s": "1e5", "Pa/s": "1", "g/m": "0.001", "kg/m": "1",
    }
)  # fmt: skip
_SUPERSCRIPTS = str.maketrans({"²": "2", "³": "3", "⁴": "4"})


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


def parse_number(text: str) -> float:
    """Return a plain decimal number written as text.

    Raises:
        InvalidInputError: a unit, percent or anything else beside the number, or not finite.

    Example:
        >>> parse_number("1.05")
        1.05
    """
    if _DECIMAL.fullmatch(text) is None or not math.isfinite(float(text)):
        raise InvalidInputError("number", text, PLAIN_NUMBER)
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
    try:
        return float(
            Decimal(require_finite(dimension.quantity, value)) / _si_factor(unit, dimension)
        )
    except _UnitProblemError as problem:
        requirement = f"a unit of {dimension.quantity} ({problem})"
        raise InvalidInputError("unit", unit, requirement) from None


class _UnitProblemError(Exception):
    """Why a unit cannot be used; the text completes a requirement in parentheses."""


def _split(text: object, dimension: Dimension, name: str) -> tuple[Decimal, str]:
    """Return the number and the unit's text of a quantity."""
    match = _QUANTITY.fullmatch(text.strip()) if isinstance(text, str) else None
    if match is None:
        hint = _hint(text, dimension)
        raise InvalidInputError(name, text, dimension.requirement + hint)
    return Decimal(match["number"]) / Decimal(match["divisor"] or 1), match["unit"]


def _hint(text: object, dimension: Dimension) -> str:
    """Return how a decimal comma or a number without a unit is written; nothing for other texts."""
    if _DECIMAL_COMMA.match(str(text)) is not None:
        return f' (decimals follow a point, not a comma: "{str(text).replace(",", ".")}")'
    if _DECIMAL.fullmatch(str(text)) is None:
        return ""
    first, second = dimension.usual_units[:2]
    return f' (write "{text} {first}" or "{text} {second}" or whichever unit is meant)'


@lru_cache(maxsize=256)
def _si_factor(unit_text: str, dimension: Dimension) -> Decimal:
    """Return the SI value of one ``unit_text``."""
    if unit_text in dimension.usual_units:
        return Decimal(_USUAL_FACTORS[unit_text])
    return _parsed_factor(unit_text, dimension)


def _parsed_factor(unit_text: str, dimension: Dimension) -> Decimal:
    """Return the SI value of any unit, by pint."""
    if unit_text.casefold() in _REFERENCED and dimension is Dimension.PRESSURE:
        raise _UnitProblemError(_REFERENCED[unit_text.casefold()])
    text = unit_text.translate(_SUPERSCRIPTS)
    if _UNIT.fullmatch(text) is None:
        raise _UnitProblemError(f'"{unit_text}" is not a unit')
    text = _BARE_EXPONENT.sub(r"\g<symbol>^\g<exponent>", text)
    registry = _registry()
    for symbol in re.findall(_SYMBOL, text):
        if _base_units(symbol, dimension) == registry.dimensionless:
            raise _UnitProblemError(f'"{symbol}" is a ratio, not {dimension.noun}')
    base = _base_units(text, dimension)
    if base != _base_units(dimension.si_unit, dimension):
        raise _UnitProblemError(
            f'"{unit_text}" is {_kind_of(base)}, not {dimension.noun}'
            + _suggestion(unit_text, dimension, exact=True)
        )
    return Decimal(registry.Quantity(Decimal(1), text).to(dimension.si_unit).magnitude)


def _kind_of(base: pint.Unit) -> str:
    """Return what a unit that is reduced to base units measures."""
    for dimension in Dimension:
        if base == _base_units(dimension.si_unit, dimension):
            return dimension.noun
    return f"{base:~P}" or "a pure number"


def _base_units(text: str, dimension: Dimension) -> pint.Unit:
    """Return a unit reduced to base units: radians stay, percent and the like reduce to none."""
    from pint.errors import PintError

    registry = _registry()
    try:
        return registry.get_root_units(registry.parse_units(text))[1]
    except (PintError, ValueError):  # ValueError: "nan" is a number to pint
        suggestion = _suggestion(text, dimension)
        raise _UnitProblemError(f'there is no unit "{text}"{suggestion}') from None


def _suggestion(unit_text: str, dimension: Dimension, exact: bool = False) -> str:
    """Return ``; did you mean "psi"?`` if a usual unit is near (or differs only in its case)."""
    usual = {unit.casefold(): unit for unit in dimension.usual_units}
    matches = difflib.get_close_matches(unit_text.casefold(), usual, 1, 1.0 if exact else 0.6)
    return f'; did you mean "{usual[matches[0]]}"?' if matches else ""


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry[Any]:
    """Return the one unit registry; building it takes a tenth of a second, so only when needed.

    It computes in decimals, so that "0.95 g/cm^3" is 950.0 and not the float below it.
    """
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)
