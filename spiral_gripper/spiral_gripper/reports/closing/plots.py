# SPDX-License-Identifier: Apache-2.0
"""Pictures of a closing in real time."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeAlias

import numpy as np
from matplotlib.animation import PillowWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from spiral_core.grip.closing import TimedClosing
from spiral_core.grip.window import GripPoint
from spiral_gripper.files.shown import axis_label, in_units, shown
from spiral_gripper.files.storage import write_file
from spiral_gripper.reports.fields import Progress
from spiral_gripper.reports.grip.plots import coil_surfaces
from spiral_gripper.reports.shape_plots import draw_sides
from spiral_gripper.reports.style import COLORS, panels, paper_style, set_title

# Of an animation: pictures per second, dots per inch, and the most pictures.
PICTURE_RATE, DOTS, MOST_PICTURES = 12.5, 80, 250
# Around what is drawn [m].
ROOM = 0.03

# Of both axes, in the units shown.
Limits: TypeAlias = tuple[tuple[float, float], tuple[float, float]]


@paper_style()
def close_figure(closing: TimedClosing) -> Figure:
    """Return contact and pressure, and the tip's speed, against time."""
    figure, (left, right) = panels(2)
    times = [frame.time for frame in closing.frames]
    left.plot(times, [100.0 * c for c in closing.contact_fractions], color=COLORS[1])
    left.set(xlabel="time [s]", ylabel="in contact [% of the tube]", ylim=(0.0, 100.0))
    beside = left.twinx()
    beside.plot(times, in_units([closing.course.at(t) for t in times], "Pa"), ":", color=COLORS[2])
    beside.set_ylabel(axis_label("pressure", "Pa"), color=COLORS[2])
    beside.set_ylim(bottom=0.0)
    speeds = [float(np.linalg.norm(frame.velocities[-1])) for frame in closing.frames]
    right.plot(times, speeds, color=COLORS[0])
    right.set(xlabel="time [s]", ylabel="speed of the tip [m/s]")
    right.set_ylim(bottom=0.0)
    radius = shown(float(closing.setup.obstacle.shape.feature_radius), "m")
    set_title(figure, f"{closing.setup.gripper.name} closes on radius {radius}")
    return figure


@paper_style()
def write_animation(closing: TimedClosing, path: Path, progress: Progress | None = None) -> None:
    """Write a closing in real time as an animated picture; ``progress`` counts the pictures.

    Raises:
        FileError: it cannot be written.
    """
    last = closing.frames[-1].time
    count = min(MOST_PICTURES, max(2, round(last * PICTURE_RATE)), len(closing.frames))
    chosen = np.rint(np.linspace(0, len(closing.frames) - 1, count)).astype(int)
    limits, center = _limits(closing), np.asarray(closing.setup.obstacle.position)
    heights = [(one.state.positions - center) @ closing.setup.axis for one in closing.frames]
    reach = float(np.min(heights)), float(np.max(heights))  # every frame's tube lies beside it
    figure = Figure(figsize=(6.0, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    writer = PillowWriter(fps=max(1, round(count / max(last, 1e-3))))
    with TemporaryDirectory() as folder:
        written = Path(folder) / "closing.gif"
        with writer.saving(figure, str(written), DOTS):
            for done, index in enumerate(chosen, start=1):
                frame = closing.frames[index]
                pressure = closing.course.at(frame.time)
                figure.clear()
                figure.suptitle(f"{frame.time:.2f} s, {shown(pressure, 'Pa', 3)}")
                point = GripPoint(pressure, closing.setup, frame.state)
                for axes in draw_sides(figure, coil_surfaces(point, reach)):
                    axes.set(xlim=limits[0], ylim=limits[1])
                writer.grab_frame()
                if progress is not None:
                    progress(done, count)
        write_file(path, written.read_bytes())


def _limits(closing: TimedClosing) -> Limits:
    """Return limits that hold every frame, across and along the hanging tube, in units shown."""
    positions = in_units(np.array([frame.state.positions for frame in closing.frames]), "m")
    room = float(in_units(ROOM, "m"))
    reach = float(np.abs(positions[:, :, 1:]).max()) + room
    down = float(positions[:, :, 0].max()) + room
    return (-reach, reach), (-down, room - float(positions[:, :, 0].min()))
