# SPDX-License-Identifier: Apache-2.0
r"""From uncertain parameters to the uncertain pressure for an object.

Linear propagation takes the slopes of the pressure over the parameters,

.. math:: \sigma_P^2 = g^T C g, \qquad g_k = \frac{\partial P(r)}{\partial \theta_k}
    = -\frac{\partial r / \partial \theta_k}{\partial r / \partial P},

Monte Carlo draws parameters from their joint distribution and asks each gripper. Both carry the
fitted parameters' uncertainty, not that of the radius. Where the readings cannot tell the fitted
law from another one, the interval covers the other's too: the other form of the curvature, and the
laws that it was compared with. Both are of the tip criterion; :func:`wrapped_from` carries them to
the onset of the wrap by contact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from spiral_core.actuator.actuator import CurvatureForm
from spiral_core.brief import brief_repr
from spiral_core.calibration.fit import Calibration, calibrate
from spiral_core.calibration.regression import DEFAULT_LEVEL, Interval, Scatter, slope
from spiral_core.errors import InvalidInputError, SpiralError
from spiral_core.grip.places import not_held
from spiral_core.grip.setup import lay_into_coil
from spiral_core.grip.window import grip_window
from spiral_core.message import Message, Quantity
from spiral_core.numerics.tasks import in_turn
from spiral_core.rod.solve import solve_rod
from spiral_core.rod.types import Array
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.wrap import Wrap, wrapped_radius

# Steps of the slopes, in standard errors along the principal directions of the covariance: small
# against the curvature of r over the parameters, large against what a solve leaves of it.
STEP = 0.1
# Half the step of the radius' slope over the pressure, as a fraction of that.
PRESSURE_STEP = 1e-4
DEFAULT_DRAWS = 400
# An interval from fewer draws than this would be their extremes.
DRAWS_MIN = 40


# A law is a rival while its AICc is higher by less than this: a twentieth of the likelihood.
RIVAL_MAX = 6.0


@dataclass(frozen=True, slots=True)
class RivalPressure:
    """The pressure for one object by a law that the readings cannot tell from the fitted one.

    Attributes:
        law: its name, with the form of the curvature.
        pressure: of the perfect wrap with its fitted values [Pa]; infinite if it cannot grip.
        interval: confidence interval of the pressure [Pa].
    """

    law: str
    pressure: float
    interval: Interval


@dataclass(frozen=True, slots=True)
class RadiusPressure:
    """The pressure for one object with its uncertainty.

    Attributes:
        radius: of the object [m].
        pressure: of the perfect wrap with the fitted values [Pa]: the tip criterion's, or the onset
            by contact of :func:`wrapped_from`.
        standard_error: of the pressure, from the fitted law alone [Pa].
        interval: confidence interval of the pressure [Pa]; it covers those of ``rivals``.
        own_interval: that of the fitted law alone [Pa].
        failed_draws: share of Monte Carlo draws that cannot grip this radius; 0 for the linear
            propagation.
        rivals: by laws that the readings cannot tell from the fitted one.
    """

    __repr__ = brief_repr

    radius: float
    pressure: float
    standard_error: float
    interval: Interval
    own_interval: Interval
    failed_draws: float = 0.0
    rivals: tuple[RivalPressure, ...] = ()


def rival_fits(
    calibration: Calibration, compared: Sequence[Calibration] = ()
) -> tuple[Calibration, ...]:
    """Return the fits of other laws that the readings cannot tell from the fitted one.

    Args:
        calibration: the fit.
        compared: fits of other laws to the same readings.

    Returns:
        The same law with the other form of the curvature and the fit's contact shifts, and those of
        ``compared``, whose AICc is less than :data:`RIVAL_MAX` higher. Without enough readings for
        AICc, all of them.
    """
    rivals = [one for one in compared if one is not calibration]
    (form,) = set(CurvatureForm) - {calibration.actuator.curvature_form}
    # Not every actuator has both forms, and not every form meets the readings.
    with suppress(SpiralError):
        actuator = replace(calibration.model.actuator, curvature_form=form)
        model = replace(calibration.model, actuator=actuator)
        rivals.append(calibrate(model, calibration.readings, robust=calibration.robust))
    limit = calibration.information_criterion + RIVAL_MAX
    return tuple(one for one in rivals if math.isinf(limit) or one.information_criterion < limit)


def pressure_uncertainty(
    calibration: Calibration,
    radii: Sequence[float],
    level: float = DEFAULT_LEVEL,
    *,
    rivals: Sequence[Calibration] | None = None,
) -> tuple[RadiusPressure, ...]:
    """Return the pressure for each radius with its uncertainty, by linear propagation.

    Args:
        calibration: a fit whose model holds a gripper.
        radii: objects' radii [m], each grippable with the fitted values.
        level: confidence level, in (0, 1).
        rivals: fits of laws that the readings cannot tell from this one; None takes
            :func:`rival_fits`.

    Raises:
        InvalidInputError: the calibration has no gripper.
        NotGrippableError: a radius cannot be gripped.
        NoCoilError: the fitted gripper does not coil.
    """
    found = _by_fitted_law(calibration, radii, level)
    rivals = rival_fits(calibration) if rivals is None else rivals
    return tuple(_widened(one, rivals, level) for one in found)


def _by_fitted_law(
    calibration: Calibration, radii: Sequence[float], level: float
) -> list[RadiusPressure]:
    """Return the pressures with the uncertainty of the constants alone."""
    wraps = _wraps(calibration, radii)
    best = np.array([wrap.pressure for wrap in wraps])
    at = np.append(calibration.values, 1.0)
    steps = [np.append(STEP * row, 0.0) for row in _principal_directions(calibration)]
    steps.append(PRESSURE_STEP * np.eye(len(at))[-1])
    changes = [slope(partial(_radii, calibration, wraps), at, step) for step in steps]
    known = [change for change in changes if change is not None]
    if len(known) < len(steps):  # beyond the ends of what can be gripped
        requirement = "farther from the ends of the range, to judge their uncertainty"
        raise InvalidInputError("radii", tuple(radii), requirement)
    ratios = np.array(known[:-1]) / known[-1] * (PRESSURE_STEP / STEP)
    errors = best * np.linalg.norm(ratios, axis=0)
    half = calibration.interval_factor(level) * errors
    rows = zip(radii, best, errors, best - half, best + half, strict=True)
    return [_of_constants(*map(float, row)) for row in rows]


def _of_constants(
    radius: float, pressure: float, error: float, low: float, high: float, failed: float = 0.0
) -> RadiusPressure:
    """Return a pressure whose interval is that of the fitted law alone."""
    interval = Interval(low, high)
    return RadiusPressure(radius, pressure, error, interval, interval, failed)


def _widened(one: RadiusPressure, rivals: Sequence[Calibration], level: float) -> RadiusPressure:
    """Return a pressure whose interval covers those of rival laws."""
    others = []
    for rival in rivals:
        form = rival.actuator.curvature_form.value
        name = f"{rival.model.fitted_law.__name__}, {form} curvature"
        pressure, interval = math.inf, Interval(math.inf, math.inf)  # if it cannot grip the radius
        with suppress(SpiralError):
            (found,) = _by_fitted_law(rival, (one.radius,), level)
            pressure, interval = found.pressure, found.interval
        others.append(RivalPressure(name, pressure, interval))
    lows, highs = zip(one.interval, *(other.interval for other in others), strict=True)
    return replace(one, interval=Interval(min(lows), max(highs)), rivals=tuple(others))


def pressure_uncertainty_by_draws(
    calibration: Calibration,
    radii: Sequence[float],
    *,
    seed: int,
    draws: int = DEFAULT_DRAWS,
    level: float = DEFAULT_LEVEL,
    executor: Executor | None = None,
    rivals: Sequence[Calibration] | None = None,
) -> tuple[RadiusPressure, ...]:
    """Return the pressure for each radius with its uncertainty, by Monte Carlo.

    Parameters are drawn from the multivariate t distribution of the fit. Each draw solves its own
    range of grips, some 20 ms, because where the coil begins and ends depends on the draw too.

    Args:
        calibration: a fit whose model holds a gripper.
        radii: objects' radii [m], each grippable with the fitted values.
        seed: of the random numbers; the same seed gives the same answer.
        draws: how many, >= 40.
        level: confidence level, in (0, 1).
        executor: makes the draws, in processes or threads; None makes them one after another.
        rivals: as for :func:`pressure_uncertainty`; their intervals are propagated linearly.

    Raises:
        InvalidInputError: the calibration has no gripper, there are too few draws, or hardly any
            of them grips a radius.
        NotGrippableError: a radius cannot be gripped with the fitted values.
        NoCoilError: the fitted gripper does not coil.
    """
    if not draws >= DRAWS_MIN:
        raise InvalidInputError("draws", draws, f"at least {DRAWS_MIN}")
    calibration.interval_factor(level)  # checks the level
    best = [wrap.pressure for wrap in _wraps(calibration, radii)]
    pressures_of = partial(_drawn, calibration, tuple(radii))
    table = np.array(list(in_turn(pressures_of, _draws(calibration, seed, draws), executor)))
    found = []
    for radius, pressure, column in zip(radii, best, table.T, strict=True):
        answers = column[np.isfinite(column)]
        if not len(answers) >= DRAWS_MIN // 2:
            raise InvalidInputError(
                "calibration",
                Message("{} of {} draws that grip {}", len(answers), draws, Quantity(radius, "m")),
                "sure enough of its parameters that most draws grip the radius",
            )
        ends = np.quantile(answers, [0.5 - 0.5 * level, 0.5 + 0.5 * level])
        row = radius, pressure, np.std(answers, ddof=1), *ends, 1.0 - len(answers) / draws
        found.append(_of_constants(*map(float, row)))
    rivals = rival_fits(calibration) if rivals is None else rivals
    return tuple(_widened(one, rivals, level) for one in found)


def wrapped_from(calibration: Calibration, found: RadiusPressure) -> RadiusPressure:
    """Return the onset of the wrap by contact with its uncertainty, from the tip criterion's.

    All pressures are scaled alike: the ratio of the two hardly depends on the constants.

    Args:
        calibration: a fit whose model holds a gripper.
        found: of :func:`pressure_uncertainty` for this calibration.

    Raises:
        NotGrippableError: no pressure wraps the object.
        SolverError: a state could not be certified.
    """
    gripper = _curve(calibration, calibration.values).gripper
    window = grip_window(lay_into_coil(gripper, found.radius), until_wrapped=True)
    if window.onset_wrap is None:
        raise not_held(window)
    ratio = window.onset_wrap / found.pressure

    def scaled(interval: Interval) -> Interval:
        return Interval(ratio * interval.low, ratio * interval.high)

    return replace(
        found,
        pressure=window.onset_wrap,
        standard_error=ratio * found.standard_error,
        interval=scaled(found.interval),
        own_interval=scaled(found.own_interval),
        rivals=tuple(
            replace(one, pressure=ratio * one.pressure, interval=scaled(one.interval))
            for one in found.rivals
        ),
    )


def _curve(calibration: Calibration, values: Array) -> WrapCurve:
    """Return the range of grips for some parameters."""
    gripper = calibration.model.trial(values).gripper
    if gripper is None:
        raise InvalidInputError(
            "calibration", "a fit without a gripper", "one whose model holds the mounted gripper"
        )
    return WrapCurve(gripper)


def _wraps(calibration: Calibration, radii: Sequence[float]) -> list[Wrap]:
    """Return the wrap of each radius with the fitted values."""
    curve = _curve(calibration, calibration.values)
    return [curve.wrap_for_radius(float(radius)) for radius in radii]


def _radii(calibration: Calibration, wraps: Sequence[Wrap], values: Array) -> Array:
    """Return the radii [m] that some parameters wrap; the last is a factor on the pressures."""
    gripper = calibration.model.trial(values[:-1]).gripper
    if gripper is None:
        raise TypeError("a fit with wraps has a gripper")
    found = []
    for wrap in wraps:
        shape = gripper.unloaded_shape(float(values[-1]) * wrap.pressure)
        count = len(wrap.state.positions) - 1
        state = solve_rod(
            gripper.rod(shape), gripper.load(shape), start=wrap.state, elements=count,
            estimate_error=False,
        )  # fmt: skip
        found.append(wrapped_radius(gripper, shape, state)[0])
    return np.array(found)


def _principal_directions(calibration: Calibration) -> Array:
    """Return (p, p) rows whose outer products add up to the covariance.

    The covariance of correlated constants is nearly singular; along its principal directions every
    step is one standard error of something.
    """
    errors = calibration.standard_errors
    strengths, vectors = np.linalg.eigh(calibration.correlation)
    rows: Array = (vectors * np.sqrt(np.maximum(strengths, 0.0))).T * errors
    return rows


def _draws(calibration: Calibration, seed: int, draws: int) -> Array:
    """Return (draws, p) parameters from the fit's multivariate t distribution."""
    generator, freedom = np.random.default_rng(seed), calibration.degrees_of_freedom
    directions = _principal_directions(calibration)
    steps = generator.standard_normal((draws, len(directions))) @ directions
    if calibration.scatter is not Scatter.TOO_SMALL:  # else the stated errors stand
        steps *= np.sqrt(freedom / generator.chisquare(freedom, draws))[:, None]
    drawn: Array = calibration.values + steps
    return drawn


def _drawn(calibration: Calibration, radii: Sequence[float], values: Array) -> list[float]:
    """Return the pressures of one draw [Pa]; infinite where it cannot grip."""
    found = [math.inf] * len(radii)
    with suppress(SpiralError):
        curve = _curve(calibration, values)
        for k, radius in enumerate(radii):
            with suppress(SpiralError):
                found[k] = curve.pressure_from_radius(float(radius))
    return found
