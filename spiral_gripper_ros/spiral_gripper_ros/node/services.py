# SPDX-License-Identifier: Apache-2.0
"""The node's services: each callback unpacks, calls and packs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.node import Node
from std_srvs.srv import Trigger

from spiral_core.errors import SpiralError
from spiral_gripper_msgs.srv import DesignGripper, PlanWrap
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.qos import REQUESTS
from spiral_gripper_ros.node.design_service import fill_response, requirement_from_msg
from spiral_gripper_ros.node.plan_service import PlanAnswers, refuse_all
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper
from spiral_gripper_ros.runtime.guards import answered, report
from spiral_gripper_ros.runtime.runtime import Runtime

# Grips of one plan_wrap: seconds each.
MOST_GRIPS = 20
TOO_MANY_GRIPS = f"compute_grip takes seconds for each object: at most {MOST_GRIPS} in one request"
RELEASED = "vented; call rearm to follow radii again"
RELEASED_INACTIVE = "vented; the node is not active"


class Services:
    """Serves `plan_wrap`, `design_gripper`, `vent`, ... while the node exists.

    Plans and designs are answered in the background, each kind in a callback group and by a worker
    of its own, so that they hold up neither the control loop nor each other. An exception in one of
    them is logged and answered, and does not vent a gripper that holds.

    Args:
        node: the ROS node that serves.
        runtime: the gripper.
    """

    def __init__(self, node: Node, runtime: Runtime) -> None:
        self._node, self._runtime = node, runtime
        # What waits is counted, so that it can be answered "busy"; designs wait in the queue.
        for kind, name, callback, group in (
            (PlanWrap, "plan_wrap", self._plan_wrap, ReentrantCallbackGroup()),
            (DesignGripper, "design_gripper", self._design, MutuallyExclusiveCallbackGroup()),
            (Trigger, "cancel_design", self._cancel_design, None),
            (Trigger, "vent", self._vent, None),
            (Trigger, "rearm", self._rearm, None),
        ):
            options = {"callback_group": group, "qos_profile": REQUESTS}
            node.create_service(kind, name, callback, **options)

    async def _design(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        def refuse(text: str, _: Reason) -> Any:  # noqa: ANN401
            return DesignGripper.Response(success=False, message=text)

        async def answer(loaded: LoadedGripper) -> Any:  # noqa: ANN401
            question = request, loaded.gravity, loaded.description
            report = await self._runtime.background.design(
                self._node.executor, lambda: requirement_from_msg(*question)
            )
            return fill_response(response, report)

        return await answered(self._runtime, answer, refuse)

    def _cancel_design(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        del request
        response.success = self._runtime.background.cancel_design("canceled")
        response.message = "canceled" if response.success else "no design is being computed"
        return response

    async def _plan_wrap(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        def refuse(text: str, reason: Reason) -> Any:  # noqa: ANN401
            return refuse_all(request, PlanWrap.Response(), text, reason)

        async def answer(loaded: LoadedGripper) -> Any:  # noqa: ANN401
            runtime, background = self._runtime, self._runtime.background
            if request.compute_grip and len(request.objects) > MOST_GRIPS:
                raise SpiralError(TOO_MANY_GRIPS)
            pool = background.exact if request.compute_grip else background.plans
            if len(request.objects) > 1:
                pool = background.batches
            runtime.take_planner()  # an inactive node has no tick that does
            answers = PlanAnswers(request, runtime, loaded)
            return await pool.ask(self._node.executor, lambda: answers.fill(response))

        return await answered(self._runtime, answer, refuse)

    def _vent(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        done = RELEASED if self._runtime.is_active else RELEASED_INACTIVE
        return self._acted(self._runtime.control.release, done, response)

    def _rearm(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        return self._acted(self._runtime.rearm, "following radii", response)

    def _acted(self, act: Callable[[], Refusal | None], done: str, response: Any) -> Any:  # noqa: ANN401
        """Do something, command what follows from it, and answer; an exception vents."""
        try:
            refusal = act()
            if not refusal:  # an inactive node is silent: another may command
                self._runtime.publish()
            response.success = not refusal
            response.message = refusal.text if refusal else done
        except Exception as error:
            report(self._runtime, "a service", error)
            response.success, response.message = False, f"internal error: {error!r}"
        return response
