"""The actuator: a tube, its fibers, its elastomer, and the choices of model that go with them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from spiral_core.actuator.fibers import FiberAngles
from spiral_core.actuator.materials import HyperelasticLaw
from spiral_core.actuator.tube import Tube
from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_positive


class CurvatureForm(Enum):
    """How stretch and twist become curvature: :mod:`spiral_core.actuator.curvature`."""

    FIRST_ORDER = "first_order"
    EXACT = "exact"


@dataclass(frozen=True, slots=True)
class Actuator:
    """A fiber-reinforced elastomeric enclosure with a straight fiber glued along it.

    Args:
        tube: the elastomer tube at rest.
        fibers: angles of the two wound families.
        material: the elastomer's law.
        straight_fiber_radius: distance from the tube's axis to the straight fiber [m], > 0;
            None puts it at the tube's inner radius.
        curvature_form: ``FIRST_ORDER`` as the paper's numbers suggest, or ``EXACT``.
        twist_shear: whether the energy counts the shear that the twist puts into the wall.

    Raises:
        InvalidInputError: a value is of the wrong type, or the radius is not positive.

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

    tube: Tube
    fibers: FiberAngles
    material: HyperelasticLaw
    straight_fiber_radius: float | None = None
    curvature_form: CurvatureForm = CurvatureForm.FIRST_ORDER
    twist_shear: bool = True

    def __post_init__(self) -> None:
        _require_type("tube", self.tube, Tube)
        _require_type("fibers", self.fibers, FiberAngles)
        _require_type("material", self.material, HyperelasticLaw)
        _require_type("curvature_form", self.curvature_form, CurvatureForm)
        _require_type("twist_shear", self.twist_shear, bool)
        if self.straight_fiber_radius is not None:
            require_positive("straight_fiber_radius", self.straight_fiber_radius)

    @property
    def fiber_radius(self) -> float:
        """Distance from the tube's axis to the straight fiber, r_f [m]."""
        if self.straight_fiber_radius is None:
            return self.tube.inner_radius
        return self.straight_fiber_radius


def _require_type(field: str, value: object, expected: type) -> None:
    """Raise InvalidInputError unless ``value`` is an instance of ``expected``."""
    if not isinstance(value, expected):
        raise InvalidInputError(field, value, f"a {expected.__name__}")
