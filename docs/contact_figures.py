# SPDX-License-Identifier: Apache-2.0
"""Draw the contact page's figure: a pull, surface or axis, and the error of a buckled rod.

Run by ``make figures``.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

from benchmarks.contact import AXIS, FRICTION, problem
from spiral_core import (
    Cylinder,
    Obstacle,
    Pinned,
    Rod,
    RodLoad,
    RodProblem,
    Section,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

FIGURE = Path(__file__).parent / "figures" / "contact.png"
# benchmarks/explicit.py with 60 elements: millimeters and newtons.
EXPLICIT = {
    "surface": ((1, 0.495), (2, 0.572), (3, 0.599), (4, 0.618), (5, 0.634), (10, 0.680)),
    "axis": ((1, 0.967), (2, 1.548), (3, 1.610), (4, 1.641), (5, 1.661), (10, 1.685)),
}
LEVERS = {"surface": None, "axis": 0.0}
COLORS = {"surface": "#c8553d", "axis": "#2f6690"}


def draw_pull(axes: Axes) -> None:
    """Draw the axial force while the object is pulled away from the base."""
    shifts = np.concatenate((np.arange(0.25e-3, 3e-3, 0.25e-3), np.arange(3e-3, 31e-3, 1e-3)))
    for name, lever in LEVERS.items():

        def station(friction: float, shift: float, lever: float | None = lever) -> RodProblem:
            pulled = problem(1.0, friction, shift)
            return replace(pulled, rod=replace(pulled.rod, friction_radius=lever))

        closed = solve_contact(station(0.0, 0.0), elements=60)
        path = follow_contact([station(FRICTION, shift) for shift in shifts], start=closed)
        forces = [state.on_obstacle().force @ AXIS for state in path.states]
        axes.plot(1e3 * shifts, forces, color=COLORS[name], label=f"friction at the {name}")
        axes.plot(
            *zip(*EXPLICIT[name], strict=True), "o", color=COLORS[name], markerfacecolor="none"
        )
    axes.plot([], [], "o", color="gray", markerfacecolor="none", label="explicit simulation")
    axes.set(xlabel="object pulled away [mm]", ylabel="axial force [N]", ylim=(0.0, None))
    axes.legend(loc="lower right")


def buckled_error(elements: int) -> float:
    """Return the error of a buckled rod's angle in a tube [rad], with a closed form's push."""
    bending, rho, radius, angle = 0.3, 0.01, 0.004, 0.35
    push = 2.0 * bending * math.sin(angle) ** 2 * math.cos(angle) / rho**2
    length = 5.0 * 2.0 * math.pi * rho / math.sin(angle)
    s = np.linspace(0.0, length, elements + 1)
    around, inside = s * math.sin(angle) / rho, 0.98 * rho
    start = np.column_stack((inside * np.cos(around), inside * np.sin(around), s * math.cos(angle)))
    buckled = RodProblem(
        Rod(length, Section((0.2, bending, bending)), radius),
        RodLoad(tip_force=(0.0, 0.0, -push)),
        base=Pinned((inside, 0.0, 0.0)),
        obstacles=(Obstacle(Cylinder(rho + radius, inside=True)),),
    )
    state = solve_contact(buckled, start=start, elements=elements)
    return abs(math.acos(state.tangents[elements // 2, 2]) - angle)


def draw_orders(axes: Axes) -> None:
    """Draw the error against the number of elements."""
    counts = np.array((80, 100, 140, 200, 280))
    errors = np.array([buckled_error(int(count)) for count in counts])
    axes.loglog(
        counts, errors, "o-", color=COLORS["surface"], label="angle of a rod buckled in a tube"
    )
    slope = errors[1] * (counts / counts[1]) ** -4.0
    axes.loglog(counts, slope, "--", color="gray", label="fourth order")
    axes.set(xlabel="elements", ylabel="error [rad]", xticks=counts, xticklabels=counts)
    axes.minorticks_off()
    axes.legend()


def main() -> None:
    """Draw both panels."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.4), layout="constrained")
    draw_pull(left)
    draw_orders(right)
    figure.savefig(FIGURE, dpi=150)


if __name__ == "__main__":
    main()
