# SPDX-License-Identifier: Apache-2.0
"""A regulator whose driver is a ROS node with topics of its own."""

from __future__ import annotations

from typing import Any

from builtin_interfaces.msg import Time
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.control.radius_gate import age_problem
from spiral_gripper_ros.messages.conversions import stamp_age
from spiral_gripper_ros.messages.qos import UNLATCHED
from spiral_gripper_ros.regulators.device import LinkError, Reading
from spiral_gripper_ros.regulators.message_field import MessageField, message_type
from spiral_gripper_ros.regulators.parameters import NONE, RegulatorParameters
from spiral_gripper_ros.regulators.pressure_scale import PressureScale

# How long a set-point may take to be acknowledged before the topic is closed [s].
ACKNOWLEDGE_TIMEOUT = 0.5


class TopicDevice:
    """Publishes set-points for a driver, and hears what it measures.

    Args:
        node: publishes and subscribes.
        values: names and types of the topics, and where their numbers are.

    Raises:
        InvalidInputError: a type is not installed, or has no such number.
    """

    def __init__(self, node: Node, values: RegulatorParameters) -> None:
        self._node, self._oldest = node, values.watchdog_timeout
        # Other elements of an array hold it.
        self._vented = PressureScale(values, "command").to_device(0.0)
        kind = message_type("command_type", values.command_type)
        self._command = MessageField(
            "command_field", kind, values.command_field, values.command_length
        )
        self._publisher = node.create_publisher(kind, values.command_topic, UNLATCHED)
        if self._publisher.topic_name == node.resolve_topic_name("pressure_command"):
            requirement = "another topic than pressure_command, which the adapter hears"
            raise InvalidInputError("command_topic", values.command_topic, requirement)
        self._reading = Reading()
        if values.measured_topic != NONE:
            heard, own = map(node.resolve_topic_name, (values.measured_topic, "measured_pressure"))
            if heard == own:
                requirement = f"another topic than {own}, which the adapter publishes"
                raise InvalidInputError("measured_topic", values.measured_topic, requirement)
            kind = message_type("measured_type", values.measured_type)
            self._measured = MessageField("measured_field", kind, values.measured_field)
            node.create_subscription(
                kind, values.measured_topic, self._on_measured, qos_profile_sensor_data
            )

    def exchange(self, number: float) -> Reading:
        """Publish a set-point; return what has come since the last call.

        A measurement that comes without a driver is dropped: it is none of the next driver's. What
        was wrong with the last one stands until another comes.
        """
        reading = self._reading
        self._reading = Reading(problem=reading.problem)
        message = self._command.message(number, self._vented)
        if hasattr(message, "header"):
            message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
        if self._publisher.get_subscription_count() == 0:
            raise LinkError(f"nobody subscribes to {self._publisher.topic_name}")
        return reading

    def close(self) -> None:
        """Wait until the last set-point has arrived."""
        self._publisher.wait_for_all_acked(Duration(seconds=ACKNOWLEDGE_TIMEOUT))

    def _on_measured(self, message: Any) -> None:  # noqa: ANN401
        try:
            number = self._measured.number(message)
        except (LookupError, TypeError, ValueError) as error:
            self._reading = Reading(problem=f"measured_field: {error}")
            return
        stamp, problem = getattr(getattr(message, "header", None), "stamp", Time()), ""
        if stamp != Time():  # else it has none
            age = stamp_age(stamp, self._node.get_clock())
            problem = age_problem("the measured pressure", age, "watchdog_timeout", self._oldest)
        self._reading = Reading(problem=problem) if problem else Reading(number)
