# SPDX-License-Identifier: Apache-2.0
"""The answers of `plan_wrap`."""

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
    require_positive,
)
from spiral_core.wrap.gripper import FRICTION_MAX, Gripper
from spiral_gripper_msgs.msg import ObjectToWrap, PlannedWrap
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.radius_gate import impossible_radius
from spiral_gripper_ros.control.states import Reason, Refusal, refusal_from_error
from spiral_gripper_ros.control.target import beyond_loss, default_overpressure
from spiral_gripper_ros.messages.conversions import (
    backbone_to_msg,
    figures_to_msg,
    known,
    optional,
    quaternion_from_msg,
    vector_from_msg,
    vector_to_msg,
)
from spiral_gripper_ros.messages.grip import grip_to_msg
from spiral_gripper_ros.parameters.spec import LARGEST_PAYLOAD, gravity_problem
from spiral_gripper_ros.planning.grip_figures import GripAnswer, GripFigures, GripQuestion
from spiral_gripper_ros.planning.object_pose import object_line
from spiral_gripper_ros.planning.planner import AnyPlanner, NoPlanner, WrapPlan, planner_for
from spiral_gripper_ros.planning.worker import EndedError

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
        known_grip: returns the grip on a plan's object of a radius [m] at a pressure [Pa], if it is
            known; for the present mount.
        solve_grip: returns the grip on one object, in seconds, unless it is no longer awaited.
        now: time that the age of grips is counted to [s].
    """

    planner: AnyPlanner
    gripper: Gripper
    limits: Limits
    points: int
    header: Any
    is_wanted: Callable[[], bool]
    known_grip: Callable[[WrapPlan, float, None, float], GripAnswer | None]
    solve_grip: Callable[[GripQuestion, Callable[[], bool]], GripFigures]
    now: float


def answer_plan_wrap(request: Any, response: Any, context: PlanContext) -> Any:  # noqa: ANN401
    """Fill a response: one answer for each object; a bad one is refused by itself, never raised."""
    start = time.perf_counter()
    planners: _Planners = {}
    response.plans = [_answered(one, request, context, planners) for one in request.objects]
    response.solve_time = time.perf_counter() - start
    return response


def refuse_all(request: Any, response: Any, text: str, reason: Reason) -> Any:  # noqa: ANN401
    """Fill a response that is refused as a whole."""
    response.plans = [_refused(Refusal(reason, text)) for _ in request.objects]
    return response


def _answered(
    asked: ObjectToWrap,
    request: Any,  # noqa: ANN401
    context: PlanContext,
    planners: _Planners,
) -> PlannedWrap:
    """Return the answer about one object."""
    if not context.is_wanted():
        return _refused(Refusal(Reason.NOT_ACTIVE, UNLOADED))
    answer, nearest = PlannedWrap(), None
    try:
        _fill(answer, asked, request, context, planners)
    except _RefusedError as refused:
        refusal = refused.refusal
    except EndedError as error:
        reason = Reason.INTERNAL_ERROR if context.is_wanted() else Reason.NOT_ACTIVE
        refusal = Refusal(reason, str(error))
    except SpiralError as error:
        refusal, nearest = refusal_from_error(error), getattr(error, "nearest_radius", None)
    else:
        return answer
    refused_answer = _refused(refusal)
    refused_answer.radius_range = answer.radius_range
    refused_answer.nearest_radius = optional(nearest)
    return refused_answer


class _RefusedError(Exception):
    """A wrap exists but is refused; carries the reason."""

    def __init__(self, refusal: Refusal) -> None:
        super().__init__(refusal.text)
        self.refusal = refusal


def _planner_of(
    asked: ObjectToWrap,
    request: Any,  # noqa: ANN401
    context: PlanContext,
    planners: _Planners,
) -> AnyPlanner:
    """Return the planner for the gravity and the object's axis."""
    if not request.gravity and not asked.axis:
        return context.planner
    gravity = context.planner.gravity
    if request.gravity:
        gravity = vector_from_msg(request.gravity[0])
    problem = gravity_problem(gravity)
    if problem is not None:
        raise _RefusedError(Refusal(Reason.GRAVITY_INVALID, problem))
    axis = context.gripper.object_axis
    if asked.axis:
        axis = require_direction("axis", vector_from_msg(asked.axis[0]))
    key = (*gravity, *(axis or ()))
    if key not in planners:
        planners[key] = planner_for(context.gripper.with_mount(gravity, axis), gravity)
    return planners[key]


def _fill(
    answer: PlannedWrap,
    asked: ObjectToWrap,
    request: Any,  # noqa: ANN401
    context: PlanContext,
    planners: _Planners,
) -> None:
    radius = asked.radius
    # Whether this gripper can wrap it is for the planner to say: it knows why, and what it can.
    refusal = impossible_radius(radius, (0.0, math.inf))
    if refusal is not None:
        raise _RefusedError(refusal)
    overpressure, length = known(request.overpressure), known(asked.length)
    friction, payload = known(asked.friction_coefficient), known(asked.payload)
    if overpressure is not None:
        require_non_negative("overpressure", overpressure)
    if payload is not None:
        require_in_range("payload", payload, 0.0, LARGEST_PAYLOAD)
    if length is not None:
        require_positive("length", length)
    if friction is not None:
        require_in_range("friction_coefficient", friction, 0.0, FRICTION_MAX)
    planner = _planner_of(asked, request, context, planners)
    if isinstance(planner, NoPlanner):
        planner.plan(radius)
    answer.radius_range = planner.radius_range
    plan = planner.plan(radius)
    _check_length(length, plan.wrap.object_length_needed or 0.0)
    above = default_overpressure(plan, context.limits) if overpressure is None else overpressure
    pressure = _capped(plan.pressure + above, context)
    grip = _grip(asked, request, pressure, plan, context)
    if grip is not None and not pressure < grip.loss:
        raise _RefusedError(beyond_loss(pressure, grip.loss))
    contact = None if grip is None else grip.contact_length
    answer.figures = [
        figures_to_msg(plan, radius, pressure, planner, context.limits.pressure_cap, contact)
    ]
    answer.grip = grip_to_msg(grip, context.now, payload, planner.gravity)
    placement, (x, y, z) = plan.placement, plan.placement.center
    answer.object_axis = [vector_to_msg(plan.wrap.coil.axis)]
    answer.object_center = [Point(x=x, y=y, z=z)]
    answer.largest_gap = [placement.largest_gap]
    if request.backbone:
        answer.backbone = backbone_to_msg(plan.wrap.state, context.points, context.header)
    answer.success = True
    answer.message = (
        f"wraps {radius:.4g} m with {plan.wrap.turns:.3g} turns at {pressure:.6g} Pa, "
        f"{above:.4g} Pa above the bare wrap; "
        f"the free coil is up to {placement.largest_gap:.3g} m off the object"
    )


def _grip(
    asked: ObjectToWrap,
    request: Any,  # noqa: ANN401
    pressure: float,
    plan: WrapPlan,
    context: PlanContext,
) -> GripAnswer | None:
    """Return what holds the object: computed for it if that is asked for, else of the table."""
    if not request.compute_grip:
        is_other = request.gravity or asked.axis or asked.friction_coefficient
        return None if is_other else context.known_grip(plan, asked.radius, None, pressure)
    pose = None
    if asked.pose:
        at = asked.pose[0]
        pose = object_line(vector_from_msg(at.position), quaternion_from_msg(at.orientation))
    friction = known(asked.friction_coefficient)
    question = GripQuestion(plan.gripper, asked.radius, friction, pose)
    return context.solve_grip(question, context.is_wanted).answer(
        pressure, at_pose=pose is not None
    )


def _check_length(available: float | None, needed: float) -> None:
    """Refuse an object that is shorter than what the coil covers; None: any length [m]."""
    if available is not None and available < needed:
        text = f"the coil covers {needed:.4g} m of the object but its length is {available:.4g} m"
        raise _RefusedError(Refusal(Reason.OBJECT_TOO_SHORT, text))


def _capped(pressure: float, context: PlanContext) -> float:
    """Return ``pressure`` [Pa] if the node would command it."""
    cap = context.limits.pressure_cap
    if not pressure <= cap:
        text = f"needs {pressure:.6g} Pa, above pressure.cap = {cap:.6g} Pa"
        raise _RefusedError(Refusal(Reason.PRESSURE_CAP, text))
    return pressure


def _refused(refusal: Refusal) -> PlannedWrap:
    return PlannedWrap(success=False, reason=int(refusal.reason), message=refusal.text)
