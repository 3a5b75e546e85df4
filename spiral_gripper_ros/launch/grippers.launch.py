# SPDX-License-Identifier: Apache-2.0
"""Several grippers, each in a namespace of its name, with frames of its own."""

from __future__ import annotations

import re
from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    IncludeLaunchDescription,
    OpaqueFunction,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "names",
                default_value="left,right",
                description="names of the grippers, separated by commas; each name is a namespace, "
                "and the base frame is NAME_gripper_base",
            ),
            DeclareLaunchArgument(
                "simulation",
                default_value="false",
                choices=["true", "false"],
                description="whether each has a simulated regulator and object",
            ),
            OpaqueFunction(function=grippers),
        ]
    )


def grippers(context: LaunchContext) -> list[object]:
    text = LaunchConfiguration("names").perform(context)
    names = [name.strip() for name in text.split(",")]
    if len(set(names)) < len(names) or not all(map(re.compile(r"[a-z]\w*").fullmatch, names)):
        raise RuntimeError(f"launch argument names must be different names, got {text!r}")
    simulated = LaunchConfiguration("simulation").perform(context) == "true"
    file = Path(__file__).with_name(f"{'simulation' if simulated else 'gripper'}.launch.py")
    # Each in its own scope: arguments of one gripper must not become defaults of the next.
    return [
        GroupAction(
            [
                IncludeLaunchDescription(
                    PythonLaunchDescriptionSource(str(file)),
                    launch_arguments={
                        "namespace": name,
                        "frame_id": f"{name}_gripper_base",
                    }.items(),
                )
            ]
        )
        for name in names
    ]
