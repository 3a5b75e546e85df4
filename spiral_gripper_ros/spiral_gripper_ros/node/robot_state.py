# SPDX-License-Identifier: Apache-2.0
"""Frames of tip and object, the object's pose and the joint's position, for the rest of a robot."""

from __future__ import annotations

import importlib
from typing import Any

from geometry_msgs.msg import PoseStamped, TransformStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState

from spiral_gripper_ros.messages.conversions import (
    filled,
    opening_joint,
    pose_along,
    pose_of,
    prefix_of,
)
from spiral_gripper_ros.planning.loaded_gripper import place_of, tube_at
from spiral_gripper_ros.process.guards import log_on_error
from spiral_gripper_ros.runtime.repetition import Repetition
from spiral_gripper_ros.runtime.runtime import Runtime


class RobotState:
    """Publishes at ``publish.robot_state_rate`` while the node is active; at 0 Hz nothing.

    ``/tf`` needs tf2_msgs: without it the frames are left out.

    Args:
        node: the ROS node that publishes.
        runtime: the gripper whose state is published.
    """

    def __init__(self, node: Node, runtime: Runtime) -> None:
        self._node, self._runtime = node, runtime
        self._publishers: dict[str, Any] = {}
        self._frames: Any = None
        self._told = Repetition(node, log_on_error(runtime.errors, self.tell))
        self.stop = self._told.stop

    def start(self) -> None:
        """Publish from now on, at the present rate."""
        rate = self._runtime.values.publish.robot_state_rate
        if rate > 0.0:
            self._connect()
        self._told.start(rate, self._runtime.clock.clock)

    def _connect(self) -> None:
        if self._publishers:
            return
        node = self._node
        self._publishers["joint"] = node.create_publisher(JointState, "joint_states", 10)
        self._publishers["object"] = node.create_publisher(PoseStamped, "wrapped_object_pose", 10)
        try:
            frames = importlib.import_module("tf2_msgs.msg").TFMessage
            self._publishers["frames"] = node.create_publisher(frames, "/tf", 100)
            self._frames = frames
        except Exception as error:  # not installed, or built for another Python
            node.get_logger().info(f"/tf is not published, tf2_msgs cannot be used: {error}")

    def tell(self) -> None:
        """Publish the frames, the pose and the position once."""
        runtime, loaded = self._runtime, self._runtime.loaded
        if loaded is None:
            return
        header, snapshot, poses = runtime.outputs.header(), runtime.control.snapshot(), {}
        seen = runtime.seen_object()
        curve = loaded.curve(snapshot.radius, seen)
        present = loaded.commanded if loaded.measured.shape is None else loaded.measured
        shape = tube_at(curve, present.pressure, present.shape)
        if shape is not None:
            tip, turn = shape.positions[-1], shape.orientations[-1]
            poses["tip"] = pose_of(tip.tolist(), turn.tolist())
        placement = place_of(snapshot.placement, curve, seen)
        if placement is not None:
            poses["object"] = pose_along(placement)
            self._publishers["object"].publish(PoseStamped(header=header, pose=poses["object"]))
        position = runtime.diameter()
        name = opening_joint(header.frame_id)
        state = JointState(header=header, name=[name], position=[position])
        self._publishers["joint"].publish(state)
        if self._frames is not None:
            transforms = []
            for name, pose in poses.items():
                child = f"{prefix_of(header.frame_id)}gripper_{name}"
                moved = TransformStamped(header=header, child_frame_id=child)
                filled(moved.transform.translation, pose.position)
                moved.transform.rotation = pose.orientation
                transforms.append(moved)
            self._publishers["frames"].publish(self._frames(transforms=transforms))
