# SPDX-License-Identifier: Apache-2.0
r"""The fit of a calibration model to readings, and whether they determine its parameters.

.. math:: \min_x \sum_i \left(\frac{y_i(x) - y_i}{\sigma_i}\right)^2, \qquad
    x_k = \text{value}_k / \text{scale}_k

by scipy's trust-region reflective method. A trial that makes no actuator, or one whose limit lies
below a measured pressure, has no residual: the method then shortens its step. Intervals and
outliers: :mod:`spiral_core.calibration.regression`.

Source: G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, ch. 2 and 5.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.actuator.actuator import Actuator
from spiral_core.brief import brief_repr
from spiral_core.calibration.model import (
    CalibrationModel,
    FittedQuantity,
    Trial,
    contradictions,
    effective_errors,
    measured_values,
    predict,
    starting_values,
    with_contact,
)
from spiral_core.calibration.readings import Reading, ShapeReading
from spiral_core.calibration.regression import (
    Fit,
    covariance_and_scale,
    outliers,
    slope,
    studentized,
)
from spiral_core.errors import InvalidInputError, SolverError, SpiralError
from spiral_core.message import Message, Quantity, joined
from spiral_core.numerics.tasks import Progress
from spiral_core.rod.types import Array, Section
from spiral_core.wrap.gripper import Gripper

# Step of the central differences in scaled parameters: their error is its square, 1e-8, while a
# rod's tolerance of 1e-8 L shows as 1e-4 of a derivative, which costs no more than an iteration.
DIFFERENCE_STEP = 1e-4
# Relative change of the cost or the parameters at which the fit ends: far below any standard error,
# as the method converges quadratically there.
TOLERANCE = 1e-8
EVALUATIONS_MAX = 200
# Share of the residuals that parameters could still remove when the fit counts as done: a hundredth
# moves them by a hundredth of a standard error.
OFFSET_MAX = 1e-2
# Steps of more than this many magnitudes of the parameters lead nowhere.
STEP_MAX = 1e3
# Residuals of this size, in standard errors, are rounding: the readings are met exactly.
EXACT = 1e-5
# Rounds in which errors that depend on the model's slope, the outliers, or what contact changes
# settle; each changes them far less than the one before, and readings do not carry more than two
# digits of an error.
ROUNDS = 4
# In the first two, contact shifts are computed. Without them a modulus is a few percent off, which
# changes them by a thousandth of the radius; the second time leaves a fiftieth of that.
CONTACT_ROUNDS = 2
# Condition index above which regression texts call parameters collinear.
CONDITION_MAX = 30.0
# Effect on all readings together, in standard errors, of changing a combination of parameters by
# their own magnitude, below which they are not fitted but left over.
UNSEEN = 1e-3
# Share of a weak direction below which a parameter is not counted as part of it.
SHARE_MIN = 0.2
# Relative standard error above which a parameter is called undetermined by itself.
RELATIVE_ERROR_MAX = 0.5


class CalibrationStatus(Enum):
    """How a fit ended; the value is advice to the user. Only ``CONVERGED`` is an answer."""

    CONVERGED = "the fit converged"
    ITERATION_LIMIT = "the fit did not converge; fix a constant, or choose a law with fewer"
    STUCK = (
        "the fit ran into values that make no actuator up to the measured pressures; "
        "check the readings' units and the actuator's dimensions, or choose another law"
    )


@dataclass(frozen=True, slots=True, eq=False, repr=False, kw_only=True)
class Calibration(Fit):
    """Fitted parameters of a calibration model; values and intervals are those of any :class:`Fit`.

    Attributes:
        model: what was fitted.
        readings: what it was fitted to, with the contact shifts that it computed.
        errors: (m,) of each component: stated, and for a stated error of the pressure its share.
        jacobian: (m, p) derivatives of ``residuals`` by the parameters.
        excluded: places of the readings that a robust fit left out, the farthest first.
        robust: whether it was one, though perhaps nothing had to be left out.
    """

    __repr__ = brief_repr

    model: CalibrationModel
    readings: tuple[Reading, ...]
    errors: Array
    jacobian: Array
    excluded: tuple[int, ...]
    robust: bool

    @property
    def trial(self) -> Trial:
        """What readings are predicted from with the fitted values."""
        return self.model.trial(self.values)

    @property
    def actuation(self) -> FreeActuation:
        """The fitted pressure-stretch relation.

        Its ``stretch_limit``, ``pressure_limit`` and ``limit`` tell over which range it is stable
        (dP/d lambda_1 > 0) and what ends that.
        """
        return self.trial.actuation

    @property
    def gripper(self) -> Gripper | None:
        """The mounted gripper with the fitted values, if one was given."""
        return self.trial.gripper

    @property
    def actuator(self) -> Actuator:
        """The actuator with the fitted constants."""
        return self.model.actuator_from(self.values)

    @property
    def stiffness(self) -> Section:
        """EI and GJ: fitted, given, or the fitted material's."""
        return self.model.stiffness_from(self.values)

    @property
    def fitted(self) -> NDArray[np.bool_]:
        """Which components were fitted (m,), and not left out as outliers."""
        return ~np.isin(_owners(self.readings), self.excluded)

    @property
    def standardized_residuals(self) -> Array:
        """Distance of each reading from the fit to the others, in standard errors of it (n,).

        Outliers are none of the others: two that agree would hide each other. Externally
        studentized; of a point's coordinates the largest. The errors are scaled as the others
        scatter, or as stated if these scatter improbably little.
        """
        owners = _owners(self.readings)
        kept = ~np.isin(owners, self.outliers)
        tests = studentized(self.residuals, self.jacobian, owners, kept)
        return np.array([one.ratio / one.accepted for one in tests.values()])

    @property
    def outliers(self) -> tuple[int, ...]:
        """Places of the readings that chance does not explain, the farthest first.

        The readings that a robust fit left out are among them.
        """
        found = outliers(self.residuals, self.jacobian, _owners(self.readings), trust_stated=True)
        return tuple(dict.fromkeys((*self.excluded, *found)))

    @property
    def predictions(self) -> Array:
        """What the fitted model predicts for each measured component (m,)."""
        predicted: Array = measured_values(self.readings) + self.residuals * self.errors
        return predicted

    @property
    def information_criterion(self) -> float:
        r"""Corrected Akaike criterion AICc; of two laws for the same readings, lower is better.

        .. math:: m \ln(2 \pi \mathrm{RSS} / m) + m + 2 \sum \ln \sigma_i + 2 k
            + \frac{2 k (k + 1)}{m - k - 1}, \qquad k = p + 1

        Infinite where there are too few readings to compare laws at all. The second-order
        correction is for small samples; the error scale counts as a parameter.

        Source: K. P. Burnham, D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed.,
        2002, ch. 7.
        """
        count, k = len(self.residuals), self._degrees()
        if not count - k - 1 > 0:
            return math.inf
        return self._deviance() + 2.0 * k + 2.0 * k * (k + 1) / (count - k - 1)

    @property
    def bayesian_criterion(self) -> float:
        r"""Schwarz's criterion BIC: as AICc with the penalty :math:`k \ln m`."""
        return self._deviance() + self._degrees() * math.log(len(self.residuals))

    def _degrees(self) -> int:
        """Return how many values were fitted: a reading that was left out counts as fitted."""
        return len(self.values) + 1 + int(np.sum(~self.fitted))

    def _deviance(self) -> float:
        """Return -2 ln L at the fitted error scale."""
        count = len(self.residuals)
        variance = float(np.sum(self.residuals[self.fitted] ** 2)) / count
        # A perfect fit has no scale: the smallest positive float stands for its variance.
        scale = math.log(2.0 * math.pi * max(variance, np.finfo(np.float64).tiny))
        return count * (scale + 1.0) + 2.0 * float(np.log(self.errors).sum())


def calibrate(
    model: CalibrationModel,
    readings: Sequence[Reading],
    *,
    robust: bool = False,
    start: Sequence[float] | None = None,
    progress: Progress | None = None,
) -> Calibration:
    """Return the parameters that meet the readings best, and how sure they are.

    Args:
        model: what is known, and what to fit.
        readings: what was measured; more components than parameters.
        robust: whether to leave out the readings that chance does not explain, at most a third.
        start: values to start from; None takes those of the model's actuator.
        progress: called as that of :func:`~spiral_core.calibration.model.with_contact`, for touched
            cylinders alone: in two rounds.

    Returns:
        The calibration. :func:`spiral_core.weak_directions` says whether the readings tell the
        parameters apart.

    Raises:
        InvalidInputError: too few readings, readings that go the other way than the actuator can
            (all of a kind, or unless ``robust`` a single one), or unless ``robust`` lie far apart
            at one pressure, readings that do not depend on a parameter, or a reading that needs a
            gripper without one.
        ActuationLimitError: the readings' pressures are past what any start reaches.
        SolverError: the fit did not converge.

    Source: G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, ch. 2 and 5; outliers:
    :mod:`spiral_core.calibration.regression`.

    Example:
        >>> import math
        >>> from spiral_core import FiberAngles, FreeActuation, Actuator, NeoHookean, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=NeoHookean(c1=100.0e3),
        ... )
        >>> from dataclasses import replace
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
        values = starting_values(model, readings) if start is None else np.array(start)
        first = model.trial(values)
    except InvalidInputError as error:
        raise _held_or(error, model) from None
    for one in contradictions(first, readings, robust=robust):
        unit = "rad" if one.quantity in ("bend_angle", "twist") else "m"
        read = joined(" and ", (Quantity(value, unit) for value in one.values))
        pressure = Quantity(readings[one.places[0]].pressure, "Pa")
        raise InvalidInputError(one.quantity, Message("{} at {}", read, pressure), one.reason)
    problem, owners = Problem(model, readings, effective_errors(first, readings)), _owners(readings)
    try:
        values, at_bound = problem.solve(values)
    except SolverError as error:
        raise _held_or(error, model) from None
    weighing = any(reading.pressure_error > 0.0 for reading in readings)
    excluded: tuple[int, ...] = ()
    kept, touched = owners >= 0, readings
    for count in range(ROUNDS):
        trial, last = model.trial(values), touched
        if count < CONTACT_ROUNDS:
            touched = with_contact(trial, readings, progress)
        problem = Problem(model, touched, effective_errors(trial, touched))
        before = excluded
        if robust:
            linear = problem.residuals(values), problem.jacobian(values)
            excluded = outliers(*linear, owners, trust_stated=False)
        if not weighing and touched is last and set(excluded) == set(before):
            break
        kept = ~np.isin(owners, excluded)
        chosen = tuple(one for k, one in enumerate(touched) if k not in excluded)
        values, at_bound = Problem(model, chosen, problem.errors[kept]).solve(values)
    residuals, jacobian = problem.residuals(values), problem.jacobian(values)
    covariance, error_scale = covariance_and_scale(residuals[kept], jacobian[kept])
    calibration = Calibration(
        names=model.names,
        values=values,
        covariance=covariance,
        residuals=residuals,
        degrees_of_freedom=int(kept.sum()) - len(values),
        error_scale=error_scale,
        at_bound=at_bound,
        model=model,
        readings=touched,
        errors=problem.errors,
        jacobian=jacobian,
        excluded=excluded,
        robust=robust,
    )
    _require_seen(calibration)
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


def _owners(readings: Sequence[Reading]) -> NDArray[np.intp]:
    """Return the place of the reading of each component (m,)."""
    counts = [len(reading.measured) for reading in readings]
    return np.repeat(np.arange(len(counts)), counts)


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Readings to be met by a model.

    Attributes:
        model: what is fitted.
        readings: what was measured.
        errors: (m,) standard error of each component.
    """

    model: CalibrationModel
    readings: tuple[Reading, ...]
    errors: Array

    def residuals(self, values: Array) -> Array:
        """Return (m,) predicted minus measured over the error.

        Args:
            values: parameters (p,) in their own units.

        Raises:
            SpiralError: these values predict nothing at some measured pressure.
        """
        predicted = predict(self.model.trial(values), self.readings)
        residuals: Array = (predicted - measured_values(self.readings)) / self.errors
        return residuals

    def jacobian(self, values: Array) -> Array:
        """Return (m, p) central differences of the residuals; one-sided where one side has none.

        Raises:
            SolverError: there are no residuals on either side.
        """
        columns = []
        for step in np.diag(DIFFERENCE_STEP * self.model.parameters.scale):
            change = slope(self.residuals, values, step)
            if change is None:
                raise SolverError(CalibrationStatus.STUCK, math.inf, 1)
            columns.append(change / step.sum())
        return np.column_stack(columns)

    def solve(self, start: Array) -> tuple[Array, tuple[str, ...]]:
        """Return the minimum near ``start`` (p,), and which parameters ended at a bound.

        Raises:
            SolverError: it was not found.
            SpiralError: the start itself predicts nothing.
        """
        from scipy.optimize import least_squares

        _, scales, low, high = self.model.parameters
        low, high = low / scales, high / scales
        begin = np.clip(start / scales, low + DIFFERENCE_STEP, high - DIFFERENCE_STEP)
        self.residuals(begin * scales)  # the start must be an answer: say why if not

        def residuals(x: Array) -> Array:
            """Return the residuals, or NaN where there are none: the step is then shortened."""
            try:
                return self.residuals(x * scales)
            except SpiralError:
                return np.full(len(self.errors), np.nan)

        def jacobian(x: Array) -> Array:
            scaled: Array = self.jacobian(x * scales) * scales
            return scaled

        found = least_squares(
            residuals,
            begin,
            jac=jacobian,
            bounds=(low, high),
            x_scale="jac",
            ftol=TOLERANCE,
            xtol=TOLERANCE,
            gtol=TOLERANCE,
            max_nfev=EVALUATIONS_MAX,
        )
        if found.status <= 0:
            raise SolverError(CalibrationStatus.ITERATION_LIMIT, found.optimality, found.nfev)
        active = np.minimum(found.x - low, high - found.x) < 2.0 * DIFFERENCE_STEP
        _require_stationary(found.fun, np.asarray(found.jac)[:, ~active], found.nfev)
        return found.x * scales, tuple(np.array(self.model.names)[active].tolist())


def _require_stationary(residuals: Array, jacobian: Array, evaluations: int) -> None:
    """Raise SolverError if a step of the free scaled parameters would still lower the cost.

    The method also ends where it meets what makes no actuator: then a part of the residuals is
    left that the parameters could remove (the relative offset of Bates and Watts).
    """
    base, singular, _ = np.linalg.svd(jacobian, full_matrices=False)
    parts = base.T @ residuals
    # What would take an endless step to remove is not seen by the readings: no way to go.
    base, parts = (x[..., np.abs(parts) < STEP_MAX * singular] for x in (base, parts))
    removable = float(np.linalg.norm(parts))
    left = float(np.linalg.norm(residuals - base @ parts))
    if removable > max(OFFSET_MAX * left, EXACT * math.sqrt(len(residuals))):
        raise SolverError(CalibrationStatus.STUCK, removable, evaluations)


def _require_seen(calibration: Calibration) -> None:
    """Refuse a fit of parameters on which no reading depends.

    Args:
        calibration: the fit; parameters at their bounds are not looked at.

    Raises:
        InvalidInputError: changing some combination of parameters by their own magnitude moves all
            readings together by less than a thousandth of their error.
    """
    names = [name for name in calibration.names if name not in calibration.at_bound]
    if not names:
        return
    scales = calibration.model.parameters.scale / max(calibration.error_scale, 1.0)
    free = np.isin(calibration.names, names)
    effects = (calibration.jacobian[calibration.fitted] * scales)[:, free]
    _, singular, directions = np.linalg.svd(effects, full_matrices=False)
    if singular[-1] >= UNSEEN:
        return
    unseen = _sharing(names, directions[-1])
    pressures = [reading.pressure for reading in calibration.readings]
    raise InvalidInputError(
        "readings",
        Message(
            "{} readings from {} to {}",
            len(pressures),
            Quantity(min(pressures), "Pa"),
            Quantity(max(pressures), "Pa"),
        ),
        f"such that they depend on {' and '.join(unseen)} ({_advice(calibration, unseen)})",
    )


@dataclass(frozen=True, slots=True)
class WeakDirection:
    """A combination of parameters that the readings hardly determine.

    Attributes:
        names: the parameters that take part.
        condition: how many times weaker its effect is than the strongest combination's.
        stretch_min: least stretch among the readings, by the fitted actuator.
        stretch_max: largest stretch among them.
        advice: what to measure, or what to fix.
    """

    __repr__ = brief_repr

    names: tuple[str, ...]
    condition: float
    stretch_min: float
    stretch_max: float
    advice: str

    def __str__(self) -> str:
        if len(self.names) == 1:
            return f"{self.names[0]} is not determined: {self.advice}"
        return (
            f"{' and '.join(self.names)} cannot be told apart over stretches "
            f"{self.stretch_min:.3f} to {self.stretch_max:.3f} "
            f"(condition index {self.condition:.3g}): {self.advice}"
        )


def weak_directions(calibration: Calibration) -> tuple[WeakDirection, ...]:
    """Return the combinations of parameters that the readings do not determine, the weakest first.

    A combination's condition index is how much weaker it acts than the strongest: the ratio of the
    singular values of the Jacobian, its columns scaled to length one. Empty if all are determined.
    A weak combination may be harmless: the pressure for a radius may not depend on it either, which
    its uncertainty shows.

    Args:
        calibration: the fit.

    Source: D. A. Belsley, E. Kuh, R. E. Welsch, Regression Diagnostics, 1980, ch. 3.
    """
    jacobian, names = calibration.jacobian[calibration.fitted], calibration.names
    lengths = np.linalg.norm(jacobian, axis=0)
    scaled = jacobian / np.where(lengths > 0.0, lengths, 1.0)
    _, singular, directions = np.linalg.svd(scaled, full_matrices=False)
    conditions = singular[0] / np.maximum(singular, np.finfo(np.float64).tiny)
    weak = [
        (_sharing(names, direction), condition)
        for condition, direction in zip(conditions[::-1], directions[::-1], strict=True)
        if condition > CONDITION_MAX
    ]
    named = {name for combination, _ in weak for name in combination}
    relative = calibration.standard_errors / np.abs(calibration.values)
    weak += [
        ((name,), conditions[-1])
        for name, error in zip(names, relative, strict=True)
        if name not in named and error > RELATIVE_ERROR_MAX
    ]
    if not weak:
        return ()
    actuation = calibration.actuation
    stretches = [actuation.stretch_from_pressure(one.pressure) for one in calibration.readings]
    ends = min(stretches), max(stretches)
    return tuple(
        WeakDirection(combination, float(condition), *ends, _advice(calibration, combination))
        for combination, condition in weak
    )


def _sharing(names: Sequence[str], direction: Array) -> tuple[str, ...]:
    """Return the parameters that take part in a direction of length one."""
    shares = zip(names, np.abs(direction), strict=True)
    return tuple(name for name, share in shares if share >= SHARE_MIN)


def _advice(calibration: Calibration, names: Sequence[str]) -> str:
    """Return what would tell these parameters apart."""
    if {"bending_stiffness", "torsional_stiffness"} & set(names):
        if not any(isinstance(reading, ShapeReading) for reading in calibration.readings):
            return (
                "only a shape that gravity bends depends on EI and GJ; "
                "measure positions of a long actuator, or leave them to the material"
            )
        return (
            "measure shapes in a second mount, with gravity across the tube, and at low pressure "
            "where the weight bends and twists it most"
        )
    if FittedQuantity.STRAIGHT_FIBER_RADIUS.value in names:
        return (
            "a bend angle sees stretch over radius only; "
            "add the extension of a straight section, or fix straight_fiber_radius"
        )
    if len(names) == 1:
        return "measure at higher pressures and more often, or fix it"
    return (
        "measure to a larger stretch, or a section wound at angles farther from 90 degrees (there "
        "I1 = I2), or fix one of them, or choose a law with fewer constants"
    )
