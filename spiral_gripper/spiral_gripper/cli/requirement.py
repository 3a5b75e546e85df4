# SPDX-License-Identifier: Apache-2.0
"""The options that state a design requirement, shared by ``design`` and ``sweep``."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import click

from spiral_gripper.cli.types import (
    FIBER_ANGLE,
    FRICTION,
    LENGTH,
    MASS,
    NUMBER,
    PRESSURE,
    SINGLE_FIBER_ANGLE,
    mount_options,
    option,
    together,
    turns_option,
    unit_vector,
)

if TYPE_CHECKING:
    from spiral_core.design.requirement import DesignRequirement
    from spiral_core.rod.types import Vector

PREFERENCES = ("least-strain", "least-pressure", "shortest", "largest-margin")

requirement_options = together(
    option("--radius-min", LENGTH, "Radius of the smallest object.", required=True),
    option("--radius-max", LENGTH, "Radius of the largest object.", required=True),
    option(
        "--tubing",
        str,
        "File of the available tube sizes and their material.",
        shown="natural_latex",
        metavar="NAME|FILE",
    ),
    option(
        "--tube",
        str,
        'Only this size, bore x wall: "3/8 in x 1/32 in". May be repeated.',
        many="tubes",
        metavar="SIZE",
    ),
    option(
        "--beta",
        FIBER_ANGLE,
        "Angle of the second fiber family. May be repeated. [default: 50, 60, 70, 80 deg]",
        many="fiber_angles_beta",
    ),
    option(
        "--alpha",
        FIBER_ANGLE,
        "Angle of the first family. [default: 88 deg]",
        to="fiber_angle_alpha",
    ),
    option(
        "--gamma",
        SINGLE_FIBER_ANGLE,
        "Angle of the single fiber; of several the best is chosen. [default: 0 deg, straight]",
        many="fiber_angles_gamma",
    ),
    turns_option,
    option("--object-length", LENGTH, "Length of the objects that the gripper may cover."),
    option("--length-max", LENGTH, "Greatest length of the gripper."),
    option("--pressure-max", PRESSURE, "Greatest pressure."),
    option("--strain-max", NUMBER, "Greatest axial strain; 0.3 is 30 %."),
    option(
        "--payload",
        MASS,
        "Mass of each object; a design must carry twice this mass, computed with contact.",
    ),
    option(
        "--friction",
        FRICTION,
        "Friction coefficient of tube and objects, where contact counts. [default: 0.3]",
        to="friction_coefficient",
        metavar="MU",
    ),
    option("--end-allowance", LENGTH, "Tube beyond the gripper at each end. [default: 20 mm]"),
    mount_options,
)


def requirement_from(options: dict[str, Any], *, contact: bool = False) -> DesignRequirement:
    """Return the requirement that the options state, and remove them from ``options``.

    Args:
        options: as they were typed.
        contact: whether friction matters without a payload, too.

    Raises:
        DescriptionError: the tubing file cannot be used.
        InvalidInputError: a value is out of its range.
        click.UsageError: friction where it matters to nothing.
    """
    if options["friction_coefficient"] is not None and options["payload"] is None and not contact:
        raise click.UsageError(
            "--friction goes with --payload where nothing is closed with contact, as with --paper"
        )
    from spiral_core.design.requirement import DesignRequirement, Preference
    from spiral_gripper.files.plausibility import warnings_of_size
    from spiral_gripper.files.tubing import load_tubing, parse_tube_size

    tubing = load_tubing(options.pop("tubing"))
    sizes = tuple(parse_tube_size(text) for text in options.pop("tubes"))
    preference = options.pop("prefer", PREFERENCES[0]).upper().replace("-", "_")
    gravity = gravity_from(options)
    axis = options.pop("object_axis")
    axis = axis and unit_vector("--object-axis", axis)
    names = {field.name for field in dataclasses.fields(DesignRequirement)}
    given = {name: options.pop(name) for name in list(options) if name in names}
    requirement = DesignRequirement(
        tubes=sizes or tubing.sizes,
        elastomers=(tubing.elastomer,),
        preference=Preference[preference],
        **{
            name: value
            for name, value in {**given, "gravity": gravity, "object_axis": axis}.items()
            if value not in (None, ())
        },
    )
    for warning in (*tubing.warnings, *(told for size in sizes for told in warnings_of_size(size))):
        click.echo(f"warning: {warning}", err=True)
    return requirement


def gravity_from(options: dict[str, Any], own: Vector = (0.0, 0.0, 0.0)) -> Vector | None:
    """Return the acceleration that the mount options state [m/s^2]; None if they state none.

    Args:
        options: both mount options are removed from them.
        own: acceleration of which that is kept which the options do not state [m/s^2].

    Raises:
        click.BadParameter: the direction is none.
    """
    direction, magnitude = options.pop("gravity_direction"), options.pop("gravity_magnitude")
    if not direction and magnitude is None:
        return None
    return gravity_of(own, direction, magnitude)


def gravity_of(
    own: Vector, direction: tuple[float, ...] | None, magnitude: float | None = None
) -> Vector:
    """Return an acceleration [m/s^2]; what is not given is that of another.

    Where that is zero: the Earth's, along the tube of a gripper that hangs.

    Raises:
        click.BadParameter: the direction is none.
    """
    from spiral_core.wrap.gripper import HANGING

    own = own if any(own) else HANGING
    size = math.hypot(*own) if magnitude is None else magnitude
    x, y, z = unit_vector("--gravity-direction", direction or own)
    return (size * x, size * y, size * z)
