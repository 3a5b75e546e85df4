# SPDX-License-Identifier: Apache-2.0
"""Problems of a gripper description file, each with its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

from spiral_core import SpiralError
from spiral_core.message import Message, joined


class ProblemKind(Enum):
    """The kinds of problems; the value is the sentence that reports one.

    Its parts are the field, the requirement and the value.
    """

    WRONG = "{0} must be {1}, got {2}"
    MISSING = "{0} is missing; it must be {1}"
    UNKNOWN = "{0} is not a field here; {1}"
    DUPLICATE = "{0} is given twice; {1}"
    NOT_YAML = "this is not valid YAML: {1}"
    UNREADABLE = "this file cannot be read: {1}"


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
        sentence = Message(self.kind.value, self.field, self.requirement, self.value)
        return Message("{}: {}", ":".join(place), sentence)


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
        return joined("\n", map(str, self.problems))


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
