# SPDX-License-Identifier: Apache-2.0
"""The computation of ``spiral-gripper calibrate``, from its parsed arguments."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from spiral_core import (
    Calibration,
    CrossValidation,
    FittedQuantity,
    InvalidInputError,
    LawChoice,
    MeasuredActuation,
    RadiusPressure,
    SpiralError,
    leave_one_out,
    measured_actuation_from_readings,
    pressure_uncertainty,
    pressure_uncertainty_by_draws,
    rival_fits,
)
from spiral_gripper.bench.measurements import (
    ERROR_COLUMNS,
    MeasurementOptions,
    Measurements,
    load_measurements,
    stated_error,
)
from spiral_gripper.bench.report import (
    copy_warnings,
    outlier_warnings,
    rival_warnings,
    warnings_of,
)
from spiral_gripper.bench.run import CalibrationRequest, modulus_warning, run_calibration
from spiral_gripper.files.description import GripperDescription
from spiral_gripper.files.fields import FIELDS, LAWS, law_name
from spiral_gripper.files.units import parse_number, parse_quantity

# Bounds of a constant that is held [Pa], [1]: far wider than rubber, but they catch wrong units.
HELD_PRESSURE = 1.0e8
HELD_EXTENSION_LIMIT = (0.1, 1.0e4)
_EXAMPLES = {"--hold": "c2=15 kPa", "--unit": "pressure=psi", "--error": "extension=0.2 mm"}


@dataclass(frozen=True, slots=True)
class CommandOptions:
    """The options of the command as click gives them; its help says what they mean."""

    laws: tuple[str, ...]
    quantities: tuple[str, ...]
    hold: tuple[str, ...]
    units: tuple[str, ...]
    errors: tuple[str, ...]
    section_length: float | None
    ignored: tuple[str, ...]
    robust: bool
    accept_implausible: bool
    radii: tuple[float, ...]
    draws: int | None
    seed: int
    level: float

    def measurement_options(self) -> MeasurementOptions:
        """Return what is stated beside the files of measurements."""
        return MeasurementOptions(
            units=_pairs("--unit", self.units),
            errors=_pairs("--error", self.errors),
            section_length=self.section_length,
            ignored=self.ignored,
        )

    def request(self) -> CalibrationRequest:
        """Return what is to be fitted."""
        held = _pairs("--hold", self.hold)
        return CalibrationRequest(
            laws=self.laws,
            quantities=tuple(FittedQuantity(one) for one in self.quantities),
            fixed={name: _constant(name, text) for name, text in held.items()},
            robust=self.robust,
            accept_implausible=self.accept_implausible,
        )


@dataclass(frozen=True, slots=True)
class CommandResult:
    """The results of the command.

    Attributes:
        choice: the fits, the best first.
        cross_validation: leave-one-out errors of the best; None if there are too few readings.
        warnings: reasons to doubt the fit, a sentence each.
        pressures: the pressure for each radius that can be gripped.
        refusals: why another radius cannot, a sentence each.
    """

    choice: LawChoice
    cross_validation: CrossValidation | None
    warnings: tuple[str, ...]
    pressures: tuple[RadiusPressure, ...]
    refusals: tuple[SpiralError, ...]


def load_files(
    description: GripperDescription, files: Sequence[Path], options: CommandOptions
) -> list[Measurements]:
    """Return the readings of files of measurements.

    Raises:
        TableError: a file cannot be used.
        InvalidInputError: an option cannot be used.
    """
    length, stated = description.actuator.tube.length, options.measurement_options()
    for name, text in stated.errors.items():
        if name not in ERROR_COLUMNS:
            raise InvalidInputError("--error", name, f"for one of {', '.join(ERROR_COLUMNS)}")
        if not stated_error(text, name, 1.0) > 0.0:
            raise InvalidInputError(f"--error {name}", text, "positive")
    loaded = [load_measurements(file, length, stated) for file in files]
    columns = frozenset().union(*(one.units for one in loaded))
    for name in stated.units:
        if name not in columns:
            raise InvalidInputError(
                "--unit", name, f"for a column of the files: {_listed(columns)}"
            )
    with_errors = {name for name, column in ERROR_COLUMNS.items() if column in columns}
    for name in stated.errors:
        if name not in with_errors:
            requirement = f"for a column of the files: {_listed(with_errors)}"
            raise InvalidInputError("--error", name, requirement)
    return loaded


def _listed(names: Collection[str]) -> str:
    return ", ".join(sorted(names))


def run_command(
    description: GripperDescription, measurements: Sequence[Measurements], options: CommandOptions
) -> CommandResult:
    """Calibrate a gripper and judge the result.

    Args:
        description: the gripper.
        measurements: the readings.
        options: what to fit and to report.

    Raises:
        SpiralError: there is no fit.
    """
    choice = run_calibration(description, measurements, options.request())
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
        remedy = f"; --law {own} fits it all the same" if fitted else ""
        warnings.insert(
            0, f"the readings do not tell the constants of {own}, the file's law, apart{remedy}"
        )
    pressures, refusals = _pressures(choice, options)
    warnings += rival_warnings(pressures)
    return CommandResult(choice, _cross_validation(best), tuple(warnings), pressures, refusals)


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


def held_air(options: CommandOptions) -> float | None:
    """Return the factor on the air's drag that a fit of a free swing holds; None if it does not.

    Raises:
        InvalidInputError: something else is held, or it is negative.
    """
    held = _pairs("--hold", options.hold)
    for name in held.keys() - {"air"}:
        raise InvalidInputError("--hold", name, "air: a free swing tells the damping alone")
    return parse_number(held["air"]) if held else None


def _cross_validation(calibration: Calibration) -> CrossValidation | None:
    """Return the leave-one-out errors, or None if there are too few readings for them."""
    try:
        return leave_one_out(calibration)
    except InvalidInputError:
        return None


def _pressures(
    choice: LawChoice, options: CommandOptions
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
    options: CommandOptions,
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


def _pairs(option: str, texts: Sequence[str]) -> dict[str, str]:
    """Return ``NAME=VALUE`` texts as a mapping."""
    pairs: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            requirement = f'of the form NAME=VALUE, such as "{_EXAMPLES[option]}"'
            raise InvalidInputError(option, text, requirement)
        if name in pairs:
            raise InvalidInputError(option, text, f"given once for {name}")
        pairs[name] = value
    return pairs


def _constant(name: str, text: str) -> float:
    """Return the value of a constant of some law, in SI units."""
    known = FIELDS.get(f"material.{name}")
    if known is None or name in ("law", "density"):
        raise InvalidInputError("--hold", name, "a constant of the law")
    if known.dimension is None:
        value = parse_number(text)
        low, high = HELD_EXTENSION_LIMIT
        requirement = f"from {low:g} to {high:g}: I1 - 3 at full extension, some 50 in latex"
    else:
        value = parse_quantity(text, known.dimension, f"--hold {name}")
        low, high = -HELD_PRESSURE, HELD_PRESSURE
        requirement = f"at most {1e-6 * high:g} MPa in size: those of rubber are 0.01 to 1 MPa"
    if not low <= value <= high:
        raise InvalidInputError(f"--hold {name}", text, requirement)
    return value
