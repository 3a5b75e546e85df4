"""Pneumatic spiral grippers without ROS: quantities with units, files, charts, a command line.

Every public name can be imported from here. Each is loaded when it is first used, so that the
command line starts at once.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from spiral_gripper.catalog import available_grippers
    from spiral_gripper.description import GripperDescription, load_description, load_gripper
    from spiral_gripper.errors import Complaint, DescriptionError, Problem
    from spiral_gripper.tubing import Tubing, available_tubing, load_tubing, parse_tube_size
    from spiral_gripper.units import Dimension, convert_from_si, parse_quantity

_MODULE_OF_NAME = {
    "Complaint": "errors",
    "DescriptionError": "errors",
    "Dimension": "units",
    "GripperDescription": "description",
    "Problem": "errors",
    "Tubing": "tubing",
    "available_grippers": "catalog",
    "available_tubing": "tubing",
    "convert_from_si": "units",
    "load_description": "description",
    "load_gripper": "description",
    "load_tubing": "tubing",
    "parse_quantity": "units",
    "parse_tube_size": "tubing",
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
