# SPDX-License-Identifier: Apache-2.0
"""Stand-ins for launch and launch_ros, which are not on PyPI: enough to load our launch files.

They take the arguments that the real ones take, and keep them; what a launch would start is then
found by :func:`started`.
"""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType


class LaunchContext:
    """Holds the values of the launch arguments."""

    is_shutdown = False

    def __init__(self, file, values):
        self.file = file
        self.launch_configurations = values


class LaunchDescription:
    def __init__(self, initial_entities=()):
        self.entities = list(initial_entities)


class DeclareLaunchArgument:
    def __init__(self, name, *, default_value=None, description=None, choices=None):
        self.name, self.description, self.choices = name, description, choices
        self.default_value = default_value


class LaunchConfiguration:
    def __init__(self, variable_name):
        self.name = variable_name

    def perform(self, context):
        return context.launch_configurations[self.name]


class ThisLaunchFileDir:
    def perform(self, context):
        return str(context.file.parent)


class IfCondition:
    def __init__(self, predicate_expression):
        self.predicate = predicate_expression


class PythonLaunchDescriptionSource:
    def __init__(self, location):
        self.location = location


class IncludeLaunchDescription:
    def __init__(self, source, *, launch_arguments=()):
        self.source, self.launch_arguments = source, dict(launch_arguments)


class OpaqueFunction:
    def __init__(self, *, function):
        self.function = function


class Node:
    def __init__(
        self,
        *,
        package,
        executable,
        name=None,
        namespace=None,
        parameters=(),
        arguments=(),
        output="log",
        condition=None,
        on_exit=None,
        respawn=False,
        respawn_delay=None,
        ros_arguments=(),
        additional_env=None,
    ):
        self.additional_env = additional_env
        self.respawn, self.respawn_delay, self.ros_arguments = respawn, respawn_delay, ros_arguments
        self.package, self.executable, self.name = package, executable, name
        self.namespace, self.parameters, self.arguments = namespace, parameters, arguments
        self.output, self.condition, self.on_exit = output, condition, on_exit


class LifecycleNode(Node):
    def __init__(self, *, name, namespace, **others):
        super().__init__(name=name, namespace=namespace, **others)


class Description:
    """What xacro would return: the file, and what was given to it."""

    def __init__(self, file, mappings):
        self.file, self.mappings = file, mappings

    def toxml(self):
        return f"{self.file} {self.mappings}"


def process_file(file, *, mappings):
    return Description(file, mappings)


class GroupAction:
    def __init__(self, actions):
        self.actions = list(actions)


class LogInfo:
    def __init__(self, *, msg):
        self.msg = msg


class Shutdown:
    def __init__(self, *, reason):
        self.reason = reason


MODULES = {
    "launch": (LaunchContext, LaunchDescription),
    "launch.actions": (
        DeclareLaunchArgument,
        GroupAction,
        IncludeLaunchDescription,
        LogInfo,
        OpaqueFunction,
        Shutdown,
    ),
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
        for member in members:
            setattr(module, member.__name__, member)
        monkeypatch.setitem(sys.modules, name, module)


def described(file):
    """Return the launch description of a file."""
    spec = importlib.util.spec_from_file_location(file.name.replace(".", "_"), file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.generate_launch_description()


def arguments(file):
    """Return the arguments that a file declares, by name."""
    entities = described(file).entities
    return {e.name: e for e in entities if isinstance(e, DeclareLaunchArgument)}


def started(file, **given):
    """Return what a launch of a file with these arguments does, without its declarations."""
    declared = arguments(file)
    assert given.keys() <= declared.keys(), given.keys() - declared.keys()
    for name, value in given.items():
        choices = declared[name].choices
        assert choices is None or value in choices, f"{name}:={value}"
    context = LaunchContext(file, {})
    for name, argument in declared.items():
        context.launch_configurations[name] = given.get(name, text(argument.default_value, context))
    return _expanded(described(file).entities, context)


def _expanded(entities, context):
    found = []
    for entity in entities:
        if isinstance(entity, DeclareLaunchArgument):
            continue
        if isinstance(entity, IncludeLaunchDescription):
            passed = {k: text(v, context) for k, v in entity.launch_arguments.items()}
            found += started(Path(text(entity.source.location, context)), **passed)
        elif isinstance(entity, GroupAction):
            found += _expanded(entity.actions, context)
        elif isinstance(entity, OpaqueFunction):
            found += _expanded(entity.function(context), context)
        elif isinstance(entity, Node):
            if entity.condition is None or text(entity.condition.predicate, context) == "true":
                found.append(_resolved(entity, context))
        else:
            found.append(entity)
    return found


def _resolved(node, context):
    node.namespace = text(node.namespace, context)
    node.parameters = [p if isinstance(p, dict) else text(p, context) for p in node.parameters]
    node.arguments = [text(argument, context) for argument in node.arguments]
    return node


def text(value, context):
    """Return the text of a substitution, of a list of them, or of plain text."""
    if isinstance(value, str):
        return value
    if isinstance(value, list):
        return "".join(text(part, context) for part in value)
    return value.perform(context)
