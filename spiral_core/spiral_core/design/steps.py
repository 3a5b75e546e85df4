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
from spiral_core.rounding import rounded_down

Figure = tuple[str, float, str]


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
    candidate, estimate, exact = chosen.candidate, chosen.estimate, chosen.exact
    tube, radius, turns = candidate.tube, candidate.tube.inner_radius, requirement.turns_required
    steps: list[DesignStep] = []

    def step(title: str, satisfied: bool, remark: str, *figures: Figure) -> None:
        quantities = tuple(StepQuantity(*figure) for figure in figures)
        steps.append(DesignStep(len(steps) + 1, title, satisfied, remark, quantities))

    # 1: the tube, chosen from those on offer or given
    offered = len(requirement.tubes)
    offer = f"{offered} on offer" if offered > 1 else "as given"
    step(
        "tube",
        True,
        f"{tube.name}, {candidate.elastomer.name} ({offer})",
        ("inner radius", radius, "m"),
        ("wall thickness", tube.wall_thickness, "m"),
        ("outer radius", tube.outer_radius, "m"),
        ("tubes on offer", float(offered), "1"),
    )

    # 2: the objects' radii over the tube's
    low, high = requirement.radius_min / radius, requirement.radius_max / radius
    step(
        "radius ratios",
        True,
        f"objects of {low:.3g} to {high:.3g} tube radii",
        ("smallest object radius / tube radius", low, "1"),
        ("largest object radius / tube radius", high, "1"),
    )

    # 3: the fiber angle that the preference selects, and why the others are not taken
    figures: list[Figure] = [("fiber angle beta", candidate.fiber_angle_beta, "rad")]
    if any(requirement.fiber_angles_gamma):
        figures.append(("angle of the single fiber gamma", candidate.fiber_angle_gamma, "rad"))
    figures += _strains(estimate)
    verdicts = []
    for other in estimates:
        rival = other.candidate
        if (rival.tube, rival.elastomer) != (tube, candidate.elastomer):
            continue
        if other.smallest is not None:
            label = Message("strain at the smallest object, {}", rival.angles)
            figures.append((label, other.smallest.strain, "1"))
        verdicts.append(Message("{} {}", rival.angles, _verdict(other, tried, chosen)))
    shape = Constraint.SMALLEST_RADIUS, Constraint.STRAIN, Constraint.TURN_CLEARANCE
    remark: str = Message("{}: {}", requirement.preference.value, joined("; ", verdicts))
    step("fiber angle", _met(estimate.margins, *shape), remark, *figures)

    # 4: the length of the required turns about the largest object, as a helix
    largest, figures = estimate.largest, [("turns required", turns, "1")]
    if largest is not None:
        figures.append(("helix length", largest.length_needed, "m"))
        figures.append(("helix length / tube radius", largest.length_needed / radius, "1"))
    met = largest is not None and _met(estimate.margins, Constraint.LENGTH)
    step("length", met, f"{turns:.4g} turns about the largest object, as a helix", *figures)

    # 5: the length of object that those turns cover
    figures, remark = [], "the object's length is not limited"
    for name, grip in _grips(estimate):
        covered = grip.object_length
        figures.append((f"object length at the {name} object", covered, "m"))
        figures.append((f"object length / tube radius, {name}", covered / radius, "1"))
    for margin in estimate.margins:
        if margin.constraint is Constraint.OBJECT_LENGTH:
            remark = margin.sentence
    if requirement.object_length is not None:
        figures.append(("object length available", requirement.object_length, "m"))
    step("object length", _met(estimate.margins, Constraint.OBJECT_LENGTH), remark, *figures)

    # 6: the rod under gravity, its length corrected
    solved = "lengths solved", float(len(chosen.held)), "1"
    if exact is None:
        step("correction for gravity", False, _worst(chosen.margins), solved)
    else:
        actuation = FreeActuation(candidate.actuator(requirement, exact.length))
        figures = [
            ("length", exact.length, "m"),
            ("length / helix length", exact.length / estimate.length, "1"),
            ("turns at the largest object", exact.largest.turns, "1"),
            *_strains(exact),
            ("object length at the largest object", exact.largest.object_length, "m"),
            ("least distance between turns", min(g.turn_spacing for _, g in _grips(exact)), "m"),
        ]
        for name, grip in _grips(exact):
            widened = helix_radius(actuation, grip.stretch)
            figures.append((f"radius range widened to, {name}", widened, "m"))
        others = [m for m in chosen.margins if m.constraint is not Constraint.PRESSURE]
        remark = Message(
            "as a rod under gravity {} instead of {}; {}",
            Quantity(exact.length, "m"),
            Quantity(estimate.length, "m"),
            "all met" if _met(others) else _worst(others),
        )
        step("correction for gravity", _met(others), remark, *figures, solved)

    # 7: pressure against radius, and the limits that it meets
    if design is None:
        step("exact design space", False, "nothing to show")
    else:
        ends = (
            Message("{} at {}", Quantity(end.pressure, "Pa"), Quantity(end.radius, "m"))
            for end in (design.largest, design.smallest)
        )
        step(
            "exact design space",
            _met(chosen.margins, Constraint.PRESSURE, Constraint.SMALLEST_RADIUS),
            joined(" to ", ends),
            ("pressure at the largest object", design.largest.pressure, "Pa"),
            ("pressure at the smallest object", design.smallest.pressure, "Pa"),
            ("smallest radius within the pressure limit", design.radius_min, "m"),
            ("largest radius", design.radius_max, "m"),
            ("largest pressure", design.gripper.pressure_max, "Pa"),
        )

    # 8: what closing on the objects with contact ended with
    if chosen.closed:
        said, figures = [], []
        for one in chosen.closed:
            size = Quantity(one.radius, "m")
            if one.onset is None:
                said.append(Message("{} is not wrapped: {}", size, one.reason))
                continue
            figures.append((Message("wrapped from, {}", size), one.onset, "Pa"))
            if one.safe_shift is not None:
                figures.append((Message("safe shift, {}", size), one.safe_shift, "m"))
                for way, aim in zip(("away from the base", "across"), one.aim, strict=True):
                    figures.append((Message("aim {}, {}", way, size), aim, "m"))
                if one.reason:
                    said.append(Message("{} is held at no pressure: {}", size, one.reason))
                elif one.safe_shift < (requirement.tolerance or 0.0):
                    safe = Quantity(one.safe_shift, "m", rounded_down)
                    said.append(Message("{} is held up to a shift of {} alone", size, safe))
            if one.shift:
                figures.append((Message("object shifted by, {}", size), one.shift, "m"))
                said.append(Message("{} is wrapped from another place than the free coil's", size))
        said = said or [Message("all objects are wrapped where the free coil lies")]
        if any(one.falls_by_choice for one in chosen.closed):
            said.append(
                Message(
                    "upright it may fall to any side at first: here to the one to which it bends"
                )
            )
        remark = joined("; ", said)
        met = _met(chosen.margins, Constraint.WRAPPED, Constraint.TOLERANCE)
        step("closing with contact", met, remark, *figures)
    return tuple(steps)


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


def _strains(model: Estimate | ExactFigures) -> list[Figure]:
    return [(f"strain at the {name} object", grip.strain, "1") for name, grip in _grips(model)]


def _worst(margins: Iterable[Margin]) -> str:
    margin = min(margins, key=lambda m: m.relative)
    return f"{margin.constraint.value} {100.0 * margin.relative:+.3g} %"


def _met(margins: Iterable[Margin], *constraints: Constraint) -> bool:
    """Return whether margins are met, of all constraints or of some."""
    return all(m.is_met for m in margins if not constraints or m.constraint in constraints)
