# SPDX-License-Identifier: Apache-2.0
"""One candidate against a requirement: by the helix model, then as a rod, with every margin."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.brief import brief_repr
from spiral_core.design.helix_estimate import (
    GripFigures,
    helix_grip,
    helix_radius,
    widest_helix,
)
from spiral_core.design.margin import Constraint, Margin, tightest
from spiral_core.design.requirement import Candidate, DesignRequirement, Preference
from spiral_core.design.rod_correction import (
    NEAR_MISS,
    PRESSURE_RESERVE,
    ExactFigures,
    LengthSearch,
    longest_length,
)
from spiral_core.errors import NotGrippableError

# A gripper so long that it would only hang makes about as many turns as its helix. Where that is
# less than this fraction of those required, no rod is solved.
HOPELESS_TURNS = 0.5
# Where no pressure limit is required, pressures up to this many times the design's own limit are
# looked at for the payload; it is raised if that carries notably more.
MOST_FOR_PAYLOAD, NOTABLY = 2.0, 1.01


class _Judged:
    """A candidate with the room on every constraint."""

    __slots__ = ()
    margins: tuple[Margin, ...]

    @property
    def feasible(self) -> bool:
        """Whether every constraint is met."""
        return all(margin.is_met for margin in self.margins)

    @property
    def violated(self) -> dict[Constraint, float]:
        """The constraints that are not met, and their figures."""
        return {m.constraint: m.value for m in self.margins if not m.is_met}

    @property
    def binding(self) -> Margin:
        """The constraint that leaves least room, or that forbids."""
        return tightest(self.margins)


@dataclass(frozen=True, slots=True)
class Estimate(_Judged):
    """A candidate by the helix model.

    Args:
        candidate: tube, material, angles.
        largest: wrapped about the largest object; None if the actuator's limit comes first.
        smallest: wrapped about the smallest object; None likewise.
        margins: room on every constraint.
    """

    candidate: Candidate
    largest: GripFigures | None
    smallest: GripFigures | None
    margins: tuple[Margin, ...]

    @property
    def length(self) -> float:
        """Length that makes the required turns about the largest object [m]; 0 if unknown."""
        return self.largest.length_needed if self.largest is not None else 0.0


@dataclass(frozen=True, slots=True)
class ClosedObject:
    """An object on which a design's gripper was closed.

    Args:
        radius: of the object [m].
        onset: least pressure at which it is wrapped [Pa]; None where it is not.
        shift: from where the free coil fits best to the place where it is wrapped [m].
        reason: why it is not wrapped, or no pressure is recommended for it, in words; else empty.
        safe_shift: across its axis, from which it is still held [m]; None where no tolerance is
            required, or it is not wrapped.
        aim: from its place to the middle of these shifts, away from the base and across [m].
        falls_by_choice: whether nothing says to which side the tube falls at first.
    """

    radius: float
    onset: float | None = None
    shift: float = 0.0
    reason: str = ""
    safe_shift: float | None = None
    aim: tuple[float, float] = (0.0, 0.0)
    falls_by_choice: bool = False


@dataclass(frozen=True, slots=True)
class Evaluation(_Judged):
    """A candidate by the rod under gravity, its length corrected.

    Args:
        estimate: the candidate by the helix model.
        exact: its figures; None if no length wraps the largest object.
        held: every length solved on the way [m], and the largest radius that it holds [m].
        margins: room on every constraint, the helix model's where there are no exact figures.
        closed: the objects on which its gripper was closed; empty if it was not.
    """

    __repr__ = brief_repr

    estimate: Estimate
    exact: ExactFigures | None
    held: dict[float, float]
    margins: tuple[Margin, ...]
    closed: tuple[ClosedObject, ...] = ()

    @property
    def candidate(self) -> Candidate:
        """Tube, material, angles."""
        return self.estimate.candidate

    @property
    def smallest(self) -> GripFigures | None:
        """Wrapped about the smallest object; None if it cannot wrap both objects."""
        return None if self.exact is None else self.exact.smallest

    @property
    def length(self) -> float | None:
        """Corrected length [m]; None if no length wraps the largest object."""
        return None if self.exact is None else self.exact.length

    @property
    def pressure(self) -> float | None:
        """Pressure at the smallest object [Pa]; None if it cannot wrap both objects."""
        return None if self.smallest is None else self.smallest.pressure

    @property
    def strain(self) -> float | None:
        """Strain at the smallest object; None if it cannot wrap both objects."""
        return None if self.smallest is None else self.smallest.strain


def estimate_candidate(requirement: DesignRequirement, candidate: Candidate) -> Estimate:
    """Return the estimate of a candidate by the helix model (steps 2 to 5); takes milliseconds.

    Raises:
        InvalidInputError: pressure would not extend an actuator with these angles.
    """
    # The helix's figures do not depend on the length; one the size of the object will do.
    actuation = FreeActuation(candidate.actuator(requirement, length=requirement.radius_max))
    largest = smallest = None
    with suppress(NotGrippableError):
        largest = helix_grip(actuation, requirement.radius_max, requirement.turns_required)
    with suppress(NotGrippableError):
        smallest = helix_grip(actuation, requirement.radius_min, requirement.turns_required)
    margins = []
    closest = helix_radius(actuation, actuation.stretch_limit)
    widest, _ = widest_helix(actuation)
    if math.isfinite(widest):
        margins.append(Margin(Constraint.LARGEST_RADIUS, widest, requirement.radius_max))
    if closest > 0.0:  # else the coil closes on itself before the actuator ends
        margins.append(Margin(Constraint.SMALLEST_RADIUS, closest, requirement.radius_min))
    margins += _smallest_margins(requirement, candidate, smallest)
    if largest is not None:
        margins += _largest_margins(requirement, largest, largest.length_needed)
    return Estimate(candidate, largest, smallest, tuple(margins))


def evaluate_candidate(
    requirement: DesignRequirement,
    estimate: Estimate,
    held: Mapping[float, float] | None = None,
    near_miss: float = NEAR_MISS,
) -> Evaluation:
    """Return a candidate as a rod under gravity, with its length corrected (step 6).

    Its arguments and its result can be pickled: it can run in another process.

    Args:
        requirement: objects and limits.
        estimate: the candidate by the helix model.
        held: lengths solved before, and the largest radii that they hold [m].
        near_miss: by what the largest radius may fall short so that all lengths are gone through,
            which takes seconds (log of the centerline's radius).

    Raises:
        SolverError: a shape could not be certified.
    """
    candidate, margins = estimate.candidate, list(estimate.margins)
    smallest = [m for m in margins if m.constraint is Constraint.SMALLEST_RADIUS]
    if estimate.largest is None:
        return Evaluation(estimate, None, {}, estimate.margins)
    turns = requirement.turns_required * longest_length(requirement, candidate) / estimate.length
    if turns < HOPELESS_TURNS * requirement.turns_required:
        few = Margin(Constraint.TURNS, turns, requirement.turns_required)
        return Evaluation(estimate, None, {}, (*margins, few))
    search = LengthSearch(requirement, candidate, estimate.length, held)
    try:
        exact = search.figures(near_miss)
    except NotGrippableError as error:  # even the largest object is too thin
        least = Margin(Constraint.SMALLEST_RADIUS, error.nearest_radius or 0.0, error.radius)
        others = (margin for margin in margins if margin not in smallest)
        return Evaluation(estimate, None, {}, (*others, least))
    if exact is None:
        reach = Margin(Constraint.LARGEST_RADIUS, search.reached, requirement.radius_max)
        return Evaluation(estimate, None, search.held, (*margins, reach))
    # The helix model's smallest radius, at the actuator's own limit, unless the rod misses the
    # object: the rod was solved only as far as the smallest object needs.
    if exact.smallest is None:
        least = Margin(Constraint.SMALLEST_RADIUS, exact.radius_min, requirement.radius_min)
        smallest = [least]
    margins = [
        *smallest,
        *_largest_margins(requirement, exact.largest, exact.length),
        Margin(Constraint.TURNS, exact.largest.turns, requirement.turns_required),
        Margin(Constraint.LARGEST_RADIUS, exact.radius_max, requirement.radius_max),
        *_smallest_margins(requirement, candidate, exact.smallest),
    ]
    if requirement.payload is not None and all(margin.is_met for margin in margins):
        # Contact is loaded only when a payload is asked for.
        from spiral_core.design.payload import carried_mass

        gripper = exact.gripper
        carried, _ = carried_mass(requirement, gripper)
        if carried < requirement.payload and requirement.pressure_max is None:
            # Its own limit is that of the wrap alone.
            limit = min(
                _bearable(requirement, candidate, exact.length),
                MOST_FOR_PAYLOAD * gripper.pressure_max,
            )
            more, pressure = carried_mass(requirement, replace(gripper, pressure_max=limit))
            if more > NOTABLY * carried:
                carried, limit = more, min(limit, (1.0 + PRESSURE_RESERVE) * pressure)
                raised = replace(gripper, pressure_max=max(gripper.pressure_max, limit))
                exact = replace(exact, gripper=raised)
        margins.append(Margin(Constraint.PAYLOAD, carried, requirement.payload))
    return Evaluation(estimate, exact, search.held, tuple(margins))


def _bearable(requirement: DesignRequirement, candidate: Candidate, length: float) -> float:
    """Return the pressure up to which a candidate keeps to the largest strain [Pa]."""
    actuation, most = FreeActuation(candidate.actuator(requirement, length)), requirement.strain_max
    if most is None:
        return actuation.pressure_limit
    return actuation.pressure_from_stretch(min(1.0 + most, actuation.stretch_limit))


def solve_candidate(
    requirement: DesignRequirement,
    candidate: Candidate,
    held: Mapping[float, float] | None = None,
) -> Evaluation:
    """Return a candidate by both models; the arguments are those of :func:`evaluate_candidate`."""
    return evaluate_candidate(requirement, estimate_candidate(requirement, candidate), held)


def rank(candidate: Estimate | Evaluation) -> tuple[int, bool, float]:
    """Return the sort key of a candidate: fewest violations, those that wrap, largest margin."""
    hangs = isinstance(candidate, Evaluation) and candidate.exact is None
    violated = sum(not margin.is_met for margin in candidate.margins)
    return violated, hangs, -candidate.binding.relative


def preference_key(preference: Preference, candidate: Estimate | Evaluation) -> tuple[float, ...]:
    """Return the sort key of a candidate: those that do, by preference, then the others by rank.

    Args:
        preference: which design is wanted.
        candidate: by either model.
    """
    smallest, length = candidate.smallest, candidate.length
    if not candidate.feasible or smallest is None or length is None:
        return (True, *rank(candidate))
    figure = {
        Preference.LEAST_STRAIN: smallest.strain,
        Preference.LEAST_PRESSURE: smallest.pressure,
        Preference.SHORTEST: length,
        Preference.LARGEST_MARGIN: -candidate.binding.relative,
    }
    return (False, figure[preference])


def _smallest_margins(
    requirement: DesignRequirement, candidate: Candidate, figures: GripFigures | None
) -> list[Margin]:
    """Return the room on the constraints that the smallest object decides, if it is wrapped."""
    if figures is None:
        return []
    return _limited(
        (Constraint.STRAIN, figures.strain, requirement.strain_max),
        (Constraint.PRESSURE, figures.pressure, requirement.pressure_max),
        (Constraint.TURN_CLEARANCE, figures.turn_spacing, 2.0 * candidate.tube.outer_radius),
    )


def _largest_margins(
    requirement: DesignRequirement, figures: GripFigures, length: float
) -> list[Margin]:
    """Return the room on the constraints that the largest object decides.

    Object length and turn spacing grow with the radius as the coil does.
    """
    return _limited(
        (Constraint.OBJECT_LENGTH, figures.object_length, requirement.object_length),
        (Constraint.LENGTH, length, requirement.length_max),
    )


def _limited(*limits: tuple[Constraint, float, float | None]) -> list[Margin]:
    """Return a margin for each limit that is given."""
    return [Margin(one, value, bound) for one, value, bound in limits if bound is not None]
