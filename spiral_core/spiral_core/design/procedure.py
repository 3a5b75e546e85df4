# SPDX-License-Identifier: Apache-2.0
"""The design procedure: a gripper for given objects and limits, or the constraint that prevents it.

The paper's seven steps, and an eighth that closes the gripper on the objects with contact;
``docs/design.md`` describes them and what was added.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import count

import numpy as np

from spiral_core.actuator.actuator import windings_of
from spiral_core.design.evaluation import (
    Estimate,
    Evaluation,
    estimate_candidate,
    evaluate_candidate,
    preference_key,
    rank,
)
from spiral_core.design.margin import Constraint
from spiral_core.design.relaxations import relaxations_of
from spiral_core.design.report import Design, DesignReport, Relaxation
from spiral_core.design.requirement import DesignRequirement, Preference
from spiral_core.design.rod_correction import (
    NEAR_MISS,
    grip_figures,
)
from spiral_core.design.steps import steps_of
from spiral_core.errors import InvalidInputError, NoCoilError
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.placement import place_object

# Points of the answer's pressure-radius curve.
CURVE_POINTS = 41
# Candidates that fail as helices and are solved as rods all the same, if none does: gravity
# changes figures by tens of percent, and what binds should be named from exact figures.
OTHERS_TRIED = 12
# Where no candidate is nearer to the requirement, all its lengths are solved if the largest radius
# found misses by at most this factor: gravity was seen to gain 1.4.
FAR_MISS = math.log(2.0)

# Candidates solved after the first that does, as the order of helices is not quite that of rods.
# Strain, pressure and length change by percents; a margin may change by half.
LOOK_AHEAD = {
    Preference.LEAST_STRAIN: 2,
    Preference.LEAST_PRESSURE: 2,
    Preference.SHORTEST: 4,
    Preference.LARGEST_MARGIN: 1000,
}

# So many candidates that wrap every object, but miss the tolerance, are tried: each takes minutes.
MOST_SHIFTED = 6

Progress = Callable[[int, int, str], None]


def design_gripper(
    requirement: DesignRequirement, progress: Progress | None = None, *, contact: bool = True
) -> DesignReport:
    """Return a gripper for objects and limits, or the constraint that forbids it.

    Candidates (tube, material, angle) are ordered by the requirement's preference as the helix
    model sees them, and solved as rods under gravity in that order, each with its length corrected.
    A candidate that fails there sends the procedure back to its second step, with the next; of the
    first that meet everything the preferred one is taken. Its gripper closes on the largest, the
    middle and the smallest object, with contact and friction. A candidate that leaves one of them
    unwrapped where the free coil lies gives way to the next, until one wraps all; where none does,
    other places are tried for the preferred one. That takes seconds, with other places minutes.

    Args:
        requirement: objects, limits, what is on offer.
        progress: called with the number of candidates solved, the number there may be, and the
            name of the next, before each; then likewise of the objects that are closed on.
        contact: whether the gripper closes on objects; otherwise the tip criterion alone decides,
            as in the paper.

    Returns:
        The design with its steps; if there is none, what comes nearest, what binds, and the
        least changes that suffice.

    Raises:
        InvalidInputError: pressure would not extend an actuator with the angles on offer; a
            tolerance is required without contact.
        SolverError: a shape could not be certified.

    Example:
        >>> from spiral_core.design.requirement import Elastomer, TubeSize
        >>> from spiral_core.actuator.materials import MooneyRivlin
        >>> requirement = DesignRequirement(
        ...     radius_min=11.0e-3,
        ...     radius_max=30.0e-3,
        ...     tubes=(TubeSize("3/8 x 1/32 in", 4.7625e-3, 0.79375e-3),),
        ...     elastomers=(Elastomer("latex", MooneyRivlin(130.0e3, 15.0e3), 950.0),),
        ...     turns_required=1.5,
        ...     object_length=0.25,
        ... )
        >>> report = design_gripper(requirement)
        >>> report.feasible, round(np.degrees(report.design.actuator.fibers.beta))
        (True, 70)
        >>> round(report.design.helix_length, 4)
        0.364
    """
    if requirement.tolerance is not None and not contact:
        raise InvalidInputError("contact", contact, "true where a tolerance is required")
    progress = progress or (lambda *_: None)
    preferred = partial(preference_key, requirement.preference)
    estimates = [estimate_candidate(requirement, c) for c in requirement.candidates()]
    passing = sum(estimate.feasible for estimate in estimates)
    order = sorted(estimates, key=preferred)[: passing + OTHERS_TRIED]
    tried = _solve_in_order(requirement, order, progress)
    if not any(evaluation.feasible for evaluation in tried):
        tried = _solved_longer(requirement, tried, progress)
    chosen = min(tried, key=preferred)
    if contact and chosen.feasible:
        left = [estimate for estimate in order[len(tried) :] if estimate.feasible]
        tried, chosen = _closed(requirement, tried, left, progress)
    design = _design(requirement, chosen)
    relaxations: tuple[Relaxation, ...] = ()
    if not (chosen.closed or chosen.feasible):
        relaxations = relaxations_of(requirement, tried, chosen.binding.constraint)
    return DesignReport(
        requirement=requirement,
        feasible=chosen.feasible,
        design=design,
        steps=steps_of(requirement, estimates, tried, chosen, design),
        binding=chosen.binding,
        relaxations=relaxations,
        tried=tuple(tried),
        candidates=len(estimates),
    )


def _solve_in_order(
    requirement: DesignRequirement, order: Sequence[Estimate], progress: Progress
) -> list[Evaluation]:
    """Return the candidates solved as rods: up to the first that does, and those it must beat."""
    tried: list[Evaluation] = []
    left = LOOK_AHEAD[requirement.preference]
    for number, estimate in enumerate(order):
        found = any(evaluation.feasible for evaluation in tried)
        if found and (left == 0 or not estimate.feasible):
            break
        left -= found
        progress(number, len(order), estimate.candidate.label)
        tried.append(evaluate_candidate(requirement, estimate, near_miss=0.0))
    return tried


def _solved_longer(
    requirement: DesignRequirement, tried: Sequence[Evaluation], progress: Progress
) -> list[Evaluation]:
    """Return candidates of which none does, those whose length fails looked at again.

    At every length where they miss by no more than a factor of two and nothing else is nearer to
    the requirement, at every length after a near miss otherwise.
    """
    solved: list[Evaluation] = []
    fewest = min(rank(evaluation)[0] for evaluation in tried)
    for evaluation in tried:
        if evaluation.violated.keys() & {Constraint.LENGTH, Constraint.LARGEST_RADIUS}:
            progress(len(solved), len(tried), evaluation.candidate.label)
            evaluation = evaluate_candidate(  # noqa: PLW2901
                requirement,
                evaluation.estimate,
                evaluation.held,
                FAR_MISS if rank(evaluation)[0] == fewest else NEAR_MISS,
            )
        solved.append(evaluation)
    return solved


def _closed(
    requirement: DesignRequirement,
    tried: Sequence[Evaluation],
    left: Sequence[Estimate],
    progress: Progress,
) -> tuple[list[Evaluation], Evaluation]:
    """Return the candidates judged by contact, and the preferred that wraps every object.

    Those that are left are solved where none does. If none wraps every object where the free coil
    lies, or six do but miss the tolerance, other places are tried for the preferred one of all.

    Raises:
        SolverError: a free shape could not be certified.
    """
    # Contact is loaded only when it is asked for.
    from spiral_core.design.closing import close_on_objects, judged, objects_of

    # As many closings as there may be, twice where other places or shifts are tried.
    twice = 2 if requirement.tolerance is not None else 1
    steps = (len(tried) + len(left) + 2) * len(objects_of(requirement)) * twice + len(left)
    done = count()

    def told(what: str) -> None:
        progress(next(done), steps, what)

    def close(number: int, *, anywhere: bool = False) -> Evaluation:
        closed = close_on_objects(requirement, solved[number], told, anywhere=anywhere)
        result[number] = judged(requirement, solved[number], closed)
        return result[number]

    def preferred(number: int) -> tuple[float, ...]:
        return preference_key(requirement.preference, solved[number])

    solved, result, missed = list(tried), list(tried), 0
    while order := [number for number, one in enumerate(result) if one.feasible]:
        for number in sorted(order, key=preferred)[: MOST_SHIFTED - missed]:
            if close(number).feasible:
                return result, result[number]
            missed += Constraint.TOLERANCE in result[number].violated
        if missed == MOST_SHIFTED:
            break
        more = _solve_in_order(requirement, left, lambda *now: told(now[-1]))
        left = left[len(more) :]
        solved += more
        result += more
    number = min(range(len(solved)), key=preferred)
    return result, close(number, anywhere=True)


def _design(requirement: DesignRequirement, chosen: Evaluation) -> Design | None:
    """Return the chosen candidate as something to build; None if it wraps nothing."""
    exact = chosen.exact
    if exact is None:
        return None
    candidate, gripper = chosen.candidate, exact.gripper
    top = max(gripper.pressure_max, exact.pressure_max)
    curve = WrapCurve(replace(gripper, pressure_max=top))
    actuator = candidate.actuator(requirement, exact.length)
    # The length was corrected on another range of pressures, where the largest radius may be
    # larger by 3e-9 of itself.
    first = min(requirement.radius_max, curve.radius_max)
    radii = np.linspace(first, max(requirement.radius_min, exact.radius_min), CURVE_POINTS)
    points = tuple(grip_figures(curve.wrap_for_radius(r)) for r in radii.tolist())
    smallest = exact.smallest or points[-1]
    extremes = min(exact.largest.radius, curve.radius_max), smallest.radius
    largest, least = (place_object(curve.wrap_for_radius(radius)) for radius in extremes)
    radius_min = curve.radius_max
    with suppress(NoCoilError):  # a limit too low for any object, in a design that is not feasible
        radius_min = WrapCurve(gripper).radius_min
    return Design(
        tube=candidate.tube,
        elastomer=candidate.elastomer,
        actuator=actuator,
        gripper=gripper,
        windings=windings_of(actuator),
        cut_length=exact.length + 2.0 * requirement.end_allowance,
        helix_length=chosen.estimate.length,
        largest=exact.largest,
        smallest=smallest,
        radius_min=radius_min,
        radius_max=curve.radius_max,
        curve=points,
        placements=(largest, least),
        margins=chosen.margins,
    )
