# SPDX-License-Identifier: Apache-2.0
"""Check of a new value of the parameter ``gripper`` before it is set."""

from __future__ import annotations

from collections.abc import Mapping

from spiral_core.errors import SpiralError
from spiral_gripper import GripperDescription, load_description
from spiral_gripper_ros.parameters.spec import ParameterValue


class ProposedGripper:
    """Reads the file that the parameter ``gripper`` names when it is proposed, and keeps it."""

    def __init__(self) -> None:
        self.description: GripperDescription | None = None

    def refusal(self, proposed: Mapping[str, ParameterValue]) -> str | None:
        """Return why the gripper among these parameters cannot be used, or None."""
        self.description = None
        if "gripper" not in proposed:
            return None
        try:
            self.description = load_description(str(proposed["gripper"]))
        except SpiralError as error:
            return str(error)
        return None
