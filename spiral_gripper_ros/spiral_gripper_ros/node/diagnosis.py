# SPDX-License-Identifier: Apache-2.0
"""Publication of the node's state on /diagnostics, in every lifecycle state."""

from __future__ import annotations

import time

from rclpy.node import Node

from spiral_gripper_ros.messages.diagnostics import diagnostics_to_msg
from spiral_gripper_ros.process.guards import log_on_error
from spiral_gripper_ros.runtime.control_clock import STEADY
from spiral_gripper_ros.runtime.runtime import Runtime

# Of real time [s] (REP-107): a simulated clock that stands still must not go unnoticed.
PERIOD = 1.0
# A simulated clock that has not moved for this time [s] is reported.
LONGEST_STANDSTILL = 1.5


class Diagnosis:
    """Publishes the diagnostics once a second, as long as the node exists.

    Args:
        node: the ROS node that is diagnosed.
        runtime: its gripper.
    """

    def __init__(self, node: Node, runtime: Runtime) -> None:
        self._node = node
        self._runtime = runtime
        self.tell = log_on_error(runtime.errors, self._tell)
        node.create_timer(PERIOD, self.tell, clock=STEADY)

    def _tell(self) -> None:
        node, runtime, loaded = self._node, self._runtime, self._runtime.loaded
        stands_still = runtime.is_active and runtime.clock.standstill() > LONGEST_STANDSTILL
        runtime.log.tell_clock(stands_still)
        if stands_still:
            runtime.control.stand_still(time.monotonic())
            runtime.on_published()
        runtime.follow_grips()  # an inactive node has no tick that does
        commanders = node.count_publishers(node.resolve_topic_name("pressure_command"))
        runtime.log.tell_others(commanders)
        message = diagnostics_to_msg(
            runtime.control.snapshot(),
            node.get_clock().now().to_msg(),
            name=node.get_fully_qualified_name(),
            hardware_id="" if loaded is None else loaded.gripper.name,
            internal_errors=runtime.errors.count,
            clock_stands_still=stands_still,
            commanders=commanders,
            object_problem=runtime.objects.problem,
            object_poses_refused=runtime.objects.refused,
            has_table=loaded is not None and loaded.grips.table(loaded.gravity) is not None,
        )
        runtime.outputs.publish_diagnostics(message)
