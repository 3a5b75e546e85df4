# SPDX-License-Identifier: Apache-2.0
"""A grip as a table of fields, and tables of its forces against pressure."""

from __future__ import annotations

import math
from operator import attrgetter

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from spiral_core.grip.grip import PAYLOAD_SAFETY, Grip
from spiral_core.grip.holding import HoldingForce, Pull, is_twist
from spiral_core.grip.window import NUDGE
from spiral_core.rod.contact.shapes import Profile
from spiral_core.rod.types import Array
from spiral_core.rounding import signed_percent
from spiral_core.wrap.placement import distances_from_axis, touching_nodes
from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper.files.shown import axis_label, number, shown, shown_message
from spiral_gripper.reports.fields import Field, Json, Rows, data, document_of, rows_of
from spiral_gripper.reports.grip.document import SolvedGrip
from spiral_gripper.reports.wrap_document import (
    COIL,
    COVERED,
    PROFILE,
    WRAP,
    SolvedProfile,
    SolvedWrap,
    profile_as_dict,
)

# Where a pull is to, in few words.
PULLS = {
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
# Ends of windows that differ by less than this fraction are printed as one.
SAME = 1e-3
# Ends of a window, and what they are called.
ENDS = {"onset_wrap": "wrapped from", "onset_curling": "curls from", "loss": "lost at"}


def wrap_rows(free: SolvedWrap | SolvedProfile, closed: SolvedGrip | None) -> Rows:
    """Return the figures of a wrap as names and texts.

    Args:
        free: what the tip criterion says.
        closed: what contact says; None where only the tip criterion was wanted.
    """
    if closed is not None:
        coil = COIL if isinstance(free, SolvedWrap) else COVERED
        return rows_of(WRAPPED, closed) + rows_of(coil, free)
    return rows_of(WRAP if isinstance(free, SolvedWrap) else PROFILE, free)


def wrap_as_dict(free: SolvedWrap | SolvedProfile, closed: SolvedGrip | None) -> Json:
    """Return a wrap for programs, in SI: the free coil's figures, and over them those of contact.

    ``largest_gap`` is that of the free coil to the object in its place.
    """
    of_contact = {} if closed is None else document_of(WRAPPED, closed)
    if isinstance(free, SolvedProfile):
        return profile_as_dict(free) | of_contact
    if closed is not None:
        setup, wrap = closed.grip.setup, free.wrap
        touching = touching_nodes(wrap, wrap.turns_required)
        distances = distances_from_axis(touching, setup.obstacle.position, setup.axis)
        of_contact["largest_gap"] = float(np.abs(distances - free.radius - wrap.outer_radius).max())
    return document_of(WRAP, free) | of_contact


def print_forces(solved: SolvedGrip, console: Console) -> None:
    """Print contact and holding forces against pressure, a line for each pressure."""
    grip, pulls = solved.grip, list(solved.grip.forces)
    console.print(_force_table(grip, pulls[:BESIDE_CONTACT], contact=True))
    for first in range(BESIDE_CONTACT, len(pulls), IN_A_TABLE):
        console.print(_force_table(grip, pulls[first : first + IN_A_TABLE], contact=False))
    found = [each for held in grip.forces.values() for each in held]
    ends = sorted({each.end.value for each in found if each.is_lower_bound})
    if ends:
        console.print(f">: at least; {'; or '.join(ends)}")
    if any(map(_is_driven, (*found, *solved.held.values(), *solved.rest_held.values()))):
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
    for column in [*columns, *(axis_label(PULLS[pull], unit_of(pull)) for pull in pulls)]:
        table.add_column(escape(column), justify="left" if column == "regime" else "right")
    for index, point in enumerate(grip.points):
        length, force = number(point.contact_length, "m", 3), number(point.normal_force, "N", 3)
        table.add_row(
            number(point.pressure, "Pa"),
            *((point.regime.value, length, force) if contact else ()),
            *(_figure(grip.forces[pull][index]) for pull in pulls),
        )
    return table


def _holds(solved: SolvedGrip) -> Rows:
    """Return what is held against each pull, and how many times over a payload."""
    setup, payload = solved.grip.setup, solved.question.payload
    diameter = 2.0 * float(setup.obstacle.shape.feature_radius)
    rows = [
        (f"  holds {PULLS[pull]}", _held(solved.held[pull], diameter))
        for pull in solved.grip.forces
    ]
    if payload is not None:
        held = solved.held[Pull.DOWN]
        ratio = held.force / (payload * _size(np.array(setup.gripper.gravity)))
        text = "not known" if math.isnan(ratio) else f"{_mark(held)}{ratio:.2f} x held"
        rows.append((f"  payload {shown(payload, 'kg')}", f"{text}, {PAYLOAD_SAFETY:g} wanted"))
    return rows


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


def _against_tip(solved: SolvedGrip) -> str:
    """Return the onset of the wrap, and how far the tip criterion is from it."""
    grip = solved.grip
    tip, text = grip.setup.tip_pressure, shown(grip.onset_wrap, "Pa")
    if tip is None:
        return text
    percent = signed_percent(grip.onset_wrap / tip - 1.0)
    other = "tip criterion's" if grip.setup.gripper.object_axis is None else "free coil's"
    return f"{text}, {percent} from the {other} {shown(tip, 'Pa')}"


def _remaining(solved: SolvedGrip) -> str | None:
    """Return what is left of a grip after its loss."""
    rest = solved.rest
    if rest is None:
        return None
    before = shown(solved.grip.window.points[-1].contact_length, "m")
    holds = ", ".join(
        f"{_mark(held)}{_value(held.force, pull)} {PULLS[pull]}"
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
    twist = is_twist(held.pull)
    text = f"{text}, peak at {shown(held.displacement, 'rad' if twist else 'm')}"
    if twist:
        return text
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


def _name(pull: Pull) -> str:
    """Return the key of what is held against a pull."""
    return f"holding_{'torque' if is_twist(pull) else 'force'}_{pull.name.lower()}"


def unit_of(pull: Pull) -> str:
    """Return the SI unit of what is held against a pull."""
    return "N m" if is_twist(pull) else "N"


def grip_as_dict(solved: SolvedGrip) -> Json:
    """Return a grip for programs, in SI."""
    grip, point, payload = solved.grip, solved.point, solved.question.payload
    diameter = 2.0 * float(grip.setup.obstacle.shape.feature_radius)
    document: Json = document_of(GRIP, solved)
    document["at_pressure"] = {
        "pressure": point.pressure,
        "arc_length": point.state.arc_lengths,
        "line_force": point.line_force,
        "positions": point.state.positions,
        **{_name(pull): solved.held[pull].force for pull in grip.forces},
    }
    if solved.mark is not None:
        document["profile_position"] = solved.mark
    for pull, found in grip.forces.items():
        name = _name(pull)
        document[name] = [each.force for each in found]
        for figure in ("displacement", "stiffness", "end", "is_lower_bound"):
            document[f"{name}_{figure}"] = [getattr(each, figure) for each in found]
        if not is_twist(pull):
            document[f"{name}_within_diameter"] = [each.within(diameter) for each in found]
    if payload is not None:
        document |= {"payload": payload, "payload_ratio": grip.payload_ratio(payload)}
    return document


def _after_loss(solved: SolvedGrip) -> dict[str, float | bool] | None:
    """Return what is left of a grip after its loss, as plain data."""
    rest = solved.rest
    if rest is None:
        return None
    return {
        "pressure": rest.pressure,
        "wrapped": rest.is_wrapped,
        "contact_length": rest.contact_length,
        "turns": rest.turns,
        "normal_force": rest.normal_force,
        **{_name(pull): held.force for pull, held in solved.rest_held.items()},
    }


def _lift_off(solved: SolvedGrip) -> str | None:
    """Return where the tip lifts off, and what follows."""
    window = solved.grip.window
    free = window.points[-1].regime is WrapRegime.OVERHANG
    rest = "the tip hangs free from there on" if free else "the tip touches again above it"
    return None if window.lift_off is None else f"{shown(window.lift_off, 'Pa')}; {rest}"


def _lost(solved: SolvedGrip) -> str:
    """Return where the grip is lost."""
    window = solved.grip.window
    end = f"{_or_not(window.loss)} ({window.end.value})"
    if window.loss_above is not None:
        end = f"{shown(window.loss_above, 'Pa')}, above {window.end.value}"
    if window.loss is None and window.points[-1].regime is WrapRegime.OVERHANG:
        left = shown(window.points[-1].contact_length, "m")
        return f"{end}; without a snap, {left} still in contact at {shown(window.top, 'Pa')}"
    return end


def _spread(solved: SolvedGrip) -> dict[str, list[float | None]] | None:
    """Return each end of the window as it is and with the object moved aside; None: not asked."""
    windows = (solved.grip.window, *solved.nudged)
    return {end: [getattr(one, end) for one in windows] for end in ENDS} if solved.nudged else None


def _spread_text(solved: SolvedGrip) -> str | None:
    """Return how far each end of the window scatters."""
    found, texts = _spread(solved), []
    for end, values in (found or {}).items():
        known = [value for value in values if value is not None]
        if not known:
            continue
        text = f"{ENDS[end]} {shown(min(known), 'Pa')}"
        if max(known) > (1.0 + SAME) * min(known):
            text += f" to {shown(max(known), 'Pa')}"
        texts.append(text if len(known) == len(values) else f"{text} or not at all")
    return None if found is None else "; ".join(texts)


def falls_by_choice(setup: str) -> Field:
    """Return the row of an upright tube, which may fall to any side, by where its setup is."""
    text = "may fall to any side: here to the one to which it bends"
    return Field(
        "falls_by_choice",
        "upright, without pressure",
        f"{setup}.falls_by_choice",
        lambda solved: text if attrgetter(setup)(solved).falls_by_choice else None,
    )


# Parts of the tables of a grip and of a wrap.
_CLOSED = (
    Field("gripper", "", "grip.setup.gripper.name"),
    Field("object_radius", "object radius", "grip.setup.obstacle.shape.feature_radius", _radius),
    Field("friction", "friction coefficient", "grip.setup.obstacle.friction"),
    Field("closing", "how it closes", "grip.setup.closing", "{.value}"),
    falls_by_choice("grip.setup"),
    *data(elements="grip.setup.element_count", tip_criterion="grip.setup.tip_pressure"),
    Field("onset_wrap", "wrapped from", "grip.window.onset_wrap", _against_tip),
    Field("onset_curling", "end curls from", "grip.window.onset_curling",
          lambda s: _or_not(s.grip.window.onset_curling)),
    Field("lift_off", "tip lifts off at", "grip.window.lift_off", _lift_off),
    Field("loss", "lost at", "grip.window.loss", _lost),
    Field("end", "", "grip.window.end"),
    *data(loss_above="grip.window.loss_above"),
)  # fmt: skip
_RECOMMENDED = (
    Field("recommended_range", "recommended range", "grip.recommended_range", lambda s: " to ".join(
        shown(end, "Pa") for end in s.grip.recommended_range) + f": {s.grip.range_end.value}"),
    Field("range_end", "", "grip.range_end"),
    Field("recommended_pressure", "recommended pressure", "recommended", _recommended),
)  # fmt: skip
_AT = (
    Field("", lambda s: f"at {shown(s.point.pressure, 'Pa')}", "point.regime", "{.value}"),
    Field("", "  in contact", "point",
          lambda s: f"{shown(s.point.contact_length, 'm')}, {s.point.turns:.3g} turns"),
    Field("", "  presses with", "point",
          lambda s: f"{shown(s.point.normal_force, 'N', 3)} in all"),
    Field("", "  pressure on the object", "point",
          lambda s: f"up to about {shown(s.point.contact_pressure, 'Pa')}"),
)  # fmt: skip
_PLACE = (
    Field("object_center", lambda s: (
        f"object's {'middle' if s.mark is None else shown(s.mark, 'm') + ' mark'} at (x, y, z)"
    ), "grip.setup.obstacle.position", "m"),
    Field("object_axis", "along", "grip.setup.axis", "({:.3f}, {:.3f}, {:.3f})"),
    Field("object_orientation", "", "grip.setup.obstacle.orientation"),
)  # fmt: skip
GRIP = (
    *_CLOSED,
    Field("after_loss", "  after that", _after_loss, _remaining),
    Field("spread", lambda s: (
        f"moved aside by {shown(NUDGE * s.question.gripper.tube.length, 'm', 1)}"
    ), _spread, _spread_text),
    Field("refusal", "NOT HELD", "refusal", lambda s: s.refusal and shown_message(s.refusal)),
    *_RECOMMENDED,
    *data(
        pressures="grip.pressures",
        contact_length="grip.contact_length",
        turns=lambda s: [each.turns for each in s.grip.points],
        normal_force="grip.normal_force",
        contact_pressure="grip.contact_pressure",
        base_reaction=lambda s: [each.base_reaction for each in s.grip.points],
    ),
    *_AT,
    Field("", "  mount carries", "point.base_reaction", lambda s: (
        f"{shown(_size(s.point.base_reaction[:3]), 'N', 3)}, "
        f"{shown(_size(s.point.base_reaction[3:]), 'N m', 3)}"
    )),
    Field("", "", "held", _holds),
    *_PLACE,
)  # fmt: skip
# A wrap without the forces that it holds; ``pressure`` is that of the perfect wrap.
WRAPPED = (
    Field("gripped", "gripped", lambda _: True, lambda _: "yes"),
    *_CLOSED,
    *_RECOMMENDED,
    *data(
        pressure="grip.onset_wrap",
        at_pressure="point.pressure",
        regime="point.regime",
        stable="point.state.stable",
        line_force=lambda s: (
        s.point.normal_force / s.point.contact_length if s.point.contact_length > 0.0 else None
    ),
    ),
    *_AT,
    *_PLACE,
)  # fmt: skip
