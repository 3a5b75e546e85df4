# SPDX-License-Identifier: Apache-2.0
"""The eighth step of a design: its gripper closes on the objects, with contact and friction."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from spiral_core.design.evaluation import ClosedObject, Evaluation
from spiral_core.design.margin import Constraint, Margin
from spiral_core.design.requirement import DesignRequirement
from spiral_core.errors import SpiralError
from spiral_core.grip.places import find_place
from spiral_core.grip.setup import GripSetup, lay_into_coil
from spiral_core.grip.window import grip_window
from spiral_core.message import Message, Quantity

Told = Callable[[str], None]


def objects_of(requirement: DesignRequirement) -> tuple[float, ...]:
    """Return the radii on which a design is closed [m]: largest, middle, smallest."""
    low, high = requirement.radius_min, requirement.radius_max
    return tuple(dict.fromkeys((high, 0.5 * (low + high), low)))


def close_on_objects(
    requirement: DesignRequirement, evaluation: Evaluation, told: Told, *, anywhere: bool = False
) -> tuple[ClosedObject, ...]:
    """Return what closing a candidate's gripper on each object ends with.

    Each object lies where the free coil fits best, as :func:`lay_into_coil` puts it.

    Args:
        requirement: objects, mount and friction.
        evaluation: a candidate as a rod under gravity.
        told: called with what is done next, in words.
        anywhere: whether other places are tried where an object is not wrapped in the first, up to
            the first object for which there is none.
    """
    radii, exact = objects_of(requirement), evaluation.exact
    if exact is None:
        return tuple(ClosedObject(r, reason="no length wraps the largest object") for r in radii)
    friction = requirement.friction_coefficient
    closed = []
    for radius in radii:
        told(Message("closing on {}", Quantity(radius, "m")))
        try:
            reached = min(radius, exact.largest.radius)  # to rounding
            setup = lay_into_coil(exact.gripper, reached, friction=friction)
        except SpiralError as error:
            closed.append(ClosedObject(radius, reason=str(error)))
            continue
        result = _closed(radius, setup)
        searched = anywhere and all(one.onset is not None for one in closed)
        if result.onset is None and searched:
            told(Message("looking for a place for {}", Quantity(radius, "m")))
            place = find_place(setup)
            if place is not None:
                shift = math.dist(place.obstacle.position, setup.obstacle.position)
                result = replace(_closed(radius, place), shift=shift)
        closed.append(result)
    return tuple(closed)


def _closed(radius: float, setup: GripSetup) -> ClosedObject:
    """Return what closing on an object in its place ends with."""
    try:
        window = grip_window(setup, until_wrapped=True)
    except SpiralError as error:
        return ClosedObject(radius, reason=str(error))
    reason = "" if window.onset_wrap is not None else window.end.value
    return ClosedObject(radius, window.onset_wrap, reason=reason)


def judged(evaluation: Evaluation, closed: tuple[ClosedObject, ...]) -> Evaluation:
    """Return a candidate with the room on the constraint that every object is wrapped."""
    wrapped = sum(one.onset is not None for one in closed)
    margin = Margin(Constraint.WRAPPED, float(wrapped), float(len(closed)))
    return replace(evaluation, margins=(*evaluation.margins, margin), closed=closed)
