# SPDX-License-Identifier: Apache-2.0
"""Tapered and irregular objects: whether a gripper can wrap a radius that varies along an axis.

A gripper covers a length of the object, and its coil takes one pressure. The coil is laid where
the object is most even, and the pressure is the one that wraps the thinnest place it covers: there
it is a perfect wrap, and thicker places are past theirs, in the regime the paper calls curling
("not harmful, not optimal"). A lower pressure would leave the thin places unheld.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from itertools import chain, pairwise

import numpy as np
from numpy.typing import ArrayLike

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError, NotGrippableError
from spiral_core.message import Message, Quantity
from spiral_core.rod.types import Array
from spiral_core.rounding import rounded_down, rounded_up
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.wrap import WrapRegime

# Places along the object at which the coil is tried.
STARTS = 101
# Places within the coil at which radius and regime are reported.
STATIONS = 21


@dataclass(frozen=True, slots=True, eq=False)
class ObjectProfile:
    """Radii of an object along its axis, straight lines between the samples.

    Args:
        positions: (n,) along the axis [m], increasing, n >= 2.
        radii: (n,) [m], > 0.

    Raises:
        InvalidInputError: the arrays do not match, or a value is out of its range.

    Example:
        >>> cone = ObjectProfile(positions=[0.0, 0.2], radii=[0.030, 0.010])
        >>> round(cone.radius_at(0.05), 6)
        0.025
    """

    __repr__ = brief_repr

    positions: ArrayLike
    radii: ArrayLike

    def __post_init__(self) -> None:
        positions, radii = (_samples(name, getattr(self, name)) for name in ("positions", "radii"))
        if positions.size < 2 or positions.shape != radii.shape:
            raise InvalidInputError("radii", self.radii, "as many as positions, at least two")
        if not bool(np.all(np.diff(positions) > 0.0)):
            raise InvalidInputError("positions", self.positions, "increasing")
        if not bool(np.all(radii > 0.0)):
            raise InvalidInputError("radii", self.radii, "positive")
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "radii", radii)

    @property
    def samples(self) -> tuple[Array, Array]:
        """Positions and radii (n,) [m]."""
        return np.asarray(self.positions), np.asarray(self.radii)

    @property
    def start(self) -> float:
        """First position [m]."""
        return float(self.samples[0][0])

    @property
    def end(self) -> float:
        """Last position [m]."""
        return float(self.samples[0][-1])

    def radius_at(self, position: float) -> float:
        """Return the radius at a position [m]; the end's beyond the ends."""
        return float(np.interp(position, *self.samples))

    def extremes(self, start: float, end: float) -> tuple[float, float]:
        """Return the smallest and the largest radius between two positions [m]."""
        positions, radii = self.samples
        inside = radii[(positions > start) & (positions < end)]
        ends = (self.radius_at(start), self.radius_at(end))
        return float(min(*ends, *inside)), float(max(*ends, *inside))


@dataclass(frozen=True, slots=True)
class Station:
    """One place of an object in the coil.

    Args:
        position: along the object's axis [m].
        radius: there [m].
        pressure: of the perfect wrap of a cylinder of this radius [Pa].
        regime: how the gripper holds it at the pressure of the whole wrap.
    """

    position: float
    radius: float
    pressure: float
    regime: WrapRegime


@dataclass(frozen=True, slots=True)
class ProfileWrap:
    """A gripper wrapped about an object of varying radius.

    Args:
        start: where the coil begins on the object's axis [m].
        end: where it ends [m].
        radius_min: thinnest place that it covers [m].
        radius_max: thickest place that it covers [m].
        pressure: recommended: the perfect wrap of the thinnest place [Pa].
        pressure_of_thickest: perfect wrap of the thickest place [Pa].
        pressure_of_mean: perfect wrap of the mean of the two radii [Pa].
        stations: places along the coil with their regimes at ``pressure``.
    """

    __repr__ = brief_repr

    start: float
    end: float
    radius_min: float
    radius_max: float
    pressure: float
    pressure_of_thickest: float
    pressure_of_mean: float
    stations: tuple[Station, ...]


def wrap_for_profile(curve: WrapCurve, profile: ObjectProfile) -> ProfileWrap:
    """Return how a gripper wraps an object of varying radius, where it is most even.

    The coil is taken to cover the object length that the required turns take about the thickest
    place it covers; regimes are those of a cylinder of each place's radius. Both are estimates:
    the contact of coil and object is not solved.

    Args:
        curve: of the gripper.
        profile: the object.

    Raises:
        NotGrippableError: nowhere along the object all radii under the coil can be gripped, or the
            object is too short; names the place that comes nearest.
        SolverError: a shape could not be certified.
    """
    evenly = np.linspace(profile.start, profile.end, STARTS).tolist()
    parts = _grippable_parts(curve, profile)
    windows = [_window(curve, profile, start) for start in (*evenly, *(part[0] for part in parts))]
    fitting = [window for window in windows if window is not None]
    if not fitting:
        raise _refusal(curve, profile, max(parts, key=lambda part: part[1] - part[0]))
    start, end = min(fitting, key=lambda window: np.ptp(profile.extremes(*window)))
    thin, thick = profile.extremes(start, end)
    pressure = curve.pressure_from_radius(thin)
    stations = []
    for position in np.linspace(start, end, STATIONS).tolist():
        radius = profile.radius_at(position)
        own, regime = curve.pressure_from_radius(radius), curve.regime(pressure, radius)
        stations.append(Station(position, radius, own, regime))
    return ProfileWrap(
        start=start,
        end=end,
        radius_min=thin,
        radius_max=thick,
        pressure=pressure,
        pressure_of_thickest=curve.pressure_from_radius(thick),
        pressure_of_mean=curve.pressure_from_radius(0.5 * (thin + thick)),
        stations=tuple(stations),
    )


def _window(curve: WrapCurve, profile: ObjectProfile, start: float) -> tuple[float, float] | None:
    """Return the part of the object that a coil from ``start`` covers; None if it does not fit.

    The coil's length depends on the thickest place under it, which depends on its length: it is
    lengthened until it covers what its thickest place needs.
    """
    end = start
    for _ in range(STARTS):
        thin, thick = profile.extremes(start, end)
        if not _grippable(curve, thin, thick):
            return None
        needed = start + (curve.wrap_for_radius(thick).object_length_needed or 0.0)
        if needed > profile.end:
            return None
        if needed <= end:
            return start, end
        end = needed
    return None


def _grippable(curve: WrapCurve, thin: float, thick: float) -> bool:
    """Return whether all radii from the thinnest to the thickest [m] can be gripped."""
    within = curve.radius_min <= thin and thick <= curve.radius_max
    return within and not any(thin < high and low < thick for low, high in curve.gaps)


def _refusal(
    curve: WrapCurve, profile: ObjectProfile, longest: tuple[float, float]
) -> NotGrippableError:
    """Return why no place does: too thin, too thick, or the longest part in range too short."""
    low, high = curve.radius_min, curve.radius_max
    thin, thick = profile.extremes(profile.start, profile.end)
    if thick < low:
        return NotGrippableError(thick, "too thin everywhere", thick - low, low)
    if thin > high:
        return NotGrippableError(thin, "too thick everywhere", high - thin, high)
    _, thickest = profile.extremes(*longest)
    needed = curve.wrap_for_radius(min(thickest, high)).object_length_needed or 0.0
    length = longest[1] - longest[0]
    reason = Message(
        "its longest part of {} to {} in radius is {} long, and the coil covers {}",
        Quantity(low, "m", rounded_up),
        Quantity(high, "m", rounded_down),
        Quantity(length, "m"),
        Quantity(needed, "m"),
    )
    return NotGrippableError(thickest, reason, length - needed, None)


def _grippable_parts(curve: WrapCurve, profile: ObjectProfile) -> list[tuple[float, float]]:
    """Return where the radii of an object are within the grippable range: start and end [m]."""
    positions, radii = profile.samples
    places = set(positions.tolist())
    rises = np.where(np.diff(radii) == 0.0, np.inf, np.diff(radii))
    # Where the straight lines between the samples cross a bound of the range or of a gap.
    for bound in (curve.radius_min, curve.radius_max, *chain(*curve.gaps)):
        shares = (bound - radii[:-1]) / rises
        crossed = (shares > 0.0) & (shares < 1.0)
        places.update((positions[:-1] + shares * np.diff(positions))[crossed].tolist())
    parts: list[tuple[float, float]] = []
    for start, end in pairwise(sorted(places)):
        radius = profile.radius_at(0.5 * (start + end))
        if _grippable(curve, radius, radius):
            begin = parts.pop()[0] if parts and parts[-1][1] == start else start
            parts.append((begin, end))
    return parts or [(profile.start, profile.start)]


def _samples(field: str, values: ArrayLike) -> Array:
    array: Array = np.zeros(())
    with suppress(TypeError, ValueError):
        array = np.array(values, dtype=np.float64)
    if array.ndim != 1 or not bool(np.isfinite(array).all()):
        raise InvalidInputError(field, values, "a list of finite numbers")
    array.setflags(write=False)
    return array
