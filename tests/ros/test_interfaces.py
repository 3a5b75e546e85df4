# SPDX-License-Identifier: Apache-2.0
"""Interfaces and parameters are those on record (see records.py): clients depend on them."""

import re
from pathlib import Path

import pytest
from rclpy.action import get_action_server_names_and_types_by_node
from rclpy.qos import LivelinessPolicy
from ros.records import agrees

from spiral_gripper_ros.node.main import main as of_node
from spiral_gripper_ros.parameters.table import GripperParameters
from spiral_gripper_ros.regulators.main import main as of_adapter
from spiral_gripper_ros.regulators.parameters import RegulatorParameters
from spiral_gripper_ros.regulators.regulator_node import RegulatorNode
from spiral_gripper_ros.simulation.main import main as of_simulator
from spiral_gripper_ros.simulation.radius_estimator import RadiusParameters
from spiral_gripper_ros.simulation.regulator import SimulatedRegulatorParameters
from spiral_gripper_ros.simulation.simulator import Simulator

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
    lines += [
        f"serves {one.srv_name} {full(one.srv_type, 'srv')} depth {one.qos_profile.depth}"
        for one in node.services
    ]
    home = node.get_namespace()
    actions = get_action_server_names_and_types_by_node(node, node.get_name(), home)
    lines += [f"acts {name} {kind}" for name, (kind,) in actions]
    own = [line for line in lines if not NOT_OURS.search(line) and "/_action/" not in line]
    return sorted(line.replace(f"{home}/", "") for line in own)


def definitions():
    """Return every message, service and action, without comments."""
    for path in sorted(MESSAGES.glob("*/*.[ams][crs][tgv]*")):
        text = path.read_text(encoding="utf-8")
        lines = (" ".join(line.partition("#")[0].split()) for line in text.splitlines())
        yield "\n".join([f"{path.parent.name}/{path.name}", *(f"  {x}" for x in lines if x)])


def parameters_of(node, specs):
    """Return a line for each parameter, with what it may be as the node declares it."""
    for spec in specs:
        found = node.describe_parameter(spec.name)
        spans = [*found.floating_point_range, *found.integer_range]
        spans = [f"{one.from_value:g} to {one.to_value:g}" for one in spans]
        words = ["parameter", spec.name, type(spec.default).__name__, repr(spec.default), *spans]
        words += [found.additional_constraints, "read-only" * found.read_only, found.description]
        yield " ".join(filter(None, words))


KINDS = GripperParameters, RegulatorParameters, SimulatedRegulatorParameters, RadiusParameters


@pytest.mark.parametrize(
    ("main", "kinds"), [(of_node, KINDS[:1]), (of_adapter, KINDS[1:2]), (of_simulator, KINDS[2:])]
)
def test_help_names_every_parameter_and_starts_no_node(main, kinds, capsys):
    assert main(["--help"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("usage: spiral_gripper_")
    specs = [spec for kind in kinds for spec in kind.specs()]
    assert all(f"\n  {spec.name} (" in said and spec.span in said for spec in specs)


def test_interfaces_and_parameters_are_those_on_record(node, namespace):
    others = Simulator(namespace=namespace).nodes
    nodes = node, RegulatorNode(namespace=namespace), *others
    lines = []
    for one, kind in zip(nodes, KINDS, strict=True):
        lines += [one.get_name(), *found_of(one), *parameters_of(one, kind.specs())]
    agrees("interfaces", "\n".join([*lines, "", *definitions(), ""]))
    for one in nodes[1:]:
        one.destroy_node()
