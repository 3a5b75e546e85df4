# SPDX-License-Identifier: Apache-2.0
"""The inputs of the design procedure: objects to be gripped, limits, available tubes and angles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from itertools import product
from numbers import Real

from spiral_core.actuator.actuator import Actuator, CurvatureForm, PressureLaw
from spiral_core.actuator.fibers import FiberAngles, SingleFiber, check_single_fibers
from spiral_core.actuator.materials import HyperelasticLaw
from spiral_core.actuator.tube import Tube
from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError
from spiral_core.message import Message, Quantity
from spiral_core.rod.types import Vector
from spiral_core.validation import (
    require_all,
    require_in_range,
    require_kind,
    require_non_negative,
    require_positive,
    require_unit_vector,
    require_vector,
)
from spiral_core.wrap.gripper import DEFAULT_FRICTION, DEFAULT_TURNS, FRICTION_MAX, HANGING

# The angle that the paper winds its first family at: 90 degrees is hard to wind.
DEFAULT_ALPHA = math.radians(88.0)
# The angles of the paper's charts and prototypes, and one step beyond.
DEFAULT_BETAS = tuple(math.radians(angle) for angle in (50.0, 60.0, 70.0, 80.0))
# At this angle of the single fiber the widest helix leaves no room for an object [rad].
LARGEST_GAMMA = math.radians(30.0)
# Constants of the section law that give the pressures of the uniform one, over its own: 1/1.48 to
# 1/1.36 for the paper's actuators (docs/derivations/section.md).
SECTION_OVER_UNIFORM = 0.7
# No elastomer stretches farther: a larger limit is a percentage that was meant as a fraction.
LARGEST_STRAIN = 10.0
# Less than a tenth of a turn holds nothing; the length for a millionth of one is micrometers.
LEAST_TURNS = 0.1
# Objects above a thousand kilometers [m]: not even a wrong unit gets there.
LARGEST_RADIUS = 1.0e6
OPTIONAL = ("object_length", "length_max", "pressure_max", "strain_max", "payload", "tolerance")
# Tube that a plug and a fitting take up at each end (our choice: one inch, less a little).
DEFAULT_END_ALLOWANCE = 0.02


@dataclass(frozen=True, slots=True)
class TubeSize:
    """A size of tubing that can be bought.

    Args:
        name: how reports call it.
        inner_radius: radius of the bore r [m], > 0.
        wall_thickness: t [m], > 0.

    Raises:
        InvalidInputError: a dimension is not positive, or beyond what a tube may have.

    Example:
        >>> TubeSize("3/8 x 1/32 in", inner_radius=4.7625e-3, wall_thickness=0.79375e-3).name
        '3/8 x 1/32 in'
    """

    name: str
    inner_radius: float
    wall_thickness: float

    def __post_init__(self) -> None:
        self.cut(1.0)

    @property
    def outer_radius(self) -> float:
        """Outer radius r + t [m]."""
        return self.inner_radius + self.wall_thickness

    def cut(self, length: float) -> Tube:
        """Return a tube of this size and a length [m]."""
        return Tube(self.inner_radius, self.wall_thickness, length)


@dataclass(frozen=True, slots=True)
class Elastomer:
    """The material of tubing.

    Args:
        name: how reports call it.
        law: its hyperelastic law.
        density: [kg/m^3], > 0.
        pressure_law: the one that the law's constants were fitted with.

    Raises:
        InvalidInputError: the law is none, or the density is not positive and finite.
    """

    name: str
    law: HyperelasticLaw
    density: float
    pressure_law: PressureLaw = PressureLaw.SECTION

    def __post_init__(self) -> None:
        require_kind("law", self.law, HyperelasticLaw)
        require_kind("pressure_law", self.pressure_law, PressureLaw)
        require_positive("density", self.density)


class Preference(Enum):
    """The criterion that selects among feasible designs; the value is its text."""

    LEAST_STRAIN = "least strain at the smallest object"
    LEAST_PRESSURE = "least pressure at the smallest object"
    SHORTEST = "shortest gripper"
    LARGEST_MARGIN = "largest margin on the limit that is nearest"


@dataclass(frozen=True, slots=True)
class DesignRequirement:
    """Objects to be gripped, limits, and the available tubes, materials and angles.

    A limit that is None does not limit.

    Args:
        radius_min: radius of the smallest object [m], > 0.
        radius_max: radius of the largest object [m], >= ``radius_min``.
        tubes: sizes on offer, at least one; one is a fixed tube.
        elastomers: materials on offer, at least one.
        fiber_angles_beta: angles at which the second family can be wound [rad].
        fiber_angle_alpha: angle of the first family [rad].
        fiber_angles_gamma: angles at which the single fiber can be laid [rad]; 0 is straight. At
            another angle the exact curvature form and constants of the section law are taken.
        turns_required: turns about the largest object, at least 0.1.
        object_length: length of object that the coil may cover [m].
        length_max: longest gripper acceptable [m].
        pressure_max: largest gauge pressure [Pa].
        strain_max: largest axial strain of the tube, lambda_1 - 1: 0.3 is 30 %.
        gravity: acceleration in the base frame [m/s^2].
        object_axis: direction of the object in the base frame (unit vector); None fits the coil.
        curvature_form: how stretch and twist become curvature.
        extra_mass_per_length: fibers, glue, what else hangs on the tube [kg/m].
        end_allowance: tube beyond the gripper at each end, for plug and fitting [m].
        preference: which of several designs is taken.
        payload: mass of each object that is to be carried twice over, along gravity [kg].
        friction_coefficient: between tube and objects, where contact counts.
        tolerance: shift of the objects across their axis, in eight directions about the middle of
            what is safe, from which closing at the recommended pressure still holds them [m].

    Raises:
        InvalidInputError: a value is out of its range.
    """

    __repr__ = brief_repr

    radius_min: float
    radius_max: float
    tubes: tuple[TubeSize, ...]
    elastomers: tuple[Elastomer, ...]
    fiber_angles_beta: tuple[float, ...] = DEFAULT_BETAS
    fiber_angle_alpha: float = DEFAULT_ALPHA
    fiber_angles_gamma: tuple[float, ...] = (0.0,)
    turns_required: float = DEFAULT_TURNS
    object_length: float | None = None
    length_max: float | None = None
    pressure_max: float | None = None
    strain_max: float | None = None
    gravity: Vector = HANGING
    object_axis: Vector | None = None
    curvature_form: CurvatureForm = CurvatureForm.FIRST_ORDER
    extra_mass_per_length: float = 0.0
    end_allowance: float = DEFAULT_END_ALLOWANCE
    preference: Preference = Preference.LEAST_STRAIN
    payload: float | None = None
    friction_coefficient: float = DEFAULT_FRICTION
    tolerance: float | None = None

    def __post_init__(self) -> None:
        given = [field for field in OPTIONAL if getattr(self, field) is not None]
        for field in ("radius_min", "radius_max", "turns_required", *given):
            require_positive(field, getattr(self, field))
        if not self.radius_max >= self.radius_min:
            smallest = Message("at least the smallest radius, {}", Quantity(self.radius_min, "m"))
            raise InvalidInputError("radius_max", self.radius_max, smallest, "m")
        if not self.radius_max <= LARGEST_RADIUS:
            most = Message("at most {}", Quantity(LARGEST_RADIUS, "m"))
            raise InvalidInputError("radius_max", self.radius_max, most, "m")
        for field, kind, what in (
            ("tubes", TubeSize, "TubeSize values"),
            ("elastomers", Elastomer, "Elastomer values"),
            ("fiber_angles_beta", Real, "angles"),
            ("fiber_angles_gamma", Real, "angles"),
        ):
            if not require_all(field, getattr(self, field), (kind,), what):
                raise InvalidInputError(field, getattr(self, field), "at least one on offer")
        require_kind("preference", self.preference, Preference)
        require_kind("curvature_form", self.curvature_form, CurvatureForm)
        self._check_fibers()
        if not self.turns_required >= LEAST_TURNS:
            requirement = f"at least {LEAST_TURNS:g}: less of a turn holds nothing"
            raise InvalidInputError("turns_required", self.turns_required, requirement)
        if self.strain_max is not None and not self.strain_max <= LARGEST_STRAIN:
            raise InvalidInputError(
                "strain_max", self.strain_max, f"at most {LARGEST_STRAIN:g} (0.3 is 30 %)"
            )
        require_vector("gravity", self.gravity, 3)
        if self.payload is not None and not any(self.gravity):
            raise InvalidInputError("payload", self.payload, "left out where there is no gravity")
        require_in_range("friction_coefficient", self.friction_coefficient, 0.0, FRICTION_MAX)
        if self.object_axis is not None:
            require_unit_vector("object_axis", self.object_axis)
        require_non_negative("extra_mass_per_length", self.extra_mass_per_length)
        require_non_negative("end_allowance", self.end_allowance)

    def candidates(self) -> tuple[Candidate, ...]:
        """Return every combination on offer: tubes, then elastomers, then angles."""
        angles = self.fiber_angles_beta, self.fiber_angles_gamma
        return tuple(Candidate(*one) for one in product(self.tubes, self.elastomers, *angles))

    def _check_fibers(self) -> None:
        """Refuse fibers that leave no motion, or that the constants' law does not describe."""
        for gamma in self.fiber_angles_gamma:
            if not abs(gamma) <= LARGEST_GAMMA:
                allowed = (
                    "an angle from -30 to 30 degrees: a steeper fiber winds a coil about nothing"
                )
                raise InvalidInputError("fiber_angles_gamma", gamma, allowed, "rad")
        for beta, gamma in product(self.fiber_angles_beta, self.fiber_angles_gamma):
            families = FiberAngles(self.fiber_angle_alpha, beta)
            try:
                check_single_fibers(families, (SingleFiber(gamma),))
            except InvalidInputError as error:
                field = "fiber_angles_gamma"
                raise InvalidInputError(field, gamma, error.requirement, "rad") from None
        uniform = [e for e in self.elastomers if e.pressure_law is PressureLaw.UNIFORM]
        if uniform and any(self.fiber_angles_gamma):
            raise InvalidInputError(
                "fiber_angles_gamma",
                next(gamma for gamma in self.fiber_angles_gamma if gamma),
                f"0 (straight): the constants of {uniform[0].name} belong to the uniform pressure "
                "law, which is for straight fibers; offer tubing with constants of the section "
                f"law, to start from {SECTION_OVER_UNIFORM:g} times these",
            )


@dataclass(frozen=True, slots=True)
class Candidate:
    """One combination on offer.

    Args:
        tube: its size.
        elastomer: its material.
        fiber_angle_beta: angle of the second family [rad].
        fiber_angle_gamma: angle of the single fiber [rad]; 0 is straight.
    """

    tube: TubeSize
    elastomer: Elastomer
    fiber_angle_beta: float
    fiber_angle_gamma: float = 0.0

    def actuator(self, requirement: DesignRequirement, length: float) -> Actuator:
        """Return the actuator that is made of it with a length [m]."""
        return Actuator(
            tube=self.tube.cut(length),
            fibers=FiberAngles(requirement.fiber_angle_alpha, self.fiber_angle_beta),
            material=self.elastomer.law,
            curvature_form=CurvatureForm.EXACT
            if self.fiber_angle_gamma
            else requirement.curvature_form,
            pressure_law=self.elastomer.pressure_law,
            single_fibers=(SingleFiber(self.fiber_angle_gamma),),
        )

    @property
    def label(self) -> str:
        """Name for reports: tube, material, angle."""
        return Message("{}, {}, {}", self.tube.name, self.elastomer.name, self.angles)

    @property
    def angles(self) -> str:
        """The angles that are chosen, in words: beta, and gamma where the fiber is not straight."""
        gamma = self.fiber_angle_gamma
        helical = Message(", gamma {}", Quantity(gamma, "rad")) if gamma else ""
        return Message("beta {}{}", Quantity(self.fiber_angle_beta, "rad"), helical)
