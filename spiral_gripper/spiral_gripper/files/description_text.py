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
from spiral_gripper.files.fields import FIELDS, constants_of, law_name
from spiral_gripper.files.storage import write_file
from spiral_gripper.files.units import convert_from_si

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
            if place.get(section) is None:
                place[section] = {}
            place = place[section]
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
    fibers, law, name = actuator.fibers, actuator.material, law_name(type(actuator.material))
    angles = (fibers.alpha, fibers.beta) if isinstance(fibers, FiberAngles) else (fibers.angle,)
    size = math.hypot(*gripper.gravity)
    values: dict[str, float | None] = {
        **{f"tube.{one}": size for one, size in dataclasses.asdict(gripper.tube).items()},
        "limits.pressure_max": gripper.pressure_max,
        "grip.turns_required": gripper.turns_required,
        "grip.friction_coefficient": gripper.friction_coefficient,
        "mount.gravity_magnitude": size,
        **dict(zip(("fibers.alpha", "fibers.beta"), angles, strict=False)),
        **{f"material.{constant}": getattr(law, constant) for constant in constants_of(name)},
    }
    down = [round(g / size, _DIGITS) for g in gripper.gravity] if size > 0.0 else [1.0, 0.0, 0.0]
    fields: dict[str, object] = {
        "name": gripper.name,
        "mount.gravity_direction": down,
        "mount.object_axis": "fitted" if gripper.object_axis is None else [*gripper.object_axis],
        "material.law": name,
        **{one: written(one, value) for one, value in values.items() if value is not None},
    }
    singles = [fiber.angle for fiber in actuator.single_fibers]
    if any(singles):
        fields["fibers.single_angles"] = [written("fibers.alpha", angle) for angle in singles]
    return fields


def written(name: str, value: float, digits: int = _DIGITS) -> str | float:
    """Return the value of a field in SI as files write it: in the usual unit, or a plain number.

    Example:
        >>> written("tube.length", 0.5), written("grip.turns_required", 1.05)
        ('500 mm', 1.05)
    """
    dimension = FIELDS[name].dimension
    if dimension is None:
        return float(f"{value:.{digits}g}")
    unit = dimension.usual_units[0]
    return f"{convert_from_si(value, unit, dimension):.{digits}g} {unit}"
