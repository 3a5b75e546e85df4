# SPDX-License-Identifier: Apache-2.0
"""Gripper description files, read and checked: from YAML with units to a gripper of the core."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from spiral_core import (
    ActuationLimitError,
    Actuator,
    CurvatureForm,
    FiberAngles,
    Gripper,
    InvalidInputError,
    MeasuredActuation,
    OneFamily,
    PressureLaw,
    Section,
    SingleFiber,
    Tube,
    gripper_from_actuator,
    stiffness_from_actuator,
)
from spiral_core.brief import brief_repr
from spiral_core.message import Message, Quantity
from spiral_core.rounding import rounded_down
from spiral_core.validation import require_finite, require_non_negative, require_positive
from spiral_core.wrap.gripper import STANDARD_GRAVITY, stiffness_from_section
from spiral_gripper.files.catalog import find_description, read_description_text
from spiral_gripper.files.document import Document, read_document
from spiral_gripper.files.errors import DescriptionError, ProblemKind
from spiral_gripper.files.fields import (
    FIELDS,
    MEASURED,
    REQUIRED,
    Values,
    material_of,
    noted,
    read_values,
)
from spiral_gripper.files.plausibility import (
    THIN_WALL,
    doubts_of_material,
    doubts_of_pressure,
    doubts_of_size,
    placed,
)

# A thousand times the Earth's gravity [m/s^2]: far more than any arm's acceleration.
GRAVITY_MAX = 1.0e4
# What the core leaves open: a check, and the largest value in SI that anybody means. A longer or
# heavier tube, such as one of meters in place of millimeters, takes so many elements that there is
# neither time nor memory for them, in a node least of all.
_RANGES: Mapping[str, tuple[Callable[[str, object], float], float]] = {
    "tube.length": (require_finite, 10.0),
    "material.density": (require_positive, 1.0e5),
    "extra_mass_per_length": (require_non_negative, 1.0e3),
    "mount.gravity_magnitude": (require_non_negative, GRAVITY_MAX),
    "limits.pressure_max": (require_positive, math.inf),
}
# Names of a single fiber's angles in the core, and in files.
_SINGLE_FIBER_FIELDS = {
    "angle": ("single_angles", "angles from -80 to 80 deg"),
    "position": ("single_positions", "angles from -360 to 360 deg"),
}


@dataclass(frozen=True, slots=True)
class GripperDescription:
    """The content of a gripper description file, checked, in SI units.

    Attributes:
        source: the file it was read from.
        description: free text about the gripper.
        actuator: tube, fibers, material and the choices of model; where the file holds a measured
            curve, the material gives the stiffness only.
        density: density of the tube's material [kg/m^3].
        extra_mass_per_length: mass beside the tube's, such as fibers and glue [kg/m].
        gripper: the gripper that the file describes, ready for the core.
        written: text of the file's fields, by dotted name.
        values: their values in SI, by dotted name.
        warnings: values that are most likely mistakes; a line each, with its place in the file.
    """

    __repr__ = brief_repr

    source: Path
    description: str
    actuator: Actuator
    density: float
    extra_mass_per_length: float
    gripper: Gripper
    written: Mapping[str, str]
    values: Values
    warnings: tuple[str, ...] = ()


def load_gripper(name_or_path: str | os.PathLike[str]) -> Gripper:
    """Return the gripper that a description file describes.

    Args:
        name_or_path: the name of a shipped gripper, or the path of a file.

    Raises:
        DescriptionError: the file cannot be used; the error holds every problem with its place.

    Example:
        >>> gripper = load_gripper("prototype_p1")
        >>> gripper.tube.length, round(gripper.pressure_max)
        (0.5, 110316)
    """
    return load_description(name_or_path).gripper


def load_description(name_or_path: str | os.PathLike[str]) -> GripperDescription:
    """Return the content of a description file, checked.

    Args:
        name_or_path: the name of a shipped gripper, or the path of a file.

    Raises:
        DescriptionError: the file cannot be used; the error holds every problem with its place.

    Example:
        >>> description = load_description("prototype_p2")
        >>> description.source.name, round(description.density, 6)
        ('prototype_p2.yaml', 950.0)
    """
    path = find_description(name_or_path)
    return parse_description(read_description_text(path), path)


def parse_description(text: str, source: Path) -> GripperDescription:
    """Return the content of the text of a description file, checked.

    Args:
        text: the file's text.
        source: the file's path, for messages and as the description's source.

    Raises:
        DescriptionError: the text cannot be used; the error holds every problem with its place.
    """
    document = read_document(text, str(source), FIELDS, REQUIRED)
    measured = any(name in document.entries for name in MEASURED)
    values = read_values(document, REQUIRED | MEASURED if measured else REQUIRED)
    parts: Values = {}
    for part, make in _PARTS.items():
        with noted(document):
            parts[part] = make(values)
    for name in _RANGES:
        with noted(document):
            _check_range(name, values)
    document.raise_problems()
    try:
        with noted(document):
            return _description(values, parts, document, source)
    except ArithmeticError:
        reason = "its numbers are too large or too small to compute with; check the units"
        document.note(ProblemKind.UNREADABLE, "", None, reason)
    raise DescriptionError(document.problems)


def _check_range(name: str, values: Values) -> None:
    """Refuse a value that is negative, or larger than anybody means."""
    require, largest = _RANGES[name]
    dimension, argument = FIELDS[name].dimension, name.rpartition(".")[2]
    if name in values and dimension and require(argument, values[name]) > largest:
        most = Message("at most {}", Quantity(largest, dimension.si_unit, rounded_down))
        raise InvalidInputError(argument, values[name], most, dimension.si_unit)


def _description(
    values: Values, parts: Values, document: Document, source: Path
) -> GripperDescription:
    """Return the description, whose parts have been checked one by one."""
    actuator = _actuator(values, parts)
    density, pressure_max = values["material.density"], values["limits.pressure_max"]
    unlimited = _unlimited(values, actuator)
    actuation = unlimited.actuation
    thin = math.inf if actuator.thick_wall else THIN_WALL
    size = doubts_of_size(actuator.tube.inner_radius, actuator.tube.wall_thickness, thin)
    doubts = ((f"tube.{name}", doubt) for name, doubt in size)
    warnings = placed(document, (*doubts, *doubts_of_material(actuator.material, density)))
    if pressure_max > actuation.pressure_limit:
        requirement = Message(
            "at most {}, the actuator's own limit{}: {}",
            Quantity(actuation.pressure_limit, "Pa", rounded_down),
            "".join(f" ({warning})" for warning in warnings),
            actuation.limit.value,
        )
        raise InvalidInputError("pressure_max", pressure_max, requirement, "Pa")
    warnings += placed(document, doubts_of_pressure(actuator, pressure_max))
    return GripperDescription(
        source=source,
        description=values.get("description", ""),
        actuator=actuator,
        density=density,
        extra_mass_per_length=values.get("extra_mass_per_length", 0.0),
        gripper=replace(unlimited, pressure_max=pressure_max),
        written={name: entry.raw for name, entry in document.entries.items()},
        values=values,
        warnings=warnings,
    )


def _unlimited(values: Values, actuator: Actuator) -> Gripper:
    """Return the gripper with its actuation's own pressure limit."""
    magnitude = values.get("mount.gravity_magnitude", STANDARD_GRAVITY)
    x, y, z = values["mount.gravity_direction"]
    gripper = gripper_from_actuator(
        values["name"],
        actuator,
        density=values["material.density"],
        stiffness=stiffness_of(values, actuator),
        gravity=(magnitude * x, magnitude * y, magnitude * z),
        **_arguments(
            values, "extra_mass_per_length", "mount.object_axis", "grip.turns_required",
            "grip.friction_coefficient",
        ),
    )  # fmt: skip
    curve = _arguments(values, *MEASURED)
    if not curve:
        return gripper
    measured = MeasuredActuation(backbone_length=values["tube.length"], **curve)
    return replace(gripper, actuation=measured, pressure_max=measured.pressure_limit)


def vary_gripper(description: GripperDescription, field: str, value: float) -> Gripper:
    """Return the gripper that a description with another value of one field describes.

    Args:
        description: of the gripper.
        field: dotted name of a field with a number, as in the file; others follow from it as they
            do there: the stiffness from the tube's wall, unless the file states it.
        value: in SI units. Where the actuator's limit falls below the file's, the limit is that.

    Raises:
        InvalidInputError: the value is out of its range.

    Example:
        >>> thicker = vary_gripper(load_description("prototype_p1"), "tube.wall_thickness", 1e-3)
        >>> round(thicker.tube.outer_radius, 7)
        0.0057625
    """
    values = description.values | {field: value}
    actuator = _actuator(values, {part: make(values) for part, make in _PARTS.items()})
    gripper = _unlimited(values, actuator)
    limit = min(gripper.pressure_max, description.gripper.pressure_max)
    return replace(gripper, pressure_max=limit)


def _actuator(values: Values, parts: Values) -> Actuator:
    choices = _arguments(
        values, "fibers.straight_fiber_radius", "model.twist_shear", "model.thick_wall"
    )
    if "model.pressure_law" in values:
        choices["pressure_law"] = PressureLaw(values["model.pressure_law"])
    # The first-order form is that of two families and a straight fiber; others have the exact one.
    is_straight = tuple(fiber.angle for fiber in parts["single_fibers"]) in ((0.0,), ())
    as_the_paper = is_straight and values["fibers.beta"] is not None
    form = CurvatureForm.FIRST_ORDER if as_the_paper else CurvatureForm.EXACT
    form = CurvatureForm(values.get("model.curvature_form", form.value))
    return Actuator(curvature_form=form, **parts, **choices)


def stiffness_of(values: Values, actuator: Actuator) -> Section:
    """Return EI and GJ: as stated, of the section at a pressure, or of the annulus."""
    stated = _arguments(values, "stiffness.bending", "stiffness.torsional")
    if "stiffness.section_at" not in values:
        annulus = stiffness_from_actuator(actuator)
        both = {"bending": annulus.bending, "torsional": annulus.torsional} | stated
        return Section.inextensible(**both)
    pressure = values["stiffness.section_at"]
    if stated:
        requirement = "left out where bending or torsional is stated"
        raise InvalidInputError("section_at", pressure, requirement)
    if not 0.0 <= pressure <= values["limits.pressure_max"]:
        raise InvalidInputError("section_at", pressure, "from 0 to limits.pressure_max")
    try:
        return stiffness_from_section(actuator, pressure)
    except (InvalidInputError, ActuationLimitError) as error:
        requirement = Message("a pressure at which the section has a stiffness: {}", str(error))
        raise InvalidInputError("section_at", pressure, requirement) from None


def _single_fibers(values: Values) -> tuple[SingleFiber, ...]:
    """Return the single fibers: one straight one, unless the file lists others."""
    angles = values.get("fibers.single_angles", (0.0,))
    places = values.get("fibers.single_positions", (0.0,) * len(angles))
    if len(places) != len(angles):
        requirement = f"as many as single_angles, {len(angles)}"
        raise InvalidInputError("single_positions", len(places), requirement)
    try:
        return tuple(map(SingleFiber, angles, places))
    except InvalidInputError as error:
        field, allowed = _SINGLE_FIBER_FIELDS[error.field]
        raise InvalidInputError(field, error.value, allowed) from None


def _tube(values: Values) -> Tube:
    return Tube(**_arguments(values, "tube.inner_radius", "tube.wall_thickness", "tube.length"))


def _fibers(values: Values) -> FiberAngles | OneFamily:
    if values["fibers.beta"] is not None:
        return FiberAngles(**_arguments(values, "fibers.alpha", "fibers.beta"))
    alpha = values["fibers.alpha"]
    try:
        return OneFamily(alpha)
    except InvalidInputError as error:
        raise InvalidInputError("alpha", alpha, error.requirement, error.unit) from None


def _arguments(values: Values, *names: str) -> Values:
    """Return the values that the file gives for some fields, by the core's argument names."""
    return {name.rpartition(".")[2]: values[name] for name in names if name in values}


# Arguments of an actuator, and what makes each from a file's values.
_PARTS: Mapping[str, Callable[[Values], object]] = {
    "tube": _tube,
    "fibers": _fibers,
    "single_fibers": _single_fibers,
    "material": material_of,
}
