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
from ros.harness import DEADLINE, START_DEADLINE, RunningNode
from ros.launch_stand_ins import LifecycleNode, LogInfo, Node, Shutdown, started
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
# What any node has besides its own.
COMMON = {"use_sim_time": False}
TABLES = {
    "spiral_gripper_node": {s.name: s.default for s in PARAMETERS} | COMMON,
    "spiral_gripper_simulator": {
        s.name: s.default for s in SimulatedRegulatorParameters.specs() + RadiusParameters.specs()
    }
    | COMMON,
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
def parameters_file(tmp_path):
    file = tmp_path / "regulator.yaml"
    file.touch()
    return str(file)


def nodes(file, **given):
    return [entity for entity in started(file, **given) if isinstance(entity, Node)]


def own_parameters(node):
    """The parameters that a launched node of ours is given, besides files."""
    (values,) = [p for p in node.parameters if isinstance(p, dict)]
    return values


def read_yaml(path):
    return YAML(typ="safe").load(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_argument_has_a_description_and_a_default(file):
    declared = launch_stand_ins.arguments(file)
    assert declared
    for argument in declared.values():
        assert argument.description, argument.name
        assert argument.default_value is not None, argument.name


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_executable_is_one_that_is_installed(file):
    scripts = pyproject()["tool"]["dynamic-metadata"][0]["ros-scripts"]
    launched = nodes(file)
    assert launched
    for node in launched:
        if node.package != "robot_state_publisher":
            assert node.package == "spiral_gripper_ros"
            assert node.executable in scripts


def test_every_parameter_is_one_that_the_node_has_and_of_its_type():
    given = {**SET, "namespace": "/left", "use_sim_time": "true"}
    for node in nodes(SIMULATION, **given):
        table = TABLES[node.executable]
        for name, value in own_parameters(node).items():
            assert type(value) is type(table[name]), name


def test_what_is_not_given_is_left_to_the_parameters_file():
    (node,) = nodes(GRIPPER)
    assert own_parameters(node) == {
        "autostart": True,
        "exit_with_parent": True,
        "use_sim_time": False,
    }
    (node,) = nodes(GRIPPER, gripper="prototype_p1", frame_id="tool0", use_sim_time="true")
    assert own_parameters(node) == {
        "autostart": True,
        "exit_with_parent": True,
        "use_sim_time": True,
        "gripper": "prototype_p1",
        "frame_id": "tool0",
    }
    # What is given comes last, and so wins.
    assert [type(p) for p in node.parameters] == [str, dict]
    assert Path(node.parameters[0]).resolve() == SAMPLE


def test_the_simulation_starts_node_and_simulator_in_one_namespace_and_one_time():
    node, simulator = nodes(SIMULATION, **SET, namespace="/left", use_sim_time="true")
    assert isinstance(node, LifecycleNode)
    assert (node.executable, simulator.executable) == tuple(TABLES)
    assert node.namespace == simulator.namespace == "/left"
    assert own_parameters(node)["use_sim_time"] is True
    assert own_parameters(node)["gripper"] == "prototype_p1"
    simulated = {name: own_parameters(simulator)[name] for name in SET}
    assert {name: str(value).removesuffix(".0") for name, value in simulated.items()} == SET
    assert own_parameters(simulator)["publish_clock"] is True
    # One process with two nodes: a name would be given to both.
    assert simulator.name is None


def test_node_and_simulator_have_one_gripper_whatever_the_parameters_file_says():
    for given in ({}, {"gripper": "prototype_p1"}):
        node, simulator = nodes(SIMULATION, **given)
        assert own_parameters(node)["gripper"] == own_parameters(simulator)["gripper"]


def test_what_is_not_given_is_not_set():
    _, simulator = nodes(SIMULATION)
    assert own_parameters(simulator) == {"gripper": "paper_design_70", "publish_clock": False}


def test_the_node_activates_itself_unless_a_lifecycle_manager_does():
    (node,) = nodes(GRIPPER)
    assert isinstance(node, LifecycleNode)
    assert own_parameters(node)["autostart"] is True
    (node,) = nodes(GRIPPER, autostart="false")
    assert own_parameters(node)["autostart"] is False


def test_a_process_that_ends_is_started_again_if_wanted(parameters_file):
    for launched in nodes(GRIPPER, regulator=parameters_file):
        assert launched.respawn is False
    for launched in nodes(GRIPPER, regulator=parameters_file, respawn="true"):
        assert launched.respawn is True
        assert launched.respawn_delay == 2.0


def test_the_log_level_is_that_of_every_process(parameters_file):
    given = {"log_level": "debug"}
    launched = [*nodes(GRIPPER, regulator=parameters_file, **given), *nodes(SIMULATION, **given)]
    assert [node.ros_arguments for node in launched] == [["--log-level", "debug"]] * 4


def what_follows(file, *, is_shutdown=False, **given):
    """What a launch does when the gripper's node has ended."""
    context = launch_stand_ins.LaunchContext(file, {})
    (node,) = [n for n in nodes(file, **given) if n.executable == "spiral_gripper_node"]
    (handler,) = node.on_exit
    declared = launch_stand_ins.arguments(GRIPPER)
    required = {"required": "true"} if file == SIMULATION else {}
    for name, argument in declared.items():
        default = launch_stand_ins.text(argument.default_value, context)
        context.launch_configurations[name] = {**given, **required}.get(name, default)
    context.is_shutdown = is_shutdown
    return [type(entity) for entity in handler.function(context)]


def test_the_end_of_a_required_node_is_that_of_the_launch():
    assert what_follows(GRIPPER) == [LogInfo]
    assert what_follows(GRIPPER, required="true") == [LogInfo, Shutdown]
    assert what_follows(GRIPPER, required="true", respawn="true") == [LogInfo]
    assert what_follows(GRIPPER, required="true", is_shutdown=True) == []


def test_the_simulation_requires_its_node(monkeypatch):
    given = []
    include = launch_stand_ins.IncludeLaunchDescription.__init__

    def noting(self, source, *, launch_arguments=()):
        include(self, source, launch_arguments=launch_arguments)
        given.append(self.launch_arguments)

    monkeypatch.setattr(launch_stand_ins.IncludeLaunchDescription, "__init__", noting)
    nodes(SIMULATION)
    assert given[0]["required"] == "true"


def test_the_adapter_is_started_with_its_file_beside_the_node(parameters_file):
    node, adapter = nodes(GRIPPER, regulator=parameters_file, namespace="/left")
    assert (adapter.executable, adapter.name) == ("spiral_gripper_regulator", "regulator")
    assert adapter.parameters == [parameters_file]
    assert node.namespace == adapter.namespace == "/left"


@pytest.mark.parametrize("argument", ["parameters", "regulator"])
def test_a_file_that_is_not_there_is_refused_with_its_argument(argument):
    with pytest.raises(RuntimeError, match=f"argument {argument} must be a file, got '/nothing'"):
        nodes(GRIPPER, **{argument: "/nothing"})


@pytest.mark.parametrize("argument", ["radius", "estimate_noise", "real_time_factor"])
def test_what_is_no_number_is_refused_with_its_argument(argument):
    with pytest.raises(RuntimeError, match=f"argument {argument} must be a number, got 'abc'"):
        nodes(SIMULATION, **{argument: "abc"})


def test_what_is_refused_is_refused_before_anything_is_started():
    """Launch starts what comes first, and ends with the error: a node would be left running."""
    entities = launch_stand_ins.described(SIMULATION).entities
    declared = launch_stand_ins.DeclareLaunchArgument
    first = next(entity for entity in entities if not isinstance(entity, declared))
    assert isinstance(first, launch_stand_ins.OpaqueFunction)


def test_the_node_is_told_which_process_launches_it():
    (node,) = nodes(GRIPPER)
    assert node.additional_env == {STARTED_BY: str(os.getpid())}


@pytest.mark.parametrize("simulation", ["false", "true"])
def test_two_grippers_have_namespaces_and_frames_of_their_own(simulation):
    launched = nodes(GRIPPERS, simulation=simulation)
    assert len(launched) == (4 if simulation == "true" else 2)
    for node in launched:
        name = node.namespace
        assert own_parameters(node)["frame_id"] == f"{name}_gripper_base"
    assert {node.namespace for node in launched} == {"left", "right"}


@pytest.mark.parametrize("names", ["", "left,left", "left,", "Left", "a b", "/left", "1"])
def test_names_that_are_none_are_refused(names):
    with pytest.raises(RuntimeError, match="argument names"):
        nodes(GRIPPERS, names=names)


def test_the_description_is_that_of_the_xacro_with_what_is_given(tmp_path):
    model = tmp_path / "mine.yaml"
    model.touch()
    given = {"prefix": "left_", "model": str(model), "collision": "swept"}
    (publisher,) = nodes(DESCRIPTION, namespace="/left", **given)
    assert (publisher.package, publisher.namespace) == ("robot_state_publisher", "/left")
    (text,) = own_parameters(publisher).values()
    assert text == f"{PACKAGE / 'urdf/spiral_gripper.urdf.xacro'} {given}"
    (publisher,) = nodes(DESCRIPTION)
    (text,) = own_parameters(publisher).values()
    assert str(PACKAGE / "urdf/paper_design_70.yaml") in text
    with pytest.raises(RuntimeError, match="argument model must be a file, got '/nothing'"):
        nodes(DESCRIPTION, model="/nothing")


def test_rviz_is_started_if_wanted_with_the_configuration_that_is_there():
    assert len(nodes(SIMULATION)) == 2
    *_, rviz = nodes(SIMULATION, rviz="true", namespace="/left")
    assert (rviz.package, rviz.executable, rviz.namespace) == ("rviz2", "rviz2", "/left")
    assert rviz.arguments[0] == "-d"
    assert Path(rviz.arguments[1]).resolve() == RVIZ


def test_the_simulators_end_is_the_launchs_end_but_not_the_other_way_round():
    _, simulator = nodes(SIMULATION)
    (handler,) = simulator.on_exit
    context = launch_stand_ins.LaunchContext(SIMULATION, {})
    assert len(handler.function(context)) == 1
    context.is_shutdown = True
    assert handler.function(context) == []


def test_what_is_launched_is_installed_by_pip_and_by_colcon():
    cmake = (ROOT / "packaging/pip.cmake").read_text(encoding="utf-8")
    setup = (PACKAGE / "setup.py").read_text(encoding="utf-8")
    (parts,) = re.findall(r"foreach\(_part (.+?)\)", cmake)
    assert set(parts.split()) >= {"config", "launch", "rviz"}
    for file in (*FILES, SAMPLE, RVIZ):
        (pattern,) = re.findall(
            rf'share/{{NAME}}/{file.parent.name}", sorted\(glob\("(.+?)"', setup
        )
        assert file in PACKAGE.glob(pattern)


# --- the sample parameters ---------------------------------------------------------------------


def flat(values, prefix=""):
    """The values of nested namespaces by their names with dots."""
    parts = ((name, v if isinstance(v, dict) else {"": v}) for name, v in values.items())
    return {
        f"{prefix}{name}.{inner}".rstrip("."): value
        for name, part in parts
        for inner, value in part.items()
    }


def test_the_sample_parameters_are_the_nodes_defaults():
    content = read_yaml(SAMPLE)
    assert list(content) == ["/**/spiral_gripper"]
    values = flat(content["/**/spiral_gripper"]["ros__parameters"])
    table = TABLES["spiral_gripper_node"]
    assert values
    for name, value in values.items():
        assert value == table[name] or (value != value and table[name] != table[name]), name
        assert type(value) is type(table[name]), name
    assert GripperParameters.refusal(values) is None


def test_the_node_reads_a_parameters_file_in_any_namespace(client, namespace, tmp_path):
    file = tmp_path / "mine.yaml"
    sample = SAMPLE.read_text(encoding="utf-8")
    changed = sample.replace("timeout_policy: hold", "timeout_policy: vent")
    file.write_text(changed.replace(" rate: 50.0", " rate: 20.0"), encoding="utf-8")
    command = [sys.executable, "-m", "spiral_gripper_ros.node.main", "--ros-args"]
    command += ["--params-file", str(file), "-r", f"__ns:={namespace}"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as node:
        try:
            client.wait_until_active()
            assert client.get_parameter_of_node("radius.timeout_policy") == "vent"
            assert client.get_parameter_of_node("publish.rate") == 20.0
        finally:
            node.terminate()
        assert node.wait(DEADLINE) == 0, node.stdout.read()


# --- RViz --------------------------------------------------------------------------------------


def displays():
    return read_yaml(RVIZ)["Visualization Manager"]["Displays"]


def test_rviz_shows_our_frame():
    options = read_yaml(RVIZ)["Visualization Manager"]["Global Options"]
    assert options["Fixed Frame"] == TABLES["spiral_gripper_node"]["frame_id"]


def test_rviz_has_the_robot_model_and_its_frames_to_be_switched_on():
    by_class = {display["Class"].split("/")[1]: display for display in displays()}
    description = by_class["RobotModel"]["Description Topic"]
    assert description["Value"] == "robot_description"
    assert description["Durability Policy"] == "Transient Local"  # as its publisher offers it
    assert "TF" in by_class


def test_rviz_shows_topics_that_are_published_as_it_asks_for_them(client, namespace):
    latched = {True: "Transient Local", False: "Volatile"}
    shown = {
        (d["Class"].split("/")[1], d["Topic"]["Value"], d["Topic"]["Durability Policy"])
        for d in displays()
        if "Topic" in d
    }
    topics = {topic for _, topic, _ in shown}
    assert topics == {"markers", "backbone", "measured_backbone", "simulated/backbone"}
    with RunningNode(namespace), RunningSimulator(namespace):
        client.wait_until(
            lambda: all(map(publishers(client), topics)), "the publishers", START_DEADLINE
        )
        published = {
            (
                info.topic_type.split("/")[-1],
                topic,
                latched[info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL],
            )
            for topic in topics
            for info in publishers(client)(topic)
            if info.qos_profile.reliability == ReliabilityPolicy.RELIABLE
        }
    assert shown == published


def publishers(client):
    """Return a function that finds the publishers of a topic of the client's namespace."""
    return lambda topic: client.get_publishers_info_by_topic(f"{client.get_namespace()}/{topic}")
