# SPDX-License-Identifier: Apache-2.0
"""A report in one file, Markdown or HTML: text, tables, and figures embedded in it."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TypeAlias

from markdown_it import MarkdownIt
from matplotlib.figure import Figure

from spiral_gripper.files.storage import write_file
from spiral_gripper.reports.style import DPI

_STYLE = """
body { font-family: sans-serif; max-width: 56em; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; margin: 0.6em 0; }
td, th { border: 1px solid #ccc; padding: 0.25em 0.7em; text-align: left; }
th { background: #f2f2f2; }
img { max-width: 100%; }
"""
Rows: TypeAlias = Sequence[Sequence[str]]


class Page:
    r"""A report that is built block by block, in Markdown.

    Args:
        title: its heading.

    Example:
        >>> page = Page("Report")
        >>> page.table(("a", "b"), [("1|2", "3 < 4")])
        >>> print("\n".join(page.markdown))
        # Report
        <BLANKLINE>
        | a | b |
        | --- | --- |
        | 1\|2 | 3 < 4 |
    """

    def __init__(self, title: str) -> None:
        self._title = title
        self.markdown = [f"# {title}\n"]

    def heading(self, text: str) -> None:
        """Add a heading."""
        self.markdown.append(f"## {text}\n")

    def paragraph(self, text: str) -> None:
        """Add a paragraph."""
        self.markdown.append(f"{text}\n")

    def items(self, texts: Sequence[str]) -> None:
        """Add a list; nothing if it is empty."""
        if texts:
            self.markdown += [*(f"- {text}" for text in texts), ""]

    def table(self, header: Sequence[str], rows: Rows) -> None:
        """Add a table."""
        lines = ["| " + " | ".join(header) + " |", "|" + " --- |" * len(header)]
        lines += ["| " + " | ".join(x.replace("|", "\\|") for x in row) + " |" for row in rows]
        self.markdown.append("\n".join(lines) + "\n")

    def picture(self, what: str, figure: Figure) -> None:
        """Add a figure as a PNG in a data URI."""
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=DPI)
        data = base64.b64encode(buffer.getvalue()).decode("ascii")
        self.markdown.append(f"![{what}](data:image/png;base64,{data})\n")

    def write(self, path: Path) -> None:
        """Write the report; the suffix decides the format (.md, .html).

        Raises:
            FileError: it cannot be written.
        """
        text = "\n".join(self.markdown)
        if path.suffix.lower() != ".md":
            body = MarkdownIt("js-default").render(text)
            head = f'<meta charset="utf-8"><title>{escape(self._title)}</title>'
            head += f"<style>{_STYLE}</style>"
            text = (
                f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head><body>{body}</body></html>\n'
            )
        write_file(path, text)
