# SPDX-License-Identifier: Apache-2.0
"""A design report as plain data for programs, and as a gripper description file for the node."""

from __future__ import annotations

import dataclasses
import json
import math
from enum import Enum
from typing import Any

from spiral_core.actuator.winding import Winding
from spiral_core.design.helix_estimate import GripFigures
from spiral_core.design.margin import Margin
from spiral_core.design.report import Design, DesignReport
from spiral_core.design.sweep import SweepPoint
from spiral_core.wrap.gripper import Gripper
from spiral_gripper.files.fields import LAWS
from spiral_gripper.files.units import Dimension, convert_from_si

# Twelve digits: rounding is far below manufacturing tolerances.
_DIGITS = 12


def plain(value: object) -> Any:  # noqa: ANN401
    """Return a value as plain data for JSON: dictionaries, lists, text, numbers, null for NaN, inf.

    Dataclasses become dictionaries of their fields, enumerations their names in lower case, arrays
    lists.

    Example:
        >>> from spiral_core.design.margin import Constraint
        >>> plain({"bound": math.inf, "by": Constraint.STRAIN, "at": (1, 2.5)})
        {'bound': None, 'by': 'strain', 'at': [1, 2.5]}
    """
    if isinstance(value, Enum):
        return value.name.lower()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if hasattr(value, "tolist"):  # numpy's arrays and scalars
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    raise TypeError(f"no plain form for {type(value).__name__}")


def design_as_dict(design: Design) -> dict[str, Any]:
    """Return every figure of a design, in SI."""
    fibers = design.actuator.fiber_pair
    return {
        "tube": plain(design.tube),
        "material": {
            "name": design.elastomer.name,
            "law": _law_name(design),
            **plain(design.elastomer.law),
            "density": design.elastomer.density,
            "pressure_law": design.elastomer.pressure_law.value,
        },
        "fiber_angle_alpha": fibers.alpha,
        "fiber_angle_beta": fibers.beta,
        "fiber_angle_gamma": design.fiber_angle,
        "length": design.length,
        "helix_length": design.helix_length,
        "cut_length": design.cut_length,
        "windings": [_winding(winding) for winding in design.windings],
        "pressure_max": design.gripper.pressure_max,
        "radius_min": design.radius_min,
        "radius_max": design.radius_max,
        "largest": _grip(design.largest),
        "smallest": _grip(design.smallest),
        "placements": plain(design.placements),
        "roll": design.roll,
        "curve": [_grip(point) for point in design.curve],
        "margins": [_margin(margin) for margin in design.margins],
    }


def report_as_dict(report: DesignReport) -> dict[str, Any]:
    """Return a whole report, in SI."""
    return {
        "feasible": report.feasible,
        "message": report.message,
        "binding": _margin(report.binding),
        "relaxations": plain(report.relaxations),
        "design": None if report.design is None else design_as_dict(report.design),
        "steps": plain(report.steps),
        "candidates": report.candidates,
        "tried": [
            {
                "candidate": evaluation.candidate.label,
                "feasible": evaluation.is_feasible,
                "binding": _margin(evaluation.binding),
            }
            for evaluation in report.tried
        ],
    }


def point_as_dict(point: SweepPoint) -> dict[str, Any]:
    """Return one candidate of a sweep, in SI."""
    return {
        "tube": plain(point.candidate.tube),
        "material": point.candidate.elastomer.name,
        "fiber_angle_beta": point.candidate.fiber_angle_beta,
        "fiber_angle_gamma": point.candidate.fiber_angle_gamma,
        "feasible": point.feasible,
        "pressure": point.pressure,
        "strain": point.strain,
        "length": point.length,
        "binding": _margin(point.binding),
    }


def description_text(design: Design, name: str) -> str:
    """Return a gripper description file for a design; ``docs/gripper_files.md`` has the format.

    Quantities are written in the units that people use, with so many digits that the file means
    this design.

    Args:
        design: the gripper.
        name: of the gripper.
    """
    actuator, gripper = design.actuator, design.gripper
    constants = "".join(
        f"  {constant}: "
        f"{value if constant == 'extension_limit' else _in('kPa', value, Dimension.PRESSURE)}\n"
        for constant, value in plain(actuator.material).items()
    )
    magnitude = math.hypot(*gripper.gravity)
    direction = [g / magnitude for g in gripper.gravity] if magnitude > 0.0 else [1.0, 0.0, 0.0]
    axis = "fitted" if gripper.object_axis is None else list(gripper.object_axis)
    extra = gripper.weight_per_length / 9.80665 - design.elastomer.density * actuator.tube.wall_area
    return (
        f"# Written by spiral-gripper design: {design.sentence}.\n"
        f"name: {json.dumps(name, ensure_ascii=False)}\n"  # in quotes: it may look like a number
        f"description: designed for radii from {1e3 * design.smallest.radius:.4g} mm to "
        f"{1e3 * design.largest.radius:.4g} mm\n"
        f"tube:\n"
        f"  inner_radius: {_in('mm', actuator.tube.inner_radius, Dimension.LENGTH)}\n"
        f"  wall_thickness: {_in('mm', actuator.tube.wall_thickness, Dimension.LENGTH)}\n"
        f"  length: {_in('mm', actuator.tube.length, Dimension.LENGTH)}\n"
        f"fibers:\n  alpha: {_in('deg', actuator.fiber_pair.alpha, Dimension.ANGLE)}\n"
        f"  beta: {_in('deg', actuator.fiber_pair.beta, Dimension.ANGLE)}\n"
        f"{_single_fiber(design)}"
        f"material:\n  law: {_law_name(design)}\n{constants}"
        f"  density: {_in('kg/m^3', design.elastomer.density, Dimension.DENSITY)}\n"
        f"model:\n  pressure_law: {actuator.pressure_law.value}\n"
        f"  curvature_form: {actuator.curvature_form.value}\n"
        f"mount:\n"
        f"  gravity_direction: {direction}\n"
        f"  gravity_magnitude: {_in('m/s^2', magnitude, Dimension.ACCELERATION)}\n"
        f"  object_axis: {axis}\n"
        f"limits:\n  pressure_max: {_in('kPa', gripper.pressure_max, Dimension.PRESSURE)}\n"
        f"grip:\n  turns_required: {gripper.turns_required!r}\n{_friction(gripper)}"
        + (f"extra_mass_per_length: {extra!r} kg/m\n" if extra > 1e-12 else "")
    )


def _friction(gripper: Gripper) -> str:
    """Return the line of the friction that a payload was judged with."""
    friction = gripper.friction_coefficient
    return "" if friction is None else f"  friction_coefficient: {friction!r}\n"


def _single_fiber(design: Design) -> str:
    """Return the line of a single fiber that is not straight."""
    if not design.fiber_angle:
        return ""
    return f"  single_angles: [{_in('deg', design.fiber_angle, Dimension.ANGLE)}]\n"


def _in(unit: str, value: float, dimension: Dimension) -> str:
    """Return an SI value as a description file writes it in a unit."""
    return f"{convert_from_si(value, unit, dimension):.{_DIGITS}g} {unit}"


def _law_name(design: Design) -> str:
    return next(name for name, law in LAWS.items() if isinstance(design.elastomer.law, law))


def _grip(grip: GripFigures) -> dict[str, Any]:
    return {**plain(grip), "strain": grip.strain}


def _margin(margin: Margin) -> dict[str, Any]:
    return {
        **plain(margin),
        "unit": margin.constraint.unit,
        "room": margin.room,
        "relative": margin.relative,
        "met": margin.is_met,
    }


def _winding(winding: Winding) -> dict[str, Any]:
    return {**plain(winding), "hand": winding.hand}
