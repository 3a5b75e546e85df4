# SPDX-License-Identifier: Apache-2.0
"""Draw the pictures of README and documentation that show a gripper.

Run by ``make figures``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.figure import Figure, FigureBase

from spiral_core import (
    GripSetup,
    PressureCourse,
    Pull,
    close_on,
    grip_window,
    lay_into_coil,
    solve_grip,
)
from spiral_core.grip.window import GripPoint
from spiral_gripper import load_description
from spiral_gripper.reports.grip.plots import grip_figure, object_surface
from spiral_gripper.reports.shaded import Surface, draw_surfaces, tube_surface
from spiral_gripper.reports.style import DPI, paper_style
from spiral_gripper.reports.winding_sheet import winding_figures

FIGURES = Path(__file__).parent / "figures"
GRIPPER, OBJECT_RADIUS = "paper_design_70", 0.02
# Seen from the side, x along the tube pointing down; the window of the pictures [mm].
RIGHT, UP = (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)
ACROSS, DOWN = (-75.0, 110.0), (-375.0, 25.0)
RATES = (20e3, 200e3)  # [Pa/s]
FRAMES_PER_SECOND, LAST_FRAME_REPEATS = 8, 12


def draw_moment(figure: FigureBase, point: GripPoint, pole: Surface, said: str) -> None:
    """Draw the gripper on its object at one pressure, alone on a figure, with a line below."""
    figure.clear()
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    surfaces = [tube_surface(point.state.positions, point.outer_radius), pole]
    draw_surfaces(axes, surfaces, RIGHT, UP)
    axes.set(xlim=ACROSS, ylim=DOWN)
    axes.set_axis_off()
    text = f"{1e-3 * point.pressure:.0f} kPa"
    axes.text(0.97, 0.09, text, transform=axes.transAxes, ha="right", fontsize=11)
    axes.text(0.97, 0.04, said, transform=axes.transAxes, ha="right")


def draw_rates(setup: GripSetup, pressure: float, path: Path) -> None:
    """Write a slow and a fast closing side by side, in real time."""
    closings = [close_on(setup, PressureCourse.ramp(rate, pressure, 1.0)) for rate in RATES]
    pole = object_surface(closings[0].grip_at_rest())
    figure = Figure(figsize=(4.8, 5.2))
    parts = figure.subfigures(1, len(RATES))
    count = round(FRAMES_PER_SECOND * max(closing.course.duration for closing in closings))

    def draw(number: int) -> None:
        time = number / FRAMES_PER_SECOND
        for part, closing, rate in zip(parts, closings, RATES, strict=True):
            frame = min(closing.frames, key=lambda one: abs(one.time - time))
            point = GripPoint(closing.course.at(time), setup, frame.state)
            draw_moment(part, point, pole, f"{1e-3 * rate:.0f} kPa/s, {time:.1f} s")

    with paper_style():
        frames = [*range(count), *[count - 1] * LAST_FRAME_REPEATS]
        movie = FuncAnimation(figure, lambda k: draw(frames[k]), len(frames))
        movie.save(path, PillowWriter(fps=FRAMES_PER_SECOND), dpi=100)


def main() -> None:
    """Write the pictures into docs/figures."""
    described = load_description(GRIPPER)
    (sheet,) = winding_figures(described.actuator, described.gripper.name, 0.02)
    sheet.savefig(FIGURES / "winding_sheet.png", dpi=DPI // 3)
    gripper = described.gripper
    grip = solve_grip(lay_into_coil(gripper, 0.015), (Pull.AWAY, Pull.TOWARDS, Pull.DOWN))
    picture = grip_figure(grip, f"{gripper.name} on radius 15 mm")
    picture.savefig(FIGURES / "grip.png", dpi=DPI // 2)

    setup = lay_into_coil(described.gripper, OBJECT_RADIUS)
    window = grip_window(setup)
    last = solve_grip(setup, (Pull.AWAY, Pull.TOWARDS), window=window)
    shown = [p for p in window.points if p.pressure <= last.recommended_pressure()]
    pole = object_surface(shown[-1])
    figure = Figure(figsize=(2.4, 5.2))
    moments = [*shown, *[shown[-1]] * LAST_FRAME_REPEATS]
    with paper_style():
        movie = FuncAnimation(
            figure,
            lambda k: draw_moment(figure, moments[k], pole, moments[k].regime.value),
            len(moments),
        )
        movie.save(FIGURES / "closing.gif", PillowWriter(fps=FRAMES_PER_SECOND), dpi=100)
        stills = Figure(figsize=(7.0, 4.0))
        picked = np.linspace(0, len(shown) - 1, 4).round().astype(int)
        for part, number in zip(stills.subfigures(1, 4), picked, strict=True):
            draw_moment(part, shown[number], pole, shown[number].regime.value)
        stills.savefig(FIGURES / "closing.png", dpi=DPI // 2)
    draw_rates(setup, 1.15 * float(setup.tip_pressure or 0.0), FIGURES / "closing_rates.gif")


if __name__ == "__main__":
    main()
