# SPDX-License-Identifier: Apache-2.0
"""A grip as rows for people and as plain data for programs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from spiral_core.errors import NotGrippableError
from spiral_core.grip.grip import PAYLOAD_SAFETY, Grip, solve_grip
from spiral_core.grip.holding import HoldingForce, Pull, holding_force, is_twist
from spiral_core.grip.point import GripPoint
from spiral_core.grip.setup import Closing, GripSetup, lay_into_coil, lay_profile_into_coil
from spiral_core.grip.window import follow_loss
from spiral_core.rod.types import Array
from spiral_core.wrap.gripper import Gripper
from spiral_gripper.files.shown import axis_label, number, reworded, shown
from spiral_gripper.reports.design_document import plain
from spiral_gripper.reports.wrap_document import read_profile

# Short names of the directions of a pull.
_PULLS = {
    Pull.AWAY: "away from the base",
    Pull.TOWARDS: "towards the base",
    Pull.SIDEWAYS: "sideways",
    Pull.TWIST_LEFT: "twist, left-handed",
    Pull.TWIST_RIGHT: "twist, right-handed",
    Pull.DOWN: "along gravity",
}


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
    """

    gripper: Gripper
    radius: float | None
    profile: Path | None
    friction: float | None
    frictionless: bool
    every_direction: bool
    payload: float | None
    force_max: float | None

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
        point: the grip there, or at the middle of the recommended range.
        refusal: why no pressure meets the conditions, or None.
        rest: what remains of the grip after its loss; None if nothing was lost, or nothing rests.
        rest_forces: what the rest still holds, by the question's ways of moving the object.
    """

    question: GripQuestion
    grip: Grip
    recommended: float | None
    point: GripPoint
    refusal: str | None
    rest: GripPoint | None
    rest_forces: Mapping[Pull, float]


def solve_question(
    question: GripQuestion, progress: Callable[[int, int], None] | None = None
) -> SolvedGrip:
    """Return how a gripper holds an object.

    Raises:
        InvalidInputError: a value is out of its range, or the profile's file cannot be used.
        NotGrippableError: the object is not held at any pressure.
    """
    grip = solve_grip(_setup(question), question.pulls, progress=progress)
    refusal = recommended = None
    try:
        recommended = grip.recommended_pressure(question.payload, force_max=question.force_max)
    except NotGrippableError as error:
        refusal = error.constraint
    at = grip.recommended_pressure() if recommended is None else recommended
    rest = follow_loss(grip.window)
    held = {} if rest is None else {p: holding_force(rest, p).force for p in question.pulls}
    return SolvedGrip(question, grip, recommended, grip.window.at(at), refusal, rest, held)


def grip_rows(solved: SolvedGrip) -> list[tuple[str, str]]:
    """Return the figures of a grip as names and texts."""
    question, grip, point = solved.question, solved.grip, solved.point
    window, setup = grip.window, grip.setup
    rows = [
        ("object radius", shown(setup.obstacle.shape.feature_radius, "m")),
        ("friction coefficient", f"{setup.obstacle.friction:.3g}"),
        ("how it closes", setup.closing.value),
        ("wrapped from", _against_tip(grip)),
        ("end curls from", _or_not(window.onset_curling)),
        ("lost at", f"{_or_not(window.loss)} ({window.end.value})"),
    ]
    if solved.rest is not None:
        rows.append(("  after that", _remaining(solved, solved.rest)))
    if solved.refusal is not None:
        rows.append(("NOT HELD", reworded(solved.refusal)))
    rows += [
        ("recommended pressure", _or_not(solved.recommended)),
        (f"at {shown(point.pressure, 'Pa')}", point.regime.value),
        ("  in contact", f"{shown(point.contact_length, 'm')}, {point.turns:.3g} turns"),
        ("  presses with", f"{shown(point.normal_force, 'N', 3)} in all"),
        ("  pressure on the object", f"up to about {shown(point.contact_pressure, 'Pa')}"),
        ("  mount carries", _reaction(point)),
    ]
    rows += [(f"  holds {_PULLS[pull]}", _held(grip, pull, point.pressure)) for pull in grip.forces]
    if question.payload is not None:
        ratio = float(
            np.interp(point.pressure, grip.pressures, grip.payload_ratio(question.payload))
        )
        rows.append(
            (
                f"  payload {shown(question.payload, 'kg')}",
                f"{ratio:.2f} x held, {PAYLOAD_SAFETY:g} wanted",
            )
        )
    rows += [
        ("object's middle at (x, y, z)", ", ".join(shown(x, "m") for x in setup.obstacle.position)),
        ("along", "({:.3f}, {:.3f}, {:.3f})".format(*setup.axis)),
    ]
    return rows


def print_forces(solved: SolvedGrip, console: Console) -> None:
    """Print contact and holding forces against pressure, a line each."""
    grip = solved.grip
    table = Table(title="holding force against pressure", title_justify="left")
    columns = [axis_label("pressure", "Pa"), "regime", axis_label("in contact", "m")]
    columns += [axis_label("presses with", "N")]
    columns += [axis_label(_PULLS[pull], _unit(pull)) for pull in grip.forces]
    for column in columns:
        table.add_column(escape(column), justify="left" if column == "regime" else "right")
    for index, point in enumerate(grip.points):
        held = [_figure(grip.forces[pull][index]) for pull in grip.forces]
        table.add_row(
            number(point.pressure, "Pa"),
            point.regime.value,
            number(point.contact_length, "m", 3),
            number(point.normal_force, "N", 3),
            *held,
        )
    console.print(table)
    if any(each.is_lower_bound for found in grip.forces.values() for each in found):
        console.print(">: a lower bound, the force was still rising where the pull ended")


def grip_as_dict(solved: SolvedGrip) -> dict[str, Any]:
    """Return a grip for programs, in SI."""
    question, grip, point = solved.question, solved.grip, solved.point
    window, setup = grip.window, grip.setup
    names = {pull: _name(pull) for pull in grip.forces}
    document: dict[str, Any] = {
        "gripper": setup.gripper.name,
        "object_radius": setup.obstacle.shape.feature_radius,
        "object_center": list(setup.obstacle.position),
        "object_axis": setup.axis.tolist(),
        "friction": setup.obstacle.friction,
        "closing": setup.closing.name.lower(),
        "elements": setup.element_count,
        "tip_criterion": setup.tip_pressure,
        "onset_wrap": window.onset_wrap,
        "onset_curling": window.onset_curling,
        "loss": window.loss,
        "end": window.end.name.lower(),
        "after_loss": _after_loss(solved),
        "recommended_range": list(grip.recommended_range),
        "recommended_pressure": solved.recommended,
        "refusal": solved.refusal,
        "pressures": grip.pressures.tolist(),
        "contact_length": grip.contact_length.tolist(),
        "turns": [each.turns for each in grip.points],
        "normal_force": grip.normal_force.tolist(),
        "contact_pressure": grip.contact_pressure.tolist(),
        "base_reaction": [each.base_reaction.tolist() for each in grip.points],
        "at_recommended": {
            "pressure": point.pressure,
            "arc_length": point.state.arc_lengths.tolist(),
            "line_force": point.line_force.tolist(),
            "positions": point.state.positions.tolist(),
        },
    }
    for pull, name in names.items():
        document[name] = grip.force(pull).tolist()
        document[f"{name}_displacement"] = [each.displacement for each in grip.forces[pull]]
        document[f"{name}_stiffness"] = [each.stiffness for each in grip.forces[pull]]
        document[f"{name}_end"] = [each.end.name.lower() for each in grip.forces[pull]]
    if question.payload is not None:
        document["payload"] = question.payload
        document["payload_ratio"] = grip.payload_ratio(question.payload).tolist()
    checked: dict[str, Any] = plain(document)
    return checked


def _after_loss(solved: SolvedGrip) -> dict[str, float | bool] | None:
    """Return what is left of a grip after its loss, as plain data."""
    rest = solved.rest
    if rest is None:
        return None
    forces: dict[str, float] = {_name(pull): force for pull, force in solved.rest_forces.items()}
    return {
        "pressure": rest.pressure,
        "wrapped": rest.is_wrapped,
        "contact_length": rest.contact_length,
        "turns": rest.turns,
        "normal_force": rest.normal_force,
        **forces,
    }


def _setup(question: GripQuestion) -> GripSetup:
    closing = Closing.FRICTIONLESS if question.frictionless else Closing.SLOW
    if question.profile is not None:
        profile = read_profile(question.profile)
        return lay_profile_into_coil(
            question.gripper, profile, friction=question.friction, closing=closing
        )
    radius = float(question.radius or 0.0)
    return lay_into_coil(question.gripper, radius, friction=question.friction, closing=closing)


def _name(pull: Pull) -> str:
    """Return the key of what is held against a pull."""
    return f"holding_{'torque' if is_twist(pull) else 'force'}_{pull.name.lower()}"


def _or_not(pressure: float | None) -> str:
    return "no pressure" if pressure is None else shown(pressure, "Pa")


def _against_tip(grip: Grip) -> str:
    """Return the onset of the wrap, and how far the tip criterion is from it."""
    tip = grip.setup.tip_pressure
    text = shown(grip.onset_wrap, "Pa")
    if tip is None:
        return text
    percent = 100.0 * (grip.onset_wrap / tip - 1.0)
    return f"{text}, {percent:+.1f} % from the tip criterion's {shown(tip, 'Pa')}"


def _reaction(point: GripPoint) -> str:
    force, moment = point.base_reaction[:3], point.base_reaction[3:]
    return f"{shown(_size(force), 'N', 3)}, {shown(_size(moment), 'N m', 3)}"


def _remaining(solved: SolvedGrip, rest: GripPoint) -> str:
    """Return what is left of a grip after its loss."""
    before = shown(solved.grip.window.points[-1].contact_length, "m")
    holds = ", ".join(
        f"{shown(force, _unit(pull), 3)} {_PULLS[pull]}"
        for pull, force in solved.rest_forces.items()
    )
    how = "still wrapped" if rest.is_wrapped else "the end has let go"
    return f"{how}; {shown(rest.contact_length, 'm')} of {before} in contact; holds {holds}"


def _held(grip: Grip, pull: Pull, pressure: float) -> str:
    """Return what is held against a pull at a pressure, between those computed."""
    force = float(np.interp(pressure, grip.pressures, grip.force(pull)))
    nearest = grip.forces[pull][int(np.argmin(np.abs(grip.pressures - pressure)))]
    if is_twist(pull):
        return f"{shown(force, 'N m', 3)}, peak at {shown(nearest.displacement, 'rad')}"
    peak, stiffness = shown(nearest.displacement, "m"), shown(nearest.stiffness, "N/m", 2)
    return f"{shown(force, 'N', 3)}, peak at {peak}, {stiffness} at first"


def _figure(held: HoldingForce) -> str:
    mark = "> " if held.is_lower_bound else ""
    return f"{mark}{number(held.force, _unit(held.pull), 3)}"


def _unit(pull: Pull) -> str:
    """Return the SI unit of what is held against a pull."""
    return "N m" if is_twist(pull) else "N"


def _size(vector: Array) -> float:
    return float(np.linalg.norm(vector))
