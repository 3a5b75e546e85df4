# SPDX-License-Identifier: Apache-2.0
"""The action `find_approach`: how an arm should hold the gripper; it moves nothing."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from rclpy.action import CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node

from spiral_core.errors import InvalidInputError, SpiralError
from spiral_core.validation import require_direction, require_in_range, require_positive
from spiral_core.wrap.gripper import STANDARD_GRAVITY, Gripper
from spiral_gripper_msgs.action import FindApproach
from spiral_gripper_msgs.msg import Approach
from spiral_gripper_ros.actions.server import GuardedServer
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.messages.conversions import (
    filled,
    known,
    line_from_msg,
    pose_of,
    vector_from_msg,
)
from spiral_gripper_ros.parameters.spec import GRAVITY_REQUIREMENT, LARGEST_PAYLOAD, gravity_problem
from spiral_gripper_ros.planning.approach import ApproachQuestion, FoundApproach, searched
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper
from spiral_gripper_ros.planning.worker import EndedError
from spiral_gripper_ros.runtime.guards import answered
from spiral_gripper_ros.runtime.runtime import Runtime

REPLACED = "replaced by a newer goal"


class ApproachServer:
    """Searches for one goal at a time, in any state that has a gripper; a newer one replaces it.

    Args:
        node: the ROS node that serves.
        runtime: the gripper.
    """

    def __init__(self, node: Node, runtime: Runtime) -> None:
        self._node, self._runtime = node, runtime
        self._newest: Any = None  # handle of the goal that is searched for
        self._server = GuardedServer(
            runtime.errors,
            node,
            FindApproach,
            "find_approach",
            self._execute,
            callback_group=ReentrantCallbackGroup(),
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        self.destroy = self._server.destroy

    async def _execute(self, handle: Any) -> Any:  # noqa: ANN401
        """Answer a goal."""

        def refuse(text: str, reason: Reason) -> Any:  # noqa: ANN401
            return FindApproach.Result(success=False, reason=int(reason), message=text)

        async def answer(loaded: LoadedGripper) -> Any:  # noqa: ANN401
            question = question_from_msg(
                handle.request, loaded.gripper, self._runtime.limits.pressure_cap
            )
            background, self._newest = self._runtime.background, handle

            def is_wanted(closed: int, expected: int) -> bool:
                unloaded = self._runtime.loaded is not loaded or background.has_ended
                if unloaded or handle.is_cancel_requested or self._newest is not handle:
                    return False
                handle.publish_feedback(FindApproach.Feedback(closed=closed, expected=expected))
                return True

            search = partial(searched, question, is_wanted)
            try:
                found, text = await background.approaches.ask(self._node.executor, search)
            except EndedError:
                if self._newest is handle:
                    raise
                raise SpiralError(REPLACED) from None
            return result_of(found, text, handle.request.object_pose)

        result = await answered(self._runtime, answer, refuse)
        if result.success:  # even if it was canceled a moment ago
            handle.succeed()
        elif handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        return result


def question_from_msg(request: Any, gripper: Gripper, cap: float) -> ApproachQuestion:  # noqa: ANN401
    """Return what a goal asks of a gripper at pressures up to a cap [Pa].

    Raises:
        InvalidInputError: the object's pose is none, or a value is out of its range.
    """
    gripper = replace(gripper, pressure_max=min(gripper.pressure_max, cap))
    _, axis = line_from_msg(request.object_pose.pose)
    gravity = (0.0, 0.0, -STANDARD_GRAVITY)
    for given in request.gravity:  # of at most one, as the others
        gravity = vector_from_msg(given)
        if gravity_problem(gravity) is not None:
            raise InvalidInputError("gravity", gravity, GRAVITY_REQUIREMENT)
        require_direction("gravity", gravity)
    radius = require_positive("object_radius", request.object_radius)
    require_in_range("object_radius", radius, 0.0, gripper.tube.length, "m")
    for payload in request.payload:
        require_in_range(
            "payload", require_positive("payload", payload), 0.0, LARGEST_PAYLOAD, "kg"
        )
    for tilt in request.tilt_max:
        require_in_range("tilt_max", require_positive("tilt_max", tilt), 0.0, math.pi, "rad")
    for friction in request.friction_coefficient:
        gripper = replace(gripper, friction_coefficient=friction)
    payload, tilt_max = known(request.payload), known(request.tilt_max)
    return ApproachQuestion(gripper, radius, axis, gravity, payload, tilt_max, request.regions)


def result_of(found: list[FoundApproach], text: str, object_pose: PoseStamped) -> Any:  # noqa: ANN401
    """Return the result that tells of approaches to an object at its place."""
    center = np.array(vector_from_msg(object_pose.pose.position))
    approaches = [
        filled(
            Approach(),
            one,
            base_pose=PoseStamped(
                header=object_pose.header,
                pose=pose_of((center + one.position).tolist(), one.orientation),
            ),
        )
        for one in found
    ]
    reason = Reason.NONE if found else Reason.NOT_CERTIFIED
    return FindApproach.Result(
        success=bool(found), reason=int(reason), message=text, approaches=approaches
    )
