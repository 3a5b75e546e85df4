"""What ``spiral-gripper calibrate`` does, once its arguments are read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from spiral_core import (
    Calibration,
    CrossValidation,
    FittedQuantity,
    InvalidInputError,
    leave_one_out,
    measured_actuation_from_readings,
    pressure_uncertainty,
    pressure_uncertainty_by_draws,
)
from spiral_gripper.bench.calibrated_file import (
    write_calibrated_description,
    write_measured_description,
)
from spiral_gripper.bench.measurements import MeasurementOptions, Measurements, load_measurements
from spiral_gripper.bench.report import outlier_lines, radius_lines, report_lines
from spiral_gripper.bench.residual_plot import save_residual_plot
from spiral_gripper.bench.run import CalibrationRequest, run_calibration
from spiral_gripper.files.description import GripperDescription, load_description
from spiral_gripper.files.fields import FIELDS
from spiral_gripper.files.units import parse_number, parse_quantity

# Rubbers of one kind differ by less than this factor in modulus; a forgotten length does not.
FAR_MODULUS = 2.5


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
    measured_curve: bool
    radii: tuple[float, ...]
    draws: int | None
    seed: int
    level: float
    output: Path | None
    no_output: bool
    plot: Path | None

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


def run_command(gripper: str, files: Sequence[Path], options: CommandOptions) -> Iterator[str]:
    """Calibrate a gripper and write what was asked for; yield what to print, line by line.

    Args:
        gripper: name of a shipped gripper, or path of a description file.
        files: the files of measurements.
        options: everything else.

    Raises:
        SpiralError: a file cannot be used, or there is no fit.
        OSError: something cannot be written.
    """
    description = load_description(gripper)
    length, stated = description.actuator.tube.length, options.measurement_options()
    measurements = [load_measurements(file, length, stated) for file in files]
    if options.measured_curve:
        yield from _write_curve(description, measurements, options.output)
        return
    choice = run_calibration(description, measurements, options.request())
    best = choice.best
    yield from report_lines(choice, options.level, _cross_validation(best))
    yield from _modulus_lines(description, best)
    yield from outlier_lines(best, measurements)
    yield from _radius_lines(best, options)
    if options.plot is not None:
        save_residual_plot(best, options.plot)
        yield f"wrote {options.plot}"
    if not options.no_output:
        yield f"wrote {write_calibrated_description(description, best, files, options.output)}"


def _modulus_lines(description: GripperDescription, best: Calibration) -> Iterator[str]:
    """Yield a warning if the fit is far from the rubber that the description states."""
    stated = description.actuator.material.small_strain_modulus
    ratio = best.actuator.material.small_strain_modulus / stated
    if not 1.0 / FAR_MODULUS <= ratio <= FAR_MODULUS:
        yield (
            f"warning: the fitted rubber's modulus is {ratio:.3g} times the description's; check "
            "--section-length (by default the whole tube's), the units and the wall thickness"
        )


def _cross_validation(calibration: Calibration) -> CrossValidation | None:
    """Return the leave-one-out errors, or None if there are too few readings for them."""
    try:
        return leave_one_out(calibration)
    except InvalidInputError:
        return None


def _radius_lines(calibration: Calibration, options: CommandOptions) -> list[str]:
    """Return the pressure for each radius that was asked for, with its uncertainty."""
    radii, level, draws = options.radii, options.level, options.draws
    if not radii:
        return []
    if draws is None:
        return radius_lines(pressure_uncertainty(calibration, radii, level), level)
    drawn = pressure_uncertainty_by_draws(
        calibration, radii, seed=options.seed, draws=draws, level=level
    )
    return radius_lines(drawn, level)


def _write_curve(
    description: GripperDescription, measurements: Sequence[Measurements], output: Path | None
) -> Iterator[str]:
    """Write the measured actuation curve into a gripper file."""
    readings = [reading for one in measurements for reading in one.readings]
    actuation = measured_actuation_from_readings(readings, description.actuator.tube.length)
    sources = [one.source for one in measurements]
    yield f"measured up to {actuation.pressure_limit * 1e-3:.4g} kPa"
    yield f"wrote {write_measured_description(description, actuation, sources, output)}"


def _pairs(option: str, texts: Sequence[str]) -> dict[str, str]:
    """Return ``NAME=VALUE`` texts as a mapping."""
    pairs: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise InvalidInputError(option, text, "of the form NAME=VALUE")
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
        return parse_number(text)
    return parse_quantity(text, known.dimension, f"--hold {name}")
