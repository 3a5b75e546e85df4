"""Measure, show, keep: ``python -m benchmarks``, or some sections only by naming them."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path

from rich.console import Console

from benchmarks import accuracy, batches, peers, robustness, solves, startup, wraps
from benchmarks.goals import goal_table
from benchmarks.machine import describe
from benchmarks.report import RESULTS, SUMMARY, as_json, show, write_page
from benchmarks.results import SMOKE, Effort, Section

WIDTH = 120
SECTIONS: dict[str, Callable[[Effort], Section]] = {
    "solves": solves.measure,
    "wraps": wraps.measure,
    "batches": batches.measure,
    "startup": startup.measure,
    "accuracy": accuracy.measure,
    "bvp": peers.collocation_section,
    "elastica": peers.dynamics_section,
    "robustness": robustness.measure,
}


def measure(names: list[str], effort: Effort, output: Path, console: Console) -> None:
    """Measure some sections, show each when it is done, and write the JSON file."""
    machine, sections = describe(), {}
    for name in names:
        sections[name] = SECTIONS[name](effort)
        for table in sections[name].tables:
            show(table, console)
    goals = goal_table({name: section.values for name, section in sections.items()})
    show(goals, console)
    output.parent.mkdir(exist_ok=True)
    output.write_text(as_json(machine, goals, sections), encoding="utf-8")
    console.print(f"Written: {output}", soft_wrap=True)


def wide_console() -> Console:
    """Return a console in which the tables fit, also where the output is no terminal."""
    console = Console()
    return console if console.width >= WIDTH else Console(width=WIDTH)


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "sections", nargs="*", help=f"some of: {', '.join(SECTIONS)} (all if none is named)"
    )
    parser.add_argument("--smoke", action="store_true", help="tiny counts: only to see it run")
    parser.add_argument("--output", type=Path, default=RESULTS / "latest.json")
    parser.add_argument(
        "--page",
        action="store_true",
        help="measure nothing: write docs/benchmarks.md and its figures from the summary",
    )
    arguments = parser.parse_args()
    unknown = set(arguments.sections) - SECTIONS.keys()
    if unknown:
        parser.error(f"no section {', '.join(sorted(unknown))}; there are {', '.join(SECTIONS)}")
    if arguments.page:
        from benchmarks.figures import draw  # matplotlib is an extra

        summary = json.loads(SUMMARY.read_text(encoding="utf-8"))
        write_page(summary)
        draw(summary)
        return
    names = arguments.sections or list(SECTIONS)
    measure(names, SMOKE if arguments.smoke else Effort(), arguments.output, wide_console())


if __name__ == "__main__":
    main()
