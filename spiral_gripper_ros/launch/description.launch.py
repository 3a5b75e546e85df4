# SPDX-License-Identifier: Apache-2.0
"""The gripper's robot_description, for RViz and planners; needs xacro and robot_state_publisher."""

from __future__ import annotations

from pathlib import Path

import xacro
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

URDF = Path(__file__).resolve().parent.parent / "urdf"


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "namespace", default_value="", description="namespace of the publisher"
            ),
            DeclareLaunchArgument(
                "prefix",
                default_value="",
                description="prefix of links and joints; use left_ with frame_id left_gripper_base",
            ),
            DeclareLaunchArgument(
                "model",
                default_value=str(URDF / "paper_design_70.yaml"),
                description="file written by `spiral-gripper model`",
            ),
            DeclareLaunchArgument(
                "collision",
                default_value="wrapped",
                choices=["wrapped", "swept", "none"],
                description="spheres of the wrapped tube, a box around every shape, or none",
            ),
            OpaqueFunction(function=publisher),
        ]
    )


def publisher(context: LaunchContext) -> list[Node]:
    given = {
        name: LaunchConfiguration(name).perform(context)
        for name in ("prefix", "model", "collision")
    }
    if not Path(given["model"]).is_file():
        raise RuntimeError(f"launch argument model must be a file, got {given['model']!r}")
    given["model"] = str(Path(given["model"]).resolve())
    description = xacro.process_file(str(URDF / "spiral_gripper.urdf.xacro"), mappings=given)
    return [
        Node(
            package="robot_state_publisher",
            executable="robot_state_publisher",
            namespace=LaunchConfiguration("namespace"),
            output="screen",
            parameters=[{"robot_description": description.toxml()}],
        )
    ]
