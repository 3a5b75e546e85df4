# SPDX-License-Identifier: Apache-2.0
"""The fields of gripper and tubing files, and how their values are read.

This is the format: whatever is not in :data:`FIELDS` is refused. The table of fields in
``docs/gripper_files.md`` is written from it.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from difflib import get_close_matches
from textwrap import shorten
from types import MappingProxyType
from typing import Any, TypeAlias

from spiral_core import (
    CurvatureForm,
    Gent,
    HyperelasticLaw,
    InvalidInputError,
    MooneyRivlin,
    NeoHookean,
    PressureLaw,
    Yeoh,
)
from spiral_core.validation import require_direction
from spiral_gripper.files.document import Document, Entry
from spiral_gripper.files.errors import ProblemKind
from spiral_gripper.files.shown import shown_message, units_shown
from spiral_gripper.files.units import (
    PLAIN_NUMBER,
    Dimension,
    convert_from_si,
    parse_number,
    parse_quantity,
    unit_of,
)

FITTED = "fitted"
NO_FAMILY = "none"

LAWS = MappingProxyType(
    {"neo_hookean": NeoHookean, "mooney_rivlin": MooneyRivlin, "yeoh": Yeoh, "gent": Gent}
)
# Laws of other programs, and the most similar one here.
_SIMILAR = {
    "ogden": "yeoh",
    "arruda_boyce": "gent",
    "linear": "neo_hookean",
    "linear_elastic": "neo_hookean",
    "hookean": "neo_hookean",
}
_DIRECTION = "three finite numbers, not all zero, such as [1, 0, 0] (x, y, z of the base frame)"

Vector = tuple[float, float, float]
# SI floats for quantities, tuples of them for lists; floats, text and booleans; unit vectors for
# directions; None for an object axis that is fitted.
Values: TypeAlias = dict[str, Any]


class _RefusedError(Exception):
    """A value is not what its field requires; the text adds to the requirement."""


@dataclass(frozen=True, slots=True)
class Field:
    """One field of the format.

    Attributes:
        kind: what its value looks like, in a word.
        requirement: what a value must be, to complete "must be ...".
        read: returns the value of an entry.
        allowed: which of such values are accepted, for the page of documentation.
        default: what leaving it out means, for that page.
        required: whether a file must have it.
        dimension: what a quantity measures; None for the other kinds.
    """

    kind: str
    requirement: str
    read: Callable[[Entry], Any]
    allowed: str = "any"
    default: str = ""
    required: bool = False
    dimension: Dimension | None = None


def _quantity(
    dimension: Dimension, allowed: str = "> 0", default: str = "", required: bool = False
) -> Field:
    def read(entry: Entry) -> float:
        return parse_quantity(entry.text or entry.raw, dimension)

    requirement = dimension.requirement
    return Field(dimension.quantity, requirement, read, allowed, default, required, dimension)


def _family(dimension: Dimension, allowed: str) -> Field:
    """Return the field of an angle that a gripper with one family of fibers lacks."""
    angle = _quantity(dimension, allowed, required=True)
    return replace(
        angle,
        requirement=f"{angle.requirement}, or {NO_FAMILY} for one family alone",
        read=lambda entry: None if entry.text == NO_FAMILY else angle.read(entry),
    )


def _list(
    kind: str, dimension: Dimension, example: str, allowed: str = "any", default: str = ""
) -> Field:
    """Return the field of a list of quantities; only one with a default may be empty."""
    requirement = f"a list of {kind} with their units, such as {example}"

    def read(entry: Entry) -> tuple[float, ...]:
        if not entry.items and not (default and entry.raw == "[]"):
            raise _RefusedError
        try:
            return tuple(parse_quantity(item.text or item.raw, dimension) for item in entry.items)
        except InvalidInputError as error:
            raise _RefusedError(f"; one of its items: {error}") from None

    return Field(kind, requirement, read, allowed, default)


def _choice(choices: tuple[str, ...], default: str = "", required: bool = False) -> Field:
    def read(entry: Entry) -> str:
        if entry.tag != "str" or entry.text not in choices:
            asked = entry.text.lower().replace("-", "_").replace(" ", "_")
            nearest = get_close_matches(_SIMILAR.get(asked, asked), choices, n=1)
            raise _RefusedError(f" (did you mean {nearest[0]}?)" if nearest else "")
        return entry.text

    allowed = ", ".join(f"`{choice}`" for choice in choices)
    requirement = f"one of {', '.join(choices)}"
    return Field("choice", requirement, read, allowed, default, required)


def _switch(default: str) -> Field:
    def read(entry: Entry) -> bool:
        if entry.tag != "bool" or entry.text not in ("true", "false"):
            raise _RefusedError
        return entry.text == "true"

    return Field("switch", "true or false", read, "`true`, `false`", default)


def _number(allowed: str, default: str = "") -> Field:
    return Field("number", PLAIN_NUMBER, _read_number, allowed, default)


def _read_number(entry: Entry) -> float:
    return parse_number(entry.text if entry.tag in ("int", "float") else entry.raw)


def _read_text(entry: Entry) -> str:
    if entry.tag != "str":
        raise _RefusedError
    return entry.text.strip()


def _read_name(entry: Entry) -> str:
    name = _read_text(entry)
    if not name or not name.isprintable():
        raise _RefusedError
    return name


def _read_direction(entry: Entry) -> Vector:
    try:
        return require_direction("direction", [_read_number(item) for item in entry.items])
    except InvalidInputError:  # not three, not numbers, or zero
        raise _RefusedError from None


_TEXT = "text, in quotes if it looks like a number"
_WOUND = "-90 to 90 deg, not 0"
FIELDS = MappingProxyType(
    {
        "name": Field("name", f"one line of {_TEXT}", _read_name, required=True),
        "description": Field("text", _TEXT, _read_text, default="empty"),
        **dict.fromkeys(
            ("tube.inner_radius", "tube.wall_thickness", "tube.length"),
            _quantity(Dimension.LENGTH, required=True),
        ),
        "fibers.alpha": _quantity(Dimension.ANGLE, _WOUND, required=True),
        "fibers.beta": _family(Dimension.ANGLE, f"{_WOUND}, or `{NO_FAMILY}`"),
        "fibers.straight_fiber_radius": _quantity(Dimension.LENGTH, default="`tube.inner_radius`"),
        "fibers.single_angles": _list(
            "angles", Dimension.ANGLE, '"[0 deg]"; "[]" is none', "-80 to 80 deg",
            "one straight fiber",
        ),
        "fibers.single_positions": _list(
            "angles", Dimension.ANGLE, '"[0 deg]"; "[]" is none', "as many as the angles", "0 deg"
        ),
        "material.law": _choice(tuple(LAWS), required=True),
        **dict.fromkeys(
            ("material.c1", "material.c2", "material.c3", "material.shear_modulus"),
            _quantity(Dimension.PRESSURE, "by the law"),
        ),
        "material.extension_limit": _number("by the law"),
        "material.density": _quantity(Dimension.DENSITY, required=True),
        "measured.pressures": _list(
            "pressures", Dimension.PRESSURE, '"[0 kPa, 20 kPa, 40 kPa]"', "rising from 0"
        ),
        "measured.curvatures": _list(
            "curvatures", Dimension.CURVATURE, '"[0 rad/m, 8 rad/m, 18 rad/m]"', "never falling"
        ),
        "measured.torsions": _list(
            "curvatures", Dimension.CURVATURE, '"[0 rad/m, 8 rad/m, 18 rad/m]"'
        ),
        "model.curvature_form": _choice(
            tuple(form.value for form in CurvatureForm), "`first_order` with one straight fiber"
        ),
        "model.pressure_law": _choice(tuple(law.value for law in PressureLaw), "`section`"),
        "model.twist_shear": _switch("`true`"),
        "model.thick_wall": _switch("`false`"),
        **dict.fromkeys(
            ("stiffness.bending", "stiffness.torsional"),
            _quantity(Dimension.FLEXURAL_STIFFNESS, default="from tube and material"),
        ),
        "stiffness.section_at": _quantity(
            Dimension.PRESSURE, "0 to the pressure limit", "stiffness of the annulus"
        ),
        "extra_mass_per_length": _quantity(Dimension.MASS_PER_LENGTH, ">= 0", "`0 kg/m`"),
        "mount.gravity_direction": Field(
            "direction", _DIRECTION, _read_direction, "not zero", required=True
        ),
        "mount.gravity_magnitude": _quantity(Dimension.ACCELERATION, ">= 0", "`9.80665 m/s^2`"),
        "mount.object_axis": Field(
            "axis", f"{FITTED}, or {_DIRECTION}",
            lambda entry: None if entry.text == FITTED else _read_direction(entry),
            "not zero", "`fitted`",
        ),
        "limits.pressure_max": _quantity(Dimension.PRESSURE, required=True),
        "grip.turns_required": _number("> 0", "`1.05`"),
        "grip.friction_coefficient": _number("0 to 10", "unknown"),
    }
)  # fmt: skip

REQUIRED = {name: field.requirement for name, field in FIELDS.items() if field.required}
CONSTANTS = tuple(
    dict.fromkeys(constant.name for law in LAWS.values() for constant in dataclasses.fields(law))
)
# The fields of a measured curve: all of them or none.
MEASURED = {
    name: field.requirement for name, field in FIELDS.items() if name.startswith("measured.")
}
# The core's argument names are the last parts of the dotted names.
_FIELD_OF_ARGUMENT = {name.rpartition(".")[2]: name for name in FIELDS} | {
    "single_fibers": "fibers.single_angles"
}


def constants_of(law: str) -> tuple[str, ...]:
    """Return the names of the constants that a law takes.

    Example:
        >>> constants_of("gent")
        ('shear_modulus', 'extension_limit')
    """
    return tuple(constant.name for constant in dataclasses.fields(LAWS[law]))


def material_of(values: Values) -> HyperelasticLaw:
    """Return the material that values of fields describe."""
    law: str = values["material.law"]
    material: HyperelasticLaw = LAWS[law](
        *(values[f"material.{name}"] for name in constants_of(law))
    )
    return material


def law_name(law: type) -> str:
    """Return the name of a law, as files have it.

    Example:
        >>> law_name(Gent)
        'gent'
    """
    return next(name for name, known in LAWS.items() if known is law)


def fiber_angle_requirement(angle: float, text: str) -> str:
    """Return what the angle of a wound fiber to the tube's axis must be.

    Args:
        angle: the one that was refused [rad].
        text: how it was written.

    Example:
        >>> print(fiber_angle_requirement(math.radians(165.0), "165 deg"))
        an angle from -90 to 90 deg, not 0 (165 deg, if counted from 0 to 180 deg, is -15 deg here)
    """
    requirement = f"an angle from {_WOUND}"
    if not 0.5 * math.pi < angle < math.pi:
        return requirement
    unit = unit_of(text, Dimension.ANGLE)
    meant = f"{convert_from_si(angle - math.pi, unit, Dimension.ANGLE):.9g} {unit}"
    return f"{requirement} ({text}, if counted from 0 to 180 deg, is {meant} here)"


def read_values(document: Document, required: Mapping[str, str]) -> Values:
    """Return the values of a document's entries that are fields of the format.

    Args:
        document: the file's entries.
        required: fields that a file must have, and what they must be.

    Raises:
        DescriptionError: fields are unknown, repeated, missing or wrong; all of them are in it.
    """
    values: Values = {}
    for name, entry in document.entries.items():
        field = FIELDS.get(name)
        if field is None:  # such as the sizes of a tubing file
            continue
        if entry.tag == "null":
            document.note(ProblemKind.MISSING, name, entry, field.requirement)
            continue
        try:
            values[name] = field.read(entry)
        except InvalidInputError as error:
            document.note(ProblemKind.WRONG, name, entry, error.requirement, entry.raw)
        except _RefusedError as refused:
            requirement = f"{field.requirement}{refused}"
            document.note(ProblemKind.WRONG, name, entry, requirement, entry.raw)
    law = values.get("material.law")
    constants = constants_of(law) if law else ()  # else it is noted as missing or wrong
    needed = {name: FIELDS[name].requirement for name in (f"material.{one}" for one in constants)}
    for name in (f"material.{one}" for one in CONSTANTS if law):
        if name in document.entries and name not in needed:
            advice = f"the constants of {law} are {', '.join(constants)}"
            document.note(ProblemKind.UNKNOWN, name, document.entries[name], advice)
    for name, requirement in {**needed, **required}.items():
        if name not in document.entries:
            section = document.sections.get(name.rpartition(".")[0])
            document.note(ProblemKind.MISSING, name, section, requirement)
    document.raise_problems()
    return values


@contextmanager
def noted(document: Document) -> Iterator[None]:
    """Note an argument that the core refuses in the block, under its name and place in the file.

    An error may name several arguments ("c1 + c2") or a whole part ("fibers"): each argument gets
    its name in the file, and the place is the first one's, or the section's.
    """
    try:
        yield
    except InvalidInputError as error:
        arguments = [a for a in re.findall(r"\w+", error.field) if a in _FIELD_OF_ARGUMENT]
        names = [_FIELD_OF_ARGUMENT[argument] for argument in arguments]
        entries = [document.entries[name] for name in names if name in document.entries]
        units = {
            dimension: unit_of(document.entries[name].text, dimension)
            for name in names
            if name in document.entries and (dimension := FIELDS[name].dimension)
        }
        with units_shown(units):
            requirement = shown_message(error.requirement)
        if names in (["fibers.alpha"], ["fibers.beta"]) and isinstance(error.value, float):
            requirement = fiber_angle_requirement(error.value, entries[0].text)
        document.note(
            ProblemKind.WRONG,
            re.sub(r"\w+", lambda word: _FIELD_OF_ARGUMENT.get(word[0], word[0]), error.field),
            entries[0] if entries else document.sections.get(error.field),
            requirement,
            ", ".join(entry.raw for entry in entries) or shorten(str(error.value), 80),
        )
