# SPDX-License-Identifier: Apache-2.0
"""A gripper's table of grips in a JSON file beside its description."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from spiral_core.grip.curve import GripCurve
from spiral_core.grip.table import GripTable
from spiral_gripper.files.beside import path_beside, read_beside, write_beside
from spiral_gripper.files.description import GripperDescription

SUFFIX = ".grips.json"
# Values of a grip that a file holds; its arrays are lists there, and what is infinite is null.
_NUMBERS = ("tip_pressure", "onset_wrap", "onset_curling", "loss", "highest_good", "top")
_LISTS = (
    "pressures", "contact_lengths", "normal_forces", "force_pressures", "away", "towards", "down",
    "settling",
)  # fmt: skip


def grips_path(description: GripperDescription) -> Path:
    """Return the path of the table of grips that belongs to a description file."""
    return path_beside(description, SUFFIX)


def write_grips(table: GripTable, description: GripperDescription) -> Path:
    """Write a table of grips beside the description that it is of; return its path.

    Raises:
        FileError: it cannot be written.
    """
    grips = [grip for grip in table.grips if grip is not None]
    document = {
        "friction": grips[0].friction if grips else None,
        "gravity": table.gravity,
        "rate": table.rate,
        "radii": table.radii,
        "errors": table.errors,
        "grips": [
            grip and {name: getattr(grip, name) for name in (*_NUMBERS, *_LISTS)}
            for grip in table.grips
        ],
    }
    return write_beside(description, SUFFIX, document)


def read_grips(description: GripperDescription) -> GripTable:
    """Return the table of grips beside a description file.

    Raises:
        FileError: see :func:`~spiral_gripper.files.beside.read_beside`.
    """
    document = read_beside(description, SUFFIX, "grip {} --table")
    x, y, z = document["gravity"]
    return GripTable(
        radii=tuple(document["radii"]),
        grips=tuple(grip and _curve(grip, document["friction"]) for grip in document["grips"]),
        errors=tuple(_number(error) for error in document["errors"]),
        gravity=(x, y, z),
        rate=document["rate"],
    )


def _curve(grip: dict[str, Any], friction: float) -> GripCurve:
    values: dict[str, Any] = {name: _number(grip[name]) for name in _NUMBERS}
    values |= {name: np.array(grip[name], dtype=float) for name in _LISTS}  # null: NaN
    return GripCurve(friction=friction, **values)


def _number(value: float | None) -> float:
    return math.inf if value is None else value
