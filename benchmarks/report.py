# SPDX-License-Identifier: Apache-2.0
"""Show what was measured, keep it as JSON, and put it into a page of the documentation."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table as RichTable

from benchmarks.results import Section, Table

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results"
END = "<!-- end -->"


@dataclass(frozen=True, slots=True)
class Page:
    """A page of the documentation that shows a summary between two marks.

    Args:
        path: the page.
        summary: the JSON file.
        program: what writes it with ``--page``.
    """

    path: Path
    summary: Path
    program: str

    @property
    def begin(self) -> str:
        """The mark behind which the summary stands."""
        return f"<!-- From {self.summary.relative_to(ROOT)}: {self.program} --page -->"

    def write(self, summary: Mapping[str, Any]) -> None:
        """Put a summary's tables between the marks."""
        text = self.path.read_text(encoding="utf-8")
        before, rest = text.split(self.begin)
        after = rest.split(END)[1]
        tables = self.begin + "\n\n" + self.markdown(summary) + END
        self.path.write_text(before + tables + after, encoding="utf-8")

    def markdown(self, summary: Mapping[str, Any]) -> str:
        """Return machine and goals as Markdown; the program prints all tables."""
        facts = ", ".join(f"{key} {value}" for key, value in summary["machine"].items())
        return f"Machine: {facts}.\n\n{markdown_table(summary['goals'])}"


PAGE = Page(
    ROOT / "docs" / "benchmarks.md",
    RESULTS / "summary.json",
    "python -m benchmarks",
)


def show(table: Table, console: Console) -> None:
    """Print a table with its note."""
    if table.rows:
        shown = RichTable(title=table.title, title_justify="left", title_style="bold")
        for i, column in enumerate(table.columns):
            shown.add_column(column, justify="left" if i == 0 else "right")
        for row in table.rows:
            shown.add_row(*row)
        console.print(shown)
    else:
        console.print(table.title, style="bold")
    if table.note:
        console.print(table.note, style="dim")
    console.print()


def as_json(machine: Mapping[str, str], goals: Table, sections: Mapping[str, Section]) -> str:
    """Return everything as JSON text."""
    content = {
        "machine": dict(machine),
        "goals": asdict(goals),
        "sections": {name: asdict(section) for name, section in sections.items()},
    }
    return json.dumps(_strict(content), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _strict(content: Any) -> Any:  # noqa: ANN401
    """Return content with null in place of what JSON has no number for."""
    if isinstance(content, dict):
        return {key: _strict(value) for key, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [_strict(value) for value in content]
    if isinstance(content, float) and not math.isfinite(content):
        return None
    return content


def markdown_table(table: Mapping[str, Any]) -> str:
    """Return one table as Markdown, with title and note."""
    lines = [f"### {table['title']}", ""]
    if table["rows"]:
        rule = ["---"] + ["---:"] * (len(table["columns"]) - 1)
        lines += ["| " + " | ".join(row) + " |" for row in (table["columns"], rule, *table["rows"])]
        lines.append("")
    if table["note"]:
        lines += [table["note"], ""]
    return "\n".join(lines) + "\n"
