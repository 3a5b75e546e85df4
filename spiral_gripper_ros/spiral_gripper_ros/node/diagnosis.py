# SPDX-License-Identifier: Apache-2.0
"""Tells /diagnostics how the node is, whatever it does."""

from __future__ import annotations

from typing import TYPE_CHECKING

from spiral_gripper_ros.node.control_clock import STEADY
from spiral_gripper_ros.node.diagnostics import Health, diagnostics_to_msg
from spiral_gripper_ros.node.guards import log_on_error

if TYPE_CHECKING:
    from spiral_gripper_ros.node.gripper_node import GripperNode

# Of real time [s] (REP-107): a simulated clock that stands still must not go unnoticed.
PERIOD = 1.0
# A simulated clock that has not moved for this time [s] is told to people.
LONGEST_STANDSTILL = 1.5


class Diagnosis:
    """Publishes the diagnostics once a second, as long as the node exists.

    Args:
        node: the node that is diagnosed.
    """

    def __init__(self, node: GripperNode) -> None:
        self._node = node
        self.tell = log_on_error(node, self._tell)
        node.create_timer(PERIOD, self.tell, clock=STEADY)

    def _tell(self) -> None:
        node = self._node
        stands_still = node.is_active and node.time.standstill() > LONGEST_STANDSTILL
        node.log.tell_clock(stands_still)
        if node.inputs is not None:
            node.inputs.hear_latched_gravity()
        commanders = node.count_publishers("pressure_command")
        node.log.tell_others(commanders)
        health = Health(
            name=node.get_fully_qualified_name(),
            hardware_id="" if node.loaded is None else node.loaded.gripper.name,
            internal_errors=node.errors.count,
            clock_stands_still=stands_still,
            commanders=commanders,
        )
        stamp = node.get_clock().now().to_msg()
        node.outputs.publish_diagnostics(diagnostics_to_msg(health, node.control.snapshot(), stamp))
