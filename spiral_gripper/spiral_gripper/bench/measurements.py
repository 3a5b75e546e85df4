# SPDX-License-Identifier: Apache-2.0
"""Files of bench measurements: from CSV with units to readings, with the line of each."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

from spiral_core import (
    BendReading,
    ExtensionReading,
    GripReading,
    InvalidInputError,
    ShapeReading,
    SwingReading,
    TwistReading,
)
from spiral_core.calibration.readings import Reading
from spiral_gripper.bench.options import CalibrationOptions
from spiral_gripper.files.table import Row, Table, read_table
from spiral_gripper.files.units import Dimension, parse_number, parse_quantity

COLUMNS = MappingProxyType(
    {
        **dict.fromkeys(("pressure", "pressure_error"), Dimension.PRESSURE),
        **dict.fromkeys(("section_length", "extension", "extension_error"), Dimension.LENGTH),
        **dict.fromkeys(
            ("twist", "twist_error", "bend_angle", "bend_angle_error"), Dimension.ANGLE
        ),
        **dict.fromkeys(("x", "y", "z", "arc_length", "position_error"), Dimension.LENGTH),
        **dict.fromkeys(("object_radius", "object_radius_error"), Dimension.LENGTH),
        "time": Dimension.TIME,
        **dict.fromkeys(("displacement", "displacement_error"), Dimension.LENGTH),
    }
)


@dataclass(frozen=True, slots=True)
class Measurements:
    """The readings of one file.

    Attributes:
        source: the file.
        readings: what was measured.
        lines: line in the file of each reading.
        units: unit of each column that was read, by its name.
        headings: of all columns.
    """

    source: Path
    readings: tuple[Reading, ...]
    lines: tuple[int, ...]
    units: Mapping[str, str] = field(default_factory=dict)
    headings: Collection[str] = ()


def load_measurements(
    path: str | os.PathLike[str], tube_length: float, options: CalibrationOptions | None = None
) -> Measurements:
    r"""Return the readings of a CSV file.

    Each row gives a reading for each kind of measurement whose cells it fills; a row that gives
    none is an error, as is any cell that cannot be read.

    Args:
        path: the file.
        tube_length: unstretched length of the described tube [m].
        options: what is stated beside the file.

    Raises:
        TableError: the file cannot be used; the error names every bad line and column.

    Example:
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = Path(folder) / "bench.csv"
        ...     _ = file.write_text("pressure [psi],twist [deg],twist_error [deg]\n4,90,2\n")
        ...     (reading,) = load_measurements(file, 0.1).readings
        >>> round(reading.twist, 6), reading.section_length
        (1.570796, 0.1)
    """
    source, options = Path(path), options or CalibrationOptions()
    table = read_table(source, COLUMNS, options.units, options.ignored)
    length = tube_length if options.section_length is None else options.section_length
    found = readings_of(table, KINDS, options, length)
    lines, readings = zip(*found, strict=True)
    units = {name: column.unit for name, column in table.columns.items()}
    return Measurements(source, readings, lines, units, table.headings)


def readings_of(
    table: Table,
    possible: tuple[Kind, ...],
    options: CalibrationOptions,
    section_length: float = math.nan,
) -> list[tuple[int, Any]]:
    """Return line and reading of each measurement of these kinds; there is at least one.

    Raises:
        TableError: it cannot be used; the error names every bad line and column.
    """
    kinds = [kind for kind in possible if kind.name in table.columns]
    _check_columns(table, possible, kinds, options)
    table.raise_problems()
    found = []
    for row in table.rows:
        for kind in kinds:
            reading = _reading(table, row, kind, options, section_length)
            if reading is not None:
                found.append((row.line, reading))
        if not any(kind.own & row.values.keys() for kind in kinds):
            reason = f"is blank, and so the line holds no measurement of {_names(kinds)}"
            table.note(row.line, kinds[0].name, reason)
    table.raise_problems()
    return found


Values = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of measurement.

    Attributes:
        reading: its class.
        name: the measured column.
        error_name: the column and the option that state its error, without ``_error``.
        needs: the other columns that it requires.
        make: the reading from a row's values and its two errors.
    """

    reading: type[Reading | SwingReading]
    name: str
    error_name: str
    needs: tuple[str, ...]
    make: Callable[[Values, float, float], Reading | SwingReading]

    @property
    def own(self) -> frozenset[str]:
        """The columns that only this kind has: one that is filled announces a reading."""
        return frozenset({self.name, *self.needs} - {"pressure"})


def _on_section(kind: type[ExtensionReading | TwistReading | BendReading], name: str) -> Kind:
    """Return a kind of measurement that is one value of a section of the tube."""
    return Kind(kind, name, name, ("pressure",), lambda values, *errors: kind(
        values["pressure"], values[name], values["section_length"], *errors
    ))  # fmt: skip


KINDS = (
    _on_section(ExtensionReading, "extension"),
    _on_section(TwistReading, "twist"),
    _on_section(BendReading, "bend_angle"),
    Kind(ShapeReading, "x", "position", ("pressure", "y", "z"), lambda values, *errors: (
        ShapeReading(
            values["pressure"], (values["x"], values["y"], values["z"]), values.get("arc_length"),
            *errors,
        )
    )),
    Kind(GripReading, "object_radius", "object_radius", ("pressure",), lambda values, *errors: (
        GripReading(values["pressure"], values["object_radius"], *errors)
    )),
)  # fmt: skip
SWING = Kind(
    SwingReading, "displacement", "displacement", ("time", "pressure"), lambda values, error, _: (
        SwingReading(values["time"], values["displacement"], error)
    ),
)  # fmt: skip
# The column that each kind of reading measures; of a shape the first of three.
COLUMN_OF = {kind.reading: kind.name for kind in KINDS}
# What an error can be stated for beside the files, and the column that it is the error of.
ERROR_COLUMNS = MappingProxyType(
    {"pressure": "pressure", **{kind.error_name: kind.name for kind in KINDS}}
)


def _names(kinds: Collection[Kind]) -> str:
    return ", ".join(kind.name for kind in kinds)


def _check_columns(
    table: Table,
    possible: tuple[Kind, ...],
    kinds: Collection[Kind],
    options: CalibrationOptions,
) -> None:
    """Note columns and errors that are missing for all rows, or belong to no possible kind."""
    line = table.header_line
    swings = {"time", "displacement", "displacement_error"}
    if possible == (SWING,):
        errors = ["displacement"]
        foreign = table.columns.keys() - swings - {"pressure"}
        reason = "does not belong to a free swing; leave it out, or --ignore it"
    else:
        errors = [*ERROR_COLUMNS]
        foreign = table.columns.keys() & swings
        reason = "is of a free swing; use --free-swing, or --ignore it"
    for name in foreign:
        table.note(line, name, reason)
    if not kinds:
        table.note(line, "", f"no column holds a measurement: one of {_names(possible)}")
    for name in sorted(options.errors.keys() - errors):
        known = ", ".join(errors)
        table.note(None, name, f"has a stated error; only these can have one: {known}")
    for kind in kinds:
        for name in kind.needs:
            if name not in table.columns:
                table.note(line, name, f"is missing; {kind.name} requires it")
        what, column = kind.error_name, f"{kind.error_name}_error"
        if column not in table.columns and what not in options.errors:
            example = COLUMNS[kind.name].usual_units[0]
            reason = (
                f'is missing; state how well {what} was measured in a column "{column} [{example}]"'
                f', or for all readings with --error "{what}=0.5 {example}"'
            )
            table.note(line, column, reason)


def _reading(
    table: Table,
    row: Row,
    kind: Kind,
    options: CalibrationOptions,
    section_length: float,
) -> Reading | SwingReading | None:
    """Return one reading of a row, or None if its cells are blank or there is a problem."""
    if not kind.own & row.values.keys():
        return None
    values = {"section_length": section_length, **row.values}
    missing = [name for name in (kind.name, *kind.needs) if name not in values]
    for name in missing:
        table.note(row.line, name, f"is blank, but {kind.name} requires it")
    if missing:
        return None

    def error(name: str, column: str) -> float:
        """Return the standard error of a value: its own column's, or the stated one."""
        own, stated = values.get(f"{name}_error"), options.errors.get(name)
        if own is None and stated is not None:
            if stated.strip().endswith("%") and values[column] == 0.0 and name != "pressure":
                requirement = "a quantity: a share of a reading of 0 is no error"
                raise InvalidInputError(f"--error {name}", stated, requirement)
            return stated_error(stated, name, values[column])
        return own or 0.0

    try:
        errors = error(kind.error_name, kind.name), error("pressure", "pressure")
        return kind.make(values, *errors)
    except InvalidInputError as problem:
        field_names = {
            "error": f"{kind.error_name}_error",
            "position": kind.name,
            **{f"--error {name}": f"{name}_error" for name in ("pressure", kind.error_name)},
        }
        name = field_names.get(problem.field, problem.field)
        stated = options.errors.get(name.removesuffix("_error"))
        written = row.texts.get(name) or (stated if name.endswith("_error") else None)
        got = f", got {written}" if written else " and is blank"
        table.note(row.line, name, f"must be {problem.requirement}{got}")
        return None


def stated_error(text: str, name: str, value: float) -> float:
    """Return the standard error of a value, in SI, that is stated beside a file.

    Args:
        text: a quantity, ``"0.2 mm"``, or a share, ``"2 %"``.
        name: what it is the error of, one of :data:`ERROR_COLUMNS` or a column itself.
        value: the measured value.

    Raises:
        InvalidInputError: the text is neither.

    Example:
        >>> stated_error("2 %", "extension", 0.05), stated_error("0.2 mm", "extension", 0.05)
        (0.001, 0.0002)
    """
    if not text.strip().endswith("%"):
        column = COLUMNS[ERROR_COLUMNS.get(name, name)]
        return parse_quantity(text.strip(), column, f"--error {name}")
    try:
        return parse_number(text.strip().removesuffix("%").strip()) / 100.0 * abs(value)
    except InvalidInputError:
        requirement = 'a share such as "2 %" or a quantity'
        raise InvalidInputError(f"--error {name}", text, requirement) from None
