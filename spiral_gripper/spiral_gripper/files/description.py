# SPDX-License-Identifier: Apache-2.0
"""Gripper description files, read and checked: from YAML with units to a gripper of the core."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

from spiral_core import (
    ActuationModel,
    Actuator,
    CurvatureForm,
    FiberAngles,
    Gripper,
    HyperelasticLaw,
    InvalidInputError,
    MeasuredActuation,
    OneFamily,
    PressureLaw,
    SingleFiber,
    Tube,
    gripper_from_actuator,
)
from spiral_core.brief import brief_repr
from spiral_core.validation import require_non_negative, require_positive
from spiral_core.wrap.gripper import STANDARD_GRAVITY
from spiral_gripper.files.catalog import find_description, read_description_text
from spiral_gripper.files.document import Document, read_document
from spiral_gripper.files.errors import DescriptionError, ProblemKind
from spiral_gripper.files.fields import FIELDS, LAWS, REQUIRED, Vector, constants_of
from spiral_gripper.files.plausibility import warnings_of_description, warnings_of_pressure
from spiral_gripper.files.stiffness import rod_stiffness
from spiral_gripper.files.units import Dimension, convert_from_si, unit_of
from spiral_gripper.files.values import Values, note_argument, read_values

# A thousand times the Earth's gravity [m/s^2]: far more than any arm's acceleration.
GRAVITY_MAX = 1.0e4
# More than anybody means. A longer or heavier tube, such as one of meters in place of millimeters,
# takes so many elements that there is neither time nor memory for them, in a node least of all.
_LARGEST = {
    "length": (10.0, "m"),
    "density": (1.0e5, "kg/m^3"),
    "extra_mass_per_length": (1.0e3, "kg/m"),
    "gravity_magnitude": (GRAVITY_MAX, "m/s^2"),
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
    values = read_values(document)
    _check_parts(values, document)
    try:
        return _description(values, document, source)
    except InvalidInputError as error:
        note_argument(document, error)
    except ArithmeticError:
        reason = "its numbers are too large or too small to compute with; check the units"
        document.note(ProblemKind.UNREADABLE, "", None, reason)
    raise DescriptionError(document.problems)


def _check_parts(values: Values, document: Document) -> None:
    """Make each part once, so that all values that the core refuses are reported together."""
    for make in (
        _tube,
        _fibers,
        _single_fibers,
        _material,
        _density,
        _extra_mass,
        _gravity,
        _pressure_max,
    ):
        _check_part(make, values, document)
    document.raise_problems()


def _check_part(make: Callable[[Values], object], values: Values, document: Document) -> None:
    """Make one part, and note the value that the core refuses."""
    try:
        make(values)
    except InvalidInputError as error:
        note_argument(document, error)


def _description(values: Values, document: Document, source: Path) -> GripperDescription:
    """Return the description, whose parts have been checked one by one."""
    actuator = _actuator(values)
    density, extra_mass_per_length = _density(values), _extra_mass(values)
    unlimited = gripper_from_actuator(
        str(values["name"]),
        actuator,
        density=density,
        extra_mass_per_length=extra_mass_per_length,
        stiffness=rod_stiffness(values, actuator),
        gravity=_gravity(values),
        **_arguments(
            values, "mount.object_axis", "grip.turns_required", "grip.friction_coefficient"
        ),
    )
    actuation = _measured_actuation(values) or unlimited.actuation
    pressure_max = _pressure_max(values)
    warnings = warnings_of_description(document, actuator, density)
    _check_pressure(pressure_max, actuation, document, warnings)
    warnings += warnings_of_pressure(document, actuator, pressure_max)
    return GripperDescription(
        source=source,
        description=str(values.get("description", "")),
        actuator=actuator,
        density=density,
        extra_mass_per_length=extra_mass_per_length,
        gripper=replace(unlimited, actuation=actuation, pressure_max=pressure_max),
        written={name: entry.raw for name, entry in document.entries.items()},
        warnings=warnings,
    )


def _check_pressure(
    pressure_max: float, actuation: ActuationModel, document: Document, warnings: tuple[str, ...]
) -> None:
    """Refuse a pressure past the actuator's own limit, in the unit of the file, with warnings."""
    if pressure_max <= actuation.pressure_limit:
        return
    entry = document.entries["limits.pressure_max"]
    unit = unit_of(entry.text, Dimension.PRESSURE)
    limit = convert_from_si(actuation.pressure_limit, unit, Dimension.PRESSURE)
    requirement = (
        f"at most {_rounded_down(limit)} {unit}, the actuator's own limit"
        f"{''.join(f' ({warning})' for warning in warnings)}: {actuation.limit.value}"
    )
    document.note(ProblemKind.WRONG, "limits.pressure_max", entry, requirement, entry.raw)
    document.raise_problems()


def _rounded_down(value: float) -> str:
    """Return a positive number with four digits, never more than the number itself."""
    text = f"{value:.4g}"
    return text if float(text) <= value else f"{value * (1.0 - 5e-4):.4g}"


def _actuator(values: Values) -> Actuator:
    choices = _arguments(
        values, "fibers.straight_fiber_radius", "model.twist_shear", "model.thick_wall"
    )
    if "model.pressure_law" in values:
        choices["pressure_law"] = PressureLaw(values["model.pressure_law"])
    singles = _single_fibers(values)
    # The first-order form is that of two families and a straight fiber; others have the exact one.
    is_straight = tuple(fiber.angle for fiber in singles) in ((0.0,), ())
    as_the_paper = is_straight and values["fibers.beta"] is not None
    form = CurvatureForm.FIRST_ORDER if as_the_paper else CurvatureForm.EXACT
    return Actuator(
        tube=_tube(values),
        fibers=_fibers(values),
        material=_material(values),
        curvature_form=CurvatureForm(values.get("model.curvature_form", form.value)),
        single_fibers=singles,
        **choices,
    )


def _single_fibers(values: Values) -> tuple[SingleFiber, ...]:
    """Return the single fibers: one straight one, unless the file lists others."""
    angles = cast("tuple[float, ...]", values.get("fibers.single_angles", (0.0,)))
    places = cast("tuple[float, ...]", values.get("fibers.single_positions", (0.0,) * len(angles)))
    if len(places) != len(angles):
        raise InvalidInputError(
            "single_positions", len(places), f"as many as single_angles, {len(angles)}"
        )
    try:
        return tuple(SingleFiber(*pair) for pair in zip(angles, places, strict=True))
    except InvalidInputError as error:
        field, allowed = _SINGLE_FIBER_FIELDS[error.field]
        raise InvalidInputError(field, error.value, allowed) from None


def _tube(values: Values) -> Tube:
    tube = Tube(**_arguments(values, "tube.inner_radius", "tube.wall_thickness", "tube.length"))
    _bounded("length", tube.length)
    return tube


def _fibers(values: Values) -> FiberAngles | OneFamily:
    if values["fibers.beta"] is not None:
        return FiberAngles(**_arguments(values, "fibers.alpha", "fibers.beta"))
    alpha = cast("float", values["fibers.alpha"])
    try:
        return OneFamily(alpha)
    except InvalidInputError as error:
        raise InvalidInputError("alpha", alpha, error.requirement) from None


def _material(values: Values) -> HyperelasticLaw:
    law = str(values["material.law"])
    constants = _arguments(values, *(f"material.{name}" for name in constants_of(law)))
    material: HyperelasticLaw = LAWS[law](**constants)
    return material


def _measured_actuation(values: Values) -> MeasuredActuation | None:
    """Return the measured curve that a file may hold in place of the law's."""
    if "measured.pressures" not in values:
        return None
    length = cast("float", values["tube.length"])
    return MeasuredActuation(
        backbone_length=length,
        **_arguments(values, "measured.pressures", "measured.curvatures", "measured.torsions"),
    )


def _density(values: Values) -> float:
    return _bounded("density", require_positive("density", values["material.density"]))


def _extra_mass(values: Values) -> float:
    extra = values.get("extra_mass_per_length", 0.0)
    return _bounded("extra_mass_per_length", require_non_negative("extra_mass_per_length", extra))


def _gravity(values: Values) -> Vector:
    """Return the acceleration of gravity in the base frame [m/s^2]."""
    given = values.get("mount.gravity_magnitude", STANDARD_GRAVITY)
    magnitude = _bounded("gravity_magnitude", require_non_negative("gravity_magnitude", given))
    x, y, z = cast("Vector", values["mount.gravity_direction"])
    return (magnitude * x, magnitude * y, magnitude * z)


def _bounded(argument: str, value: float) -> float:
    """Return a value; refuse one above the largest plausible value."""
    largest, unit = _LARGEST[argument]
    if value > largest:
        raise InvalidInputError(argument, value, f"at most {largest:g} {unit}")
    return value


def _pressure_max(values: Values) -> float:
    return require_positive("pressure_max", values["limits.pressure_max"])


def _arguments(values: Values, *names: str) -> dict[str, Any]:
    """Return the values that the file gives for some fields, by the core's argument names."""
    return {name.rpartition(".")[2]: values[name] for name in names if name in values}
