# SPDX-License-Identifier: Apache-2.0
"""Frames of tip and object, the object's pose and the joint's position, for the rest of a robot."""

from __future__ import annotations

import importlib
import math
from typing import Any

from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion, TransformStamped
from rclpy.node import Node
from rclpy.timer import Timer
from sensor_msgs.msg import JointState

from spiral_gripper_ros.messages.conversions import opening_joint, pose_along, prefix_of
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper
from spiral_gripper_ros.process.guards import log_on_error
from spiral_gripper_ros.runtime.runtime import Runtime

# A timer cannot wait for any time [s].
LONGEST_PERIOD = 3600.0


class RobotState:
    """Publishes at ``publish.robot_state_rate`` while the node is active; at 0 Hz nothing.

    ``/tf`` needs tf2_msgs: without it the frames are left out.

    Args:
        node: the ROS node that publishes.
        runtime: the gripper whose state is published.
    """

    def __init__(self, node: Node, runtime: Runtime) -> None:
        self._node = node
        self._runtime = runtime
        self._timer: Timer | None = None
        self._publishers: dict[str, Any] = {}
        self._frames: Any = None
        self.tell = log_on_error(runtime.errors, self._tell)

    def start(self) -> None:
        """Publish from now on, at the present rate."""
        self.stop()
        rate = self._runtime.values.publish.robot_state_rate
        if rate > 0.0:
            self._connect()
            clock = self._runtime.clock.clock
            period = min(1.0 / rate, LONGEST_PERIOD)
            self._timer = self._node.create_timer(period, self.tell, clock=clock)

    def stop(self) -> None:
        """Publish no more."""
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
        self._timer = None

    def _connect(self) -> None:
        if self._publishers:
            return
        node = self._node
        self._publishers["joint"] = node.create_publisher(JointState, "joint_states", 10)
        self._publishers["object"] = node.create_publisher(PoseStamped, "wrapped_object_pose", 10)
        try:
            self._frames = importlib.import_module("tf2_msgs.msg").TFMessage
            self._publishers["frames"] = node.create_publisher(self._frames, "/tf", 100)
        except Exception as error:  # not installed, or built for another Python
            node.get_logger().info(f"/tf is not published, tf2_msgs cannot be used: {error}")

    def _tell(self) -> None:
        runtime, loaded = self._runtime, self._runtime.loaded
        if loaded is None:
            return
        header = runtime.outputs.header()
        prefix, poses = prefix_of(header.frame_id), {}
        shape = loaded.measured.shape or loaded.commanded.shape
        if shape is not None:
            x, y, z = shape.state.tip_position.tolist()
            qx, qy, qz, qw = shape.state.orientations[-1].tolist()
            poses["tip"] = Pose(
                position=Point(x=x, y=y, z=z), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw)
            )
        placement = loaded.placement(runtime.control.snapshot().plan)
        if placement is not None:
            poses["object"] = pose_along(placement)
            self._publishers["object"].publish(PoseStamped(header=header, pose=poses["object"]))
        self._publishers["joint"].publish(self._joint(loaded, header))
        if self._frames is not None:
            transforms = [
                _transform(header, f"{prefix}gripper_{name}", pose) for name, pose in poses.items()
            ]
            self._publishers["frames"].publish(self._frames(transforms=transforms))

    def _joint(self, loaded: LoadedGripper, header: Any) -> JointState:  # noqa: ANN401
        runtime, pressure = self._runtime, self._runtime.control.snapshot().pressure
        opening = runtime.values.gripper_cmd.open_position
        position = loaded.planner.wrapped_diameter(pressure, opening)
        state = JointState(header=header, name=[opening_joint(header.frame_id)])
        state.position = [position if math.isfinite(position) else opening]
        return state


def _transform(header: Any, child: str, pose: Pose) -> TransformStamped:  # noqa: ANN401
    message = TransformStamped(header=header, child_frame_id=child)
    place = message.transform.translation
    place.x, place.y, place.z = pose.position.x, pose.position.y, pose.position.z
    message.transform.rotation = pose.orientation
    return message
