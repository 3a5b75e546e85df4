# SPDX-License-Identifier: Apache-2.0
"""The node's services: each callback unpacks, calls, packs."""

from __future__ import annotations

import functools
import traceback
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from std_srvs.srv import Trigger

from spiral_core.errors import SpiralError
from spiral_gripper_msgs.srv import DesignGripper, PlanWrap, PlanWraps
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.node.design_service import fill_response, question_from_msg
from spiral_gripper_ros.node.guards import report
from spiral_gripper_ros.node.parameters import number
from spiral_gripper_ros.node.plan_service import (
    PlanContext,
    answer_plan_wrap,
    answer_plan_wraps,
    refuse_all,
)

if TYPE_CHECKING:
    from spiral_gripper_ros.node.gripper_node import GripperNode
    from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper

TOO_LARGE = "the numbers of the request are too large to compute with: SI units are expected"
RELEASED = "vented; call rearm to follow radii again"
RELEASED_INACTIVE = "vented; the node is not active"


class Services:
    """Serves `design_gripper`, `plan_wrap`, `release` and `rearm` as long as the node exists.

    The first two are answered in the background and have callback groups of their own, so that
    they hold up neither the control loop nor each other: while an answer is awaited, nothing else
    of its group is called. An exception in one of them is logged and answered, and does not vent a
    gripper that holds.

    Args:
        node: the node that serves.
    """

    def __init__(self, node: GripperNode) -> None:
        self._node = node
        designs, plans = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()
        node.create_service(
            DesignGripper, "design_gripper", self._design_gripper, callback_group=designs
        )
        node.create_service(Trigger, "cancel_design", self._cancel_design)
        node.create_service(PlanWrap, "plan_wrap", self._plan_wrap, callback_group=plans)
        node.create_service(PlanWraps, "plan_wraps", self._plan_wraps, callback_group=plans)
        node.create_service(Trigger, "release", self._release)
        node.create_service(Trigger, "rearm", self._rearm)

    async def _design_gripper(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        loaded = self._node.loaded
        if loaded is None:
            response.message = self._node.not_configured
            return response
        return await self._guarded(self._designed(request, response, loaded), response)

    async def _designed(self, request: Any, response: Any, loaded: LoadedGripper) -> Any:  # noqa: ANN401
        question = question_from_msg(request, loaded.mount.gravity)
        node = self._node
        report = await node.background.design(node.executor, question, loaded.description)
        return fill_response(response, report)

    def _cancel_design(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        del request
        response.success = self._node.background.cancel_design("canceled")
        response.message = "canceled" if response.success else "no design is being computed"
        return response

    async def _plan_wrap(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        if self._node.loaded is None:
            response.reason, response.message = int(Reason.NOT_ACTIVE), self._node.not_configured
            return response
        return await self._guarded(self._planned(answer_plan_wrap, request, response), response)

    async def _plan_wraps(self, request: Any, response: Any) -> Any:  # noqa: ANN401
        if self._node.loaded is None:
            return refuse_all(request, response, Reason.NOT_ACTIVE, self._node.not_configured)
        answered = self._planned(answer_plan_wraps, request, response)
        return await self._guarded(answered, response)

    async def _planned(self, answer: Callable[..., Any], *question: Any) -> Any:  # noqa: ANN401
        """Return what a function answers in the background, from the gripper as it is now."""
        node, loaded = self._node, self._node.loaded
        if loaded is None:
            raise SpiralError(node.not_configured)
        node.take_planner()  # an inactive node has no tick that does
        context = PlanContext(
            planner=loaded.planner,
            gripper=loaded.gripper,
            pressure_cap=node.limits.pressure_cap,
            grip_ratio=node.limits.grip_ratio,
            points=int(number(node.values, "backbone_points")),
            header=node.outputs.header(),
        )
        return await node.background.ask(
            node.executor, functools.partial(answer, *question, context)
        )

    async def _guarded(self, answer: Awaitable[Any], response: Any) -> Any:  # noqa: ANN401
        """Return what is awaited; an exception becomes an answer too."""
        try:
            return await answer
        except SpiralError as error:
            return _failed(response, str(error))
        except OverflowError:
            return _failed(response, TOO_LARGE)
        except Exception as error:
            self._node.get_logger().error(
                f"exception in a service:\n{''.join(traceback.format_exception(error))}"
            )
            return _failed(response, f"internal error: {error!r}", Reason.INTERNAL_ERROR)

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


def _failed(response: Any, message: str, reason: Reason = Reason.INVALID_REQUEST) -> Any:  # noqa: ANN401
    """Return an empty response that says what went wrong; lists get one entry."""
    failed = type(response)()
    for name, value in (("success", False), ("reason", int(reason)), ("message", message)):
        if hasattr(failed, name):
            is_list = not isinstance(getattr(failed, name), (bool, int, str))
            setattr(failed, name, [value] if is_list else value)
    return failed
