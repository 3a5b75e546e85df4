# SPDX-License-Identifier: Apache-2.0
"""The doctor's check of running grippers: two nodes must not command one valve."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

from spiral_gripper.doctor.checks import Facts, Finding, Mark
from spiral_gripper_ros.doctor.transport import listener

# How long a node of ours must have listened [s]: Fast DDS repeats announcements every 3 s.
LISTENING_TIME = 4.0
COMMAND = "pressure_command"
STATUS_TYPE = "spiral_gripper_msgs/msg/GripStatus"


@dataclass(frozen=True, slots=True)
class Grippers:
    """The gripper nodes on the domain.

    Attributes:
        commanders: nodes that publish a pressure command, by topic.
        nodes: nodes that publish a gripper's status.
    """

    commanders: Mapping[str, tuple[str, ...]]
    nodes: tuple[str, ...]


def check_grippers(facts: Facts) -> Finding:
    """Check which gripper nodes run, and whether two of them command the same valve."""
    return grippers_finding(found_grippers(), facts)


def grippers_finding(found: Grippers, facts: Facts) -> Finding:
    """Judge which nodes run.

    Args:
        found: the nodes.
        facts: the settings that say which nodes can be seen.
    """
    domain = facts.environ.get("ROS_DOMAIN_ID") or "0"
    fights = {topic: names for topic, names in found.commanders.items() if len(names) > 1}
    if fights:
        topic, names = min(fights.items())
        more = f" (and on {len(fights) - 1} other topics)" if len(fights) > 1 else ""
        return Finding(
            Mark.WARNING,
            f"{len(names)} nodes command {topic}: {', '.join(names)}{more}",
            "One that was killed is listed for half a minute more. Else the valve gets both "
            "commands in turn: stop one, or give each gripper its namespace:",
            ("spiral_gripper_node --ros-args -r __ns:=/left",),
        )
    twins = sorted({name for name in found.nodes if found.nodes.count(name) > 1})
    if twins:
        return Finding(
            Mark.WARNING,
            f"several nodes have the name {twins[0]}",
            "Their parameters and services cannot be told apart. Give each its namespace:",
            ("spiral_gripper_node --ros-args -r __ns:=/left",),
        )
    if not found.nodes:
        return Finding(Mark.OK, f"no gripper's node runs on domain {domain}")
    return Finding(Mark.OK, f"on domain {domain}: {', '.join(sorted(found.nodes))}")


def found_grippers() -> Grippers:
    """Return the grippers' nodes that are discovered within :data:`LISTENING_TIME`."""
    own = listener()
    while time.monotonic() < own.since + LISTENING_TIME:
        own.handle(0.1)
    commanders, nodes = {}, []
    for topic, types in own.node.get_topic_names_and_types():
        is_command = topic.rpartition("/")[2] == COMMAND
        if not is_command and STATUS_TYPE not in types:
            continue
        names = [
            f"{found.node_namespace.rstrip('/')}/{found.node_name}"
            for found in own.node.get_publishers_info_by_topic(topic)
        ]
        if is_command:
            commanders[topic] = tuple(sorted(names))
        else:
            nodes += names
    return Grippers(commanders, tuple(nodes))
