# SPDX-License-Identifier: Apache-2.0
"""The model of a calibration: the constants of one law, and further quantities to fit."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import lru_cache
from typing import Any, cast

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.actuator.actuator import Actuator, PressureLaw
from spiral_core.actuator.materials import Gent, HyperelasticLaw, MooneyRivlin, NeoHookean, Yeoh
from spiral_core.brief import brief_repr
from spiral_core.calibration.readings import ExtensionReading, Reading, TwistReading
from spiral_core.errors import ActuationLimitError, InvalidInputError
from spiral_core.rod.types import RodStiffness
from spiral_core.validation import require_finite, require_positive
from spiral_core.wrap.gripper import Gripper, stiffness_from_actuator

# I1 - 3 at which natural rubber's chains run out, to start a fit from: between the 30 and 100 that
# are published for it.
GENT_EXTENSION_LIMIT = 50.0


# Chains that run out at 1e4 never do in any tube: the law is neo-Hookean there, and a fit that
# wants more should stop and say so.
_CEILINGS = {"extension_limit": 1.0e4}


class FittedQuantity(Enum):
    """What can be fitted beside the law's constants; the value is its name in the result."""

    BENDING_STIFFNESS = "bending_stiffness"
    TORSIONAL_STIFFNESS = "torsional_stiffness"
    STRAIGHT_FIBER_RADIUS = "straight_fiber_radius"


@dataclass(frozen=True, slots=True)
class Trial:
    """One choice of the parameters, made into what the readings are predicted from.

    Attributes:
        actuation: the finished actuator with these constants.
        gripper: the mounted gripper with this actuation and stiffness, or None if none was given.
    """

    actuation: FreeActuation
    gripper: Gripper | None = None

    @property
    def straight(self) -> FreeActuation:
        """A straight section of the tube, without single fibers: its wall stretches evenly.

        Extension and twist are measured on it. The uniform law does not tell it from the actuator.
        """
        actuator = self.actuation.actuator
        if actuator.pressure_law is PressureLaw.UNIFORM:
            return self.actuation
        return actuation_of(actuator.without_single_fibers())

    def actuation_for(self, reading: Reading) -> FreeActuation:
        """Return what a reading was measured on: the straight section or the finished actuator."""
        is_straight = isinstance(reading, ExtensionReading | TwistReading)
        return self.straight if is_straight else self.actuation

    def highest_beyond(self, readings: Iterable[Reading]) -> ActuationLimitError | None:
        """Return the error of the highest reading, if it is past what it was measured on."""
        for reading in sorted(readings, key=lambda one: one.pressure, reverse=True):
            on = self.actuation_for(reading)
            if not reading.pressure <= on.pressure_limit:
                return ActuationLimitError(
                    on.limit, "pressure", reading.pressure, on.pressure_limit
                )
        return None


@dataclass(frozen=True, slots=True)
class CalibrationModel:
    """An actuator whose law's constants, and perhaps more, are to be fitted.

    Args:
        actuator: tube, fibers and the choices of model; its material gives the values to start
            from, and those of ``fixed`` constants do not matter.
        law: the law to fit, a dataclass whose fields are its constants; by default the material's
            own.
        quantities: what to fit beside the constants.
        fixed: constants that are held, by name.
        bounds: lowest and highest value allowed, by parameter name; infinite by default, except
            that what must be positive is, and that Gent's extension limit ends at 1e4.
        gripper: how the actuator is mounted, needed for shapes and grips; its actuation is
            replaced.
        bending_stiffness: EI [N m^2] where it is known; None takes it from the fitted material.
        torsional_stiffness: GJ [N m^2] likewise.

    Raises:
        InvalidInputError: a name is not a parameter, or a bound or fixed value is not a number.

    Example:
        >>> import math
        >>> from spiral_core import FiberAngles, MooneyRivlin, Tube
        >>> model = CalibrationModel(
        ...     Actuator(
        ...         tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...         fibers=FiberAngles(alpha=math.radians(65.0), beta=math.radians(-65.0)),
        ...         material=MooneyRivlin(c1=130.0e3, c2=15.0e3),
        ...     ),
        ...     quantities=(FittedQuantity.STRAIGHT_FIBER_RADIUS,),
        ... )
        >>> model.names
        ('c1', 'c2', 'straight_fiber_radius')
    """

    __repr__ = brief_repr

    actuator: Actuator
    law: type[HyperelasticLaw] | None = None
    quantities: tuple[FittedQuantity, ...] = ()
    fixed: Mapping[str, float] = field(default_factory=dict)
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    gripper: Gripper | None = None
    bending_stiffness: float | None = None
    torsional_stiffness: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.actuator, Actuator):
            raise InvalidInputError("actuator", self.actuator, "an Actuator")
        constants = constants_of(self.fitted_law)
        for name, value in self.fixed.items():
            if name not in constants:
                raise InvalidInputError("fixed", name, f"one of {', '.join(constants)}")
            require_finite(name, value)
        if not self.names:
            raise InvalidInputError("fixed", dict(self.fixed), "not every parameter")
        for name, bounds in self.bounds.items():
            if name not in self.names:
                raise InvalidInputError("bounds", name, f"one of {', '.join(self.names)}")
            _require_bounds(name, bounds)
        for field_name in ("bending_stiffness", "torsional_stiffness"):
            if getattr(self, field_name) is not None:
                require_positive(field_name, getattr(self, field_name))

    @property
    def fitted_law(self) -> type[HyperelasticLaw]:
        """The law whose constants are fitted."""
        return type(self.actuator.material) if self.law is None else self.law

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters, in the order of the result's arrays."""
        constants = (name for name in constants_of(self.fitted_law) if name not in self.fixed)
        return (*constants, *(quantity.value for quantity in self.quantities))

    def start(self) -> tuple[float, ...]:
        """Return the values to start from: the material's own, or those of the same modulus."""
        known = _starting_values(self.actuator, self.fitted_law)
        return tuple(
            min(max(known[name], low), high)
            for name, (low, high) in zip(self.names, self.limits(), strict=True)
        )

    def scales(self) -> tuple[float, ...]:
        """Return a magnitude for each parameter, > 0, in which steps are measured."""
        modulus = self.actuator.material.small_strain_modulus
        known = _starting_values(self.actuator, self.fitted_law)
        pressures = _pressure_constants(self.fitted_law)
        return tuple(modulus / 6.0 if name in pressures else known[name] for name in self.names)

    def limits(self) -> tuple[tuple[float, float], ...]:
        """Return the lowest and highest value of each parameter."""
        return tuple(
            self.bounds.get(name, (floor, _CEILINGS.get(name, float("inf"))))
            for name, floor in zip(self.names, self._floors(), strict=True)
        )

    def actuator_from(self, values: Sequence[float]) -> Actuator:
        """Return the actuator with these parameter values.

        Raises:
            InvalidInputError: the law or the actuator refuses them.
        """
        given = dict(zip(self.names, values, strict=True)) | dict(self.fixed)
        constants = {name: float(given[name]) for name in constants_of(self.fitted_law)}
        material = cast("Any", self.fitted_law)(**constants)
        radius = given.get(FittedQuantity.STRAIGHT_FIBER_RADIUS.value)
        return replace(
            self.actuator,
            material=material,
            straight_fiber_radius=self.actuator.straight_fiber_radius
            if radius is None
            else float(radius),
        )

    def stiffness_from(self, values: Sequence[float]) -> RodStiffness:
        """Return EI and GJ with these parameter values: fitted, given, or the material's."""
        given = dict(zip(self.names, values, strict=True))
        material = stiffness_from_actuator(self.actuator_from(values))
        known = (self.bending_stiffness, self.torsional_stiffness)
        bending, torsional = (
            given.get(quantity.value, own if stated is None else stated)
            for quantity, stated, own in zip(
                (FittedQuantity.BENDING_STIFFNESS, FittedQuantity.TORSIONAL_STIFFNESS),
                known,
                (material.bending, material.torsional),
                strict=True,
            )
        )
        return RodStiffness(bending=float(bending), torsional=float(torsional))

    def trial(self, values: Sequence[float]) -> Trial:
        """Return what readings are predicted from at these parameter values.

        Args:
            values: the parameters, in the order of ``names``.

        Raises:
            InvalidInputError: these values make no actuator that extends under pressure.
        """
        actuator = self.actuator_from(values)
        actuation = actuation_of(actuator)
        if self.gripper is None:
            return Trial(actuation)
        gripper = replace(
            self.gripper,
            tube=self.actuator.tube,
            actuation=actuation,
            stiffness=self.stiffness_from(values),
            pressure_max=min(self.gripper.pressure_max, actuation.pressure_limit),
        )
        return Trial(actuation, gripper)

    def _floors(self) -> tuple[float, ...]:
        """Return the lower bound that each parameter has by its nature."""
        free = {"c2", "c3"} | ({"c1"} if self.fitted_law is MooneyRivlin else set())
        # A positive quantity may fall to a millionth of its magnitude, never to zero itself.
        return tuple(
            float("-inf") if name in free else 1e-6 * scale
            for name, scale in zip(self.names, self.scales(), strict=True)
        )


@lru_cache(maxsize=32)
def actuation_of(actuator: Actuator) -> FreeActuation:
    """Return the actuation of an actuator; a fit asks for that of the same one several times.

    Raises:
        InvalidInputError: pressure would not extend this actuator.
    """
    return FreeActuation(actuator)


def constants_of(law: type[HyperelasticLaw]) -> tuple[str, ...]:
    """Return the names of a law's constants: the fields of its dataclass.

    Raises:
        InvalidInputError: the law is not a frozen dataclass.

    Example:
        >>> constants_of(MooneyRivlin)
        ('c1', 'c2')
    """
    if not (dataclasses.is_dataclass(law) and law.__hash__ is not None):
        raise InvalidInputError("law", law, "a frozen dataclass whose fields are its constants")
    return tuple(constant.name for constant in dataclasses.fields(law))


def _pressure_constants(law: type[HyperelasticLaw]) -> tuple[str, ...]:
    """Return which of a law's constants are pressures."""
    return tuple(name for name in constants_of(law) if name != "extension_limit")


def _starting_values(actuator: Actuator, law: type[HyperelasticLaw]) -> dict[str, float]:
    """Return values to start from, for every parameter there can be."""
    stiffness = stiffness_from_actuator(actuator)
    values = {
        FittedQuantity.BENDING_STIFFNESS.value: stiffness.bending,
        FittedQuantity.TORSIONAL_STIFFNESS.value: stiffness.torsional,
        FittedQuantity.STRAIGHT_FIBER_RADIUS.value: actuator.fiber_radius,
    }
    if isinstance(actuator.material, law):
        own = {name: float(getattr(actuator.material, name)) for name in constants_of(law)}
        return values | own
    modulus = require_positive("small_strain_modulus", actuator.material.small_strain_modulus)
    same_modulus: dict[Any, dict[str, float]] = {
        NeoHookean: {"c1": modulus / 6.0},
        MooneyRivlin: {"c1": modulus / 8.0, "c2": modulus / 24.0},
        Yeoh: {"c1": modulus / 6.0, "c2": 0.0, "c3": 0.0},
        Gent: {"shear_modulus": modulus / 3.0, "extension_limit": GENT_EXTENSION_LIMIT},
    }
    if law not in same_modulus:
        known = ", ".join(one.__name__ for one in same_modulus)
        raise InvalidInputError(
            "law", law.__name__, f"the actuator's own, to start from its constants, or {known}"
        )
    return values | same_modulus[law]


def _require_bounds(name: str, bounds: object) -> None:
    """Raise unless the bounds of a parameter are two numbers, the lower first; either infinite."""
    pair = bounds if isinstance(bounds, (tuple, list)) else ()
    numbers = [b for b in pair if isinstance(b, (int, float)) and not isinstance(b, bool)]
    if len(pair) != 2 or len(numbers) != 2 or not numbers[0] < numbers[1]:
        raise InvalidInputError(f"bounds of {name}", bounds, "two numbers, low < high")
