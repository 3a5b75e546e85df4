# SPDX-License-Identifier: Apache-2.0
"""The launch files, the sample parameters and the RViz configuration fit the nodes that they start.

The launch files are loaded with stand-ins for launch and launch_ros, which are not on PyPI.
"""

import os
import re
import sys
from pathlib import Path
from runpy import run_path
from types import ModuleType, SimpleNamespace

import pytest
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import parameter_dict_from_yaml_file, parameter_value_to_python
from repo.source_tree import ROOT, pyproject
from ros.control_bench import rows
from ruamel.yaml import YAML

from spiral_gripper_ros.parameters.table import PARAMETERS
from spiral_gripper_ros.process.stop_signals import STARTED_BY
from spiral_gripper_ros.simulation.radius_estimator import RadiusParameters
from spiral_gripper_ros.simulation.regulator import SimulatedRegulatorParameters
from spiral_gripper_ros.simulation.simulator import Simulator

PACKAGE = ROOT / "spiral_gripper_ros"
FILES = {file.name.split(".")[0]: file for file in sorted(PACKAGE.glob("launch/*.py"))}
SAMPLE = PACKAGE / "config/gripper.yaml"
RVIZ = PACKAGE / "rviz/spiral_gripper.rviz"
NODE = {spec.name: spec.default for spec in PARAMETERS} | {"use_sim_time": False}
SIMULATED = SimulatedRegulatorParameters.specs() + RadiusParameters.specs()
SET = (
    "gripper=prototype_p1 frame_id=tool0 profile=sine radius=0.01 fault=leak "
    "estimate_noise=0.0001 stiffness_factor=1.2 real_time_factor=2"
)
SET = dict(word.split("=") for word in SET.split())
# What our files give to classes of launch and launch_ros, as those call it.
KEYWORDS = (
    "default_value description choices launch_arguments function msg reason package executable "
    "name namespace parameters arguments output condition on_exit respawn respawn_delay "
    "ros_arguments additional_env mappings"
)


class Kept:
    """A class of launch, which keeps what it is given; what is not given is None."""

    toxml = str

    def __init__(self, *given, **named):
        assert named.keys() <= set(KEYWORDS.split()), named.keys()
        self.given = given
        vars(self).update(named)

    def __getattr__(self, name):
        return None

    def perform(self, context):
        """Return the text of a LaunchConfiguration, or of ThisLaunchFileDir."""
        return context.values[self.given[0]] if self.given else str(context.file.parent)

    @property
    def kind(self):
        return type(self).__name__


class StandIn(ModuleType):
    """A module that has a class of every name."""

    __path__, __file__ = (), __file__

    def __getattr__(self, name):
        return type(name, (Kept,), {})


MODULES = """
xacro launch launch.actions launch.conditions launch.launch_description_sources
launch.substitutions launch_ros launch_ros.actions
"""


@pytest.fixture(autouse=True)
def stand_ins(monkeypatch):
    for name in MODULES.split():
        monkeypatch.setitem(sys.modules, name, StandIn(name))


def described(name):
    """Return what the launch description of a file holds."""
    return run_path(str(FILES[name]))["generate_launch_description"]().given[0]


def arguments(name):
    """Return the arguments that a file declares, by name."""
    return {e.given[0]: e for e in described(name) if e.kind == "DeclareLaunchArgument"}


def started(name, **given):
    """Return the nodes that a launch of a file with these arguments starts, with its context."""
    context = SimpleNamespace(file=FILES[name], values={}, is_shutdown=False)
    for argument, declared in arguments(name).items():
        value = given.pop(argument, text(declared.default_value, context))
        assert declared.choices is None or value in declared.choices, f"{argument}:={value}"
        context.values[argument] = value
    assert given == {}
    return list(expanded(described(name), context))


def expanded(entities, context):
    for entity in entities:
        if entity.kind == "IncludeLaunchDescription":
            passed = {k: text(v, context) for k, v in entity.launch_arguments}
            file = Path(text(entity.given[0].given[0], context))
            yield from started(file.name.split(".")[0], **passed)
        elif entity.kind in ("GroupAction", "OpaqueFunction"):
            inner = entity.function(context) if entity.function else entity.given[0]
            yield from expanded(inner, context)
        elif entity.kind != "DeclareLaunchArgument" and not entity.condition:  # RViz, if wanted
            entity.context, entity.namespace = context, text(entity.namespace, context)
            given = entity.parameters or []
            entity.own = next((one for one in given if isinstance(one, dict)), {})
            yield entity


def text(value, context):
    """Return the text of a substitution, of a list of them, or of plain text."""
    if isinstance(value, list):
        return "".join(text(part, context) for part in value)
    return value if isinstance(value, str) else value.perform(context)


@pytest.mark.parametrize("name", FILES)
def test_every_argument_is_described_and_every_executable_installed(name):
    declared = arguments(name)
    assert all(one.description and one.default_value is not None for one in declared.values())
    page = (ROOT / "docs/simulation.md").read_text(encoding="utf-8")
    (listed,) = re.findall(rf"^\| `{name}\.launch\.py` \|[^|]*\|(.*)\|$", page, re.MULTILINE)
    assert set(re.findall(r"`(\w+)`", listed)) == set(declared)
    ours = {(node.package, node.executable) for node in started(name)}
    ours -= {("robot_state_publisher", "robot_state_publisher")}
    scripts = pyproject()["tool"]["dynamic-metadata"][0]["ros-scripts"]
    assert ours <= {("spiral_gripper_ros", script) for script in scripts}


def test_launch_files_parameters_and_rviz_configuration_are_installed():
    parts = re.search(r"foreach\(_part (.+?)\)", (ROOT / "packaging/pip.cmake").read_text())[1]
    setup = (PACKAGE / "setup.py").read_text(encoding="utf-8")
    patterns = dict(re.findall(r'share/{NAME}/(\w+)", sorted\(glob\("(.+?)"', setup))
    for shipped in (*FILES.values(), SAMPLE, RVIZ):
        folder = shipped.parent.name
        assert shipped in PACKAGE.glob(patterns[folder])
        assert folder in parts.split()


def test_what_is_not_given_is_left_to_the_parameters_file_and_what_is_given_wins():
    (node,) = started("gripper")
    left = {"autostart": True, "exit_with_parent": True, "use_sim_time": False}
    assert (node.own, node.kind, node.respawn) == (left, "LifecycleNode", False)
    assert node.additional_env == {STARTED_BY: str(os.getpid())}
    given = {"gripper": "prototype_p1", "frame_id": "tool0"}
    others = {"regulator": str(SAMPLE), "log_level": "debug", "namespace": "/left"}
    switches = {"use_sim_time": "true", "autostart": "false", "respawn": "true"}
    node, adapter = started("gripper", **given, **others, **switches)
    assert node.own == {**left, **given, "use_sim_time": True, "autostart": False}
    file, own = node.parameters  # what comes last wins
    assert (Path(file).resolve(), own) == (SAMPLE, node.own)
    assert (adapter.executable, adapter.name) == ("spiral_gripper_regulator", "regulator")
    assert adapter.parameters == [str(SAMPLE)]
    for one in (node, adapter):
        assert (one.respawn, one.respawn_delay, one.namespace) == (True, 2.0, "/left")
        assert one.ros_arguments == ["--log-level", "debug"]


def test_the_simulation_starts_node_and_simulator_in_one_namespace_and_one_time():
    node, simulator = started("simulation", **SET, namespace="/left", use_sim_time="true")
    assert node.executable == "spiral_gripper_node"
    assert simulator.executable == "spiral_gripper_simulator"
    assert node.namespace == simulator.namespace == "/left"
    assert (node.own["use_sim_time"], node.own["gripper"]) == (True, "prototype_p1")
    given = simulator.own
    assert given.pop("publish_clock") is True
    defaults = {spec.name: spec.default for spec in SIMULATED}
    assert given == {name: type(defaults[name])(value) for name, value in SET.items()}
    assert all(type(value) is type(defaults[name]) for name, value in given.items())
    # One process with two nodes: a name would be given to both.
    assert simulator.name is None


# The launch file, what is given, which node ends: what follows.
ENDS = """
gripper 0: LogInfo
gripper required=true 0: LogInfo Shutdown
gripper required=true respawn=true 0: LogInfo
simulation 0: LogInfo Shutdown
simulation 1: Shutdown
"""


@pytest.mark.parametrize("row", rows(ENDS))
def test_the_end_of_a_required_process_is_that_of_the_launch(row):
    (name, *given, number), follows = (part.split() for part in row.split(": "))
    node = started(name, **dict(word.split("=") for word in given))[int(number)]
    (handler,) = node.on_exit
    assert [action.kind for action in handler.function(node.context)] == follows
    node.context.is_shutdown = True
    assert handler.function(node.context) == []


REFUSED = """
gripper parameters /nothing: a file
gripper regulator /nothing: a file
description model /nothing: a file
simulation radius abc: a number
grippers names left,left: different names
grippers names left,: different names
grippers names Left: different names
grippers names /left: different names
grippers names 1: different names
"""


@pytest.mark.parametrize("row", rows(REFUSED))
def test_what_cannot_be_is_refused_with_its_argument_before_anything_is_started(row):
    name, argument, value, *words = row.replace(":", "").split()
    told = f"argument {argument} must be {' '.join(words)}, got '{value}'"
    with pytest.raises(RuntimeError, match=told):
        started(name, **{argument: value})
    # Launch starts what comes first, and ends with the error: a node would be left running.
    assert described(name)[len(arguments(name))].kind == "OpaqueFunction"


@pytest.mark.parametrize(("simulation", "count"), [("false", 2), ("true", 4)])
def test_two_grippers_have_namespaces_and_frames_of_their_own(simulation, count):
    launched = started("grippers", simulation=simulation)
    frames = [(node.namespace, node.own["frame_id"]) for node in launched]
    assert len(frames) == count
    assert set(frames) == {(name, f"{name}_gripper_base") for name in ("left", "right")}


# --- the sample parameters and RViz ------------------------------------------------------------


def test_the_sample_parameters_are_the_nodes_defaults():
    name = "/**/spiral_gripper"
    messages = parameter_dict_from_yaml_file(str(SAMPLE), target_nodes=[name]).items()
    values = {name: str(parameter_value_to_python(one.value)) for name, one in messages}
    assert values
    assert values == {name: str(NODE[name]) for name in values}


def test_rviz_shows_what_node_and_simulator_publish(node, namespace):
    manager = YAML().load(RVIZ)["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == NODE["frame_id"]
    simulator = Simulator(SingleThreadedExecutor(), namespace=namespace)
    published = {
        (one.msg_type.__name__, one.topic_name, one.qos_profile.durability.name)
        for home in (node, *simulator.nodes)
        for one in home.publishers
    }
    for one in simulator.nodes:
        one.destroy_node()
    shown = {
        (
            display["Class"].split("/")[1],
            f"{namespace}/{display['Topic']['Value']}",
            display["Topic"]["Durability Policy"].upper().replace(" ", "_"),
        )
        for display in manager["Displays"]
        if "Topic" in display
    }
    assert len(shown) >= 3
    assert shown <= published
    (robot,) = [one for one in manager["Displays"] if one["Class"].endswith("RobotModel")]
    assert robot["Description Topic"]["Durability Policy"] == "Transient Local"
