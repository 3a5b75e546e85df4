# SPDX-License-Identifier: Apache-2.0
"""Tubing files: the sizes that can be bought and their elastomer, with units."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from spiral_core import PressureLaw
from spiral_core.brief import brief_repr
from spiral_core.design.requirement import Elastomer, TubeSize
from spiral_core.errors import InvalidInputError
from spiral_core.message import Message
from spiral_gripper.files.catalog import TUBING, find_description, read_description_text
from spiral_gripper.files.document import Document, Entry, read_document
from spiral_gripper.files.errors import ProblemKind
from spiral_gripper.files.fields import (
    CONSTANTS,
    FIELDS,
    material_of,
    noted,
    read_values,
)
from spiral_gripper.files.plausibility import doubts_of_material, placed, warnings_of_size
from spiral_gripper.files.units import Dimension, parse_quantity

SIZE_REQUIREMENT = 'bore and wall with their units, such as "3/8 in x 1/32 in"'
# A wall thicker than this many bore radii has most likely changed places with the bore.
LARGEST_WALL = 4.0
_SIZES = "sizes"
_REQUIRED = ("name", "material.law", "material.density")
_LAW = "model.pressure_law"
_FIELDS = (*_REQUIRED, "description", _LAW, *(f"material.{c}" for c in CONSTANTS), _SIZES)


@dataclass(frozen=True, slots=True)
class Tubing:
    """The content of a tubing file, checked, in SI units.

    Attributes:
        source: the file it was read from.
        name: of the material, as reports call it.
        sizes: available tubes.
        elastomer: material of the tubes.
        warnings: values that are most likely mistakes; a line each, with its place in the file.
    """

    __repr__ = brief_repr

    source: Path
    name: str
    sizes: tuple[TubeSize, ...]
    elastomer: Elastomer
    warnings: tuple[str, ...] = ()


def available_tubing() -> tuple[str, ...]:
    """Return the names of the tubing files shipped with the package, in alphabetical order.

    Example:
        >>> available_tubing()
        ('natural_latex',)
    """
    return TUBING.names


def load_tubing(name_or_path: str | os.PathLike[str]) -> Tubing:
    """Return the content of a tubing file.

    Args:
        name_or_path: the name of a shipped file, or the path of one.

    Raises:
        DescriptionError: the file cannot be used; the error holds every problem with its place.

    Example:
        >>> tubing = load_tubing("natural_latex")
        >>> tubing.elastomer.density, tubing.sizes[0].name
        (950.0, '1/8 in x 1/32 in')
    """
    source = find_description(name_or_path, TUBING)
    text = read_description_text(source, TUBING)
    document = read_document(text, str(source), _FIELDS, (*_REQUIRED, _SIZES))
    sizes = _read_sizes(document)
    required = {name: FIELDS[name].requirement for name in _REQUIRED}
    values = read_values(document, {**required, _SIZES: f"a list of {SIZE_REQUIREMENT}"})
    with noted(document):
        law = material_of(values)
        pressure_law = PressureLaw(values.get(_LAW, PressureLaw.SECTION.value))
        density = values["material.density"]
        elastomer = Elastomer(values["name"], law, density, pressure_law)
    document.raise_problems()
    offered = tuple(size for _, size in sizes)
    warnings = placed(document, doubts_of_material(law, density))
    warnings += tuple(
        f"{document.file}:{item.line}:{item.column}: {warning}"
        for item, size in sizes
        for warning in warnings_of_size(size)
    )
    return Tubing(source, elastomer.name, offered, elastomer, warnings)


def parse_tube_size(text: str) -> TubeSize:
    """Return a size written as bore (inner diameter) and wall thickness.

    Raises:
        InvalidInputError: not two lengths with their units, or one is not positive.

    Example:
        >>> size = parse_tube_size("3/8 in x 1/32 in")
        >>> round(size.inner_radius * 1e3, 4), round(size.wall_thickness * 1e3, 5)
        (4.7625, 0.79375)
    """
    bore, separator, wall = (part.strip() for part in text.partition(" x "))
    if not separator:
        raise InvalidInputError("tube size", text, SIZE_REQUIREMENT)
    try:
        size = TubeSize(
            " ".join(text.split()),
            inner_radius=0.5 * parse_quantity(bore, Dimension.LENGTH),
            wall_thickness=parse_quantity(wall, Dimension.LENGTH),
        )
    except InvalidInputError as error:
        requirement = Message(
            "{} ({} must be {})", SIZE_REQUIREMENT, error.field, error.requirement
        )
        raise InvalidInputError("tube size", text, requirement) from None
    if size.wall_thickness > LARGEST_WALL * size.inner_radius:
        swapped = f'bore before wall, and such a wall is none (did you mean "{wall} x {bore}"?)'
        raise InvalidInputError("tube size", text, swapped)
    return size


def _read_sizes(document: Document) -> list[tuple[Entry, TubeSize]]:
    """Return the sizes that a document lists, each with its entry; what is wrong is noted."""
    entry = document.entries.get(_SIZES)
    items = () if entry is None else entry.items
    if entry is not None and not items:
        document.note(ProblemKind.WRONG, _SIZES, entry, f"a list of {SIZE_REQUIREMENT}", entry.raw)
    sizes = ((item, _read_size(document, item)) for item in items)
    return [(item, size) for item, size in sizes if size is not None]


def _read_size(document: Document, item: Entry) -> TubeSize | None:
    try:
        return parse_tube_size(item.text or item.raw)
    except InvalidInputError as error:
        document.note(ProblemKind.WRONG, _SIZES, item, error.requirement, item.raw)
        return None
