"""Show what was measured, keep it as JSON, and put it into docs/benchmarks.md."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table as RichTable

from benchmarks.results import Section, Table

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results"
SUMMARY = RESULTS / "summary.json"
PAGE = ROOT / "docs" / "benchmarks.md"
BEGIN = "<!-- From benchmarks/results/summary.json: python -m benchmarks --page -->"
END = "<!-- end -->"


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
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def write_page(summary: Mapping[str, Any]) -> None:
    """Put a summary's tables between the marks of docs/benchmarks.md."""
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    PAGE.write_text(before + BEGIN + "\n\n" + markdown(summary) + END + after, encoding="utf-8")


def markdown(summary: Mapping[str, Any]) -> str:
    """Return machine and tables of a summary as Markdown."""
    facts = ", ".join(f"{key} {value}" for key, value in summary["machine"].items())
    tables = [summary["goals"]]
    for section in summary["sections"].values():
        tables += section["tables"]
    return f"Machine: {facts}.\n\n" + "".join(markdown_table(table) for table in tables)


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
