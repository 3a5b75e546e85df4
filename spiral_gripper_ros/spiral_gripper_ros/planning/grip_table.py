# SPDX-License-Identifier: Apache-2.0
"""Grips of some radii, solved in the background, and interpolation between them. No ROS."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper_ros.planning.grip_figures import GripFigures


@dataclass(frozen=True, slots=True)
class GripAnswer:
    """The grip on one object at one pressure.

    Args:
        at_pose: whether it was computed for the object where it is seen; else for one that is laid
            into the free coil.
        computed_at: when [s].
        friction: coefficient used.
        onset_wrap: lowest pressure of the perfect wrap [Pa].
        onset_curling: pressure at which the tip lifts off again [Pa]; inf: it does not.
        loss: pressure at which the grip is lost [Pa]; inf: it is not.
        contact_length: of tube on the object [m].
        normal_force: on the object, summed [N].
        away, towards, down: force that holds the object against moving along its axis away from
            the base, towards it, and along gravity [N].
        settling: how long the tube swings on after a ramp to this pressure [s]; NaN: not known.
        regime: how the object is held.
    """

    at_pose: bool
    computed_at: float
    friction: float
    onset_wrap: float
    onset_curling: float
    loss: float
    contact_length: float
    normal_force: float
    away: float
    towards: float
    down: float
    settling: float
    regime: WrapRegime


@dataclass(frozen=True, slots=True)
class GripEntry:
    """A grip with the time at which it was computed [s]."""

    figures: GripFigures
    computed_at: float

    def answer(self, pressure: float, *, at_pose: bool) -> GripAnswer:
        """Return the grip at a pressure [Pa]; above the loss nothing is held."""
        figures = self.figures
        values = _at(figures, pressure)
        return GripAnswer(
            at_pose=at_pose,
            computed_at=self.computed_at,
            friction=figures.friction,
            onset_wrap=figures.onset_wrap,
            onset_curling=_or_inf(figures.onset_curling),
            loss=_or_inf(figures.loss),
            regime=figures.regime(pressure),
            **values,
        )


def blended_answer(
    radii: Sequence[float], entries: Sequence[GripEntry], radius: float, tip: float, pressure: float
) -> GripAnswer:
    """Return the grip on a radius between two that are solved.

    Pressures are compared as multiples of the pressure of each radius's wrap by the tip criterion,
    which takes most of the difference out; what is left is linear in the radius. Where only one of
    the two loses the grip or curls, that one counts.

    Args:
        radii: the two [m], in order.
        entries: their grips.
        radius: between them [m].
        tip: its own pressure by the tip criterion [Pa].
        pressure: asked for [Pa].
    """
    weights, scales = _weights(radii, radius), _scales(entries, tip)
    onset, _, loss = blended_window(radii, entries, radius, tip)
    curls = (s * _or_inf(e.figures.onset_curling) for s, e in zip(scales, entries, strict=True))
    curling = _blended_end(weights, *curls)
    low, high = (_at(e.figures, pressure / s) for s, e in zip(scales, entries, strict=True))
    blended = {name: weights[0] * low[name] + weights[1] * high[name] for name in low}
    regime = WrapRegime.PERFECT_WRAP if pressure < curling else WrapRegime.CURLING
    if pressure < onset or pressure >= loss:
        regime = WrapRegime.OVERHANG
    if pressure >= loss:
        blended = _LOST
    return GripAnswer(
        at_pose=False,
        computed_at=min(entry.computed_at for entry in entries),
        friction=entries[0].figures.friction,
        onset_wrap=onset,
        onset_curling=curling,
        loss=loss,
        regime=regime,
        **blended,
    )


def blended_window(
    radii: Sequence[float], entries: Sequence[GripEntry], radius: float, tip: float
) -> tuple[float, float, float]:
    """Return where good grips begin and end, and where the grip is lost [Pa]; inf: nowhere.

    The arguments are those of :func:`blended_answer`.
    """
    weights, scales = _weights(radii, radius), _scales(entries, tip)
    low, high = (
        [scale * value for value in _ends(entry.figures)]
        for scale, entry in zip(scales, entries, strict=True)
    )
    onset = weights[0] * low[0] + weights[1] * high[0]
    return onset, _blended_end(weights, low[1], high[1]), _blended_end(weights, low[2], high[2])


def table_radii(smallest: float, largest: float, count: int) -> tuple[float, ...]:
    """Return radii [m] from end to end of a range, evenly spaced in their logarithm.

    Example:
        >>> [round(radius, 4) for radius in table_radii(0.01, 0.04, 3)]
        [0.01, 0.02, 0.04]
    """
    return tuple(float(radius) for radius in np.geomspace(smallest, largest, count))


def neighbors(radii: Sequence[float], radius: float) -> tuple[int, int] | None:
    """Return the places of the two radii around one [m], or None if it is outside of them.

    Example:
        >>> neighbors((0.01, 0.02, 0.04), 0.03), neighbors((0.01, 0.02), 0.03)
        ((1, 2), None)
    """
    if len(radii) < 2 or not radii[0] <= radius <= radii[-1]:
        return None
    upper = min(max(bisect_right(radii, radius), 1), len(radii) - 1)
    return upper - 1, upper


# What changes with the pressure, where the grip is lost.
_LOST = {
    **dict.fromkeys(("contact_length", "normal_force", "away", "towards", "down"), 0.0),
    "settling": math.nan,
}


def _at(figures: GripFigures, pressure: float) -> dict[str, float]:
    """Return what changes with the pressure [Pa]."""
    if figures.loss is not None and pressure >= figures.loss:
        return _LOST
    path = (figures.contact_lengths, figures.normal_forces)
    held = (figures.away, figures.towards, figures.down)
    values = [float(np.interp(pressure, figures.pressures, each)) for each in path]
    # Below the first of its pressures nothing holds that could be relied on.
    values += [float(np.interp(pressure, figures.force_pressures, each, left=0.0)) for each in held]
    values.append(float(np.interp(pressure, figures.force_pressures, figures.settling)))
    return dict(zip(_LOST, values, strict=True))


def _weights(radii: Sequence[float], radius: float) -> tuple[float, float]:
    part = (radius - radii[0]) / (radii[1] - radii[0])
    return 1.0 - part, part


def _scales(entries: Sequence[GripEntry], tip: float) -> list[float]:
    return [tip / entry.figures.tip_pressure for entry in entries]


def _ends(figures: GripFigures) -> tuple[float, float, float]:
    return figures.onset_wrap, figures.highest_good, _or_inf(figures.loss)


def _or_inf(pressure: float | None) -> float:
    return math.inf if pressure is None else pressure


def _blended_end(weights: tuple[float, float], low: float, high: float) -> float:
    if math.isinf(low) or math.isinf(high):
        return min(low, high)
    return weights[0] * low + weights[1] * high
