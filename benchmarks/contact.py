# SPDX-License-Identifier: Apache-2.0
"""What contact costs: the usual gripper on a cylinder, warm and cold, pulled, and on N elements."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from benchmarks.cases import OUTER_RADIUS, SECOND_MOMENT, Vector
from benchmarks.results import Effort, Section, Table, milli
from benchmarks.timing import median_time
from spiral_core import Cylinder, Obstacle, Rod, RodProblem
from spiral_core import (
    Section as Stiffness,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

LENGTH, YOUNG, RADIUS = 0.36, 0.78e6, 0.015
# Twist and curvature of the 70 degree gripper at the stretch that fits the cylinder, and at 1.1.
FITS = np.array((-18.007, 0.0, 40.675))
CLOSED = np.array((-20.009, 0.0, 44.743))
AXIS = FITS / np.linalg.norm(FITS)
FRICTION = 0.3
PULL, STEP = 0.06, 2e-3
COUNTS = (45, 90, 180, 360, 720)
USUAL = 180


def problem(scale: float, friction: float = 0.0, shift: float = 0.0) -> RodProblem:
    """Return the gripper, its strain scaled, tangent to a cylinder shifted away from the base."""
    x, y, z = (np.array((0.0, RADIUS + OUTER_RADIUS, 0.0)) - shift * AXIS).tolist()
    u, v, w = (scale * CLOSED).tolist()
    a, b, c = AXIS.tolist()
    bending = YOUNG * SECOND_MOMENT
    stiffness = Stiffness((2.0 / 3.0 * bending, bending, bending))
    axis: Vector = (a, b, c)
    return RodProblem(
        Rod(LENGTH, stiffness, OUTER_RADIUS, (u, v, w)),
        obstacles=(Obstacle.along(Cylinder(RADIUS), (x, y, z), axis, friction),),
    )


def warm_rows(effort: Effort) -> tuple[list[tuple[str, ...]], dict[str, float]]:
    """Return times of cold and warm solves against N, and the order of their growth."""
    rows: list[tuple[str, ...]] = []
    warm: list[float] = []
    for count in COUNTS:
        start = solve_contact(problem(1.0), elements=count)
        near = problem(1.01)
        cold = median_time(partial(solve_contact, problem(1.0), elements=count), 3, warmup=0)
        step = partial(solve_contact, near, start=start)
        warm.append(median_time(step, max(3, effort.long // 10)))
        rows.append(
            (
                str(count),
                milli(cold),
                str(start.iterations),
                milli(warm[-1]),
                str(step().iterations),
                milli(warm[-1] / count),
            )
        )
    order = math.log(warm[-1] / warm[1]) / math.log(COUNTS[-1] / COUNTS[1])
    return rows, {"warm_180": warm[COUNTS.index(USUAL)], "order": order}


def pull() -> tuple[float, float, int]:
    """Return time, peak force [N] and Newton passes of pulling the object until it has slipped."""
    closed = solve_contact(problem(1.0), elements=USUAL // 2)
    stations = [problem(1.0, FRICTION, shift) for shift in np.arange(STEP, PULL + 0.5 * STEP, STEP)]
    path = follow_contact(stations, start=closed)
    time = median_time(lambda: follow_contact(stations, start=closed), 3, warmup=0)
    forces = [abs(float(state.on_obstacle().force @ AXIS)) for state in path.states]
    return time, max(forces), sum(state.iterations for state in path.states)


def measure(effort: Effort) -> Section:
    """Measure what contact costs."""
    rows, values = warm_rows(effort)
    time, peak, passes = pull()
    values["pull"] = time
    table = Table(
        "Contact: the gripper of 70 degrees on a cylinder",
        ("N", "cold", "passes", "warm", "passes", "warm, per element"),
        tuple(rows),
        "The paper's tube on a cylinder of 15 mm, at 1.1 of the stretch that fits it, no gravity. "
        "Cold: from the straight rod. Warm: after a change of the rest strain by 1 %. From N = 90 "
        f"to 720 the warm time grows as N^{values['order']:.2f}. The pull: the cylinder moved "
        f"{1e3 * PULL:.0f} mm along its axis in steps of {1e3 * STEP:.0f} mm, friction {FRICTION}, "
        f"N = {USUAL // 2}: {milli(time)}, {passes} passes, peak {peak:.2f} N.",
    )
    return Section((table,), values)
