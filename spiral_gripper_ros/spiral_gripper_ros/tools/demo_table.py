# SPDX-License-Identifier: Apache-2.0
"""What the demo shows: a live table on a terminal, plain lines elsewhere. Knows no ROS."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from rich import box
from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table

ROWS_SHOWN = 16
# Time between two rows without news [s]: in the live table, and as plain lines that stay.
LIVE_PERIOD = 0.5
LINE_PERIOD = 1.0


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table, in the units people read: mm, kPa."""

    time: float
    label: str
    radius_mm: float
    pressure_kpa: float
    turns: float
    regime: str
    tip_mm: tuple[float, float, float]
    state: str
    reason: str

    def cells(self) -> tuple[str, ...]:
        """Return the text of each column."""
        x, y, z = self.tip_mm
        return (
            f"{self.time:5.1f}",
            self.label,
            f"{self.radius_mm:6.2f}" if self.radius_mm > 0.0 else "-",
            f"{self.pressure_kpa:6.2f}",
            f"{self.turns:4.2f}" if self.turns > 0.0 else "-",
            self.regime,
            f"{x:4.0f} {y:4.0f} {z:4.0f}",
            self.state,
            self.reason,
        )


TIP = "tip x y z [mm]"
# The tip's column is left out of a live table on a terminal that is narrower than this.
WIDE = 112
COLUMNS = (
    "t [s]",
    "object",
    "radius [mm]",
    "pressure [kPa]",
    "turns",
    "regime",
    TIP,
    "state",
    "refused because",
)
_MAY_WRAP = ("object", "state", "refused because")
_LIVE_WIDTHS = (5, 0, 6, 8, 5, 12, 14, 0, 0)
_WIDTHS = (5, 26, 11, 14, 5, 12, 14, 9, 0)


class DemoTable:
    """Shows rows as they come; use it as a context manager.

    Args:
        console: where to; a terminal gets a live table.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._wide = console.width >= WIDE
        self._rows: deque[Row] = deque(maxlen=ROWS_SHOWN)
        self._live = Live(console=console, auto_refresh=False) if console.is_terminal else None

    def __enter__(self) -> DemoTable:
        if self._live is None:
            self._line(COLUMNS)
        else:
            self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._live is not None:
            self._live.stop()

    def show(self, row: Row) -> None:
        """Show one more row if it has news, or if the last one is old."""
        period = LINE_PERIOD if self._live is None else LIVE_PERIOD
        if self._rows and not _worth_a_row(self._rows[-1], row, period):
            return
        self._rows.append(row)
        if self._live is None:
            self._line(row.cells())
        else:
            self._live.update(self._table(), refresh=True)

    def _line(self, cells: tuple[str, ...]) -> None:
        text = "  ".join(cell.ljust(width) for cell, width in zip(cells, _WIDTHS, strict=True))
        self._console.print(text.rstrip(), soft_wrap=True, highlight=False, markup=False)

    def _table(self) -> Table:
        table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
        shown = [i for i, name in enumerate(COLUMNS) if self._wide or name != TIP]
        for i in shown:
            # The unit below the name; and "[mm]" would be taken for markup.
            name = escape(COLUMNS[i].replace(" [", "\n["))
            may_wrap = COLUMNS[i] in _MAY_WRAP
            table.add_column(
                name, no_wrap=not may_wrap, min_width=0 if may_wrap else _LIVE_WIDTHS[i]
            )
        for row in self._rows:
            cells = row.cells()
            style = "yellow" if row.reason else None
            table.add_row(*(escape(cells[i]) for i in shown), style=style)
        return table


def _worth_a_row(last: Row, row: Row, period: float) -> bool:
    news = (last.label, last.state, last.reason) != (row.label, row.state, row.reason)
    return news or row.time - last.time >= period
