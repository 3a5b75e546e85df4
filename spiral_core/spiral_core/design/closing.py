# SPDX-License-Identifier: Apache-2.0
"""The eighth step of a design: its gripper closes on the objects, with contact and friction."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from spiral_core.design.evaluation import ClosedObject, Evaluation
from spiral_core.design.margin import Constraint, Margin
from spiral_core.design.payload import object_in_coil
from spiral_core.design.requirement import DesignRequirement
from spiral_core.errors import SpiralError
from spiral_core.grip.capture import safe_shift
from spiral_core.grip.grip import recommended_grip
from spiral_core.grip.places import find_place
from spiral_core.grip.setup import GripSetup
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
    """Return what closing a candidate's gripper on each object ends with, up to one not wrapped.

    Each object lies where the free coil fits best, as :func:`lay_into_coil` puts it.

    Args:
        requirement: objects, mount and friction.
        evaluation: a candidate as a rod under gravity.
        told: called with what is done next, in words.
        anywhere: whether other places are tried where an object is not wrapped in the first, up to
            the first object for which there is none; then it is closed on all of them.
    """
    radii, exact = objects_of(requirement), evaluation.exact
    if exact is None:
        return tuple(ClosedObject(r, reason="no length wraps the largest object") for r in radii)
    friction = requirement.friction_coefficient
    closed: list[ClosedObject] = []
    for radius in radii:
        if not anywhere and closed and closed[-1].onset is None:
            break
        told(Message("closing on {}", Quantity(radius, "m")))
        try:
            setup = object_in_coil(exact.gripper, radius, friction)
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
                result, setup = replace(_closed(radius, place), shift=shift), place
        closed.append(result)
        wrapped = all(one.onset is not None for one in closed)
        if requirement.tolerance is not None and wrapped:
            told(Message("closing on {}, shifted", Quantity(radius, "m")))
            closed[-1] = _shifted(requirement, requirement.tolerance, setup, result)
    return tuple(closed)


def _closed(radius: float, setup: GripSetup) -> ClosedObject:
    """Return what closing on an object in its place ends with."""
    try:
        window = grip_window(setup, until_wrapped=True)
    except SpiralError as error:
        return ClosedObject(radius, reason=str(error))
    reason = "" if window.onset_wrap is not None else window.end.value
    falls = setup.falls_by_choice
    return ClosedObject(radius, window.onset_wrap, reason=reason, falls_by_choice=falls)


def _shifted(
    requirement: DesignRequirement, tolerance: float, setup: GripSetup, closed: ClosedObject
) -> ClosedObject:
    """Return how far an object may be shifted at its recommended pressure; 0 if it has none."""
    payload = requirement.payload
    try:
        pressure = recommended_grip(setup, payload).pressure
        safe, aim = safe_shift(setup, pressure, payload, tolerance)
    except SpiralError as error:
        return replace(closed, safe_shift=0.0, reason=str(error))
    return replace(closed, safe_shift=safe, aim=aim)


def judged(
    requirement: DesignRequirement, evaluation: Evaluation, closed: tuple[ClosedObject, ...]
) -> Evaluation:
    """Return a candidate with the room on what is required of closing on the objects."""
    wrapped = sum(one.onset is not None for one in closed)
    objects = len(objects_of(requirement))
    margins = [Margin(Constraint.WRAPPED, float(wrapped), float(objects))]
    if requirement.tolerance is not None and wrapped == objects:
        least = min(one.safe_shift or 0.0 for one in closed)
        margins.append(Margin(Constraint.TOLERANCE, least, requirement.tolerance))
    return replace(evaluation, margins=(*evaluation.margins, *margins), closed=closed)
