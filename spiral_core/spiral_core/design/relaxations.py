# SPDX-License-Identifier: Apache-2.0
"""The smallest sufficient change of each single limit when no design meets a requirement."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import replace

from spiral_core.design.evaluation import (
    Evaluation,
    estimate_candidate,
    evaluate_candidate,
    rank,
    smallest_margins,
)
from spiral_core.design.margin import Constraint, Margin
from spiral_core.design.report import Relaxation
from spiral_core.design.requirement import Candidate, DesignRequirement
from spiral_core.design.rod_correction import grip_figures, gripper_of
from spiral_core.errors import NotGrippableError, SolverError
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import DEFAULT_TURNS

LIMITS = {
    "strain_max": Constraint.STRAIN,
    "pressure_max": Constraint.PRESSURE,
    "object_length": Constraint.OBJECT_LENGTH,
    "length_max": Constraint.LENGTH,
    "payload": Constraint.PAYLOAD,
}
# Constraints that a larger smallest object eases, and those that a smaller largest object eases.
OF_SMALLEST = frozenset(
    {
        Constraint.SMALLEST_RADIUS,
        Constraint.STRAIN,
        Constraint.PRESSURE,
        Constraint.TURN_CLEARANCE,
    }
)
OF_LARGEST = frozenset(
    {
        Constraint.LARGEST_RADIUS,
        Constraint.OBJECT_LENGTH,
        Constraint.LENGTH,
        Constraint.TURNS,
    }
)
# Radii are given to this fraction: finer than tubing is bought.
RADIUS_RESOLUTION = 5e-3
# Turns are given to this fraction: each trial corrects the length of a long gripper anew.
TURNS_RESOLUTION = 0.05
# A search for a radius ends where this fraction of a limit, or less, is left unused.
ROOM_RESOLUTION = 5e-3
# Room of a radius that a gripper does not reach: none, by as much as makes the search halve.
UNREACHABLE = -1.0
# Limits are widened by this fraction beyond the figure that needs them, as rounding's share.
ROUNDING = 1e-6
# Of the candidates that come nearest, how many are searched for a radius they do meet.
RADIUS_CANDIDATES = 2


def relaxations_of(
    requirement: DesignRequirement, evaluations: Iterable[Evaluation], binding: Constraint
) -> tuple[Relaxation, ...]:
    """Return the least changes of single requirements that suffice.

    First those that ease the binding constraint itself, the smallest change first.

    Each is verified: the candidate it names was solved with the changed requirement, or its solved
    figures do not depend on what is changed.

    Args:
        requirement: that nothing meets.
        evaluations: the candidates that were solved.
        binding: the constraint that forbids the nearest of them.
    """
    by_room = sorted(evaluations, key=lambda e: rank(e.margins))
    found = [_limit_relaxation(requirement, by_room, field, LIMITS[field]) for field in LIMITS]
    for search in (_radius_min_relaxation, _radius_max_relaxation, _turns_relaxation):
        with suppress(SolverError):  # what cannot be certified is not offered
            found.append(search(requirement, by_room))
    eases = _fields_easing(binding)
    return tuple(
        sorted(
            (relaxation for relaxation in found if relaxation is not None),
            key=lambda relaxation: (relaxation.field not in eases, relaxation.relative),
        )
    )


def _fields_easing(constraint: Constraint) -> set[str]:
    """Return the fields of a requirement that bear on a constraint."""
    fields = {field for field, limited in LIMITS.items() if limited is constraint}
    if constraint in OF_SMALLEST:
        return fields | {"radius_min"}
    return fields | {"radius_max", "turns_required"}


def _violated(evaluation: Evaluation) -> frozenset[Constraint]:
    return frozenset(m.constraint for m in evaluation.margins if not m.is_met)


def _limit_relaxation(
    requirement: DesignRequirement,
    evaluations: list[Evaluation],
    field: str,
    constraint: Constraint,
) -> Relaxation | None:
    """Return the limit at which a candidate that misses nothing else would do."""
    needed = [
        (_margin(evaluation, constraint).value, evaluation.candidate.label)
        for evaluation in evaluations
        if _violated(evaluation) == {constraint} and _margin(evaluation, constraint).value > 0.0
    ]
    if not needed:
        return None
    upper = constraint.is_upper
    value, label = min(needed) if upper else max(needed)
    sufficient = value * (1.0 + ROUNDING if upper else 1.0 - ROUNDING)
    return Relaxation(field, getattr(requirement, field), sufficient, label)


def _radius_min_relaxation(
    requirement: DesignRequirement, evaluations: list[Evaluation]
) -> Relaxation | None:
    """Return the smallest object that a candidate does hold with all else kept."""
    suited = [e for e in evaluations if e.exact is not None and _violated(e) <= OF_SMALLEST]
    answers = [
        _smallest_radius(requirement, evaluation) for evaluation in suited[:RADIUS_CANDIDATES]
    ]
    return min((a for a in answers if a is not None), key=lambda a: a.sufficient, default=None)


def _smallest_radius(requirement: DesignRequirement, evaluation: Evaluation) -> Relaxation | None:
    """Return the smallest object of one candidate, on the curve of its own length."""
    if evaluation.exact is None:
        return None
    candidate, length = evaluation.candidate, evaluation.exact.length
    curve = WrapCurve(gripper_of(requirement, candidate, length, evaluation.exact.pressure_max))

    def room(radius: float) -> float:
        try:
            wrap = curve.wrap_for_radius(radius)
        except NotGrippableError:
            return UNREACHABLE
        figures = grip_figures(wrap, requirement.turns_required)
        return _least_room(smallest_margins(requirement, candidate, figures))

    radius = _nearest(room, bad=requirement.radius_min, good=requirement.radius_max)
    if radius is None:
        return None
    return Relaxation("radius_min", requirement.radius_min, radius, candidate.label)


def _eased_by_a_smaller_largest(evaluations: list[Evaluation]) -> list[Evaluation]:
    """Return the candidates that miss nothing but what the largest object decides."""
    return [
        e
        for e in evaluations
        if _violated(e) <= OF_LARGEST
        and (e.estimate.largest or Constraint.LARGEST_RADIUS in _violated(e))
    ]


def _turns_relaxation(
    requirement: DesignRequirement, evaluations: list[Evaluation]
) -> Relaxation | None:
    """Return the most turns that the nearest candidate makes with all else kept."""
    suited = _eased_by_a_smaller_largest(evaluations)
    if not suited or not requirement.turns_required > DEFAULT_TURNS:
        return None
    candidate = suited[0].candidate

    def room(turns: float) -> float:
        return _room_of_largest(replace(requirement, turns_required=turns), candidate)

    few = [m.value for m in suited[0].margins if m.constraint is Constraint.TURNS and not m.is_met]
    bad = max(min([requirement.turns_required, *few]), DEFAULT_TURNS)
    turns = _nearest(room, bad, good=DEFAULT_TURNS, resolution=TURNS_RESOLUTION)
    if turns is None:
        return None
    return Relaxation("turns_required", requirement.turns_required, turns, candidate.label)


def _room_of_largest(requirement: DesignRequirement, candidate: Candidate) -> float:
    """Return the least room on what the largest object decides, the length corrected for it."""
    result = evaluate_candidate(requirement, estimate_candidate(requirement, candidate))
    return _least_room(m for m in result.margins if m.constraint in OF_LARGEST)


def _radius_max_relaxation(
    requirement: DesignRequirement, evaluations: list[Evaluation]
) -> Relaxation | None:
    """Return the largest object that the nearest candidate does hold with all else kept."""
    suited = _eased_by_a_smaller_largest(evaluations)
    return _largest_radius(requirement, suited[0]) if suited else None


def _largest_radius(requirement: DesignRequirement, evaluation: Evaluation) -> Relaxation | None:
    """Return the largest object of one candidate, its length corrected for each radius tried."""
    candidate = evaluation.candidate

    def room(radius: float) -> float:
        return _room_of_largest(replace(requirement, radius_max=radius), candidate)

    bad = requirement.radius_max
    reached = [m.value for m in evaluation.margins if m.constraint is Constraint.LARGEST_RADIUS]
    if evaluation.exact is None and reached:  # no length reaches farther than this
        bad = min(bad, *reached)
    if not bad > requirement.radius_min:
        return None
    radius = _nearest(room, bad=bad, good=requirement.radius_min)
    if radius is None:
        return None
    return Relaxation("radius_max", requirement.radius_max, radius, candidate.label)


def _least_room(margins: Iterable[Margin]) -> float:
    """Return the smallest relative margin; negative if one is not met, 1 if nothing limits."""
    counted = (m.relative for m in margins if not (m.is_met and m.constraint.is_set_by_length))
    return min(counted, default=1.0)


def _nearest(
    room: Callable[[float], float],
    bad: float,
    good: float,
    resolution: float = RADIUS_RESOLUTION,
) -> float | None:
    """Return a value with room >= 0 that leaves little of it; None if ``good`` has none.

    False position, kept off the ends of the bracket: the room is nearly linear in a radius.
    """
    room_good, room_bad = room(good), room(bad)
    if room_good < 0.0:
        return None
    if room_bad >= 0.0:
        return bad
    while room_good > ROOM_RESOLUTION and abs(good - bad) > resolution * good:
        fraction = min(max(room_good / (room_good - room_bad), 0.1), 0.9)
        middle = good + fraction * (bad - good)
        value = room(middle)
        if value >= 0.0:
            good, room_good = middle, value
        else:
            bad, room_bad = middle, value
    return good


def _margin(evaluation: Evaluation, constraint: Constraint) -> Margin:
    return next(m for m in evaluation.margins if m.constraint is constraint)
