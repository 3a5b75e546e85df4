# SPDX-License-Identifier: Apache-2.0
"""What commands print: JSON, rows of figures, and lines about files that they have written."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from spiral_gripper.cli.types import wanted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from spiral_gripper.reports.fields import Field, Rows


def print_json(value: object) -> None:
    """Print a value as JSON, in SI units; missing values are null."""
    from spiral_gripper.reports.fields import plain

    click.echo(json.dumps(plain(value), indent=2, allow_nan=False))


def print_rows(title: str, rows: Rows) -> None:
    """Print names and figures in two columns."""
    from rich.console import Console

    from spiral_gripper.reports.tables import row_table

    Console().print(row_table(title, rows))


def print_result(fields: Sequence[Field], result: object, title: str = "") -> None:
    """Print a result: as JSON, in two columns under a title, or without one a line each."""
    from spiral_gripper.reports.fields import document_of, rows_of

    if wanted("json"):
        print_json(document_of(fields, result))
    elif title:
        print_rows(title, rows_of(fields, result))
    else:
        print_lines(rows_of(fields, result))


def print_lines(rows: Rows) -> None:
    """Print names and figures, a line each."""
    click.echo("\n".join(f"{name}: {text}".rstrip() for name, text in rows))


def say_written(path: Path) -> None:
    """Say on standard error, beside the answer, which file was written."""
    click.echo(f"wrote {path}", err=True)


def write_picture(figure: Figure) -> None:
    """Write a picture to the file that ``--plot`` names, and say so."""
    from spiral_gripper.reports.style import save_figure

    save_figure(figure, wanted("plot"))
    say_written(wanted("plot"))
