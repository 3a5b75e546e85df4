# SPDX-License-Identifier: Apache-2.0
"""The studio's second chart: holding force against pressure, and where the gripper is now."""

from __future__ import annotations

import numpy as np
from viser import uplot

from spiral_core import Pull
from spiral_core.rod.types import Array
from spiral_gripper.studio.session import Answer

FORCE_SERIES = (
    uplot.Series(label="pressure [kPa]"),
    uplot.Series(label="away from the base [N]", stroke="#c8553d", width=2),
    uplot.Series(label="towards the base [N]", stroke="#7ba7b4", width=2),
    uplot.Series(label="now [N]", stroke="#2f4858", points=uplot.Series_Points(show=True, size=10)),
)
FORCE_AXES = (uplot.Axis(label="pressure [kPa]"), uplot.Axis(label="holding force [N]"))


def force_data(answer: Answer | None, pressure: float) -> tuple[Array, ...]:
    """Return pressures [kPa], forces away and towards the base [N], and the present force.

    Args:
        answer: what is known; without a grip the point alone is drawn, at no force.
        pressure: gauge pressure now [Pa].
    """
    if answer is None or answer.grip is None:
        here = 1e-3 * np.array([pressure, pressure + 1.0])
        return here, np.full(2, np.nan), np.full(2, np.nan), np.array([0.0, np.nan])
    pressures = answer.grip.pressures
    forces = [answer.grip.force(pull) for pull in (Pull.AWAY, Pull.TOWARDS)]
    place = int(np.searchsorted(pressures, pressure))
    inside = 0 < place < len(pressures)
    between = [float(np.interp(pressure, pressures, f)) if inside else np.nan for f in forces]
    now = np.full(len(pressures) + 1, np.nan)
    now[place] = between[0] if inside else 0.0
    away, towards = (np.insert(f, place, b) for f, b in zip(forces, between, strict=True))
    return 1e-3 * np.insert(pressures, place, pressure), away, towards, now


def force_scales(answer: Answer | None, pressure_max: float) -> dict[str, uplot.Scale]:
    """Return the chart's ranges: all pressures up to the limit [Pa], all forces."""
    known = answer is not None and answer.grip is not None
    most = float(np.max(answer.grip.force(Pull.AWAY))) if known else 1.0  # type: ignore[union-attr]
    return {
        "x": uplot.Scale(time=False, auto=False, range=(0.0, 1e-3 * pressure_max)),
        "y": uplot.Scale(auto=False, range=(0.0, 1.1 * max(most, 1e-3))),
    }
