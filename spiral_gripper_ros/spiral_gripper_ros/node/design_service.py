# SPDX-License-Identifier: Apache-2.0
"""Packing and unpacking of `design_gripper`; :mod:`spiral_core.design.procedure` decides."""

from __future__ import annotations

from typing import Any

from spiral_core.design.report import Design, DesignReport
from spiral_core.errors import InvalidInputError
from spiral_core.rod.types import Vector
from spiral_gripper.reports.design_document import description_text
from spiral_gripper_msgs.msg import DesignChange, DesignMargin, DesignStep, Winding
from spiral_gripper_ros.messages.conversions import known, vector_from_msg
from spiral_gripper_ros.parameters.spec import GRAVITY_REQUIREMENT, gravity_problem
from spiral_gripper_ros.planning.design_question import DesignQuestion

# What the service calls the fields of the core's requirement.
FIELD_NAMES = {"radius_min": "object_radius_min", "radius_max": "object_radius_max"}
# How a design is called in the description that goes with it.
DESIGN_NAME = "designed"


def question_from_msg(request: Any, gravity: Vector) -> DesignQuestion:  # noqa: ANN401
    """Return what a request says.

    Args:
        request: the ``DesignGripper`` request.
        gravity: the node's present gravity [m/s^2]; used if the request names none.

    Raises:
        InvalidInputError: a figure is 0, or the gravity is not one that the node would follow.
    """
    axis = vector_from_msg(request.object_axis[0]) if request.object_axis else None
    if request.gravity:
        gravity = vector_from_msg(request.gravity[0])
        if gravity_problem(gravity) is not None:
            raise InvalidInputError("gravity", gravity, GRAVITY_REQUIREMENT)
    return DesignQuestion(
        object_radius_min=request.object_radius_min,
        object_radius_max=request.object_radius_max,
        object_length=_given(request, "object_length"),
        length_max=_given(request, "length_max"),
        pressure_max=_given(request, "pressure_max"),
        strain_max=_given(request, "strain_max"),
        turns_required=_given(request, "turns_required"),
        tubing=request.tubing,
        tube_inner_radii=tuple(request.tube_inner_radii),
        tube_wall_thicknesses=tuple(request.tube_wall_thicknesses),
        fiber_angles_beta=tuple(request.fiber_angles_beta),
        fiber_angle_alpha=_given(request, "fiber_angle_alpha"),
        fiber_angles_gamma=tuple(request.fiber_angles_gamma),
        end_allowance=_given(request, "end_allowance"),
        gravity=gravity,
        object_axis=axis,
        preference=request.preference,
    )


def _given(request: Any, name: str) -> float:  # noqa: ANN401
    """Return a positive number of the request, or the 0 of the question for one not given."""
    value = known(getattr(request, name))
    if value == 0.0:
        raise InvalidInputError(name, value, "positive where it is given")
    return value or 0.0


def fill_response(response: Any, report: DesignReport) -> Any:  # noqa: ANN401
    """Write a report into a ``DesignGripper`` response; what does not exist stays 0."""
    response.success, response.message = report.feasible, report.message
    response.binding_constraint = report.binding.constraint.value
    response.binding_value, response.binding_limit = report.binding.value, report.binding.bound
    response.changes = [
        DesignChange(
            field=FIELD_NAMES.get(change.field, change.field),
            requested=change.requested,
            sufficient=change.sufficient,
            design=change.design,
        )
        for change in report.relaxations
    ]
    response.candidates, response.candidates_solved = report.candidates, len(report.tried)
    response.steps = [
        DesignStep(
            number=step.number,
            title=step.title,
            satisfied=step.satisfied,
            remark=step.remark,
            names=[figure.name for figure in step.figures],
            values=[figure.value for figure in step.figures],
            units=[figure.unit for figure in step.figures],
        )
        for step in report.steps
    ]
    if report.design is not None:
        _fill_design(response, report.design)
        if report.feasible:
            response.description = description_text(report.design, DESIGN_NAME)
    return response


def _fill_design(response: Any, design: Design) -> None:  # noqa: ANN401
    fibers, largest, smallest = design.actuator.fiber_pair, design.largest, design.smallest
    response.design_known = True
    response.tube, response.material = design.tube.name, design.elastomer.name
    response.tube_inner_radius = design.tube.inner_radius
    response.tube_wall_thickness = design.tube.wall_thickness
    response.fiber_angle_alpha, response.fiber_angle_beta = fibers.alpha, fibers.beta
    response.fiber_angle_gamma = design.actuator.single_fibers[0].angle
    response.length, response.length_helix = design.length, design.helix_length
    response.cut_length = design.cut_length
    response.windings = [
        Winding(angle=w.angle, pitch=w.pitch, turns=w.turns, fiber_length=w.fiber_length)
        for w in design.windings
    ]
    response.pressure_max = design.gripper.pressure_max
    response.radius_min, response.radius_max = design.radius_min, design.radius_max
    response.strain_at_radius_max = largest.strain
    response.strain_at_radius_min = smallest.strain
    response.pressure_at_radius_max = largest.pressure
    response.pressure_at_radius_min = smallest.pressure
    response.turns_at_radius_max, response.turns_at_radius_min = largest.turns, smallest.turns
    response.object_length_at_radius_max = largest.object_length
    response.object_length_at_radius_min = smallest.object_length
    response.chart_radius = [point.radius for point in design.curve]
    response.chart_pressure = [point.pressure for point in design.curve]
    response.margins = [
        DesignMargin(
            constraint=margin.constraint.value,
            value=margin.value,
            bound=margin.bound,
            room=margin.room,
            relative=margin.relative,
            unit=margin.constraint.unit,
            met=margin.is_met,
        )
        for margin in design.margins
    ]
