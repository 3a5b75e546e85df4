# SPDX-License-Identifier: Apache-2.0
r"""How the pressure in the gripper follows a regulator's target: a lag, limited flow, a leak.

.. math:: \dot p = \mathrm{clip}\!\left(\frac{p_t - p}{T},\; -R_\mathrm{vent},\; R_\mathrm{fill}
    \right) - \frac{p}{T_\mathrm{leak}}

with the gauge pressure :math:`p`, the regulator's target :math:`p_t`, the time constant :math:`T`
of its loop, and the flow limits of its valves as rates of the pressure (a flow :math:`Q` at ambient
density into a volume :math:`V` is :math:`p_\mathrm{atm} Q / V`). The limits are constants, or
depend on the pressure as in ISO 6358 (:func:`flow_rows`). The last term is a leak, laminar:
proportional to the gauge pressure. The regulator has no integral action, so that it makes a leak up
only in part and settles at :math:`p = p_t / (1 + T / T_\mathrm{leak})`, or at
:math:`R_\mathrm{fill} T_\mathrm{leak}` if its fill valve is then wide open.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

from spiral_core.closing.pneumatics import Supply
from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_non_negative, require_positive

# Pressure [Pa], and how fast it rises and falls there with a valve wide open [Pa/s].
FlowRow: TypeAlias = tuple[float, float, float]
# Pressures of a table of flow.
FLOW_ROWS = 41


def flow_rows(
    supply: Supply, volume: Callable[[float], float], highest: float
) -> tuple[FlowRow, ...]:
    """Return the flow limits of valve and line up to a pressure [Pa], as rates of the pressure.

    Args:
        supply: through one orifice, by ISO 6358.
        volume: of the gripper [m^3] at a gauge pressure [Pa].
        highest: last pressure of the table [Pa], > 0.
    """
    step = require_positive("highest", highest) / (FLOW_ROWS - 1)
    rows = []
    for i in range(FLOW_ROWS):
        rise, fall = supply.rates(volume, i * step)
        rows.append((i * step, max(0.0, rise), max(0.0, fall)))  # rounding where the flow dies
    return tuple(rows)


@dataclass(frozen=True, slots=True)
class Valve:
    """The valves of a regulator and the loop that drives them.

    Args:
        time_constant: of the loop where no valve is wide open [s], > 0.
        fill_rate: rise of the pressure with the fill valve wide open [Pa/s], > 0.
        vent_rate: fall with the vent valve wide open [Pa/s], > 0.
        flow: rows that replace the two rates, linear between increasing pressures; empty: none.

    Raises:
        InvalidInputError: a value is not positive and finite, or the rows' pressures do not
            increase.

    Example:
        A lag far from its limits: 1 - 1/e of the way after one time constant.

        >>> valve = Valve(time_constant=0.1, fill_rate=1e6, vent_rate=1e6)
        >>> round(valve.pressure_after(0.1, pressure=0.0, target=1000.0), 6)
        632.120559
    """

    time_constant: float
    fill_rate: float
    vent_rate: float
    flow: tuple[FlowRow, ...] = ()

    def __post_init__(self) -> None:
        for field in ("time_constant", "fill_rate", "vent_rate"):
            require_positive(field, getattr(self, field))
        for row in self.flow:
            for value in row:
                require_non_negative("flow", value)
        if any(not b[0] > a[0] for a, b in pairwise(self.flow)):
            raise InvalidInputError("flow", self.flow, "rows of increasing pressure")

    def pressure_after(
        self, duration: float, pressure: float, target: float, leak_rate: float = 0.0
    ) -> float:
        """Return the pressure [Pa] after a time with one target: the exact solution.

        The law is linear in pieces, and the pressure goes one way only: it passes each piece at
        most once. Steps of any length therefore lead to the same pressures.

        Args:
            duration: time that passes [s], >= 0.
            pressure: at its beginning [Pa], >= 0.
            target: what the regulator aims for [Pa], >= 0.
            leak_rate: 1/T_leak [1/s], >= 0; 0: tight.

        Raises:
            InvalidInputError: a value is not finite or negative.
        """
        remaining = require_non_negative("duration", duration)
        now = require_non_negative("pressure", pressure)
        pieces = self._pieces(
            require_non_negative("target", target), require_non_negative("leak_rate", leak_rate)
        )
        rising = _slope(pieces, now) > 0.0
        for piece in pieces if rising else reversed(pieces):
            end = piece.high if rising else piece.low
            if now >= end if rising else now <= end:
                continue
            time = piece.time_between(now, end)
            if time >= remaining:
                return piece.pressure_after(remaining, now)
            now, remaining = end, remaining - time
        return now

    def _pieces(self, target: float, leak_rate: float) -> list[_Piece]:
        """Return the pieces of the law from low to high pressures."""
        rows = self.flow or ((0.0, self.fill_rate, self.vent_rate),)
        first, last = rows[0], rows[-1]
        cells = [(-math.inf, first[0], first, first), (last[0], math.inf, last, last)]
        cells[1:1] = [(one[0], two[0], one, two) for one, two in pairwise(rows)]
        return [piece for cell in cells for piece in self._cell(*cell, target, leak_rate)]

    def _cell(
        self, low: float, high: float, one: FlowRow, two: FlowRow, target: float, leak_rate: float
    ) -> list[_Piece]:
        """Return the pieces between two rows of the flow: where a valve is wide open, or none."""
        rate = 1.0 / self.time_constant
        width = two[0] - one[0]
        # dp/dt = gain - decay p, of the two limits and of the loop between them
        laws = []
        for sign, column in ((1.0, 1), (-1.0, 2)):
            slope = sign * (two[column] - one[column]) / width if width > 0.0 else 0.0
            laws.append((sign * one[column] - slope * one[0], -slope))
        loop = (target * rate, rate)
        ends = [(loop[0] - gain) / (loop[1] - decay) for gain, decay in laws if loop[1] != decay]
        cuts = [low, *sorted(end for end in ends if low < end < high), high]
        pieces = []
        for a, b in pairwise(cuts):
            middle = min(max(0.5 * (max(a, -1e9) + min(b, 1e9)), a), b)
            fill, vent, wanted = (gain - decay * middle for gain, decay in (*laws, loop))
            gain, decay = loop if vent < wanted < fill else laws[0 if wanted >= fill else 1]
            pieces.append(_Piece(a, b, gain, decay + leak_rate))
        return pieces


@dataclass(frozen=True, slots=True)
class _Piece:
    """Where the pressure follows dp/dt = gain - decay * p.

    Args:
        low, high: the pressures of the piece [Pa].
        gain: [Pa/s].
        decay: [1/s].
    """

    low: float
    high: float
    gain: float
    decay: float

    def slope(self, pressure: float) -> float:
        """Return dp/dt [Pa/s]."""
        return self.gain - self.decay * pressure

    def pressure_after(self, duration: float, pressure: float) -> float:
        """Return the pressure [Pa] after a time [s] within the piece."""
        if self.decay == 0.0:
            return pressure + self.gain * duration
        return pressure - self.slope(pressure) / self.decay * math.expm1(-self.decay * duration)

    def time_between(self, pressure: float, end: float) -> float:
        """Return the time [s] from a pressure to another [Pa]; inf if it is never reached."""
        first, last = self.slope(pressure), self.slope(end)
        if self.decay == 0.0 or math.isinf(end):
            return (end - pressure) / first if first else math.inf
        # The slope keeps its sign: it never passes zero.
        return math.log(first / last) / self.decay if first * last > 0.0 else math.inf


def _slope(pieces: list[_Piece], pressure: float) -> float:
    """Return dp/dt [Pa/s] at a pressure [Pa]."""
    return next(piece for piece in pieces if pressure <= piece.high).slope(pressure)
