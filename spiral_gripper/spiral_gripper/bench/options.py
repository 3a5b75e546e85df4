# SPDX-License-Identifier: Apache-2.0
"""The options of a calibration, and their form on the command line."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from spiral_core import FittedQuantity, InvalidInputError
from spiral_core.calibration.regression import DEFAULT_LEVEL
from spiral_gripper.files.fields import FIELDS, LAWS
from spiral_gripper.files.units import parse_number, parse_quantity

# Bounds of a constant that is held [Pa], [1]: far wider than rubber, but they catch wrong units.
HELD_PRESSURE = 1.0e8
HELD_EXTENSION_LIMIT = (0.1, 1.0e4)
# Of the factor on the air's drag, as computed 1.
HELD_AIR = 1.0e3
_EXAMPLES = {"--hold": "c2=15 kPa", "--unit": "pressure=psi", "--error": "extension=0.2 mm"}


@dataclass(frozen=True, slots=True)
class CalibrationOptions:
    """How files of measurements are read, what is fitted to them, and what is reported.

    Args:
        units: unit of a column whose heading has none, by column name.
        errors: standard error of a measured column without a column of its own for it: a quantity,
            ``"0.5 mm"``, or a share of each value, ``"2 %"``; by the measured column's name
            (``position`` for x, y and z).
        section_length: unstretched length that was measured [m], where no column says it; None is
            the length of the described tube.
        ignored: headings of columns that are not measurements.
        laws: names of the laws to try, as in description files; none means the description's own,
            and the law with one constant where the readings do not tell its constants apart.
        quantities: what to fit beside the constants.
        fixed: constants that are held, by name, in SI units; of a free swing ``air``.
        robust: whether outliers may be among the readings.
        accept_implausible: whether to accept readings that look like a mix-up of units.
        radii: of objects whose pressure is reported [m].
        draws: for its interval; None propagates errors linearly.
        seed: of the draws.
        level: confidence level of the intervals, in (0, 1).
    """

    units: Mapping[str, str] = field(default_factory=dict)
    errors: Mapping[str, str] = field(default_factory=dict)
    section_length: float | None = None
    ignored: Collection[str] = ()
    laws: tuple[str, ...] = ()
    quantities: tuple[FittedQuantity, ...] = ()
    fixed: Mapping[str, float] = field(default_factory=dict)
    robust: bool = False
    accept_implausible: bool = False
    radii: tuple[float, ...] = ()
    draws: int | None = None
    seed: int = 0
    level: float = DEFAULT_LEVEL

    def __post_init__(self) -> None:
        for law in self.laws:
            if law not in LAWS:
                raise InvalidInputError("law", law, f"one of {', '.join(LAWS)}")


def parse_options(
    hold: Sequence[str],
    units: Sequence[str],
    errors: Sequence[str],
    quantities: Sequence[str],
    *,
    free_swing: bool,
    **others: Any,  # noqa: ANN401  # fields of CalibrationOptions
) -> CalibrationOptions:
    """Return the options that the command line states.

    Args:
        hold: constants and their values, NAME=VALUE.
        units: columns and their units, likewise.
        errors: columns and their standard errors, likewise.
        quantities: names of what to fit beside the constants.
        free_swing: whether a swing is fitted, of which only ``air`` can be held.
        others: further fields of :class:`CalibrationOptions`.

    Raises:
        InvalidInputError: a text cannot be used.
    """
    held = _pairs("--hold", hold)
    return CalibrationOptions(
        units=_pairs("--unit", units),
        errors=_pairs("--error", errors),
        quantities=tuple(FittedQuantity(one) for one in quantities),
        fixed={name: _constant(name, text, free_swing) for name, text in held.items()},
        **others,
    )


def _pairs(option: str, texts: Sequence[str]) -> dict[str, str]:
    """Return ``NAME=VALUE`` texts as a mapping."""
    pairs: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            requirement = f'of the form NAME=VALUE, such as "{_EXAMPLES[option]}"'
            raise InvalidInputError(option, text, requirement)
        if name in pairs:
            raise InvalidInputError(option, text, f"given once for {name}")
        pairs[name] = value
    return pairs


def _constant(name: str, text: str, free_swing: bool) -> float:
    """Return the value of a constant of some law, in SI units; of a swing, the factor on air."""
    known = FIELDS.get(f"material.{name}")
    if free_swing:
        if name != "air":
            raise InvalidInputError("--hold", name, "air: a free swing tells the damping alone")
        value = parse_number(text, "--hold air")
        low, high = 0.0, HELD_AIR
        requirement = f"from 0 to {high:g}: 1 is the drag as computed"
    elif known is None or name in ("law", "density"):
        raise InvalidInputError("--hold", name, "a constant of the law")
    elif known.dimension is None:
        value = parse_number(text, f"--hold {name}")
        low, high = HELD_EXTENSION_LIMIT
        requirement = f"from {low:g} to {high:g}: I1 - 3 at full extension, some 50 in latex"
    else:
        value = parse_quantity(text, known.dimension, f"--hold {name}")
        low, high = -HELD_PRESSURE, HELD_PRESSURE
        requirement = f"at most {1e-6 * high:g} MPa in size: those of rubber are 0.01 to 1 MPa"
    if not low <= value <= high:
        raise InvalidInputError(f"--hold {name}", text, requirement)
    return value
