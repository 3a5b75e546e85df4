# SPDX-License-Identifier: Apache-2.0
"""Draws the gripper for RViz, as long as somebody looks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rclpy.timer import Timer

from spiral_core.wrap.placement import ObjectPlacement, place_object
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.node.guards import log_on_error
from spiral_gripper_ros.node.markers import Scene, no_markers, scene_to_msg
from spiral_gripper_ros.node.parameters import number
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper
from spiral_gripper_ros.planning.planner import WrapPlan
from spiral_gripper_ros.robot.robot_state import RobotState

if TYPE_CHECKING:
    from spiral_gripper_ros.node.gripper_node import GripperNode

# A display forgets the markers of a node that is gone after so many periods without new ones.
LIFETIME_PERIODS = 5.0
# Slower than once in this time [s] nothing is drawn; a timer cannot wait for any time.
LONGEST_PERIOD = 3600.0


class Display:
    """Publishes ``markers`` at ``marker_rate`` while the node is active and somebody subscribes.

    Args:
        node: the node whose gripper is drawn.
    """

    def __init__(self, node: GripperNode) -> None:
        self._node = node
        self.draw = log_on_error(node, self._draw)
        self.start = log_on_error(node, self._start)
        self.stop = log_on_error(node, self._stop)
        self._timer: Timer | None = None
        self._is_drawn = False
        self._robot = RobotState(node)
        self._placed: tuple[WrapPlan, ObjectPlacement] | None = None

    def _start(self) -> None:
        """Draw from now on, at the present ``marker_rate``; at 0 Hz delete what is drawn."""
        self._robot.start()
        self._stop_timer()
        if self._rate() > 0.0:
            clock = self._node.time.clock
            self._timer = self._node.create_timer(self._period(), self.draw, clock=clock)
        else:
            self._clear()

    def _stop(self) -> None:
        """Draw no more, and delete what is drawn."""
        self._robot.stop()
        self._clear()

    def _clear(self) -> None:
        self._stop_timer()
        if self._is_drawn:
            self._node.outputs.publish_markers(no_markers(self._node.outputs.header()))
        self._is_drawn, self._placed = False, None

    def _draw(self) -> None:
        node = self._node
        if node.loaded is None or not node.outputs.markers_are_wanted:
            return
        message = scene_to_msg(
            self._scene(node.loaded, node.control.snapshot()),
            points=int(number(node.values, "backbone_points")),
            lifetime=LIFETIME_PERIODS * self._period(),
            header=node.outputs.header(),
        )
        node.outputs.publish_markers(message)
        self._is_drawn = True

    def _scene(self, loaded: LoadedGripper, snapshot: Snapshot[WrapPlan]) -> Scene:
        commanded, measured = loaded.shape, loaded.measured_shape
        return Scene(
            commanded=None if commanded is None else commanded.state,
            measured=None if measured is None else measured.state,
            placement=self._placement(snapshot),
            regime=snapshot.shown(loaded.regime),
            text=_text(snapshot),
            outer_radius=loaded.gripper.tube.outer_radius,
        )

    def _placement(self, snapshot: Snapshot[WrapPlan]) -> ObjectPlacement | None:
        """Return where the object in use is; it stays there while the gripper moves."""
        plan = snapshot.plan
        if plan is None or snapshot.radius is None:
            return None
        if self._placed is None or self._placed[0] is not plan:
            self._placed = (plan, place_object(plan.wrap))
        return self._placed[1]

    def _rate(self) -> float:
        return number(self._node.values, "marker_rate")

    def _period(self) -> float:
        return min(1.0 / self._rate(), LONGEST_PERIOD)

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
        self._timer = None


def _text(snapshot: Snapshot[WrapPlan]) -> str:
    """Return state, pressures and what is wrong, for people."""
    lines = [f"{snapshot.state.name}  {_kilopascal(snapshot.pressure_command)}"]
    if snapshot.measured is not None:
        lines.append(f"measured  {_kilopascal(snapshot.measured.pressure)}")
    reasons = (snapshot.refusal.reason, snapshot.pressure_fault.reason)
    lines += [reason.name for reason in reasons if reason is not Reason.NONE]
    return "\n".join(lines)


def _kilopascal(pressure: float) -> str:
    return f"{1e-3 * pressure:.1f} kPa"
