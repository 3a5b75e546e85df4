# SPDX-License-Identifier: Apache-2.0
"""What every suite of benchmarks does with its command line: measure, show, keep, write a page."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from rich.console import Console

from benchmarks.machine import describe
from benchmarks.report import Page, as_json, show
from benchmarks.results import Section, Table

WIDTH = 120
EffortT = TypeVar("EffortT")


@dataclass(frozen=True, slots=True)
class Suite(Generic[EffortT]):
    """Benchmarks that are measured together.

    Args:
        program: how it is called, such as ``python -m benchmarks``.
        description: for its help.
        sections: what is measured, by name.
        effort: how much, usually.
        smoke: how much with ``--smoke``.
        goals: makes the table of goals from the sections' values.
        libraries: whose versions matter.
        latest: where the figures go.
        page: the page that shows a summary.
        draw: draws that page's figures; None if it has none.
    """

    program: str
    description: str | None
    sections: Mapping[str, Callable[[EffortT], Section]]
    effort: EffortT
    smoke: EffortT
    goals: Callable[[Mapping[str, Mapping[str, float]]], Table]
    libraries: tuple[str, ...]
    latest: Path
    page: Page
    draw: Callable[[Mapping[str, Any]], None] | None = None


def measure(
    suite: Suite[EffortT], names: list[str], effort: EffortT, output: Path, console: Console
) -> None:
    """Measure some sections, show each when it is done, and write the JSON file."""
    machine, sections = describe(suite.libraries), {}
    for name in names:
        sections[name] = suite.sections[name](effort)
        for table in sections[name].tables:
            show(table, console)
    goals = suite.goals({name: section.values for name, section in sections.items()})
    show(goals, console)
    output.parent.mkdir(exist_ok=True)
    output.write_text(as_json(machine, goals, sections), encoding="utf-8")
    console.print(f"Written: {output}", soft_wrap=True)


def wide_console() -> Console:
    """Return a console in which the tables fit, also where the output is no terminal."""
    console = Console()
    return console if console.width >= WIDTH else Console(width=WIDTH)


def main(suite: Suite[EffortT]) -> None:
    """Read the command line and do what it says."""
    known = ", ".join(suite.sections)
    parser = argparse.ArgumentParser(prog=suite.program, description=suite.description)
    parser.add_argument("sections", nargs="*", help=f"some of: {known} (all if none is named)")
    parser.add_argument("--smoke", action="store_true", help="tiny counts: only to see it run")
    parser.add_argument("--output", type=Path, default=suite.latest)
    parser.add_argument(
        "--page",
        action="store_true",
        help=f"measure nothing: write docs/{suite.page.path.name} from the summary",
    )
    arguments = parser.parse_args()
    unknown = set(arguments.sections) - suite.sections.keys()
    if unknown:
        parser.error(f"no section {', '.join(sorted(unknown))}; there are {known}")
    if arguments.page:
        summary = json.loads(suite.page.summary.read_text(encoding="utf-8"))
        suite.page.write(summary)
        if suite.draw is not None:
            suite.draw(summary)
        return
    names = arguments.sections or list(suite.sections)
    effort = suite.smoke if arguments.smoke else suite.effort
    measure(suite, names, effort, arguments.output, wide_console())
