# SPDX-License-Identifier: Apache-2.0
"""A table of grips next to exact ones: ``python -m benchmarks.ros.grip_tables GRIPPER``.

The table is that of the file beside the gripper's description. Objects between its radii are closed
on and pulled at some pressures, and what the table says of them there is compared. Some minutes a
gripper.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field

import numpy as np

from spiral_core.errors import SpiralError
from spiral_core.grip.holding import Pull, holding_force
from spiral_core.grip.setup import lay_into_coil
from spiral_core.grip.table import NEGLIGIBLE, GripTable
from spiral_core.grip.window import GripWindow, grip_window
from spiral_core.wrap.gripper import Gripper
from spiral_gripper import load_description
from spiral_gripper.files.grips import read_grips

PULLS = ("away", "towards", "down")
# Pressures of the comparison, as multiples of the exact onset; what is past the loss is left out.
MULTIPLES = (1.0, 1.05, 1.1, 1.15, 1.2)


@dataclass(slots=True)
class Comparison:
    """How far a table is off exact grips.

    Args:
        radii: of the objects [m].
        told: of those, which the table tells the forces of.
        errors: by name, of each object that is told: the largest relative deviation.
        not_held: of the objects, which are not held.
    """

    radii: tuple[float, ...]
    told: list[float] = field(default_factory=list)
    errors: dict[str, list[float]] = field(default_factory=dict)
    not_held: list[float] = field(default_factory=list)


def compare(gripper: Gripper, table: GripTable, count: int) -> Comparison:
    """Return how far a table is off ``count`` exact grips, evenly over its range."""
    ends = np.geomspace(table.radii[0], table.radii[-1], count + 1)
    compared = Comparison(tuple(np.sqrt(ends[:-1] * ends[1:]).tolist()))
    for radius in compared.radii:
        window = _window(gripper, radius)
        if window is None:
            compared.not_held.append(radius)
        errors = {} if window is None else _errors(table, radius, window)
        if errors:
            compared.told.append(radius)
        for name, error in errors.items():
            compared.errors.setdefault(name, []).append(error)
    return compared


def _errors(table: GripTable, radius: float, window: GripWindow) -> dict[str, float]:
    """Return by how much a table is off at most, by name; empty where it does not tell."""
    largest = dict[str, float]()
    onset = window.onset_wrap or 0.0
    ends = {"onset_wrap": onset, "onset_curling": window.onset_curling, "loss": window.loss}
    for pressure in (multiple * onset for multiple in MULTIPLES):
        if pressure > window.top:
            break
        told = table.answer(radius, window.setup.tip_pressure or 0.0, pressure)
        if told is None:
            return {}
        point = window.at(pressure)
        floor = NEGLIGIBLE * point.normal_force
        exact = {
            **{name: value for name, value in ends.items() if value is not None},
            "contact_length": point.contact_length,
            "normal_force": max(point.normal_force, floor),
            **{pull: max(holding_force(point, Pull[pull.upper()]).force, floor) for pull in PULLS},
        }
        for name, value in exact.items():
            largest[name] = max(largest.get(name, 0.0), abs(getattr(told, name) - value) / value)
    return largest


def _window(gripper: Gripper, radius: float) -> GripWindow | None:
    """Return the exact window of an object; None where it is not wrapped."""
    try:
        window = grip_window(lay_into_coil(gripper, radius))
    except SpiralError:
        return None
    return window if window.onset_wrap is not None else None


def _print(name: str, compared: Comparison) -> None:
    print(
        f"{name}: {len(compared.radii)} objects, {len(compared.not_held)} not held, "
        f"forces told of {len(compared.told)}"
    )
    for what, errors in compared.errors.items():
        print(f"  {what:15} median {np.median(errors):6.1%}   largest {max(errors):6.1%}")


def main() -> None:
    """Compare the tables of some grippers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("grippers", nargs="*", default=["paper_design_70", "prototype_p1"])
    parser.add_argument("--objects", type=int, default=12, help="between the radii of the table")
    given = parser.parse_args()
    for name in given.grippers:
        description = load_description(name)
        _print(name, compare(description.gripper, read_grips(description), given.objects))


if __name__ == "__main__":
    main()
