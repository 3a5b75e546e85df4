# SPDX-License-Identifier: Apache-2.0
"""The node's interfaces are those on record: clients depend on them.

A change on purpose is recorded by RECORD_INTERFACES=1 pytest tests/ros/test_interfaces.py, and told
in CHANGELOG.md.
"""

import os
import re
from pathlib import Path

from rclpy.action import get_action_server_names_and_types_by_node
from rclpy.qos import LivelinessPolicy
from ros.harness import NODE

from spiral_gripper_ros.parameters.table import PARAMETERS

RECORD = Path(__file__).with_name("interfaces.txt")
MESSAGES = Path(__file__).parents[2] / "spiral_gripper_msgs"
# Those of rclpy itself, and of control_msgs, which is there or not.
NOT_OURS = re.compile(r"rcl_interfaces|lifecycle_msgs|type_description|control_msgs|rosgraph_msgs")


def quality(qos):
    words = [qos.reliability.name, qos.durability.name]
    if qos.liveliness is LivelinessPolicy.MANUAL_BY_TOPIC:
        words.append(f"{qos.liveliness.name} {qos.liveliness_lease_duration.nanoseconds / 1e9:g} s")
    return " ".join(words).lower()


def found_of(client, node):
    """Return a line for each topic, service and action of the node, with types and qualities.

    The middleware tells others no depth: that is the one of the same node in this process.
    """
    end = (NODE, client.get_namespace())
    depths = {
        one.topic.strip("/"): one.qos_profile.depth
        for one in (*node.publishers, *node.subscriptions)
    }
    lines = []
    for what, names, ends in (
        ("publishes", client.get_publisher_names_and_types_by_node, "publishers"),
        ("subscribes", client.get_subscriber_names_and_types_by_node, "subscriptions"),
    ):
        for name, (kind,) in names(*end):
            infos = getattr(client, f"get_{ends}_info_by_topic")(name)
            (info,) = [one for one in infos if (one.node_name, one.node_namespace) == end]
            depth = depths.get(name.rpartition("/")[2])
            lines.append(f"{what} {name} {kind} {quality(info.qos_profile)} depth {depth}")
    services = client.get_service_names_and_types_by_node(*end)
    lines += [f"serves {name} {kind}" for name, (kind,) in services]
    actions = get_action_server_names_and_types_by_node(client, *end)
    lines += [f"acts {name} {kind}" for name, (kind,) in actions]
    own = [line for line in lines if not NOT_OURS.search(line) and "/_action/" not in line]
    return sorted(line.replace(f"{end[1]}/", "") for line in own)


def definitions():
    """Return every message, service and action, without comments."""
    for path in sorted(MESSAGES.glob("*/*.[ams][crs][tgv]*")):
        text = path.read_text(encoding="utf-8")
        lines = (" ".join(line.partition("#")[0].split()) for line in text.splitlines())
        yield "\n".join([f"{path.parent.name}/{path.name}", *(f"  {x}" for x in lines if x)])


def test_the_interfaces_are_those_on_record(active, node):
    parameters = [
        f"parameter {one.name} {type(one.default).__name__} {one.default!r} "
        + (" | ".join(one.choices) if one.low is None else f"{one.low:g} to {one.high:g}")
        + " read-only" * one.read_only
        for one in PARAMETERS
    ]
    lines = [line.rstrip() for line in (*found_of(active, node), *parameters)]
    found = "\n".join([*lines, "", *definitions(), ""])
    if os.environ.get("RECORD_INTERFACES"):
        RECORD.write_text(found, encoding="utf-8")
    assert found == RECORD.read_text(encoding="utf-8")
