# SPDX-License-Identifier: Apache-2.0
"""Convergence of a grip in the number of elements: the same grip on twice as many."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from spiral_core.grip.grip import Grip
from spiral_core.grip.holding import Pull, holding_force
from spiral_core.grip.window import GripWindow, WindowEnd, grip_window


@dataclass(frozen=True, slots=True)
class Refinement:
    """What twice the elements change, and how far the contact lets the tube sink in.

    Contact is hard, without a stiffness to choose: its sharpness is the penetration that is left.

    Args:
        elements: of the grip.
        window: largest change of an onset or the loss, as a fraction; infinite where only one of
            the two has it.
        force: the same of the holding force away from the base at the recommended pressure.
        penetration: largest of a node into the object, as a fraction of the tube's outer radius.
    """

    elements: int
    window: float
    force: float
    penetration: float

    def __str__(self) -> str:
        return (
            f"{self.elements} and {2 * self.elements} elements: window differs by "
            f"{100.0 * self.window:.1f} %, force by {100.0 * self.force:.1f} %; "
            f"contact sinks in by {self.penetration:.0e} r_o"
        )


def refine(grip: Grip) -> Refinement:
    """Return what twice the elements change of a grip.

    Takes some three times as long as the window itself.

    Raises:
        NotGrippableError: the grip has no window, or none on twice the elements.
        SolverError: a state could not be certified.
    """
    window = grip.window
    count = window.setup.element_count
    stations = None if window.end is WindowEnd.LOST else window.pressures[1:]
    finer = grip_window(replace(window.setup, elements=2 * count), stations)
    pressure = min(grip.recommended_pressure(), finer.top)
    coarse, fine = (holding_force(each.at(pressure), Pull.AWAY).force for each in (window, finer))
    sunk = min(float(point.state.gaps.min()) for each in (window, finer) for point in each.points)
    return Refinement(
        elements=count,
        window=max(
            _change(coarse, fine)
            for coarse, fine in zip(_edges(window), _edges(finer), strict=True)
        ),
        force=_change(coarse, fine),
        penetration=max(0.0, -sunk) / window.setup.gripper.tube.outer_radius,
    )


def _edges(window: GripWindow) -> tuple[float | None, float | None, float | None]:
    """Return the onsets of wrap and curling, and the loss [Pa]."""
    return window.onset_wrap, window.onset_curling, window.loss


def _change(coarse: float | None, fine: float | None) -> float:
    """Return how far two values differ, as a fraction of the finer."""
    if coarse is None and fine is None:
        return 0.0
    if coarse is None or fine is None:
        return math.inf
    return 0.0 if coarse == fine else abs(coarse - fine) / max(abs(fine), 1e-300)
