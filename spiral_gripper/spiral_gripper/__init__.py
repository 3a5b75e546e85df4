"""Pneumatic spiral grippers without ROS: quantities with units, files, charts, a command line.

Every public name can be imported from here. Each is loaded when it is first used, so that the
command line starts at once.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from spiral_gripper.files.catalog import available_grippers
    from spiral_gripper.files.description import GripperDescription, load_description, load_gripper
    from spiral_gripper.files.errors import Complaint, DescriptionError, Problem
    from spiral_gripper.files.tubing import Tubing, available_tubing, load_tubing, parse_tube_size
    from spiral_gripper.files.units import Dimension, convert_from_si, parse_quantity

_MODULE_OF_NAME = {
    "Complaint": "files.errors",
    "DescriptionError": "files.errors",
    "Dimension": "files.units",
    "GripperDescription": "files.description",
    "Problem": "files.errors",
    "Tubing": "files.tubing",
    "available_grippers": "files.catalog",
    "available_tubing": "files.tubing",
    "convert_from_si": "files.units",
    "load_description": "files.description",
    "load_gripper": "files.description",
    "load_tubing": "files.tubing",
    "parse_quantity": "files.units",
    "parse_tube_size": "files.tubing",
}

__all__ = [
    "Complaint",
    "DescriptionError",
    "Dimension",
    "GripperDescription",
    "Problem",
    "Tubing",
    "available_grippers",
    "available_tubing",
    "convert_from_si",
    "load_description",
    "load_gripper",
    "load_tubing",
    "parse_quantity",
    "parse_tube_size",
]


def __getattr__(name: str) -> object:
    """Load the module that holds a public name when the name is first used."""
    module = _MODULE_OF_NAME.get(name)
    if module is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(f"{__name__}.{module}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(__all__)
