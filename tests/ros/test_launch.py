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
from rclpy.parameter import parameter_dict_from_yaml_file, parameter_value_to_python
from repo.source_tree import ROOT, pyproject
from ros.control_bench import rows
from ros.records import agrees
from ruamel.yaml import YAML

from spiral_gripper_ros.parameters.table import PARAMETERS
from spiral_gripper_ros.process.stop_signals import STARTED_BY
from spiral_gripper_ros.simulation.radius_estimator import RadiusParameters
from spiral_gripper_ros.simulation.regulator import SimulatedRegulatorParameters

PACKAGE = ROOT / "spiral_gripper_ros"
FILES = {file.name.split(".")[0]: file for file in sorted(PACKAGE.glob("launch/*.py"))}
SAMPLE = PACKAGE / "config/gripper.yaml"
RVIZ = PACKAGE / "rviz/spiral_gripper.rviz"
NODE = {spec.name: spec.default for spec in PARAMETERS} | {"use_sim_time": False}
SIMULATED = SimulatedRegulatorParameters.specs() + RadiusParameters.specs()
SIMULATED = {spec.name for spec in SIMULATED} | {"publish_clock"}
# Files and their arguments; what is refused is refused before anything is started.
LAUNCHES = f"""
gripper
gripper gripper=prototype_p1 frame_id=tool0 regulator={SAMPLE} log_level=debug namespace=/left
  use_sim_time=true autostart=false respawn=true
gripper required=true
gripper required=true respawn=true
simulation
simulation gripper=prototype_p1 frame_id=tool0 profile=sine radius=0.01 fault=leak namespace=/left
  estimate_noise=0.0001 stiffness_factor=1.2 real_time_factor=2 use_sim_time=true rviz=true
grippers
grippers simulation=true names=one
description
description prefix=left_ collision=none namespace=/left
gripper parameters=/nothing
gripper regulator=/nothing
description model=/nothing
simulation radius=abc
grippers names=left,left
grippers names=left,
grippers names=Left
grippers names=/left
grippers names=1
"""
TEXTS = "LaunchConfiguration", "ThisLaunchFileDir"


class Kept:
    """A class of launch, which keeps what it is given; what is not given is None."""

    def __init__(self, *given, **named):
        self.given, self.named = given, named

    def __getattr__(self, name):
        return self.named.get(name)

    def toxml(self):
        return self.named

    @property
    def kind(self):
        return type(self).__name__

    def perform(self, context):
        """Return the text of one of TEXTS."""
        return context.values[self.given[0]] if self.given else str(context.file.parent)


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
    """Return what the launch description of a file holds, and the context of a launch."""
    context = SimpleNamespace(file=FILES[name], values={}, is_shutdown=False)
    return run_path(str(FILES[name]))["generate_launch_description"]().given[0], context


def declared(entities):
    return {one.given[0]: one for one in entities if one.kind == "DeclareLaunchArgument"}


def started(name, given):
    """Yield the processes that a launch of a file with these arguments starts."""
    entities, context = described(name)
    for name, argument in declared(entities).items():
        context.values[name] = given.pop(name, shown(argument.default_value, context))
        assert context.values[name] in (argument.choices or context.values.values())
    assert not given
    yield from expanded(entities, context)


def expanded(entities, context):
    for one in entities:
        if one.kind == "IncludeLaunchDescription":
            file = Path(shown(one.given[0].given[0], context))
            passed = {name: shown(value, context) for name, value in one.launch_arguments}
            yield from started(file.name.split(".")[0], passed)
        elif one.kind in ("GroupAction", "OpaqueFunction"):
            yield from expanded(one.function(context) if one.function else one.given[0], context)
        elif one.kind != "DeclareLaunchArgument":
            yield {"kind": one.kind} | shown(one.named, context)


def shown(value, context):
    """Return what a value is in a launch: texts for substitutions, what follows for a function."""
    if isinstance(value, dict):
        return {name: shown(one, context) for name, one in value.items()}
    if isinstance(value, list):
        parts = [shown(one, context) for one in value]
        is_text = any(getattr(one, "kind", "") in TEXTS for one in value)
        return "".join(parts) if is_text else parts
    if not isinstance(value, Kept):
        return value
    if value.function:
        context.is_shutdown = True
        assert value.function(context) == []  # the launch ends anyway
        context.is_shutdown = False
        return shown(value.function(context), context)
    if value.kind in TEXTS:
        return value.perform(context)
    return [value.kind, shown(list(value.given), context), shown(value.named, context)]


def lines(row):
    """Yield what a launch starts, a line for each thing that it gives."""
    name, *given = row.split()
    yield f"launch {row}"
    try:
        for process in started(name, dict(word.split("=") for word in given)):
            yield from (f"  {key}: {value}" for key, value in process.items())
            if process["executable"] == "spiral_gripper_simulator":
                assert process["parameters"][0].keys() <= SIMULATED
    except RuntimeError as error:
        yield f"  {error}"


def test_the_launches_are_those_on_record():
    found = []
    for name in FILES:
        entities, context = described(name)
        arguments = declared(entities)
        found += [f"{name} {key} {shown(one.named, context)}" for key, one in arguments.items()]
        # Launch starts what comes first, and ends with an error: a node would be left running.
        assert entities[len(arguments)].kind == "OpaqueFunction"
    found = "\n".join(found + [line for row in rows(LAUNCHES) for line in lines(row)])
    started_here = f"'{STARTED_BY}': '{os.getpid()}'"
    agrees("launches", found.replace(str(ROOT), "").replace(started_here, "started here"))


@pytest.mark.parametrize("name", FILES)
def test_every_argument_stands_on_the_page_and_every_executable_is_installed(name):
    page = (ROOT / "docs/simulation.md").read_text(encoding="utf-8")
    (listed,) = re.findall(rf"^\| `{name}\.launch\.py` \|[^|]*\|(.*)\|$", page, re.MULTILINE)
    assert set(re.findall(r"`(\w+)`", listed)) == declared(described(name)[0]).keys()
    scripts = pyproject()["tool"]["dynamic-metadata"][0]["ros-scripts"]
    for one in started(name, {}):
        assert one["executable"] in scripts or one["package"] != PACKAGE.name


def test_launch_files_parameters_and_rviz_configuration_are_installed():
    parts = re.search(r"foreach\(_part (.+?)\)", (ROOT / "packaging/pip.cmake").read_text())[1]
    setup = (PACKAGE / "setup.py").read_text(encoding="utf-8")
    patterns = dict(re.findall(r'^    "(\w+)": "(.+)",$', setup, re.MULTILINE))
    for shipped in (*FILES.values(), SAMPLE, RVIZ):
        folder = shipped.parent.name
        assert shipped in PACKAGE.glob(patterns[folder])
        assert folder in parts.split()


# --- the sample parameters and RViz ------------------------------------------------------------


def test_the_sample_parameters_are_the_nodes_defaults():
    name = "/**/spiral_gripper"
    messages = parameter_dict_from_yaml_file(str(SAMPLE), target_nodes=[name]).items()
    values = {name: str(parameter_value_to_python(one.value)) for name, one in messages}
    assert values
    assert values == {name: str(NODE[name]) for name in values}


def test_rviz_shows_what_node_and_simulator_publish():
    manager = YAML().load(RVIZ)["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == NODE["frame_id"]
    published = (Path(__file__).parent / "records/interfaces.txt").read_text(encoding="utf-8")
    topics = [one for one in manager["Displays"] if "Topic" in one]
    assert len(topics) >= 3
    for display in topics:
        kind, durability = (
            display["Class"].partition("/")[2],
            display["Topic"]["Durability Policy"].lower().replace(" ", "_"),
        )
        line = rf"publishes {display['Topic']['Value']} \w+/msg/{kind} \w+ {durability} "
        assert re.search(line, published), line
    (robot,) = [one for one in manager["Displays"] if one["Class"].endswith("RobotModel")]
    assert robot["Description Topic"]["Durability Policy"] == "Transient Local"
