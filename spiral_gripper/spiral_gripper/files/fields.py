# SPDX-License-Identifier: Apache-2.0
"""The fields of a gripper description file, and how each is read from its text.

This is the format: whatever is not in :data:`FIELDS` is refused. ``docs/gripper_files.md``
describes it, and is tested against it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from enum import Enum
from types import MappingProxyType
from typing import Final, cast

from spiral_core import (
    CurvatureForm,
    Gent,
    InvalidInputError,
    MooneyRivlin,
    NeoHookean,
    PressureLaw,
    Yeoh,
)
from spiral_core.validation import require_direction
from spiral_gripper.files.document import Entry
from spiral_gripper.files.units import (
    PLAIN_NUMBER,
    Dimension,
    convert_from_si,
    parse_number,
    parse_quantity,
    unit_of,
)

FITTED: Final = "fitted"
NO_FAMILY: Final = "none"

LAWS: Final = MappingProxyType(
    {"neo_hookean": NeoHookean, "mooney_rivlin": MooneyRivlin, "yeoh": Yeoh, "gent": Gent}
)


# Laws of other programs, and the most similar one here.
_SIMILAR: Final = {
    "ogden": "yeoh",
    "arruda_boyce": "gent",
    "linear": "neo_hookean",
    "linear_elastic": "neo_hookean",
    "hookean": "neo_hookean",
}


class Kind(Enum):
    """Kinds of values; each value is the requirement, unless the field has its own."""

    QUANTITY = "a number with a unit"
    FAMILY = "an angle, or none"
    NUMBER = PLAIN_NUMBER
    NAME = "one line of text, in quotes if it looks like a number"
    TEXT = "text, in quotes if it looks like a number"
    CHOICE = "one of the names"
    SWITCH = "true or false"
    DIRECTION = "three finite numbers, not all zero, such as [1, 0, 0] (x, y, z of the base frame)"
    PRESSURES = 'a list of pressures with their units, such as "[0 kPa, 20 kPa, 40 kPa]"'
    CURVATURES = 'a list of curvatures with their units, such as "[0 rad/m, 8 rad/m, 18 rad/m]"'
    ANGLES = 'a list of angles with their units, such as "[0 deg]"; "[]" is none'
    AXIS = (
        f"{FITTED}, or three finite numbers, not all zero, such as [1, 0, 0] "
        "(x, y, z of the base frame)"
    )


@dataclass(frozen=True, slots=True)
class Field:
    """One field of the format.

    Attributes:
        kind: what its value looks like.
        required: whether a file must have it.
        dimension: what a quantity measures; None for the other kinds.
        choices: the names a choice allows.
        allowed: which of such values are accepted, for the page of documentation.
        default: what leaving it out means, for that page.
    """

    kind: Kind
    required: bool = False
    dimension: Dimension | None = None
    choices: tuple[str, ...] = ()
    allowed: str = "any"
    default: str = ""

    @property
    def requirement(self) -> str:
        """What a value must be, to complete "must be ..."."""
        if self.dimension is not None and self.kind is Kind.FAMILY:
            return f"{self.dimension.requirement}, or {NO_FAMILY} for one family alone"
        if self.dimension is not None:
            return self.dimension.requirement
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        return self.kind.value


def _quantity(
    dimension: Dimension, required: bool = False, allowed: str = "> 0", default: str = ""
) -> Field:
    return Field(Kind.QUANTITY, required, dimension, allowed=allowed, default=default)


FIELDS: Final = MappingProxyType(
    {
        "name": Field(Kind.NAME, required=True),
        "description": Field(Kind.TEXT, default="empty"),
        "tube.inner_radius": _quantity(Dimension.LENGTH, required=True),
        "tube.wall_thickness": _quantity(Dimension.LENGTH, required=True),
        "tube.length": _quantity(Dimension.LENGTH, required=True),
        "fibers.alpha": _quantity(Dimension.ANGLE, required=True, allowed="-90 to 90 deg, not 0"),
        "fibers.beta": Field(
            Kind.FAMILY,
            required=True,
            dimension=Dimension.ANGLE,
            allowed="-90 to 90 deg, not 0, or `none`",
        ),
        "fibers.straight_fiber_radius": _quantity(Dimension.LENGTH, default="`tube.inner_radius`"),
        "fibers.single_angles": Field(
            Kind.ANGLES, allowed="-80 to 80 deg", default="one straight fiber"
        ),
        "fibers.single_positions": Field(
            Kind.ANGLES, allowed="as many as the angles", default="0 deg"
        ),
        "material.law": Field(Kind.CHOICE, required=True, choices=tuple(LAWS)),
        "material.c1": _quantity(Dimension.PRESSURE, allowed="by the law"),
        "material.c2": _quantity(Dimension.PRESSURE, allowed="by the law"),
        "material.c3": _quantity(Dimension.PRESSURE, allowed="by the law"),
        "material.shear_modulus": _quantity(Dimension.PRESSURE, allowed="by the law"),
        "material.extension_limit": Field(Kind.NUMBER, allowed="by the law"),
        "material.density": _quantity(Dimension.DENSITY, required=True),
        "measured.pressures": Field(Kind.PRESSURES, allowed="rising from 0"),
        "measured.curvatures": Field(Kind.CURVATURES, allowed="never falling"),
        "measured.torsions": Field(Kind.CURVATURES),
        "model.curvature_form": Field(
            Kind.CHOICE,
            choices=tuple(form.value for form in CurvatureForm),
            default="`first_order` with one straight fiber",
        ),
        "model.pressure_law": Field(
            Kind.CHOICE, choices=tuple(law.value for law in PressureLaw), default="`section`"
        ),
        "model.twist_shear": Field(Kind.SWITCH, default="`true`"),
        "model.thick_wall": Field(Kind.SWITCH, default="`false`"),
        "stiffness.bending": _quantity(
            Dimension.FLEXURAL_STIFFNESS, default="from tube and material"
        ),
        "stiffness.torsional": _quantity(
            Dimension.FLEXURAL_STIFFNESS, default="from tube and material"
        ),
        "stiffness.section_at": _quantity(
            Dimension.PRESSURE,
            allowed="0 to the pressure limit",
            default="stiffness of the annulus",
        ),
        "extra_mass_per_length": _quantity(
            Dimension.MASS_PER_LENGTH, allowed=">= 0", default="`0 kg/m`"
        ),
        "mount.gravity_direction": Field(Kind.DIRECTION, required=True, allowed="not zero"),
        "mount.gravity_magnitude": _quantity(
            Dimension.ACCELERATION, allowed=">= 0", default="`9.80665 m/s^2`"
        ),
        "mount.object_axis": Field(Kind.AXIS, allowed="not zero", default="`fitted`"),
        "limits.pressure_max": _quantity(Dimension.PRESSURE, required=True),
        "grip.turns_required": Field(Kind.NUMBER, allowed="> 0", default="`1.05`"),
        "grip.friction_coefficient": Field(Kind.NUMBER, allowed=">= 0", default="unknown"),
    }
)

REQUIRED: Final = tuple(name for name, field in FIELDS.items() if field.required)
CONSTANTS: Final = tuple(
    dict.fromkeys(constant.name for law in LAWS.values() for constant in dataclasses.fields(law))
)


def constants_of(law: str) -> tuple[str, ...]:
    """Return the names of the constants that a law takes.

    Example:
        >>> constants_of("gent")
        ('shear_modulus', 'extension_limit')
    """
    return tuple(constant.name for constant in dataclasses.fields(LAWS[law]))


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
    requirement = "an angle from -90 to 90 deg, not 0"
    if not 0.5 * math.pi < angle < math.pi:
        return requirement
    unit = unit_of(text, Dimension.ANGLE)
    meant = f"{convert_from_si(angle - math.pi, unit, Dimension.ANGLE):.9g} {unit}"
    return f"{requirement} ({text}, if counted from 0 to 180 deg, is {meant} here)"


Vector = tuple[float, float, float]
Value = float | str | bool | Vector | tuple[float, ...] | None


def read_value(name: str, entry: Entry) -> Value:
    """Return the value of a field from what a file holds in its place.

    Args:
        name: dotted name of the field, a key of :data:`FIELDS`.
        entry: what the file holds there.

    Returns:
        SI floats for quantities, and tuples of them for lists; floats, text and booleans; unit
        vectors for directions; None for an object axis that is fitted.

    Raises:
        InvalidInputError: the entry is not what the field requires.

    Example:
        >>> read_value("tube.length", Entry(1, 1, "500 mm", "str", "500 mm"))
        0.5
    """
    field = FIELDS[name]
    try:
        return _READERS[field.kind](field, entry)
    except InvalidInputError as error:
        raise InvalidInputError(name, entry.raw, error.requirement) from None


def _read_quantity(field: Field, entry: Entry) -> float:
    dimension = cast("Dimension", field.dimension)  # every field of this kind has one
    return parse_quantity(entry.text or entry.raw, dimension)


def _read_family(field: Field, entry: Entry) -> float | None:
    return None if entry.text == NO_FAMILY else _read_quantity(field, entry)


def _read_number(_field: Field, entry: Entry) -> float:
    return parse_number(entry.text if entry.tag in ("int", "float") else entry.raw)


def _read_name(field: Field, entry: Entry) -> str:
    name = _read_text(field, entry)
    if not name or not name.isprintable():
        raise _refusal(field, entry)
    return name


def _read_text(field: Field, entry: Entry) -> str:
    if entry.tag != "str":
        raise _refusal(field, entry)
    return entry.text.strip()


def _read_choice(field: Field, entry: Entry) -> str:
    if entry.tag != "str" or entry.text not in field.choices:
        asked = entry.text.lower().replace("-", "_").replace(" ", "_")
        nearest = get_close_matches(_SIMILAR.get(asked, asked), field.choices, n=1)
        hint = f" (did you mean {nearest[0]}?)" if nearest else ""
        raise InvalidInputError("", entry.raw, field.requirement + hint)
    return entry.text


def _read_switch(field: Field, entry: Entry) -> bool:
    if entry.tag != "bool" or entry.text not in ("true", "false"):
        raise _refusal(field, entry)
    return entry.text == "true"


def _read_direction(field: Field, entry: Entry) -> Vector:
    try:
        return require_direction("direction", [_read_number(field, item) for item in entry.items])
    except ValueError:  # not three, not numbers, or zero: InvalidInputError is a ValueError
        raise _refusal(field, entry) from None


def _read_list(field: Field, entry: Entry) -> tuple[float, ...]:
    dimension = _ITEMS[field.kind]
    if dimension is Dimension.ANGLE and entry.raw == "[]":
        return ()
    if not entry.items:
        raise _refusal(field, entry)
    try:
        return tuple(parse_quantity(item.text or item.raw, dimension) for item in entry.items)
    except InvalidInputError as error:
        requirement = f"{field.requirement}; one of its items: {error}"
        raise InvalidInputError("", entry.raw, requirement) from None


def _read_axis(field: Field, entry: Entry) -> Vector | None:
    return None if entry.text == FITTED else _read_direction(field, entry)


def _refusal(field: Field, entry: Entry) -> InvalidInputError:
    return InvalidInputError("", entry.raw, field.requirement)


_ITEMS: Final = {
    Kind.PRESSURES: Dimension.PRESSURE,
    Kind.CURVATURES: Dimension.CURVATURE,
    Kind.ANGLES: Dimension.ANGLE,
}
_READERS: Final[Mapping[Kind, Callable[[Field, Entry], Value]]] = MappingProxyType(
    {
        Kind.QUANTITY: _read_quantity,
        Kind.FAMILY: _read_family,
        Kind.NUMBER: _read_number,
        Kind.NAME: _read_name,
        Kind.TEXT: _read_text,
        Kind.CHOICE: _read_choice,
        Kind.SWITCH: _read_switch,
        Kind.DIRECTION: _read_direction,
        **dict.fromkeys(_ITEMS, _read_list),
        Kind.AXIS: _read_axis,
    }
)
