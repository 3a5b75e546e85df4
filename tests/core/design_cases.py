# SPDX-License-Identifier: Apache-2.0
"""The paper's design example as a requirement, with limits of our own where it states none."""

from __future__ import annotations

from spiral_core import DesignRequirement, Elastomer, MooneyRivlin, PressureLaw, TubeSize

PAPER_TUBE = TubeSize("3/8 in x 1/32 in", inner_radius=4.7625e-3, wall_thickness=0.79375e-3)
LATEX = Elastomer(
    "latex",
    MooneyRivlin(c1=130.0e3, c2=15.0e3),
    density=950.0,
    pressure_law=PressureLaw.UNIFORM,
)
PAPER_EXAMPLE = DesignRequirement(
    radius_min=11.0e-3,
    radius_max=30.0e-3,
    tubes=(PAPER_TUBE,),
    elastomers=(LATEX,),
    turns_required=1.5,
    object_length=0.25,
    pressure_max=110.316e3,
    strain_max=0.3,
)
# Bore diameter and wall in 1/32 in; the sizes of the shipped natural_latex.
SIZES = (
    (4, 1.0), (6, 1.0), (6, 1.5), (8, 1.0), (8, 1.5), (8, 2.0), (10, 1.0),
    (10, 1.5), (10, 2.0), (12, 1.0), (12, 1.5), (12, 2.0), (16, 1.0), (16, 2.0),
)  # fmt: skip
IN_32 = 25.4e-3 / 32.0
CATALOG = tuple(
    TubeSize(f"{bore}/32 x {wall:g}/32 in", 0.5 * bore * IN_32, wall * IN_32)
    for bore, wall in SIZES
)
