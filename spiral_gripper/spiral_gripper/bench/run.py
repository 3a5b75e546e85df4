"""From a gripper description and files of measurements to a calibration, checked on the way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from spiral_core import (
    Calibration,
    CalibrationModel,
    FittedQuantity,
    FreeActuation,
    InvalidInputError,
    LawChoice,
    Reading,
    SpiralError,
    calibrate,
    choose_law,
    stiffness_from_actuator,
)
from spiral_core.calibration.model import Trial
from spiral_core.calibration.plausibility import find_unit_mix_up
from spiral_gripper.bench.errors import BadCell, MeasurementError
from spiral_gripper.bench.measurements import Measurements
from spiral_gripper.files.description import GripperDescription
from spiral_gripper.files.fields import LAWS

# Two stiffnesses that agree to this fraction are the same one, computed twice.
SAME_STIFFNESS = 1e-12


@dataclass(frozen=True, slots=True)
class CalibrationRequest:
    """What to fit.

    Args:
        laws: names of the laws to try, as in description files; none means the description's own.
        quantities: what to fit beside the constants.
        fixed: constants that are held, by name, in SI units.
        robust: whether outliers may be among the readings.
        accept_implausible: whether readings are taken as they are, although a mix-up of units
            would explain them better.
    """

    laws: tuple[str, ...] = ()
    quantities: tuple[FittedQuantity, ...] = ()
    fixed: Mapping[str, float] = field(default_factory=dict)
    robust: bool = False
    accept_implausible: bool = False

    def __post_init__(self) -> None:
        for law in self.laws:
            if law not in LAWS:
                raise InvalidInputError("law", law, f"one of {', '.join(LAWS)}")


def run_calibration(
    description: GripperDescription,
    measurements: Sequence[Measurements],
    request: CalibrationRequest | None = None,
) -> LawChoice:
    """Return the fits of each law that was asked for, the most credible first.

    Args:
        description: the gripper as it is described, whose constants are to start from.
        measurements: the readings, of one or more files.
        request: what to fit.

    Raises:
        MeasurementError: the readings look as if they were in other units than stated.
        InvalidInputError: too few readings, or nothing to fit.
        SpiralError: no law could be fitted; the first one's reason.
    """
    request = request or CalibrationRequest()
    for one in measurements:
        if not request.accept_implausible:
            _refuse_mix_ups(description, one)
    readings = [reading for one in measurements for reading in one.readings]
    own_law = next(k for k, v in LAWS.items() if isinstance(description.actuator.material, v))
    laws = request.laws or (own_law,)
    outcomes = [_outcome(description, law, request, readings) for law in laws]
    if not any(isinstance(outcome, Calibration) for outcome in outcomes):
        raise next(one[1] for one in outcomes if not isinstance(one, Calibration))
    return choose_law(outcomes)


def _outcome(
    description: GripperDescription,
    law: str,
    request: CalibrationRequest,
    readings: Sequence[Reading],
) -> Calibration | tuple[str, SpiralError]:
    """Return the fit of one law, or its name and why there is none."""
    try:
        model = calibration_model(description, law, request)
        return calibrate(model, readings, robust=request.robust)
    except SpiralError as error:
        return (law, error)


def calibration_model(
    description: GripperDescription, law: str, request: CalibrationRequest
) -> CalibrationModel:
    """Return what the core is to fit for one law.

    Stiffnesses that the description states are kept; the others follow the fitted material.
    """
    stated = description.gripper.stiffness
    derived = stiffness_from_actuator(description.actuator)
    return CalibrationModel(
        actuator=description.actuator,
        law=LAWS[law],
        quantities=request.quantities,
        fixed=request.fixed,
        gripper=description.gripper,
        bending_stiffness=_if_stated(stated.bending, derived.bending),
        torsional_stiffness=_if_stated(stated.torsional, derived.torsional),
    )


def _if_stated(value: float, derived: float) -> float | None:
    return None if abs(value - derived) <= SAME_STIFFNESS * derived else value


def _refuse_mix_ups(description: GripperDescription, measurements: Measurements) -> None:
    """Raise MeasurementError if a mix-up of units explains a file's readings better."""
    trial = Trial(FreeActuation(description.actuator), description.gripper)
    by_kind: dict[type, list[Reading]] = {}
    for reading in measurements.readings:
        by_kind.setdefault(type(reading), []).append(reading)
    problems = []
    for kind, readings in by_kind.items():
        found = find_unit_mix_up(trial, readings)
        if found is None:
            continue
        heading = "pressure" if found.response_factor == 1.0 else _HEADINGS[kind.__name__]
        line = measurements.lines[measurements.readings.index(readings[0])]
        reason = (
            f"looks like {found.description}: the described gripper would differ by a factor of "
            f"{found.discrepancy:.3g}, and of {found.discrepancy_if:.3g} with that corrected; "
            "correct the unit, or accept the readings as they are if they are right"
        )
        problems.append(BadCell(str(measurements.source), line, None, heading, reason))
    if problems:
        raise MeasurementError(problems)


_HEADINGS = {
    "ExtensionReading": "extension",
    "TwistReading": "twist",
    "BendReading": "bend_angle",
    "ShapeReading": "x, y, z",
    "GripReading": "object_radius",
}
