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


def full(kind, folder):
    return f"{kind.__module__.partition('.')[0]}/{folder}/{kind.__name__}"


def found_of(node):
    """Return a line for each topic, service and action of the node, with types and qualities."""
    ends = [("publishes", one) for one in node.publishers]
    ends += [("subscribes", one) for one in node.subscriptions]
    lines = [
        f"{what} {end.topic_name} {full(end.msg_type, 'msg')} {quality(end.qos_profile)} "
        f"depth {end.qos_profile.depth}"
        for what, end in ends
    ]
    services = [(one.srv_name, full(one.srv_type, "srv")) for one in node.services]
    lines += [f"serves {name} {kind}" for name, kind in services]
    home = node.get_namespace()
    actions = get_action_server_names_and_types_by_node(node, NODE, home)
    lines += [f"acts {name} {kind}" for name, (kind,) in actions]
    own = [line for line in lines if not NOT_OURS.search(line) and "/_action/" not in line]
    return sorted(line.replace(f"{home}/", "") for line in own)


def definitions():
    """Return every message, service and action, without comments."""
    for path in sorted(MESSAGES.glob("*/*.[ams][crs][tgv]*")):
        text = path.read_text(encoding="utf-8")
        lines = (" ".join(line.partition("#")[0].split()) for line in text.splitlines())
        yield "\n".join([f"{path.parent.name}/{path.name}", *(f"  {x}" for x in lines if x)])


def parameters_of(node):
    """Return a line for each parameter, with what it may be as the node declares it."""
    for spec in PARAMETERS:
        found = node.describe_parameter(spec.name)
        assert found.description == spec.description
        spans = [*found.floating_point_range, *found.integer_range]
        spans = [f"{one.from_value:g} to {one.to_value:g}" for one in spans]
        words = ["parameter", spec.name, type(spec.default).__name__, repr(spec.default), *spans]
        yield " ".join(
            [*words, found.additional_constraints, "read-only" * found.read_only]
        ).strip()


def test_the_interfaces_are_those_on_record(node):
    found = "\n".join([*found_of(node), *parameters_of(node), "", *definitions(), ""])
    if os.environ.get("RECORD_INTERFACES"):
        RECORD.write_text(found, encoding="utf-8")
    assert found == RECORD.read_text(encoding="utf-8")
