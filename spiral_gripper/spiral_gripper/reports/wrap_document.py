# SPDX-License-Identifier: Apache-2.0
"""A wrap as rows for people and as plain data for programs; object profiles from CSV."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from spiral_core.errors import InvalidInputError
from spiral_core.rod.types import RodState
from spiral_core.validation import require_positive
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.placement import ObjectPlacement, place_object
from spiral_core.wrap.profile import ObjectProfile, ProfileWrap, wrap_for_profile
from spiral_core.wrap.wrap import Wrap, WrapRegime, line_force
from spiral_gripper.files.shown import shown, shown_range
from spiral_gripper.files.storage import read_text
from spiral_gripper.files.units import Dimension, parse_number, parse_quantity
from spiral_gripper.reports.design_document import plain

_HEADER = re.compile(r"\s*(?P<name>\w+)\s*\[(?P<unit>[^\]]+)\]\s*")
HEADER_REQUIREMENT = 'of columns with units, such as "position [mm], radius [mm]"'


@dataclass(frozen=True, slots=True)
class SolvedWrap:
    """A gripper around a cylinder.

    Args:
        gripper: as it is mounted.
        wrap: the perfect wrap.
        placement: where the object lies, and how well the free coil fits it.
        snaps: pressures at which the tube snaps on the way to the wrap [Pa].
        radius_range: smallest and largest radius that it grips [m].
        pressure: at which the regime is asked for [Pa], or None.
        regime: at that pressure, or None.
        line_force: normal force per length at that pressure [N/m], or None.
    """

    gripper: Gripper
    wrap: Wrap
    placement: ObjectPlacement
    snaps: tuple[float, ...]
    radius_range: tuple[float, float]
    pressure: float | None
    regime: WrapRegime | None
    line_force: float | None


@dataclass(frozen=True, slots=True)
class SolvedProfile:
    """A gripper around an object of varying radius.

    Args:
        gripper: as it is mounted.
        wrap: where and at what pressure.
        radius_range: smallest and largest radius that it grips [m].
        state: the shape at that pressure.
    """

    gripper: Gripper
    wrap: ProfileWrap
    radius_range: tuple[float, float]
    state: RodState


def solve_wrap(gripper: Gripper, radius: float, pressure: float | None) -> SolvedWrap:
    """Return the perfect wrap of a cylinder [m] and, if asked, how a pressure [Pa] holds it.

    Raises:
        InvalidInputError: a value is out of its range.
        NotGrippableError: the radius is outside the grippable range.
    """
    require_positive("radius", radius)  # before anything is compiled
    curve = WrapCurve(gripper)
    wrap = curve.wrap_for_radius(radius)
    regime = force = None
    if pressure is not None:
        regime = curve.regime(pressure, radius)
        force = line_force(
            gripper.stiffness,
            gripper.unloaded_shape(pressure),
            radius,
            wrap.helix_angle,
            gripper.tube.outer_radius,
        )
    return SolvedWrap(
        gripper,
        wrap,
        place_object(wrap),
        tuple(snap for snap in curve.snap_pressures if snap < wrap.pressure),
        (curve.radius_min, curve.radius_max),
        pressure,
        regime,
        force,
    )


def solve_profile(gripper: Gripper, path: Path) -> SolvedProfile:
    """Return how a gripper wraps the object of a profile file.

    Raises:
        InvalidInputError: the file cannot be used.
        NotGrippableError: the object cannot be wrapped anywhere.
    """
    curve = WrapCurve(gripper)
    wrap = wrap_for_profile(curve, read_profile(path))
    state = curve.state_at_pressure(wrap.pressure)
    return SolvedProfile(gripper, wrap, (curve.radius_min, curve.radius_max), state)


def wrap_rows(solved: SolvedWrap) -> list[tuple[str, str]]:
    """Return the figures of a wrap as names and texts."""
    wrap, placement = solved.wrap, solved.placement
    rows = [
        ("object radius", shown(wrap.object_radius, "m")),
        ("pressure of the perfect wrap", shown(wrap.pressure, "Pa")),
        ("turns", f"{wrap.turns:.3g}, required {solved.gripper.turns_required:.3g}"),
        ("gripper length they need", _length(wrap.gripper_length_needed)),
        ("object length they cover", _length(wrap.object_length_needed)),
        (
            "stretch",
            "" if wrap.unloaded_shape.stretch is None else f"{wrap.unloaded_shape.stretch:.5g}",
        ),
        ("object's middle at (x, y, z)", ", ".join(shown(x, "m") for x in placement.center)),
        ("along", "({:.3f}, {:.3f}, {:.3f})".format(*placement.axis)),
        ("free coil off the object by up to", shown(placement.largest_gap, "m")),
        ("grips radii", shown_range(*solved.radius_range)),
        ("stable", "yes, certified" if wrap.state.stable else "no"),
    ]
    if solved.snaps:
        rows.append(("tube snaps on the way at", ", ".join(shown(p, "Pa") for p in solved.snaps)))
    if solved.pressure is not None and solved.regime is not None:
        rows.append((f"at {shown(solved.pressure, 'Pa')}", solved.regime.value))
        if solved.regime is not WrapRegime.OVERHANG and solved.line_force is not None:
            rows.append(("normal force per length there", shown(solved.line_force, "N/m")))
    return rows


def wrap_as_dict(solved: SolvedWrap) -> dict[str, Any]:
    """Return a wrap for programs, in SI."""
    wrap = solved.wrap
    return {
        "gripper": solved.gripper.name,
        "object_radius": wrap.object_radius,
        "pressure": wrap.pressure,
        "turns": wrap.turns,
        "turns_required": solved.gripper.turns_required,
        "gripper_length_needed": wrap.gripper_length_needed,
        "object_length_needed": wrap.object_length_needed,
        "stretch": wrap.unloaded_shape.stretch,
        "object_axis": list(solved.placement.axis),
        "object_center": list(solved.placement.center),
        "largest_gap": solved.placement.largest_gap,
        "snap_pressures": list(solved.snaps),
        "radius_range": list(solved.radius_range),
        "stable": wrap.state.stable,
        "at_pressure": solved.pressure,
        "regime": plain(solved.regime),
        "line_force": solved.line_force,
    }


def profile_rows(solved: SolvedProfile) -> list[tuple[str, str]]:
    """Return the figures of a profile's wrap as names and texts."""
    wrap = solved.wrap
    rows = [
        ("coil from, to", f"{shown(wrap.start, 'm')}, {shown(wrap.end, 'm')}"),
        ("radii there", f"{shown(wrap.radius_min, 'm')} to {shown(wrap.radius_max, 'm')}"),
        ("pressure (of the thinnest place)", shown(wrap.pressure, "Pa")),
        ("pressure of the mean radius", shown(wrap.pressure_of_mean, "Pa")),
        ("pressure of the thickest place", shown(wrap.pressure_of_thickest, "Pa")),
    ]
    rows += [
        (f"at {shown(s.position, 'm')}", f"radius {shown(s.radius, 'm')}: {s.regime.value}")
        for s in wrap.stations[::5]
    ]
    return rows


def profile_as_dict(solved: SolvedProfile) -> dict[str, Any]:
    """Return a profile's wrap for programs, in SI."""
    return {
        "gripper": solved.gripper.name,
        **plain(solved.wrap),
        "radius_range": list(solved.radius_range),
    }


def read_profile(path: Path) -> ObjectProfile:
    """Return the object profile that a CSV file holds, its units in its header.

    Raises:
        FileError: it cannot be read.
        InvalidInputError: it is no CSV text, the header has no units, or a line has no two numbers.
    """
    try:
        lines = csv.reader(read_text(path).splitlines())
        rows = [row for row in lines if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise InvalidInputError(str(path), str(error), "a CSV file") from None
    scales = _scales(rows[0] if rows else [], path)
    columns: list[list[float]] = [[], []]
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != 2:
            raise InvalidInputError(f"{path}: row {number}", ", ".join(row), "two numbers")
        for column, cell, scale in zip(columns, row, scales, strict=True):
            column.append(scale * parse_number(cell.strip()))
    try:
        return ObjectProfile(positions=columns[0], radii=columns[1])
    except InvalidInputError as error:
        place = ("positions", "radii").index(error.field)
        written = ", ".join(row[place].strip() for row in rows[1:])
        name = f"{path}: {rows[0][place].strip()}"
        raise InvalidInputError(name, written, error.requirement) from None


def _scales(header: list[str], path: Path) -> tuple[float, float]:
    """Return the SI values of the two columns' units."""
    matches = [_HEADER.fullmatch(cell) for cell in header]
    found = [(m["name"].lower(), m["unit"]) for m in matches if m is not None]
    if [name for name, _ in found] != ["position", "radius"]:
        raise InvalidInputError(f"{path}: header", ", ".join(header), HEADER_REQUIREMENT)
    position, radius = (parse_quantity(f"1 {unit}", Dimension.LENGTH) for _, unit in found)
    return position, radius


def _length(value: float | None) -> str:
    return "" if value is None else shown(value, "m")
