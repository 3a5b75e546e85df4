# SPDX-License-Identifier: Apache-2.0
"""Times of the perfect wrap: from the radius of an object to pressure and shape."""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.results import Effort, Section, Table, micro, milli
from benchmarks.timing import median_time
from spiral_core import WrapCurve
from spiral_gripper import available_grippers, load_gripper

RADII = 40


def measure(effort: Effort) -> Section:
    """Measure the shipped grippers: building the curve, and inverting it."""
    rows: list[tuple[str, ...]] = []
    values: dict[str, float] = {}
    for name in available_grippers():
        gripper = load_gripper(name)
        build = median_time(partial(WrapCurve, gripper), max(2, effort.long // 20), warmup=1)
        curve = WrapCurve(gripper)
        radii = np.linspace(curve.radius_min, curve.radius_max, RADII).tolist()
        times = [
            median_time(partial(curve.wrap_for_radius, r), max(2, effort.short // RADII))
            for r in radii
        ]
        off = max(
            abs(curve.radius_from_pressure(curve.pressure_from_radius(r)) / r - 1.0) for r in radii
        )
        median, worst = float(np.median(times)), max(times)
        values |= {f"build_{name}": build, f"invert_{name}": median, f"worst_{name}": worst}
        rows.append((name, milli(build), micro(median), micro(worst), f"{off:.0e}"))
    return Section(
        (
            Table(
                "Perfect wrap of the shipped grippers",
                ("gripper", "build the curve", "wrap_for_radius", "slowest radius", "round trip"),
                tuple(rows),
                f"{RADII} radii over each gripper's range. The round trip is the relative error of "
                "radius → pressure → radius.",
            ),
        ),
        values | {"invert": max(values[f"invert_{name}"] for name in available_grippers())},
    )
