# SPDX-License-Identifier: Apache-2.0
"""What the node hears: radii, gravity, measured pressures, and signs of life of its client."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from geometry_msgs.msg import Vector3Stamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.subscription import Subscription
from rclpy.time import Time
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Empty, Float64

from spiral_gripper_msgs.msg import ObjectRadius
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.node.conversions import frame_problem, vector_from_msg
from spiral_gripper_ros.node.guards import vent_on_error
from spiral_gripper_ros.node.parameter_spec import gravity_problem
from spiral_gripper_ros.node.parameters import measured_scale, number
from spiral_gripper_ros.node.qos import LATEST, NEWEST
from spiral_gripper_ros.robot.estimate_age import STAMPED_RADIUS, stale_estimate

if TYPE_CHECKING:
    from spiral_gripper_ros.node.gripper_node import GripperNode


class Inputs:
    """Subscribes while the node is configured; every message is judged by the control logic.

    Args:
        node: the node that hears.
    """

    def __init__(self, node: GripperNode) -> None:
        self._node = node
        self._has_latched = False
        self._subscriptions: list[Subscription] = []
        for kind, topic, callback in (
            (Float64, "object_radius", self.hear_radius),
            (ObjectRadius, STAMPED_RADIUS, self.hear_stamped_radius),
            (Vector3Stamped, "gravity", self.hear_gravity),
            (FluidPressure, "measured_pressure", self.hear_measured),
            (Empty, "keep_alive", self.hear_client),
        ):
            self._subscribe(kind, topic, callback, NEWEST)
        self.hear_latched_gravity()

    def destroy(self) -> None:
        """Hear nothing any more."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)

    def hear_latched_gravity(self) -> None:
        """Hear what was published before, once there is a publisher that keeps it for latecomers.

        To others such a subscription would be a mismatch, of which both sides warn.
        """
        publishers = self._node.get_publishers_info_by_topic("gravity")
        latched = DurabilityPolicy.TRANSIENT_LOCAL
        if not self._has_latched and any(p.qos_profile.durability == latched for p in publishers):
            self._has_latched = True
            self._subscribe(Vector3Stamped, "gravity", self.hear_gravity, LATEST)

    def _subscribe(self, kind: Any, topic: str, callback: Any, qos: QoSProfile) -> None:  # noqa: ANN401
        callback = vent_on_error(self._node, callback)
        self._subscriptions.append(self._node.create_subscription(kind, topic, callback, qos))

    def hear_radius(self, message: Float64) -> None:
        """Follow a radius [m] if it is good; its pressure goes out at once."""
        node = self._node
        if node.loaded is None or not node.is_active:
            return
        now = node.now()
        if node.control.offer_radius(now, message.data, node.loaded.planner):
            node.command(now)
            # The next radius must not wait for the rest: that follows with the next tick, which a
            # simulated clock may never let come.
            if node.time.is_simulated:
                node.tell(now)

    def hear_stamped_radius(self, message: ObjectRadius) -> None:
        """Follow a radius [m] that was seen not too long ago."""
        node = self._node
        if not node.is_active:
            return
        clock = node.get_clock()
        age = clock.now() - Time.from_msg(message.header.stamp, clock_type=clock.clock_type)
        limit = number(node.values, "radius_age_limit")
        refusal = stale_estimate(1.0e-9 * age.nanoseconds, limit)
        if refusal is None:
            self.hear_radius(Float64(data=message.radius))
        else:
            node.control.refuse(refusal)

    def hear_measured(self, message: FluidPressure) -> None:
        """Compare a measured gauge pressure [Pa] with what is commanded."""
        if self._node.is_active:
            pressure = measured_scale(self._node.values).to_gauge(message.fluid_pressure)
            self._node.control.offer_measured(self._node.now(), pressure)

    def hear_gravity(self, message: Vector3Stamped) -> None:
        """Have the shapes solved anew for another gravity [m/s^2]."""
        node = self._node
        if node.loaded is None:
            return
        gravity = vector_from_msg(message.vector)
        problem = frame_problem(
            message.header.frame_id, str(node.values["frame_id"])
        ) or gravity_problem(gravity)
        if problem is not None:
            node.control.refuse(Refusal(Reason.GRAVITY_INVALID, problem))
            return
        if node.is_active:
            node.control.note_gravity(node.now(), is_heard=True)
        node.gravity = gravity
        node.loaded.mount.want(gravity, number(node.values, "gravity_hysteresis"))

    def hear_client(self, message: Empty) -> None:
        """Note a sign of life of the client."""
        del message
        if self._node.is_active:
            self._node.control.keep_alive(self._node.now())
