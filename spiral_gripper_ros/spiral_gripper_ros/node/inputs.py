# SPDX-License-Identifier: Apache-2.0
"""The node's subscriptions: radii, gravity, measured pressures, keep-alives of the client."""

from __future__ import annotations

import math
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Vector3Stamped
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.subscription import Subscription
from std_msgs.msg import Empty, Float64

from spiral_core.rod.types import Vector
from spiral_gripper_msgs.msg import ObjectRadius
from spiral_gripper_ros.control.radius_gate import STAMPED_RADIUS, age_problem, stale_estimate
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.conversions import frame_problem, stamp_age, vector_from_msg
from spiral_gripper_ros.messages.qos import LATEST, NEWEST
from spiral_gripper_ros.node.transforms import TransformError, Transforms
from spiral_gripper_ros.parameters.spec import gravity_problem
from spiral_gripper_ros.process.guards import log_on_error
from spiral_gripper_ros.runtime.control_clock import STEADY
from spiral_gripper_ros.runtime.guards import vent_on_error
from spiral_gripper_ros.runtime.runtime import Runtime

# How often gravity is computed from the frames of the robot [s].
GRAVITY_PERIOD = 0.04
# How often latched publishers of gravity are looked for [s].
LATCHED_PERIOD = 1.0


class Inputs:
    """Subscribes while the node is configured; the control logic checks every message.

    Args:
        node: the ROS node that subscribes.
        runtime: the gripper.
    """

    def __init__(self, node: Node, runtime: Runtime) -> None:
        self._node = node
        self._runtime = runtime
        self._has_latched = False
        self._transforms = Transforms(node, runtime.values.frame_id)
        gravity_frame = runtime.values.gravity.frame
        if gravity_frame:
            self._transforms.listen()
        self.hear_object_pose = log_on_error(runtime.errors, self._hear_object_pose)
        self._subscriptions: list[Subscription] = []
        for kind, topic, callback in (
            (Float64, "object_radius", self.hear_radius),
            (ObjectRadius, STAMPED_RADIUS, self.hear_stamped_radius),
            (Float64, "measured_pressure", self.hear_measured),
            (PoseStamped, "object_pose", self.hear_object_pose),
            (Empty, "keep_alive", self.hear_client),
        ):
            self._subscribe(kind, topic, callback, NEWEST)
        if gravity_frame:
            look, period = vent_on_error(runtime, self.look_up_gravity), GRAVITY_PERIOD
        else:
            self._subscribe(Vector3Stamped, "gravity", self.hear_gravity, NEWEST)
            look, period = log_on_error(runtime.errors, self.hear_latched_gravity), LATCHED_PERIOD
        self._timer = node.create_timer(period, look, clock=STEADY)
        look()

    def destroy(self) -> None:
        """End all subscriptions."""
        self._node.destroy_timer(self._timer)
        self._transforms.destroy()
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)

    def hear_latched_gravity(self) -> None:
        """Subscribe to latched gravity, once there is a publisher of it.

        With any other publisher such a subscription mismatches, and both sides warn.
        """
        publishers = self._node.get_publishers_info_by_topic("gravity")
        latched = DurabilityPolicy.TRANSIENT_LOCAL
        if not self._has_latched and any(p.qos_profile.durability == latched for p in publishers):
            self._has_latched = True
            self._subscribe(Vector3Stamped, "gravity", self.hear_gravity, LATEST)

    def _subscribe(self, kind: Any, topic: str, callback: Any, qos: QoSProfile) -> None:  # noqa: ANN401
        callback = vent_on_error(self._runtime, callback)
        self._subscriptions.append(self._node.create_subscription(kind, topic, callback, qos))

    def hear_radius(self, message: Float64) -> None:
        """Follow a radius [m] if it is accepted; its pressure is published at once."""
        runtime = self._runtime
        if runtime.loaded is None or not runtime.is_active:
            return
        now = runtime.now()
        if runtime.control.offer_radius(now, message.data, runtime.loaded.planner):
            runtime.command(now)
            # The next radius must not wait for the rest: that follows with the next tick, which a
            # simulated clock may never let come.
            if runtime.clock.is_simulated:
                runtime.tell(now)

    def hear_stamped_radius(self, message: ObjectRadius) -> None:
        """Follow a radius [m] if its stamp is young enough."""
        runtime = self._runtime
        if not runtime.is_active:
            return
        limit = runtime.values.radius.age_limit
        refusal = stale_estimate(self._age(message.header.stamp), limit)
        if refusal is None:
            self.hear_radius(Float64(data=message.radius))
        else:
            runtime.control.refuse(refusal)

    def hear_measured(self, message: Float64) -> None:
        """Compare a measured gauge pressure [Pa] with what is commanded."""
        if self._runtime.is_active:
            self._runtime.control.offer_measured(self._runtime.now(), message.data)

    def hear_gravity(self, message: Vector3Stamped) -> None:
        """Take a new gravity [m/s^2]; plans and shapes are solved again."""
        problem = frame_problem("gravity", message, self._runtime.values.frame_id)
        self._take_gravity(vector_from_msg(message.vector), message.header.stamp, problem)

    def look_up_gravity(self) -> None:
        """Take the gravity that the frames of the robot tell, as strong as described."""
        runtime = self._runtime
        if runtime.loaded is None:
            return
        strength = math.hypot(*runtime.loaded.gripper.gravity)
        try:
            down, stamp = self._transforms.down(runtime.values.gravity.frame)
        except TransformError as error:
            self._take_gravity(runtime.loaded.gripper.gravity, Time(), str(error))
        else:
            x, y, z = down
            self._take_gravity((strength * x, strength * y, strength * z), stamp, None)

    def _take_gravity(self, gravity: Vector, stamp: Any, problem: str | None) -> None:  # noqa: ANN401
        runtime, limit = self._runtime, "radius.age_limit"
        if runtime.loaded is None:
            return
        age = 0.0 if stamp == Time() else self._age(stamp)
        problem = (
            problem
            or gravity_problem(gravity)
            or age_problem("gravity", min(age, 0.0), limit, runtime.values.radius.age_limit)
        )
        if problem:
            runtime.control.refuse(Refusal(Reason.GRAVITY_INVALID, problem))
            return
        runtime.control.hear_gravity(runtime.now(), age)
        runtime.gravity = gravity
        runtime.loaded.want(gravity, runtime.values.gravity.hysteresis)

    def _hear_object_pose(self, message: PoseStamped) -> None:
        """Note where the object is; what is commanded does not depend on it."""
        runtime = self._runtime
        if not runtime.is_active:
            return
        header, turn = message.header, message.pose.orientation
        center = vector_from_msg(message.pose.position)
        quaternion = (turn.x, turn.y, turn.z, turn.w)
        if header.frame_id not in ("", runtime.values.frame_id):
            try:
                center, quaternion = self._transforms.pose(
                    header.frame_id, header.stamp, center, quaternion
                )
            except TransformError as error:
                runtime.objects.refuse(f"object_pose: {error}")
                return
        age = self._age(header.stamp)
        runtime.objects.offer(
            center,
            quaternion,
            seen_at=runtime.now() - age,
            age=age,
            limit=runtime.values.object_pose.timeout,
        )

    def _age(self, stamp: Any) -> float:  # noqa: ANN401
        return stamp_age(stamp, self._node.get_clock())

    def hear_client(self, message: Empty) -> None:
        """Note a keep-alive of the client."""
        del message
        if self._runtime.is_active:
            self._runtime.control.keep_alive(self._runtime.now())
