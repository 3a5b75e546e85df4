# SPDX-License-Identifier: Apache-2.0
"""Pressure against radius of the perfect wrap, over the whole grippable range of a gripper."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike

from spiral_core.errors import NoCoilError, NotGrippableError
from spiral_core.message import Message, Quantity
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Array
from spiral_core.validation import require_finite, require_in_range, require_positive
from spiral_core.wrap.branch import BranchEnd, CoiledRange
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.scan import PressureScan
from spiral_core.wrap.wrap import PERFECT_BAND, Wrap, WrapRegime, wrapped_radius

# Relative error of 1/(r_w + r_o) at which the search for its pressure ends.
RADIUS_TOLERANCE = 1e-9
# A radius outside of the range by no more than this fraction is the one at its end: two solves of
# one shape differ by rounding.
ROUNDING = 1e-12
# A state is certified to 1e-8 of EI/L, and a soft one moves by more than that. Where rounding of
# this kind keeps the search from its end, an error up to this one is accepted: no more than the
# elements' own.
ROUGH_TOLERANCE = 1e-6
SEARCH_LIMIT = 60
# Turns may fall short of those required by the rounding of the end of the range.
TURNS_TOLERANCE = 1e-7
# Of this many steps one halves the bracket, whatever the secant suggests.
HALVING = 4
# A start that is taken as it is, without a Newton step, is solved again above this imbalance.
STALE_RESIDUAL = 1e-11
# Solved wraps that one interpolation goes through.
TABLE_NODES = 8
# A wrap nearer to an end of the sub-branch than this fraction of the usual distance is left out:
# the rounding of their difference would spoil the interpolation.
LEAST_GAP = 0.05


class WrapCurve:
    """Pressure against object radius for one gripper as it is mounted.

    The whole range is solved once; every question after that is a short warm start from the solved
    pressures next to it, so that answers do not depend on the order of the questions. Of several
    pressures that wrap a radius the lowest is the answer. A state is the one that a pressure rising
    from zero leads to.

    Args:
        gripper: the gripper.

    Raises:
        NoCoilError: it nowhere makes the required turns with room for an object.
        SolverError: a shape could not be certified.

    Attributes:
        gripper: the gripper.
        pressure_min, pressure_max: ends of the coiled range [Pa].
        radius_min, radius_max: smallest and largest radius that can be gripped [m]. About a given
            axis, or where the tube snaps, there may be gaps between them.
        snap_pressures: where the tube snaps into another shape as the pressure rises [Pa].
    """

    def __init__(self, gripper: Gripper) -> None:
        self.gripper = gripper
        self._scan = PressureScan(gripper)
        coiled = CoiledRange(self._scan)
        self._branches = coiled.branches
        if not self._branches:
            raise _no_coil(coiled, gripper)
        self._tables = [WrapTable(branch.by_falling_radius) for branch in self._branches]
        self.snap_pressures = tuple(self._scan.snaps)
        self.pressure_min = self._branches[0].wraps[0].pressure
        self.pressure_max = self._branches[-1].wraps[-1].pressure
        self.radius_min = min(branch.radius_range[0] for branch in self._branches)
        self.radius_max = max(branch.radius_range[1] for branch in self._branches)

    def __repr__(self) -> str:
        radii = f"{1e3 * self.radius_min:.4g} to {1e3 * self.radius_max:.4g} mm"
        pressures = f"{1e-3 * self.pressure_min:.4g} to {1e-3 * self.pressure_max:.4g} kPa"
        return f"WrapCurve({self.gripper.name!r}, radii {radii}, pressures {pressures})"

    @property
    def gaps(self) -> tuple[tuple[float, float], ...]:
        """Radii between ``radius_min`` and ``radius_max`` that no pressure wraps [m], rising."""
        found, reached = [], self.radius_min
        for smallest, largest in sorted(branch.radius_range for branch in self._branches):
            if smallest > reached:
                found.append((reached, smallest))
            reached = max(reached, largest)
        return tuple(found)

    def state_at_pressure(self, pressure: float) -> RodState:
        """Return the shape at any pressure [Pa] within the gripper's limit, coiled or not.

        Raises:
            InvalidInputError: the pressure is not in [0, the gripper's ``pressure_max``].
            SolverError: the shape could not be certified.
        """
        return self._scan.wrap_at(pressure).state

    def wrap_at_pressure(self, pressure: float) -> Wrap:
        """Return what the gripper wraps at a pressure [Pa].

        Its radius is infinite where the pressure does not bend the gripper, and not positive where
        the coil has closed on itself.

        Raises:
            InvalidInputError: the pressure is not positive or above the gripper's ``pressure_max``.
            SolverError: the shape could not be certified.
        """
        return self._scan.wrap_at(require_positive("pressure", pressure))

    def wrap_for_radius(self, radius: float) -> Wrap:
        """Return the perfect wrap of a cylinder of this radius [m], at the lowest pressure.

        Raises:
            InvalidInputError: the radius is not positive and finite.
            NotGrippableError: no pressure wraps it; carries why, and the nearest radius that can be
                gripped.
            SolverError: a shape could not be certified.
        """
        require_positive("radius", radius)
        for branch, table in zip(self._branches, self._tables, strict=True):
            smallest, largest = branch.radius_range
            inside = min(max(radius, smallest), largest)
            if abs(inside - radius) <= ROUNDING * radius:
                wrap = self._search(table, inside)
                if wrap is not None and (
                    wrap.pressure > branch.few_turns_up_to
                    or wrap.turns >= wrap.turns_required - TURNS_TOLERANCE
                ):
                    return wrap
        return self._refuse(radius)

    def pressure_from_radius(self, radius: float) -> float:
        """Return the pressure [Pa] that wraps a radius [m]; raises as :meth:`wrap_for_radius`."""
        return self.wrap_for_radius(radius).pressure

    def radius_from_pressure(self, pressure: float) -> float:
        """Return the radius [m] that a pressure [Pa] of the coiled range wraps perfectly.

        Raises:
            InvalidInputError: the pressure is not in [``pressure_min``, ``pressure_max``].
            NoCoilError: it is in a gap of the coiled range, with too few turns or no room.
            SolverError: the shape could not be certified.
        """
        require_in_range("pressure", pressure, self.pressure_min, self.pressure_max, "Pa")
        wrap = self.wrap_at_pressure(pressure)
        if not self.is_coiled(pressure):
            raise NoCoilError(wrap.turns, wrap.turns_required, pressure)
        return wrap.object_radius

    def pressures_from_radii(self, radii: ArrayLike) -> Array:
        """Return the pressures [Pa] that wrap radii [m], in an array of the same shape.

        Raises as :meth:`wrap_for_radius`, for the first radius that cannot be wrapped.
        """
        return self._each(self.pressure_from_radius, "radii", radii)

    def radii_from_pressures(self, pressures: ArrayLike) -> Array:
        """Return the radii [m] that pressures [Pa] wrap; raises as :meth:`radius_from_pressure`."""
        return self._each(self.radius_from_pressure, "pressures", pressures)

    @staticmethod
    def _each(answer: Callable[[float], float], field: str, values: ArrayLike) -> Array:
        """Return an answer for each value."""
        given = np.asarray(values, dtype=np.float64)
        found = [answer(require_finite(field, value)) for value in given.ravel().tolist()]
        return np.array(found, dtype=np.float64).reshape(given.shape)

    def is_coiled(self, pressure: float) -> bool:
        """Return whether a pressure [Pa] belongs to the coiled range."""
        return any(
            branch.wraps[0].pressure <= pressure <= branch.wraps[-1].pressure
            for branch in self._branches
        )

    def regime(self, pressure: float, radius: float, state: RodState | None = None) -> WrapRegime:
        """Return how a pressure [Pa] holds an object of a grippable radius [m].

        Args:
            pressure: gauge pressure [Pa].
            radius: of the object [m].
            state: :meth:`state_at_pressure`, where it is known already.

        Raises:
            InvalidInputError: the pressure is not in [0, the gripper's ``pressure_max``], or the
                radius not positive and finite.
            NotGrippableError: the radius is outside the grippable range.
            SolverError: the shape could not be certified.
        """
        require_in_range("pressure", pressure, 0.0, self.gripper.pressure_max, "Pa")
        if not self.radius_min <= require_positive("radius", radius) <= self.radius_max:
            self._refuse(radius)
        if pressure < self.pressure_min:
            return WrapRegime.OVERHANG
        if state is None:
            state = self.state_at_pressure(pressure)
        fits, _ = wrapped_radius(self.gripper, self.gripper.unloaded_shape(pressure), state)
        if abs(fits - radius) <= PERFECT_BAND * radius:
            return WrapRegime.PERFECT_WRAP
        # A coil that is wider than the object hangs over it, one that is tighter curls.
        return WrapRegime.OVERHANG if fits > radius else WrapRegime.CURLING

    def _refuse(self, radius: float) -> NoReturn:
        """Raise NotGrippableError: what ends the range at the nearest radius is the reason."""
        ends = [end for branch in self._branches for end in branch.ends]
        nearest, kind = min(ends, key=lambda end: abs(end[0].object_radius - radius))
        word = "between two parts of the grippable range"
        if not self.radius_min <= radius <= self.radius_max:
            word = "too thick" if radius > self.radius_max else "too thin"
        at = Quantity(nearest.pressure, "Pa")
        limit = Quantity(self.gripper.pressure_max, "Pa")
        reason = {
            BranchEnd.TURNS: f"for {self.gripper.turns_required:g} turns of this length",
            BranchEnd.PRESSURE_LIMIT: Message("for the pressure limit of {}", limit),
            BranchEnd.CLOSED: Message("for the tube: the coil closes on itself at {}", at),
            BranchEnd.SNAP: Message("for this shape: the tube snaps into another one near {}", at),
            BranchEnd.EXTREME: Message("for the coil: its radius turns back at {}", at),
        }
        edge = nearest.object_radius
        text = Message("{} {}", word, reason[kind])
        raise NotGrippableError(radius, text, -abs(radius - edge), edge)

    def _search(self, table: WrapTable, radius: float) -> Wrap | None:
        """Return the wrap of a radius on a table's sub-branch: a secant search inside a bracket.

        None if the radius jumps past it, as it does where the fitted axis does.
        """
        scan = self._scan
        target = table.contact_curvature(radius)
        below, above, pressure, slope = table.bracket_and_guess(target)
        q = scan.start_at(pressure)
        last, previous = pressure, math.nan
        wrap, miss = None, math.inf
        for step in range(1, SEARCH_LIMIT):
            wrap = scan.wrap_at(pressure, q)
            if wrap.state.iterations == 0 and wrap.state.residual > STALE_RESIDUAL:
                wrap = scan.wrap_at(pressure)
            miss = table.contact_curvature(wrap.object_radius) - target
            if abs(miss) <= RADIUS_TOLERANCE * target:
                return wrap
            q = wrap.state.orientations.copy()
            below, above = (pressure, above) if miss < 0.0 else (below, pressure)
            if step > 1 and miss != previous:
                slope = (miss - previous) / (pressure - last)
            last, previous = pressure, miss
            proposal = pressure - miss / slope
            inside = min(below, above) < proposal < max(below, above)
            pressure = proposal if inside and step % HALVING else 0.5 * (below + above)
            if pressure in (below, above):
                break
        return wrap if abs(miss) <= ROUGH_TOLERANCE * target else None


class WrapTable:
    r"""Pressures against the contact curvature 1/(r_w + r_o), in which they are almost linear.

    Between two wraps the pressure is the polynomial through the nearest ones, in Newton's form.

    Args:
        branch: wraps of a sub-branch by falling radius, its two ends included.
    """

    __slots__ = ("_curvatures", "_divided", "_outer_radius", "_pressures")

    def __init__(self, branch: Sequence[Wrap]) -> None:
        self._outer_radius = branch[0].outer_radius
        first, *inner, last = branch
        least = LEAST_GAP * abs(last.pressure - first.pressure) / (len(branch) - 1)
        kept = [
            first,
            *(w for w in inner if min(abs(w.pressure - e.pressure) for e in (first, last)) > least),
            last,
        ]
        curvatures = np.array([self.contact_curvature(wrap.object_radius) for wrap in kept])
        differences = np.array([wrap.pressure for wrap in kept])
        self._curvatures: list[float] = curvatures.tolist()
        self._pressures: list[float] = differences.tolist()
        self._divided: list[list[float]] = [self._pressures]
        for k in range(1, min(TABLE_NODES, len(kept))):
            differences = np.diff(differences) / (curvatures[k:] - curvatures[:-k])
            self._divided.append(differences.tolist())

    def contact_curvature(self, radius: float) -> float:
        """Return 1/(r_w + r_o) [1/m] for r_w [m]."""
        return 1.0 / (radius + self._outer_radius)

    def bracket_and_guess(self, target: float) -> tuple[float, float, float, float]:
        """Return what a search for a contact curvature [1/m] on the branch starts from.

        Returns:
            The pressures of the wraps next below and next above it in contact curvature [Pa], the
            pressure between them that is guessed [Pa], and the slope of the contact curvature
            there [1/(m Pa)].
        """
        curvatures, pressures = self._curvatures, self._pressures
        above = min(max(bisect_left(curvatures, target), 1), len(curvatures) - 1)
        low, high = pressures[above - 1], pressures[above]
        order = len(self._divided)
        first = min(max(above - order // 2, 0), len(curvatures) - order)
        guess, change = self._divided[-1][first], 0.0
        for k in range(order - 2, -1, -1):
            away = target - curvatures[first + k]
            change = change * away + guess
            guess = guess * away + self._divided[k][first]
        if (low <= guess <= high or high <= guess <= low) and change * (high - low) > 0.0:
            return low, high, guess, 1.0 / change
        change = (high - low) / (curvatures[above] - curvatures[above - 1])
        return low, high, low + change * (target - curvatures[above - 1]), 1.0 / change


def _no_coil(coiled: CoiledRange, gripper: Gripper) -> NoCoilError:
    """Return why a gripper has no coiled range: too few turns while there is room inside."""
    closed = [s.pressure for s in coiled.samples if not coiled.has_room(s)]
    if len(closed) == len(coiled.samples):
        return NoCoilError(0.0, gripper.turns_required, gripper.pressure_max, closes_at=min(closed))
    most = coiled.most_turns()
    return NoCoilError(
        most.turns,
        gripper.turns_required,
        most.pressure,
        closes_at=min(closed, default=None),
        at_actuator_limit=gripper.pressure_max >= gripper.actuation.pressure_limit,
    )
