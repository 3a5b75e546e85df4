# SPDX-License-Identifier: Apache-2.0
"""A pre-curved coil that closes around a cone: where it touches and how hard it holds.

Run ``python examples/coil_on_a_cone.py``.
"""

from __future__ import annotations

import math

import numpy as np

from spiral_core import Cone, Obstacle, Rod, RodProblem, Section, follow_rod

# A tube of 11 mm whose unloaded coil is tighter than the cone.
RADIUS, LENGTH, BENDING = 5.5e-3, 0.3, 8e-4
CURVATURE, TORSION = 45.0, 15.0
TUBE = Section((0.67 * BENDING, BENDING, BENDING))

# The cone's radius is 15 mm where the tube is clamped, and grows by a tenth of the way along it.
SIZE, SLOPE = 15e-3, 0.1
AXIS = np.array((TORSION, 0.0, CURVATURE)) / math.hypot(TORSION, CURVATURE)
CONE = Obstacle.along(
    Cone(SIZE, SLOPE),
    point=(0.0, 1.02 * (SIZE + RADIUS), 0.0),
    axis=(float(AXIS[0]), 0.0, float(AXIS[2])),
    friction=0.2,
)


def curled(fraction: float) -> RodProblem:
    """Return the tube, clamped beside the cone, with a part of its rest strain."""
    strain = (fraction * TORSION, 0.0, fraction * CURVATURE)
    return RodProblem(Rod(LENGTH, TUBE, RADIUS, strain), obstacles=(CONE,))


path = follow_rod([curled(fraction) for fraction in (0.0, 0.5, 0.8, 1.0)], elements=90)
for fraction, state in zip((0.0, 0.5, 0.8, 1.0), path.states, strict=True):
    share = state.contact_lengths[0] / LENGTH
    force = state.normal_forces.sum()
    print(f"{fraction:4.0%} curled: {share:4.0%} of the length touches, {force:.2f} N in all")

# A coil that squeezes a cone pushes it out, thick end first; friction takes up most of that.
grip = path.states[-1]
axial = float(grip.on_obstacle().force @ AXIS)
print(f"{axial:+.3f} N along the axis; certified stable: {grip.stable}; snaps: {len(path.events)}")
