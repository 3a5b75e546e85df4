# SPDX-License-Identifier: Apache-2.0
"""The SROS2 policies against what the nodes really do: nothing is missing, nothing too much.

A right is a pair of what one may do and the full name of a topic or a service. An action is the
services and topics that it consists of. sros2 turns each right into DDS topics; with its profiles'
names, these are the rules of its schema (version 0.2.0) and of its template for permissions:

- a name that begins with "/" stands as it is, "~" stands for the node's, others follow `ns`;
- all profiles of an enclave are of one process, and its rights are theirs together.
"""

import contextlib
import re
import socket
from fnmatch import fnmatchcase
from pathlib import Path
from xml.etree import ElementTree

import pytest
from rclpy.node import Node
from repo.source_tree import ROOT
from ros.harness import START_DEADLINE, RunningNode
from ros.local_nodes import parameters
from ros.records import agrees

from spiral_gripper_ros.client import SpiralGripper
from spiral_gripper_ros.process.node_process import NODE, SIMULATOR, NodeProcess
from spiral_gripper_ros.regulators.regulator_node import RegulatorNode

SECURITY = ROOT / "spiral_gripper_ros" / "security"
POLICY, SIMULATION = SECURITY / "policy.xml", SECURITY / "simulation.xml"
PREFIX = "/spiral_gripper/"
# What the schema allows: the attributes of an element, and the elements in it.
SCHEMA = {
    "policy": "version enclaves",
    "enclaves": "enclave",
    "enclave": "path profiles",
    "profiles": "profile",
    "profile": "ns node topics services actions",
    "topics": "publish subscribe topic",
    "services": "reply request service",
    "actions": "execute call action",
}
# How looks at the graph call the ends of a right, and what a right on an action consists of.
GRAPH = {
    "publish": "publisher",
    "subscribe": "subscriber",
    "reply": "service",
    "request": "client",
}
ACTIONS = {"execute": ("reply", "publish"), "call": ("request", "subscribe")}
SERVICES, TOPICS = ("send_goal", "cancel_goal", "get_result"), ("feedback", "status")


def action_rights(kind, name):
    """Return the rights that one on an action consists of: ``execute`` or ``call``."""
    return {
        (right, f"{name}/_action/{part}")
        for right, parts in zip(ACTIONS[kind], (SERVICES, TOPICS), strict=True)
        for part in parts
    }


def read(file):
    """Return the profiles of the enclaves of a policy, which is as its schema says."""
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    commented = ElementTree.parse(file, parser).getroot().find("enclaves")
    assert all(type(enclave.tag) is str for enclave in commented), "sros2 takes it for an enclave"
    root = ElementTree.parse(file).getroot()
    assert root.get("version") == "0.2.0"
    for element in root.iter():
        allowed = SCHEMA.get(element.tag, "").split()
        assert {*element.attrib, *(child.tag for child in element)} <= set(allowed), element.tag
        assert allowed or element.text.strip(), f"an empty {element.tag}"
    return {one.get("path").removeprefix(PREFIX): one.find("profiles") for one in root[0]}


def rights_by_enclave(namespace="", files=(POLICY, SIMULATION)):
    """Return the rights of each enclave, by the last part of its path, for a namespace."""
    found = {}
    for enclave, profile in ((e, p) for file in files for e, ps in read(file).items() for p in ps):
        assert profile.get("ns") == "/", "documentation says to replace every ns"
        rights = found.setdefault(enclave, set())
        for group in profile:
            assert set(group.attrib.values()) == {"ALLOW"}, "the default is to deny"
            for kind, entry in ((kind, entry) for kind in group.attrib for entry in group):
                name = entry.text.replace("~", profile.get("node"))
                name = name if name.startswith("/") else f"{namespace}/{name}"
                rights |= action_rights(kind, name) if kind in ACTIONS else {(kind, name)}
    return found


def used_rights(looker):
    """Return what other nodes of the looker's namespace do, as the looker sees it."""
    own, namespace = looker.get_name(), looker.get_namespace()
    known = looker.get_node_names_and_namespaces()
    return {
        (right, topic)
        for name in {name for name, where in known if where == namespace} - {own}
        for right, kind in GRAPH.items()
        for topic, _ in getattr(looker, f"get_{kind}_names_and_types_by_node")(name, namespace)
    }


def permits(granted, right):
    """Return whether rights permit one, wildcards included."""
    return any(right[0] == kind and fnmatchcase(right[1], name) for kind, name in granted)


@pytest.mark.parametrize(
    ("enclave", "module", "given"),
    [
        # It publishes all it can, but for /tf: tf2_msgs and tf2_ros are not on PyPI.
        ("gripper", NODE, {"publish.robot_state_rate": 10.0}),
        ("simulator", SIMULATOR, {"publish_clock": True}),
    ],
)
def test_an_enclave_may_do_what_its_nodes_do_and_nothing_else(
    namespace, client, enclave, module, given
):
    expected = {
        right for right in rights_by_enclave(namespace)[enclave] if not right[1].startswith("/tf")
    }
    # Of those of control_msgs, only what is installed is offered.
    for name in ("gripper_cmd", "parallel_gripper_cmd"):
        expected -= action_rights("execute", f"{namespace}/{name}")
    # With simulated time a node listens to /clock, as the policy lets every node.
    with RunningNode(namespace, {"use_sim_time": True} | given, module=module):
        client.wait_until(lambda: used_rights(client) >= expected, "all rights")
        assert used_rights(client) == expected


@pytest.mark.parametrize("enclave", rights_by_enclave())
def test_a_node_in_an_enclave_may_start_and_the_adapter_do_what_it_does(namespace, client, enclave):
    name = read(SIMULATION if enclave == "simulator" else POLICY)[enclave][0].get("node")
    timed = {"namespace": namespace, "parameter_overrides": parameters(use_sim_time=True)}
    node = RegulatorNode(**timed) if enclave == "regulator" else Node(name, **timed)
    seen = {("subscribe", "/clock"), ("reply", f"{namespace}/{name}/get_type_description")}
    client.wait_until(lambda: used_rights(client) >= seen, "its rights")
    assert used_rights(client) <= rights_by_enclave(namespace)[enclave]
    node.destroy_node()


def test_a_python_program_may_do_what_its_client_does(namespace, client):
    granted = rights_by_enclave(namespace)["commander"]
    calls = action_rights("call", f"{namespace}/grasp")
    with SpiralGripper(namespace):
        client.wait_until(lambda: used_rights(client) > calls, "all rights")
        assert all(permits(granted, right) for right in used_rights(client))


def test_who_may_do_what_by_the_policies_is_on_record():
    everyone = rights_by_enclave()
    granted = set().union(*everyone.values())
    movers = sorted(right for right in granted if right[0] in ("publish", "request"))
    table = {right: [one for one in everyone if permits(everyone[one], right)] for right in movers}
    agrees("rights", "\n".join(f"{' '.join(right)}: {table[right]}" for right in movers))
    by_kind = {kind: {name for right, name in granted if right == kind} for kind in GRAPH}
    # Nothing is asked for that neither we nor the rest of the robot offer, and no wildcard stands
    # for anything of the gripper.
    assert by_kind["request"] <= by_kind["reply"]
    assert by_kind["subscribe"] <= by_kind["publish"] | {"/tf_static"}
    wild = {right for right in granted if "*" in right[1]}
    assert {kind for kind, _ in wild} == {"reply"}
    assert not [right for right in granted - wild if permits(wild, right)]
    # The monitor only listens.
    written = {right for right in everyone["monitor"] if right[0] in ("publish", "request")}
    assert written == {("publish", "/rosout"), ("publish", "/parameter_events")}


def test_hardware_needs_nothing_of_the_simulators_policy_and_the_page_lists_the_enclaves():
    assert list(read(SIMULATION)) == ["simulator"]
    assert "simulator" not in read(POLICY)
    section = (ROOT / "docs/security.md").read_text(encoding="utf-8").split("\n## ")[1]
    listed = re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE)
    assert listed == list(rights_by_enclave())


@pytest.mark.parametrize("said", ["gripper' does not exist", "cannot start: "])
def test_a_node_that_cannot_be_secured_does_not_start(namespace, tmp_path, said):
    enclave = "spiral_gripper/gripper"
    if "start" in said:  # without keys; the wheels' Fast DDS has no security at all
        (tmp_path / "enclaves" / enclave).mkdir(parents=True)
    environment = {
        "ROS_SECURITY_ENABLE": "true",
        "ROS_SECURITY_STRATEGY": "Enforce",
        "ROS_SECURITY_KEYSTORE": str(tmp_path),
        "ROS_SECURITY_ENCLAVE_OVERRIDE": f"/{enclave}",
    }
    with RunningNode(namespace, environment=environment) as node:
        assert node.wait(START_DEADLINE) != 0
        assert said in node.log()
        assert "Traceback" not in node.log()


def test_the_loopback_profile_binds_no_other_interface(namespace, client):
    environment = {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(SECURITY / "loopback.xml"),
    }
    with NodeProcess(namespace, environment=environment) as node:
        client.wait_until_active()
        process, inodes = Path(f"/proc/{node.pid}"), set()
        for descriptor in (process / "fd").iterdir():
            with contextlib.suppress(FileNotFoundError):  # closed meanwhile
                inodes.update(re.findall(r"socket:\[(\d+)\]", str(descriptor.readlink())))
        lines = [line.split() for line in (process / "net" / "udp").read_text().splitlines()]
    addresses = {line[1].partition(":")[0] for line in lines if line[9] in inodes}
    bound = {socket.inet_ntoa(bytes.fromhex(address)[::-1]) for address in addresses}
    assert {"127.0.0.1"} <= bound <= {"127.0.0.1", "239.255.0.1"}  # and multicast
