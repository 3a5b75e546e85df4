# SPDX-License-Identifier: Apache-2.0
"""``spiral-gripper inject``: sets the fault of a running simulation, without ros2cli."""

from __future__ import annotations

import os
import sys

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger

from spiral_gripper_ros.simulation.regulator import Fault
from spiral_gripper_ros.simulation.regulator_node import REGULATOR_NODE, injection_service

DISCOVERY_TIMEOUT = 5.0
NOT_FOUND = 2


def local_discovery() -> None:
    """Keep to this machine, unless the environment says otherwise."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")


def injection_name(namespace: str, fault: Fault) -> str:
    """Return the full name of the service that sets a fault."""
    space = namespace.strip("/")
    return f"{'/' if space else ''}{space}/{REGULATOR_NODE}/{injection_service(fault)}"


def inject(namespace: str, fault: str) -> int:
    """Set the fault of the simulation in a namespace; return the process's exit code."""
    local_discovery()
    name = injection_name(namespace, Fault(fault))
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node, executor = rclpy.create_node("spiral_gripper_injection"), SingleThreadedExecutor()
    executor.add_node(node)
    try:
        client = node.create_client(Trigger, name)
        if not client.wait_for_service(DISCOVERY_TIMEOUT):
            sys.stderr.write(f"spiral-gripper: no simulation answers at {name}\n")
            return NOT_FOUND
        future = client.call_async(Trigger.Request())
        executor.spin_until_future_complete(future, DISCOVERY_TIMEOUT)
        answer = future.result()
        if answer is None or not answer.success:
            sys.stderr.write(f"spiral-gripper: {name} did not set the fault\n")
            return NOT_FOUND
        sys.stdout.write(f"{answer.message}\n")
        return 0
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()
