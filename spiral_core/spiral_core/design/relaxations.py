# SPDX-License-Identifier: Apache-2.0
"""The smallest sufficient change of each single limit when no design meets a requirement."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import replace
from typing import Any

from spiral_core.design.evaluation import (
    Evaluation,
    rank,
    solve_candidate,
)
from spiral_core.design.margin import Constraint, Margin
from spiral_core.design.report import Relaxation
from spiral_core.design.requirement import Candidate, DesignRequirement
from spiral_core.design.rod_correction import most_turns
from spiral_core.errors import SolverError
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
# Radii and turns are found to this fraction: finer than tubing is bought.
RESOLUTION = 4e-3
# Of this many steps one halves the bracket, whatever the secant suggests.
HALVING = 3
# Limits are widened by this fraction beyond the figure that needs them, as rounding's share.
ROUNDING = 1e-6


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
    nearest = sorted(evaluations, key=rank)
    found: list[Relaxation | None] = []
    # The limit at which a candidate that misses nothing else would do.
    for field, constraint in LIMITS.items():
        needed = [
            (e.violated[constraint], e.candidate)
            for e in nearest
            if e.violated.keys() == {constraint} and e.violated[constraint] > 0.0
        ]
        needed.sort(key=lambda one: one[0], reverse=not constraint.is_upper)
        for value, candidate in needed:
            sufficient = value * (1.0 + ROUNDING if constraint.is_upper else 1.0 - ROUNDING)
            if _carries(_changed(requirement, field, sufficient), candidate):
                requested = getattr(requirement, field)
                found.append(Relaxation(field, requested, sufficient, candidate.label))
                break
    of_smallest = [e for e in nearest if e.exact is not None and e.violated.keys() <= OF_SMALLEST]
    of_largest = [e for e in nearest if e.violated.keys() <= OF_LARGEST]
    found += [
        _least_change(requirement, "radius_min", of_smallest, requirement.radius_max),
        _least_change(requirement, "radius_max", of_largest, requirement.radius_min),
    ]
    if requirement.turns_required > DEFAULT_TURNS:
        found.append(_least_change(requirement, "turns_required", of_largest[:1], DEFAULT_TURNS))
    eases = {field for field, limited in LIMITS.items() if limited is binding}
    eases |= {"radius_min"} if binding in OF_SMALLEST else {"radius_max", "turns_required"}
    known = (relaxation for relaxation in found if relaxation is not None)
    return tuple(sorted(known, key=lambda one: (one.field not in eases, one.relative)))


def _least_change(
    requirement: DesignRequirement, field: str, suited: Iterable[Evaluation], good: float
) -> Relaxation | None:
    """Return the value of a field nearest to the one required at which a candidate will do.

    Args:
        requirement: that nothing meets.
        field: a radius or the turns.
        suited: candidates that miss nothing but what the field decides.
        good: the value of the field that is easiest to meet.
    """
    requested, best = getattr(requirement, field), None
    for evaluation in suited:
        held, candidate = dict(evaluation.held), evaluation.candidate

        def room(
            value: float, candidate: Candidate = candidate, held: dict[float, float] = held
        ) -> float:
            eased = replace(_changed(requirement, field, value), payload=None)
            # What a length holds does not depend on the largest object.
            known = held if field == "radius_max" else None
            solved = solve_candidate(eased, candidate, known)
            held.update(solved.held)
            return _least_room(solved.margins, field)

        with suppress(SolverError):  # what cannot be certified is not offered
            room_good = room(good)
            if room_good < 0.0:
                continue
            guess = math.nan  # about how much of the field the candidate does
            if field == "radius_max":
                limit = requirement.length_max or math.inf
                guess = max((r for x, r in evaluation.held.items() if x <= limit), default=guess)
            elif field == "turns_required":
                guess = most_turns(requirement, candidate, evaluation.estimate.length)
            without = requested, _least_room(evaluation.margins, field)
            value = _nearest(room, without, (good, room_good), guess)
            eased = _changed(requirement, field, value)
            if _carries(eased, candidate):
                good = value
                best = Relaxation(field, requested, value, candidate.label)
                if abs(requested - value) <= RESOLUTION * value:
                    break
    return best


def _carries(eased: DesignRequirement, candidate: Candidate) -> bool:
    """Return whether a candidate that meets all else carries the payload, if one is required."""
    with suppress(SolverError):  # what cannot be certified is not offered
        return eased.payload is None or solve_candidate(eased, candidate).feasible
    return False


def _changed(requirement: DesignRequirement, field: str, value: float) -> DesignRequirement:
    change: dict[str, Any] = {field: value}
    return replace(requirement, **change)


def _least_room(margins: Iterable[Margin], field: str) -> float:
    """Return the smallest relative margin of those that change with a field, or are not met.

    It is negative if one is not met, and 1 if nothing limits. What the field does not change would
    flatten the room, and mislead the secant.
    """
    eased = OF_SMALLEST if field == "radius_min" else OF_LARGEST
    counted = (
        m.relative
        for m in margins
        if not m.is_met or (m.constraint in eased and not m.constraint.is_met_just_so)
    )
    return min(counted, default=1.0)


def _nearest(
    room: Callable[[float], float],
    without: tuple[float, float],
    with_room: tuple[float, float],
    guess: float,
) -> float:
    """Return the value with room >= 0 next to one without; of both the room is given.

    The guess, and later the root of a secant, is tried on its two sides in turn, so that both ends
    of the bracket move.
    """
    (bad, room_bad), (good, room_good) = without, with_room
    step, side = 0, -1.0
    while abs(good - bad) > RESOLUTION * good:
        step += 1
        width = 0.45 * RESOLUTION * good / abs(bad - good)
        share = (guess - good) / (bad - good)
        if not 0.0 < share < 1.0:
            share = 0.5 if step % HALVING == 0 else room_good / (room_good - room_bad)
        middle = good + min(max(share + side * width, width), 1.0 - width) * (bad - good)
        value = room(middle)
        if value >= 0.0:
            good, room_good, side = middle, value, 1.0
        else:
            bad, room_bad, side = middle, value, -1.0
    return good
