# SPDX-License-Identifier: Apache-2.0
"""One style for all pictures: a paper's column width, letters of 8 points."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from textwrap import wrap
from typing import Any

from matplotlib import __version_info__, rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from spiral_gripper.files.storage import write_file

# Dark to light, told apart in gray too.
COLORS = ("#1b3a4b", "#2f7f93", "#c8553d", "#e3a857", "#7d6b91", "#5b8c5a")
OVERHANG_COLOR, PERFECT_COLOR, CURLING_COLOR = "#7ba7b4", "#2f7f93", "#e3a857"
DPI = 300
# Where a figure's legend is; Ubuntu 24.04's matplotlib 3.6 cannot keep it off the axes.
BESIDE: Any = "outside right upper"
BELOW: Any = "outside lower center"
if __version_info__ < (3, 7):
    BESIDE, BELOW = "upper right", "lower center"


def save_figure(figure: Figure, path: Path) -> None:
    """Write a picture; the suffix decides the format (png, svg, pdf). Equal data, equal file.

    Raises:
        FileError: it cannot be written.
    """
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    kind = path.suffix.lower().removeprefix(".")
    content = io.BytesIO()
    with paper_style():
        figure.savefig(content, format=kind, dpi=DPI, metadata=metadata.get(kind))
    write_file(path, content.getvalue())


def set_title(figure: Figure, title: str, width: int = 110) -> None:
    """Set a figure's title in lines of at most ``width`` letters; a dollar sign is one."""
    figure.suptitle("\n".join(wrap(title, width)), parse_math=False)


@contextmanager
def paper_style() -> Iterator[None]:
    """Draw for a paper's columns while the block runs; text stays text in PDF and SVG."""
    with rc_context(
        {
            "font.size": 8.0,
            "axes.titlesize": 8.0,
            "figure.titlesize": 9.0,
            "legend.frameon": False,
            "lines.linewidth": 1.2,
            "pdf.fonttype": 42,  # TrueType, to be searched and edited
            "svg.fonttype": "none",  # letters, not outlines
            "svg.hashsalt": "spiral_gripper",
        }
    ):
        yield


def panels(count: int) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels side by side."""
    figure = Figure(figsize=(7.0 if count > 1 else 4.6, 2.6), layout="constrained")
    panels = [figure.add_subplot(1, count, number) for number in range(1, count + 1)]
    for axes in panels:
        style_axes(axes)
    return figure, panels


def style_axes(axes: Axes) -> None:
    """Remove lines without information from the axes."""
    axes.grid(visible=True, color="#dddddd", lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def color_of(number: int) -> str:
    """Return the color of the curve of a number, from 0."""
    return COLORS[number % len(COLORS)]
