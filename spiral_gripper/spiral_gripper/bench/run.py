# SPDX-License-Identifier: Apache-2.0
"""From a gripper description and files of measurements to a calibration, checked on the way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from spiral_core import (
    Calibration,
    CalibrationModel,
    FittedQuantity,
    FreeActuation,
    GripReading,
    InvalidInputError,
    LawChoice,
    Reading,
    ShapeReading,
    SpiralError,
    calibrate,
    choose_law,
    stiffness_from_actuator,
    weak_directions,
)
from spiral_core.calibration.model import Trial, constants_of, contradictions
from spiral_gripper.bench.measurements import COLUMNS, Measurements
from spiral_gripper.bench.plausibility import (
    COLUMN_OF,
    EXPLAINED,
    discrepancy,
    needed_modulus,
    other_explanations,
    possible_mix_ups,
)
from spiral_gripper.files.description import GripperDescription
from spiral_gripper.files.fields import LAWS, law_name
from spiral_gripper.files.shown import shown
from spiral_gripper.files.table import BadCell, TableError

# Two stiffnesses that agree to this fraction are the same one, computed twice.
SAME_STIFFNESS = 1e-12
# Rubbers of one kind differ by less than this factor in modulus; a forgotten length does not.
FAR_MODULUS = 2.5
# The law with one constant, fitted where the readings cannot distinguish more.
SIMPLEST_LAW = "neo_hookean"


@dataclass(frozen=True, slots=True)
class CalibrationRequest:
    """What to fit.

    Args:
        laws: names of the laws to try, as in description files; none means the description's own,
            and :data:`SIMPLEST_LAW` where the readings do not tell its constants apart.
        quantities: what to fit beside the constants.
        fixed: constants that are held, by name, in SI units.
        robust: whether outliers may be among the readings.
        accept_implausible: whether to accept readings that look like a mix-up of units.
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
    """Return the fits of each requested law, the best first.

    Args:
        description: the gripper as it is described, whose constants are to start from.
        measurements: the readings, of one or more files.
        request: what to fit.

    Raises:
        TableError: the readings look as if they were in other units than stated.
        InvalidInputError: too few readings, or nothing to fit.
        SpiralError: no law could be fitted; the first one's reason.
    """
    request = request or CalibrationRequest()
    for one in measurements:
        if not request.accept_implausible:
            _refuse_mix_ups(description, one)
        _refuse_contradictions(description, one, request)
    readings = [reading for one in measurements for reading in one.readings]
    laws = request.laws or (law_name(type(description.actuator.material)),)
    outcomes = [_outcome(description, law, request, readings) for law in laws]
    if not request.laws and laws != (SIMPLEST_LAW,) and _is_undecided(outcomes[0]):
        outcomes.append(_outcome(description, SIMPLEST_LAW, request, readings))
    if not any(isinstance(outcome, Calibration) for outcome in outcomes):
        raise next(one[1] for one in outcomes if not isinstance(one, Calibration))
    return choose_law(outcomes)


def modulus_warning(
    description: GripperDescription, best: Calibration, measurements: Sequence[Measurements]
) -> str | None:
    """Return a warning if the fitted rubber is far from the one that the description states."""
    stated = description.actuator.material.small_strain_modulus
    fitted = best.actuator.material.small_strain_modulus
    if 1.0 / FAR_MODULUS <= fitted / stated <= FAR_MODULUS:
        return None
    trial = Trial(FreeActuation(description.actuator), description.gripper)
    others = [
        explanation
        for one in measurements
        for kind in _by_kind(one.readings).values()
        for explanation in other_explanations(trial, kind, one.units)
    ]
    instead = f"; what would explain it too: {', '.join(dict.fromkeys(others))}" if others else ""
    return (
        f"the fitted rubber's modulus is {fitted / stated:.3g} times the description's "
        f"({fitted * 1e-6:.3g} MPa, not {stated * 1e-6:.3g} MPa){instead}"
    )


def _is_undecided(outcome: Calibration | tuple[str, SpiralError]) -> bool:
    """Return whether there is no fit, or one that does not tell the law's constants apart."""
    if not isinstance(outcome, Calibration):
        return True
    constants = constants_of(outcome.model.fitted_law)
    return any(set(weak.names) <= set(constants) for weak in weak_directions(outcome))


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

    Stiffnesses that the description states are kept; the others follow the fitted material, as the
    annulus has them. That goes for a section's own stiffness too, which only holds as a whole.
    """
    stated = description.gripper.stiffness
    derived = stiffness_from_actuator(description.actuator)
    if stated.coupling != 0.0 or stated.sideways is not None:
        stated = derived
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
    """Raise TableError for readings that no elastomer gives, but a mix-up of units does."""
    trial = Trial(FreeActuation(description.actuator), description.gripper)
    problems = []
    for kind, readings in _by_kind(measurements.readings).items():
        if discrepancy(trial, readings, 1.0, 1.0) < EXPLAINED or needed_modulus(trial, readings):
            continue
        names = possible_mix_ups(trial, readings, measurements.units)
        if not names:
            continue
        line = measurements.lines[measurements.readings.index(readings[0])]
        reason = (
            f"no elastomer gives these readings with the described tube, but {' or '.join(names)} "
            "would; correct the unit, or take them as they are with --accept-implausible"
        )
        heading = f"pressure, {COLUMN_OF[kind]}"
        problems.append(BadCell(str(measurements.source), line, None, heading, reason))
    if problems:
        raise TableError(problems)


def _refuse_contradictions(
    description: GripperDescription, measurements: Measurements, request: CalibrationRequest
) -> None:
    """Raise TableError for readings that no constants bring together, with their lines."""
    trial = Trial(FreeActuation(description.actuator), description.gripper)
    readings = measurements.readings
    # Of the described tube, whose limit may lie below a reading.
    within = [
        k
        for k, one in enumerate(readings)
        if one.pressure <= trial.actuation_for(one).pressure_limit
        and not isinstance(one, ShapeReading | GripReading)
    ]
    chosen = [readings[k] for k in within]
    problems = []
    for one in contradictions(trial, chosen, robust=request.robust):
        lines = [measurements.lines[within[k]] for k in one.places]
        dimension = COLUMNS[one.quantity]
        values = " and ".join(shown(value, dimension.si_unit) for value in one.values)
        others = "".join(f" (with line {line})" for line in lines[1:])
        reason = f"must be {one.reason}, got {values}{others}"
        problems.append(BadCell(str(measurements.source), lines[0], None, one.quantity, reason))
    if problems:
        raise TableError(sorted(problems, key=lambda problem: problem.line or 0))


def _by_kind(readings: Sequence[Reading]) -> dict[type[Reading], list[Reading]]:
    """Return readings sorted by what they measure."""
    by_kind: dict[type[Reading], list[Reading]] = {}
    for reading in readings:
        by_kind.setdefault(type(reading), []).append(reading)
    return by_kind
