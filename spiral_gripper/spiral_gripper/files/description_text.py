# SPDX-License-Identifier: Apache-2.0
"""Saving of descriptions: the file's own text and comments, with the new values."""

from __future__ import annotations

import dataclasses
import io
import math
import os
from pathlib import Path

from spiral_core import FiberAngles
from spiral_gripper.files.catalog import read_description_text
from spiral_gripper.files.description import GripperDescription, parse_description
from spiral_gripper.files.fields import LAWS
from spiral_gripper.files.storage import write_file
from spiral_gripper.files.units import Dimension, convert_from_si

# Twelve digits: rounding is far below manufacturing tolerances.
_DIGITS = 12


def save_description(
    description: GripperDescription, path: str | os.PathLike[str], *, replace: bool = False
) -> None:
    """Write a gripper description file.

    Args:
        description: the content; values that changed since its file was read replace the old
            ones, and comments stay.
        path: the file.
        replace: whether a file of this name may be replaced.

    Raises:
        FileError: it exists, or cannot be written.

    Example:
        >>> import tempfile
        >>> from dataclasses import replace
        >>> from spiral_gripper import load_description, load_gripper
        >>> paper = load_description("paper_design_70")
        >>> shorter = replace(paper.gripper, tube=replace(paper.gripper.tube, length=0.3))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     save_description(replace(paper, gripper=shorter), f"{folder}/shorter.yaml")
        ...     print(load_gripper(f"{folder}/shorter.yaml").tube.length)
        0.3
    """
    write_file(Path(path), description_text(description), replace=replace)


def description_text(description: GripperDescription) -> str:
    """Return the text of a description file; see :func:`save_description`."""
    from ruamel.yaml import YAML

    text = read_description_text(description.source)
    old, new = (_fields(one) for one in (parse_description(text, description.source), description))
    yaml = YAML(typ="rt")
    yaml.preserve_quotes = True
    yaml.width = 4096
    root = yaml.load(text)
    for name, value in new.items():
        if old.get(name) != value:
            *sections, key = name.split(".")
            place = root
            for section in sections:
                place = place.setdefault(section, {})
            place[key] = value
    stream = io.StringIO()
    yaml.dump(root, stream)
    return stream.getvalue()


def _fields(description: GripperDescription) -> dict[str, object]:
    """Return the values that may have changed, by dotted field, as files write them."""
    actuator, gripper = description.actuator, description.gripper
    tube, fibers = gripper.tube, actuator.fibers
    angles = (fibers.alpha, fibers.beta) if isinstance(fibers, FiberAngles) else (fibers.angle,)
    fields: dict[str, object] = {
        "name": gripper.name,
        "tube.inner_radius": _in("mm", tube.inner_radius, Dimension.LENGTH),
        "tube.wall_thickness": _in("mm", tube.wall_thickness, Dimension.LENGTH),
        "tube.length": _in("mm", tube.length, Dimension.LENGTH),
        "limits.pressure_max": _in("kPa", gripper.pressure_max, Dimension.PRESSURE),
        "grip.turns_required": gripper.turns_required,
        "mount.gravity_magnitude": _in(
            "m/s^2", math.hypot(*gripper.gravity), Dimension.ACCELERATION
        ),
        "mount.gravity_direction": _direction(gripper.gravity),
        "mount.object_axis": "fitted" if gripper.object_axis is None else [*gripper.object_axis],
    }
    for name, angle in zip(("alpha", "beta"), angles, strict=False):
        fields[f"fibers.{name}"] = _in("deg", angle, Dimension.ANGLE)
    if gripper.friction_coefficient is not None:
        fields["grip.friction_coefficient"] = gripper.friction_coefficient
    law = actuator.material
    fields["material.law"] = next(name for name, kind in LAWS.items() if isinstance(law, kind))
    for constant in dataclasses.fields(law):  # type: ignore[arg-type]  # every law of a file is one
        value = getattr(law, constant.name)
        is_ratio = constant.name == "extension_limit"
        fields[f"material.{constant.name}"] = (
            value if is_ratio else _in("kPa", value, Dimension.PRESSURE)
        )
    return fields


def _direction(gravity: tuple[float, float, float]) -> list[float]:
    """Return the direction of gravity; straight down for a gripper without gravity."""
    size = math.hypot(*gravity)
    return [round(g / size, _DIGITS) for g in gravity] if size > 0.0 else [1.0, 0.0, 0.0]


def _in(unit: str, value: float, dimension: Dimension) -> str:
    return f"{convert_from_si(value, unit, dimension):.{_DIGITS}g} {unit}"
