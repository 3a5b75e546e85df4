# SPDX-License-Identifier: Apache-2.0
"""From the entries of a file to its values, and from the core's errors to places in the file."""

from __future__ import annotations

import re
from collections.abc import Iterable
from textwrap import shorten
from typing import TypeAlias

from spiral_core import InvalidInputError
from spiral_gripper.files.document import Document
from spiral_gripper.files.errors import ProblemKind
from spiral_gripper.files.fields import (
    CONSTANTS,
    FIELDS,
    Value,
    constants_of,
    fiber_angle_requirement,
    read_value,
)

Values: TypeAlias = dict[str, Value]

# The fields of a measured curve: all of them or none.
MEASURED = "measured."

# The core's argument names are the last parts of the dotted names.
_FIELD_OF_ARGUMENT = {name.rpartition(".")[2]: name for name in FIELDS} | {
    "single_fibers": "fibers.single_angles"
}


def read_values(document: Document) -> Values:
    """Return the values of a document's entries, by dotted name.

    Raises:
        DescriptionError: fields are unknown, repeated, missing or wrong; all of them are in it.
    """
    values = read_entries(document, document.entries)
    check_constants(document, values.get("material.law"))
    curve = any(name.startswith(MEASURED) for name in document.entries)
    for name, field in FIELDS.items():
        if field.required or (curve and name.startswith(MEASURED)):
            require(document, name, field.requirement)
    document.raise_problems()
    return values


def read_entries(document: Document, names: Iterable[str]) -> Values:
    """Return the values of the named entries; note those that are wrong as problems."""
    values: Values = {}
    for name in names:
        entry, requirement = document.entries[name], FIELDS[name].requirement
        if entry.tag == "null":
            document.note(ProblemKind.MISSING, name, entry, requirement)
            continue
        try:
            values[name] = read_value(name, entry)
        except InvalidInputError as error:
            document.note(ProblemKind.WRONG, name, entry, error.requirement, entry.raw)
    return values


def note_argument(document: Document, error: InvalidInputError) -> None:
    """Note an argument that the core refused, under its name and place in the file.

    An error may name several arguments ("c1 + c2") or a whole part ("fibers"): each argument gets
    its name in the file, and the place is the first one's, or the section's.
    """
    arguments = [a for a in re.findall(r"\w+", error.field) if a in _FIELD_OF_ARGUMENT]
    names = [_FIELD_OF_ARGUMENT[argument] for argument in arguments]
    entries = [document.entries[name] for name in names if name in document.entries]
    requirement = error.requirement
    dimension = FIELDS[names[0]].dimension if names else None
    if names in (["fibers.alpha"], ["fibers.beta"]) and entries and isinstance(error.value, float):
        requirement = fiber_angle_requirement(error.value, entries[0].text)
    elif dimension is not None and isinstance(error.value, float):
        requirement += f" (it is {error.value:.9g} {dimension.si_unit})"
    document.note(
        ProblemKind.WRONG,
        re.sub(r"\w+", lambda word: _FIELD_OF_ARGUMENT.get(word[0], word[0]), error.field),
        entries[0] if entries else document.sections.get(error.field),
        requirement,
        ", ".join(entry.raw for entry in entries) or shorten(str(error.value), 80),
    )


def check_constants(document: Document, law: Value) -> None:
    """Note the constants that a law lacks, and those that it does not take."""
    if not isinstance(law, str):  # missing or wrong, and noted as such
        return
    constants = constants_of(law)
    for constant in CONSTANTS:
        name = f"material.{constant}"
        if constant in constants:
            require(document, name, FIELDS[name].requirement)
        elif name in document.entries:
            advice = f"the constants of {law} are {', '.join(constants)}"
            document.note(ProblemKind.UNKNOWN, name, document.entries[name], advice)


def require(document: Document, name: str, requirement: str) -> None:
    """Note a field that is missing, at its section if there is one."""
    if name not in document.entries:
        section = document.sections.get(name.rpartition(".")[0])
        document.note(ProblemKind.MISSING, name, section, requirement)
