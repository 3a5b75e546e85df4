# SPDX-License-Identifier: Apache-2.0
"""The actuator: tube, fibers, elastomer, choices of model; its unloaded shape and its winding."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from typing import Protocol, runtime_checkable

from spiral_core.actuator.fibers import (
    FiberAngles,
    OneFamily,
    SingleFiber,
    check_single_fibers,
    family_angles,
    fiber_set_of,
)
from spiral_core.actuator.materials import HyperelasticLaw
from spiral_core.actuator.section import FiberSet
from spiral_core.actuator.tube import Tube
from spiral_core.brief import brief_repr
from spiral_core.errors import ActuationLimit, InvalidInputError
from spiral_core.validation import require_all, require_finite, require_kind, require_positive


@dataclass(frozen=True, slots=True)
class UnloadedShape:
    """The uniform shape an actuator takes when nothing loads it.

    In the material frame (x tangent, y towards the straight fiber) its strain vector is
    (torsion, 0, curvature); see ``docs/conventions.md``.

    Args:
        curvature: curvature per length of ``backbone_length`` [1/m]; positive bends towards y.
        torsion: torsion, the same as the twist rate of the material frame [1/m]; positive is
            right-handed.
        backbone_length: length of the backbone that carries this shape [m], > 0.
        stretch: axial stretch of the tube (1 at rest), or None where a model does not know it.

    Raises:
        InvalidInputError: a value is not finite, or a length or stretch is not positive.

    Example:
        >>> UnloadedShape(curvature=20.0, torsion=-10.0, backbone_length=0.36).stretch is None
        True
    """

    curvature: float
    torsion: float
    backbone_length: float
    stretch: float | None = None

    def __post_init__(self) -> None:
        require_finite("curvature", self.curvature)
        require_finite("torsion", self.torsion)
        require_positive("backbone_length", self.backbone_length)
        if self.stretch is not None:
            require_positive("stretch", self.stretch)


@runtime_checkable
class ActuationModel(Protocol):
    """A model from pressure to unloaded shape: mechanical, or interpolating measured data."""

    @property
    def pressure_limit(self) -> float:
        """Largest gauge pressure the model answers for [Pa]."""
        ...

    @property
    def limit(self) -> ActuationLimit:
        """The reason for ``pressure_limit``."""
        ...

    def unloaded_shape(self, pressure: float) -> UnloadedShape:
        """Return the unloaded shape at a gauge pressure [Pa], 0 <= pressure <= pressure_limit.

        Raises:
            InvalidInputError: the pressure is negative or not finite.
            ActuationLimitError: the pressure is past ``pressure_limit``.
        """
        ...


class PressureLaw(Enum):
    """Which wall's energy the pressure works against; the elastomer's constants belong to one."""

    SECTION = "section"
    UNIFORM = "uniform"


class CurvatureForm(Enum):
    """How stretch and twist become curvature: :mod:`spiral_core.actuator.curvature`."""

    FIRST_ORDER = "first_order"
    EXACT = "exact"


_TYPES = {
    "tube": Tube,
    "material": HyperelasticLaw,
    "curvature_form": CurvatureForm,
    "twist_shear": bool,
    "pressure_law": PressureLaw,
    "thick_wall": bool,
}


@dataclass(frozen=True, slots=True)
class Actuator:
    """A fiber-reinforced elastomeric enclosure with a straight fiber glued along it.

    Args:
        tube: the elastomer tube at rest.
        fibers: angles of the two wound families, or of one alone.
        material: the elastomer's law.
        straight_fiber_radius: distance from the tube's axis to the straight fiber [m], > 0;
            None puts it at the tube's inner radius.
        curvature_form: ``FIRST_ORDER`` as the paper's numbers suggest, or ``EXACT``.
        pressure_law: ``SECTION`` counts the strains all around the bent section, ``UNIFORM`` takes
            the wall as stretched evenly, as the paper does.
        twist_shear: whether the energy counts the shear that the twist puts into the wall; only
            the uniform law can leave it out, to compare.
        single_fibers: fibers that make the tube bend: a straight one by default, or helical ones
            that do not cross; without any the tube stays straight.
        thick_wall: whether the section law lets strains vary through the wall, with the fibers on
            its outside; a thin wall has them, and the strains, on the tube's inner radius.

    Raises:
        InvalidInputError: a value is of the wrong type, the radius is not positive, the elastomer's
            limit is at rest, or choices of model contradict each other or the fibers.

    Example:
        >>> import math
        >>> from spiral_core.actuator.materials import MooneyRivlin
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=MooneyRivlin(c1=130.0e3, c2=15.0e3),
        ... )
        >>> actuator.fiber_radius
        0.0047625
    """

    __repr__ = brief_repr

    tube: Tube
    fibers: FiberAngles | OneFamily
    material: HyperelasticLaw
    straight_fiber_radius: float | None = None
    curvature_form: CurvatureForm = CurvatureForm.FIRST_ORDER
    twist_shear: bool = True
    pressure_law: PressureLaw = PressureLaw.SECTION
    single_fibers: tuple[SingleFiber, ...] = (SingleFiber(),)
    thick_wall: bool = False

    def __post_init__(self) -> None:
        for field, kind in _TYPES.items():
            require_kind(field, getattr(self, field), kind)
        require_kind("fibers", self.fibers, FiberAngles, OneFamily)
        limit = self.material.first_invariant_limit
        if not limit > 3.0:
            raise InvalidInputError("first_invariant_limit", limit, "more than the 3 of rest")
        require_all("single_fibers", self.single_fibers, (SingleFiber,), "SingleFiber values")
        if self.straight_fiber_radius is not None:
            require_positive("straight_fiber_radius", self.straight_fiber_radius)
        check_single_fibers(self.fibers, self.single_fibers)
        self._check_choices()

    @property
    def fiber_radius(self) -> float:
        """Distance from the tube's axis to the single fibers, r_f [m]."""
        if self.straight_fiber_radius is None:
            return self.wound_radius
        return self.straight_fiber_radius

    @property
    def fiber_pair(self) -> FiberAngles:
        """The angles of two wound families.

        Raises:
            InvalidInputError: it has one family alone.
        """
        if isinstance(self.fibers, OneFamily):
            raise InvalidInputError("fibers", "one wound family", "two families for this")
        return self.fibers

    @property
    def wound_radius(self) -> float:
        """Radius at which the wound fibers count as lying [m]."""
        return self.tube.outer_radius if self.thick_wall else self.tube.inner_radius

    @property
    def fiber_set(self) -> FiberSet:
        """The fibers as the section's kinematics takes them."""
        return fiber_set_of(
            self.fibers,
            self.single_fibers,
            self.fiber_radius / self.wound_radius,
            self.tube.inner_radius / self.wound_radius if self.thick_wall else None,
            self.twist_shear,
        )

    def without_single_fibers(self) -> Actuator:
        """Return the straight section of the same tube and wound fibers."""
        return replace(self, single_fibers=(), straight_fiber_radius=None)

    def _check_choices(self) -> None:
        """Refuse choices of model that are not defined for these fibers, or for each other."""
        if self.pressure_law is PressureLaw.SECTION and not self.twist_shear:
            raise InvalidInputError(
                "twist_shear", False, "true: only the uniform law can leave the shear out"
            )
        if self.pressure_law is PressureLaw.UNIFORM and self.thick_wall:
            raise InvalidInputError("thick_wall", True, "false with the uniform law")
        two = isinstance(self.fibers, FiberAngles)
        if two and [fiber.angle for fiber in self.single_fibers] in ([], [0.0]):
            return
        others = "for fibers other than two families and one straight one"
        if self.pressure_law is PressureLaw.UNIFORM:
            raise InvalidInputError("pressure_law", "uniform", f"section {others}")
        if self.curvature_form is CurvatureForm.FIRST_ORDER:
            raise InvalidInputError("curvature_form", "first_order", f"exact {others}")
        if not two and (self.thick_wall or len(self.single_fibers) > 1):
            field = "thick_wall" if self.thick_wall else "single_fibers"
            raise InvalidInputError(
                field, getattr(self, field), "a thin wall and at most one fiber with one family"
            )


@dataclass(frozen=True, slots=True)
class Winding:
    """One wound fiber, laid on the outside of the tube at rest.

    Args:
        angle: from the tube's axis [rad]; positive is right-handed.
        pitch: advance along the tube per turn [m], > 0.
        turns: turns over the length of the actuator.
        fiber_length: length of one fiber, without what is tied off [m].
    """

    angle: float
    pitch: float
    turns: float
    fiber_length: float

    @property
    def hand(self) -> str:
        """Which way it winds: ``"right"`` or ``"left"``."""
        return "right" if self.angle > 0.0 else "left"


def windings_of(actuator: Actuator) -> tuple[Winding, ...]:
    r"""Return the windings of an actuator's families, one or two.

    .. math:: p = \frac{2 \pi r_o}{|\tan\varphi|}, \qquad N = L / p, \qquad
        \ell = L / |\cos\varphi|

    on the outer radius :math:`r_o`, where the fibers lie. Where several fibers of a family are
    wound side by side, each has this pitch. Exactly at 90 degrees, which cannot be wound but may
    be computed with, the pitch vanishes and the turns are as many as the float of pi/2 allows.

    Args:
        actuator: the actuator.

    Example:
        >>> from spiral_core import FiberAngles, NeoHookean, Tube
        >>> tube = Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.361)
        >>> fibers = FiberAngles(alpha=math.radians(88.0), beta=math.radians(70.0))
        >>> first, second = windings_of(Actuator(tube, fibers, NeoHookean(c1=145.0e3)))
        >>> round(second.pitch * 1e3, 2), round(second.turns, 1), second.hand
        (12.71, 28.4, 'right')
    """
    windings, length = [], actuator.tube.length
    for angle in family_angles(actuator.fibers):
        pitch = 2.0 * math.pi * actuator.tube.outer_radius / abs(math.tan(angle))
        windings.append(Winding(angle, pitch, length / pitch, length / abs(math.cos(angle))))
    return tuple(windings)
