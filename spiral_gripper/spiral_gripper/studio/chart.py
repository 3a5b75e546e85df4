# SPDX-License-Identifier: Apache-2.0
"""The studio's chart: pressure against the radius that it wraps, and where the gripper is now."""

from __future__ import annotations

import numpy as np
from viser import uplot

from spiral_core.rod.types import Array
from spiral_gripper.studio.session import Answer

SERIES = (
    uplot.Series(label="radius [mm]"),
    uplot.Series(label="perfect wrap [kPa]", stroke="#c8553d", width=2),
    uplot.Series(
        label="now [kPa]", stroke="#2f4858", points=uplot.Series_Points(show=True, size=10)
    ),
)
AXES = (uplot.Axis(label="object radius [mm]"), uplot.Axis(label="pressure [kPa]"))


def chart_data(answer: Answer | None, radius: float, pressure: float) -> tuple[Array, ...]:
    """Return the chart's radii [mm], wrap pressures [kPa], and the present pressure at its radius.

    Args:
        answer: what is wrapped; None or without wraps: the point alone is drawn.
        radius: of the object [m].
        pressure: gauge pressure now [Pa].
    """
    if answer is None or answer.radii.size == 0:
        here = 1e3 * np.array([radius, radius + 1e-6])
        return here, np.full(2, np.nan), np.array([1e-3 * pressure, np.nan])
    order = np.argsort(answer.radii)
    radii, pressures = answer.radii[order], answer.pressures[order]
    place = int(np.searchsorted(radii, radius))
    inside = 0 < place < len(radii)
    between = float(np.interp(radius, radii, pressures)) if inside else np.nan
    now = np.full(len(radii) + 1, np.nan)
    now[place] = pressure
    return (
        1e3 * np.insert(radii, place, radius),
        1e-3 * np.insert(pressures, place, between),
        1e-3 * now,
    )


def chart_scales(answer: Answer | None, pressure_max: float) -> dict[str, uplot.Scale]:
    """Return the chart's ranges: all radii that are wrapped, all pressures up to the limit [Pa]."""
    widest = 0.04 if answer is None or answer.radii.size == 0 else float(answer.radii.max())
    return {
        "x": uplot.Scale(time=False, auto=False, range=(0.0, 1.1e3 * widest)),
        "y": uplot.Scale(auto=False, range=(0.0, 1e-3 * pressure_max)),
    }
