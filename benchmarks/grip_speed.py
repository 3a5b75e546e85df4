# SPDX-License-Identifier: Apache-2.0
"""CPU time of a grip: its window, and forces both ways: ``python -m benchmarks.grip_speed``."""

from __future__ import annotations

import time

from benchmarks.command import wide_console
from benchmarks.report import show
from benchmarks.results import Table
from spiral_core import Closing, GripSetup, NotGrippableError, Pull, lay_into_coil, solve_grip
from spiral_gripper import load_gripper

CASES = (("paper_design_70", 0.015), ("paper_design_70", 0.030), ("prototype_p1", 0.015))
BOTH_WAYS = (Pull.AWAY, Pull.TOWARDS)


def measured(setup: GripSetup) -> tuple[float, float]:
    """Return the CPU time [s] of the window and of ten forces each way."""
    begin = time.process_time()
    window = solve_grip(setup, (), pressures=()).window
    between = time.process_time()
    solve_grip(setup, BOTH_WAYS, window=window)
    return between - begin, time.process_time() - between


def refused_after(setup: GripSetup) -> float:
    """Return the CPU time [s] after which an object beside the coil is refused."""
    aside = setup.obstacle.moved(translation=(0.0, 0.15, 0.0))
    begin = time.process_time()
    try:
        solve_grip(GripSetup(setup.gripper, aside, setup.closing, None, setup.tip_pressure))
    except NotGrippableError:
        return time.process_time() - begin
    raise AssertionError("an object beside the coil is held")


def main() -> None:
    """Print the table."""
    rows = []
    measured(lay_into_coil(load_gripper(CASES[0][0]), CASES[0][1]))  # loads the kernels
    for name, radius in CASES:
        for closing in Closing:
            setup = lay_into_coil(load_gripper(name), radius, closing=closing)
            times = (*measured(setup), refused_after(setup))
            what = f"{name}, {1e3 * radius:.0f} mm, {closing.name.lower()}"
            rows.append((what, *(f"{seconds:.2f} s" for seconds in times)))
    columns = ("grip", "window", "forces at 10 pressures, both ways", "refusal of one beside")
    show(Table("CPU time of a grip", columns, tuple(rows)), wide_console())


if __name__ == "__main__":
    main()
