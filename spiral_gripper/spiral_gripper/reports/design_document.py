# SPDX-License-Identifier: Apache-2.0
"""A design report as plain data for programs, and as a gripper description file for the node."""

from __future__ import annotations

import dataclasses
import math
from enum import Enum
from typing import Any

from spiral_core.actuator.actuator import Winding
from spiral_core.design.helix_estimate import GripFigures
from spiral_core.design.margin import Margin
from spiral_core.design.report import Design, DesignReport
from spiral_core.design.sweep import SweepPoint
from spiral_core.wrap.gripper import STANDARD_GRAVITY
from spiral_gripper.files.description_text import changed_text, description_fields, put_fields
from spiral_gripper.files.fields import law_name


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
            "law": law_name(type(design.elastomer.law)),
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

    Args:
        design: the gripper.
        name: of the gripper.
    """
    actuator, gripper, density = design.actuator, design.gripper, design.elastomer.density
    radii = (f"{1e3 * grip.radius:.4g} mm" for grip in (design.smallest, design.largest))
    fields = {
        "name": name,
        "description": f"designed for radii from {' to '.join(radii)}",
        **description_fields(actuator, gripper),
        "material.density": f"{density:.12g} kg/m^3",
        "model.pressure_law": actuator.pressure_law.value,
        "model.curvature_form": actuator.curvature_form.value,
    }
    extra = gripper.weight_per_length / STANDARD_GRAVITY - density * actuator.tube.wall_area
    if extra > 1e-12:
        fields["extra_mass_per_length"] = f"{extra!r} kg/m"
    root: dict[str, object] = {}
    put_fields(root, fields | {"name": name})
    return f"# Written by spiral-gripper design: {design.sentence}.\n{changed_text(root)}"


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
