# SPDX-License-Identifier: Apache-2.0
"""From a gripper description and files of measurements to a calibration, checked on the way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

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
    wrapped_from,
)
from spiral_core.numerics.tasks import Progress
from spiral_core.rounding import rounded_down
from spiral_gripper.bench.doubts import (
    contact_warnings,
    copy_warnings,
    outlier_warnings,
    rival_warnings,
    warnings_of,
)
from spiral_gripper.bench.measurements import (
    COLUMN_OF,
    COLUMNS,
    ERROR_COLUMNS,
    Measurements,
    load_measurements,
    stated_error,
)
from spiral_gripper.bench.options import CalibrationOptions
from spiral_gripper.bench.plausibility import (
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


# A fit, or the law's name and why there is none.
Outcome: TypeAlias = Calibration | tuple[str, SpiralError]


@dataclass(frozen=True, slots=True)
class CalibrationResult:
    """A calibration, judged.

    Attributes:
        choice: the fits, the best first.
        cross_validation: leave-one-out errors of the best; None if there are too few readings.
        warnings: reasons to doubt the fit, a sentence each.
        pressures: from which each radius is wrapped by contact.
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
    columns: set[str] = set().union(*(one.units for one in loaded))
    headings: set[str] = set().union(*(one.headings for one in loaded))
    with_errors = {name for name, column in ERROR_COLUMNS.items() if column in columns}
    for option, names, known in (
        ("--unit", options.units, columns), ("--error", options.errors, with_errors),
        ("--ignore", options.ignored, headings),
    ):  # fmt: skip
        for name in names:
            if name not in known:
                requirement = f"for a column of the files: {', '.join(sorted(known))}"
                raise InvalidInputError(option, name, requirement)
    # An option that changes no reading, because columns say it, was not meant so.
    unused: list[tuple[str, object, str, CalibrationOptions]] = [
        (f"--error {name}", text, "1", replace(options, errors=_without(options.errors, name)))
        for name, text in options.errors.items()
    ]
    given = options.section_length
    if given is not None:
        other = replace(options, section_length=2.0 * given)
        unused.append(("--section-length", given, "m", other))
    for option, value, unit, other in unused:
        with suppress(TableError):
            if [load_measurements(file, length, other) for file in files] == loaded:
                requirement = "left out: columns of the files state it, or no reading needs it"
                raise InvalidInputError(option, value, requirement, unit)
    return loaded


def _without(errors: Mapping[str, str], name: str) -> dict[str, str]:
    return {key: text for key, text in errors.items() if key != name}


def calibrate_gripper(
    description: GripperDescription,
    measurements: Sequence[Measurements],
    options: CalibrationOptions,
    progress: Progress | None = None,
) -> CalibrationResult:
    """Calibrate a gripper and judge the result.

    Args:
        description: the gripper.
        measurements: the readings.
        options: what to fit and to report.
        progress: see :func:`spiral_core.calibrate`.

    Raises:
        SpiralError: there is no fit.
    """
    choice = run_calibration(description, measurements, options, progress)
    best = choice.best
    warnings = [
        *warnings_of(best),
        *_modulus_warnings(description, best, measurements),
        *outlier_warnings(best, measurements),
        *copy_warnings(measurements),
        *contact_warnings(best, measurements),
    ]
    own = law_name(type(description.actuator.material))
    if not options.laws and best.model.fitted_law is not LAWS[own]:
        fitted = any(one.model.fitted_law is LAWS[own] for one in choice.calibrations)
        remedy = f"; --law {own} fits it anyway" if fitted else ""
        warnings.insert(
            0, f"the readings do not tell the constants of {own}, the file's law, apart{remedy}"
        )
    pressures: list[RadiusPressure] = []
    refusals: list[SpiralError] = []
    rivals = rival_fits(best, choice.calibrations) if options.radii else ()
    for radius in options.radii:
        answer = _pressure(best, radius, options, rivals)
        (refusals if isinstance(answer, SpiralError) else pressures).append(answer)  # type: ignore[arg-type]
    cross_validation = None
    with suppress(InvalidInputError):  # too few readings
        cross_validation = leave_one_out(best)
    warnings += rival_warnings(pressures)
    return CalibrationResult(
        choice,
        cross_validation,
        tuple(warnings),
        tuple(pressures),
        tuple(refusals),
        options.level,
    )


def measured_curve(
    description: GripperDescription,
    measurements: Sequence[Measurements],
    options: CalibrationOptions,
) -> MeasuredActuation:
    """Return the actuation curve that was measured.

    Raises:
        TableError: see :func:`run_calibration`.
        InvalidInputError: the readings make no curve, or a helical fiber coils the tube at rest.
    """
    _refuse_doubtful(_trial(description), measurements, options)
    readings = [reading for one in measurements for reading in one.readings]
    actuator = description.actuator
    for fiber in actuator.single_fibers:
        if fiber.angle != 0.0:
            requirement = (
                "0 for a curve from bend angles and twists: they do not tell the torsion that a "
                "helical fiber has at rest"
            )
            raise InvalidInputError("single_angles", fiber.angle, requirement, "rad")
    return measured_actuation_from_readings(readings, actuator.tube.length, actuator.fiber_pair)


def run_calibration(
    description: GripperDescription,
    measurements: Sequence[Measurements],
    options: CalibrationOptions | None = None,
    progress: Progress | None = None,
) -> LawChoice:
    """Return the fits of each requested law, the best first.

    Args:
        description: the gripper as it is described, whose constants are to start from.
        measurements: the readings, of one or more files.
        options: what to fit.
        progress: see :func:`spiral_core.calibrate`.

    Raises:
        TableError: the readings look as if they were in other units than stated, or contradict
            the fibers or each other.
        InvalidInputError: too few readings, or nothing to fit.
        SpiralError: no law could be fitted; the first one's reason.
    """
    options, trial = options or CalibrationOptions(), _trial(description)
    _refuse_doubtful(trial, measurements, options)
    readings = [reading for one in measurements for reading in one.readings]

    def outcome(law: str) -> Outcome:
        try:
            model = calibration_model(description, law, options)
            return calibrate(model, readings, robust=options.robust, progress=progress)
        except SpiralError as error:
            return (law, error)

    laws = options.laws or (law_name(type(description.actuator.material)),)
    outcomes = [outcome(law) for law in laws]
    if not options.laws and laws != (SIMPLEST_LAW,) and _is_undecided(outcomes[0]):
        outcomes.append(outcome(SIMPLEST_LAW))
    if all(isinstance(one, tuple) for one in outcomes):
        problems = [cell for one in measurements for cell in _mix_ups(trial, one, fitted=False)]
        if problems and not options.accept_implausible:
            raise TableError(problems)
        raise outcomes[0][1]  # type: ignore[index]
    return choose_law(outcomes)


def _trial(description: GripperDescription) -> Trial:
    return Trial(FreeActuation(description.actuator), description.gripper)


def _modulus_warnings(
    description: GripperDescription, best: Calibration, measurements: Sequence[Measurements]
) -> list[str]:
    """Return a warning if the fitted rubber is far from the one that the description states."""
    stated = description.actuator.material.small_strain_modulus
    fitted = best.actuator.material.small_strain_modulus
    if 1.0 / FAR_MODULUS <= fitted / stated <= FAR_MODULUS:
        return []
    others = [
        explanation
        for one in measurements
        for kind in _by_kind(one.readings)
        for explanation in other_explanations(_trial(description), kind, one.units)
    ]
    instead = f"; what would explain it too: {', '.join(dict.fromkeys(others))}" if others else ""
    ratio = f"the fitted rubber's modulus is {fitted / stated:.3g} times the description's"
    return [f"{ratio} ({fitted * 1e-6:.3g} MPa, not {stated * 1e-6:.3g} MPa){instead}"]


def _pressure(
    calibration: Calibration,
    radius: float,
    options: CalibrationOptions,
    rivals: Sequence[Calibration],
) -> RadiusPressure | SpiralError:
    """Return the pressure that wraps a radius with its uncertainty, or why there is none."""
    level, draws = options.level, options.draws
    try:
        if draws is None:
            found = pressure_uncertainty(calibration, [radius], level, rivals=rivals)
        else:
            found = pressure_uncertainty_by_draws(
                calibration, [radius], seed=options.seed, draws=draws, level=level, rivals=rivals
            )
        return wrapped_from(calibration, found[0])
    except SpiralError as error:
        return error


def _is_undecided(outcome: Outcome) -> bool:
    """Return whether there is no fit, or one that does not tell the law's constants apart."""
    if not isinstance(outcome, Calibration):
        return True
    constants = constants_of(outcome.model.fitted_law)
    return any(set(weak.names) <= set(constants) for weak in weak_directions(outcome))


def calibration_model(
    description: GripperDescription, law: str, options: CalibrationOptions
) -> CalibrationModel:
    """Return what the core is to fit for one law.

    Stiffnesses that the description states are kept; the others follow the fitted material, as the
    annulus has them. That goes for a section's own stiffness too, which only holds as a whole.
    """
    stated = description.gripper.stiffness
    derived = stiffness_from_actuator(description.actuator)
    whole = stated.coupling != 0.0 or stated.sideways != stated.bending

    def kept(name: str) -> float | None:
        value, own = getattr(stated, name), getattr(derived, name)
        return None if whole or abs(value - own) <= SAME_STIFFNESS * own else value

    try:
        return CalibrationModel(
            actuator=description.actuator,
            law=LAWS[law],
            quantities=options.quantities,
            fixed=options.fixed,
            gripper=description.gripper,
            bending_stiffness=kept("bending"),
            torsional_stiffness=kept("torsional"),
        )
    except InvalidInputError as error:
        if error.field != "fixed":
            raise
        raise InvalidInputError("--hold", error.value, error.requirement) from None


def _refuse_doubtful(
    trial: Trial, measurements: Sequence[Measurements], options: CalibrationOptions
) -> None:
    """Refuse readings that look like a mix-up, or contradict the fibers or each other."""
    for one in measurements:
        problems = _beyond_the_tip(trial, one)
        if not (problems or options.accept_implausible):
            problems = _mix_ups(trial, one)
        problems = problems or _contradictions(trial, one, robust=options.robust)
        if problems:
            raise TableError(problems)


def _beyond_the_tip(trial: Trial, measurements: Measurements) -> list[BadCell]:
    """Return the points of shapes that lie farther along the tube than it is long."""
    length = trial.actuation.actuator.tube.length
    reason = f"must be at most the tube's length, {shown(length, 'm', rounded=rounded_down)}"
    return [
        BadCell(str(measurements.source), line, None, "arc_length", reason)
        for line, one in zip(measurements.lines, measurements.readings, strict=True)
        if isinstance(one, ShapeReading) and (one.arc_length or 0.0) > length
    ]


def _mix_ups(trial: Trial, measurements: Measurements, *, fitted: bool = True) -> list[BadCell]:
    """Return the readings that no elastomer gives, but a mix-up of units does.

    Where none was fitted, none gives them.
    """
    problems = []
    for readings in _by_kind(measurements.readings):
        if discrepancy(trial, readings, 1.0, 1.0) < EXPLAINED:
            continue
        if fitted and needed_modulus(trial, readings):
            continue
        names = possible_mix_ups(trial, readings, measurements.units)
        if not names:
            continue
        line = measurements.lines[measurements.readings.index(readings[0])]
        reason = (
            f"no elastomer gives these readings with the described tube, but {' or '.join(names)} "
            "would; correct the unit, or take them as they are with --accept-implausible"
        )
        heading = f"pressure, {COLUMN_OF[type(readings[0])]}"
        problems.append(BadCell(str(measurements.source), line, None, heading, reason))
    return problems


def _contradictions(trial: Trial, measurements: Measurements, *, robust: bool) -> list[BadCell]:
    """Return the readings that no constants bring together, with their lines."""
    # Of the described tube, whose limit may lie below a reading.
    chosen = [
        (line, one)
        for line, one in zip(measurements.lines, measurements.readings, strict=True)
        if one.pressure <= trial.actuation_for(one).pressure_limit
        and not isinstance(one, ShapeReading | GripReading)
    ]
    problems = []
    for one in contradictions(trial, [reading for _, reading in chosen], robust=robust):
        line, *lines = (chosen[place][0] for place in one.places)
        unit = COLUMNS[one.quantity].si_unit
        values = " and ".join(shown(value, unit) for value in one.values)
        others = "".join(f" (with line {line})" for line in lines)
        reason = f"must be {one.reason}, got {values}{others}"
        problems.append(BadCell(str(measurements.source), line, None, one.quantity, reason))
    return problems


def _by_kind(readings: Sequence[Reading]) -> list[list[Reading]]:
    """Return readings sorted by what they measure."""
    by_kind: dict[type[Reading], list[Reading]] = {}
    for reading in readings:
        by_kind.setdefault(type(reading), []).append(reading)
    return list(by_kind.values())
