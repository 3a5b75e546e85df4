# SPDX-License-Identifier: Apache-2.0
r"""Predictions of the model for readings, and their slopes over the pressure.

Straight sections and bend angles follow from the stretch alone: extension
:math:`(\lambda_1 - 1) L`, twist :math:`\omega L / r`, bend angle :math:`\kappa` times the length of
the backbone. Shapes and grips are those of the mounted gripper under its weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.calibration.model import Trial
from spiral_core.calibration.readings import (
    BendReading,
    ExtensionReading,
    GripReading,
    Reading,
    ShapeReading,
    TwistReading,
)
from spiral_core.errors import InvalidInputError
from spiral_core.rod.solve import solve_rod
from spiral_core.rod.types import Array, RodState
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.wrap import wrapped_radius

# Step for the slope over the pressure, as a fraction of it: far above the rod's tolerance, and so
# small that the slope, which only weighs a stated error, is good to a thousandth.
PRESSURE_STEP = 1e-3
# Standard errors by which readings may go the wrong way: noise about zero does not go farther.
CONTRADICTION = 4.0
# Standard errors of their difference by which readings at one pressure may differ: more than
# repeats whose errors were stated three times too small ever do.
FAR_APART = 10.0
_NAMES: dict[type[Reading], str] = {
    ExtensionReading: "extension",
    TwistReading: "twist",
    BendReading: "bend_angle",
    ShapeReading: "position",
    GripReading: "object_radius",
}
_DIRECTIONS: dict[type[Reading], tuple[str, str]] = {
    ExtensionReading: ("extension", "pressure lengthens this actuator; check the sign"),
    TwistReading: (
        "twist",
        "right-handed rotation of the far end is positive; check the sign, and alpha and beta",
    ),
    BendReading: ("bend_angle", "it bends towards the straight fiber; check the sign"),
}


@dataclass(slots=True)
class _Shapes:
    """The mounted gripper's shapes by pressure, each solved once and from the one before."""

    gripper: Gripper
    states: dict[float, RodState] = field(default_factory=dict)

    def at(self, pressure: float) -> tuple[UnloadedShape, RodState]:
        """Return the unloaded shape and the loaded state at a pressure [Pa]."""
        shape = self.gripper.actuation.unloaded_shape(pressure)
        if pressure not in self.states:
            start = next(reversed(self.states.values())) if self.states else None
            self.states[pressure] = solve_rod(
                self.gripper.rod(shape),
                self.gripper.load(shape),
                # The same number for every trial, so that predictions depend smoothly on it.
                elements=None if start is None else len(start.arc_lengths) - 1,
                start=start,
                estimate_error=False,
            )
        return shape, self.states[pressure]


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
    shapes = None if trial.gripper is None else _Shapes(trial.gripper)
    components = [_predict_one(trial, shapes, reading) for reading in readings]
    return np.array([value for values in components for value in values], dtype=np.float64)


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
    trial: Trial, readings: Sequence[Reading], *, repeats: bool = True
) -> list[Contradiction]:
    """Return the readings that contradict the actuator, or each other, whatever its constants.

    Constants change how far it extends, twists and bends, not in which direction, and give one
    response to one pressure.

    Args:
        trial: any choice of the parameters.
        readings: the readings.
        repeats: whether readings at one pressure are compared.

    Returns:
        Readings that go the wrong way by more than :data:`CONTRADICTION` standard errors, one by
        one or all of a kind together; and pairs at one pressure that are more than
        :data:`FAR_APART` standard errors apart.
    """
    found = []
    for kind, (quantity, hint) in _DIRECTIONS.items():
        places = [k for k, one in enumerate(readings) if isinstance(one, kind)]
        chosen = [readings[k] for k in places]
        errors = np.array([one.error for one in chosen])
        expected, measured = predict(trial, chosen), measured_values(chosen)
        signs = "negative" if expected.sum() < 0.0 else "positive"
        reason = f"{signs} for these fibers ({hint})"
        ways = np.sign(expected) * measured / errors
        # The factor that would meet them best, over its standard error.
        weight = float(np.linalg.norm(expected / errors))
        together = float(expected / errors @ (measured / errors)) < -CONTRADICTION * weight
        for k, way in zip(places, ways.tolist(), strict=True):
            if way < -(0.0 if together else CONTRADICTION):
                found.append(Contradiction((k,), quantity, readings[k].measured, reason))
    return found + (_far_apart(trial, readings) if repeats else [])


def _far_apart(trial: Trial, readings: Sequence[Reading]) -> list[Contradiction]:
    """Return pairs of readings of the same that differ by far more than their errors."""
    groups: dict[tuple[object, ...], list[int]] = {}
    for k, one in enumerate(readings):
        of = getattr(one, "section_length", None), getattr(one, "arc_length", None)
        groups.setdefault((type(one), one.pressure, *of), []).append(k)
    found = []
    for places in groups.values():
        if len(places) < 2:
            continue
        values = np.array([readings[k].measured for k in places])
        errors = effective_errors(trial, [readings[k] for k in places]).reshape(values.shape)
        low, high = values.argmin(axis=0), values.argmax(axis=0)
        columns = np.arange(values.shape[1])
        apart = (values[high, columns] - values[low, columns]) / np.hypot(
            errors[high, columns], errors[low, columns]
        )
        worst = int(np.argmax(apart))
        if apart[worst] > FAR_APART:
            pair = int(low[worst]), int(high[worst])
            reason = (
                f"alike: at one pressure they are {apart[worst]:.3g} standard errors of their "
                "difference apart; state the error that repeats show, or fit without outliers"
            )
            found.append(
                Contradiction(
                    tuple(places[k] for k in pair),
                    _NAMES[type(readings[places[0]])],
                    tuple(float(values[k, worst]) for k in pair),
                    reason,
                )
            )
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
    own: Array = np.repeat([reading.error for reading in readings], counts)
    errors = np.repeat([reading.pressure_error for reading in readings], counts)
    if not errors.any():
        return own
    slopes = _pressure_slopes(trial, readings)
    total: Array = np.hypot(own, slopes * errors)
    return total


def _pressure_slopes(trial: Trial, readings: Sequence[Reading]) -> Array:
    """Return the derivative of each component over the pressure, from steps that stay in range."""
    limit = trial.actuation.pressure_limit
    low = [replace(r, pressure=r.pressure * (1.0 - PRESSURE_STEP)) for r in readings]
    high = [replace(r, pressure=min(limit, r.pressure * (1.0 + PRESSURE_STEP))) for r in readings]
    widths = [
        (b.pressure - a.pressure) or 1.0  # at zero pressure both are the same: slope 0
        for a, b in zip(low, high, strict=True)
        for _ in a.measured
    ]
    slopes: Array = (predict(trial, high) - predict(trial, low)) / np.array(widths)
    return slopes


def _predict_one(trial: Trial, shapes: _Shapes | None, reading: Reading) -> tuple[float, ...]:
    if isinstance(reading, ExtensionReading):
        stretch = trial.straight.stretch_from_pressure(reading.pressure)
        return ((stretch - 1.0) * reading.section_length,)
    if isinstance(reading, TwistReading):
        shape = trial.straight.unloaded_shape(reading.pressure)
        rate = shape.torsion * shape.backbone_length / trial.straight.actuator.tube.length
        return (rate * reading.section_length,)
    if isinstance(reading, BendReading):
        shape = trial.actuation.unloaded_shape(reading.pressure)
        elongation = shape.backbone_length / trial.actuation.actuator.tube.length
        return (shape.curvature * elongation * reading.section_length,)
    if shapes is None:
        raise InvalidInputError("gripper", None, "given: shapes and grips depend on the mount")
    if isinstance(reading, ShapeReading):
        return _position(shapes, reading)
    return (_wrapped_radius(shapes, reading),)


def _position(shapes: _Shapes, reading: ShapeReading) -> tuple[float, ...]:
    """Return the predicted position of a point of the backbone [m]."""
    from scipy.interpolate import CubicHermiteSpline

    shape, state = shapes.at(reading.pressure)
    length = shapes.gripper.tube.length
    if reading.arc_length is None:
        return tuple(float(x) for x in state.tip_position)
    if not reading.arc_length <= length:
        raise InvalidInputError("arc_length", reading.arc_length, f"at most the length {length} m")
    spline = CubicHermiteSpline(state.arc_lengths, state.positions, state.tangents)
    position = spline(reading.arc_length / length * shape.backbone_length)
    return tuple(float(x) for x in position)


def _wrapped_radius(shapes: _Shapes, reading: GripReading) -> float:
    """Return the radius that this pressure wraps perfectly [m]."""
    radius, _ = wrapped_radius(shapes.gripper, *shapes.at(reading.pressure))
    return radius
