# SPDX-License-Identifier: Apache-2.0
"""A question to a gripper, its answer, and that as plain data for programs."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from spiral_core.errors import NotGrippableError
from spiral_core.grip.grip import Grip, solve_grip
from spiral_core.grip.holding import HoldingForce, Pull, holding_forces
from spiral_core.grip.places import (
    PLACES_TRIED,
    find_place,
    nearest_held_radius,
    not_held,
    what_helps,
)
from spiral_core.grip.setup import Closing, GripSetup, lay_into_coil, lay_profile_into_coil
from spiral_core.grip.window import (
    NUDGE,
    GripPoint,
    GripWindow,
    follow_loss,
    grip_window,
    nudged_windows,
)
from spiral_core.message import Message, Quantity, joined
from spiral_core.rod.contact.shapes import Profile
from spiral_core.rod.types import Vector
from spiral_core.wrap.gripper import Gripper
from spiral_gripper.reports.fields import Progress
from spiral_gripper.reports.wrap_document import read_profile


@dataclass(frozen=True, slots=True)
class GripQuestion:
    """The inputs of a grip computation.

    Args:
        gripper: as it is mounted.
        radius: of a cylinder [m], or None.
        profile: of an object, a CSV file, or None.
        friction: coefficient; None takes the gripper's or the default.
        frictionless: whether friction acts only once it is closed.
        every_direction: whether the object is moved in all directions.
        payload: mass to carry [kg], or None.
        force_max: greatest sum of normal forces [N], or None.
        pressures: to look at [Pa]; none takes ten from a little below the wrap on.
        place: of the object's middle, in the base frame [m]; None is in the free coil.
        spread: whether it is closed again with the object moved aside by next to nothing.
    """

    gripper: Gripper
    radius: float | None
    profile: Path | None
    friction: float | None = None
    frictionless: bool = False
    every_direction: bool = False
    payload: float | None = None
    force_max: float | None = None
    pressures: tuple[float, ...] = ()
    place: Vector | None = None
    spread: bool = False

    @property
    def pulls(self) -> tuple[Pull, ...]:
        """Ways of moving the object that are looked at."""
        if self.every_direction:
            weightless = not any(self.gripper.gravity)
            return tuple(pull for pull in Pull if not (weightless and pull is Pull.DOWN))
        loaded = (Pull.DOWN,) if self.payload is not None else ()
        return (Pull.AWAY, Pull.TOWARDS, *loaded)


@dataclass(frozen=True, slots=True)
class SolvedGrip:
    """A grip computation and its results.

    Args:
        question: the inputs.
        grip: the answer.
        recommended: pressure to command [Pa]; None if none meets the conditions.
        point: the grip at the first pressure that was asked for, or there, or at the middle of the
            recommended range.
        held: what the point holds, computed there.
        refusal: why no pressure meets the conditions, or None.
        rest: what remains of the grip after its loss; None if nothing was lost, or nothing rests.
        rest_held: what the rest still holds, by the question's ways of moving the object.
        mark: place on the profile's own axis that is in the coil's middle [m], or None.
        nudged: what closing again finds with the object moved aside; empty if not asked for.
    """

    question: GripQuestion
    grip: Grip
    recommended: float | None
    point: GripPoint
    held: Mapping[Pull, HoldingForce]
    refusal: str | None
    rest: GripPoint | None
    rest_held: Mapping[Pull, HoldingForce]
    mark: float | None
    nudged: tuple[GripWindow, ...] = ()


def solve_question(
    question: GripQuestion, progress: Progress | None = None, *, forces: bool = True
) -> SolvedGrip:
    """Return how a gripper holds an object, or without ``forces`` where it is wrapped.

    Raises:
        InvalidInputError: a value is out of its range, or the profile's file cannot be used.
        NotGrippableError: the object is not held at any pressure.
    """
    window, mark = closed_window(question, progress)
    pulls, asked = question.pulls if forces else (), sorted(set(question.pressures))
    grip = Grip(window, (), {})
    if forces:
        grip = solve_grip(
            window.setup, pulls, pressures=asked or None, window=window, progress=progress
        )
    refusal = recommended = None
    try:
        recommended = grip.recommended_pressure(question.payload, force_max=question.force_max)
    except NotGrippableError as error:
        refusal = error.constraint
    if asked and forces:  # computed already
        looked_at = asked.index(question.pressures[0])
        point = grip.points[looked_at]
        held = {pull: found[looked_at] for pull, found in grip.forces.items()}
    else:
        best = grip.recommended_pressure() if recommended is None else recommended
        point = window.at(question.pressures[0] if asked else best)
        held = holding_forces(point, pulls)
    rest = follow_loss(window) if forces else None
    rest_held = {} if rest is None else holding_forces(rest, pulls)
    nudged = nudged_windows(window.setup) if question.spread else ()
    return SolvedGrip(
        question, grip, recommended, point, held, refusal, rest, rest_held, mark, nudged
    )


def placed(
    question: GripQuestion,
    executor: Executor | None,
    progress: Progress | None = None,
) -> GripQuestion:
    """Return a question with the object where it is held: in the free coil or, if not, near it.

    Raises:
        InvalidInputError: a value is out of its range, or the profile's file cannot be used.
        NotGrippableError: the object is held in no place that was tried; says what would help.
    """
    setup, _ = setup_of(question)
    found = find_place(setup, executor, progress)
    if found is None:
        reason = f"of {PLACES_TRIED} places in and near the coil none holds it"
        reason = joined("; ", (reason, what_helps(setup, executor)))
        radius = float(setup.obstacle.shape.feature_radius)
        raise NotGrippableError(radius, reason, -1.0, nearest_held_radius(setup))
    if found is setup:
        return question
    x, y, z = found.axis.tolist()
    gripper = replace(question.gripper, object_axis=(x, y, z))
    return replace(question, gripper=gripper, place=found.obstacle.position)


def closed_window(
    question: GripQuestion, progress: Progress | None = None
) -> tuple[GripWindow, float | None]:
    """Return the window of a question, and the place on the profile's axis in the coil's middle.

    Raises:
        NotGrippableError: no pressure wraps the object, or nothing is held at one of those asked.
    """
    setup, mark = setup_of(question)
    window = grip_window(setup, progress=progress)
    if window.onset_wrap is None:
        refusal = not_held(window, progress)
        for nudged in nudged_windows(setup) if question.spread else ():
            if nudged.onset_wrap is not None:
                reason = Message(
                    "{}; moved aside by {} it is wrapped from {}: no experiment can decide",
                    refusal.constraint,
                    Quantity(NUDGE * setup.gripper.tube.length, "m"),
                    Quantity(nudged.onset_wrap, "Pa"),
                )
                raise NotGrippableError(refusal.radius, reason, refusal.margin, None)
        if question.place is not None:
            raise refusal
        advice = "--find-place looks for a place near by where it is held"
        reason = joined("; ", (refusal.constraint, advice))
        raise NotGrippableError(refusal.radius, reason, refusal.margin, refusal.nearest_radius)
    for pressure in question.pressures:
        if pressure > window.top:
            end = Quantity(window.top if window.loss is None else window.loss, "Pa")
            asked = Quantity(pressure, "Pa")
            reason = Message("{} is too much: at {} {}", asked, end, window.end.value)
            radius = float(setup.obstacle.shape.feature_radius)
            raise NotGrippableError(radius, reason, window.top - pressure, None)
    return window, mark


def setup_of(question: GripQuestion) -> tuple[GripSetup, float | None]:
    """Return the setup, and the place on the profile's axis in the coil's middle [m]."""
    options: dict[str, Any] = {
        "friction": question.friction,
        "closing": Closing.FRICTIONLESS if question.frictionless else Closing.SLOW,
        "center": question.place,
    }
    if question.profile is None:
        return lay_into_coil(question.gripper, float(question.radius or 0.0), **options), None
    profile = read_profile(question.profile)
    setup = lay_profile_into_coil(question.gripper, profile, **options)
    shape = setup.obstacle.shape
    return setup, profile.start - (shape.heights[0] if isinstance(shape, Profile) else 0.0)
