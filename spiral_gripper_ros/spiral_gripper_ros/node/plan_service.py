# SPDX-License-Identifier: Apache-2.0
"""The answers of `plan_wrap`."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import mul
from typing import Any

from geometry_msgs.msg import Point

from spiral_core.errors import SpiralError
from spiral_core.grip.curve import GripAnswer, GripCurve, GripQuestion
from spiral_core.validation import (
    require_direction,
    require_in_range,
    require_non_negative,
    require_positive,
)
from spiral_core.wrap.gripper import DEFAULT_FRICTION, FRICTION_MAX, Gripper
from spiral_gripper.files.regions import StoredRegion, capture_margin
from spiral_gripper_msgs.msg import ObjectToWrap, PlannedWrap
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.plan import WrapPlan
from spiral_gripper_ros.control.radius_gate import impossible_radius
from spiral_gripper_ros.control.states import Reason, Refusal, refusal_from_error
from spiral_gripper_ros.control.target import beyond_loss, default_overpressure
from spiral_gripper_ros.messages.conversions import (
    backbone_to_msg,
    figures_to_msg,
    filled,
    known,
    line_from_msg,
    vector_from_msg,
    vector_to_msg,
)
from spiral_gripper_ros.messages.grip import grip_to_msg
from spiral_gripper_ros.parameters.spec import LARGEST_PAYLOAD, gravity_problem
from spiral_gripper_ros.planning.planner import AnyPlanner, NoPlanner, planner_for
from spiral_gripper_ros.planning.worker import EndedError

# Directions are one, in either sense, if their product is at least this.
SAME_AXIS = 1.0 - 1e-12
UNLOADED = "the gripper was unloaded or exchanged before all objects were planned for"


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
        regions: of capture that are known.
    """

    planner: AnyPlanner
    gripper: Gripper
    limits: Limits
    points: int
    header: Any
    is_wanted: Callable[[], bool]
    known_grip: Callable[[WrapPlan, float, None, float], GripAnswer | None]
    solve_grip: Callable[[GripQuestion, Callable[[], bool]], GripCurve]
    now: float
    regions: tuple[StoredRegion, ...] = ()


def answer_plan_wrap(request: Any, response: Any, context: PlanContext) -> Any:  # noqa: ANN401
    """Fill a response: one answer for each object; a bad one is refused by itself, never raised."""
    start = time.perf_counter()
    answers = _Answers(request, context)
    response.plans = [answers.about(one) for one in request.objects]
    response.solve_time = time.perf_counter() - start
    return response


def refuse_all(request: Any, response: Any, text: str, reason: Reason) -> Any:  # noqa: ANN401
    """Fill a response that is refused as a whole."""
    response.plans = [_refused(Refusal(reason, text)) for _ in request.objects]
    return response


class _RefusedError(Exception):
    """A wrap exists but is refused; carries the reason."""

    def __init__(self, reason: Reason, text: str) -> None:
        super().__init__(text)
        self.refusal = Refusal(reason, text)


class _Answers:
    """The answers to one request, about one object after the other."""

    def __init__(self, request: Any, context: PlanContext) -> None:  # noqa: ANN401
        self._request, self._context = request, context
        # Planners for other mounts, by gravity and axis: some tens of milliseconds each.
        self._planners: dict[tuple[float, ...], AnyPlanner] = {}

    def about(self, asked: ObjectToWrap) -> PlannedWrap:
        """Return the answer about one object."""
        is_wanted = self._context.is_wanted
        if not is_wanted():
            return _refused(Refusal(Reason.NOT_ACTIVE, UNLOADED))
        answer, nearest = PlannedWrap(), None
        try:
            return self._filled(answer, asked)
        except _RefusedError as refused:
            refusal = refused.refusal
        except EndedError as error:
            reason = Reason.INTERNAL_ERROR if is_wanted() else Reason.NOT_ACTIVE
            refusal = Refusal(reason, str(error))
        except SpiralError as error:
            refusal, nearest = refusal_from_error(error), getattr(error, "nearest_radius", None)
        told = {"radius_range": answer.radius_range, "nearest_radius": nearest}
        refused_answer: PlannedWrap = filled(_refused(refusal), **told)
        return refused_answer

    def _filled(self, answer: PlannedWrap, asked: ObjectToWrap) -> PlannedWrap:
        request, context, radius = self._request, self._context, asked.radius
        self._check(asked)
        overpressure, length = known(request.overpressure), known(asked.length)
        payload = known(asked.payload)
        planner, cap = self._planner(asked), context.limits.pressure_cap
        if isinstance(planner, NoPlanner):
            planner.plan(radius)
        answer.radius_range = planner.radius_range
        plan = planner.plan(radius, by_tip=request.compute_grip)
        needed = plan.wrap.object_length_needed or 0.0
        if length is not None and length < needed:
            text = f"the coil covers {needed:.4g} m of the object but its length is {length:.4g} m"
            raise _RefusedError(Reason.OBJECT_TOO_SHORT, text)
        solved = self._solved(asked, plan) if request.compute_grip else None
        if solved is not None:
            onset, highest_good, loss = solved.window
            plan = replace(plan, onset=onset, highest_good=highest_good, loss=loss)
        above = default_overpressure(plan, context.limits) if overpressure is None else overpressure
        pressure = plan.pressure + above
        if not pressure <= cap:
            text = f"needs {pressure:.6g} Pa, above pressure.cap = {cap:.6g} Pa"
            raise _RefusedError(Reason.PRESSURE_CAP, text)
        grip = (
            self._known_grip(asked, pressure, plan)
            if solved is None
            else solved.answer(pressure, at_pose=bool(asked.pose))
        )
        loss = plan.loss if grip is None else grip.loss
        if not pressure < loss:
            lost = beyond_loss(pressure, loss)
            raise _RefusedError(lost.reason, lost.text)
        contact = None if grip is None else grip.contact_length
        margin = self._capture_margin(asked, pressure, plan)
        missed, unjudged = margin is not None and margin < 0.0, ""
        if solved is None and margin is None and asked.pose:
            unjudged = "; its pose is not judged: compute_grip does that"
        elif grip is None and margin is None and plan.recommended is None:
            unjudged = "; contact is not judged: compute_grip does that"
        placement = plan.placement
        if request.backbone:
            answer.backbone = backbone_to_msg(plan.wrap.state, context.points, context.header)
        message: PlannedWrap = filled(
            answer,
            figures=[figures_to_msg(plan, radius, pressure, planner, cap, contact)],
            grip=grip_to_msg(grip, context.now, payload, planner.gravity),
            object_axis=[vector_to_msg(plan.wrap.coil.axis)],
            object_center=[vector_to_msg(placement.center, Point)],
            largest_gap=placement.largest_gap,
            capture_margin=margin,
            success=True,
            message=f"wraps {radius:.4g} m with {plan.wrap.turns:.3g} turns at {pressure:.6g} Pa, "
            f"{above:.4g} Pa above the bare wrap; "
            f"the free coil is up to {placement.largest_gap:.3g} m off the object"
            f"{'; at its pose it may be missed' if missed else ''}"
            f"{unjudged}",
        )
        return message

    def _check(self, asked: ObjectToWrap) -> None:
        """Refuse numbers that are out of their range."""
        # Whether this gripper can wrap it is for the planner to say: it knows why, and what it can.
        refusal = impossible_radius(asked.radius, (0.0, math.inf))
        if refusal is not None:
            raise _RefusedError(refusal.reason, refusal.text)
        overpressure, length = known(self._request.overpressure), known(asked.length)
        friction, payload = known(asked.friction_coefficient), known(asked.payload)
        if overpressure is not None:
            require_non_negative("overpressure", overpressure)
        if payload is not None:
            require_in_range("payload", payload, 0.0, LARGEST_PAYLOAD)
        if length is not None:
            require_positive("length", length)
        if friction is not None:
            require_in_range("friction_coefficient", friction, 0.0, FRICTION_MAX)

    def _planner(self, asked: ObjectToWrap) -> AnyPlanner:
        """Return the planner for the gravity and the object's axis."""
        present, gripper = self._context.planner, self._context.gripper
        gravity, axis = present.gravity, gripper.object_axis
        if self._request.gravity:
            gravity = vector_from_msg(self._request.gravity[0])
        is_own = self._is_own(asked)
        if is_own and gravity == present.gravity:
            return present
        problem = gravity_problem(gravity)
        if problem is not None:
            raise _RefusedError(Reason.GRAVITY_INVALID, problem)
        if asked.axis:
            axis = require_direction("axis", vector_from_msg(asked.axis[0]))
        key = (is_own, *gravity, *(axis or ()))
        if key not in self._planners:
            grips = getattr(present, "grips", None) if is_own else None
            self._planners[key] = planner_for(gripper.with_mount(gravity, axis), gravity, grips)
        return self._planners[key]

    def _is_own(self, asked: ObjectToWrap) -> bool:
        """Return whether an object has the axis and the friction of the node's own grips."""
        own = self._context.gripper
        if asked.axis:
            axis = require_direction("axis", vector_from_msg(asked.axis[0]))
            along = 0.0 if own.object_axis is None else sum(map(mul, axis, own.object_axis))
            if abs(along) < SAME_AXIS:
                return False
        return self._friction(asked) == self._friction(ObjectToWrap())

    def _friction(self, asked: ObjectToWrap) -> float:
        """Return the coefficient that an object states, or the gripper's."""
        friction, own = known(asked.friction_coefficient), self._context.gripper
        if friction is None:
            friction = own.friction_coefficient
        return DEFAULT_FRICTION if friction is None else friction

    def _solved(self, asked: ObjectToWrap, plan: WrapPlan) -> GripCurve:
        """Return the grip on exactly this object, in seconds."""
        pose = line_from_msg(asked.pose[0]) if asked.pose else None
        friction = known(asked.friction_coefficient)
        question = GripQuestion(plan.gripper, asked.radius, friction, pose)
        return self._context.solve_grip(question, self._context.is_wanted)

    def _known_grip(
        self, asked: ObjectToWrap, pressure: float, plan: WrapPlan
    ) -> GripAnswer | None:
        """Return what is known of the grip, for the node's own axis and friction."""
        if not self._is_own(asked):
            return None
        return self._context.known_grip(plan, asked.radius, None, pressure)

    def _capture_margin(self, asked: ObjectToWrap, pressure: float, plan: WrapPlan) -> float | None:
        """Return how far inside of a known region of capture the object is, if it is seen."""
        if not asked.pose:
            return None
        line, friction = line_from_msg(asked.pose[0]), self._friction(asked)
        closing = pressure, asked.radius, plan.gripper.gravity, friction, known(asked.payload)
        return capture_margin(self._context.regions, *line, closing)


def _refused(refusal: Refusal) -> PlannedWrap:
    return PlannedWrap(success=False, reason=int(refusal.reason), message=refusal.text)
