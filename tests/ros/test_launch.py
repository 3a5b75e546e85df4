# SPDX-License-Identifier: Apache-2.0
"""The launch files, the sample parameters and the RViz configuration fit the nodes that they start.

The launch files are loaded with stand-ins for launch and launch_ros.
"""

import os
import re
from pathlib import Path

import pytest
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy
from repo.source_tree import ROOT, pyproject
from ros import launch_stand_ins
from ros.control_bench import rows
from ros.launch_stand_ins import LifecycleNode, OpaqueFunction, started
from ruamel.yaml import YAML

from spiral_gripper_ros.parameters.table import PARAMETERS, GripperParameters
from spiral_gripper_ros.process.stop_signals import STARTED_BY
from spiral_gripper_ros.simulation.radius_estimator import RadiusParameters
from spiral_gripper_ros.simulation.regulator import SimulatedRegulatorParameters
from spiral_gripper_ros.simulation.simulator import Simulator

PACKAGE = ROOT / "spiral_gripper_ros"
DESCRIPTION, GRIPPER, GRIPPERS, SIMULATION = FILES = tuple(
    PACKAGE / f"launch/{name}.launch.py"
    for name in ("description", "gripper", "grippers", "simulation")
)
SAMPLE = PACKAGE / "config/gripper.yaml"
RVIZ = PACKAGE / "rviz/spiral_gripper.rviz"
SIMULATED = SimulatedRegulatorParameters.specs() + RadiusParameters.specs()
TABLES = {
    program: {spec.name: spec.default for spec in specs}
    for program, specs in (
        ("spiral_gripper_node", PARAMETERS),
        ("spiral_gripper_simulator", SIMULATED),
    )
}
SET = (
    "gripper=prototype_p1 frame_id=tool0 profile=sine radius=0.01 fault=leak "
    "estimate_noise=0.0001 stiffness_factor=1.2 real_time_factor=2"
)
SET = dict(word.split("=") for word in SET.split())


@pytest.fixture(autouse=True)
def stand_ins(monkeypatch):
    launch_stand_ins.install(monkeypatch)


@pytest.fixture
def file(tmp_path):
    file = tmp_path / "mine.yaml"
    file.touch()
    return str(file)


def own_parameters(node):
    """The parameters that a launched node of ours is given, besides files."""
    (values,) = [p for p in node.parameters if isinstance(p, dict)]
    return values


def read_yaml(path):
    return YAML(typ="safe").load(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_argument_is_described_and_every_executable_and_file_installed(file):
    for argument in launch_stand_ins.arguments(file).values():
        assert argument.description, argument.name
        assert argument.default_value is not None, argument.name
    ours = {(node.package, node.executable) for node in started(file)}
    ours -= {("robot_state_publisher", "robot_state_publisher")}
    scripts = pyproject()["tool"]["dynamic-metadata"][0]["ros-scripts"]
    assert ours <= {("spiral_gripper_ros", script) for script in scripts}
    (parts,) = re.findall(r"foreach\(_part (.+?)\)", (ROOT / "packaging/pip.cmake").read_text())
    setup = (PACKAGE / "setup.py").read_text(encoding="utf-8")
    for shipped in (file, SAMPLE, RVIZ):
        folder = shipped.parent.name
        (pattern,) = re.findall(rf'share/{{NAME}}/{folder}", sorted\(glob\("(.+?)"', setup)
        assert shipped in PACKAGE.glob(pattern)
        assert folder in parts.split()


def test_what_is_not_given_is_left_to_the_parameters_file_and_what_is_given_wins():
    (node,) = started(GRIPPER)
    left = {"autostart": True, "exit_with_parent": True, "use_sim_time": False}
    assert own_parameters(node) == left
    assert isinstance(node, LifecycleNode)
    assert node.additional_env == {STARTED_BY: str(os.getpid())}
    given = {"gripper": "prototype_p1", "frame_id": "tool0"}
    (node,) = started(GRIPPER, use_sim_time="true", autostart="false", **given)
    assert own_parameters(node) == {**left, **given, "use_sim_time": True, "autostart": False}
    assert [type(p) for p in node.parameters] == [str, dict]  # what comes last wins
    assert Path(node.parameters[0]).resolve() == SAMPLE


def test_the_simulation_starts_node_and_simulator_in_one_namespace_and_one_time():
    node, simulator = launched = started(SIMULATION, **SET, namespace="/left", use_sim_time="true")
    assert (node.executable, simulator.executable) == tuple(TABLES)
    assert node.namespace == simulator.namespace == "/left"
    for one in launched:
        for name, value in own_parameters(one).items():
            table = TABLES[one.executable] | {"use_sim_time": False}
            assert type(value) is type(table[name]), name
    assert own_parameters(node)["use_sim_time"] is True
    assert own_parameters(node)["gripper"] == "prototype_p1"
    simulated = own_parameters(simulator)
    assert simulated.pop("publish_clock") is True
    assert {name: str(value).removesuffix(".0") for name, value in simulated.items()} == SET
    # One process with two nodes: a name would be given to both.
    assert simulator.name is None


def test_node_and_adapter_have_the_log_level_the_respawn_and_their_files(file):
    given = {"regulator": file, "log_level": "debug", "namespace": "/left"}
    for respawn in ("true", "false"):
        node, adapter = started(GRIPPER, respawn=respawn, **given)
        for one in (node, adapter):
            assert (one.respawn, one.respawn_delay) == (respawn == "true", 2.0)
            assert (one.namespace, one.ros_arguments) == ("/left", ["--log-level", "debug"])
    assert (adapter.executable, adapter.name) == ("spiral_gripper_regulator", "regulator")
    assert adapter.parameters == [file]


# The launch file, what is given, which node ends: what follows.
ENDS = """
gripper 0: LogInfo
gripper required=true 0: LogInfo Shutdown
gripper required=true respawn=true 0: LogInfo
simulation 0: LogInfo Shutdown
simulation 1: Shutdown
"""
BY_NAME = {file.name.split(".")[0]: file for file in FILES}


@pytest.mark.parametrize("row", rows(ENDS))
def test_the_end_of_a_required_process_is_that_of_the_launch(row):
    words, follows = (part.split() for part in row.split(": "))
    given = dict(word.split("=") for word in words[1:-1])
    node = started(BY_NAME[words[0]], **given)[int(words[-1])]
    (handler,) = node.on_exit
    assert [type(action).__name__ for action in handler.function(node.context)] == follows
    node.context.is_shutdown = True
    assert handler.function(node.context) == []


REFUSED = """
gripper parameters /nothing: a file
gripper regulator /nothing: a file
description model /nothing: a file
simulation radius abc: a number
simulation real_time_factor abc: a number
grippers names left,left: different names
grippers names left,: different names
grippers names Left: different names
grippers names /left: different names
grippers names 1: different names
"""


@pytest.mark.parametrize("row", rows(REFUSED))
def test_what_cannot_be_is_refused_with_its_argument(row):
    file, argument, value, *words = row.replace(":", "").split()
    told = f"argument {argument} must be {' '.join(words)}, got '{value}'"
    with pytest.raises(RuntimeError, match=told):
        started(BY_NAME[file], **{argument: value})


def test_what_is_refused_is_refused_before_anything_is_started():
    """Launch starts what comes first, and ends with the error: a node would be left running."""
    declared = len(launch_stand_ins.arguments(SIMULATION))
    assert isinstance(launch_stand_ins.described(SIMULATION)[declared], OpaqueFunction)


@pytest.mark.parametrize(("simulation", "count"), [("false", 2), ("true", 4)])
def test_two_grippers_have_namespaces_and_frames_of_their_own(simulation, count):
    launched = started(GRIPPERS, simulation=simulation)
    assert len(launched) == count
    for node in launched:
        assert own_parameters(node)["frame_id"] == f"{node.namespace}_gripper_base"
    assert {node.namespace for node in launched} == {"left", "right"}


# --- the sample parameters and RViz ------------------------------------------------------------


def flat(values, prefix=""):
    """The values of nested namespaces by their names with dots."""
    parts = ((name, v if isinstance(v, dict) else {"": v}) for name, v in values.items())
    return {
        f"{prefix}{name}.{inner}".rstrip("."): value
        for name, part in parts
        for inner, value in part.items()
    }


def test_the_sample_parameters_are_the_nodes_defaults():
    ((node, content),) = read_yaml(SAMPLE).items()
    assert node == "/**/spiral_gripper"
    values, table = flat(content["ros__parameters"]), TABLES["spiral_gripper_node"]
    assert values
    for name, value in values.items():
        assert value == table[name] or (value != value and table[name] != table[name]), name
        assert type(value) is type(table[name]), name
    assert GripperParameters.refusal(values) is None


def test_rviz_shows_what_node_and_simulator_publish(node, namespace):
    manager = read_yaml(RVIZ)["Visualization Manager"]
    fixed = manager["Global Options"]["Fixed Frame"]
    assert fixed == TABLES["spiral_gripper_node"]["frame_id"]
    displays = {d["Class"].split("/")[1]: d for d in manager["Displays"]}
    description = displays["RobotModel"]["Description Topic"]
    assert description["Value"] == "robot_description"
    assert description["Durability Policy"] == "Transient Local"  # as its publisher offers it
    assert "TF" in displays
    simulator = Simulator(SingleThreadedExecutor(), namespace=namespace)
    published = {
        (
            publisher.msg_type.__name__,
            publisher.topic.removeprefix(f"{namespace}/"),
            publisher.qos_profile.durability is DurabilityPolicy.TRANSIENT_LOCAL,
        )
        for one in (node, *simulator.nodes)
        for publisher in one.publishers
    }
    for one in simulator.nodes:
        one.destroy_node()
    shown = {
        (
            display["Class"].split("/")[1],
            display["Topic"]["Value"],
            display["Topic"]["Durability Policy"] == "Transient Local",
        )
        for display in manager["Displays"]
        if "Topic" in display
    }
    assert len(shown) >= 3
    assert shown <= published
