# SPDX-License-Identifier: Apache-2.0
"""Packing and unpacking of `design_gripper`; :mod:`spiral_core.design.procedure` decides."""

from __future__ import annotations

import math
from typing import Any

from spiral_core.design.report import Design, DesignReport
from spiral_core.design.requirement import (
    DEFAULT_BETAS,
    DesignRequirement,
    Elastomer,
    Preference,
    TubeSize,
)
from spiral_core.errors import InvalidInputError
from spiral_core.rod.types import Vector
from spiral_core.validation import require_direction
from spiral_gripper import GripperDescription, available_tubing, load_tubing
from spiral_gripper.reports.design_document import description_text
from spiral_gripper_msgs.msg import DesignChange, DesignMargin, DesignStep, Winding
from spiral_gripper_ros.messages.conversions import (
    OPTIONAL_NUMBER,
    filled,
    known,
    vector_from_msg,
)
from spiral_gripper_ros.parameters.spec import GRAVITY_REQUIREMENT, gravity_problem

# Each is estimated, and the promising ones are solved as rods, at some tens of milliseconds each.
MOST_COMBINATIONS = 2000
# What the service calls the fields of the core's requirement.
FIELD_NAMES = {"radius_min": "object_radius_min", "radius_max": "object_radius_max"}
# How a design is called in the description that goes with it.
DESIGN_NAME = "designed"
_FIGURE = ("name", "value", "unit")


def requirement_from_msg(
    request: Any,  # noqa: ANN401
    gravity: Vector,
    description: GripperDescription,
) -> DesignRequirement:
    """Return the requirement that a request states; what it leaves open is that of the gripper.

    Args:
        request: the ``DesignGripper`` request.
        gravity: the node's present gravity [m/s^2]; used if the request names none.
        description: of the node's gripper.

    Raises:
        InvalidInputError: a value is out of its range, or the gravity is not one that the node
            would follow.
    """
    gripper, actuator = description.gripper, description.actuator
    for given in request.gravity:  # of at most one
        gravity = vector_from_msg(given)
        if gravity_problem(gravity) is not None:
            raise InvalidInputError("gravity", gravity, GRAVITY_REQUIREMENT)
    tubes, elastomer = _on_offer(request, description)
    angles = tuple(request.fiber_angles_beta) or DEFAULT_BETAS
    single_angles = tuple(request.fiber_angles_gamma) or (0.0,)
    counts = tuple(map(len, (tubes, angles, single_angles)))
    if math.prod(counts) > MOST_COMBINATIONS:
        product, most = " x ".join(map(str, counts)), f"at most {MOST_COMBINATIONS}"
        raise InvalidInputError("combinations of tube and angles", product, most)
    axis = gripper.object_axis
    for given in request.object_axis:
        axis = require_direction("object_axis", vector_from_msg(given))
    preferences = {preference.name.lower(): preference for preference in Preference}
    preference = request.preference or Preference.LEAST_STRAIN.name.lower()
    if preference not in preferences:
        raise InvalidInputError("preference", preference, f"one of {', '.join(preferences)}")
    values: dict[str, Any] = {
        "fiber_angle_alpha": actuator.fiber_pair.alpha,
        "turns_required": gripper.turns_required,
        "pressure_max": gripper.pressure_max,
    }
    return DesignRequirement(
        radius_min=request.object_radius_min,
        radius_max=request.object_radius_max,
        tubes=tubes,
        elastomers=(elastomer,),
        fiber_angles_beta=angles,
        fiber_angles_gamma=single_angles,
        gravity=gravity,
        object_axis=axis,
        curvature_form=actuator.curvature_form,
        extra_mass_per_length=description.extra_mass_per_length,
        preference=preferences[preference],
        **(values | _given(request)),
    )


def _given(request: Any) -> dict[str, float]:  # noqa: ANN401
    """Return the optional numbers of a request that it states; a 0 is none."""
    values: dict[str, float] = {}
    for name, kind in request.get_fields_and_field_types().items():
        value = known(getattr(request, name)) if kind == OPTIONAL_NUMBER else None
        if value == 0.0:
            raise InvalidInputError(name, value, "positive where it is given")
        if value is not None:
            values[name] = value
    return values


def _on_offer(
    request: Any,  # noqa: ANN401
    description: GripperDescription,
) -> tuple[tuple[TubeSize, ...], Elastomer]:
    """Return the tubes on offer and their material."""
    radii, walls = tuple(request.tube_inner_radii), tuple(request.tube_wall_thicknesses)
    if len(radii) != len(walls):
        requirement = f"as many as tube_inner_radii, {len(radii)}"
        raise InvalidInputError("tube_wall_thicknesses", walls, requirement)
    if request.tubing and radii:
        raise InvalidInputError("tubing", request.tubing, "empty where tube_inner_radii are given")
    if request.tubing:
        if request.tubing not in available_tubing():  # a path could be a pipe
            names = ", ".join(available_tubing())
            raise InvalidInputError("tubing", request.tubing, f"a shipped list: {names}")
        tubing = load_tubing(request.tubing)
        return tubing.sizes, tubing.elastomer
    own, name = description.actuator, description.gripper.name
    elastomer = Elastomer(name, own.material, description.density, own.pressure_law)
    sizes = list(zip(radii, walls, strict=True))
    sizes = sizes or [(own.tube.inner_radius, own.tube.wall_thickness)]
    return tuple(TubeSize(f"{2e3 * r:.4g} x {1e3 * t:.4g} mm", r, t) for r, t in sizes), elastomer


def fill_response(response: Any, report: DesignReport) -> Any:  # noqa: ANN401
    """Write a report into a ``DesignGripper`` response; what does not exist stays 0."""
    design, values = report.design, {}
    if design is not None:
        values = _figures(design)
        if report.feasible:
            values["description"] = description_text(design, DESIGN_NAME)
    return filled(
        response,
        report,
        design,
        success=report.feasible,
        binding_constraint=report.binding.constraint.value,
        binding_value=report.binding.value,
        binding_limit=report.binding.bound,
        changes=[
            filled(DesignChange(), change, field=FIELD_NAMES.get(change.field, change.field))
            for change in report.relaxations
        ],
        candidates_solved=len(report.tried),
        steps=[
            filled(
                DesignStep(),
                step,
                **{f"{part}s": [getattr(f, part) for f in step.figures] for part in _FIGURE},
            )
            for step in report.steps
        ],
        **values,
    )


def _figures(design: Design) -> dict[str, Any]:
    """Return what a response says of a design by other names than the design itself."""
    fibers = design.actuator.fiber_pair
    ends = {
        f"{name}_at_radius_{end}": getattr(grip, name)
        for end, grip in (("max", design.largest), ("min", design.smallest))
        for name in ("strain", "pressure", "turns", "object_length")
    }
    return ends | {
        "design_known": True,
        "tube": design.tube.name,
        "material": design.elastomer.name,
        "tube_inner_radius": design.tube.inner_radius,
        "tube_wall_thickness": design.tube.wall_thickness,
        "fiber_angle_alpha": fibers.alpha,
        "fiber_angle_beta": fibers.beta,
        "fiber_angle_gamma": design.actuator.single_fibers[0].angle,
        "length_helix": design.helix_length,
        "windings": [filled(Winding(), winding) for winding in design.windings],
        "pressure_max": design.gripper.pressure_max,
        "chart_radius": [point.radius for point in design.curve],
        "chart_pressure": [point.pressure for point in design.curve],
        "margins": [
            filled(DesignMargin(), m, constraint=kind.value, unit=kind.unit, met=m.is_met)
            for m in design.margins
            for kind in (m.constraint,)
        ],
    }
