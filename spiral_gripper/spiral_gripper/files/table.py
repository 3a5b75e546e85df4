# SPDX-License-Identifier: Apache-2.0
"""CSV text to rows of SI numbers with their lines: headings, units, cells, and what is wrong.

A heading is a name with a unit, ``pressure [psi]``, ``pressure (psi)`` or ``pressure_psi``; a unit
may also be stated beside the file. Lines that are blank or begin with ``#`` are comments.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

from spiral_core import InvalidInputError
from spiral_gripper.files.errors import FileProblemsError
from spiral_gripper.files.storage import FileError, read_text
from spiral_gripper.files.units import Dimension, convert_from_si, parse_number, parse_quantity

_BRACKETED = re.compile(r"(?P<name>[^\[\](){}]+?)\s*[\[(](?P<unit>[^\[\]()]*)[\])]")


@dataclass(frozen=True, slots=True)
class BadCell:
    """One thing wrong in one place of a table.

    Attributes:
        file: the file's path as it was asked for.
        line: line in the file, from 1; None where no line is to blame.
        column: number of the column, from 1; None where no column is to blame.
        heading: the column's heading, or the name of the column that is missing; may be empty.
        reason: what is wrong, and what would be right.

    Example:
        >>> print(BadCell("bench.csv", 7, 2, "extension [mm]", "must be a number, got 'abc'"))
        bench.csv:7: column 2 "extension [mm]": must be a number, got 'abc'
    """

    file: str
    line: int | None
    column: int | None
    heading: str
    reason: str

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        number = "" if self.column is None else f"column {self.column} "
        heading = f'"{self.heading}"' if self.heading else ""
        column = f"{number}{heading}".strip()
        return ": ".join(part for part in (place, column, self.reason) if part)


class TableError(FileProblemsError):
    """A CSV file cannot be used; one line of text for each problem in it.

    Attributes:
        problems: every problem found, in the order of the file; at least one.

    Example:
        >>> error = TableError([BadCell("bench.csv", 7, 2, "x [mm]", "is blank")])
        >>> error.problems[0].line, error.problems[0].column
        (7, 2)
    """

    problems: tuple[BadCell, ...]


@dataclass(frozen=True, slots=True)
class Column:
    """One column that is read.

    Attributes:
        number: its place in the file, from 1.
        heading: its heading as written.
        name: one of the columns that the file may have.
        unit: the unit of its cells.
        dimension: what it measures.
    """

    number: int
    heading: str
    name: str
    unit: str
    dimension: Dimension


@dataclass(frozen=True, slots=True)
class Row:
    """One line of numbers.

    Attributes:
        line: line in the file, from 1.
        values: SI values by column name; blank cells are left out.
        texts: the same as written, with their units.
    """

    line: int
    values: dict[str, float] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Table:
    """The numbers of one file, its columns, and what is wrong so far.

    Attributes:
        file: the file's name for messages.
        header_line: line of the headings.
        headings: all of them.
        columns: the columns that are read, by name.
        rows: the lines of numbers.
        problems: what is wrong.
    """

    file: str
    header_line: int = 1
    headings: Collection[str] = ()
    columns: dict[str, Column] = field(default_factory=dict)
    rows: list[Row] = field(default_factory=list)
    problems: list[BadCell] = field(default_factory=list)

    def note(self, line: int | None, name: str, reason: str, number: int | None = None) -> None:
        """Note a problem in a column; with a number, in the column of this heading."""
        column = self.columns.get(name)
        if column is not None and number is None:
            name, number = column.heading, column.number
        self.problems.append(BadCell(self.file, line, number, name, reason))

    def raise_problems(self) -> None:
        """Raise everything noted so far as one TableError, if there is anything."""
        if self.problems:
            raise TableError(self.problems)


def read_table(
    path: Path,
    known: Mapping[str, Dimension],
    units: Mapping[str, str] | None = None,
    ignored: Collection[str] = (),
) -> Table:
    r"""Return the numbers of a CSV file, in SI units.

    Args:
        path: the file.
        known: the columns that the table may have, and what each measures.
        units: units of columns whose heading has none, by column name; None where no option states
            them or ignores columns.
        ignored: headings of columns that are not to be read.

    Raises:
        TableError: the table cannot be used; every problem found is in it.

    Example:
        >>> import tempfile
        >>> known = {"pressure": Dimension.PRESSURE, "extension": Dimension.LENGTH}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = Path(folder) / "bench.csv"
        ...     _ = path.write_text("pressure [psi],extension [mm]\n2,1.5\n")
        ...     row = read_table(path, known).rows[0]
        >>> row.line, round(row.values["pressure"]), row.values["extension"]
        (2, 13790, 0.0015)
    """
    file = str(path)
    try:
        lines = csv_lines(read_text(path), file)
    except FileError as error:
        problem = BadCell(file, None, None, "", f"cannot be read: {error.reason}")
        raise TableError([problem]) from None
    header_line, headings = lines[0] if lines else (1, [])
    table = Table(file, header_line, headings)
    if not lines:
        table.note(None, "", "the file holds no table")
    elif len(headings) == 1 and re.search(r"[;\t]", headings[0]):
        reason = "columns must be separated by commas, and decimals by points"
        table.note(header_line, headings[0], reason, 1)
    table.raise_problems()
    for number, heading in enumerate(headings, start=1):
        if heading in ignored:
            continue
        try:
            column = _column(number, heading, known, units)
        except InvalidInputError as error:
            table.note(header_line, heading, error.requirement, number)
            continue
        if column.name in table.columns:
            table.note(header_line, column.name, f"stands in column {number} again")
        table.columns[column.name] = column
    for name in (name for name in units or {} if name not in known):
        reason = f"a unit is stated for this, which is no column; those are {', '.join(known)}"
        table.note(None, name, reason)
    table.raise_problems()
    for line, cells in lines[1:]:
        _read_row(table, line, cells, len(headings))
    if len(lines) == 1:
        table.note(None, "", "the file holds headings but no rows")
    table.raise_problems()
    return table


def csv_lines(text: str, file: str) -> list[tuple[int, list[str]]]:
    r"""Return the cells of each line that is neither blank nor a comment, with its number.

    Raises:
        TableError: a line is not of comma-separated values.

    Example:
        >>> csv_lines("# seen by a camera\ntime, label\n", "seen.csv")
        [(2, ['time', 'label'])]
    """
    lines = []
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            (cells,) = csv.reader(io.StringIO(line), strict=True)
        except (csv.Error, ValueError) as error:
            reason = f"is not a line of comma-separated values ({error})"
            raise TableError([BadCell(file, number, None, "", reason)]) from None
        lines.append((number, [cell.strip() for cell in cells]))
    return lines


def _column(
    number: int, heading: str, known: Mapping[str, Dimension], units: Mapping[str, str] | None
) -> Column:
    """Return what a heading means; the error's requirement is the whole message."""
    name, unit = _name_and_unit(heading, known)
    by_option = units is not None

    def refused(reason: str, remedy: str = "") -> InvalidInputError:
        return InvalidInputError("", heading, reason + (remedy if by_option else ""))

    if name not in known:
        near = get_close_matches(name, known, n=1)
        hint = f"did you mean {near[0]}?" if near else f"known columns are {', '.join(known)}"
        remedy = f'; leave it out by --ignore "{heading}"'
        raise refused(f"is not a known column ({hint})", remedy)
    stated, dimension = (units or {}).get(name), known[name]
    if unit and stated and unit != stated:
        raise refused(f'has its own unit, but "{stated}" is stated for it')
    unit = unit or stated or ""
    if not unit:
        example = dimension.usual_units[0]
        remedy = f', or --unit "{name}={example}"'
        raise refused(f'has no unit; write "{name} [{example}]"', remedy)
    try:
        convert_from_si(1.0, unit, dimension)
    except InvalidInputError as error:
        usual = ", ".join(dimension.usual_units)
        raise refused(f"must have {error.requirement}; usual are {usual}") from None
    return Column(number, heading, name, unit, dimension)


def _name_and_unit(heading: str, known: Collection[str]) -> tuple[str, str]:
    """Return the two parts of a heading; the unit is empty if there is none."""
    match = _BRACKETED.fullmatch(heading)
    if match is not None:
        return match["name"].strip(), match["unit"].strip()
    for name in sorted(known, key=len, reverse=True):
        if heading.startswith(f"{name}_") and heading not in known:
            return name, heading.removeprefix(f"{name}_")
    return heading, ""


def _read_row(table: Table, line: int, cells: list[str], count: int) -> None:
    """Add a row to a table, or the problems in it."""
    if len(cells) != count:
        reason = f"has {len(cells)} cells, but the header has {count}"
        if len(cells) > count:
            reason += " (a decimal comma? decimals follow a point)"
        table.note(line, "", reason)
        return
    row = Row(line)
    for name, column in table.columns.items():
        cell = cells[column.number - 1]
        if not cell:
            continue
        text = f"{cell} {column.unit}"
        try:
            parse_number(cell)
            row.values[name], row.texts[name] = parse_quantity(text, column.dimension), text
        except InvalidInputError:
            reason = f"must be a plain number, with its unit in the heading, got {cell!r}"
            table.note(line, name, reason)
    table.rows.append(row)
