# SPDX-License-Identifier: Apache-2.0
"""The paper's design example as a requirement, with limits of our own where it states none."""

from dataclasses import replace
from math import radians

from spiral_core import (
    DesignRequirement,
    Elastomer,
    MooneyRivlin,
    PressureLaw,
    TubeSize,
    design_gripper,
)

PAPER_TUBE = TubeSize("3/8 in x 1/32 in", inner_radius=4.7625e-3, wall_thickness=0.79375e-3)
LATEX = Elastomer(
    "latex", MooneyRivlin(130.0e3, 15.0e3), density=950.0, pressure_law=PressureLaw.UNIFORM
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
WEIGHTLESS = {"gravity": (0.0, 0.0, 0.0), "object_length": None, "pressure_max": None}
# Bore diameter and wall in 1/32 in; sizes of the shipped natural_latex.
IN_32 = 25.4e-3 / 32.0
CATALOG = tuple(
    TubeSize(f"{bore}/32 x {wall:g}/32 in", 0.5 * bore * IN_32, wall * IN_32)
    for bore in (4, 6, 8, 10, 12, 16)
    for wall in (1.0, 1.5, 2.0)
)


def angles(*degrees):
    return tuple(radians(angle) for angle in degrees)


def answered(requirement=PAPER_EXAMPLE, **changes):
    """Return the report by the tip criterion, as in the paper."""
    return design_gripper(replace(requirement, **changes), contact=False)


def designed(*wanted, **changes):
    """Return the design of a feasible requirement."""
    report = answered(*wanted, **changes)
    assert report.feasible, report.message
    return report.design
