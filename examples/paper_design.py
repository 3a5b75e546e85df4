# SPDX-License-Identifier: Apache-2.0
"""The paper's design example: a gripper for a tube light (11 mm) and a PVC pipe (30 mm).

The paper goes from these two radii to fiber angles of 88 and 70 degrees and a helix length of
361 mm. It uses 3/8 in x 1/32 in latex tubing (our reading of its part number). Its limits and
its number of turns are not known to us; those below are ours:

* 1.5 turns about the pipe: with them the helix length comes within 1 % of the paper's;
* 250 mm of object to hold: between 201 and 262 mm the procedure chooses 70 degrees, as the paper
  does; longer objects allow 60 degrees, which strains the tube less, shorter ones need 80 degrees;
* 16 psi, the highest pressure at which the paper shows shapes, and 30 % strain.
"""

from __future__ import annotations

import math

from spiral_core import DesignRequirement, design_gripper
from spiral_gripper import load_tubing, parse_tube_size

requirement = DesignRequirement(
    radius_min=11.0e-3,
    radius_max=30.0e-3,
    tubes=(parse_tube_size("3/8 in x 1/32 in"),),
    elastomers=(load_tubing("natural_latex").elastomer,),
    turns_required=1.5,
    object_length=0.25,
    pressure_max=110.316e3,
    strain_max=0.3,
)
report = design_gripper(requirement, contact=False)  # the paper's seven steps

for step in report.steps:
    print(f"{step.number} {step.title}: {step.remark}")

design = report.design
if design is None:
    raise SystemExit(report.message)
beta = math.degrees(design.actuator.fiber_pair.beta)
print(f"beta {beta:.0f} deg (the paper: 70), helix length {1e3 * design.helix_length:.1f} mm (361)")
print(f"length under gravity {1e3 * design.length:.1f} mm, cut {1e3 * design.cut_length:.1f} mm")
for winding in design.windings:
    print(
        f"wind at {math.degrees(winding.angle):.0f} deg: pitch {1e3 * winding.pitch:.2f} mm, "
        f"{winding.turns:.1f} turns, {winding.hand}-handed"
    )
for grip in (design.largest, design.smallest):
    print(f"object of {1e3 * grip.radius:.0f} mm: {1e-3 * grip.pressure:.1f} kPa")
