# SPDX-License-Identifier: Apache-2.0
r"""The model of a calibration: parameters, what readings they predict, and where a fit starts.

Straight sections and bend angles follow from the stretch alone: extension
:math:`(\lambda_1 - 1) L`, twist :math:`\omega L / r`, bend angle :math:`\kappa` times the length of
the backbone. Shapes and grips are those of the mounted gripper under its weight; grips are those of
the free coil, shifted by what contact changes (:func:`with_contact`).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple, cast

import numpy as np

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.actuator.actuator import Actuator, PressureLaw, UnloadedShape
from spiral_core.actuator.materials import Gent, HyperelasticLaw, MooneyRivlin, NeoHookean, Yeoh
from spiral_core.brief import brief_repr
from spiral_core.calibration.readings import (
    BendReading,
    ExtensionReading,
    GripReading,
    Reading,
    ShapeReading,
    TwistReading,
)
from spiral_core.errors import ActuationLimitError, InvalidInputError, SpiralError
from spiral_core.grip.setup import lay_into_coil
from spiral_core.grip.window import grip_window, sharp_onset
from spiral_core.message import Message, Quantity
from spiral_core.numerics.tasks import Progress
from spiral_core.rod._mesh import element_count
from spiral_core.rod.solve import solve_rod
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Array, Section
from spiral_core.rounding import rounded_down
from spiral_core.validation import require_all, require_finite, require_kind, require_positive
from spiral_core.wrap.gripper import Gripper, stiffness_from_actuator
from spiral_core.wrap.wrap import wrapped_radius

# I1 - 3 at which natural rubber's chains run out, to start a fit from: between the 30 and 100 that
# are published for it.
GENT_EXTENSION_LIMIT = 50.0


# Chains that run out at 1e4 never do in any tube: the law is neo-Hookean there, and a fit that
# wants more should stop and say so.
EXTENSION_LIMIT_MAX = 1.0e4


# Constants to start from that give a modulus [Pa] at rest.
OF_SAME_MODULUS: dict[Any, Callable[[float], dict[str, float]]] = {
    NeoHookean: lambda modulus: {"c1": modulus / 6.0},
    MooneyRivlin: lambda modulus: {"c1": modulus / 8.0, "c2": modulus / 24.0},
    Yeoh: lambda modulus: {"c1": modulus / 6.0, "c2": 0.0, "c3": 0.0},
    Gent: lambda modulus: {
        "shear_modulus": modulus / 3.0,
        "extension_limit": GENT_EXTENSION_LIMIT,
    },
}


class Parameters(NamedTuple):
    """What is known of parameters beforehand, (p,) each.

    Attributes:
        start: the material's own, or of a law of the same modulus.
        scale: magnitudes > 0, in which steps are measured.
        low, high: the lowest and highest value by their nature.
    """

    start: Array
    scale: Array
    low: Array
    high: Array


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

    def actuation_for(self, reading: Reading) -> FreeActuation:
        """Return what a reading was measured on: the straight section or the finished actuator.

        Extension and twist are measured on a straight section of the tube, without single fibers:
        its wall stretches evenly. The uniform law does not tell it from the actuator.
        """
        actuator = self.actuation.actuator
        whole = not isinstance(reading, ExtensionReading | TwistReading)
        if whole or actuator.pressure_law is PressureLaw.UNIFORM:
            return self.actuation
        return actuation_of(actuator.without_single_fibers())

    def highest_beyond(self, readings: Iterable[Reading]) -> ActuationLimitError | None:
        """Return the error of the highest reading, if it is past what it was measured on."""
        for reading in sorted(readings, key=lambda one: one.pressure, reverse=True):
            on, pressure = self.actuation_for(reading), reading.pressure
            if not pressure <= on.pressure_limit:
                return ActuationLimitError(on.limit, "pressure", pressure, on.pressure_limit)
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
        gripper: how the actuator is mounted, needed for shapes and grips; its actuation is
            replaced.
        bending_stiffness: EI [N m^2] where it is known; None takes it from the fitted material.
        torsional_stiffness: GJ [N m^2] likewise.

    Raises:
        InvalidInputError: a name is not a parameter, or a fixed value is not a number.

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
    gripper: Gripper | None = None
    bending_stiffness: float | None = None
    torsional_stiffness: float | None = None

    def __post_init__(self) -> None:
        require_kind("actuator", self.actuator, Actuator)
        if self.gripper is not None:
            require_kind("gripper", self.gripper, Gripper)
        require_all("quantities", self.quantities, (FittedQuantity,), "FittedQuantity values")
        require_kind("fixed", self.fixed, Mapping)
        constants = constants_of(self.fitted_law)
        for name, value in self.fixed.items():
            if name not in constants:
                raise InvalidInputError("fixed", name, f"one of {', '.join(constants)}")
            require_finite(name, value)
        if not self.names:
            raise InvalidInputError("fixed", ", ".join(self.fixed), "fewer than all parameters")
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

    @property
    def parameters(self) -> Parameters:
        """Values to start from, magnitudes and limits of the parameters.

        Raises:
            InvalidInputError: there is nothing to start the law from.
        """
        material, law = self.actuator.material, self.fitted_law
        modulus, stiffness = material.small_strain_modulus, stiffness_from_actuator(self.actuator)
        if isinstance(material, law):
            constants = {name: float(getattr(material, name)) for name in constants_of(law)}
        elif law in OF_SAME_MODULUS:
            require_positive("small_strain_modulus", modulus)
            constants = OF_SAME_MODULUS[law](modulus)
        else:
            known = ", ".join(one.__name__ for one in OF_SAME_MODULUS)
            requirement = f"the actuator's own, to start from its constants, or {known}"
            raise InvalidInputError("law", law.__name__, requirement)
        given = constants | {
            FittedQuantity.BENDING_STIFFNESS.value: stiffness.bending,
            FittedQuantity.TORSIONAL_STIFFNESS.value: stiffness.torsional,
            FittedQuantity.STRAIGHT_FIBER_RADIUS.value: self.actuator.fiber_radius,
        }
        signed = {"c2", "c3"} | ({"c1"} if law is MooneyRivlin else set())
        rows = []
        for name in self.names:
            ends = name == "extension_limit"
            scale = modulus / 6.0 if name in constants and not ends else given[name]
            # A positive quantity may fall to a millionth of its magnitude, never to zero itself.
            low = -np.inf if name in signed else 1e-6 * scale
            high = EXTENSION_LIMIT_MAX if ends else np.inf
            rows.append((min(max(given[name], low), high), scale, low, high))
        return Parameters(*np.array(rows).T)

    def actuator_from(self, values: Iterable[float]) -> Actuator:
        """Return the actuator with these parameter values.

        Raises:
            InvalidInputError: the law or the actuator refuses them.
        """
        given = dict(zip(self.names, values, strict=True)) | dict(self.fixed)
        constants = {name: float(given[name]) for name in constants_of(self.fitted_law)}
        material = cast("Any", self.fitted_law)(**constants)
        actuator = replace(self.actuator, material=material)
        if FittedQuantity.STRAIGHT_FIBER_RADIUS.value not in given:
            return actuator
        return replace(actuator, straight_fiber_radius=float(given["straight_fiber_radius"]))

    def stiffness_from(self, values: Iterable[float]) -> Section:
        """Return EI and GJ with these parameter values: fitted, given, or the material's."""
        given = dict(zip(self.names, values, strict=True))
        material = stiffness_from_actuator(self.actuator_from(values))
        bending = given.get("bending_stiffness", self.bending_stiffness)
        torsional = given.get("torsional_stiffness", self.torsional_stiffness)
        return Section.inextensible(
            bending=material.bending if bending is None else float(bending),
            torsional=material.torsional if torsional is None else float(torsional),
        )

    def trial(self, values: Iterable[float]) -> Trial:
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


# Step for the slope over the pressure, as a fraction of it: far above the rod's tolerance, and so
# small that the slope, which only weighs a stated error, is good to a thousandth.
PRESSURE_STEP = 1e-3
# Standard errors by which readings may go the wrong way: noise about zero does not go farther.
CONTRADICTION = 4.0
# Standard errors of their difference by which readings at one pressure may differ: more than
# repeats whose errors were stated three times too small ever do.
FAR_APART = 10.0
_DIRECTIONS: dict[type[Reading], str] = {
    ExtensionReading: "pressure lengthens this actuator; check the sign",
    TwistReading: (
        "right-handed rotation of the far end is positive; check the sign, and alpha and beta"
    ),
    BendReading: "it bends towards the straight fiber; check the sign",
}


def predict(trial: Trial, readings: Sequence[Reading]) -> Array:
    """Return the predicted components of all readings, one after the other.

    Args:
        trial: the parameters' choice; it must hold a gripper if there are shapes or grips.
        readings: the readings.

    Returns:
        (m,) in the units of ``measured``.

    Raises:
        InvalidInputError: a shape or grip needs a mounted gripper and there is none.
        ActuationLimitError: a pressure is past the limit of this trial's actuator.
        SolverError: a shape could not be certified.
    """
    mounted: dict[float, tuple[Gripper, UnloadedShape, RodState]] = {}
    state, elements = None, None
    found: list[float] = []
    for reading in readings:
        pressure = reading.pressure
        if not isinstance(reading, ShapeReading | GripReading):
            actuation = trial.actuation_for(reading)
            if isinstance(reading, ExtensionReading):
                per_length = actuation.stretch_from_pressure(pressure) - 1.0
            else:
                shape = actuation.unloaded_shape(pressure)
                rate = shape.torsion if isinstance(reading, TwistReading) else shape.curvature
                per_length = rate * (shape.backbone_length / actuation.actuator.tube.length)
            found.append(per_length * reading.section_length)
            continue
        if pressure not in mounted:
            if trial.gripper is None:
                raise InvalidInputError(
                    "gripper", None, "given: shapes and grips depend on the mount"
                )
            if elements is None:
                of = (one for one in readings if isinstance(one, ShapeReading | GripReading))
                shape = trial.actuation.unloaded_shape(max(one.pressure for one in of))
                elements = element_count(trial.gripper.rod(shape), trial.gripper.load(shape))
            shape = trial.actuation.unloaded_shape(pressure)
            # Each from the one before, all with the elements that the highest pressure takes.
            state = solve_rod(
                trial.gripper.rod(shape),
                trial.gripper.load(shape),
                elements=elements,
                start=state,
                estimate_error=False,
            )
            mounted[pressure] = trial.gripper, shape, state
        if isinstance(reading, ShapeReading):
            found += _position(*mounted[pressure], reading.arc_length)
        else:
            radius, _ = wrapped_radius(*mounted[pressure])
            found.append(radius + (reading.contact_shift or 0.0))
    return np.array(found, dtype=np.float64)


# Onsets of contact are looked for up to this many times the highest pressure read: those of a
# fitted gripper lie nearer, and its own limit may lie right above the readings.
ONSET_MAX = 1.25


def with_contact(
    trial: Trial, readings: Sequence[Reading], progress: Progress | None = None
) -> tuple[Reading, ...]:
    r"""Return readings with what contact changes in the radius of each touched cylinder.

    The tip touches a cylinder of radius R at the onset :math:`P_c(R)` of the wrap by contact, where
    the free coil is still wider. With the difference of the two radii, the contact shift,

    .. math:: r(P) = r_w(P) + R - r_w(P_c(R))

    is R at the onset, and near it has the slopes of :math:`r_w` over pressure and parameters: the
    shift hardly depends on them, and without weight not at all on a factor on the law's constants.

    Args:
        trial: the parameters' choice.
        readings: what was measured; a shift that is given stays.
        progress: called with the number of cylinders done and the number there are, after each;
            one takes about a second.

    Returns:
        The readings themselves where nothing is touched. The shift of a cylinder that this gripper
        does not wrap by contact is 0: it is compared by the tip criterion.
    """
    grips = [one for one in readings if isinstance(one, GripReading) and one.contact_shift is None]
    if trial.gripper is None or not grips:
        return tuple(readings)
    highest = ONSET_MAX * max(one.pressure for one in grips)
    gripper = replace(trial.gripper, pressure_max=min(highest, trial.actuation.pressure_limit))
    shifts = dict.fromkeys((one.object_radius for one in grips), 0.0)
    for count, radius in enumerate(shifts, start=1):
        with suppress(SpiralError):
            onset = sharp_onset(grip_window(lay_into_coil(gripper, radius), until_wrapped=True))
            (free,) = predict(trial, [GripReading(onset, radius, radius)]).tolist()
            shifts[radius] = radius - free
        if progress is not None:
            progress(count, len(shifts))
    touched: dict[Reading, Reading] = {
        one: replace(one, contact_shift=shifts[one.object_radius]) for one in grips
    }
    return tuple(touched.get(one, one) for one in readings)


def _position(
    gripper: Gripper, shape: UnloadedShape, state: RodState, arc_length: float | None
) -> list[float]:
    """Return the position of a point of the backbone [m]; without an arc length, of the tip."""
    from scipy.interpolate import CubicHermiteSpline

    length = gripper.tube.length
    if arc_length is None:
        return [float(x) for x in state.tip_position]
    if not arc_length <= length:
        requirement = Message("at most the length, {}", Quantity(length, "m", rounded_down))
        raise InvalidInputError("arc_length", arc_length, requirement, "m")
    spline = CubicHermiteSpline(state.arc_lengths, state.positions, state.tangents)
    position: list[float] = spline(arc_length / length * shape.backbone_length).tolist()
    return position


class Contradiction(NamedTuple):
    """Readings that no constants bring together.

    Attributes:
        places: of the readings.
        quantity: what they measured.
        values: what they read, in SI units.
        reason: what would be right.
    """

    places: tuple[int, ...]
    quantity: str
    values: tuple[float, ...]
    reason: str


def contradictions(
    trial: Trial, readings: Sequence[Reading], *, robust: bool = False
) -> list[Contradiction]:
    """Return the readings that contradict the actuator, or each other, whatever its constants.

    Constants change how far it extends, twists and bends, not in which direction, and give one
    response to one pressure.

    Args:
        trial: any choice of the parameters.
        readings: the readings.
        robust: whether single readings may be wrong: they are then left to the outliers.

    Returns:
        Readings that go the wrong way by more than :data:`CONTRADICTION` standard errors, one by
        one or all of a kind together; and pairs at one pressure that are more than
        :data:`FAR_APART` standard errors apart.
    """
    found = []
    for kind, hint in _DIRECTIONS.items():
        places = [k for k, one in enumerate(readings) if isinstance(one, kind)]
        chosen = [readings[k] for k in places]
        errors = np.array([one.error for one in chosen])
        expected, measured = predict(trial, chosen) / errors, measured_values(chosen) / errors
        signs = "negative" if expected.sum() < 0.0 else "positive"
        reason = f"{signs} for these fibers ({hint})"
        # The factor that would meet them best, over its standard error.
        together = expected @ measured < -CONTRADICTION * np.linalg.norm(expected)
        ways = np.sign(expected) * measured
        for k, way in zip(places, ways.tolist(), strict=True):
            if way < 0.0 and (together or (way < -CONTRADICTION and not robust)):
                found.append(Contradiction((k,), kind.quantity, readings[k].measured, reason))
    return found if robust else found + _far_apart(trial, readings)


def _far_apart(trial: Trial, readings: Sequence[Reading]) -> list[Contradiction]:
    """Return pairs of readings of the same that differ by far more than their errors."""
    groups: dict[tuple[object, ...], list[int]] = {}
    for k, one in enumerate(readings):
        of = getattr(one, "section_length", None), getattr(one, "arc_length", None)
        groups.setdefault((type(one), one.pressure, *of), []).append(k)
    found = []
    for places in (group for group in groups.values() if len(group) > 1):
        chosen = [readings[k] for k in places]
        values = np.array([one.measured for one in chosen])
        errors: Array = effective_errors(trial, chosen).reshape(values.shape)
        pairs = []
        for read, error in zip(values.T.tolist(), errors.T.tolist(), strict=True):
            rising = sorted(zip(read, error, places, strict=True))
            pairs += [
                ((high[0] - low[0]) / math.hypot(low[1], high[1]), low, high)
                for low, high in product(_outermost(rising), _outermost(rising[::-1]))
            ]
        apart, low, high = max(pairs)
        if apart > FAR_APART:
            reason = (
                f"alike: at one pressure they are {apart:.3g} standard errors of their "
                "difference apart; state the error that repeats show, or leave one out"
            )
            quantity, both = readings[low[2]].quantity, (low[0], high[0])
            found.append(Contradiction((low[2], high[2]), quantity, both, reason))
    return found


def _outermost(ordered: Sequence[tuple[float, float, int]]) -> list[tuple[float, float, int]]:
    """Return of values, errors and places those more exact than all that lie farther out."""
    found: list[tuple[float, float, int]] = []
    for one in ordered:
        if not found or one[1] < found[-1][1]:
            found.append(one)
    return found


def measured_values(readings: Sequence[Reading]) -> Array:
    """Return the measured components of all readings, in the order of :func:`predict`."""
    return np.array([value for reading in readings for value in reading.measured], dtype=np.float64)


def effective_errors(trial: Trial, readings: Sequence[Reading]) -> Array:
    r"""Return the standard error of each component, the pressure's share included.

    .. math:: \sigma^2 = \sigma_y^2 + \left(\frac{\partial y}{\partial P} \sigma_P\right)^2

    Source: J. Orear, American Journal of Physics 50, 1982, 912-916 (effective variance).
    """
    counts = [len(reading.measured) for reading in readings]
    own, errors = np.repeat([(r.error, r.pressure_error) for r in readings], counts, axis=0).T
    if not errors.any():
        return np.asarray(own)
    low = [replace(r, pressure=r.pressure * (1.0 - PRESSURE_STEP)) for r in readings]
    high = [
        replace(r, pressure=min(on.pressure_limit, r.pressure * (1.0 + PRESSURE_STEP)))
        for r, on in zip(readings, map(trial.actuation_for, readings), strict=True)
    ]
    steps = [(b.pressure - a.pressure) or 1.0 for a, b in zip(low, high, strict=True)]
    # At zero pressure both are the same: slope 0.
    slopes = (predict(trial, high) - predict(trial, low)) / np.repeat(steps, counts)
    total: Array = np.hypot(own, slopes * errors)
    return total


# Until the start reaches the highest measured pressure it is made stiffer by these factors: a
# little first, as noise near a limit point needs no more.
STIFFENING = (1.0, 1.01, 1.03, 1.1, 1.3, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)


def starting_values(model: CalibrationModel, readings: Sequence[Reading]) -> Array:
    """Return values from which every reading can be predicted: the model's own, or stiffer ones.

    Args:
        model: what is to be fitted.
        readings: what was measured.

    Raises:
        ActuationLimitError: the measured pressures are past what any start reaches.
    """
    stiffened, beyond = np.array([name != "extension_limit" for name in model.names]), None
    for factor in STIFFENING:
        values: Array = np.where(stiffened, factor, 1.0) * model.parameters.start
        beyond = Trial(actuation_of(model.actuator_from(values))).highest_beyond(readings)
        if beyond is None:
            return values
    raise cast("ActuationLimitError", beyond)
