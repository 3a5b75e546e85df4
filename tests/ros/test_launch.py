# SPDX-License-Identifier: Apache-2.0
"""The launch files, the sample parameters and the RViz configuration fit the nodes that they start.

The launch files are loaded with stand-ins for launch and launch_ros.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from repo.source_tree import ROOT, pyproject
from ros import launch_stand_ins
from ros.harness import DEADLINE, START_DEADLINE
from ros.launch_stand_ins import LifecycleNode, LogInfo, OpaqueFunction, Shutdown, started
from ros.simulation_harness import RunningSimulator
from ruamel.yaml import YAML

from spiral_gripper_ros.parameters.table import PARAMETERS, GripperParameters
from spiral_gripper_ros.process.stop_signals import STARTED_BY
from spiral_gripper_ros.simulation.radius_estimator import RadiusParameters
from spiral_gripper_ros.simulation.regulator import SimulatedRegulatorParameters

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
SET = {
    "gripper": "prototype_p1",
    "frame_id": "tool0",
    "profile": "sine",
    "radius": "0.01",
    "fault": "leak",
    "estimate_noise": "0.0001",
    "stiffness_factor": "1.2",
    "real_time_factor": "2",
}


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
    scripts = pyproject()["tool"]["dynamic-metadata"][0]["ros-scripts"]
    launched = started(file)
    assert launched
    for node in launched:
        if node.package != "robot_state_publisher":
            assert node.package == "spiral_gripper_ros"
            assert node.executable in scripts
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


def test_the_simulation_has_one_gripper_whatever_the_file_says_and_rviz_if_wanted():
    node, simulator, rviz = started(SIMULATION, rviz="true", namespace="/left")
    assert own_parameters(simulator) == {"gripper": "paper_design_70", "publish_clock": False}
    assert own_parameters(node)["gripper"] == "paper_design_70"
    assert (rviz.package, rviz.executable, rviz.namespace) == ("rviz2", "rviz2", "/left")
    assert rviz.arguments[0] == "-d"
    assert Path(rviz.arguments[1]).resolve() == RVIZ


def test_node_and_adapter_have_the_log_level_the_respawn_and_their_files(file):
    for respawn in ("true", "false"):
        given = {"regulator": file, "log_level": "debug", "respawn": respawn, "namespace": "/left"}
        for node in (launched := started(GRIPPER, **given)):
            assert (node.respawn, node.respawn_delay) == (respawn == "true", 2.0)
            assert (node.namespace, node.ros_arguments) == ("/left", ["--log-level", "debug"])
    _, adapter = launched
    assert (adapter.executable, adapter.name) == ("spiral_gripper_regulator", "regulator")
    assert adapter.parameters == [file]
    for node in started(SIMULATION, log_level="debug"):
        assert node.ros_arguments == ["--log-level", "debug"]


@pytest.mark.parametrize(
    ("file", "given", "which", "follows"),
    [
        (GRIPPER, {}, 0, [LogInfo]),
        (GRIPPER, {"required": "true"}, 0, [LogInfo, Shutdown]),
        (GRIPPER, {"required": "true", "respawn": "true"}, 0, [LogInfo]),
        (SIMULATION, {}, 0, [LogInfo, Shutdown]),
        (SIMULATION, {}, 1, [Shutdown]),
    ],
)
def test_the_end_of_a_required_process_is_that_of_the_launch(file, given, which, follows):
    node = started(file, **given)[which]
    (handler,) = node.on_exit
    assert [type(action) for action in handler.function(node.context)] == follows
    node.context.is_shutdown = True
    assert handler.function(node.context) == []


@pytest.mark.parametrize(
    ("file", "argument", "value", "words"),
    [(GRIPPER, argument, "/nothing", "a file") for argument in ("parameters", "regulator")]
    + [(DESCRIPTION, "model", "/nothing", "a file")]
    + [(SIMULATION, argument, "abc", "a number") for argument in ("radius", "real_time_factor")]
    + [
        (GRIPPERS, "names", names, "different names")
        for names in ("", "left,left", "left,", "Left", "a b", "/left", "1")
    ],
)
def test_what_cannot_be_is_refused_with_its_argument(file, argument, value, words):
    with pytest.raises(RuntimeError, match=f"argument {argument} must be {words}, got '{value}'"):
        started(file, **{argument: value})


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


def test_the_description_is_that_of_the_xacro_with_what_is_given(file):
    given = {"prefix": "left_", "model": file, "collision": "swept"}
    (publisher,) = started(DESCRIPTION, namespace="/left", **given)
    assert (publisher.package, publisher.namespace) == ("robot_state_publisher", "/left")
    (text,) = own_parameters(publisher).values()
    assert text == f"{PACKAGE / 'urdf/spiral_gripper.urdf.xacro'} {given}"
    (publisher,) = started(DESCRIPTION)
    (text,) = own_parameters(publisher).values()
    assert str(PACKAGE / "urdf/paper_design_70.yaml") in text


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


def test_the_node_reads_the_sample_and_rviz_shows_what_is_published(client, namespace, tmp_path):
    file = tmp_path / "mine.yaml"
    sample = SAMPLE.read_text(encoding="utf-8")
    changed = sample.replace("timeout_policy: hold", "timeout_policy: vent")
    file.write_text(changed.replace(" rate: 50.0", " rate: 20.0"), encoding="utf-8")
    manager = read_yaml(RVIZ)["Visualization Manager"]
    fixed = manager["Global Options"]["Fixed Frame"]
    assert fixed == TABLES["spiral_gripper_node"]["frame_id"]
    displays = {d["Class"].split("/")[1]: d for d in manager["Displays"]}
    description = displays["RobotModel"]["Description Topic"]
    assert description["Value"] == "robot_description"
    assert description["Durability Policy"] == "Transient Local"  # as its publisher offers it
    assert "TF" in displays
    shown = {
        (d["Class"].split("/")[1], d["Topic"]["Value"], d["Topic"]["Durability Policy"])
        for d in manager["Displays"]
        if "Topic" in d
    }
    topics = {topic for _, topic, _ in shown}
    assert topics == {"markers", "backbone", "measured_backbone", "simulated/backbone"}

    def publishers(topic):
        return client.get_publishers_info_by_topic(f"{namespace}/{topic}")

    command = [sys.executable, "-m", "spiral_gripper_ros.node.main", "--ros-args"]
    command += ["--params-file", str(file), "-r", f"__ns:={namespace}"]
    with RunningSimulator(namespace), subprocess.Popen(command) as node:
        try:
            client.wait_until(lambda: all(map(publishers, topics)), "publishers", START_DEADLINE)
            published = {
                (
                    info.topic_type.split("/")[-1],
                    topic,
                    "Transient Local"
                    if info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
                    else "Volatile",
                )
                for topic in topics
                for info in publishers(topic)
                if info.qos_profile.reliability == ReliabilityPolicy.RELIABLE
            }
            assert client.get_parameter_of_node("radius.timeout_policy") == "vent"
            assert client.get_parameter_of_node("publish.rate") == 20.0
        finally:
            node.terminate()
        assert node.wait(DEADLINE) == 0
    assert shown == published
