"""The gripper that a running node is asked to change to: read and judged before it is."""

from __future__ import annotations

from collections.abc import Mapping

from spiral_core.errors import SpiralError
from spiral_gripper import GripperDescription, load_description
from spiral_gripper.files.catalog import find_description
from spiral_gripper_ros.node.parameters import ParameterValue

# The longest description that is read while the node commands [byte]; those that are shipped have
# a thousandth of it.
LONGEST_FILE = 2_000_000


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
            self.description = _read(str(proposed["gripper"]))
        except SpiralError as error:
            return str(error)
        except ValueError as error:  # a path with a null
            return f"gripper must be the name of a gripper or the path of a file: {error}"
        return None


def _read(name_or_path: str) -> GripperDescription:
    path = find_description(name_or_path)
    # What is no plain file may never end.
    if path.exists() and not path.is_file():
        raise ValueError(f"{path} is not a file")
    if path.is_file() and path.stat().st_size > LONGEST_FILE:
        raise ValueError(f"{path} is larger than {LONGEST_FILE} bytes")
    return load_description(path)
