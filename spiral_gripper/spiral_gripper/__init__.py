# SPDX-License-Identifier: Apache-2.0
"""Pneumatic spiral grippers without ROS: quantities with units, files, charts, a command line.

Every public name can be imported from here and is loaded when it is first used, so that the command
line starts at once. Names are added to :data:`_NAMES` and to ``__init__.pyi``, which type checkers
read.
"""

from importlib import import_module

_NAMES = {
    "files.catalog": ("available_grippers",),
    "files.description": ("GripperDescription", "load_description", "load_gripper"),
    "files.description_text": ("save_description",),
    "files.errors": ("ProblemKind", "DescriptionError", "Problem"),
    "files.shown": ("display_units",),
    "files.tubing": ("Tubing", "available_tubing", "load_tubing", "parse_tube_size"),
    "pictures": ("plot",),
    "files.units": ("Dimension", "convert_from_si", "parse_quantity"),
}
_MODULE_OF_NAME = {name: module for module, names in _NAMES.items() for name in names}

__all__ = sorted(_MODULE_OF_NAME)  # noqa: PLE0605 - computed, so that no name is stated twice


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
    return list(__all__)
