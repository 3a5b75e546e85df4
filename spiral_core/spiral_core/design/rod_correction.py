# SPDX-License-Identifier: Apache-2.0
"""Step 6 of the design procedure: the rod under gravity, and the corrected length.

Gravity changes the radius that a pressure fits and the length that a turn takes. The helix
model's length is a first guess. Here the gripper is solved as a rod, and its length is corrected
until it makes exactly the required turns about the largest object.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.design.helix_estimate import GripFigures, helix_radius, helix_stretch, turn_spacing
from spiral_core.design.requirement import Candidate, DesignRequirement
from spiral_core.errors import NoCoilError, NotGrippableError, SolverError
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import (
    DEFAULT_FRICTION,
    DEFAULT_TURNS,
    STANDARD_GRAVITY,
    Gripper,
    gripper_from_actuator,
)
from spiral_core.wrap.wrap import Wrap

# The search for the length ends where the length is too long by at most this fraction: 1 mm of
# the paper's design, and about 5 thousandths of a turn.
LENGTH_TOLERANCE = 3e-3
# A bracket of lengths this narrow is a length, whatever happens inside.
NARROWEST = 3e-4
# Weight over bending stiffness, w L^3 / EI, up to which a coil is tried at once; and up to which
# longer ones are tried: what hangs longer only sags more.
SAG_AT_START = 100.0
SAG_AT_MOST = 3000.0
# Pressures are solved up to where a helix's centerline has this fraction of the radius that the
# smallest object needs: room for what gravity changes, without coils nobody asked for.
CLOSEST_COIL = 0.6
# The secant from the helix model's length takes so many steps at most, each longer by this factor
# at most, as if the radius rose by at least this power of the length (1 is a helix).
STEPS = 6
GROWTH = 1.25
LEAST_SLOPE = 0.3
# A near miss: the log of the centerline's radius lacks no more than this.
NEAR_MISS = 0.05
# Lengths up to this multiple of the helix model's are tried.
LONGEST = 3.0
# Where the secant finds none, all powers of this factor are solved that may do: gravity makes the
# largest radius rise in waves, with level parts, dips and jumps as the length grows. These lengths
# do not depend on the largest object.
RUNG = 1.06
# A rod is shorter than the helix that holds the same by this factor at most: 1.14 in 72 random
# mounts, 1.33 about given axes. Shorter ones are not solved.
SHORTEST = 1.2
SHORTEST_ABOUT_AXIS = 1.4
# Lengths that hold less than this fraction of what another holds for certain are not solved.
CREST = 0.95
# Where no pressure limit is required, that of the design is this fraction above what the smallest
# object needs: past 25 % or so a coil unwinds from what it holds.
PRESSURE_RESERVE = 0.2
# A bracket halves down to the tolerance in 13 steps; the secant needs 2 or 3.
ITERATION_LIMIT = 40
# Of this many steps one halves the bracket, whatever the secant suggests.
HALVING = 4


@dataclass(frozen=True, slots=True)
class ExactFigures:
    """A candidate of corrected length, as a rod under gravity.

    Args:
        gripper: of the corrected length, mounted, with the largest pressure to command.
        largest: wrapped about the largest object.
        smallest: wrapped about the smallest object; None if it cannot.
        pressure_max: up to which it was solved: certainly enough for the smallest object [Pa].
        radius_min: smallest radius that it wraps there [m].
        radius_max: largest radius that it wraps [m].
    """

    gripper: Gripper
    largest: GripFigures
    smallest: GripFigures | None
    pressure_max: float
    radius_min: float
    radius_max: float

    @property
    def length(self) -> float:
        """Corrected unstretched length [m]."""
        return self.gripper.tube.length


def gripper_of(
    requirement: DesignRequirement,
    candidate: Candidate,
    length: float,
    pressure_max: float | None = None,
) -> Gripper:
    """Return a candidate as a gripper of a length [m], mounted as required.

    Args:
        requirement: the mount and the turns.
        candidate: tube, material, angles.
        length: unstretched length [m].
        pressure_max: largest gauge pressure [Pa]; None takes the actuator's own limit.
    """
    friction = requirement.friction_coefficient
    told = friction != DEFAULT_FRICTION
    return gripper_from_actuator(
        candidate.label[:],  # plain text: a name keeps no quantities
        candidate.actuator(requirement, length),
        density=candidate.elastomer.density,
        pressure_max=pressure_max,
        extra_mass_per_length=requirement.extra_mass_per_length,
        gravity=requirement.gravity,
        object_axis=requirement.object_axis,
        turns_required=requirement.turns_required,
        friction_coefficient=friction if requirement.payload or told else None,
    )


def grip_figures(wrap: Wrap) -> GripFigures:
    """Return the figures of a perfect wrap that makes at least the required turns."""
    object_length = wrap.object_length_needed or 0.0
    return GripFigures(
        radius=wrap.object_radius,
        pressure=wrap.pressure,
        stretch=wrap.unloaded_shape.stretch or 1.0,
        turns=wrap.turns,
        length_needed=wrap.gripper_length_needed or 0.0,
        object_length=object_length,
        turn_spacing=turn_spacing(object_length, wrap.turns_required, wrap.helix_angle),
    )


class LengthSearch:
    """The shortest length that holds every object, and the largest object that any length holds.

    The largest radius that a length holds rises with the length as a helix's does, until gravity
    opens the coil. A secant from the helix model's length is tried first; where it ends at a length
    that is too long for the requirement, or at none, lengths are gone through in steps of
    :data:`RUNG`: a crest narrower than that, or shorter than :data:`SHORTEST` allows, is missed.

    Args:
        requirement: objects, turns and mount.
        candidate: tube, material, angles.
        start: the helix model's length [m].
        held: lengths that were solved for another largest object, and what they hold.

    Attributes:
        outer: outer radius of the tube [m].
        wanted: contact radius of the largest object, to the tube's centerline [m].
        held: largest radius that each length solved holds [m]; 0 where none coils.
        reached: the largest object that any length within the limit holds [m], where none holds
            all of them.
    """

    def __init__(
        self,
        requirement: DesignRequirement,
        candidate: Candidate,
        start: float,
        held: Mapping[float, float] | None = None,
    ) -> None:
        self.requirement = requirement
        self.candidate = candidate
        self.start = start
        self.pressure_max = _sufficient_pressure(requirement, candidate)
        self.outer = candidate.tube.outer_radius
        self.wanted = requirement.radius_max + self.outer
        self.limit = requirement.length_max or math.inf
        self.longest = min(LONGEST * start, longest_length(requirement, candidate))
        # Longer ones, solved for a larger object, are not offered for this one.
        self.held = {x: radius for x, radius in (held or {}).items() if x <= self.longest}
        self.reached = 0.0
        self._curves: dict[float, WrapCurve] = {}

    def figures(self, near_miss: float = NEAR_MISS) -> ExactFigures | None:
        """Return the figures of the length that makes the required turns; None if no length does.

        The result is verified, not extrapolated: the gripper of this very length was solved over
        its whole range, and wraps the largest object with at least the required turns. Among the
        lengths around it, it is longer than needed by at most :data:`LENGTH_TOLERANCE`.

        Args:
            near_miss: log of the centerline's radius that a length may lack so that, where the
                secant finds none that will do, all lengths are gone through.

        Raises:
            NotGrippableError: even the largest object is thinner than the smallest radius solved.
            SolverError: a shape could not be certified.
        """
        self._approach()
        length = self._narrowed()
        if length is None:
            self.reached = max(self.held.values())
            if max(map(self._excess, self.held)) > -near_miss:
                self._scan(self.longest)
        elif length > self.limit and LEAST_SLOPE * math.log(length / self.limit) <= near_miss:
            self._scan(self.limit)
        length = self._narrowed()
        if length is None:
            return None
        curve, wanted = self.curve(length), self.requirement
        largest, smallest = grip_figures(curve.wrap_for_radius(wanted.radius_max)), None
        if wanted.radius_min >= curve.radius_min:
            smallest = grip_figures(curve.wrap_for_radius(wanted.radius_min))
        # The actuator's own limit may be far past what its tube bears.
        limit = wanted.pressure_max
        if limit is None:
            limit = self.pressure_max
            if smallest is not None:
                limit = (1.0 + PRESSURE_RESERVE) * smallest.pressure
        limit = min(limit, curve.gripper.actuation.pressure_limit)
        return ExactFigures(
            gripper=replace(curve.gripper, pressure_max=limit),
            largest=largest,
            smallest=smallest,
            pressure_max=self.pressure_max,
            radius_min=curve.radius_min,
            radius_max=self.held[length],
        )

    def curve(self, length: float) -> WrapCurve:
        """Return the wraps of a length [m] that coils."""
        if length not in self._curves:
            gripper = gripper_of(self.requirement, self.candidate, length, self.pressure_max)
            self._curves[length] = WrapCurve(gripper)
        return self._curves[length]

    def _approach(self) -> None:
        """Step towards the length as a helix would, until one holds the largest object."""
        if self._bracket() is not None:
            return
        length = min(self.start, length_at_sag(self.requirement, self.candidate, SAG_AT_START))
        length = min(max(length, self.shortest(self.requirement.radius_max)), self.longest)
        if any(self.held.values()):  # known for another largest object: from the best of them
            length = max(self.held, key=self.held.__getitem__)
        excess, slope = self._excess(length), 1.0
        for _ in range(STEPS):
            if excess >= 0.0:
                return
            rise = 0.5 * LENGTH_TOLERANCE - excess / max(slope, LEAST_SLOPE)
            rise = min(rise, math.log(GROWTH))
            length *= math.exp(rise)
            if length > self.longest:
                return
            before, excess = excess, self._excess(length)
            if excess < before - NEAR_MISS:  # beyond the crest
                return
            if math.isfinite(before):
                slope = (excess - before) / rise

    def _scan(self, longest: float) -> None:
        """Solve the lengths up to one [m], from the shortest, until one holds the largest object.

        If none does within the limit of the length, the most that one of them holds is kept.
        """
        shortest = self.shortest(self.requirement.radius_max)
        for length in self.lengths(longest):
            if length >= shortest and self._excess(length) >= 0.0:
                break
        self.reached = 0.0
        for length in reversed([x for x in self.lengths(longest) if x <= self.limit]):
            if length < self.shortest(CREST * self.reached):
                break
            self.reached = max(self.reached, self._solved(length))

    def lengths(self, longest: float, shortest: float | None = None) -> list[float]:
        """Return the lengths up to one that are gone through [m]: they depend on no object."""
        first, last = (math.log(x, RUNG) for x in (shortest or self.shortest(0.0), longest))
        rungs = {RUNG**k for k in range(math.ceil(first), math.floor(last) + 1)}
        return sorted(rungs | {min(self.limit, longest), longest})

    def shortest(self, radius: float) -> float:
        """Return a length [m] that is too short for an object of a radius [m]."""
        shorter = SHORTEST if self.requirement.object_axis is None else SHORTEST_ABOUT_AXIS
        return self.start * (radius + self.outer) / self.wanted / shorter

    def _bracket(self) -> tuple[float, float] | None:
        """Return the last length that is too short (0 if none is) and the first that is not [m]."""
        too_short = 0.0
        for length in sorted(self.held):
            if self._excess(length) >= 0.0:
                return too_short, length
            too_short = length
        return None

    def _narrowed(self) -> float | None:
        """Return the shortest length that will do of those solved, after narrowing it down [m]."""
        length: float | None = None
        for step in range(1, ITERATION_LIMIT):
            bracket = self._bracket()
            if bracket is None:
                return None
            too_short, length = bracket
            excess, slope = self._excess(length), 1.0
            if too_short and math.isfinite(self._excess(too_short)):
                slope = (excess - self._excess(too_short)) / math.log(length / too_short)
            narrow = length - too_short <= NARROWEST * length
            if narrow or excess <= LENGTH_TOLERANCE * slope:
                break
            shorter = length * math.exp(0.5 * LENGTH_TOLERANCE - excess / slope)
            if too_short and (step % HALVING == 0 or not too_short < shorter < length):
                shorter = 0.5 * (too_short + length)
            self._excess(shorter)
        return length

    def _excess(self, length: float) -> float:
        """Return log of the largest centerline radius over the one wanted; -inf: no coil."""
        radius = self._solved(length)
        return math.log((radius + self.outer) / self.wanted) if radius else -math.inf

    def _solved(self, length: float) -> float:
        """Return the radius up to which a length [m] holds all objects [m]; 0 if none coils."""
        if length not in self.held:
            try:
                curve = self.curve(length)
            except (NoCoilError, SolverError):  # what cannot be certified is not offered
                self.held[length] = 0.0
            else:
                # An object in a gap of the range would not be held: it counts up to the gap.
                gaps = [low for low, high in curve.gaps if high > self.requirement.radius_min]
                self.held[length] = radius = min([curve.radius_max, *gaps])
                if radius < self.requirement.radius_max:
                    del self._curves[length]
        return self.held[length]


def most_turns(requirement: DesignRequirement, candidate: Candidate, start: float) -> float:
    """Return about the most turns that a length makes about the largest object, by one scan.

    Args:
        requirement: objects, mount, and more turns than any length makes.
        candidate: tube, material, angles.
        start: the helix model's length [m].
    """
    few = replace(requirement, turns_required=DEFAULT_TURNS)
    share = DEFAULT_TURNS / requirement.turns_required
    search = LengthSearch(few, candidate, share * start)
    longest = min(LONGEST * start, longest_length(requirement, candidate))
    most, shortest = 0.0, search.shortest(requirement.radius_max)
    lengths = [x for x in search.lengths(longest, shortest) if x <= search.limit]
    for length in reversed(lengths):
        if length < max(CREST * most / DEFAULT_TURNS, 1.0) * shortest:
            break
        with suppress(NoCoilError, NotGrippableError, SolverError):
            most = max(most, search.curve(length).wrap_for_radius(requirement.radius_max).turns)
    return most


def longest_length(requirement: DesignRequirement, candidate: Candidate) -> float:
    """Return the longest length that is tried [m]: what is longer only sags more."""
    return length_at_sag(requirement, candidate, SAG_AT_MOST)


def length_at_sag(requirement: DesignRequirement, candidate: Candidate, sag: float) -> float:
    """Return the length whose w L^3 / EI is ``sag`` [m]; infinite without gravity."""
    gripper = gripper_of(requirement, candidate, length=1.0)
    weight = gripper.weight_per_length * math.hypot(*gripper.gravity) / STANDARD_GRAVITY
    if weight == 0.0:
        return math.inf
    length: float = (sag * gripper.stiffness.bending / weight) ** (1.0 / 3.0)
    return length


def _sufficient_pressure(requirement: DesignRequirement, candidate: Candidate) -> float:
    """Return a pressure that is certainly enough for the smallest object [Pa]."""
    actuation = FreeActuation(candidate.actuator(requirement, length=1.0))
    outer = candidate.tube.outer_radius
    closest = CLOSEST_COIL * (requirement.radius_min + outer) - outer
    if helix_radius(actuation, actuation.stretch_limit) >= closest:
        return actuation.pressure_limit
    return actuation.pressure_from_stretch(helix_stretch(actuation, closest))
