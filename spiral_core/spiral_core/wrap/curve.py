# SPDX-License-Identifier: Apache-2.0
"""Pressure against radius of the perfect wrap, over the whole grippable range of a gripper."""

from __future__ import annotations

import math
from typing import NoReturn

from spiral_core.errors import NoCoilError, NotGrippableError
from spiral_core.message import Message, Quantity
from spiral_core.rod.state import RodState
from spiral_core.validation import require_in_range, require_positive
from spiral_core.wrap.branch import CoiledRange, SubBranch
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
        for branch in self._branches:
            smallest, largest = branch.radius_range
            inside = min(max(radius, smallest), largest)
            if abs(inside - radius) <= ROUNDING * radius:
                wrap = self._search(branch, inside)
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
        at, limit = (Quantity(p, "Pa") for p in (nearest.pressure, self.gripper.pressure_max))
        reason = Message(kind.value, at, limit, self.gripper.turns_required)
        edge = nearest.object_radius
        raise NotGrippableError(radius, Message("{} {}", word, reason), -abs(radius - edge), edge)

    def _search(self, branch: SubBranch, radius: float) -> Wrap | None:
        """Return the wrap of a radius on a sub-branch: a secant search inside a bracket.

        None if the radius jumps past it, as it does where the fitted axis does.
        """
        outer = self.gripper.tube.outer_radius
        target = 1.0 / (radius + outer)
        below, above, pressure, slope = branch.bracket_and_guess(target)
        last, previous = pressure, math.nan
        wrap, miss = None, math.inf
        for step in range(1, SEARCH_LIMIT):
            wrap = self._scan.wrap_at(pressure)
            miss = 1.0 / (wrap.object_radius + outer) - target
            if abs(miss) <= RADIUS_TOLERANCE * target:
                return wrap
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
