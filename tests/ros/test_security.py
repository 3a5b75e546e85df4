# SPDX-License-Identifier: Apache-2.0
"""The SROS2 policies against what the nodes really do: nothing is missing, nothing too much."""

import contextlib
import itertools
import re
import socket
import time
from pathlib import Path

import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter
from ros.enclaves import (
    POLICY,
    SIMULATION,
    action_rights,
    permits,
    profiles,
    rights_by_enclave,
    used_rights,
)
from ros.harness import NODE, START_DEADLINE, RunningNode
from ros.simulation_harness import RunningSimulator

from spiral_gripper_ros.client import SpiralGripper
from spiral_gripper_ros.process.node_process import NodeProcess
from spiral_gripper_ros.simulation.radius_node import RADIUS_NODE
from spiral_gripper_ros.simulation.regulator_node import REGULATOR_NODE

PAGE = Path(__file__).parents[2] / "docs" / "security.md"
LOOPBACK = POLICY.with_name("loopback.xml")
MULTICAST = "239.255.0.1"
# With it a node listens to /clock, as the policy lets every node.
SIM_TIME = {"use_sim_time": True}
# It publishes all it can then, but for /tf: tf2_msgs and tf2_ros are not on PyPI.
ALL_OUTPUTS = {"publish.robot_state_rate": 10.0}


def udp_addresses(process_id):
    """Return the addresses that a process receives UDP on."""
    process = Path("/proc") / str(process_id)
    inodes = set()
    for descriptor in (process / "fd").iterdir():
        with contextlib.suppress(FileNotFoundError):  # closed meanwhile
            inodes.update(re.findall(r"socket:\[(\d+)\]", str(descriptor.readlink())))
    lines = [line.split() for line in (process / "net" / "udp").read_text().splitlines()[1:]]
    addresses = {line[1].partition(":")[0] for line in lines if line[9] in inodes}
    return {socket.inet_ntoa(bytes.fromhex(address)[::-1]) for address in addresses}


def compare(client, names, expected, unseen=frozenset()):
    """Wait until nodes do all that is expected of them, and find that they do nothing else."""
    end, used = time.monotonic() + START_DEADLINE, set()
    while not used >= expected and time.monotonic() < end:
        client.spin(0.05)
        used = used_rights(client, *names) | unseen
    assert used == expected


def test_the_gripper_may_do_what_its_node_does_and_nothing_else(namespace, client):
    granted = rights_by_enclave(namespace)["gripper"]
    # Of those of control_msgs, only what is installed is offered.
    names = [f"{namespace}/{name}" for name in ("gripper_cmd", "parallel_gripper_cmd")]
    unseen = set().union(*(action_rights("execute", name) for name in names))
    unseen |= {("publish", "/tf"), ("subscribe", "/tf"), ("subscribe", "/tf_static")}
    assert profiles("gripper") == [NODE]
    with RunningNode(namespace, SIM_TIME | ALL_OUTPUTS):
        compare(client, [NODE], granted, unseen)


def test_the_simulator_may_do_what_its_nodes_do_and_nothing_else(namespace, client):
    granted = rights_by_enclave(namespace)["simulator"]
    names = [REGULATOR_NODE, RADIUS_NODE]
    assert profiles("simulator") == names
    with RunningSimulator(namespace, {**SIM_TIME, "publish_clock": True}):
        compare(client, names, granted)


def test_a_python_program_may_do_what_its_client_does(namespace, client):
    granted = rights_by_enclave(namespace)["commander"]
    with SpiralGripper(namespace) as gripper:
        name = gripper._link.node.get_name()
        calls = action_rights("call", f"{namespace}/grasp")
        client.wait_until(
            lambda: calls < used_rights(client, name) and len(used_rights(client, name)) > 10, name
        )
        used = used_rights(client, name)
    assert not {right for right in used if not permits(granted, right)}


@pytest.mark.parametrize(
    "enclave", ["arm", "commander", "monitor", "operator", "perception", "regulator"]
)
def test_a_node_of_rclpy_may_start_in_each_enclave(namespace, client, enclave):
    granted = rights_by_enclave(namespace)[enclave]
    (name, *_) = profiles(enclave)
    node = Node(
        name, namespace=namespace, parameter_overrides=[Parameter("use_sim_time", value=True)]
    )
    client.wait_until(
        lambda: (
            ("subscribe", "/clock") in used_rights(client, name)
            and len(used_rights(client, name)) > 8
        ),
        name,
    )
    used = used_rights(client, name)
    node.destroy_node()
    assert used <= granted


@pytest.mark.parametrize(
    ("right", "name", "enclaves"),
    [
        ("publish", "/pressure_command", {"gripper"}),
        ("publish", "/measured_pressure", {"regulator", "simulator"}),
        ("publish", "/object_radius", {"perception", "simulator"}),
        ("publish", "/object_pose", {"perception"}),
        ("publish", "/wrapped_object_pose", {"gripper"}),
        ("publish", "/joint_states", {"gripper"}),
        ("publish", "/tf", {"gripper"}),
        ("publish", "/gravity", {"arm"}),
        ("publish", "/clock", {"simulator"}),
        ("request", "/vent", {"commander", "operator"}),
        ("request", "/rearm", {"commander", "operator"}),
        ("request", "/release/_action/send_goal", {"commander", "operator"}),
        ("request", "/grasp/_action/send_goal", {"commander"}),
        ("request", "/spiral_gripper/set_parameters", {"operator"}),
        ("request", "/spiral_gripper/change_state", {"operator"}),
        ("reply", "/vent", {"gripper"}),
    ],
)
def test_who_may_move_the_gripper(right, name, enclaves):
    everyone = rights_by_enclave()
    assert {
        enclave for enclave in everyone if permits(everyone[enclave], (right, name))
    } == enclaves


def test_the_monitor_only_listens():
    everyone = rights_by_enclave()
    written = {right for right in everyone["monitor"] if right[0] in ("publish", "request")}
    assert written == {("publish", "/rosout"), ("publish", "/parameter_events")}
    told = {name for right, name in everyone["gripper"] if right == "publish"}
    heard = {name for right, name in everyone["monitor"] if right == "subscribe"}
    others = ("/transition_event", "/feedback", "/_action/status")  # of the node, of its actions
    assert {name for name in told - heard if not name.endswith(others)} == set()


@pytest.mark.parametrize(("asked", "offered"), [("request", "reply"), ("subscribe", "publish")])
def test_nothing_is_asked_for_that_nobody_offers(asked, offered):
    everyone = set().union(*rights_by_enclave().values())
    without = {name for right, name in everyone if right == asked}
    without -= {name for right, name in everyone if right == offered}
    assert without <= {"/tf_static"}  # which other nodes of the robot publish


def test_a_wildcard_stands_for_nothing_of_the_gripper():
    everyone = set().union(*rights_by_enclave().values())
    wild = {right for right in everyone if "*" in right[1]}
    assert {kind for kind, _ in wild} == {"reply"}
    assert not [
        pair for pair in itertools.product(wild, everyone - wild) if permits(pair[:1], pair[1])
    ]


def test_hardware_needs_nothing_of_the_simulators_policy():
    assert set(rights_by_enclave(files=[SIMULATION])) == {"simulator"}
    assert "simulator" not in rights_by_enclave(files=[POLICY])


def test_the_page_lists_the_enclaves():
    section = PAGE.read_text(encoding="utf-8").split("\n## ")[1]
    listed = re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE)
    assert listed == list(rights_by_enclave())


@pytest.mark.parametrize(
    ("has_folder", "said"), [(False, "gripper' does not exist"), (True, "cannot start: ")]
)
def test_a_node_that_cannot_be_secured_does_not_start(
    namespace, client, tmp_path, has_folder, said
):
    if has_folder:  # without keys; the wheels' Fast DDS has no security at all
        (tmp_path / "enclaves" / "spiral_gripper" / "gripper").mkdir(parents=True)
    environment = {
        "ROS_SECURITY_ENABLE": "true",
        "ROS_SECURITY_STRATEGY": "Enforce",
        "ROS_SECURITY_KEYSTORE": str(tmp_path),
        "ROS_SECURITY_ENCLAVE_OVERRIDE": "/spiral_gripper/gripper",
    }
    with (
        (tmp_path / "log").open("w+") as log,
        NodeProcess(namespace, environment=environment, output=log) as node,
    ):
        client.wait_until(lambda: not node.running, "the end of the node")
        assert node.exit_code != 0
    log = (tmp_path / "log").read_text()
    assert said in log
    assert "Traceback" not in log
    assert not client.pressures


def test_the_loopback_profile_binds_no_other_interface(namespace, client):
    environment = {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(LOOPBACK),
    }
    with NodeProcess(namespace, environment=environment) as node:
        client.wait_until_active()
        bound = udp_addresses(node.process_id)
    assert "127.0.0.1" in bound
    assert bound <= {"127.0.0.1", MULTICAST}
