# SPDX-License-Identifier: Apache-2.0
"""Radii that all differ, and the pressures that answer them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.ros.session import GRIPPER
from spiral_core import WrapCurve
from spiral_gripper import load_gripper

# Part of the grippable range that is swept, in the middle of it.
LOWEST, HIGHEST = 0.3, 0.7
# Different radii; the sweep goes up and down over them.
STEPS = 800


@dataclass(frozen=True, slots=True)
class Sweep:
    """What is sent, and what must come back.

    Args:
        values: to be sent; each differs from those shortly before it.
        answers: the numbers that answer them.
    """

    values: tuple[float, ...]
    answers: tuple[float, ...]

    def part(self, start: int, count: int) -> Sweep:
        """Return ``count`` of the endless repetition from ``start`` on."""
        indices = [(start + k) % len(self.values) for k in range(count)]
        return Sweep(
            tuple(self.values[i] for i in indices), tuple(self.answers[i] for i in indices)
        )


def radius_sweep() -> Sweep:
    """Return a sweep of radii [m], up and down in small steps, and their wrap pressures [Pa].

    The pressures come from the solver that the node uses, so that they are the same to the bit.
    """
    curve = WrapCurve(load_gripper(GRIPPER))
    width = curve.radius_max - curve.radius_min
    up = curve.radius_min + width * np.linspace(LOWEST, HIGHEST, STEPS // 2)
    # The way down meets no radius of the way up: an answer belongs to one of them.
    down = up[::-1] - 0.5 * (up[1] - up[0])
    radii = np.concatenate((up, down)).tolist()
    return Sweep(tuple(radii), tuple(curve.pressure_from_radius(radius) for radius in radii))


def echo_sweep() -> Sweep:
    """Return a sweep whose answers are the values themselves."""
    values = tuple(float(k) for k in range(STEPS))
    return Sweep(values, values)
