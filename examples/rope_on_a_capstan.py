# SPDX-License-Identifier: Apache-2.0
"""A rope over a fixed bar: how much more than its counterweight it holds before it slips.

Run ``python examples/rope_on_a_capstan.py``.
"""

from __future__ import annotations

import math

import numpy as np

from spiral_core import (
    Cylinder,
    Free,
    Obstacle,
    PointLoad,
    Rod,
    RodLoad,
    RodProblem,
    Section,
    follow_rod,
    solve_rod,
)

# A thin rope over a bar of 100 mm: half a turn, and 200 mm hanging on either side.
RADIUS, HANGING, BAR, FRICTION = 1e-3, 0.2, 0.05, 0.3
AROUND = BAR + RADIUS
LENGTH = 2.0 * HANGING + math.pi * AROUND
ROPE = Rod(
    LENGTH,
    Section.round(RADIUS, young=3e6, shear_modulus=1e6),
    RADIUS,
    friction_radius=0.0,  # at the centerline, as in the capstan equation
)
COUNTERWEIGHT = 0.5  # [N]


def loaded(ratio: float) -> RodProblem:
    """Return the rope with the counterweight on one end and ``ratio`` times it on the other."""
    return RodProblem(
        ROPE,
        RodLoad(tip_force=(0.0, 0.0, -ratio * COUNTERWEIGHT)),
        base=Free(),
        point_loads=(PointLoad(0.0, force=(0.0, 0.0, -COUNTERWEIGHT)),),
        obstacles=(
            Obstacle.along(Cylinder(BAR), (0.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0), friction=FRICTION),
        ),
    )


def draped(s: float) -> tuple[float, float, float]:
    """Return the rope's place over the bar at arc length s."""
    angle = min(max((s - HANGING) / AROUND, 0.0), math.pi)
    below = min(s - HANGING, 0.0) + min(LENGTH - HANGING - s, 0.0)
    return (-AROUND * math.cos(angle), 0.0, AROUND * math.sin(angle) + below)


ELEMENTS = 100
places = np.array([draped(s) for s in np.linspace(0.0, LENGTH, ELEMENTS + 1)])
even = solve_rod(loaded(1.0), start=places, elements=ELEMENTS)
print(f"{even.contact_lengths[0] / AROUND:.2f} rad of the bar are touched; stable: {even.stable}")

# With increasing load on one side the rope stretches, and slip starts on that side.
ratios = (1.5, 2.0, 2.5)
path = follow_rod([loaded(ratio) for ratio in ratios], start=even)
for ratio, state in zip(ratios, path.states, strict=True):
    moved = np.abs(state.positions - even.positions).max()
    print(f"{ratio:.1f} to 1: held; the heavy end is {1e3 * moved:.1f} mm lower, by stretch")
print(f"the capstan equation allows {math.exp(FRICTION * math.pi):.2f} to 1")
