# SPDX-License-Identifier: Apache-2.0
"""Saving of descriptions: the file's own text and comments, with the new values."""

from __future__ import annotations

import dataclasses
import io
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spiral_core import Actuator, FiberAngles, Gripper
from spiral_gripper.files.catalog import read_description_text
from spiral_gripper.files.description import GripperDescription, parse_description
from spiral_gripper.files.fields import law_name
from spiral_gripper.files.storage import write_file
from spiral_gripper.files.units import Dimension, convert_from_si

if TYPE_CHECKING:
    from ruamel.yaml import YAML

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
    text = read_description_text(description.source)
    read = parse_description(text, description.source)
    old, new = (description_fields(one.actuator, one.gripper) for one in (read, description))
    root = read_for_change(text)
    put_fields(root, {name: value for name, value in new.items() if old.get(name) != value})
    return changed_text(root)


def read_for_change(text: str) -> Any:  # noqa: ANN401 - ruamel.yaml's map
    """Return the fields of a file's text, with its comments and its layout."""
    return _round_trip().load(text)


def put_fields(root: Any, fields: Mapping[str, object]) -> None:  # noqa: ANN401
    """Set fields, by their dotted names, in a map of sections."""
    for name, value in fields.items():
        *sections, key = name.split(".")
        place = root
        for section in sections:
            place = place.setdefault(section, {})
        place[key] = value


def changed_text(root: object) -> str:
    """Return the text of fields that :func:`read_for_change` has read."""
    stream = io.StringIO()
    _round_trip().dump(root, stream)
    return stream.getvalue()


def _round_trip() -> YAML:
    from ruamel.yaml import YAML

    yaml = YAML(typ="rt")
    yaml.preserve_quotes = True
    yaml.width = 4096
    return yaml


def description_fields(actuator: Actuator, gripper: Gripper) -> dict[str, object]:
    """Return the values of a gripper by dotted field, as files write them.

    Twelve digits are written, so that a file means this gripper.
    """
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
    if any(fiber.angle for fiber in actuator.single_fibers):
        singles = [_in("deg", fiber.angle, Dimension.ANGLE) for fiber in actuator.single_fibers]
        fields["fibers.single_angles"] = singles
    law = actuator.material
    fields["material.law"] = law_name(type(law))
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
