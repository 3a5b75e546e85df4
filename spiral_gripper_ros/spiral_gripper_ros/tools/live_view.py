# SPDX-License-Identifier: Apache-2.0
"""Output of ``spiral-gripper simulate``: a live table on a terminal, lines elsewhere."""

from __future__ import annotations

import time
from dataclasses import dataclass

from rich import box
from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table

from spiral_gripper.files.shown import axis_label

# Time between two lines without news, where there is no terminal [s].
LINE_PERIOD = 1.0


@dataclass(frozen=True, slots=True)
class View:
    """What there is to show, in the units people read; None is not known.

    Args:
        elapsed: since the node became active [s].
        radius: of the object that is really there, and of the one the node believes in.
        command: and the measured pressure.
        regime: how the node believes that the object is held.
        wrapped: whether the node believes that it is held.
        grip: how it is really held.
        state: of the node.
        trouble: why the node refuses something, or what is wrong with the pressure; "": nothing.
        reasons: for the trouble; its text has numbers in it, which differ each time.
    """

    elapsed: float
    radius: tuple[float | None, float | None]
    command: float | None
    measured: float | None
    regime: str
    wrapped: bool
    grip: str
    state: str
    trouble: str
    reasons: tuple[int, ...]

    def cells(self) -> tuple[tuple[str, str, int], ...]:
        """Return name, text and width of each column."""
        real, believed = self.radius
        return (
            ("t [s]", f"{self.elapsed:5.1f}", 5),
            (axis_label("object", "m"), _number(real), 11),
            (axis_label("believed", "m"), _number(believed), 13),
            (axis_label("command", "Pa"), _number(self.command), 13),
            (axis_label("measured", "Pa"), _number(self.measured), 14),
            ("regime", self.regime, 12),
            ("wrapped", "yes" if self.wrapped else "no", 7),
            ("really", self.grip, 13),
            ("state", self.state, 12),
            ("trouble", self.trouble, 0),
        )


class LiveView:
    """Shows views as they come; use it as a context manager.

    Args:
        console: where to; a terminal gets a table that changes in place.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._live = Live(console=console, auto_refresh=False) if console.is_terminal else None
        self._shown: View | None = None
        self._due = 0.0

    def __enter__(self) -> LiveView:
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._live is not None:
            self._live.stop()

    def show(self, view: View) -> None:
        """Show the newest view."""
        if self._live is not None:
            self._live.update(_table(view), refresh=True)
            return
        now = time.monotonic()
        if self._shown is not None and now < self._due and not _news(self._shown, view):
            return
        if self._shown is None:
            self._line([(name, width) for name, _, width in view.cells()])
        self._line([(text, width) for _, text, width in view.cells()])
        self._shown, self._due = view, now + LINE_PERIOD

    def _line(self, cells: list[tuple[str, int]]) -> None:
        text = "  ".join(cell.ljust(width) for cell, width in cells)
        self._console.print(text.rstrip(), soft_wrap=True, highlight=False, markup=False)


def _news(shown: View, view: View) -> bool:
    """Return whether a view tells of something new, other than numbers."""
    return (shown.state, shown.reasons, shown.grip, shown.wrapped) != (
        view.state,
        view.reasons,
        view.grip,
        view.wrapped,
    )


def _table(view: View) -> Table:
    table = Table(box=box.SIMPLE, show_header=False, pad_edge=False)
    for name, text, _ in view.cells():
        style = "yellow" if name == "trouble" else None
        table.add_row(escape(name), escape(text), style=style)
    return table


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"
