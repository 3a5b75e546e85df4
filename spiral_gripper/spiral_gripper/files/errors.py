# SPDX-License-Identifier: Apache-2.0
"""Problems of a gripper description file, each with its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

from spiral_core import SpiralError


class ProblemKind(Enum):
    """The kinds of problems; the value is the sentence that reports one."""

    WRONG = "{field} must be {requirement}, got {value}"
    MISSING = "{field} is missing; it must be {requirement}"
    UNKNOWN = "{field} is not a field here; {requirement}"
    DUPLICATE = "{field} is given twice; {requirement}"
    NOT_YAML = "this is not valid YAML: {requirement}"
    UNREADABLE = "this file cannot be read: {requirement}"


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing wrong in one place of a file.

    Attributes:
        kind: of the problem.
        file: the file's path as it was asked for, or the name if there is no such file.
        line: line in the file, from 1; None where no line is to blame.
        column: column in that line, from 1; None where no line is to blame.
        field: dotted name of the field, such as ``"tube.inner_radius"``; empty for the whole file.
        value: what the file says there, on one line; None if it says nothing.
        requirement: what would be right.

    Example:
        >>> print(Problem(ProblemKind.WRONG, "mine.yaml", 4, 17, "tube.length", "0 mm", "positive"))
        mine.yaml:4:17: tube.length must be positive, got 0 mm
    """

    kind: ProblemKind
    file: str
    line: int | None
    column: int | None
    field: str
    value: str | None
    requirement: str

    def __str__(self) -> str:
        place = [self.file, *(str(part) for part in (self.line, self.column) if part is not None)]
        sentence = self.kind.value.format(
            field=self.field, value=self.value, requirement=self.requirement
        )
        return f"{':'.join(place)}: {sentence}"


class FileProblemsError(SpiralError, ValueError):
    """A file cannot be used; one line of text for each problem in it.

    Attributes:
        problems: every problem found, in the order of the file; at least one.
    """

    def __init__(self, problems: Sequence[Any]) -> None:
        ordered = sorted(problems, key=lambda problem: (problem.line or 0, problem.column or 0))
        super().__init__(ordered)
        self.problems: tuple[Any, ...] = tuple(ordered)

    def __str__(self) -> str:
        return "\n".join(str(problem) for problem in self.problems)


class DescriptionError(FileProblemsError):
    """A gripper description file cannot be used; one line of text for each problem in it.

    Attributes:
        problems: every problem found, in the order of the file; at least one.

    Example:
        >>> place = Problem(ProblemKind.WRONG, "a.yaml", 4, 17, "tube.length", "0 mm", "positive")
        >>> DescriptionError([place]).problems[0].line
        4
    """

    problems: tuple[Problem, ...]
