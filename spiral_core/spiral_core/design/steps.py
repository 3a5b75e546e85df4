# SPDX-License-Identifier: Apache-2.0
"""The steps of the design procedure, each with its own intermediate result."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.design.evaluation import Estimate, Evaluation
from spiral_core.design.helix_estimate import GripFigures, helix_radius
from spiral_core.design.margin import Constraint, Margin
from spiral_core.design.report import Design, DesignStep, StepQuantity
from spiral_core.design.requirement import DesignRequirement
from spiral_core.design.rod_correction import ExactFigures
from spiral_core.message import Message, Quantity, joined


def steps_of(
    requirement: DesignRequirement,
    estimates: Sequence[Estimate],
    tried: Sequence[Evaluation],
    chosen: Evaluation,
    design: Design | None,
) -> tuple[DesignStep, ...]:
    """Return the seven steps of a design, and the eighth where its gripper was closed.

    Args:
        requirement: the question.
        estimates: every candidate by the helix model.
        tried: the candidates that were solved as rods.
        chosen: the one that was taken, or that comes nearest.
        design: made of it; None if it cannot wrap the largest object.
    """
    return (
        _tube(requirement, chosen),
        _ratios(requirement, chosen.estimate),
        _angle(requirement, estimates, tried, chosen),
        _length(requirement, chosen.estimate),
        _object_length(requirement, chosen.estimate),
        _correction(requirement, chosen),
        _design_space(chosen, design),
        *([_closing(chosen)] if chosen.closed else []),
    )


def _tube(requirement: DesignRequirement, chosen: Evaluation) -> DesignStep:
    """Step 1: the tube, chosen from those on offer or given."""
    tube = chosen.candidate.tube
    offer = f"{len(requirement.tubes)} on offer" if len(requirement.tubes) > 1 else "as given"
    return DesignStep(
        1,
        "tube",
        satisfied=True,
        remark=f"{tube.name}, {chosen.candidate.elastomer.name} ({offer})",
        figures=(
            StepQuantity("inner radius", tube.inner_radius, "m"),
            StepQuantity("wall thickness", tube.wall_thickness, "m"),
            StepQuantity("outer radius", tube.outer_radius, "m"),
            StepQuantity("tubes on offer", float(len(requirement.tubes)), "1"),
        ),
    )


def _ratios(requirement: DesignRequirement, estimate: Estimate) -> DesignStep:
    """Step 2: the objects' radii over the tube's."""
    radius = estimate.candidate.tube.inner_radius
    low, high = requirement.radius_min / radius, requirement.radius_max / radius
    return DesignStep(
        2,
        "radius ratios",
        satisfied=True,
        remark=f"objects of {low:.3g} to {high:.3g} tube radii",
        figures=(
            StepQuantity("smallest object radius / tube radius", low, "1"),
            StepQuantity("largest object radius / tube radius", high, "1"),
        ),
    )


def _angle(
    requirement: DesignRequirement,
    estimates: Sequence[Estimate],
    tried: Sequence[Evaluation],
    chosen: Evaluation,
) -> DesignStep:
    """Step 3: the fiber angle that the preference selects, and why the others are not taken."""
    estimate = chosen.estimate
    margins = _only(
        estimate.margins,
        Constraint.SMALLEST_RADIUS,
        Constraint.STRAIN,
        Constraint.TURN_CLEARANCE,
    )
    chosen_angles = estimate.candidate
    figures = [StepQuantity("fiber angle beta", chosen_angles.fiber_angle_beta, "rad")]
    if any(requirement.fiber_angles_gamma):
        gamma = chosen_angles.fiber_angle_gamma
        figures.append(StepQuantity("angle of the single fiber gamma", gamma, "rad"))
    figures += _interval(estimate)
    verdicts = []
    for other in _same_tube(estimates, estimate):
        if other.smallest is not None:
            name = Message("strain at the smallest object, {}", other.candidate.angles)
            figures.append(StepQuantity(name, other.smallest.strain, "1"))
        verdict = _verdict(other, tried, chosen)
        verdicts.append(Message("{} {}", other.candidate.angles, verdict))
    return DesignStep(
        3,
        "fiber angle",
        satisfied=_met(margins),
        remark=Message("{}: {}", requirement.preference.value, joined("; ", verdicts)),
        figures=tuple(figures),
    )


def _length(requirement: DesignRequirement, estimate: Estimate) -> DesignStep:
    """Step 4: the length of the required turns about the largest object, as a helix."""
    radius = estimate.candidate.tube.inner_radius
    largest = estimate.largest
    figures = [StepQuantity("turns required", requirement.turns_required, "1")]
    if largest is not None:
        figures += [
            StepQuantity("helix length", largest.length_needed, "m"),
            StepQuantity("helix length / tube radius", largest.length_needed / radius, "1"),
        ]
    return DesignStep(
        4,
        "length",
        satisfied=largest is not None and _met(_only(estimate.margins, Constraint.LENGTH)),
        remark=f"{requirement.turns_required:.4g} turns about the largest object, as a helix",
        figures=tuple(figures),
    )


def _object_length(requirement: DesignRequirement, estimate: Estimate) -> DesignStep:
    """Step 5: the length of object that those turns cover."""
    radius = estimate.candidate.tube.inner_radius
    figures = []
    for name, grip in _grips(estimate):
        covered = grip.object_length
        figures += [
            StepQuantity(f"object length at the {name} object", covered, "m"),
            StepQuantity(f"object length / tube radius, {name}", covered / radius, "1"),
        ]
    margins = _only(estimate.margins, Constraint.OBJECT_LENGTH)
    remark = margins[0].sentence if margins else "the object's length is not limited"
    if requirement.object_length is not None:
        figures.append(StepQuantity("object length available", requirement.object_length, "m"))
    return DesignStep(5, "object length", _met(margins), remark, tuple(figures))


def _correction(requirement: DesignRequirement, chosen: Evaluation) -> DesignStep:
    """Step 6: the rod under gravity, its length corrected."""
    title = "correction for gravity"
    exact, estimate = chosen.exact, chosen.estimate
    tried = StepQuantity("lengths solved", float(len(chosen.held)), "1")
    if exact is None:
        return DesignStep(
            6, title, satisfied=False, remark=_worst(chosen.margins), figures=(tried,)
        )
    actuation = FreeActuation(chosen.candidate.actuator(requirement, exact.length))
    spacing = min(grip.turn_spacing for _, grip in _grips(exact))
    figures = [
        StepQuantity("length", exact.length, "m"),
        StepQuantity("length / helix length", exact.length / estimate.length, "1"),
        StepQuantity("turns at the largest object", exact.largest.turns, "1"),
        *_interval(exact),
        StepQuantity("object length at the largest object", exact.largest.object_length, "m"),
        StepQuantity("least distance between turns", spacing, "m"),
        *(
            StepQuantity(
                f"radius range widened to, {name}", helix_radius(actuation, grip.stretch), "m"
            )
            for name, grip in _grips(exact)
        ),
        tried,
    ]
    margins = [m for m in chosen.margins if m.constraint is not Constraint.PRESSURE]
    remark = Message(
        "as a rod under gravity {} instead of {}; {}",
        Quantity(exact.length, "m"),
        Quantity(estimate.length, "m"),
        "all met" if _met(margins) else _worst(margins),
    )
    return DesignStep(6, title, _met(margins), remark, tuple(figures))


def _design_space(chosen: Evaluation, design: Design | None) -> DesignStep:
    """Step 7: pressure against radius, and the limits that it meets."""
    title = "exact design space"
    margins = _only(chosen.margins, Constraint.PRESSURE, Constraint.SMALLEST_RADIUS)
    if design is None:
        return DesignStep(7, title, satisfied=False, remark="nothing to show", figures=())
    figures = (
        StepQuantity("pressure at the largest object", design.largest.pressure, "Pa"),
        StepQuantity("pressure at the smallest object", design.smallest.pressure, "Pa"),
        StepQuantity("smallest radius within the pressure limit", design.radius_min, "m"),
        StepQuantity("largest radius", design.radius_max, "m"),
        StepQuantity("largest pressure", design.gripper.pressure_max, "Pa"),
    )
    ends = (
        Message("{} at {}", Quantity(end.pressure, "Pa"), Quantity(end.radius, "m"))
        for end in (design.largest, design.smallest)
    )
    remark = joined(" to ", ends)
    return DesignStep(7, title, _met(margins), remark, figures)


def _closing(chosen: Evaluation) -> DesignStep:
    """Step 8: what closing on the objects with contact ended with."""
    figures, said = [], []
    for one in chosen.closed:
        name = Quantity(one.radius, "m")
        if one.onset is None:
            said.append(Message("{} is not wrapped: {}", name, one.reason))
            continue
        figures.append(StepQuantity(Message("wrapped from, {}", name), one.onset, "Pa"))
        if one.shift:
            figures.append(StepQuantity(Message("object shifted by, {}", name), one.shift, "m"))
            said.append(Message("{} is wrapped from another place than the free coil's", name))
    remark = joined("; ", said) or "all objects are wrapped where the free coil lies"
    satisfied = all(one.onset is not None for one in chosen.closed)
    return DesignStep(8, "closing with contact", satisfied, remark, tuple(figures))


def _same_tube(estimates: Sequence[Estimate], chosen: Estimate) -> list[Estimate]:
    wanted = chosen.candidate
    return [
        e
        for e in estimates
        if (e.candidate.tube, e.candidate.elastomer) == (wanted.tube, wanted.elastomer)
    ]


def _verdict(estimate: Estimate, tried: Sequence[Evaluation], chosen: Evaluation) -> str:
    """Return why a candidate was taken or not."""
    if estimate is chosen.estimate:
        return "taken" if chosen.feasible else f"comes nearest ({_worst(chosen.margins)})"
    for evaluation in tried:
        if evaluation.estimate is estimate and not evaluation.feasible:
            return f"fails as a rod ({_worst(evaluation.margins)})"
    if not estimate.feasible:
        return f"fails as a helix ({_worst(estimate.margins)})"
    return "would do too"


def _grips(model: Estimate | ExactFigures) -> list[tuple[str, GripFigures]]:
    """Return the names and figures of the extreme objects that are wrapped."""
    both = (("largest", model.largest), ("smallest", model.smallest))
    return [(name, grip) for name, grip in both if grip is not None]


def _interval(model: Estimate | ExactFigures) -> list[StepQuantity]:
    return [
        StepQuantity(f"strain at the {name} object", grip.strain, "1")
        for name, grip in _grips(model)
    ]


def _worst(margins: Iterable[Margin]) -> str:
    margin = min(margins, key=lambda m: m.relative)
    return f"{margin.constraint.value} {100.0 * margin.relative:+.3g} %"


def _only(margins: Iterable[Margin], *constraints: Constraint) -> list[Margin]:
    return [margin for margin in margins if margin.constraint in constraints]


def _met(margins: Iterable[Margin]) -> bool:
    return all(margin.is_met for margin in margins)
