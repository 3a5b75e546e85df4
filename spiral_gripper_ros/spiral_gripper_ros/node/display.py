# SPDX-License-Identifier: Apache-2.0
"""Markers of the gripper for RViz, published while there are subscribers."""

from __future__ import annotations

from dataclasses import replace

from rclpy.node import Node
from rclpy.timer import Timer

from spiral_core.rod.state import RodState
from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.messages.conversions import shown_regime
from spiral_gripper_ros.messages.markers import Scene, no_markers, scene_to_msg
from spiral_gripper_ros.node.robot_state import RobotState
from spiral_gripper_ros.planning.grip_figures import GripFigures, TubeShape
from spiral_gripper_ros.planning.grip_follower import InUse
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper
from spiral_gripper_ros.planning.planner import GripShape, WrapPlan
from spiral_gripper_ros.process.guards import log_on_error
from spiral_gripper_ros.runtime.runtime import Runtime

# A display forgets the markers of a node that is gone after so many periods without new ones.
LIFETIME_PERIODS = 5.0
# Slower than once in this time [s] nothing is drawn; a timer cannot wait for any time.
LONGEST_PERIOD = 3600.0


class Display:
    """Publishes ``markers`` at ``publish.marker_rate`` while active and somebody subscribes.

    Args:
        node: the ROS node that publishes.
        runtime: the gripper that is drawn.
    """

    def __init__(self, node: Node, runtime: Runtime) -> None:
        self._node = node
        self._runtime = runtime
        self.draw = log_on_error(runtime.errors, self._draw)
        self.start = log_on_error(runtime.errors, self._start)
        self.stop = log_on_error(runtime.errors, self._stop)
        self._timer: Timer | None = None
        self._is_drawn = False
        self._robot = RobotState(node, runtime)

    def _start(self) -> None:
        """Start to publish at the present ``publish.marker_rate``; at 0 Hz delete the markers."""
        self._robot.start()
        self._stop_timer()
        if self._rate() > 0.0:
            clock = self._runtime.clock.clock
            self._timer = self._node.create_timer(self._period(), self.draw, clock=clock)
        else:
            self._clear()

    def _stop(self) -> None:
        """Stop publishing, and delete the markers."""
        self._robot.stop()
        self._clear()

    def _clear(self) -> None:
        self._stop_timer()
        if self._is_drawn:
            self._runtime.outputs.publish("markers", no_markers(self._runtime.outputs.header()))
        self._is_drawn = False

    def _draw(self) -> None:
        runtime = self._runtime
        if runtime.loaded is None or not runtime.outputs.markers_are_wanted:
            return
        message = scene_to_msg(
            self._scene(runtime.loaded, runtime.control.snapshot()),
            points=runtime.values.publish.backbone_points,
            lifetime=LIFETIME_PERIODS * self._period(),
            header=runtime.outputs.header(),
        )
        runtime.outputs.publish("markers", message)
        self._is_drawn = True

    def _scene(self, loaded: LoadedGripper, snapshot: Snapshot[WrapPlan]) -> Scene:
        commanded, measured = loaded.commanded.shape, loaded.measured.shape
        pressure = None if snapshot.measured is None else snapshot.measured.pressure
        grip = self._grip(loaded, snapshot)
        return Scene(
            commanded=_on_object(grip, snapshot.pressure_command, commanded),
            measured=_on_object(grip, pressure, measured),
            placement=self._placement(loaded, snapshot, grip),
            regime=shown_regime(snapshot, loaded, loaded.regime(snapshot.pressure)),
            text=_text(snapshot),
            outer_radius=loaded.gripper.tube.outer_radius,
        )

    def _grip(self, loaded: LoadedGripper, snapshot: Snapshot[WrapPlan]) -> GripFigures | None:
        """Return the grip that was computed for the object in use, if it is known."""
        if snapshot.radius is None:
            return None
        found = loaded.grips.found(InUse(snapshot.radius, self._runtime.seen_object()))
        return found if isinstance(found, GripFigures) else None

    def _placement(
        self, loaded: LoadedGripper, snapshot: Snapshot[WrapPlan], grip: GripFigures | None
    ) -> ObjectPlacement | None:
        """Return where the object in use is: as it is seen, else where the wrap expects it."""
        placement, seen = loaded.placement(snapshot.plan), self._runtime.seen_object()
        if placement is not None and seen is not None:
            return replace(placement, center=seen.center, axis=seen.axis)
        if placement is not None and grip is not None:
            return replace(placement, center=grip.center, axis=grip.axis)
        return placement

    def _rate(self) -> float:
        return self._runtime.values.publish.marker_rate

    def _period(self) -> float:
        return min(1.0 / self._rate(), LONGEST_PERIOD)

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
        self._timer = None


def _on_object(
    grip: GripFigures | None, pressure: float | None, free: GripShape | None
) -> RodState | TubeShape | None:
    """Return the tube at a pressure [Pa]: on the object where that is solved, else the free one."""
    held = None if grip is None or pressure is None else grip.shape(pressure)
    if held is not None:
        return held
    return None if free is None else free.state


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
