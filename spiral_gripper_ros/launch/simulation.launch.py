# SPDX-License-Identifier: Apache-2.0
"""The node without hardware: a simulated regulator, gripper and object; RViz if wanted."""

from __future__ import annotations

import os

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction, Shutdown
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, ThisLaunchFileDir
from launch_ros.actions import Node

# Arguments that set the simulator's parameter of their name, with their types.
SETTINGS = {
    "gripper": str,
    "frame_id": str,
    "profile": str,
    "radius": float,
    "fault": str,
    "estimate_noise": float,
    "stiffness_factor": float,
    "real_time_factor": float,
}
# Arguments of gripper.launch.py.
PASSED_ON = ("gripper", "frame_id", "namespace", "parameters", "use_sim_time", "log_level")


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription(
        [
            *_arguments(),
            OpaqueFunction(function=node_and_simulator),
            Node(
                package="rviz2",
                executable="rviz2",
                namespace=LaunchConfiguration("namespace"),
                arguments=["-d", [ThisLaunchFileDir(), "/../rviz/spiral_gripper.rviz"]],
                condition=IfCondition(LaunchConfiguration("rviz")),
            ),
        ]
    )


def node_and_simulator(context: LaunchContext) -> list[object]:
    """Return both, or neither: an argument that cannot be must not leave a node running."""
    given = {name: LaunchConfiguration(name).perform(context) for name in SETTINGS}
    values = {name: typed(name, value) for name, value in given.items() if value}
    return [
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource([ThisLaunchFileDir(), "/gripper.launch.py"]),
            launch_arguments={
                **{name: LaunchConfiguration(name) for name in PASSED_ON},
                "required": "true",
            }.items(),
        ),
        # Two nodes in one process: no name here, which would be given to both.
        Node(
            package="spiral_gripper_ros",
            executable="spiral_gripper_simulator",
            namespace=LaunchConfiguration("namespace"),
            output="screen",
            ros_arguments=["--log-level", LaunchConfiguration("log_level").perform(context)],
            parameters=[
                {
                    "publish_clock": LaunchConfiguration("use_sim_time").perform(context) == "true",
                    **values,
                }
            ],
            additional_env={"SPIRAL_GRIPPER_STARTED_BY": str(os.getpid())},
            on_exit=[OpaqueFunction(function=end_without_simulator)],
        ),
    ]


def typed(name: str, text: str) -> str | float:
    """Return an argument's value as the simulator takes it."""
    if SETTINGS[name] is str:
        return text
    try:
        return float(text)
    except ValueError:
        raise RuntimeError(f"launch argument {name} must be a number, got {text!r}") from None


def end_without_simulator(context: LaunchContext) -> list[Shutdown]:
    return [] if context.is_shutdown else [Shutdown(reason="the simulator has ended")]


def _arguments() -> list[DeclareLaunchArgument]:
    described = {
        "namespace": "namespace of all nodes",
        "frame_id": "the gripper's base frame; default: gripper_base",
        "profile": "the object's radius over time: constant, step, sine or none",
        "radius": "the object's radius [m]; default: the middle of the gripper's range",
        "estimate_noise": "standard deviation of the radius estimates [m]",
        "fault": "fault of the regulator: none, leak, stuck_valve or lost_link",
        "stiffness_factor": "real stiffness of the gripper, as a multiple of the described one",
        "real_time_factor": "speed of the simulation; acts when use_sim_time is true",
    }
    return [
        *(
            DeclareLaunchArgument(name, default_value="", description=text)
            for name, text in described.items()
        ),
        DeclareLaunchArgument(
            "gripper",
            default_value="paper_design_70",
            description="name of a shipped gripper, or path of a description file, for node and "
            "simulator; overrides the parameters file",
        ),
        DeclareLaunchArgument(
            "parameters",
            default_value=[ThisLaunchFileDir(), "/../config/gripper.yaml"],
            description="YAML file of the gripper node's parameters",
        ),
        DeclareLaunchArgument(
            "use_sim_time",
            default_value="false",
            choices=["true", "false"],
            description="whether the simulator publishes /clock and the node uses it",
        ),
        DeclareLaunchArgument(
            "log_level",
            default_value="info",
            choices=["debug", "info", "warn", "error", "fatal"],
            description="lowest level that is logged",
        ),
        DeclareLaunchArgument(
            "rviz",
            default_value="false",
            choices=["true", "false"],
            description="whether to start RViz",
        ),
    ]
