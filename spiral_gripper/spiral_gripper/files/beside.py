# SPDX-License-Identifier: Apache-2.0
"""JSON files beside a gripper's description, each with a digest of all that its values depend on.

All values are in SI units.
"""

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

from spiral_gripper.files.description import GripperDescription
from spiral_gripper.files.storage import FileError, read_text, write_file

# Raised when the same description gets other answers: files made before are then refused.
FORMAT = 2
# Numbers of a file, and of a description where it is compared, are rounded to this many digits.
DIGITS, COMPARED_DIGITS = 6, 12
# What a description says in words; its answers depend on all other fields.
_WORDS = ("name", "description")


def path_beside(description: GripperDescription, suffix: str) -> Path:
    """Return the path of the file with a suffix that belongs to a description file.

    Example:
        >>> from spiral_gripper import load_description
        >>> path_beside(load_description("prototype_p1"), ".grips.json").name
        'prototype_p1.grips.json'
    """
    return description.source.with_suffix(suffix)


def write_beside(description: GripperDescription, suffix: str, document: dict[str, Any]) -> Path:
    """Write values beside the description that they are of; return the path.

    A list of numbers is a line each.

    Raises:
        FileError: they cannot be written.
    """
    rounded = _rounded(document, DIGITS)
    text = json.dumps({"key": _key(rounded, description)} | rounded, indent=1) + "\n"
    text = re.sub(r"\[[^][{}]*\]", lambda numbers: " ".join(numbers[0].split()), text)
    path = path_beside(description, suffix)
    write_file(path, text)
    return path


def read_beside(description: GripperDescription, suffix: str, command: str) -> dict[str, Any]:
    """Return the values of the file with a suffix beside a description.

    Args:
        description: the gripper's.
        suffix: of the file.
        command: that makes it, with ``{}`` for the description's path.

    Raises:
        FileError: there is none (its action is ``"read"``); or it cannot be used, because it was
            made for other values of the description, or by a version whose answers are others, or
            is damaged. The reason names the command that makes one.
    """
    path = path_beside(description, suffix)
    remedy = f"spiral-gripper {command.format(shlex.quote(str(description.source)))}"
    if not os.path.exists(path):  # noqa: PTH110  # also where its name is too long to look up
        raise FileError(str(path), "read", f"there is no such file; {remedy} makes it")
    reason = "it belongs to another description or version, or is damaged"
    try:
        document: dict[str, Any] = json.loads(read_text(path))
        if document.pop("key") == _key(document, description):
            return document
    except FileError as error:
        reason = error.reason
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    raise FileError(str(path), "used", f"{reason}; {remedy} makes it anew")


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
