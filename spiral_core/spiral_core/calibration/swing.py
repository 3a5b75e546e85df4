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
# The measured frequency is that of the described gripper to this factor; a wrong unit of time or a
# forgotten mount is not.
OTHER_SWING = 1.6
# Frequencies tried at first, over that of the description.
TRIED = np.linspace(0.3, 3.0, 541)
# Steps of the amplitude's integration (Runge-Kutta, fourth order).
STEPS = 200


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
    from scipy.optimize import least_squares

    if air is not None:
        require_non_negative("air", air)
    ordered = sorted(readings, key=lambda one: one.time)
    data = _Data(swing, ordered, air)
    frequency, cosine, sine, offset = data.first_guess()
    size = math.hypot(cosine, sine)
    start = [1.0, *([1.0] if air is None else []), frequency / swing.frequency, 0.0]
    start += [1.0, math.atan2(-sine, cosine), offset / size]
    damped = 1 if air is not None else 2
    low = np.full(len(start), -np.inf)
    low[:damped], low[damped + 2] = 0.0, 1e-6

    def residuals(x: Array) -> Array:
        return data.residuals(x, size)

    found = least_squares(
        residuals, start, bounds=(low, np.inf), x_scale="jac", jac="3-point", max_nfev=200
    )
    if found.status <= 0:
        raise SolverError(CalibrationStatus.ITERATION_LIMIT, float(found.optimality), found.nfev)
    covariance, error_scale = covariance_and_scale(found.fun, np.asarray(found.jac))
    names = ("retardation_time", "air")[:damped]
    units = np.array((DEFAULT_RETARDATION_TIME, 1.0))[:damped]
    values = units * found.x[:damped]
    return SwingFit(
        names=names,
        values=values,
        covariance=covariance[:damped, :damped] * np.outer(units, units),
        residuals=found.fun,
        degrees_of_freedom=len(ordered) - len(start),
        error_scale=error_scale,
        at_bound=tuple(n for n, v in zip(names, found.x, strict=False) if v < 1e-4),
        damping=Damping(float(values[0]), float(values[1]) if air is None else air),
        frequency=float(found.x[damped] * swing.frequency),
        amplitude=float(found.x[damped + 2] * size),
    )


class _Data:
    """Readings as arrays, and what the model says of them."""

    def __init__(self, swing: Swing, readings: list[SwingReading], air: float | None) -> None:
        self.swing, self.air = swing, air
        if len(readings) < FEWEST_READINGS:
            raise InvalidInputError("readings", len(readings), f"at least {FEWEST_READINGS}")
        self.times = np.array([one.time for one in readings])
        self.measured = np.array([one.displacement for one in readings])
        self.errors = np.array([one.error for one in readings])
        self.times = self.times - self.times[0]

    def first_guess(self) -> tuple[float, float, float, float]:
        """Return frequency [Hz], cosine, sine and offset [m] of the swing; refuse another's."""
        own, ends = self.swing.frequency, float(self.times[-1])
        if not len(self.times) >= LEAST_READINGS * ends * own:
            per = len(self.times) / (ends * own)
            each = f"at least {LEAST_READINGS:g} in each swing of {own:.3g} Hz"
            requirement = f"{each} (check the unit of time)"
            raise InvalidInputError("readings", f"{per:.2g} in a swing", requirement)
        best = (math.inf, 0.0, np.zeros(3))
        assumed = Damping()
        for frequency in TRIED * own:
            decay = np.exp(-self.times * 0.5 * self.swing.material * assumed.retardation_time)
            angle = 2.0 * math.pi * frequency * self.times
            columns = np.column_stack(
                (decay * np.cos(angle), decay * np.sin(angle), np.ones_like(decay))
            )
            parts, left, *_ = np.linalg.lstsq(columns, self.measured, rcond=None)
            if left.size and left[0] < best[0]:
                best = (float(left[0]), float(frequency), parts)
        frequency, parts = best[1], best[2]
        if not own / OTHER_SWING < frequency < own * OTHER_SWING:
            raise InvalidInputError(
                "time",
                f"a swing of {frequency:.3g} Hz",
                f"readings of the described gripper's swing, {own:.3g} Hz: check the unit of "
                "time, the mount, the pressure and the weight",
            )
        if not ends * frequency >= LEAST_PERIODS:
            least = Quantity(LEAST_PERIODS / frequency, "s")
            requirement = Message("at least {:g} swings, {}", LEAST_PERIODS, least)
            raise InvalidInputError("time", ends, requirement, "s")
        variance = float(np.sum((self.measured - self.measured.mean()) ** 2))
        if not best[0] < (1.0 - LEAST_SWING) * variance:
            requirement = "a swing of the tip that decays"
            raise InvalidInputError("displacement", "no such swing", requirement)
        return frequency, float(parts[0]), float(parts[1]), float(parts[2])

    def residuals(self, x: Array, size: float) -> Array:
        """Return fitted minus measured over the errors (m,)."""
        values = x.tolist()
        air = values.pop(1) if self.air is None else self.air
        damping = Damping(max(values[0], 0.0) * DEFAULT_RETARDATION_TIME, max(air, 0.0))
        frequency, bend, amplitude, phase, offset = values[1:]
        times, amplitudes = self._decay(abs(amplitude) * size, damping)
        squares = (amplitudes / size) ** 2
        stretch = np.cumsum(0.5 * (squares[1:] + squares[:-1])) * (times[1] - times[0])
        squared = np.interp(self.times, times, np.append(0.0, stretch))
        turned = frequency * self.times + bend * squared
        angle = phase + 2.0 * math.pi * self.swing.frequency * turned
        # the logarithm of the amplitude bends little between 200 steps
        decay = np.exp(np.interp(self.times, times, np.log(amplitudes)))
        fitted: Array = size * offset + decay * np.cos(angle)
        weighted: Array = (fitted - self.measured) / self.errors
        return weighted

    def _decay(self, start: float, damping: Damping) -> tuple[Array, Array]:
        """Return times [s] and amplitudes [m] of even steps, by Runge and Kutta's method."""
        times = np.linspace(0.0, float(self.times[-1]), STEPS + 1)
        step, amplitudes = times[1] - times[0], np.empty(STEPS + 1)
        amplitudes[0] = amplitude = max(start, 1e-300)
        linear = float(self.swing.decay_rate(np.array(0.0), damping))
        slow = damping.air * self.swing.air_creeping
        fast = damping.air * self.swing.air_inertial

        def rate(log: float) -> float:
            size = math.exp(log)
            return -(linear + slow * math.cbrt(size) + fast * size)

        log = math.log(amplitude)
        for i in range(STEPS):
            first = rate(log)
            second = rate(log + 0.5 * step * first)
            third = rate(log + 0.5 * step * second)
            log += step / 6.0 * (first + 2.0 * (second + third) + rate(log + step * third))
            amplitudes[i + 1] = math.exp(log)
        return times, amplitudes
