# SPDX-License-Identifier: Apache-2.0
"""A cable between two poles: how far it sags, what it pulls, and what happens when a pole moves.

Run ``python examples/cable_between_poles.py``.
"""

from __future__ import annotations

import numpy as np

from spiral_core import Pinned, Rod, RodLoad, RodProblem, Section, follow_rod, solve_rod

# A rubber cable, 1 m long, 10 mm thick: it stretches and resists bending a little.
LENGTH, RADIUS = 1.0, 5e-3
CABLE = Rod(LENGTH, Section.round(RADIUS, young=1e6, shear_modulus=1e6 / 3.0), RADIUS)
WEIGHT = 1000.0 * 9.81 * np.pi * RADIUS**2  # [N/m]


def between(span: float) -> RodProblem:
    """Return the cable pinned to two poles at one height."""
    return RodProblem(
        CABLE,
        RodLoad(distributed=(0.0, 0.0, -WEIGHT)),
        base=Pinned((0.0, 0.0, 0.0)),
        tip=Pinned((span, 0.0, 0.0)),
    )


# Released from a shape that is not the answer: two straight pieces.
slack = solve_rod(
    between(0.8), start=np.array([[0.0, 0.0, 0.0], [0.4, 0.0, -0.3], [0.8, 0.0, 0.0]]), elements=50
)
sag = -slack.positions[:, 2].min()
pull = np.linalg.norm(slack.base_reaction[:3])
print(f"span 0.80 m: sags {1e3 * sag:.1f} mm, pulls {pull:.3f} N at each pole")

# One pole is moved away; the cable follows through a path of stable states.
path = follow_rod([between(span) for span in (0.9, 0.95, 0.99)], start=slack)
for span, state in zip((0.9, 0.95, 0.99), path.states, strict=True):
    sag_now = -state.positions[:, 2].min()
    pull_now = np.linalg.norm(state.base_reaction[:3])
    print(f"span {span:.2f} m: sags {1e3 * sag_now:.1f} mm, pulls {pull_now:.3f} N at each pole")
