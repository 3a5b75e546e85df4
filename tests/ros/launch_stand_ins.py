# SPDX-License-Identifier: Apache-2.0
"""Stand-ins for launch and launch_ros, which are not on PyPI: enough to load our launch files.

They take the arguments that the real ones take, and keep them; what a launch would start is then
found by :func:`started`.
"""

import importlib.util
import sys
from dataclasses import field, make_dataclass
from pathlib import Path
from types import ModuleType


def kind(name, *positional, keywords=(), bases=()):
    """A class that takes and keeps these arguments; what is not given is None."""
    fields = [(one, object, field(default=None)) for one in positional]
    fields += [(one, object, field(default=None, kw_only=True)) for one in keywords]
    return make_dataclass(name, fields, bases=bases, eq=False)


class LaunchContext(kind("LaunchContext", "file", "launch_configurations")):
    """Holds the values of the launch arguments."""

    is_shutdown = False


class LaunchConfiguration(kind("LaunchConfiguration", "variable_name")):
    def perform(self, context):
        return context.launch_configurations[self.variable_name]


class ThisLaunchFileDir:
    def perform(self, context):
        return str(context.file.parent)


class Description(kind("Description", "file", "mappings")):
    """What xacro would return: the file, and what was given to it."""

    def toxml(self):
        return f"{self.file} {self.mappings}"


def process_file(file, *, mappings):
    return Description(file, mappings)


LaunchDescription = kind("LaunchDescription", "initial_entities")
DeclareLaunchArgument = kind(
    "DeclareLaunchArgument", "name", keywords=("default_value", "description", "choices")
)
IfCondition = kind("IfCondition", "predicate_expression")
PythonLaunchDescriptionSource = kind("PythonLaunchDescriptionSource", "location")
IncludeLaunchDescription = kind(
    "IncludeLaunchDescription", "source", keywords=("launch_arguments",)
)
OpaqueFunction = kind("OpaqueFunction", keywords=("function",))
GroupAction = kind("GroupAction", "actions")
LogInfo = kind("LogInfo", keywords=("msg",))
Shutdown = kind("Shutdown", keywords=("reason",))
Node = kind(
    "Node",
    keywords=[
        "package",
        "executable",
        "name",
        "namespace",
        "parameters",
        "arguments",
        "output",
        "condition",
        "on_exit",
        "respawn",
        "respawn_delay",
        "ros_arguments",
        "additional_env",
    ],
)
LifecycleNode = kind("LifecycleNode", bases=(Node,))
ACTIONS = (DeclareLaunchArgument, GroupAction, IncludeLaunchDescription)
MODULES = {
    "launch": (LaunchContext, LaunchDescription),
    "launch.actions": (*ACTIONS, LogInfo, OpaqueFunction, Shutdown),
    "launch.conditions": (IfCondition,),
    "launch.launch_description_sources": (PythonLaunchDescriptionSource,),
    "launch.substitutions": (LaunchConfiguration, ThisLaunchFileDir),
    "launch_ros": (),
    "xacro": (process_file,),
    "launch_ros.actions": (LifecycleNode, Node),
}


def install(monkeypatch):
    """Let ``import launch`` and ``import launch_ros`` find the stand-ins."""
    for name, members in MODULES.items():
        module = ModuleType(name)
        module.__path__ = []
        vars(module).update({member.__name__: member for member in members})
        monkeypatch.setitem(sys.modules, name, module)


def described(file):
    """Return what the launch description of a file holds."""
    spec = importlib.util.spec_from_file_location(file.name.replace(".", "_"), file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.generate_launch_description().initial_entities


def arguments(file):
    """Return the arguments that a file declares, by name."""
    return {e.name: e for e in described(file) if isinstance(e, DeclareLaunchArgument)}


def started(file, **given):
    """Return the nodes that a launch of a file with these arguments starts, with its context."""
    declared = arguments(file)
    assert given.keys() <= declared.keys(), given.keys() - declared.keys()
    for name, value in given.items():
        choices = declared[name].choices
        assert choices is None or value in choices, f"{name}:={value}"
    context = LaunchContext(file, {})
    for name, argument in declared.items():
        context.launch_configurations[name] = given.get(name, text(argument.default_value, context))
    return _expanded(described(file), context)


def _expanded(entities, context):
    found = []
    for entity in entities:
        if isinstance(entity, IncludeLaunchDescription):
            passed = {k: text(v, context) for k, v in entity.launch_arguments}
            found += started(Path(text(entity.source.location, context)), **passed)
        elif isinstance(entity, GroupAction):
            found += _expanded(entity.actions, context)
        elif isinstance(entity, OpaqueFunction):
            found += _expanded(entity.function(context), context)
        elif not isinstance(entity, DeclareLaunchArgument):
            condition = entity.condition
            if condition is None or text(condition.predicate_expression, context) == "true":
                found.append(entity)
            entity.context, entity.namespace = context, text(entity.namespace, context)
            given = entity.parameters or ()
            entity.parameters = [p if isinstance(p, dict) else text(p, context) for p in given]
            entity.arguments = [text(argument, context) for argument in entity.arguments or ()]
    return found


def text(value, context):
    """Return the text of a substitution, of a list of them, or of plain text."""
    if isinstance(value, str):
        return value
    if isinstance(value, list):
        return "".join(text(part, context) for part in value)
    return value.perform(context)
