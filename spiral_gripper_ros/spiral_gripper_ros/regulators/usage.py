# SPDX-License-Identifier: Apache-2.0
"""The help text of ``spiral_gripper_regulator --help``."""

from __future__ import annotations

from spiral_gripper_ros.regulators.parameters import REGULATOR_PARAMETERS

_HEAD = """\
usage: spiral_gripper_regulator [--help] [--ros-args -p NAME:=VALUE ... -r FROM:=TO ...]

An adapter from the gripper node to a pressure regulator: topics of its driver, a serial line, or
Modbus TCP.

  subscribes pressure_command [Pa gauge]
  publishes  measured_pressure [Pa gauge], /diagnostics

examples:
  spiral_gripper_regulator --ros-args -p device:=serial -p port:=/dev/ttyACM0
  spiral_gripper_regulator --ros-args -p command_topic:=/valve/set -p command_unit:=kPa

parameters (with their defaults):
"""


def usage() -> str:
    """Return the help text, with every parameter of the table."""
    return _HEAD + "".join(
        f"  {spec.name} ({spec.default}): {spec.description}\n" for spec in REGULATOR_PARAMETERS
    )
