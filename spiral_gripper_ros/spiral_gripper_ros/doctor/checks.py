# SPDX-License-Identifier: Apache-2.0
"""The doctor's table of ROS 2: ``spiral-gripper doctor`` finds it where the node is installed.

The order matters: what only reads files and variables comes first, because loading ROS ends the
process where they are wrong.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from spiral_gripper.doctor.checks import Check, Facts, Finding, Mark
from spiral_gripper_ros.doctor.domain import check_discovery, check_domain
from spiral_gripper_ros.doctor.environment import (
    check_distribution,
    check_middleware_name,
    check_start,
)
from spiral_gripper_ros.doctor.interfaces import check_interfaces
from spiral_gripper_ros.doctor.memory import check_leftovers, check_room
from spiral_gripper_ros.doctor.security import check_security

SECTION = "ROS 2"
_LOADS = ("ros.distribution", "ros.workspaces", "ros.middleware", "ros.domain")
_STARTS = (*_LOADS, "ros.rclpy", "ros.security")
_WORKS = (*_STARTS, "ros.node")


def checks(facts: Facts) -> tuple[Check, ...]:
    """Return the checks of this table, the same for all facts."""
    del facts
    transport, graph = "transport", "graph"
    return (
        Check("ros.distribution", "distribution", check_distribution),
        Check("ros.workspaces", "workspaces", check_start),
        Check("ros.middleware", "middleware", check_middleware_name),
        Check("ros.domain", "domain", check_domain),
        Check("ros.discovery", "discovery", check_discovery),
        Check("ros.security", "security", check_security),
        Check("ros.shared_memory", "shared memory", check_room),
        Check("ros.leftovers", "leftovers", check_leftovers),
        Check("ros.rclpy", "rclpy", check_rclpy, _LOADS),
        Check("ros.interfaces", "interfaces", check_interfaces, _LOADS),
        Check("ros.node", "node", _later(transport, "check_middleware"), _STARTS),
        Check(
            "ros.two_processes", "two processes", _later(transport, "check_two_processes"), _WORKS
        ),
        Check("ros.grippers", "grippers", _later(graph, "check_grippers"), _WORKS),
    )


def check_rclpy(facts: Facts) -> Finding:
    """Check whether rclpy can be imported."""
    rclpy = import_module("rclpy")
    version = facts.distributions.get("rclpy", "of unknown version")
    return Finding(Mark.OK, f"{version}, from {next(iter(rclpy.__path__))}")


def _later(module: str, name: str) -> Callable[[Facts], Finding]:
    """Return a check whose module loads ROS, and is therefore imported when it runs."""

    def run(facts: Facts) -> Finding:
        check: Callable[[Facts], Finding] = getattr(
            import_module(f"spiral_gripper_ros.doctor.{module}"), name
        )
        return check(facts)

    return run
