# SPDX-License-Identifier: Apache-2.0
"""A gripper's table of grips in a JSON file beside its description, in SI units."""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np

from spiral_core.grip.curve import GripCurve
from spiral_core.grip.table import GripTable
from spiral_gripper.files.description import GripperDescription
from spiral_gripper.files.storage import FileError, read_text, write_file

# Raised when the same description gets other grips: tables made before are then refused.
FORMAT = 1
# Numbers of a file, and of a description where it is compared, are rounded to this many digits.
DIGITS, COMPARED_DIGITS = 6, 12
# What a description says in words; all other fields change its grips.
_WORDS = ("name", "description")
# Values of a grip that a file holds; its arrays are lists there, and what is infinite is null.
_NUMBERS = ("tip_pressure", "onset_wrap", "onset_curling", "loss", "highest_good", "top")
_FORCES = ("contact_lengths", "normal_forces", "force_pressures", "away", "towards", "down")
_LISTS = ("pressures", *_FORCES, "settling")


def grips_path(description: GripperDescription) -> Path:
    """Return the path of the table of grips that belongs to a description file.

    Example:
        >>> from spiral_gripper import load_description
        >>> grips_path(load_description("prototype_p1")).name
        'prototype_p1.grips.json'
    """
    return description.source.with_suffix(".grips.json")


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
    rounded = _rounded(document, DIGITS)
    text = json.dumps({"key": _key(rounded, description)} | rounded, indent=1) + "\n"
    text = re.sub(
        r"\[[^][{}]*\]", lambda numbers: " ".join(numbers[0].split()), text
    )  # a line each
    path = grips_path(description)
    write_file(path, text)
    return path


def read_grips(description: GripperDescription) -> GripTable:
    """Return the table of grips beside a description file.

    Raises:
        FileError: there is none (its action is ``"read"``); or it cannot be used, because it was
            made for other values of the description, or by a version whose grips are others, or is
            damaged. The reason names the command that makes one.
    """
    path = grips_path(description)
    remedy = f"spiral-gripper grip {shlex.quote(str(description.source))} --table"
    if not os.path.exists(path):  # noqa: PTH110  # also where its name is too long to look up
        raise FileError(str(path), "read", f"there is no such file; {remedy} makes it")
    reason = "it belongs to another description or version, or is damaged"
    try:
        document = json.loads(read_text(path))
        key = document.pop("key")
        if key == _key(document, description):
            return _table(document)
    except FileError as error:
        reason = error.reason
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    raise FileError(str(path), "used", f"{reason}; {remedy} makes it anew")


def _table(document: dict[str, Any]) -> GripTable:
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


def _key(document: dict[str, Any], description: GripperDescription) -> str:
    """Return a digest of a table and of all that its grips depend on."""
    values = {n: value for n, value in description.values.items() if n not in _WORDS}
    content = [FORMAT, _rounded(values, COMPARED_DIGITS), document]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def _rounded(value: Any, digits: int) -> Any:  # noqa: ANN401
    """Return a value as JSON has it, its numbers rounded; None for those that are not finite."""
    if isinstance(value, dict):
        return {name: _rounded(each, digits) for name, each in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_rounded(each, digits) for each in value]
    if isinstance(value, float):  # numpy's too
        return float(f"{value:.{digits}g}") if math.isfinite(value) else None
    return value
