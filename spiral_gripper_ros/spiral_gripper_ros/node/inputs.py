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

from spiral_core.errors import InvalidInputError
from spiral_core.rod.types import Vector
from spiral_gripper_msgs.msg import ObjectRadius
from spiral_gripper_ros.control.radius_gate import age_problem
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.conversions import (
    line_from_msg,
    stamp_age,
    vector_from_msg,
)
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
        self._node, self._runtime = node, runtime
        self._has_latched = False
        self._transforms = Transforms(node, runtime.values.frame_id)
        self._subscriptions: list[Subscription] = []
        if runtime.values.gravity.frame:
            self._transforms.listen()  # raises before there is anything to be destroyed
        self._subscribe(Float64, "object_radius", self.hear_radius)
        self._subscribe(ObjectRadius, "object_radius_stamped", self.hear_stamped_radius)
        self._subscribe(Float64, "measured_pressure", self.hear_measured)
        self._subscribe(PoseStamped, "object_pose", log_on_error(runtime.errors, self.hear_pose))
        self._subscribe(Empty, "keep_alive", self.hear_client)
        if runtime.values.gravity.frame:
            look, period = vent_on_error(runtime, self.look_up_gravity), GRAVITY_PERIOD
        else:
            self._subscribe(Vector3Stamped, "gravity", self.hear_gravity)
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

    def _subscribe(
        self,
        kind: Any,  # noqa: ANN401
        topic: str,
        callback: Any,  # noqa: ANN401
        qos: QoSProfile = NEWEST,
    ) -> None:
        callback = vent_on_error(self._runtime, callback)
        self._subscriptions.append(self._node.create_subscription(kind, topic, callback, qos))

    def hear_radius(self, message: Float64) -> None:
        """Follow a radius [m] if it is accepted; its pressure is published at once."""
        runtime = self._runtime
        if runtime.loaded is None or not runtime.is_active:
            return
        now = runtime.now()
        if runtime.control.offer_radius(now, message.data, runtime.loaded.planner):
            if now > runtime.commanded_at:  # a simulated clock may stand still
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
        age, limit = self._age(message.header.stamp), runtime.values.radius.age_limit
        problem = age_problem("object_radius_stamped", age, "radius.age_limit", limit)
        if problem:
            runtime.control.refuse(Refusal(Reason.RADIUS_STALE, problem))
        else:
            self.hear_radius(Float64(data=message.radius))

    def hear_measured(self, message: Float64) -> None:
        """Compare a measured gauge pressure [Pa] with what is commanded."""
        if self._runtime.is_active:
            self._runtime.control.offer_measured(self._runtime.now(), message.data)

    def hear_gravity(self, message: Vector3Stamped) -> None:
        """Take a new gravity [m/s^2]; plans and shapes are solved again."""
        own, given, problem = self._runtime.values.frame_id, message.header.frame_id, None
        if given not in ("", own):
            problem = (
                f"gravity must be given in the frame {own!r} (or an unnamed one), got {given!r}"
            )
        self._take_gravity(vector_from_msg(message.vector), message.header.stamp, problem)

    def look_up_gravity(self) -> None:
        """Take the gravity that the frames of the robot tell, as strong as described."""
        runtime = self._runtime
        if runtime.loaded is None:
            return
        strength = math.hypot(*runtime.loaded.gripper.gravity)
        try:
            (x, y, z), stamp = self._transforms.down(runtime.values.gravity.frame)
        except TransformError as error:
            runtime.control.refuse(Refusal(Reason.GRAVITY_INVALID, str(error)))
        else:
            self._take_gravity((strength * x, strength * y, strength * z), stamp, None)

    def _take_gravity(self, gravity: Vector, stamp: Any, problem: str | None) -> None:  # noqa: ANN401
        runtime = self._runtime
        if runtime.loaded is None:
            return
        age = 0.0 if stamp == Time() else self._age(stamp)
        limit = "radius.age_limit", runtime.values.radius.age_limit
        problem = (
            problem or gravity_problem(gravity) or age_problem("gravity", min(age, 0.0), *limit)
        )
        if problem:
            runtime.control.refuse(Refusal(Reason.GRAVITY_INVALID, problem))
            return
        runtime.control.hear_gravity(runtime.now(), age)
        runtime.gravity = gravity
        runtime.loaded.want(gravity, runtime.values.gravity.hysteresis)

    def hear_pose(self, message: PoseStamped) -> None:
        """Note where the object is; what is commanded does not depend on it."""
        runtime, header, objects = self._runtime, message.header, self._runtime.objects
        if not runtime.is_active:
            return
        try:
            line = line_from_msg(message.pose)
            if header.frame_id not in ("", runtime.values.frame_id):
                line = self._transforms.line(header.frame_id, header.stamp, *line)
        except InvalidInputError as error:
            objects.refuse(str(error))
        except TransformError as error:
            objects.refuse(f"object_pose: {error}")
        else:
            age, limit = self._age(header.stamp), runtime.values.object_pose.timeout
            objects.offer(*line, runtime.now() - age, age, limit)

    def _age(self, stamp: Any) -> float:  # noqa: ANN401
        return stamp_age(stamp, self._node.get_clock())

    def hear_client(self, message: Empty) -> None:
        """Note a keep-alive of the client."""
        del message
        if self._runtime.is_active:
            self._runtime.control.keep_alive(self._runtime.now())
