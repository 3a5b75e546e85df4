# SPDX-License-Identifier: Apache-2.0
"""The studio's chart: pressure against the radius that it wraps, and where the gripper is now."""

from __future__ import annotations

import numpy as np
from viser import uplot

from spiral_core.rod.types import Array
from spiral_gripper.files.shown import axis_label, in_units
from spiral_gripper.studio.session import Answer

SERIES = (
    uplot.Series(label="radius"),
    uplot.Series(label="perfect wrap", stroke="#c8553d", width=2),
    uplot.Series(label="now", stroke="#2f4858", points=uplot.Series_Points(show=True, size=10)),
)


def chart_axes() -> tuple[uplot.Axis, uplot.Axis]:
    """Return the chart's axes, with the units that are shown."""
    return (
        uplot.Axis(label=axis_label("object radius", "m")),
        uplot.Axis(label=axis_label("pressure", "Pa")),
    )


def chart_data(answer: Answer | None, radius: float, pressure: float) -> tuple[Array, ...]:
    """Return the chart's radii, wrap pressures, and the present pressure, in the units shown.

    Args:
        answer: what is wrapped; None or without wraps: the point alone is drawn.
        radius: of the object [m].
        pressure: gauge pressure now [Pa].
    """
    if answer is None or answer.radii.size == 0:
        here = in_units([radius, radius + 1e-6], "m")
        return here, np.full(2, np.nan), in_units([pressure, np.nan], "Pa")
    order = np.argsort(answer.radii)
    radii, pressures = answer.radii[order], answer.pressures[order]
    place = int(np.searchsorted(radii, radius))
    inside = 0 < place < len(radii)
    between = float(np.interp(radius, radii, pressures)) if inside else np.nan
    now = np.full(len(radii) + 1, np.nan)
    now[place] = pressure
    return (
        in_units(np.insert(radii, place, radius), "m"),
        in_units(np.insert(pressures, place, between), "Pa"),
        in_units(now, "Pa"),
    )


def chart_scales(answer: Answer | None, pressure_max: float) -> dict[str, uplot.Scale]:
    """Return the chart's ranges: all radii that are wrapped, all pressures up to the limit [Pa]."""
    widest = 0.04 if answer is None or answer.radii.size == 0 else float(answer.radii.max())
    return {
        "x": uplot.Scale(time=False, auto=False, range=(0.0, 1.1 * float(in_units(widest, "m")))),
        "y": uplot.Scale(auto=False, range=(0.0, float(in_units(pressure_max, "Pa")))),
    }
