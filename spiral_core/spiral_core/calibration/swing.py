# SPDX-License-Identifier: Apache-2.0
r"""Damping from a free swing: the tip is let go, and its displacement is read against time.

The slowest vibration with the amplitude of :class:`~spiral_core.rod.motion.swing.Swing`,

.. math:: y(t) = c + A(t) \cos\left(\varphi + 2 \pi \int f + s A^2 \, dt\right)

is fitted to the readings by least squares: retardation time T and factor on the air in
:math:`\dot A`, beside amplitude, phase, frequency f, its change s with the amplitude, and offset c.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.calibration.fit import CalibrationStatus
from spiral_core.calibration.readings import require_size
from spiral_core.calibration.regression import (
    DEFAULT_LEVEL,
    Fit,
    Interval,
    covariance_and_scale,
)
from spiral_core.errors import InvalidInputError, SolverError
from spiral_core.message import Message, Quantity
from spiral_core.rod.motion.inertia import DEFAULT_RETARDATION_TIME, Damping
from spiral_core.rod.motion.swing import Swing
from spiral_core.rod.types import Array
from spiral_core.validation import require_finite, require_non_negative, require_positive

# A decay is seen over so many periods, and a period in so many readings.
LEAST_PERIODS, LEAST_READINGS = 3.0, 6.0
# All of a swing, of which seven numbers are fitted.
FEWEST_READINGS = 12
# The swing explains this part of the readings' variance at least; otherwise there is none.
LEAST_SWING = 0.5
# Readings that differ by less than this part of themselves are all the same.
ROUNDING = 1e-9
# The measured frequency is that of the described gripper to this factor; a wrong unit of time or a
# forgotten mount is not.
OTHER_SWING = 1.6
# Frequencies tried at first, over that of the description.
TRIED = np.linspace(0.3, 3.0, 541)
# Of the integration of amplitude and phase: far below the steps by which the fit differentiates.
ACCURACY = 1e-10


@dataclass(frozen=True, slots=True)
class SwingReading:
    """Displacement of the tip while it swings freely, along the line on which it swings.

    Args:
        time: [s].
        displacement: from anywhere on that line [m].
        error: standard error of the displacement [m], > 0.

    Raises:
        InvalidInputError: a value is out of its range.
    """

    time: float
    displacement: float
    error: float

    def __post_init__(self) -> None:
        require_finite("time", self.time)
        require_finite("displacement", self.displacement)
        require_positive("error", self.error)
        for name in ("time", "displacement", "error"):
            require_size(name, getattr(self, name))


@dataclass(frozen=True, slots=True, eq=False, repr=False, kw_only=True)
class SwingFit(Fit):
    """Damping that was fitted to a free swing: ``retardation_time`` [s], and ``air`` if not held.

    Values and intervals are those of any :class:`Fit`; no interval goes below zero.

    Attributes:
        damping: both, the held one too.
        frequency: of the swing at small amplitude [Hz].
        amplitude: in the beginning [m].
    """

    __repr__ = brief_repr

    damping: Damping
    frequency: float
    amplitude: float

    def interval(self, name: str, level: float = DEFAULT_LEVEL) -> Interval:
        """Return the confidence interval of one value, from Student's t, cut off at zero.

        Raises:
            InvalidInputError: there is no such value, or the level is not between 0 and 1.
        """
        low, high = Fit.interval(self, name, level)
        return Interval(max(0.0, low), high)


def fit_swing(
    swing: Swing, readings: Sequence[SwingReading], *, air: float | None = None
) -> SwingFit:
    """Return the damping that meets a free swing best, and how sure it is.

    Args:
        swing: the vibration that was read, from ``vibrations(gripper, pressure)``.
        readings: over three periods at least, in any order.
        air: factor on the air's drag that is held; None fits it too.

    Raises:
        InvalidInputError: too few readings, too short, or another frequency than the gripper's.
        SolverError: the fit did not converge.

    Source: docs/derivations/motion.md, section 3.
    """
    from scipy.integrate import odeint
    from scipy.optimize import least_squares

    if air is not None:
        require_non_negative("air", air)
    if len(readings) < FEWEST_READINGS:
        raise InvalidInputError("readings", len(readings), f"at least {FEWEST_READINGS}")
    ordered = sorted(readings, key=lambda one: one.time)
    times, measured, errors = np.array([(r.time, r.displacement, r.error) for r in ordered]).T
    times = times - times[0]
    frequency, cosine, sine, offset = _first_guess(swing, times, measured)
    size = math.hypot(cosine, sine)
    names = ("retardation_time", "air") if air is None else ("retardation_time",)
    units = np.array((DEFAULT_RETARDATION_TIME, 1.0))[: len(names)]
    damped = len(names)
    # The damping, then frequency, its change, amplitude, phase and offset, over their magnitudes.
    start = [1.0] * damped + [frequency / swing.frequency, 0.0, 1.0]
    start += [math.atan2(-sine, cosine), offset / size]
    low = np.full(len(start), -np.inf)
    low[:damped], low[damped + 2] = 0.0, 1e-6

    def damping_of(x: Array) -> Damping:
        return Damping(*(units * x[:damped]).tolist(), *(() if air is None else (air,)))

    def residuals(x: Array) -> Array:
        """Return fitted minus measured over the errors (m,)."""
        damping, (frequency, bend, amplitude, phase, offset) = damping_of(x), x[damped:]
        linear = float(swing.decay_rate(np.array(0.0), damping))
        slow, fast = damping.air * swing.air_creeping, damping.air * swing.air_inertial

        def rates(state: Array, _: float) -> tuple[float, float]:
            """Return the derivatives of log A and of the integral of (A / size)^2."""
            one = math.exp(state[0])
            return -(linear + slow * one ** (1.0 / 3.0) + fast * one), (one / size) ** 2

        begin = math.log(amplitude * size), 0.0
        log, squared = odeint(rates, begin, times, rtol=ACCURACY, atol=ACCURACY).T
        turned = swing.frequency * (frequency * times + bend * squared)
        fitted = size * offset + np.exp(log) * np.cos(phase + 2.0 * math.pi * turned)
        weighted: Array = (fitted - measured) / errors
        return weighted

    found = least_squares(
        residuals, start, bounds=(low, np.inf), x_scale="jac", jac="3-point", max_nfev=200
    )
    if found.status <= 0:
        raise SolverError(CalibrationStatus.ITERATION_LIMIT, float(found.optimality), found.nfev)
    covariance, error_scale = covariance_and_scale(found.fun, np.asarray(found.jac))
    return SwingFit(
        names=names,
        values=units * found.x[:damped],
        covariance=covariance[:damped, :damped] * np.outer(units, units),
        residuals=found.fun,
        degrees_of_freedom=len(times) - len(start),
        error_scale=error_scale,
        at_bound=tuple(name for name, x in zip(names, found.x, strict=False) if x < 1e-4),
        damping=damping_of(found.x),
        frequency=float(found.x[damped] * swing.frequency),
        amplitude=float(found.x[damped + 2] * size),
    )


def _first_guess(swing: Swing, times: Array, measured: Array) -> Array:
    """Return frequency [Hz], cosine, sine and offset [m] of the swing; refuse another's."""
    own, end = swing.frequency, float(times[-1])
    if not len(times) >= LEAST_READINGS * end * own:
        each = f"at least {LEAST_READINGS:g} in each swing of {own:.3g} Hz"
        requirement = f"{each} (check the unit of time)"
        per = len(times) / (end * own)
        raise InvalidInputError("readings", f"{per:.2g} in a swing", requirement)
    no_swing = InvalidInputError("displacement", "no such swing", "a swing of the tip that decays")
    if not np.ptp(measured) > ROUNDING * np.abs(measured).max():
        raise no_swing
    decay = np.exp(-times * 0.5 * swing.material * DEFAULT_RETARDATION_TIME)
    least, best = math.inf, np.zeros(4)
    for frequency in TRIED * own:
        angle = 2.0 * math.pi * frequency * times
        columns = np.stack((decay * np.cos(angle), decay * np.sin(angle), np.ones_like(decay)), 1)
        parts = np.linalg.lstsq(columns, measured, rcond=None)[0]
        left = float(np.sum((columns @ parts - measured) ** 2))
        if left < least:
            least, best = left, np.append(frequency, parts)
    frequency = float(best[0])
    if not own / OTHER_SWING < frequency < own * OTHER_SWING:
        raise InvalidInputError(
            "time",
            f"a swing of {frequency:.3g} Hz",
            f"readings of the described gripper's swing, {own:.3g} Hz: check the unit of "
            "time, the mount, the pressure and the weight",
        )
    if not end * frequency >= LEAST_PERIODS:
        shortest = Quantity(LEAST_PERIODS / frequency, "s")
        requirement = Message("at least {:g} swings, {}", LEAST_PERIODS, shortest)
        raise InvalidInputError("time", end, requirement, "s")
    if not least < (1.0 - LEAST_SWING) * float(np.sum((measured - measured.mean()) ** 2)):
        raise no_swing
    return best
