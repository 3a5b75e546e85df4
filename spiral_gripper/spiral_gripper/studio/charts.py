# SPDX-License-Identifier: Apache-2.0
"""The studio's charts: pressure against radius, force against pressure, and the gripper now."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import viser
from viser import uplot

from spiral_core import Pull
from spiral_core.rod.types import Array
from spiral_gripper.files.shown import in_units
from spiral_gripper.studio.session import Answer
from spiral_gripper.studio.settings import Settings

# Of a curve that is not known.
_NOTHING = np.array([np.nan])
RED, PALE, DARK = "#c8553d", "#7ba7b4", "#2f4858"

# The axes of a chart follow its data, the one upwards from zero: the browser sees to it.
FOLLOWING = {
    "x": uplot.Scale(time=False),
    "y": uplot.Scale(
        range={"min": {"soft": 0.0, "mode": 1}, "max": {"soft": 1e-3, "mode": 1, "pad": 0.1}}
    ),
}


def add_chart(
    gui: viser.GuiApi, x: str, y: str, curves: dict[str, str], *, now: bool = True
) -> viser.GuiUplotHandle:
    """Add an empty chart.

    Args:
        gui: where it is put.
        x: label of the axis to the right, with the unit shown.
        y: label of the axis upwards.
        curves: color by name.
        now: whether a dot shows where the gripper is now.
    """
    series = [uplot.Series(label=name, stroke=color, width=2) for name, color in curves.items()]
    if now:
        dot = uplot.Series_Points(show=True, size=10)
        series.append(uplot.Series(label="now", stroke=DARK, points=dot))
    return gui.add_uplot(
        tuple(np.zeros(1) for _ in range(len(series) + 1)),
        (uplot.Series(label=x), *series),
        axes=(uplot.Axis(label=x), uplot.Axis(label=y)),
        scales=FOLLOWING,
        legend={"show": False},
        aspect=1.5,
        padding=(14, 14, 0, 0),  # the highest label of an axis is not cut off
    )


def update_chart(
    chart: viser.GuiUplotHandle, data: tuple[Array, ...], scales: dict[str, uplot.Scale]
) -> None:
    """Draw curves between the ends of their axes; the same ends are not sent again.

    With new ends the page lays itself out anew: a slow browser that gets some fifty of them at
    once ends with an error.
    """
    if chart.scales != scales:
        chart.scales = scales
    chart.data = data


def _ranges(right: float, top: float) -> dict[str, uplot.Scale]:
    """Return the ranges of a chart: from 0 to ``right``, and from 0 to ``top``."""
    return {
        "x": uplot.Scale(time=False, auto=False, range=(0.0, right)),
        "y": uplot.Scale(auto=False, range=(0.0, top)),
    }


def chart_data(answer: Answer | None, settings: Settings) -> tuple[Array, ...]:
    """Return the chart's radii, wrap pressures, and the present pressure, in the units shown.

    Without an answer, or without wraps, the point alone is drawn.
    """
    radii, pressures = np.array([settings.object_radius + 1e-6]), _NOTHING
    if answer is not None and answer.radii.size:
        radii, pressures = answer.radii, answer.pressures
    radii, (pressures,), now = _with(
        settings.object_radius, radii, [pressures], lambda _: settings.pressure
    )
    return in_units(radii, "m"), in_units(pressures, "Pa"), in_units(now, "Pa")


def chart_scales(answer: Answer | None, pressure_max: float) -> dict[str, uplot.Scale]:
    """Return the chart's ranges: all radii that are wrapped, all pressures up to the limit [Pa]."""
    widest = 0.04 if answer is None else float(answer.radii.max(initial=0.0)) or 0.04
    return _ranges(1.1 * float(in_units(widest, "m")), float(in_units(pressure_max, "Pa")))


def force_data(answer: Answer | None, pressure: float) -> tuple[Array, ...]:
    """Return pressures, forces away and towards the base, the present force, in the units shown.

    Args:
        answer: what is known; without a grip the point alone is drawn, at no force.
        pressure: gauge pressure now [Pa].
    """
    pressures, forces = np.array([pressure + 1.0]), [_NOTHING, _NOTHING]
    if answer is not None and answer.grip is not None:
        pressures = answer.grip.pressures
        forces = [answer.grip.force(pull) for pull in (Pull.AWAY, Pull.TOWARDS)]
    pressures, (away, towards), now = _with(
        pressure, pressures, forces, lambda values: float(np.nan_to_num(values[0]))
    )
    return in_units(pressures, "Pa"), *(in_units(one, "N") for one in (away, towards, now))


def force_scales(answer: Answer | None, pressure_max: float) -> dict[str, uplot.Scale]:
    """Return the chart's ranges: all pressures up to the limit [Pa], all forces."""
    known = answer is not None and answer.grip is not None
    most = float(np.nan_to_num(answer.grip.force(Pull.AWAY)).max()) if known else 1.0  # type: ignore[union-attr]
    top = float(in_units(1.1 * max(most, 1e-3), "N"))
    return _ranges(float(in_units(pressure_max, "Pa")), top)


def _with(
    at: float, places: Array, curves: list[Array], now: Callable[[list[float]], float]
) -> tuple[Array, list[Array], Array]:
    """Return places and curves with one more point at ``at``, NaN outside, and a dot there alone.

    ``now`` returns the dot's height from the curves' values.
    """
    index = int(np.searchsorted(places, at))
    inside = 0 < index < len(places)
    values = [float(np.interp(at, places, curve)) if inside else np.nan for curve in curves]
    longer = [np.insert(c, index, value) for c, value in zip(curves, values, strict=True)]
    dot = np.insert(np.full(len(places), np.nan), index, now(values))
    return np.insert(places, index, at), longer, dot
