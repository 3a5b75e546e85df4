# SPDX-License-Identifier: Apache-2.0
"""Selection of a law: information criteria of several fits, and leave-one-out errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.calibration.fit import Calibration, calibrate
from spiral_core.calibration.model import predict
from spiral_core.calibration.readings import Reading
from spiral_core.errors import InvalidInputError, SpiralError
from spiral_core.rod.types import Array


@dataclass(frozen=True, slots=True, eq=False)
class CrossValidation:
    """Predictions of readings by fits to the other readings.

    Attributes:
        measured: (k,) measured components that were predicted.
        predicted: (k,) what the fits to all other pressures predict.
        pressures: (k,) pressure of each [Pa].
        errors: (k,) standard error of each, as it was stated.
        largest: (k,) the largest measured value of the same kind of reading.
        not_predicted: pressures that a fit to the others does not reach, or where it failed [Pa].
    """

    __repr__ = brief_repr

    measured: Array
    predicted: Array
    pressures: Array
    errors: Array
    largest: Array
    not_predicted: tuple[float, ...]

    @property
    def relative_errors(self) -> Array:
        """Predicted over measured, minus one, of the values that are not 0."""
        told = self.measured != 0.0
        errors: Array = self.predicted[told] / self.measured[told] - 1.0
        return errors

    @property
    def relative_error(self) -> float:
        """Root mean square of the relative errors."""
        return _root_mean_square(self.relative_errors)

    @property
    def error_scale(self) -> float:
        """Root mean square of predicted minus measured, over the stated errors."""
        return _root_mean_square((self.predicted - self.measured) / self.errors)

    @property
    def share_of_largest(self) -> float:
        """Root mean square of predicted minus measured, over the largest value of the kind.

        Unlike the relative error it says something of readings near zero too.
        """
        told = self.largest > 0.0
        shares = (self.predicted[told] - self.measured[told]) / self.largest[told]
        return _root_mean_square(shares) if told.any() else 0.0

    @property
    def error(self) -> float:
        """Root mean square of predicted minus measured, in the unit of what was measured."""
        return _root_mean_square(self.predicted - self.measured)


def _root_mean_square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _setting(reading: Reading) -> float:
    """Return the pressure of a reading [Pa], to nine digits: one setting of the regulator."""
    return float(f"{reading.pressure:.9g}")


def leave_one_out(calibration: Calibration) -> CrossValidation:
    """Return how a fit predicts the readings of each pressure from those of all others.

    Readings at one pressure are left out together, because repeats are not independent. Readings at
    pressure zero are predicted by any fit, and are not left out.

    Args:
        calibration: the fit to repeat, as robust; readings that it left out stay out.

    Raises:
        InvalidInputError: all readings were made at one pressure, or none could be predicted.
    """
    readings = [one for k, one in enumerate(calibration.readings) if k not in calibration.excluded]
    pressurized = sorted((one for one in readings if one.pressure > 0.0), key=_setting)
    groups = [list(group) for _, group in groupby(pressurized, _setting)]
    if len(groups) < 2:
        found = f"{len(groups)} pressures above 0"
        raise InvalidInputError("readings", found, "made at two pressures above 0 at least")
    largest: dict[type[Reading], float] = {}
    for one in readings:
        largest[type(one)] = max(largest.get(type(one), 0.0), *map(abs, one.measured))
    rows: list[tuple[float, ...]] = []
    missed: list[float] = []
    for group in groups:
        others = [reading for reading in readings if reading not in group]
        try:
            start, robust = calibration.values.tolist(), calibration.robust
            fit = calibrate(calibration.model, others, robust=robust, start=start)
            predicted = iter(predict(fit.trial, group).tolist())
        except SpiralError:
            missed.append(group[0].pressure)
            continue
        for one in group:
            of_one = one.pressure, one.error, largest[type(one)]
            rows += [(value, next(predicted), *of_one) for value in one.measured]
    if not rows:
        raise InvalidInputError("readings", f"{len(groups)} pressures", "enough to leave one out")
    measured, foreseen, pressures, errors, most = np.array(rows).T
    return CrossValidation(measured, foreseen, pressures, errors, most, tuple(missed))


@dataclass(frozen=True, slots=True)
class LawChoice:
    """Fits of several laws to the same readings, the most credible first.

    Attributes:
        calibrations: the fits by rising AICc; where too few readings leave it undefined, those with
            fewer parameters first.
        failures: law's name and reason, for those that could not be fitted.
    """

    __repr__ = brief_repr

    calibrations: tuple[Calibration, ...]
    failures: tuple[tuple[str, str], ...]

    @property
    def best(self) -> Calibration:
        """The fit with the lowest criterion."""
        return self.calibrations[0]

    @property
    def weights(self) -> tuple[float, ...]:
        r"""Akaike weight of each law, :math:`\propto e^{-\Delta / 2}`: how much the data favor it.

        Zero where the criterion is infinite.
        """
        lowest = self.best.information_criterion
        if math.isinf(lowest):
            return tuple(0.0 for _ in self.calibrations)
        raw = [math.exp(0.5 * (lowest - c.information_criterion)) for c in self.calibrations]
        return tuple(value / sum(raw) for value in raw)


def choose_law(calibrations: Sequence[Calibration | tuple[str, SpiralError]]) -> LawChoice:
    """Return fits to the same readings in the order in which an information criterion puts them.

    Args:
        calibrations: the fits, and for a law that could not be fitted its name and the error.

    Raises:
        InvalidInputError: nothing to choose from, or fits to different readings.
    """
    fits = [one for one in calibrations if isinstance(one, Calibration)]
    failures = [one for one in calibrations if not isinstance(one, Calibration)]
    if not fits:
        raise InvalidInputError("calibrations", len(fits), "one successful fit at least")
    if any(one.readings != fits[0].readings for one in fits):
        raise InvalidInputError("calibrations", "different readings", "fits to the same readings")
    fits.sort(key=lambda c: (c.information_criterion, len(c.values), c.bayesian_criterion))
    return LawChoice(tuple(fits), tuple((name, str(error)) for name, error in failures))
