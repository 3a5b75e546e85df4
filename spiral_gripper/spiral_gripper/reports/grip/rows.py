# SPDX-License-Identifier: Apache-2.0
"""A grip for people: rows of figures, and tables of forces against pressure."""

from __future__ import annotations

import math

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from spiral_core.grip.grip import PAYLOAD_SAFETY, Grip
from spiral_core.grip.holding import HoldingForce, Pull, is_twist
from spiral_core.grip.point import GripPoint
from spiral_core.rod.contact.shapes import Profile
from spiral_core.rod.types import Array
from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper.files.shown import axis_label, number, reworded, shown
from spiral_gripper.reports.grip.document import SolvedGrip, unit_of

# Where a pull is to, in few words.
_PULLS = {
    Pull.AWAY: "away from the base",
    Pull.TOWARDS: "towards the base",
    Pull.SIDEWAYS: "sideways",
    Pull.TWIST_LEFT: "twist, left-handed",
    Pull.TWIST_RIGHT: "twist, right-handed",
    Pull.DOWN: "along gravity",
}
# So many of them fit into a line of 80 characters, beside the contact and without it.
BESIDE_CONTACT = 2
IN_A_TABLE = 4


def grip_rows(solved: SolvedGrip) -> list[tuple[str, str]]:
    """Return the figures of a grip as names and texts."""
    grip, point = solved.grip, solved.point
    setup = grip.setup
    rows = [
        ("object radius", _radius(solved)),
        ("friction coefficient", f"{setup.obstacle.friction:.3g}"),
        ("how it closes", setup.closing.value),
        *_window_rows(solved),
    ]
    if solved.refusal is not None:
        rows.append(("NOT HELD", reworded(solved.refusal)))
    low, high = (shown(pressure, "Pa") for pressure in grip.recommended_range)
    rows += [
        ("recommended range", f"{low} to {high}: {grip.range_end.value}"),
        ("recommended pressure", _recommended(solved)),
        (f"at {shown(point.pressure, 'Pa')}", point.regime.value),
        ("  in contact", f"{shown(point.contact_length, 'm')}, {point.turns:.3g} turns"),
        ("  presses with", f"{shown(point.normal_force, 'N', 3)} in all"),
        ("  pressure on the object", f"up to about {shown(point.contact_pressure, 'Pa')}"),
        ("  mount carries", _reaction(point)),
    ]
    diameter = 2.0 * float(setup.obstacle.shape.feature_radius)
    rows += [(f"  holds {_PULLS[pull]}", _held(held, diameter)) for pull, held in _found(solved)]
    if solved.question.payload is not None:
        rows.append(_payload_row(solved, solved.question.payload))
    return [*rows, *_place_rows(solved)]


def _window_rows(solved: SolvedGrip) -> list[tuple[str, str]]:
    """Return what the rising pressure does."""
    window = solved.grip.window
    rows = [
        ("wrapped from", _against_tip(solved.grip)),
        ("end curls from", _or_not(window.onset_curling)),
    ]
    free = window.points[-1].regime is WrapRegime.OVERHANG
    if window.lift_off is not None:
        rest = "the tip hangs free from there on" if free else "the tip touches again above it"
        rows.append(("tip lifts off at", f"{shown(window.lift_off, 'Pa')}; {rest}"))
    end = f"{_or_not(window.loss)} ({window.end.value})"
    if window.loss is None and free:
        left = shown(window.points[-1].contact_length, "m")
        end = f"{end}; without a snap, {left} still in contact at {shown(window.top, 'Pa')}"
    rows.append(("lost at", end))
    if solved.rest is not None:
        rows.append(("  after that", _remaining(solved, solved.rest)))
    return rows


def print_forces(solved: SolvedGrip, console: Console) -> None:
    """Print contact and holding forces against pressure, a line for each pressure."""
    pulls = list(solved.grip.forces)
    groups = [pulls[:BESIDE_CONTACT]]
    rest = pulls[BESIDE_CONTACT:]
    groups += [rest[i : i + IN_A_TABLE] for i in range(0, len(rest), IN_A_TABLE)]
    for count, group in enumerate(groups):
        console.print(_force_table(solved.grip, group, contact=count == 0))
    found = [each for held in solved.grip.forces.values() for each in held]
    if any(each.is_lower_bound for each in found):
        ends = sorted({each.end.value for each in found if each.is_lower_bound})
        console.print(f">: at least; {'; or '.join(ends)}")
    if any(
        _is_driven(each) for each in [*found, *solved.held.values(), *solved.rest_held.values()]
    ):
        console.print(
            "0: the coil itself drives the object this way, and gives way before it holds"
        )
    if any(math.isnan(each.force) for each in found):
        console.print("?: not known, the first step of the pull could not be followed")


def _force_table(grip: Grip, pulls: list[Pull], *, contact: bool) -> Table:
    """Return some of the forces against pressure; regime and contact beside them, or not."""
    title = "holding force against pressure" if contact else None
    table = Table(title=title, title_justify="left")
    columns = [axis_label("pressure", "Pa")]
    if contact:
        columns += ["regime", axis_label("in contact", "m"), axis_label("presses with", "N")]
    columns += [axis_label(_PULLS[pull], unit_of(pull)) for pull in pulls]
    for column in columns:
        table.add_column(escape(column), justify="left" if column == "regime" else "right")
    for index, point in enumerate(grip.points):
        cells = [number(point.pressure, "Pa")]
        if contact:
            cells += [
                point.regime.value,
                number(point.contact_length, "m", 3),
                number(point.normal_force, "N", 3),
            ]
        table.add_row(*cells, *(_figure(grip.forces[pull][index]) for pull in pulls))
    return table


def _found(solved: SolvedGrip) -> list[tuple[Pull, HoldingForce]]:
    """Return what holds at the point shown, in the order asked."""
    return [(pull, solved.held[pull]) for pull in solved.grip.forces]


def _payload_row(solved: SolvedGrip, payload: float) -> tuple[str, str]:
    """Return how many times over a payload is held."""
    held = solved.held[Pull.DOWN]
    gravity = float(np.linalg.norm(solved.grip.setup.gripper.gravity))
    ratio = held.force / (payload * gravity)
    text = "not known" if math.isnan(ratio) else f"{_mark(held)}{ratio:.2f} x held"
    return f"  payload {shown(payload, 'kg')}", f"{text}, {PAYLOAD_SAFETY:g} wanted"


def _place_rows(solved: SolvedGrip) -> list[tuple[str, str]]:
    """Return where the object lies."""
    setup = solved.grip.setup
    name = "object's middle at (x, y, z)"
    if solved.mark is not None:
        name = f"object's {shown(solved.mark, 'm')} mark at (x, y, z)"
    return [
        (name, ", ".join(shown(x, "m") for x in setup.obstacle.position)),
        ("along", "({:.3f}, {:.3f}, {:.3f})".format(*setup.axis)),
    ]


def _radius(solved: SolvedGrip) -> str:
    """Return the object's radius, of a profile what it has along its length."""
    shape = solved.grip.setup.obstacle.shape
    if isinstance(shape, Profile):
        thin, thick = (shown(radius, "m") for radius in (min(shape.radii), max(shape.radii)))
        return f"{thin} to {thick} along its length"
    return shown(shape.feature_radius, "m")


def _or_not(pressure: float | None) -> str:
    return "no pressure" if pressure is None else shown(pressure, "Pa")


def _recommended(solved: SolvedGrip) -> str:
    """Return the pressure to command, and why it lies above the recommended range if it does."""
    pressure = solved.recommended
    if pressure is not None and pressure > solved.grip.recommended_range[1]:
        wanted = "greatest force" if solved.question.payload is None else "payload"
        return f"{shown(pressure, 'Pa')}, above that range for the {wanted}"
    return _or_not(pressure)


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
        f"{_mark(held)}{_value(held.force, pull)} {_PULLS[pull]}"
        for pull, held in solved.rest_held.items()
    )
    how = "still wrapped" if rest.is_wrapped else "the end has let go"
    return f"{how}; {shown(rest.contact_length, 'm')} of {before} in contact; holds {holds}"


def _held(held: HoldingForce, diameter: float) -> str:
    """Return what is held against a pull, where, and what within a diameter of the object."""
    if math.isnan(held.force):
        return f"not known: {held.end.value}"
    text = f"{_mark(held)}{_value(held.force, held.pull)}"
    if _is_driven(held):
        return f"{text}: the coil itself drives it this way"
    if is_twist(held.pull):
        return f"{text}, peak at {shown(held.displacement, 'rad')}"
    text = f"{text}, peak at {shown(held.displacement, 'm')}"
    if held.displacement > diameter * (1.0 + 1e-9):
        near = _value(held.within(diameter), held.pull)
        text = f"{text}; {near} within one diameter, {shown(diameter, 'm')}"
    return f"{text}; {shown(held.stiffness, 'N/m', 2)} at first"


def _is_driven(held: HoldingForce) -> bool:
    """Return whether the coil itself drives the object this way, and nothing holds it."""
    return held.force == 0.0 and float(held.forces.min()) < 0.0


def _figure(held: HoldingForce) -> str:
    if math.isnan(held.force):
        return "?"
    return f"{_mark(held)}{number(held.force, unit_of(held.pull), 3)}"


def _mark(held: HoldingForce) -> str:
    return "> " if held.is_lower_bound else ""


def _value(force: float, pull: Pull) -> str:
    return "not known" if math.isnan(force) else shown(force, unit_of(pull), 3)


def _size(vector: Array) -> float:
    return float(np.linalg.norm(vector))
