# SPDX-License-Identifier: Apache-2.0
"""The result of the design procedure: a gripper, or the constraint that prevents one."""

from __future__ import annotations

import math
from dataclasses import dataclass

from spiral_core.actuator.actuator import Actuator, Winding
from spiral_core.brief import brief_repr
from spiral_core.design.evaluation import Evaluation
from spiral_core.design.helix_estimate import GripFigures
from spiral_core.design.margin import Constraint, Margin
from spiral_core.design.requirement import Candidate, DesignRequirement, Elastomer, TubeSize
from spiral_core.message import Message, Quantity
from spiral_core.rounding import rounded_down, rounded_up
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.placement import ObjectPlacement

# Gravity within this angle of the tube, at the clamp, bends it as if it were along it [rad].
NO_ROLL = 1e-3


@dataclass(frozen=True, slots=True)
class StepQuantity:
    """A named figure of a step.

    Args:
        name: what it is, in words.
        value: in SI.
        unit: its SI unit; ``"1"`` for ratios, strains and counts.
    """

    name: str
    value: float
    unit: str


@dataclass(frozen=True, slots=True)
class DesignStep:
    """One step of the design, with its intermediate result.

    Args:
        number: 1 to 7, as in the paper; 8 closes the gripper on the objects.
        title: what is decided.
        satisfied: whether the step could be met.
        remark: how, or why not, in one line.
        figures: its result.
    """

    __repr__ = brief_repr

    number: int
    title: str
    satisfied: bool
    remark: str
    figures: tuple[StepQuantity, ...]


@dataclass(frozen=True, slots=True)
class Relaxation:
    """The least change of one requirement that makes the whole feasible, all others kept.

    Args:
        field: of the requirement.
        requested: its value as it was asked for.
        sufficient: its value at which a design exists.
        design: that design, in words.
    """

    field: str
    requested: float
    sufficient: float
    design: str

    @property
    def relative(self) -> float:
        """How far the requirement is changed, as a fraction of what was asked for."""
        return abs(self.sufficient / self.requested - 1.0)

    @property
    def sentence(self) -> str:
        """The change in words; its value is rounded such that it still suffices."""
        unit = {
            "strain_max": "1",
            "pressure_max": "Pa",
            "turns_required": "1",
            "payload": "kg",
        }.get(self.field, "m")
        outward = rounded_up if self.sufficient > self.requested else rounded_down
        return Message(
            "{} = {} instead of {} ({})",
            self.field,
            Quantity(self.sufficient, unit, outward),
            Quantity(self.requested, unit),
            self.design,
        )


@dataclass(frozen=True, slots=True)
class Design:
    """A gripper that can be built.

    Args:
        tube: the tube's size.
        elastomer: its material.
        actuator: tube of the corrected length, fibers, material.
        gripper: the same, mounted, with its largest pressure.
        windings: of the first and the second family.
        cut_length: tube to cut, with what the two ends take up [m].
        helix_length: length by the helix model alone [m].
        largest: wrapped about the largest object.
        smallest: wrapped about the smallest object, or about the smallest it can.
        radius_min: smallest radius that it grips within the pressure limit [m].
        radius_max: largest radius that it grips [m].
        curve: pressure against object radius, from the largest to the smallest object.
        placements: where the largest and the smallest object lie.
        margins: room on every constraint.
    """

    __repr__ = brief_repr

    tube: TubeSize
    elastomer: Elastomer
    actuator: Actuator
    gripper: Gripper
    windings: tuple[Winding, ...]
    cut_length: float
    helix_length: float
    largest: GripFigures
    smallest: GripFigures
    radius_min: float
    radius_max: float
    curve: tuple[GripFigures, ...]
    placements: tuple[ObjectPlacement, ObjectPlacement]
    margins: tuple[Margin, ...]

    @property
    def length(self) -> float:
        """Unstretched length of the actuator, corrected for gravity [m]."""
        return self.actuator.tube.length

    @property
    def fiber_angle(self) -> float:
        """Angle of the single fiber, gamma [rad]; 0 is straight."""
        return self.actuator.single_fibers[0].angle

    @property
    def roll(self) -> float | None:
        """Angle about the tube, at the clamp, from the single fiber (+y) to gravity [rad].

        None where gravity has no part across the tube: the roll of the clamp is then of no matter.
        """
        along, y, z = self.gripper.gravity
        across = math.hypot(y, z)
        return math.atan2(z, y) if across > NO_ROLL * math.hypot(along, across) else None

    @property
    def sentence(self) -> str:
        """The design in one line."""
        pair = self.actuator.fiber_pair
        chosen = Candidate(self.tube, self.elastomer, pair.beta, self.fiber_angle)
        return Message(
            "{}, length {}, {} to {}",
            chosen.label,
            Quantity(self.length, "m"),
            Quantity(self.largest.pressure, "Pa"),
            Quantity(self.smallest.pressure, "Pa"),
        )


@dataclass(frozen=True, slots=True)
class DesignReport:
    """What the design procedure found, step by step.

    Args:
        requirement: the question.
        feasible: whether everything required is met.
        design: the answer; if nothing meets the requirement, what comes nearest; None if nothing
            wraps at all.
        steps: the seven steps, and the eighth where contact was asked for.
        binding: the constraint that leaves least room, or that forbids.
        relaxations: if infeasible, sufficient changes of one requirement, the smallest first.
        tried: the candidates that were solved as rods, in the order they were tried.
        candidates: number of combinations on offer.
    """

    __repr__ = brief_repr

    requirement: DesignRequirement
    feasible: bool
    design: Design | None
    steps: tuple[DesignStep, ...]
    binding: Margin
    relaxations: tuple[Relaxation, ...]
    tried: tuple[Evaluation, ...]
    candidates: int

    @property
    def outlook(self) -> str:
        """What would help where no design is feasible, or why nothing is known to, in one line."""
        if self.relaxations:
            return Message("feasible with {}", self.relaxations[0].sentence)
        if self.binding.constraint is Constraint.WRAPPED:
            return self.steps[-1].remark
        if self.binding.constraint is Constraint.TOLERANCE and self.binding.value > 0.0:
            safe = Quantity(self.binding.value, "m", rounded_down)
            return Message("feasible with a tolerance of {}", safe)
        return "no single change of the requirement makes it feasible"

    @property
    def message(self) -> str:
        """The answer in one line."""
        if self.feasible and self.design is not None:
            return self.design.sentence
        return Message("not feasible: {}; {}", self.binding.sentence, self.outlook)
