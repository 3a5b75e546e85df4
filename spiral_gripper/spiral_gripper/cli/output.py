# SPDX-License-Identifier: Apache-2.0
"""What commands print: JSON, rows of figures, and lines about files that they have written."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from spiral_gripper.reports.fields import Field, Rows


def print_json(value: object) -> None:
    """Print a value as JSON, in SI units; missing values are null."""
    from spiral_gripper.reports.fields import plain

    click.echo(json.dumps(plain(value), indent=2, allow_nan=False, ensure_ascii=False))


def print_rows(title: str, rows: Rows) -> None:
    """Print names and figures in two columns."""
    from rich.console import Console

    from spiral_gripper.reports.tables import row_table

    Console().print(row_table(title, rows))


def print_result(fields: Sequence[Field], result: object, as_json: bool, title: str = "") -> None:
    """Print a result: as JSON, in two columns under a title, or without one a line each."""
    from spiral_gripper.reports.fields import document_of, rows_of

    if as_json:
        print_json(document_of(fields, result))
    elif title:
        print_rows(title, rows_of(fields, result))
    else:
        print_lines(rows_of(fields, result))


def print_lines(rows: Rows) -> None:
    """Print names and figures, a line each."""
    click.echo("\n".join(f"{name}: {text}".rstrip() for name, text in rows))


@contextmanager
def waiting(text: str, *, quiet: bool = False) -> Iterator[None]:
    """Say on standard error what the block waits for and, on a terminal, for how long."""
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    silent = quiet or not console.is_terminal
    if silent and not quiet:
        click.echo(f"{text} ...", err=True)
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=silent) as progress:
        progress.add_task(text)
        yield


def say_written(path: Path) -> None:
    """Say on standard error, beside the answer, which file was written."""
    click.echo(f"wrote {path}", err=True)


def write_picture(figure: Figure, path: Path) -> None:
    """Write a picture to a file, and say so."""
    from spiral_gripper.reports.style import save_figure

    save_figure(figure, path)
    say_written(path)
