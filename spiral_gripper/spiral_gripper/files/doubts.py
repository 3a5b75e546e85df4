# SPDX-License-Identifier: Apache-2.0
"""Values that are possible but most likely not meant: another unit, another decimal place."""

from __future__ import annotations

from collections.abc import Iterator

from spiral_core import Actuator
from spiral_gripper.files.document import Document

# Bores from a hypodermic tube's to a fire hose's [m].
BORES = (1.0e-4, 0.1)
# Young's moduli from the softest silicone's to hard polyurethane's [Pa].
MODULI = (1.0e4, 2.0e7)
# Densities from a foam's to a filled rubber's [kg/m^3].
DENSITIES = (100.0, 4000.0)
# Ratio of wall to bore radius up to which the model's one strain for the whole wall will do.
THIN_WALL = 0.25
THICK_WALL = 2.0


def doubts_of(document: Document, actuator: Actuator, density: float) -> tuple[str, ...]:
    """Return a line for each value that is most likely not meant, with its place in the file.

    Args:
        document: the file's entries.
        actuator: what they describe.
        density: of the elastomer [kg/m^3].
    """
    found = []
    for name, doubt in _doubts(actuator, density):
        entry = document.entries.get(name)
        place = entry or document.sections[name]
        value = "" if entry is None else f" {entry.raw}"
        found.append(f"{document.file}:{place.line}:{place.column}: {name}{value} {doubt}")
    return tuple(found)


def _doubts(actuator: Actuator, density: float) -> Iterator[tuple[str, str]]:
    """Yield the fields in doubt, and why."""
    tube, modulus = actuator.tube, actuator.material.small_strain_modulus
    if not BORES[0] <= tube.inner_radius <= BORES[1]:
        yield "tube.inner_radius", "is not between 0.1 mm and 100 mm; check its unit"
    ratio = tube.wall_thickness / tube.inner_radius
    if ratio > THICK_WALL:
        yield "tube.wall_thickness", f"is {ratio:.3g} times the bore radius; check both units"
    elif ratio > THIN_WALL:
        thin = f"the model takes one strain for the whole wall, which holds up to {THIN_WALL:g}"
        yield "tube.wall_thickness", f"is {ratio:.2g} of the bore radius: {thin}; calibrate it"
    if not MODULI[0] <= modulus <= MODULI[1]:
        found = f"has a Young's modulus of {modulus * 1e-6:.3g} MPa; elastomers have 0.01 to 20 MPa"
        yield "material", f"{found}; check the units of its constants"
    if not DENSITIES[0] <= density <= DENSITIES[1]:
        yield "material.density", "is not between 100 and 4000 kg/m^3; check its unit"
