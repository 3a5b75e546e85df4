# SPDX-License-Identifier: Apache-2.0
"""The winding template of a tube: its fibers on the unrolled surface in true size."""

from __future__ import annotations

import io
import math
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from spiral_core.actuator.actuator import Actuator, windings_of
from spiral_core.errors import InvalidInputError
from spiral_core.message import Message, Quantity
from spiral_core.rounding import rounded_down
from spiral_gripper.files.storage import write_file
from spiral_gripper.reports.design_document import LEAST_PITCH
from spiral_gripper.reports.style import COLORS, paper_style
from spiral_gripper.reports.tables import winding_rows

# The area common to A4 and US letter [mm], and the position of the strips on it.
PAGE_WIDTH, PAGE_HEIGHT, MARGIN = 210.0, 279.0, 12.0
STRIP_LENGTH = 200.0
STRIP_GAP = 8.0
RULER = 100.0
MILLIMETERS_PER_INCH = 25.4
FAMILY_STYLES = ((COLORS[1], 0.25), (COLORS[2], 0.8))
FIBER_STYLE = ("black", 1.4)


def winding_figures(actuator: Actuator, name: str, end_allowance: float) -> list[Figure]:
    """Return the pages: the figures of the winding, a ruler to check the print, the template.

    The template is cut into strips of at most 200 mm that follow one another along the tube.

    Args:
        actuator: the actuator.
        name: of the gripper.
        end_allowance: tube that plug and fitting take up at each end [m].

    Raises:
        InvalidInputError: a family is too steep to be wound; a tube too thick for the page.
    """
    around = 2e3 * math.pi * actuator.tube.outer_radius
    width = PAGE_WIDTH - 2.0 * MARGIN
    if around > width:
        diameter = 2e3 * actuator.tube.outer_radius
        raise InvalidInputError("outer diameter [mm]", diameter, f"at most {width / math.pi:.4g}")
    for winding in windings_of(actuator):
        if winding.pitch < LEAST_PITCH:
            steepest = math.atan2(2.0 * math.pi * actuator.tube.outer_radius, LEAST_PITCH)
            requirement = Message(
                "at most {}, a pitch of {}",
                Quantity(steepest, "rad", rounded_down),
                Quantity(LEAST_PITCH, "m"),
            )
            raise InvalidInputError("fiber angle", abs(winding.angle), requirement, "rad")
    length = 1e3 * actuator.tube.length
    starts = np.arange(0.0, length, STRIP_LENGTH).tolist()
    each = max(1, int((width + STRIP_GAP) / (around + STRIP_GAP)))
    groups = [starts[k : k + each] for k in range(0, len(starts), each)]
    return [_page(actuator, name, end_allowance, group, around) for group in groups]


def write_winding_sheet(actuator: Actuator, name: str, end_allowance: float, path: Path) -> None:
    """Write the sheet; the suffix decides the format (.pdf, .svg).

    Raises:
        InvalidInputError: as :func:`winding_figures`, or an SVG would have several pages.
        FileError: it cannot be written.
    """
    pages = winding_figures(actuator, name, end_allowance)
    content = io.BytesIO()
    with paper_style():
        if path.suffix.lower() == ".pdf":
            with PdfPages(content, metadata={"CreationDate": None}) as file:
                for page in pages:
                    file.savefig(page)
        elif len(pages) > 1:
            raise InvalidInputError("pages of an SVG", len(pages), "1; write a .pdf")
        else:
            pages[0].savefig(content, format="svg", metadata={"Date": None})
    write_file(path, content.getvalue())


@paper_style()
def _page(
    actuator: Actuator, name: str, end_allowance: float, starts: list[float], around: float
) -> Figure:
    """Return one page with the strips that begin at these places along the tube [mm].

    Seen from outside, the tube's axis upwards; a right-handed fiber rises to the right. On each
    turn a fiber is drawn again, one circumference to the left; the strip's edges cut it off.
    """
    figure = Figure(figsize=(PAGE_WIDTH / MILLIMETERS_PER_INCH, PAGE_HEIGHT / MILLIMETERS_PER_INCH))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, PAGE_WIDTH), ylim=(0.0, PAGE_HEIGHT))
    axes.set_axis_off()
    top, bottom, length = PAGE_HEIGHT - MARGIN, 1.8 * MARGIN, 1e3 * actuator.tube.length
    title = f"{name}: winding sheet, print at 100 %"
    axes.text(MARGIN, top, title, fontsize=11, va="top", parse_math=False)
    for number, (label, text) in enumerate(winding_rows(actuator, end_allowance)):
        height = top - 8.0 - 4.2 * number
        axes.text(MARGIN, height, label, va="top")
        axes.text(MARGIN + 52.0, height, text, va="top")
    axes.plot([MARGIN, MARGIN + RULER], [MARGIN] * 2, color="black", lw=0.8, marker="|", ms=8)
    axes.text(MARGIN + RULER + 3.0, MARGIN, "must measure 100 mm", va="center")
    for place, start in enumerate(starts):
        left, end = MARGIN + place * (around + STRIP_GAP), min(start + STRIP_LENGTH, length)
        strip = Rectangle((left, bottom), around, end - start, fill=False, ec="gray", lw=0.4)
        axes.add_patch(strip)
        axes.text(left, bottom - 3.5, f"{start:.4g} to {end:.4g} mm", fontsize=7)
        for angle, middle, (color, thickness) in _fibers(actuator, around):
            ends = middle + math.tan(angle) * np.array((start, end, math.nan))
            turns = np.floor(np.array((ends[:2].min(), ends[:2].max())) / around)
            across = left + ends - around * np.arange(turns[0], turns[1] + 1.0)[:, None]
            along = np.tile((bottom, bottom + end - start, math.nan), len(across))
            (line,) = axes.plot(across.ravel(), along, color=color, lw=thickness)
            line.set_clip_path(strip)  # as an argument it would be lost when the line is added
    return figure


def _fibers(actuator: Actuator, around: float) -> list[tuple[float, float, tuple[str, float]]]:
    """Return angle, place around the lower end and style of each fiber."""
    families = zip(windings_of(actuator), FAMILY_STYLES, strict=False)
    fibers = [(winding.angle, 0.5 * around, style) for winding, style in families]
    first = actuator.single_fibers[0].position if actuator.single_fibers else 0.0
    for fiber in actuator.single_fibers:
        turned = (0.5 + (fiber.position - first) / (2.0 * math.pi)) % 1.0
        fibers.append((fiber.angle, turned * around, FIBER_STYLE))
    return fibers
