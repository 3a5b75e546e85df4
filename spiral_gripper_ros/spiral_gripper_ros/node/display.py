# SPDX-License-Identifier: Apache-2.0
"""Markers of the gripper for RViz, published while there are subscribers."""

from __future__ import annotations

from rclpy.node import Node

from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.messages.markers import no_markers, scene_to_msg
from spiral_gripper_ros.node.robot_state import RobotState
from spiral_gripper_ros.planning.loaded_gripper import place_of, tube_at
from spiral_gripper_ros.process.guards import log_on_error
from spiral_gripper_ros.runtime.repetition import LONGEST_PERIOD, Repetition
from spiral_gripper_ros.runtime.runtime import Runtime

# A display forgets the markers of a node that is gone after so many periods without new ones.
LIFETIME_PERIODS = 5.0


class Display:
    """Publishes ``markers`` at ``publish.marker_rate`` while active and somebody subscribes.

    Args:
        node: the ROS node that publishes.
        runtime: the gripper that is drawn.
    """

    def __init__(self, node: Node, runtime: Runtime) -> None:
        self._runtime = runtime
        self._drawn = Repetition(node, log_on_error(runtime.errors, self.draw))
        self.start = log_on_error(runtime.errors, self._start)
        self.stop = log_on_error(runtime.errors, self._stop)
        self._is_drawn = False
        self._robot = RobotState(node, runtime)

    def _start(self) -> None:
        """Start to publish at the present ``publish.marker_rate``; at 0 Hz delete the markers."""
        runtime = self._runtime
        self._robot.start()
        if self._rate == 0.0:
            self._clear()
        self._drawn.start(self._rate, runtime.clock.clock)

    def _stop(self) -> None:
        """Stop publishing, and delete the markers."""
        self._robot.stop()
        self._drawn.stop()
        self._clear()

    def _clear(self) -> None:
        if self._is_drawn:
            self._runtime.outputs.publish("markers", no_markers(self._runtime.outputs.header()))
        self._is_drawn = False

    def draw(self) -> None:
        """Publish the markers, if anybody subscribes."""
        runtime, loaded = self._runtime, self._runtime.loaded
        if loaded is None or not runtime.outputs.markers_are_wanted:
            return
        snapshot, seen = runtime.control.snapshot(), runtime.seen_object()
        curve = loaded.curve(snapshot.radius, seen)
        message = scene_to_msg(
            commanded=tube_at(curve, snapshot.pressure_command, loaded.commanded.shape),
            measured=tube_at(curve, loaded.measured.pressure, loaded.measured.shape),
            placement=place_of(snapshot.placement, curve, seen),
            regime=loaded.shown_regime(snapshot),
            text=_text(snapshot),
            outer_radius=loaded.gripper.tube.outer_radius,
            points=runtime.values.publish.backbone_points,
            lifetime=LIFETIME_PERIODS * min(1.0 / self._rate, LONGEST_PERIOD),
            header=runtime.outputs.header(),
        )
        runtime.outputs.publish("markers", message)
        self._is_drawn = True

    @property
    def _rate(self) -> float:
        return self._runtime.values.publish.marker_rate


def _text(snapshot: Snapshot) -> str:
    """Return state, pressures and what is wrong, for people."""
    lines = [f"{snapshot.state.name}  {1e-3 * snapshot.pressure_command:.1f} kPa"]
    if snapshot.measured_pressure is not None:
        lines.append(f"measured  {1e-3 * snapshot.measured_pressure:.1f} kPa")
    lines += [one.reason.name for one in (snapshot.refusal, snapshot.fault) if one]
    return "\n".join(lines)
