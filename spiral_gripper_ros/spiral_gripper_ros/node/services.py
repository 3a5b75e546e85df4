"""The node's services: each callback unpacks, calls, packs."""

from __future__ import annotations

import functools
import traceback
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from std_srvs.srv import Trigger

from spiral_core.errors import SpiralError
from spiral_gripper_msgs.srv import DesignGripper, PlanWrap
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.node.design_service import fill_response, question_from_msg
from spiral_gripper_ros.node.guards import report
from spiral_gripper_ros.node.parameters import number
from spiral_gripper_ros.node.plan_service import PlanContext, answer_plan_wrap
from spiral_gripper_ros.planning.design_question import requirement_from_question

if TYPE_CHECKING:
    from spiral_gripper_ros.node.gripper_node import GripperNode
    from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper

NOT_CONFIGURED = "the node has no gripper yet: configure it first"
TOO_LARGE = "the numbers of the request are too large to compute with: SI units are expected"
RELEASED = "vented; call rearm to follow radii again"
RELEASED_INACTIVE = "vented; the node is not active"


class Services:
    """Serves `design_gripper`, `plan_wrap`, `release` and `rearm` as long as the node exists.

    The first two are answered in the background and have a callback group of their own, so that
    they do not hold up the control loop: while an answer is awaited, nothing else of its group is
    called. An exception in one of them is logged and answered, and does not vent a gripper that
    holds.

    Args:
        node: the node that serves.
    """

    def __init__(self, node: GripperNode) -> None:
        self._node = node
        questions = MutuallyExclusiveCallbackGroup()
        node.create_service(
            DesignGripper, "design_gripper", self._design_gripper, callback_group=questions
        )
        node.create_service(PlanWrap, "plan_wrap", self._plan_wrap, callback_group=questions)
        node.create_service(Trigger, "release", self._release)
        node.create_service(Trigger, "rearm", self._rearm)

    async def _design_gripper(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        loaded = self._node.loaded
        if loaded is None:
            response.message = NOT_CONFIGURED
            return response
        return await self._guarded(self._designed(request, response, loaded), response)

    async def _designed(self, request: Any, response: Any, loaded: LoadedGripper) -> Any:  # noqa: ANN401
        question = question_from_msg(request, loaded.mount.gravity)
        requirement = requirement_from_question(question, loaded.description)
        report = await self._node.background.ask_design(self._node.executor, requirement)
        return fill_response(response, report)

    async def _plan_wrap(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        node, loaded = self._node, self._node.loaded
        if loaded is not None:
            node.take_planner()  # an inactive node has no tick that does
        if loaded is None:
            response.reason, response.message = int(Reason.NOT_ACTIVE), NOT_CONFIGURED
            return response
        context = PlanContext(
            planner=loaded.planner,
            gripper=loaded.gripper,
            pressure_cap=node.limits.pressure_cap,
            points=int(number(node.values, "backbone_points")),
            header=node.outputs.header(),
        )
        question = functools.partial(answer_plan_wrap, request, response, context)
        return await self._guarded(node.background.ask(node.executor, question), response)

    async def _guarded(self, answer: Awaitable[Any], response: Any) -> Any:  # noqa: ANN401
        """Return what is awaited; an exception becomes an answer too."""
        try:
            return await answer
        except SpiralError as error:
            return type(response)(success=False, message=str(error))
        except OverflowError:
            return type(response)(success=False, message=TOO_LARGE)
        except Exception as error:
            self._node.get_logger().error(
                f"exception in a service:\n{''.join(traceback.format_exception(error))}"
            )
            failed = type(response)(success=False, message=f"internal error: {error!r}")
            if hasattr(failed, "reason"):
                failed.reason = int(Reason.INTERNAL_ERROR)
            return failed

    def _release(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        done = RELEASED if self._node.is_active else RELEASED_INACTIVE
        return self._acted(self._node.control.release, done, response)

    def _rearm(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        return self._acted(self._node.control.rearm, "following radii", response)

    def _acted(self, act: Callable[[], Refusal | None], done: str, response: Any) -> Any:  # noqa: ANN401
        """Do something, command what follows from it, and answer; an exception vents."""
        try:
            refusal = act()
            if refusal is None:  # an inactive node is silent: another may command
                self._node.publish()
            response.success = refusal is None
            response.message = done if refusal is None else refusal.text
        except Exception as error:
            report(self._node, "a service", error)
            response.success, response.message = False, f"internal error: {error!r}"
        return response
