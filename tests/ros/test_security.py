# SPDX-License-Identifier: Apache-2.0
"""The SROS2 policies against what the nodes really do: nothing is missing, nothing too much."""

import contextlib
import re
import socket
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
from ros.harness import NODE, RunningNode
from ros.simulation_harness import RunningSimulator

from spiral_gripper_ros.client import SpiralGripper
from spiral_gripper_ros.process.node_process import NodeProcess
from spiral_gripper_ros.simulation.regulator_node import REGULATOR_NODE
from spiral_gripper_ros.simulation.simulator import RADIUS_NODE

PAGE = Path(__file__).parents[2] / "docs" / "security.md"
LOOPBACK = POLICY.with_name("loopback.xml")
MULTICAST = "239.255.0.1"
# With it a node listens to /clock, as the policy lets every node.
SIM_TIME = {"use_sim_time": True}


@pytest.mark.parametrize(
    ("enclave", "process", "parameters", "names"),
    [
        # It publishes all it can, but for /tf: tf2_msgs and tf2_ros are not on PyPI.
        ("gripper", RunningNode, {"publish.robot_state_rate": 10.0}, [NODE]),
        ("simulator", RunningSimulator, {"publish_clock": True}, [REGULATOR_NODE, RADIUS_NODE]),
    ],
)
def test_an_enclave_may_do_what_its_nodes_do_and_nothing_else(
    namespace, client, enclave, process, parameters, names
):
    frames = {("publish", "/tf"), ("subscribe", "/tf"), ("subscribe", "/tf_static")}
    granted = rights_by_enclave(namespace)[enclave]
    assert enclave != "gripper" or frames <= granted
    expected = granted - frames
    # Of those of control_msgs, only what is installed is offered.
    for name in ("gripper_cmd", "parallel_gripper_cmd"):
        expected -= action_rights("execute", f"{namespace}/{name}")
    assert profiles(enclave) == names
    with process(namespace, SIM_TIME | parameters):
        client.wait_until(lambda: used_rights(client, *names) >= expected, "all rights")
        assert used_rights(client, *names) == expected


def test_a_python_program_may_do_what_its_client_does(namespace, client):
    granted = rights_by_enclave(namespace)["commander"]
    calls = action_rights("call", f"{namespace}/grasp")

    def used():
        names = client.get_node_names_and_namespaces()
        others = {name for name, of in names if of == namespace} - {client.get_name()}
        return used_rights(client, *others)

    with SpiralGripper(namespace):
        client.wait_until(lambda: calls < used() and len(used()) > 10, "all rights")
        assert all(permits(granted, right) for right in used())


def test_a_node_of_rclpy_may_start_in_each_enclave(namespace, client):
    node = Node(
        "any", namespace=namespace, parameter_overrides=[Parameter("use_sim_time", value=True)]
    )
    client.wait_until(
        lambda: (
            ("subscribe", "/clock") in used_rights(client, "any")
            and len(used_rights(client, "any")) > 8
        ),
        "all rights",
    )
    used = used_rights(client, "any")
    node.destroy_node()
    for enclave, granted in rights_by_enclave(namespace).items():
        name = profiles(enclave)[0]
        assert {(kind, topic.replace("/any/", f"/{name}/")) for kind, topic in used} <= granted


MOVERS = {
    ("publish", "/pressure_command"): {"gripper"},
    ("publish", "/measured_pressure"): {"regulator", "simulator"},
    ("publish", "/object_pose"): {"perception"},
    ("publish", "/gravity"): {"arm"},
    ("request", "/vent"): {"commander", "operator"},
    ("request", "/release/_action/send_goal"): {"commander", "operator"},
    ("request", "/grasp/_action/send_goal"): {"commander"},
    ("request", "/spiral_gripper/set_parameters"): {"operator"},
    ("request", "/spiral_gripper/change_state"): {"operator"},
    ("reply", "/vent"): {"gripper"},
}


def test_who_may_do_what_by_the_policies():
    everyone = rights_by_enclave()
    for right, enclaves in MOVERS.items():
        assert {name for name, rights in everyone.items() if permits(rights, right)} == enclaves
    by_kind = {
        kind: {name for rights in everyone.values() for right, name in rights if right == kind}
        for kind in ("publish", "subscribe", "reply", "request")
    }
    # Nothing is asked for that neither we nor the rest of the robot offer, and no wildcard stands
    # for anything of the gripper.
    assert by_kind["request"] <= by_kind["reply"]
    assert by_kind["subscribe"] <= by_kind["publish"] | {"/tf_static"}
    wild = {right for rights in everyone.values() for right in rights if "*" in right[1]}
    assert {kind for kind, _ in wild} == {"reply"}
    plain = set().union(*everyone.values()) - wild
    assert not [right for right in plain if permits(wild, right)]
    # The monitor only listens, to all but feedback and events.
    written = {right for right in everyone["monitor"] if right[0] in ("publish", "request")}
    assert written == {("publish", "/rosout"), ("publish", "/parameter_events")}
    unheard = {
        name
        for kind, name in everyone["gripper"]
        if kind == "publish" and ("subscribe", name) not in everyone["monitor"]
    }
    others = ("/transition_event", "/feedback", "/_action/status")
    assert all(name.endswith(others) for name in unheard)


def test_hardware_needs_nothing_of_the_simulators_policy_and_the_page_lists_the_enclaves():
    assert set(rights_by_enclave(files=[SIMULATION])) == {"simulator"}
    assert "simulator" not in rights_by_enclave(files=[POLICY])
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
    with RunningNode(namespace, environment=environment) as node:
        client.wait_until(lambda: not node.running, "the end of the node")
        assert node.exit_code != 0
        assert said in node.log()
        assert "Traceback" not in node.log()


def test_the_loopback_profile_binds_no_other_interface(namespace, client):
    environment = {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(LOOPBACK),
    }
    with NodeProcess(namespace, environment=environment) as node:
        client.wait_until_active()
        process, inodes = Path("/proc") / str(node.process_id), set()
        for descriptor in (process / "fd").iterdir():
            with contextlib.suppress(FileNotFoundError):  # closed meanwhile
                inodes.update(re.findall(r"socket:\[(\d+)\]", str(descriptor.readlink())))
        lines = [line.split() for line in (process / "net" / "udp").read_text().splitlines()]
    addresses = {line[1].partition(":")[0] for line in lines if line[9] in inodes}
    bound = {socket.inet_ntoa(bytes.fromhex(address)[::-1]) for address in addresses}
    assert {"127.0.0.1"} <= bound <= {"127.0.0.1", MULTICAST}
