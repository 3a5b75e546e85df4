# SPDX-License-Identifier: Apache-2.0
"""The help text of `spiral_gripper_node --help`."""

from __future__ import annotations

from spiral_gripper_ros.parameters.spec import ParameterSpec
from spiral_gripper_ros.parameters.table import PARAMETERS

_HEAD = """\
usage: spiral_gripper_node [--help] [--ros-args -p NAME:=VALUE ... -r FROM:=TO ...]

A lifecycle node that turns object radii into the pressure of the perfect wrap.

  subscribes object_radius [m], gravity [m/s^2], measured_pressure [Pa gauge, optional]
  publishes  pressure_command [Pa gauge]
             status, backbone, measured_backbone, markers, /diagnostics
  serves     release, rearm, plan_wrap, design_gripper; actions: grasp and, with control_msgs,
             gripper_cmd and parallel_gripper_cmd

example:
  spiral_gripper_node --ros-args -r __ns:=/left -p gripper:=prototype_p1

parameters (with their defaults):
"""
_TAIL = """\

`ros2 param describe` describes each parameter of the running node; `ros2 node info` lists topics.
"""


def usage() -> str:
    """Return the help text, with every parameter of the table."""
    return _HEAD + "".join(f"  {_line(spec)}\n" for spec in PARAMETERS) + _TAIL


def _line(spec: ParameterSpec) -> str:
    default = "not set" if spec.default == () else str(spec.default)
    return f"{spec.name} ({default}): {spec.description}"
