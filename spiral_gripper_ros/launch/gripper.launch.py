# SPDX-License-Identifier: Apache-2.0
"""One gripper: the node, which activates itself, and the adapter of its regulator if wanted.

Nothing here waits for the node: it configures and activates itself, after a respawn too.
"""

from __future__ import annotations

import os
from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration, ThisLaunchFileDir
from launch_ros.actions import LifecycleNode, Node

# Arguments that set the parameter of their name if they are given, whatever the file says.
SETTINGS = ("gripper", "frame_id")
# Time from a process's end to its respawn [s]: longer than a regulator's watchdog.
RESPAWN_DELAY = 2.0


def generate_launch_description() -> LaunchDescription:
    switch = ["true", "false"]
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "parameters",
                default_value=[ThisLaunchFileDir(), "/../config/gripper.yaml"],
                description="YAML file of the node's parameters",
            ),
            DeclareLaunchArgument(
                "gripper",
                default_value="",
                description="name of a shipped gripper, or path of a description file; "
                "default: the value in the parameters file",
            ),
            DeclareLaunchArgument(
                "frame_id",
                default_value="",
                description="the gripper's base frame; default: the value in the parameters file",
            ),
            DeclareLaunchArgument(
                "namespace", default_value="", description="namespace of the nodes"
            ),
            DeclareLaunchArgument(
                "use_sim_time",
                default_value="false",
                choices=switch,
                description="whether the nodes use the time of /clock",
            ),
            DeclareLaunchArgument(
                "autostart",
                default_value="true",
                choices=switch,
                description="whether the node activates itself; false: a lifecycle manager does",
            ),
            DeclareLaunchArgument(
                "respawn",
                default_value="false",
                choices=switch,
                description="whether to restart a process that has ended; it vents first",
            ),
            DeclareLaunchArgument(
                "required",
                default_value="false",
                choices=switch,
                description="whether the launch ends with the node; without effect with respawn",
            ),
            DeclareLaunchArgument(
                "log_level",
                default_value="info",
                choices=["debug", "info", "warn", "error", "fatal"],
                description="lowest level that is logged",
            ),
            DeclareLaunchArgument(
                "regulator",
                default_value="",
                description="YAML file of the regulator adapter's parameters; "
                "default: no adapter is started",
            ),
            OpaqueFunction(function=nodes),
        ]
    )


def nodes(context: LaunchContext) -> list[object]:
    given = {name: LaunchConfiguration(name).perform(context) for name in SETTINGS}
    own = {
        "autostart": is_true(context, "autostart"),
        "exit_with_parent": True,  # nobody would be in charge of it
        "use_sim_time": is_true(context, "use_sim_time"),
        **{name: value for name, value in given.items() if value},
    }
    gripper = LifecycleNode(
        executable="spiral_gripper_node",
        name="spiral_gripper",
        parameters=[existing_file(context, "parameters"), own],
        on_exit=[OpaqueFunction(function=ended)],
        **common(context),
    )
    if not LaunchConfiguration("regulator").perform(context):
        return [gripper]
    regulator = Node(
        executable="spiral_gripper_regulator",
        name="regulator",
        parameters=[existing_file(context, "regulator")],
        **common(context),
    )
    return [gripper, regulator]


def common(context: LaunchContext) -> dict[str, object]:
    """Return what all processes have in common."""
    return {
        "package": "spiral_gripper_ros",
        "namespace": LaunchConfiguration("namespace"),
        "output": "screen",
        # This process may end before one of them can look for its parent.
        "additional_env": {"SPIRAL_GRIPPER_STARTED_BY": str(os.getpid())},
        "respawn": is_true(context, "respawn"),
        "respawn_delay": RESPAWN_DELAY,
        "ros_arguments": ["--log-level", LaunchConfiguration("log_level").perform(context)],
    }


def ended(context: LaunchContext) -> list[object]:
    """Say that the node has ended, unless the launch ends anyway."""
    if context.is_shutdown:
        return []
    note = LogInfo(msg="spiral_gripper has ended: its log says why")
    if is_true(context, "required") and not is_true(context, "respawn"):
        return [note, Shutdown(reason="the gripper's node has ended")]
    return [note]


def is_true(context: LaunchContext, argument: str) -> bool:
    return LaunchConfiguration(argument).perform(context) == "true"


def existing_file(context: LaunchContext, argument: str) -> str:
    """Return a file's path; launch itself would go on without it, with the node's defaults."""
    path = LaunchConfiguration(argument).perform(context)
    if not Path(path).is_file():
        raise RuntimeError(f"launch argument {argument} must be a file, got {path!r}")
    return path
