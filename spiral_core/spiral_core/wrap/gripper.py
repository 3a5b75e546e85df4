# SPDX-License-Identifier: Apache-2.0
"""A gripper: an actuator as a rod, with its mount and its limits."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from spiral_core.actuator.actuation import FreeActuation, section_stiffness
from spiral_core.actuator.actuator import ActuationModel, Actuator, UnloadedShape
from spiral_core.actuator.tube import Tube
from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError
from spiral_core.message import Message, Quantity
from spiral_core.rod.types import Rod, RodLoad, Section, Vector
from spiral_core.rounding import rounded_down, rounded_up
from spiral_core.validation import (
    require_in_range,
    require_kind,
    require_non_negative,
    require_positive,
    require_unit_vector,
    require_vector,
)

STANDARD_GRAVITY = 9.80665
# The tube leaves the base along +x: hanging straight down, gravity points along +x.
HANGING: Vector = (STANDARD_GRAVITY, 0.0, 0.0)
# Slightly more than one complete turn: the paper's condition for a grip whatever the friction.
DEFAULT_TURNS = 1.05
# Coulomb's coefficient where none is given: a cautious value for latex on a smooth, dusty or damp
# surface. Dry rubber on clean solids has 0.5 to 1; measure yours.
DEFAULT_FRICTION = 0.3
FRICTION_MAX = 10.0
# GJ/EI of an annulus is 2/3, that of a section of fibers up to some twenty. Beyond a hundred, or
# below a hundredth, curves of wraps take minutes.
LARGEST_STIFFNESS_RATIO = 100.0
# Fibers that do not stretch forbid all but one combination of bending and twist. A rod takes them
# as this many times as stiff as what they allow: hanging tips are then 0.7 to 1.6 % of the length
# from where 1000 times puts them, at 55 kPa and more. With 30 times friction moves a closing coil
# in snaps too small to follow.
FIBER_STIFFNESS = 10.0


@dataclass(frozen=True, slots=True)
class Gripper:
    """A mounted spiral gripper.

    Args:
        name: for messages.
        tube: the elastomer tube at rest.
        actuation: turns a pressure into the unloaded shape.
        stiffness: of the tube; to no motion more than a hundred times as stiff as to another.
        weight_per_length: mass times standard gravity per unstretched length [N/m], >= 0.
        pressure_max: largest gauge pressure that may be commanded [Pa], > 0 and within the
        actuation's range.
        gravity: acceleration in the base frame [m/s^2]; only its direction and its ratio to
        standard gravity matter.
        object_axis: direction of the object's axis in the base frame (unit vector); None fits it to
        the coil.
        turns_required: turns about the object that count as a wrap, > 0.
        friction_coefficient: between gripper and object, or None if unknown.

    Raises:
        InvalidInputError: a value is out of its range.
    """

    __repr__ = brief_repr

    name: str
    tube: Tube
    actuation: ActuationModel
    stiffness: Section
    weight_per_length: float
    pressure_max: float
    gravity: Vector = HANGING
    object_axis: Vector | None = None
    turns_required: float = DEFAULT_TURNS
    friction_coefficient: float | None = None

    def __post_init__(self) -> None:
        for field, kind in (
            ("tube", Tube),
            ("actuation", ActuationModel),
            ("stiffness", Section),
        ):
            require_kind(field, getattr(self, field), kind)
        require_non_negative("weight_per_length", self.weight_per_length)
        require_positive("pressure_max", self.pressure_max)
        _check_stiffness(self.stiffness)
        if self.pressure_max > self.actuation.pressure_limit:
            limit = Quantity(self.actuation.pressure_limit, "Pa", rounded_down)
            requirement = Message(
                "at most {}, the actuator's own limit ({})", limit, self.actuation.limit.value
            )
            raise InvalidInputError("pressure_max", self.pressure_max, requirement, "Pa")
        require_vector("gravity", self.gravity, 3)
        if self.object_axis is not None:
            require_unit_vector("object_axis", self.object_axis)
        require_positive("turns_required", self.turns_required)
        if self.friction_coefficient is not None:
            require_in_range("friction_coefficient", self.friction_coefficient, 0.0, FRICTION_MAX)

    def unloaded_shape(self, pressure: float) -> UnloadedShape:
        """Return the unloaded shape at a gauge pressure [Pa], at most ``pressure_max``.

        Raises:
            InvalidInputError: the pressure is not in [0, ``pressure_max``].
        """
        return self.actuation.unloaded_shape(
            require_in_range("pressure", pressure, 0.0, self.pressure_max, "Pa")
        )

    def rod(self, shape: UnloadedShape) -> Rod:
        """Return the rod that an unloaded shape is bent from; of no radius: it may pass itself."""
        return Rod(
            length=shape.backbone_length,
            section=self.stiffness,
            rest_strain=(shape.torsion, 0.0, shape.curvature),
        )

    def load(self, shape: UnloadedShape) -> RodLoad:
        """Return the gripper's weight on its rod; the mass stays when the backbone stretches."""
        density = self.weight_per_length * self.tube.length / shape.backbone_length
        x, y, z = self.gravity
        unit = density / STANDARD_GRAVITY
        return RodLoad(distributed=(unit * x, unit * y, unit * z))

    def with_mount(self, gravity: Vector, object_axis: Vector | None) -> Gripper:
        """Return the same gripper held otherwise: gravity [m/s^2] and axis in the base frame."""
        return replace(self, gravity=gravity, object_axis=object_axis)


def _check_stiffness(stiffness: Section) -> None:
    """Refuse a ratio of stiffnesses that no tube has."""
    if not stiffness.plain:
        raise InvalidInputError("stiffness", stiffness, "a Section.inextensible(...)")
    bending, most = stiffness.bending, LARGEST_STIFFNESS_RATIO
    if not bending / most <= stiffness.torsional <= bending * most:
        requirement = Message(
            "from {} to {}, a hundredth to a hundred times the bending stiffness; are both in the "
            "same unit?",
            Quantity(bending / most, "N m^2", rounded_up),
            Quantity(bending * most, "N m^2", rounded_down),
        )
        raise InvalidInputError("torsional", stiffness.torsional, requirement, "N m^2")
    softest, _, stiffest = np.linalg.eigvalsh(stiffness.matrix).tolist()
    if not stiffest <= most * softest:
        section = f"a section at most {most:g} times as stiff to one motion as to another"
        raise InvalidInputError("stiffness", stiffness, section)


def stiffness_from_actuator(actuator: Actuator) -> Section:
    """Return EI and GJ of the tube's annulus, for the small-strain modulus E and G = E/3.

    The fibers' own stiffness is not counted; calibrate where it matters.
    """
    modulus = actuator.material.small_strain_modulus
    return Section.inextensible(
        bending=modulus * actuator.tube.second_moment_of_area,
        torsional=modulus / 3.0 * actuator.tube.polar_moment_of_area,
    )


def stiffness_from_section(actuator: Actuator, pressure: float) -> Section:
    r"""Return the stiffness that the section law's own energy gives, at a pressure held constant.

    An estimate from above, to compare: fibers that neither stretch nor slip. In the plane of the
    coil they leave bending and twist one motion, of stiffness S along a unit direction d; every
    other combination gets :data:`FIBER_STIFFNESS` times as much, as does bending sideways where
    two single fibers forbid it. What public data support is the annulus,
    :func:`stiffness_from_actuator`.

    .. math:: K = S \, [d d^T + N (1 - d d^T)]

    Args:
        actuator: two wound families and a single fiber, with constants of the section law.
        pressure: gauge pressure [Pa], from 0 to the actuator's limit.

    Returns:
        Stiffness per length of the backbone, with coupling and the bending sideways.

    Raises:
        InvalidInputError: the law is not the section's, or the fibers are others.
        ActuationLimitError: the pressure is past the actuator's limit.

    Source: ``docs/derivations/section.md``, "Stiffness".

    Example:
        >>> import math
        >>> from spiral_core import FiberAngles, NeoHookean
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.361),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=NeoHookean(c1=100.0e3),
        ... )
        >>> annulus = stiffness_from_actuator(actuator)
        >>> section = stiffness_from_section(actuator, pressure=0.0)
        >>> round(section.sideways / annulus.bending, 2)
        1.26
    """
    actuation = FreeActuation(actuator)
    shape = actuation.unloaded_shape(pressure)
    found = section_stiffness(actuation, pressure)
    slope = found.twist_per_curvature
    square = 1.0 / (1.0 + slope * slope)  # of d's component of bending
    # Per length of the backbone, where the section counts per length at rest.
    along = found.bending * square * shape.backbone_length / actuator.tube.length
    other = FIBER_STIFFNESS * along
    sideways = found.sideways * shape.backbone_length / actuator.tube.length
    return Section.inextensible(
        bending=along * square + other * (1.0 - square),
        torsional=along * (1.0 - square) + other * square,
        sideways=min(sideways, other),
        coupling=(along - other) * slope * square,
    )


def gripper_from_actuator(
    name: str,
    actuator: Actuator,
    *,
    density: float,
    pressure_max: float | None = None,
    extra_mass_per_length: float = 0.0,
    stiffness: Section | None = None,
    gravity: Vector = HANGING,
    object_axis: Vector | None = None,
    turns_required: float = DEFAULT_TURNS,
    friction_coefficient: float | None = None,
) -> Gripper:
    """Return the gripper made of an actuator of known density.

    Args:
        name: how messages call it.
        actuator: tube, fibers, material.
        density: of the elastomer [kg/m^3], > 0.
        pressure_max: largest gauge pressure [Pa]; None takes the actuator's own limit.
        extra_mass_per_length: fibers, glue, what else hangs on the tube [kg/m].
        stiffness: None derives it from the material (:func:`stiffness_from_actuator`).
        gravity: in the base frame [m/s^2]; hanging straight down by default.
        object_axis: unit vector in the base frame, or None to fit it to the coil.
        turns_required: turns about the object that count as a wrap.
        friction_coefficient: between gripper and object, or None if unknown.

    Raises:
        InvalidInputError: a value is out of its range.

    Example:
        >>> import math
        >>> from spiral_core.actuator.fibers import FiberAngles
        >>> from spiral_core.actuator.materials import MooneyRivlin
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.361),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(70.0)),
        ...     material=MooneyRivlin(c1=130.0e3, c2=15.0e3),
        ... )
        >>> gripper = gripper_from_actuator("example", actuator, density=930.0)
        >>> round(gripper.weight_per_length, 4)
        0.2347
    """
    require_positive("density", density)
    require_non_negative("extra_mass_per_length", extra_mass_per_length)
    actuation = FreeActuation(actuator)
    mass = density * actuator.tube.wall_area + extra_mass_per_length
    return Gripper(
        name=name,
        tube=actuator.tube,
        actuation=actuation,
        stiffness=stiffness_from_actuator(actuator) if stiffness is None else stiffness,
        weight_per_length=mass * STANDARD_GRAVITY,
        pressure_max=actuation.pressure_limit if pressure_max is None else pressure_max,
        gravity=gravity,
        object_axis=object_axis,
        turns_required=turns_required,
        friction_coefficient=friction_coefficient,
    )
