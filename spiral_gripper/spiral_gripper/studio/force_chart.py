# SPDX-License-Identifier: Apache-2.0
"""The studio's second chart: holding force against pressure, and where the gripper is now."""

from __future__ import annotations

import numpy as np
from viser import uplot

from spiral_core import Pull
from spiral_core.rod.types import Array
from spiral_gripper.files.shown import axis_label, in_units
from spiral_gripper.studio.session import Answer

FORCE_SERIES = (
    uplot.Series(label="pressure"),
    uplot.Series(label="away from the base", stroke="#c8553d", width=2),
    uplot.Series(label="towards the base", stroke="#7ba7b4", width=2),
    uplot.Series(label="now", stroke="#2f4858", points=uplot.Series_Points(show=True, size=10)),
)


def force_axes() -> tuple[uplot.Axis, uplot.Axis]:
    """Return the chart's axes, with the units that are shown."""
    return (
        uplot.Axis(label=axis_label("pressure", "Pa")),
        uplot.Axis(label=axis_label("holding force", "N")),
    )


def force_data(answer: Answer | None, pressure: float) -> tuple[Array, ...]:
    """Return pressures, forces away and towards the base, the present force, in the units shown.

    Args:
        answer: what is known; without a grip the point alone is drawn, at no force.
        pressure: gauge pressure now [Pa].
    """
    if answer is None or answer.grip is None:
        here = in_units([pressure, pressure + 1.0], "Pa")
        return here, np.full(2, np.nan), np.full(2, np.nan), np.array([0.0, np.nan])
    pressures = answer.grip.pressures
    forces = [answer.grip.force(pull) for pull in (Pull.AWAY, Pull.TOWARDS)]
    place = int(np.searchsorted(pressures, pressure))
    inside = 0 < place < len(pressures)
    between = [float(np.interp(pressure, pressures, f)) if inside else np.nan for f in forces]
    now = np.full(len(pressures) + 1, np.nan)
    now[place] = between[0] if inside else 0.0
    away, towards = (np.insert(f, place, b) for f, b in zip(forces, between, strict=True))
    there = in_units(np.insert(pressures, place, pressure), "Pa")
    return there, in_units(away, "N"), in_units(towards, "N"), in_units(now, "N")


def force_scales(answer: Answer | None, pressure_max: float) -> dict[str, uplot.Scale]:
    """Return the chart's ranges: all pressures up to the limit [Pa], all forces."""
    known = answer is not None and answer.grip is not None
    most = float(np.max(answer.grip.force(Pull.AWAY))) if known else 1.0  # type: ignore[union-attr]
    return {
        "x": uplot.Scale(time=False, auto=False, range=(0.0, float(in_units(pressure_max, "Pa")))),
        "y": uplot.Scale(auto=False, range=(0.0, float(in_units(1.1 * max(most, 1e-3), "N")))),
    }
