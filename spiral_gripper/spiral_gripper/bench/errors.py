# SPDX-License-Identifier: Apache-2.0
"""Problems of a file of measurements, each with its line and column."""

from __future__ import annotations

from dataclasses import dataclass

from spiral_gripper.files.errors import FileProblemsError


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


class MeasurementError(FileProblemsError):
    """A file of measurements cannot be used; one line of text for each problem in it.

    Attributes:
        problems: every problem found, in the order of the file; at least one.

    Example:
        >>> error = MeasurementError([BadCell("bench.csv", 7, 2, "x [mm]", "is blank")])
        >>> error.problems[0].line, error.problems[0].column
        (7, 2)
    """

    problems: tuple[BadCell, ...]
