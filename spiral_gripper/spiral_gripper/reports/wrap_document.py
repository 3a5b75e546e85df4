# SPDX-License-Identifier: Apache-2.0
"""Shapes and wraps: solved, and as tables of fields; object profiles from CSV."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.errors import InvalidInputError
from spiral_core.rod.solve import solve_rod
from spiral_core.rod.state import RodState
from spiral_core.validation import require_positive
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.placement import ObjectPlacement, place_object
from spiral_core.wrap.profile import ObjectProfile, ProfileWrap, wrap_for_profile
from spiral_core.wrap.wrap import Wrap, WrapRegime, line_force
from spiral_gripper.files.shown import shown, shown_range
from spiral_gripper.files.table import read_table
from spiral_gripper.files.units import Dimension
from spiral_gripper.reports.fields import Field, Json, data, plain

HEADER_REQUIREMENT = 'is missing: a profile has columns with units, "position [mm], radius [mm]"'
PROFILE_COLUMNS = MappingProxyType({"position": Dimension.LENGTH, "radius": Dimension.LENGTH})

ASSUMED = "the object lies in the free coil; no contact, no friction"


@dataclass(frozen=True, slots=True)
class SolvedShape:
    """A gripper at one pressure, coiled or not.

    Args:
        gripper: as it is mounted.
        pressure: gauge pressure [Pa].
        unloaded_shape: what it would be unloaded.
        state: its certified shape.
    """

    gripper: Gripper
    pressure: float
    unloaded_shape: UnloadedShape
    state: RodState


def solve_shape(gripper: Gripper, pressure: float) -> SolvedShape:
    """Return the shape of a gripper at a pressure [Pa].

    Raises:
        InvalidInputError: the pressure is not in [0, the gripper's ``pressure_max``].
        SolverError: the shape could not be certified.
    """
    rest = gripper.unloaded_shape(pressure)
    state = solve_rod(gripper.rod(rest), gripper.load(rest))
    return SolvedShape(gripper, pressure, rest, state)


@dataclass(frozen=True, slots=True)
class SolvedWrap:
    """A cylinder wrapped by the tip criterion: where the free coil fits it, without contact.

    Args:
        gripper: as it is mounted.
        radius: of the cylinder, as it was asked for [m].
        wrap: the free coil.
        placement: where the object lies, and how well the free coil fits it.
        snaps: pressures at which the tube snaps on the way to the wrap [Pa].
        radius_range: smallest and largest radius that the criterion knows [m].
        pressure: at which the regime is asked for [Pa], or None.
        regime: at that pressure, or None.
        line_force: normal force per length at that pressure [N/m], or None.
    """

    gripper: Gripper
    radius: float
    wrap: Wrap
    placement: ObjectPlacement
    snaps: tuple[float, ...]
    radius_range: tuple[float, float]
    pressure: float | None
    regime: WrapRegime | None
    line_force: float | None


@dataclass(frozen=True, slots=True)
class SolvedProfile:
    """An object of varying radius wrapped by the tip criterion.

    Args:
        gripper: as it is mounted.
        wrap: where and at what pressure.
        radius_range: smallest and largest radius that the criterion knows [m].
        state: the shape at that pressure.
    """

    gripper: Gripper
    wrap: ProfileWrap
    radius_range: tuple[float, float]
    state: RodState


def solve_wrap(gripper: Gripper, radius: float, pressure: float | None) -> SolvedWrap:
    """Return what the tip criterion says of a cylinder [m] and, if asked, of a pressure [Pa].

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
        shape, outer = gripper.unloaded_shape(pressure), gripper.tube.outer_radius
        force = line_force(gripper.stiffness, shape, radius, wrap.helix_angle, outer)
    snaps = tuple(snap for snap in curve.snap_pressures if snap < wrap.pressure)
    known = (curve.radius_min, curve.radius_max)
    return SolvedWrap(
        gripper, radius, wrap, place_object(wrap), snaps, known, pressure, regime, force
    )


def solve_profile(gripper: Gripper, path: Path) -> SolvedProfile:
    """Return what the tip criterion says of the object of a profile file.

    Raises:
        InvalidInputError: the file cannot be used.
        NotGrippableError: the object cannot be wrapped anywhere.
    """
    curve = WrapCurve(gripper)
    wrap = wrap_for_profile(curve, read_profile(path))
    known, state = (curve.radius_min, curve.radius_max), curve.state_at_pressure(wrap.pressure)
    return SolvedProfile(gripper, wrap, known, state)


def _line_force(solved: SolvedWrap) -> str | None:
    if solved.line_force is None or solved.regime is WrapRegime.OVERHANG:
        return None
    return shown(solved.line_force, "N/m")


SHAPE = (
    *data(gripper="gripper.name", pressure="pressure", gravity="gripper.gravity"),
    Field("", "tip (x, y, z)", lambda solved: tuple(solved.state.tip_position), "m"),
    Field("curvature", "curvature, torsion unloaded", "unloaded_shape.curvature", lambda solved: (
        f"{solved.unloaded_shape.curvature:.4g}, {solved.unloaded_shape.torsion:.4g} /m"
    )),
    Field("torsion", "", "unloaded_shape.torsion"),
    Field("stretch", "stretch", "unloaded_shape.stretch", "{:.5g}"),
    Field("backbone_length", "length", "unloaded_shape.backbone_length", "m"),
    Field("status", "", "state.status"),
    Field("stable", "stable", "state.stable", lambda solved: (
        "yes, certified" if solved.state.stable else "no"
    )),
    Field("discretization_error", "discretization error", "state.discretization_error", "m"),
    Field("folds", "folds passed on the way", "state.folds"),
    *data(
        arc_lengths="state.arc_lengths",
        positions="state.positions",
        orientations="state.orientations",
    ),
)  # fmt: skip
COIL = (
    Field("turns", "free coil's turns", "wrap.turns", lambda solved: (
        f"{solved.wrap.turns:.3g}, required {solved.gripper.turns_required:.3g}"
    )),
    Field("turns_required", "", "gripper.turns_required"),
    Field("gripper_length_needed", "  gripper length they need", "wrap.gripper_length_needed", "m"),
    Field("object_length_needed", "  object length they cover", "wrap.object_length_needed", "m"),
    Field("stretch", "  stretch", "wrap.unloaded_shape.stretch", "{:.5g}"),
    Field("snap_pressures", lambda solved: "tube snaps on the way at" if solved.snaps else "",
          "snaps", "Pa"),
    Field("stable", "", "wrap.state.stable"),
)  # fmt: skip
WRAP = (
    Field("gripper", "", "gripper.name"),
    Field("object_radius", "object radius", "radius", "m"),
    Field("pressure", "tip criterion", "wrap.pressure", "Pa"),
    Field("", "  it assumes", lambda _: ASSUMED, "{}"),
    *COIL,
    Field("object_center", "object's middle at (x, y, z)", "placement.center", "m"),
    Field("object_axis", "along", "placement.axis", "({:.3f}, {:.3f}, {:.3f})"),
    Field("largest_gap", "free coil off the object by up to", "placement.largest_gap", "m"),
    Field("radius_range", "radii it knows a pressure for", "radius_range", lambda solved: (
        shown_range(*solved.radius_range)
    )),
    Field("at_pressure", "", "pressure"),
    Field("regime", lambda solved: f"at {shown(solved.pressure or 0.0, 'Pa')}", "regime",
          lambda solved: solved.regime and solved.regime.value),
    Field("line_force", "normal force per length there", "line_force", _line_force),
)  # fmt: skip
COVERED = (
    Field("", "coil from, to", lambda solved: (solved.wrap.start, solved.wrap.end), "m"),
    Field("", "radii there", "wrap", lambda solved: (
        f"{shown(solved.wrap.radius_min, 'm')} to {shown(solved.wrap.radius_max, 'm')}"
    )),
)  # fmt: skip
PROFILE = (
    *COVERED,
    Field("", "tip criterion (of the thinnest place)", "wrap.pressure", "Pa"),
    Field("", "  it assumes", lambda _: ASSUMED, "{}"),
    Field("", "pressure of the mean radius", "wrap.pressure_of_mean", "Pa"),
    Field("", "pressure of the thickest place", "wrap.pressure_of_thickest", "Pa"),
    Field("", "", "wrap.stations", lambda solved: [
        (f"at {shown(s.position, 'm')}", f"radius {shown(s.radius, 'm')}: {s.regime.value}")
        for s in solved.wrap.stations[::5]
    ]),
)  # fmt: skip


def profile_as_dict(solved: SolvedProfile) -> Json:
    """Return a profile's wrap for programs, in SI."""
    return {
        "gripper": solved.gripper.name,
        **plain(solved.wrap),
        "radius_range": solved.radius_range,
    }


def read_profile(path: Path) -> ObjectProfile:
    """Return the object profile that a CSV file holds, its units in its header.

    Raises:
        TableError: it cannot be used; the error names every bad line and column.
        InvalidInputError: the positions do not increase, or the radii are no profile.
    """
    table = read_table(path, PROFILE_COLUMNS)
    for name in PROFILE_COLUMNS:
        if name not in table.columns:
            table.note(table.header_line, name, HEADER_REQUIREMENT)
            continue
        for row in table.rows:
            if name not in row.values:
                table.note(row.line, name, "is blank, but a profile requires it")
    table.raise_problems()
    positions, radii = ([row.values[name] for row in table.rows] for name in PROFILE_COLUMNS)
    try:
        return ObjectProfile(positions=positions, radii=radii)
    except InvalidInputError as error:
        name = {"positions": "position", "radii": "radius"}[error.field]
        written = ", ".join(row.texts[name].split()[0] for row in table.rows)
        column = f"{path}: {table.columns[name].heading}"
        raise InvalidInputError(column, written, error.requirement) from None
