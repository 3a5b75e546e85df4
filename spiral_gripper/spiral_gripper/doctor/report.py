# SPDX-License-Identifier: Apache-2.0
"""Output of the doctor: lines for people, a document for programs."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any, Final

from rich.console import Console
from rich.text import Text

from spiral_gripper.doctor.checks import Answer, Mark
from spiral_gripper.doctor.worker import finding_as_dict

STYLES: Final = {
    Mark.OK: "green",
    Mark.INFO: "cyan",
    Mark.WARNING: "bold yellow",
    Mark.PROBLEM: "bold red",
    Mark.SKIPPED: "dim",
}
_MARK_WIDTH: Final = 7
_TITLE_WIDTH: Final = 17
_INDENT: Final = _MARK_WIDTH + 2 + _TITLE_WIDTH + 2
# A terminal may be narrower than the columns [characters]; the text still gets this much.
_NARROWEST: Final = 20


def print_answer(answer: Answer, console: Console) -> None:
    """Print one answer, and below it the advice; commands are never broken into lines."""
    finding = answer.finding
    room = max(console.width - _INDENT, _NARROWEST)
    first, *others = _wrapped(finding.text, room) or [""]
    line = Text.assemble(
        (f"{finding.mark.value:<{_MARK_WIDTH}}  ", STYLES[finding.mark]),
        f"{_shortened(answer.title):<{_TITLE_WIDTH}}  {first}",
    )
    below = [*others, *_wrapped(finding.advice, room)]
    _print(line, console)
    for text in below:
        _print(Text(f"{'':{_INDENT}}{text}"), console)
    for command in finding.commands:
        _print(Text(f"{'':{_INDENT}}  {command}", "bold"), console)


def print_section(name: str, console: Console) -> None:
    """Print the heading of a table's answers."""
    console.print(Text(name, "bold"))


def verdict(answers: Iterable[Answer]) -> str:
    """Return the summary of all answers."""
    marks = Counter(answer.finding.mark for answer in answers)
    problems, warnings = marks[Mark.PROBLEM], marks[Mark.WARNING]
    if not problems and not warnings:
        return f"all well: {sum(marks.values())} checks"
    return f"{_count(problems, 'problem')}, {_count(warnings, 'warning')}"


def print_verdict(answers: Sequence[Answer], console: Console) -> None:
    """Print the summary of all answers."""
    marks = {answer.finding.mark for answer in answers}
    worst = next((mark for mark in (Mark.PROBLEM, Mark.WARNING) if mark in marks), Mark.OK)
    console.print(Text(verdict(answers), STYLES[worst]))


def has_problem(answers: Iterable[Answer]) -> bool:
    """Return whether anything must be fixed."""
    return any(answer.finding.mark is Mark.PROBLEM for answer in answers)


def as_document(answers: Sequence[Answer]) -> dict[str, Any]:
    """Return all answers as plain data for JSON."""
    marks = Counter(answer.finding.mark for answer in answers)
    return {
        "problems": marks[Mark.PROBLEM],
        "warnings": marks[Mark.WARNING],
        "checks": [
            {
                "section": answer.section,
                "name": answer.name,
                "title": answer.title,
                **finding_as_dict(answer.finding),
                "elapsed": round(answer.elapsed, 3),
            }
            for answer in answers
        ],
    }


def _print(line: Text, console: Console) -> None:
    console.print(line, soft_wrap=True)


def _wrapped(text: str, width: int) -> list[str]:
    """Return a text in lines, paths and commands in one piece."""
    return textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False)


def _shortened(title: str) -> str:
    return title if len(title) <= _TITLE_WIDTH else f"{title[: _TITLE_WIDTH - 3]}..."


def _count(number: int, noun: str) -> str:
    """Return a number of things in words.

    Example:
        >>> _count(1, "problem"), _count(0, "warning")
        ('1 problem', 'no warnings')
    """
    if number == 0:
        return f"no {noun}s"
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
