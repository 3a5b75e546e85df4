# SPDX-License-Identifier: Apache-2.0
"""Step 6 of the design procedure: the rod under gravity, and the corrected length.

Gravity changes the radius that a pressure fits and the length that a turn takes. The helix
model's length is a first guess. Here the gripper is solved as a rod, and its length is corrected
until it makes exactly the required turns about the largest object.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.design.helix_estimate import GripFigures, helix_radius, helix_stretch, turn_spacing
from spiral_core.design.requirement import Candidate, DesignRequirement
from spiral_core.errors import NoCoilError, SolverError
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import STANDARD_GRAVITY, Gripper, gripper_from_actuator
from spiral_core.wrap.wrap import Wrap

# Relative excess of the largest radius (of the centerline) that ends the search: 0.1 mm of the
# paper's design, and about 5 thousandths of a turn.
RADIUS_TOLERANCE = 3e-3
# A bracket of lengths this narrow is a length: 0.1 mm of the paper's design.
LENGTH_TOLERANCE = 3e-4
# Weight over bending stiffness, w L^3 / EI, up to which a hanging coil is tried at once; a longer
# first guess is shortened to it, because most of its length would only hang.
SAG_AT_START = 100.0
# ... and up to which longer ones are tried: what hangs longer only sags more.
SAG_AT_MOST = 3000.0
# Pressures are solved up to where a helix's centerline has this fraction of the radius that the
# smallest object needs: room for what gravity changes, without coils nobody asked for.
CLOSEST_COIL = 0.6
# Lengths grow by at most this factor at once, and by at least that ...
GROWTH = 1.25
LEAST_GROWTH = 1.002
# ... up to this multiple of the helix model's.
LONGEST = 3.0
# Bounds on the slope that a secant may use: 1 is a helix, less a coil that sags.
LEAST_SLOPE = 0.3
GREATEST_SLOPE = 3.0
# Of a coil that sags, the largest radius dips here and there as it grows with length. Where it
# misses by less than this (log of the centerline's radius), longer ones are tried in these steps.
NEAR_MISS = 0.05
SCAN_GROWTH = 1.03
SCAN_STEPS = 16
# Where no pressure limit is required, that of the design is this fraction above what the smallest
# object needs: past 25 % or so a coil unwinds from what it holds.
PRESSURE_RESERVE = 0.2
# A bracket of that width halves down to the tolerance in 13 steps; the secant needs 2 or 3.
ITERATION_LIMIT = 40


@dataclass(frozen=True, slots=True)
class ExactFigures:
    """A candidate of corrected length, as a rod under gravity.

    Args:
        length: corrected unstretched length [m].
        largest: wrapped about the largest object.
        smallest: wrapped about the smallest object; None if it cannot.
        pressure_max: up to which it was solved: certainly enough for the smallest object [Pa].
        actuator_limit: the actuator's own largest pressure [Pa].
        radius_min: smallest radius that it wraps there [m].
        radius_max: largest radius that it wraps [m].
        lengths_tried: every length solved on the way, in order [m].
    """

    length: float
    largest: GripFigures
    smallest: GripFigures | None
    pressure_max: float
    actuator_limit: float
    radius_min: float
    radius_max: float
    lengths_tried: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class OutOfReach:
    """Why no length wraps the largest object.

    Args:
        radius_reached: largest radius that any length tried does wrap [m]; 0 if none coils.
        lengths_tried: every length solved on the way, in order [m].
    """

    radius_reached: float
    lengths_tried: tuple[float, ...]


def pressure_limit(requirement: DesignRequirement, exact: ExactFigures) -> float:
    """Return the largest pressure to command [Pa].

    It is the one required; where none is, what the smallest object needs and
    :data:`PRESSURE_RESERVE`: the actuator's own limit may be far past what its tube bears.
    """
    if requirement.pressure_max is not None:
        return min(requirement.pressure_max, exact.actuator_limit)
    if exact.smallest is None:
        return exact.pressure_max
    return min((1.0 + PRESSURE_RESERVE) * exact.smallest.pressure, exact.actuator_limit)


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
    return gripper_from_actuator(
        candidate.label,
        candidate.actuator(requirement, length),
        density=candidate.elastomer.density,
        pressure_max=pressure_max,
        extra_mass_per_length=requirement.extra_mass_per_length,
        gravity=requirement.gravity,
        object_axis=requirement.object_axis,
        turns_required=requirement.turns_required,
        friction_coefficient=requirement.friction_coefficient if requirement.payload else None,
    )


def grip_figures(wrap: Wrap, turns: float) -> GripFigures:
    """Return the figures of a perfect wrap that makes at least ``turns`` turns."""
    object_length = wrap.object_length_needed or 0.0
    return GripFigures(
        radius=wrap.object_radius,
        pressure=wrap.pressure,
        stretch=wrap.unloaded_shape.stretch or 1.0,
        turns=wrap.turns,
        length_needed=wrap.gripper_length_needed or 0.0,
        object_length=object_length,
        turn_spacing=turn_spacing(object_length, turns, wrap.helix_angle),
    )


class _Trial(NamedTuple):
    """One length, solved: its whole curve, and the radius up to which it wraps the objects [m]."""

    length: float
    curve: WrapCurve | None
    radius_max: float


class _Search:
    """The shortest length that wraps the largest object, by a secant inside a bracket.

    At the largest radius the coil makes exactly the required turns. For a helix its
    centerline's radius is proportional to the length: the search runs on their logarithms.
    """

    def __init__(self, requirement: DesignRequirement, candidate: Candidate, start: float) -> None:
        self.requirement = requirement
        self.candidate = candidate
        self.pressure_max = _sufficient_pressure(requirement, candidate)
        self.longest = min(LONGEST * start, longest_length(requirement, candidate))
        self.too_short = 0.0
        self.best: _Trial | None = None
        self.trials = [
            self._solved(min(start, length_at_sag(requirement, candidate, SAG_AT_START)))
        ]

    def run(self) -> _Trial | None:
        """Return the solved length, or None if no longer one that was tried would do either."""
        self._iterate()
        if self.best is None and self._nearly_reached() and self._scan_longer():
            self._iterate()
        return self.best

    def _nearly_reached(self) -> bool:
        return max(self._excess(trial) for trial in self.trials) > -NEAR_MISS

    def _scan_longer(self) -> bool:
        """Step past a dip of the largest radius; return whether it rises far enough behind it."""
        for _ in range(SCAN_STEPS):
            length = SCAN_GROWTH * self.trials[-1].length
            if length > self.longest:
                return False
            self.trials.append(self._solved(length))
            if self.trials[-1].radius_max >= self.requirement.radius_max:
                return True
            self.too_short = length
        return False

    def _iterate(self) -> None:
        """Narrow the bracket down from the last trial."""
        for _ in range(ITERATION_LIMIT):
            trial = self.trials[-1]
            if trial.radius_max >= self.requirement.radius_max:
                self.best = trial
            else:
                self.too_short = trial.length
            if self._is_done():
                break
            self.trials.append(self._solved(self._proposal(trial)))

    def _is_done(self) -> bool:
        if self.best is None:
            return self.too_short >= self.longest or self._sags_only()
        narrow = self.best.length - self.too_short <= LENGTH_TOLERANCE * self.best.length
        return narrow or self._excess(self.best) <= RADIUS_TOLERANCE

    def _sags_only(self) -> bool:
        """Return whether more length goes into sagging instead of a wider coil."""
        if self.trials[-1].curve is None or self._slope(-2) > LEAST_SLOPE:
            return False
        within_a_step = self._excess(self.trials[-1]) > -LEAST_SLOPE * math.log(GROWTH)
        return not within_a_step or self._slope(-3) <= LEAST_SLOPE

    def _excess(self, trial: _Trial) -> float:
        """Return log of the largest centerline radius over the one wanted."""
        outer = self.candidate.tube.outer_radius
        return math.log((trial.radius_max + outer) / (self.requirement.radius_max + outer))

    def _proposal(self, trial: _Trial) -> float:
        """Return the next length, always inside the bracket [m]."""
        proposal = GROWTH * trial.length
        if trial.curve is not None:
            excess = self._excess(trial) - 0.5 * RADIUS_TOLERANCE
            proposal = min(trial.length * math.exp(-excess / self._slope()), proposal)
        if self.best is None:
            return min(max(proposal, LEAST_GROWTH * self.too_short), self.longest)
        if self.too_short < proposal < self.best.length:
            return proposal
        return 0.5 * (self.too_short + self.best.length)

    def _slope(self, first: int = -2) -> float:
        """Return d log(radius) / d log(length) between two neighboring trials; 1 for a helix.

        Args:
            first: index of the earlier one among those that coil; -2 for the last two.
        """
        solved = [trial for trial in self.trials if trial.curve is not None]
        if len(solved) < -first or solved[first].length == solved[first + 1].length:
            return 1.0
        rise = self._excess(solved[first + 1]) - self._excess(solved[first])
        slope = rise / math.log(solved[first + 1].length / solved[first].length)
        return min(max(slope, LEAST_SLOPE), GREATEST_SLOPE)

    def _solved(self, length: float) -> _Trial:
        try:
            curve = WrapCurve(
                gripper_of(self.requirement, self.candidate, length, self.pressure_max)
            )
        except (NoCoilError, SolverError):  # what cannot be certified is not offered
            return _Trial(length, None, 0.0)
        # An object in a gap of the range would not be held: the range counts up to the gap.
        wanted = self.requirement
        gaps = [
            low for low, high in curve.gaps if low < wanted.radius_max and high > wanted.radius_min
        ]
        return _Trial(length, curve, min([curve.radius_max, *gaps]))


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


def corrected_figures(
    requirement: DesignRequirement, candidate: Candidate, start: float
) -> ExactFigures | OutOfReach:
    """Return a candidate with the length at which it makes the required turns as a rod.

    The result is verified, not extrapolated: the gripper of this very length was solved over its
    whole range, and wraps the largest object with at least the required turns. Either its largest
    radius is at most :data:`RADIUS_TOLERANCE` more than that, or the length is within
    :data:`LENGTH_TOLERANCE` of one that does not.

    Args:
        requirement: objects, turns and mount.
        candidate: tube, material, angles.
        start: length to start from, the helix model's [m].

    Raises:
        NotGrippableError: even the largest object is thinner than the smallest radius solved.
        SolverError: a shape could not be certified.
    """
    search = _Search(requirement, candidate, start)
    trial = search.run()
    tried = tuple(t.length for t in search.trials)
    if trial is None or trial.curve is None:
        return OutOfReach(max(t.radius_max for t in search.trials), tried)
    turns = requirement.turns_required
    largest = grip_figures(trial.curve.wrap_for_radius(requirement.radius_max), turns)
    smallest = None
    if requirement.radius_min >= trial.curve.radius_min:
        smallest = grip_figures(trial.curve.wrap_for_radius(requirement.radius_min), turns)
    return ExactFigures(
        length=trial.length,
        largest=largest,
        smallest=smallest,
        pressure_max=search.pressure_max,
        actuator_limit=trial.curve.gripper.actuation.pressure_limit,
        radius_min=trial.curve.radius_min,
        radius_max=trial.radius_max,
        lengths_tried=tried,
    )
