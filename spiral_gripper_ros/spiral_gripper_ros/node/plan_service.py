# SPDX-License-Identifier: Apache-2.0
"""The answers of `plan_wrap` and `plan_wraps`."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from geometry_msgs.msg import Point

from spiral_core.errors import SpiralError
from spiral_core.validation import (
    require_direction,
    require_in_range,
    require_non_negative,
)
from spiral_core.wrap.gripper import FRICTION_MAX, Gripper
from spiral_gripper_msgs.srv import PlanWrap
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.radius_gate import impossible_radius
from spiral_gripper_ros.control.states import Reason, Refusal, refusal_from_error
from spiral_gripper_ros.control.target import beyond_loss, default_overpressure
from spiral_gripper_ros.messages.conversions import backbone_to_msg, vector_from_msg, vector_to_msg
from spiral_gripper_ros.messages.grip import grip_to_msg
from spiral_gripper_ros.parameters.spec import gravity_problem
from spiral_gripper_ros.planning.grip_figures import GripQuestion
from spiral_gripper_ros.planning.grip_table import GripAnswer, GripEntry
from spiral_gripper_ros.planning.object_pose import object_line
from spiral_gripper_ros.planning.planner import AnyPlanner, NoPlanner, WrapPlan, planner_for

# The fields of `plan_wrap` that `plan_wraps` lists.
_LISTED = (
    "success",
    "reason",
    "message",
    "pressure",
    "turns",
    "contact_length",
    "line_force",
    "grip",
)
UNLOADED = "the gripper was unloaded or exchanged before all objects were planned for"
# Planners for other mounts, by gravity and axis: some tens of milliseconds each.
_Planners: TypeAlias = dict[tuple[float, ...], AnyPlanner]


@dataclass(frozen=True, slots=True)
class PlanContext:
    """The data from which a `plan_wrap` request is answered.

    Args:
        planner: for the present mount; used if the request names no other.
        gripper: the gripper.
        limits: of the commands; their cap and the pressure of a grip, unless the request says.
        points: largest number of poses of the shape.
        header: stamp and frame of the shape.
        is_wanted: tells whether a long answer is still awaited.
        table_grip: returns the grip on a radius [m] that is wrapped at a pressure [Pa] by the tip
            criterion, at another pressure [Pa], if it is known; for the present mount.
        solve_grip: returns the grip on one object, in seconds, unless it is no longer awaited.
        now: time that the age of grips is counted to [s].
    """

    planner: AnyPlanner
    gripper: Gripper
    limits: Limits
    points: int
    header: Any
    is_wanted: Callable[[], bool]
    table_grip: Callable[[float, float, float], GripAnswer | None]
    solve_grip: Callable[[GripQuestion, Callable[[], bool]], GripEntry]
    now: float


def answer_plan_wrap(request: Any, response: Any, context: PlanContext) -> Any:  # noqa: ANN401
    """Fill a ``PlanWrap`` response; a bad request is answered with the reason, never raised."""
    start = time.perf_counter()
    _fill_safely(request, response, context, {})
    response.solve_time = time.perf_counter() - start
    return response


def _fill_safely(request: Any, response: Any, context: PlanContext, planners: _Planners) -> None:  # noqa: ANN401
    try:
        _fill(request, response, context, planners)
    except _RefusedError as refused:
        _refuse(response, refused.refusal)
    except SpiralError as error:
        _refuse(response, refusal_from_error(error))
        response.nearest_radius = getattr(error, "nearest_radius", None) or 0.0
    if not response.success:
        response.pressure = response.line_force = response.turns = response.contact_length = 0.0


def answer_plan_wraps(request: Any, response: Any, context: PlanContext) -> Any:  # noqa: ANN401
    """Fill a ``PlanWraps`` response: one answer for each radius; a bad one is refused by itself."""
    start = time.perf_counter()
    radii, axes = request.object_radius, request.object_axis
    if axes and len(axes) != len(radii):
        text = f"object_axis must be empty or as long as object_radius, {len(radii)}"
        return refuse_all(request, response, Reason.INVALID_REQUEST, f"{text}, got {len(axes)}")
    planners: _Planners = {}
    for index, radius in enumerate(radii):
        one = PlanWrap.Request(
            object_radius=radius,
            object_length=request.object_length,
            payload=request.payload,
            friction_coefficient=request.friction_coefficient,
            compute_grip=request.compute_grip,
            overpressure=request.overpressure,
            object_axis=axes[index : index + 1],
            gravity=request.gravity,
        )
        answer = PlanWrap.Response()
        if context.is_wanted():
            _fill_safely(one, answer, context, planners)
        else:
            _refuse(answer, Refusal(Reason.NOT_ACTIVE, UNLOADED))
        for name in _LISTED:
            getattr(response, name).append(getattr(answer, name))
    response.solve_time = time.perf_counter() - start
    return response


def refuse_all(request: Any, response: Any, reason: Reason, text: str) -> Any:  # noqa: ANN401
    """Fill a ``PlanWraps`` response that is refused as a whole."""
    for _ in request.object_radius:
        refused = PlanWrap.Response(success=False, reason=int(reason), message=text)
        for name in _LISTED:
            getattr(response, name).append(getattr(refused, name))
    return response


class _RefusedError(Exception):
    """A wrap exists but is refused; carries the reason."""

    def __init__(self, refusal: Refusal) -> None:
        super().__init__(refusal.text)
        self.refusal = refusal


def _planner_of(request: Any, context: PlanContext, planners: _Planners) -> AnyPlanner:  # noqa: ANN401
    """Return the planner for the gravity and axis that the request names."""
    if not request.gravity and not request.object_axis:
        return context.planner
    gravity = context.planner.gravity
    if request.gravity:
        gravity = vector_from_msg(request.gravity[0])
    problem = gravity_problem(gravity)
    if problem is not None:
        raise _RefusedError(Refusal(Reason.GRAVITY_INVALID, problem))
    axis = context.gripper.object_axis
    if request.object_axis:
        axis = require_direction("object_axis", vector_from_msg(request.object_axis[0]))
    key = (*gravity, *(axis or ()))
    if key not in planners:
        planners[key] = planner_for(context.gripper.with_mount(gravity, axis), gravity)
    return planners[key]


def _fill(request: Any, response: Any, context: PlanContext, planners: _Planners) -> None:  # noqa: ANN401
    radius = request.object_radius
    # Whether this gripper can wrap it is for the planner to say: it knows why, and what it can.
    refusal = impossible_radius(radius, (0.0, math.inf))
    if refusal is not None:
        raise _RefusedError(refusal)
    overpressure = require_non_negative("overpressure", request.overpressure)
    length = require_non_negative("object_length", request.object_length)
    require_in_range("friction_coefficient", request.friction_coefficient, 0.0, FRICTION_MAX)
    require_non_negative("payload", request.payload)
    planner = _planner_of(request, context, planners)
    if isinstance(planner, NoPlanner):
        planner.plan(radius)
    response.radius_min, response.radius_max = planner.radius_range
    plan = planner.plan(radius)
    wrap = plan.wrap
    _fill_wrap(response, plan, context)
    _check_length(length, response.object_length_needed)
    overpressure = overpressure or default_overpressure(plan, context.limits)
    response.pressure = _capped(plan.pressure + overpressure, context)
    response.line_force = planner.line_force(wrap, response.pressure)
    answer = _grip(request, response.pressure, plan, context)
    if answer is not None:
        response.contact_length = answer.contact_length
        if request.overpressure > 0.0 and not response.pressure < answer.loss:
            raise _RefusedError(beyond_loss(response.pressure, answer.loss))
    response.grip = grip_to_msg(answer, context.now, request.payload, planner.gravity)
    response.success = True
    response.nearest_radius = radius
    response.message = (
        f"wraps {radius:.4g} m with {response.turns:.3g} turns at {response.pressure:.6g} Pa, "
        f"{response.pressure - plan.pressure:.4g} Pa above the bare wrap; "
        f"the free coil is up to {response.largest_gap:.3g} m off the object"
    )


def _grip(request: Any, pressure: float, plan: WrapPlan, context: PlanContext) -> GripAnswer | None:  # noqa: ANN401
    """Return what holds the object: computed for it if that is asked for, else of the table."""
    if not request.compute_grip:
        is_other = request.gravity or request.object_axis or request.friction_coefficient > 0.0
        if is_other:
            return None
        return context.table_grip(request.object_radius, plan.laid.pressure, pressure)
    pose = None
    if request.object_pose:
        position, turn = request.object_pose[0].position, request.object_pose[0].orientation
        pose = object_line(vector_from_msg(position), (turn.x, turn.y, turn.z, turn.w))
    question = GripQuestion(
        plan.gripper, request.object_radius, request.friction_coefficient or None, pose
    )
    return context.solve_grip(question, context.is_wanted).answer(
        pressure, at_pose=pose is not None
    )


def _check_length(available: float, needed: float) -> None:
    """Refuse an object that is shorter than what the coil covers; 0 stands for any length [m]."""
    if 0.0 < available < needed:
        text = (
            f"the coil covers {needed:.4g} m of the object but object_length is {available:.4g} m"
        )
        raise _RefusedError(Refusal(Reason.OBJECT_TOO_SHORT, text))


def _capped(pressure: float, context: PlanContext) -> float:
    """Return ``pressure`` [Pa] if the node would command it."""
    cap = context.limits.pressure_cap
    if not pressure <= cap:
        text = f"needs {pressure:.6g} Pa, above pressure_cap = {cap:.6g} Pa"
        raise _RefusedError(Refusal(Reason.PRESSURE_CAP, text))
    return pressure


def _fill_wrap(response: Any, plan: WrapPlan, context: PlanContext) -> None:  # noqa: ANN401
    wrap, placement = plan.wrap, plan.placement
    response.turns = wrap.turns
    response.contact_length = wrap.contact_length
    response.gripper_length_needed = wrap.gripper_length_needed or 0.0
    response.object_length_needed = wrap.object_length_needed or 0.0
    response.object_axis = vector_to_msg(wrap.coil.axis)
    x, y, z = placement.center
    response.object_center = Point(x=x, y=y, z=z)
    response.largest_gap = placement.largest_gap
    response.backbone = backbone_to_msg(wrap.state, context.points, context.header)
    response.stable = wrap.state.stable


def _refuse(response: Any, refusal: Refusal) -> None:  # noqa: ANN401
    response.success = False
    response.reason = int(refusal.reason)
    response.message = refusal.text
