# SPDX-License-Identifier: Apache-2.0
"""From a gripper description and files of measurements to a calibration, checked on the way."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from spiral_core import (
    CalibrationModel,
    FreeActuation,
    GripReading,
    InvalidInputError,
    MeasuredActuation,
    ShapeReading,
    SpiralError,
    calibrate,
    choose_law,
    leave_one_out,
    measured_actuation_from_readings,
    pressure_uncertainty,
    stiffness_from_actuator,
    weak_directions,
)
from spiral_core.calibration.fit import Calibration
from spiral_core.calibration.model import Trial, constants_of, contradictions
from spiral_core.calibration.readings import Reading
from spiral_core.calibration.selection import CrossValidation, LawChoice
from spiral_core.calibration.uncertainty import (
    RadiusPressure,
    pressure_uncertainty_by_draws,
    rival_fits,
)
from spiral_gripper.bench.doubts import (
    copy_warnings,
    outlier_warnings,
    rival_warnings,
    warnings_of,
)
from spiral_gripper.bench.measurements import (
    COLUMNS,
    ERROR_COLUMNS,
    Measurements,
    load_measurements,
    stated_error,
)
from spiral_gripper.bench.options import CalibrationOptions
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
class CalibrationResult:
    """A calibration, judged.

    Attributes:
        choice: the fits, the best first.
        cross_validation: leave-one-out errors of the best; None if there are too few readings.
        warnings: reasons to doubt the fit, a sentence each.
        pressures: the pressure for each radius that can be gripped.
        refusals: why another radius cannot, a sentence each.
        level: confidence level of the intervals, in (0, 1).
    """

    choice: LawChoice
    cross_validation: CrossValidation | None
    warnings: tuple[str, ...]
    pressures: tuple[RadiusPressure, ...]
    refusals: tuple[SpiralError, ...]
    level: float


def load_files(
    description: GripperDescription, files: Sequence[Path], options: CalibrationOptions
) -> list[Measurements]:
    """Return the readings of files of measurements.

    Raises:
        TableError: a file cannot be used.
        InvalidInputError: an option cannot be used.
    """
    for name, text in options.errors.items():
        if name not in ERROR_COLUMNS:
            raise InvalidInputError("--error", name, f"for one of {', '.join(ERROR_COLUMNS)}")
        if not stated_error(text, name, 1.0) > 0.0:
            raise InvalidInputError(f"--error {name}", text, "positive")
    length = description.actuator.tube.length
    loaded = [load_measurements(file, length, options) for file in files]
    columns = frozenset().union(*(one.units for one in loaded))
    for name in options.units:
        if name not in columns:
            raise InvalidInputError(
                "--unit", name, f"for a column of the files: {_listed(columns)}"
            )
    with_errors = {name for name, column in ERROR_COLUMNS.items() if column in columns}
    for name in options.errors:
        if name not in with_errors:
            requirement = f"for a column of the files: {_listed(with_errors)}"
            raise InvalidInputError("--error", name, requirement)
    return loaded


def _listed(names: Collection[str]) -> str:
    return ", ".join(sorted(names))


def calibrate_gripper(
    description: GripperDescription,
    measurements: Sequence[Measurements],
    options: CalibrationOptions,
) -> CalibrationResult:
    """Calibrate a gripper and judge the result.

    Args:
        description: the gripper.
        measurements: the readings.
        options: what to fit and to report.

    Raises:
        SpiralError: there is no fit.
    """
    choice = run_calibration(description, measurements, options)
    best = choice.best
    modulus = modulus_warning(description, best, measurements)
    warnings = [
        *warnings_of(best),
        *([] if modulus is None else [modulus]),
        *outlier_warnings(best, measurements),
        *copy_warnings(measurements),
    ]
    own = law_name(type(description.actuator.material))
    if not options.laws and best.model.fitted_law is not LAWS[own]:
        fitted = any(one.model.fitted_law is LAWS[own] for one in choice.calibrations)
        remedy = f"; --law {own} fits it anyway" if fitted else ""
        warnings.insert(
            0, f"the readings do not tell the constants of {own}, the file's law, apart{remedy}"
        )
    pressures, refusals = _pressures(choice, options)
    warnings += rival_warnings(pressures)
    return CalibrationResult(
        choice, _cross_validation(best), tuple(warnings), pressures, refusals, options.level
    )


def measured_curve(
    description: GripperDescription, measurements: Sequence[Measurements]
) -> MeasuredActuation:
    """Return the actuation curve that was measured.

    Raises:
        InvalidInputError: the readings make no curve.
    """
    readings = [reading for one in measurements for reading in one.readings]
    actuator = description.actuator
    return measured_actuation_from_readings(readings, actuator.tube.length, actuator.fiber_pair)


def run_calibration(
    description: GripperDescription,
    measurements: Sequence[Measurements],
    options: CalibrationOptions | None = None,
) -> LawChoice:
    """Return the fits of each requested law, the best first.

    Args:
        description: the gripper as it is described, whose constants are to start from.
        measurements: the readings, of one or more files.
        options: what to fit.

    Raises:
        TableError: the readings look as if they were in other units than stated.
        InvalidInputError: too few readings, or nothing to fit.
        SpiralError: no law could be fitted; the first one's reason.
    """
    options = options or CalibrationOptions()
    for one in measurements:
        if not options.accept_implausible:
            _refuse_mix_ups(description, one)
        _refuse_contradictions(description, one, options)
    readings = [reading for one in measurements for reading in one.readings]
    laws = options.laws or (law_name(type(description.actuator.material)),)
    outcomes = [_outcome(description, law, options, readings) for law in laws]
    if not options.laws and laws != (SIMPLEST_LAW,) and _is_undecided(outcomes[0]):
        outcomes.append(_outcome(description, SIMPLEST_LAW, options, readings))
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


def _cross_validation(calibration: Calibration) -> CrossValidation | None:
    """Return the leave-one-out errors, or None if there are too few readings for them."""
    try:
        return leave_one_out(calibration)
    except InvalidInputError:
        return None


def _pressures(
    choice: LawChoice, options: CalibrationOptions
) -> tuple[tuple[RadiusPressure, ...], tuple[SpiralError, ...]]:
    """Return the pressures for the radii that were asked for, and why some have none."""
    found: list[RadiusPressure] = []
    refused: list[SpiralError] = []
    rivals = rival_fits(choice.best, choice.calibrations) if options.radii else ()
    for radius in options.radii:
        answer = _pressure(choice.best, radius, options, rivals)
        if isinstance(answer, SpiralError):
            refused.append(answer)
        else:
            found.append(answer)
    return tuple(found), tuple(refused)


def _pressure(
    calibration: Calibration,
    radius: float,
    options: CalibrationOptions,
    rivals: Sequence[Calibration],
) -> RadiusPressure | SpiralError:
    """Return the pressure for one radius with its uncertainty, or why there is none."""
    level, draws = options.level, options.draws
    try:
        if draws is None:
            return pressure_uncertainty(calibration, [radius], level, rivals=rivals)[0]
        return pressure_uncertainty_by_draws(
            calibration, [radius], seed=options.seed, draws=draws, level=level, rivals=rivals
        )[0]
    except SpiralError as error:
        return error


def _is_undecided(outcome: Calibration | tuple[str, SpiralError]) -> bool:
    """Return whether there is no fit, or one that does not tell the law's constants apart."""
    if not isinstance(outcome, Calibration):
        return True
    constants = constants_of(outcome.model.fitted_law)
    return any(set(weak.names) <= set(constants) for weak in weak_directions(outcome))


def _outcome(
    description: GripperDescription,
    law: str,
    options: CalibrationOptions,
    readings: Sequence[Reading],
) -> Calibration | tuple[str, SpiralError]:
    """Return the fit of one law, or its name and why there is none."""
    try:
        model = calibration_model(description, law, options)
        return calibrate(model, readings, robust=options.robust)
    except SpiralError as error:
        return (law, error)


def calibration_model(
    description: GripperDescription, law: str, options: CalibrationOptions
) -> CalibrationModel:
    """Return what the core is to fit for one law.

    Stiffnesses that the description states are kept; the others follow the fitted material, as the
    annulus has them. That goes for a section's own stiffness too, which only holds as a whole.
    """
    stated = description.gripper.stiffness
    derived = stiffness_from_actuator(description.actuator)
    if stated.coupling != 0.0 or stated.sideways != stated.bending:
        stated = derived
    return CalibrationModel(
        actuator=description.actuator,
        law=LAWS[law],
        quantities=options.quantities,
        fixed=options.fixed,
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
    description: GripperDescription, measurements: Measurements, options: CalibrationOptions
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
    for one in contradictions(trial, chosen, robust=options.robust):
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
