# SPDX-License-Identifier: Apache-2.0
"""Fit of a calibration model to readings: least squares, or Huber's loss against outliers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from spiral_core.calibration.identifiability import require_seen
from spiral_core.calibration.model import CalibrationModel, actuation_of
from spiral_core.calibration.outliers import Scatter, outliers, scatter_of
from spiral_core.calibration.predict import (
    contradictions,
    effective_errors,
    measured_values,
)
from spiral_core.calibration.problem import Problem, Solution
from spiral_core.calibration.readings import Reading, ShapeReading
from spiral_core.calibration.result import Calibration
from spiral_core.calibration.start import starting_values
from spiral_core.errors import InvalidInputError, SolverError, SpiralError
from spiral_core.rod.types import Array

# Rounds in which errors that depend on the model's slope, or the outliers, settle; each changes
# them far less than the one before, and readings do not carry more than two digits of an error.
ROUNDS = 4


def calibrate(
    model: CalibrationModel,
    readings: Sequence[Reading],
    *,
    robust: bool = False,
    start: Sequence[float] | None = None,
) -> Calibration:
    """Return the parameters that meet the readings best, and how sure they are.

    Args:
        model: what is known, and what to fit.
        readings: what was measured; more components than parameters.
        robust: whether to leave out the readings that chance does not explain, at most a third.
        start: values to start from; None takes those of the model's actuator.

    Returns:
        The calibration. :func:`spiral_core.weak_directions` says whether the readings tell the
        parameters apart.

    Raises:
        InvalidInputError: too few readings, readings that go the other way than the actuator can
            or (unless ``robust``) lie far apart at one pressure, readings that do not depend on a
            parameter, or a reading that needs a gripper without one.
        ActuationLimitError: the readings' pressures are past what any start reaches.
        SolverError: the fit did not converge.

    Source: G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, ch. 2 and 5; outliers:
    :mod:`spiral_core.calibration.outliers`.

    Example:
        >>> import math
        >>> from spiral_core import FiberAngles, FreeActuation, Actuator, NeoHookean, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=NeoHookean(c1=100.0e3),
        ... )
        >>> section = actuator.without_single_fibers()  # what extension is measured on
        >>> truth = FreeActuation(replace(section, material=NeoHookean(c1=145.0e3)))
        >>> from spiral_core.calibration.readings import ExtensionReading
        >>> readings = [
        ...     ExtensionReading(p, 0.1 * (truth.stretch_from_pressure(p) - 1.0), 0.1, 1.0e-4)
        ...     for p in (20.0e3, 40.0e3, 60.0e3)
        ... ]
        >>> round(calibrate(CalibrationModel(actuator), readings).value("c1"))
        145000
    """
    readings = tuple(readings)
    _require_enough(model, readings)
    try:
        values = starting_values(model, readings) if start is None else tuple(start)
        first = model.trial(values)
    except InvalidInputError as error:
        raise _held_or(error, model) from None
    for one in contradictions(first, readings, repeats=not robust):
        at = readings[one.places[0]].pressure
        read = " and ".join(f"{value:.6g}" for value in one.values)
        raise InvalidInputError(one.quantity, f"{read} (SI) at {at:.6g} Pa", one.reason)
    errors = effective_errors(first, readings)
    problem = Problem(model, readings, errors)
    try:
        solution = problem.solve(values)
    except SolverError as error:
        raise _held_or(error, model) from None
    weighing = any(reading.pressure_error > 0.0 for reading in readings)
    excluded: tuple[int, ...] = ()
    full = problem
    for _ in range(ROUNDS if weighing or robust else 0):
        trial = model.trial(solution.values.tolist())
        full = replace(problem, errors=effective_errors(trial, readings))
        found = _outliers(full, solution.values) if robust else ()
        settled = not weighing and set(found) == set(excluded)
        excluded = found
        if settled:
            break
        solution = full.without(excluded).solve(solution.values.tolist())
    calibration = _calibration(full, solution, excluded)
    require_seen(calibration)
    return calibration


def _held_or(error: SpiralError, model: CalibrationModel) -> SpiralError:
    """Return why a fit failed: with constants that are held, most likely those."""
    if not model.fixed:
        return error
    held = ", ".join(f"{name} = {value:g}" for name, value in model.fixed.items())
    free = " and ".join(model.names)
    requirement = f"such that some {free} makes a law that meets the readings; leave them free"
    return InvalidInputError("held constants", held, requirement)


def _require_enough(model: CalibrationModel, readings: Sequence[Reading]) -> None:
    """Refuse readings that leave nothing over to judge the errors by."""
    count = len(measured_values(readings))
    if not count > len(model.names):
        names = ", ".join(model.names)
        raise InvalidInputError(
            "readings",
            f"{count} measured values",
            f"at least {len(model.names) + 1}, to fit {names} and judge the errors",
        )
    # Repeats at one pressure tell how they scatter, not another parameter.
    told = {
        (type(one), one.pressure, getattr(one, "arc_length", None)): len(one.measured)
        for one in readings
        if one.pressure > 0.0 or isinstance(one, ShapeReading)
    }
    if not sum(told.values()) >= len(model.names):
        raise InvalidInputError(
            "readings",
            f"{len(told)} different pressures above 0",
            f"made at {len(model.names)} different pressures above 0 at least, or of several "
            f"kinds, to tell {' and '.join(model.names)}",
        )


def _outliers(problem: Problem, values: Array) -> tuple[int, ...]:
    """Return the readings that chance does not explain at a solution."""
    counts = [len(reading.measured) for reading in problem.readings]
    owners = np.repeat(np.arange(len(counts)), counts)
    residuals, jacobian = problem.residuals(values), problem.jacobian(values)
    return outliers(residuals, jacobian, owners, trust_stated=False)


def _calibration(problem: Problem, solution: Solution, excluded: tuple[int, ...]) -> Calibration:
    """Return the result with its covariance; readings that were left out have residuals too."""
    freedom = len(solution.residuals) - len(solution.values)
    variance = float(solution.residuals @ solution.residuals) / freedom
    small = scatter_of(math.sqrt(variance), freedom) is Scatter.TOO_SMALL
    accepted = 1.0 if small else variance  # by which the stated errors are scaled, squared
    values = solution.values
    active = zip(problem.model.names, solution.active, strict=True)
    return Calibration(
        model=problem.model,
        readings=problem.readings,
        values=values,
        covariance=accepted * inverse_information(solution.jacobian),
        degrees_of_freedom=freedom,
        residuals=problem.residuals(values) if excluded else solution.residuals,
        errors=problem.errors,
        jacobian=problem.jacobian(values) if excluded else solution.jacobian,
        error_scale=math.sqrt(variance),
        at_bound=tuple(name for name, hit in active if hit),
        excluded=excluded,
        actuation=actuation_of(problem.model.actuator_from(values.tolist())),
        gripper=problem.model.trial(values.tolist()).gripper,
    )


def inverse_information(jacobian: Array) -> Array:
    """Return (J^T J)^-1 by singular values of J with its columns scaled to length one.

    A direction that no reading sees at all would divide by zero; the smallest positive float times
    the largest singular value stands in, and shows as an absurdly wide interval.
    """
    lengths = np.linalg.norm(jacobian, axis=0)
    lengths = np.where(lengths > 0.0, lengths, np.finfo(np.float64).tiny ** 0.25)
    _, singular, directions = np.linalg.svd(jacobian / lengths, full_matrices=False)
    floor = np.finfo(np.float64).eps * max(float(singular[0]), 1.0)
    scaled = directions / np.maximum(singular, floor)[:, None]
    inverse: Array = scaled.T @ scaled / np.outer(lengths, lengths)
    return inverse
