# SPDX-License-Identifier: Apache-2.0
"""Import of the ROS 2 part of a command, which is not installed on every platform."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

import click

ROS_SIDE = ("rclpy", "spiral_gripper_msgs", "spiral_gripper_ros")


def load_ros_side(module: str) -> ModuleType:
    """Return a module of ``spiral_gripper_ros``, or fail with one line if ROS 2 is missing.

    Args:
        module: its dotted name below the package.

    Raises:
        click.ClickException: a part of the ROS 2 side is not installed.
    """
    missing = [name for name in ROS_SIDE if find_spec(name) is None]
    if missing:
        raise click.ClickException(
            f"this command needs ROS 2, and {missing[0]} is not installed: on Linux x86-64 with "
            "Python 3.10 to 3.13, pip install spiral-gripper installs it"
        )
    return import_module(f"spiral_gripper_ros.{module}")
