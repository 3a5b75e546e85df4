# SPDX-License-Identifier: Apache-2.0
"""Pieces of a report in one file, Markdown or HTML: tables, and figures embedded in the text."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE_STYLE = """
body { font-family: sans-serif; max-width: 56em; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; margin: 0.6em 0; }
td, th { border: 1px solid #ccc; padding: 0.25em 0.7em; text-align: left; }
th { background: #f2f2f2; }
.no { color: #b03020; }
.ok { color: #207030; }
img { max-width: 100%; }
"""
Rows: TypeAlias = Sequence[Sequence[str]]


def figure_uri(figure: Figure) -> str:
    """Return a figure as a PNG in a data URI."""
    from spiral_gripper.reports.style import DPI

    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI)
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def markdown_table(header: Sequence[str], rows: Rows) -> str:
    r"""Return a table in Markdown.

    Example:
        >>> print(markdown_table(("a", "b"), [("1|2", "3")]), end="")
        | a | b |
        | --- | --- |
        | 1\|2 | 3 |
    """
    lines = ["| " + " | ".join(header) + " |", "|" + " --- |" * len(header)]
    lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def html_table(header: Sequence[str], rows: Rows) -> str:
    """Return a table in HTML, its texts escaped.

    Example:
        >>> html_table(("a",), [("1 < 2",)])
        '<table><tr><th>a</th></tr><tr><td>1 &lt; 2</td></tr></table>'
    """
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return f"<table><tr>{head}</tr>{body}</table>"
