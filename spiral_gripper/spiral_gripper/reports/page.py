# SPDX-License-Identifier: Apache-2.0
"""A report in one file, Markdown or HTML: text, tables, and figures embedded in it."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TypeAlias

from matplotlib.figure import Figure

from spiral_gripper.files.storage import write_file
from spiral_gripper.reports.style import DPI

_STYLE = """
body { font-family: sans-serif; max-width: 56em; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; margin: 0.6em 0; }
td, th { border: 1px solid #ccc; padding: 0.25em 0.7em; text-align: left; }
th { background: #f2f2f2; }
.no { color: #b03020; }
.ok { color: #207030; }
img { max-width: 100%; }
"""
Rows: TypeAlias = Sequence[Sequence[str]]


class Page:
    r"""A report that is built block by block.

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
        <BLANKLINE>
        >>> page.html[-1]
        '<table><tr><th>a</th><th>b</th></tr><tr><td>1|2</td><td>3 &lt; 4</td></tr></table>'
    """

    def __init__(self, title: str) -> None:
        self._title = escape(title)
        self.markdown = [f"# {title}\n"]
        self.html = [f"<h1>{self._title}</h1>"]

    def heading(self, text: str, verdict: str = "", *, good: bool = True) -> None:
        """Add a heading, with a verdict in green or red after it."""
        self.markdown.append(f"## {text} {verdict}".rstrip() + "\n")
        mark = f' <span class="{"ok" if good else "no"}">{verdict}</span>' if verdict else ""
        self.html.append(f"<h2>{escape(text)}{mark}</h2>")

    def verdict(self, text: str, *, good: bool) -> None:
        """Add what the report finds, in green or red."""
        self.markdown.append(f"**{text}**\n")
        self.html.append(f'<p class="{"ok" if good else "no"}"><strong>{escape(text)}</strong></p>')

    def paragraph(self, text: str) -> None:
        """Add a paragraph."""
        self.markdown.append(f"{text}\n")
        self.html.append(f"<p>{escape(text)}</p>")

    def items(self, texts: Sequence[str]) -> None:
        """Add a list; nothing if it is empty."""
        if texts:
            self.markdown += [*(f"- {text}" for text in texts), ""]
            self.html.append(f"<ul>{''.join(f'<li>{escape(text)}</li>' for text in texts)}</ul>")

    def table(self, header: Sequence[str], rows: Rows) -> None:
        """Add a table."""
        lines = ["| " + " | ".join(header) + " |", "|" + " --- |" * len(header)]
        lines += ["| " + " | ".join(x.replace("|", "\\|") for x in row) + " |" for row in rows]
        self.markdown.append("\n".join(lines) + "\n")
        head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
        body = ("".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows)
        cells = "".join(f"<tr>{row}</tr>" for row in (head, *body))
        self.html.append(f"<table>{cells}</table>")

    def picture(self, what: str, figure: Figure) -> None:
        """Add a figure as a PNG in a data URI."""
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=DPI)
        uri = "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")
        self.markdown.append(f"![{what}]({uri})\n")
        self.html.append(f'<img alt="{escape(what)}" src="{uri}">')

    def write(self, path: Path) -> None:
        """Write the report; the suffix decides the format (.md, .html).

        Raises:
            FileError: it cannot be written.
        """
        text = "\n".join(self.markdown)
        if path.suffix.lower() != ".md":
            head = (
                f'<head><meta charset="utf-8"><title>{self._title}</title><style>{_STYLE}</style>'
            )
            body = "\n".join(self.html)
            text = f'<!DOCTYPE html>\n<html lang="en">{head}</head><body>\n{body}\n</body></html>\n'
        write_file(path, text)
