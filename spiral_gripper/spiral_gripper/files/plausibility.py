# SPDX-License-Identifier: Apache-2.0
"""Values that are possible but most likely mistakes: a wrong unit or decimal place."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from spiral_core import Actuator, HyperelasticLaw
from spiral_core.design.requirement import TubeSize
from spiral_gripper.files.document import Document

# Bores from a hypodermic tube's to a fire hose's [m].
BORES = (1.0e-4, 0.1)
# Young's moduli from the softest silicone's to hard polyurethane's [Pa].
MODULI = (1.0e4, 2.0e7)
# Densities from a foam's to a filled rubber's [kg/m^3].
DENSITIES = (100.0, 4000.0)
# Ratio of wall to bore radius up to which one strain for the whole wall is accurate enough.
THIN_WALL = 0.25
THICK_WALL = 2.0
# Hoop stress of the wall without fibers, in Young's moduli: the shipped grippers stay below 1.
HOOP_STRAIN = 5.0


def doubts_of_pressure(actuator: Actuator, pressure_max: float) -> Iterator[tuple[str, str]]:
    """Yield the pressure limit [Pa], if it is far beyond what such a tube is used with, and why."""
    tube = actuator.tube
    stress = pressure_max * tube.inner_radius / tube.wall_thickness
    times = stress / actuator.material.small_strain_modulus
    if times > HOOP_STRAIN:
        warning = f"stresses the wall alone with {times:.2g} times its Young's modulus"
        yield "limits.pressure_max", f"{warning}; check its unit"


def warnings_of_size(size: TubeSize, thin_wall: float = math.inf) -> tuple[str, ...]:
    """Return a sentence for each of a tube's dimensions that is most likely a mistake.

    Args:
        size: of the tube.
        thin_wall: ratio of wall to bore radius above which a wall counts as thick; a list may well
            offer such tubes, but a warning about the chosen one begins at :data:`THIN_WALL`.
    """
    found = doubts_of_size(size.inner_radius, size.wall_thickness, thin_wall)
    return tuple(f"{name} of {size.name} {warning}" for name, warning in found)


def placed(document: Document, doubts: Iterable[tuple[str, str]]) -> tuple[str, ...]:
    """Return doubts about fields as lines with their place and what is written there."""
    found = []
    for name, doubt in doubts:
        entry = document.entries.get(name)
        place, value = (entry, f" {entry.raw}") if entry else (document.sections[name], "")
        found.append(f"{document.file}:{place.line}:{place.column}: {name}{value} {doubt}")
    return tuple(found)


def doubts_of_size(
    inner_radius: float, wall_thickness: float, thin_wall: float = THIN_WALL
) -> Iterator[tuple[str, str]]:
    """Yield the implausible ones of a tube's dimensions [m], and why."""
    if not BORES[0] <= inner_radius <= BORES[1]:
        yield "inner_radius", "is not between 0.1 mm and 100 mm; check its unit"
    ratio = wall_thickness / inner_radius
    if ratio > THICK_WALL:
        yield "wall_thickness", f"is {ratio:.3g} times the bore radius; check both units"
    elif ratio > thin_wall:
        thin = f"the model takes one strain for the whole wall, which holds up to {THIN_WALL:g}"
        advice = "calibrate it, or set model.thick_wall to true, with pressure_law section"
        yield "wall_thickness", f"is {ratio:.2g} of the bore radius: {thin}; {advice}"


def doubts_of_material(law: HyperelasticLaw, density: float) -> Iterator[tuple[str, str]]:
    """Yield the implausible properties of a material, and why."""
    modulus = law.small_strain_modulus
    if not MODULI[0] <= modulus <= MODULI[1]:
        found = f"has a Young's modulus of {modulus * 1e-6:.3g} MPa; elastomers have 0.01 to 20 MPa"
        yield "material", f"{found}; check the units of its constants"
    if not DENSITIES[0] <= density <= DENSITIES[1]:
        yield "material.density", "is not between 100 and 4000 kg/m^3; check its unit"
