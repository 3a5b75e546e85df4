# SPDX-License-Identifier: Apache-2.0
"""The answers of `plan_wrap`."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from operator import mul
from typing import Any

from geometry_msgs.msg import Point

from spiral_core.errors import SpiralError
from spiral_core.grip.curve import GripQuestion
from spiral_core.validation import (
    require_direction,
    require_in_range,
    require_non_negative,
    require_positive,
)
from spiral_core.wrap.gripper import DEFAULT_FRICTION, FRICTION_MAX
from spiral_gripper.files.regions import capture_margin
from spiral_gripper_msgs.msg import ObjectToWrap, PlannedWrap
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
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper
from spiral_gripper_ros.planning.planner import GripperPlanner, planner_for
from spiral_gripper_ros.planning.worker import EndedError
from spiral_gripper_ros.runtime.runtime import Runtime

# Directions are one, in either sense, if their product is at least this.
SAME_AXIS = 1.0 - 1e-12
UNLOADED = "the gripper was unloaded or exchanged before all objects were planned for"


def refuse_all(request: Any, response: Any, text: str, reason: Reason) -> Any:  # noqa: ANN401
    """Fill a response that is refused as a whole."""
    response.plans = [_refused(Refusal(reason, text)) for _ in request.objects]
    return response


class _RefusedError(Exception):
    """A wrap exists but is refused; its argument is the refusal."""


class PlanAnswers:
    """The answers to one request, with what the node knows when it is made.

    Args:
        request: the ``PlanWrap`` request.
        runtime: the gripper.
        loaded: the gripper that is loaded.
    """

    def __init__(self, request: Any, runtime: Runtime, loaded: LoadedGripper) -> None:  # noqa: ANN401
        self._request, self._runtime, self._loaded = request, runtime, loaded
        self._present, self._limits, self._now = loaded.planner, runtime.limits, runtime.now()
        self._header, self._points = (
            runtime.outputs.header(),
            runtime.values.publish.backbone_points,
        )
        # Planners for other mounts, by gravity and axis: some tens of milliseconds each.
        self._planners: dict[tuple[float, ...], GripperPlanner] = {}

    def fill(self, response: Any) -> Any:  # noqa: ANN401
        """Fill a response: one answer for each object; a bad one is refused, never raised.

        To be called in the background.
        """
        start = time.perf_counter()
        response.plans = [self._about(one) for one in self._request.objects]
        response.solve_time = time.perf_counter() - start
        return response

    def _is_wanted(self) -> bool:
        """Return whether the answers are still awaited."""
        return self._runtime.loaded is self._loaded and not self._runtime.background.has_ended

    def _about(self, asked: ObjectToWrap) -> PlannedWrap:
        """Return the answer about one object."""
        if not self._is_wanted():
            return _refused(Refusal(Reason.NOT_ACTIVE, UNLOADED))
        answer, nearest = PlannedWrap(), None
        try:
            return self._filled(answer, asked)
        except _RefusedError as refused:
            (refusal,) = refused.args
        except EndedError as error:
            reason = Reason.INTERNAL_ERROR if self._is_wanted() else Reason.NOT_ACTIVE
            refusal = Refusal(reason, str(error))
        except SpiralError as error:
            refusal, nearest = refusal_from_error(error), getattr(error, "nearest_radius", None)
        told = {"radius_range": answer.radius_range, "nearest_radius": nearest}
        return filled(_refused(refusal), **told)

    def _filled(self, answer: PlannedWrap, asked: ObjectToWrap) -> PlannedWrap:
        request, radius, cap = self._request, asked.radius, self._limits.pressure_cap
        self._check(asked)
        overpressure, length = known(request.overpressure), known(asked.length)
        payload, planner = known(asked.payload), self._planner(asked)
        if planner.error is None:
            answer.radius_range = planner.held_range
        plan = planner.plan(radius, by_tip=request.compute_grip)
        needed = plan.wrap.object_length_needed or 0.0
        if length is not None and length < needed:
            text = f"the coil covers {needed:.4g} m of the object but its length is {length:.4g} m"
            raise _RefusedError(Refusal(Reason.OBJECT_TOO_SHORT, text))
        pose, solved = line_from_msg(asked.pose[0]) if asked.pose else None, None
        if request.compute_grip:  # on exactly this object, in seconds
            friction = known(asked.friction_coefficient)
            question = GripQuestion(plan.gripper, radius, friction, pose)
            solved = self._runtime.solve_grip(question, self._is_wanted)
            onset, highest_good, loss = solved.window
            plan = replace(plan, onset=onset, highest_good=highest_good, loss=loss)
        above = default_overpressure(plan, self._limits) if overpressure is None else overpressure
        pressure = plan.pressure + above
        if not pressure <= cap:
            text = f"needs {pressure:.6g} Pa, above pressure.cap = {cap:.6g} Pa"
            raise _RefusedError(Refusal(Reason.PRESSURE_CAP, text))
        grip = None
        if solved is not None:
            grip = solved.answer(pressure, at_pose=pose is not None)
        elif planner.grips is not None:
            grip = planner.grips.answer(plan, None, pressure)
        loss = plan.loss if grip is None else grip.loss
        if not pressure < loss:
            raise _RefusedError(beyond_loss(pressure, loss))
        margin = None  # how far inside of a known region of capture it is
        if pose is not None:
            closing = pressure, radius, plan.gripper.gravity, self._friction(asked), payload
            margin = capture_margin(self._loaded.regions, *pose, closing)
        missed, unjudged = margin is not None and margin < 0.0, ""
        if solved is None and margin is None and asked.pose:
            unjudged = "; its pose is not judged: compute_grip does that"
        elif grip is None and margin is None and plan.recommended is None:
            unjudged = "; contact is not judged: compute_grip does that"
        placement = plan.placement
        if request.backbone:
            answer.backbone = backbone_to_msg(plan.wrap.state, self._points, self._header)
        return filled(
            answer,
            figures=[figures_to_msg(plan, pressure, planner, cap, grip)],
            grip=grip_to_msg(grip, self._now, payload, planner.gravity),
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

    def _check(self, asked: ObjectToWrap) -> None:
        """Refuse numbers that are out of their range."""
        # Whether this gripper can wrap it is for the planner to say: it knows why, and what it can.
        refusal = impossible_radius(asked.radius, (0.0, math.inf))
        if refusal:
            raise _RefusedError(refusal)
        for overpressure in self._request.overpressure:  # of at most one, as the others
            require_non_negative("overpressure", overpressure)
        for payload in asked.payload:
            require_in_range("payload", payload, 0.0, LARGEST_PAYLOAD)
        for length in asked.length:
            require_positive("length", length)
        for friction in asked.friction_coefficient:
            require_in_range("friction_coefficient", friction, 0.0, FRICTION_MAX)

    def _planner(self, asked: ObjectToWrap) -> GripperPlanner:
        """Return the planner for the gravity and the object's axis."""
        present, gripper = self._present, self._loaded.gripper
        gravity, axis = present.gravity, gripper.object_axis
        for given in self._request.gravity:
            gravity = vector_from_msg(given)
        is_own = self._is_own(asked)
        if is_own and gravity == present.gravity:
            return present
        problem = gravity_problem(gravity)
        if problem:
            raise _RefusedError(Refusal(Reason.GRAVITY_INVALID, problem))
        for given in asked.axis:
            axis = require_direction("axis", vector_from_msg(given))
        key = (is_own, *gravity, *(axis or ()))
        if key not in self._planners:
            grips = present.grips if is_own else None
            self._planners[key] = planner_for(gripper.with_mount(gravity, axis), gravity, grips)
        return self._planners[key]

    def _is_own(self, asked: ObjectToWrap) -> bool:
        """Return whether an object has the axis and the friction of the node's own grips."""
        own = self._loaded.gripper
        for given in asked.axis:
            axis = require_direction("axis", vector_from_msg(given))
            along = 0.0 if own.object_axis is None else sum(map(mul, axis, own.object_axis))
            if abs(along) < SAME_AXIS:
                return False
        return self._friction(asked) == self._friction(ObjectToWrap())

    def _friction(self, asked: ObjectToWrap) -> float:
        """Return the coefficient that an object states, or the gripper's."""
        friction = known(asked.friction_coefficient)
        if friction is None:
            friction = self._loaded.gripper.friction_coefficient
        return DEFAULT_FRICTION if friction is None else friction


def _refused(refusal: Refusal) -> PlannedWrap:
    return PlannedWrap(success=False, reason=int(refusal.reason), message=refusal.text)
