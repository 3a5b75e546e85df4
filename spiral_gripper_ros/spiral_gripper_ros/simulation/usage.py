# SPDX-License-Identifier: Apache-2.0
"""The help text of `spiral_gripper_simulator --help`."""

from __future__ import annotations

from collections.abc import Iterable

from spiral_gripper_ros.parameters.spec import ParameterSpec
from spiral_gripper_ros.simulation.parameters import RADIUS_PARAMETERS, REGULATOR_PARAMETERS

_HEAD = """\
usage: spiral_gripper_simulator [--help] [--ros-args -p NAME:=VALUE ... -r FROM:=TO ...]

A simulated regulator, gripper and source of radii: the node without hardware.

  subscribes pressure_command [Pa gauge]
  publishes  measured_pressure, object_radius, /diagnostics; /clock if asked to
             simulated/pressure, simulated/object_radius, simulated/grip, simulated/backbone
  serves     simulated_regulator/inject_leak, inject_stuck_valve, inject_lost_link, clear_fault

example:
  spiral_gripper_simulator --ros-args -r __ns:=/left -p radius:=0.02 -p fault:=leak
"""


def simulator_usage() -> str:
    """Return the help text, with every parameter of the tables."""
    return (
        f"{_HEAD}\nparameters of simulated_regulator (with their defaults):\n"
        f"{_lines(REGULATOR_PARAMETERS)}\nparameters of radius_source:\n{_lines(RADIUS_PARAMETERS)}"
    )


def _lines(table: Iterable[ParameterSpec]) -> str:
    return "".join(f"  {spec.name} ({spec.default}): {spec.description}\n" for spec in table)
