# SPDX-License-Identifier: Apache-2.0
"""A design as a table of fields, its report as plain data, and its gripper description file."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter

from spiral_core.actuator.actuator import Winding
from spiral_core.design.helix_estimate import GripFigures
from spiral_core.design.margin import Margin
from spiral_core.design.report import Design, DesignReport
from spiral_core.wrap.gripper import STANDARD_GRAVITY
from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper.files.description_text import changed_text, description_fields, put_fields
from spiral_gripper.files.fields import law_name
from spiral_gripper.files.shown import number, scale_of, shown, shown_message, shown_range
from spiral_gripper.reports.fields import Field, Json, Rows, data, document_of, plain

# No fiber is as thin as this pitch [m].
LEAST_PITCH = 1e-4


def report_as_dict(report: DesignReport) -> Json:
    """Return a whole report, in SI."""
    return {
        "feasible": report.feasible,
        "message": report.message,
        "binding": _margin(report.binding),
        "relaxations": plain(report.relaxations),
        "design": None if report.design is None else document_of(DESIGN, report.design),
        "steps": plain(report.steps),
        "candidates": report.candidates,
        "tried": [
            {
                "candidate": one.candidate.label,
                "feasible": one.feasible,
                "binding": _margin(one.binding),
            }
            for one in report.tried
        ],
    }


def description_text(design: Design, name: str) -> str:
    """Return a gripper description file for a design; ``docs/gripper_files.md`` has the format.

    Args:
        design: the gripper.
        name: of the gripper.
    """
    actuator, gripper, density = design.actuator, design.gripper, design.elastomer.density
    radii = (f"{1e3 * grip.radius:.4g} mm" for grip in (design.smallest, design.largest))
    fields = {
        "name": name,
        "description": f"designed for radii from {' to '.join(radii)}",
        **description_fields(actuator, gripper),
        "material.density": f"{density:.12g} kg/m^3",
        "model.pressure_law": actuator.pressure_law.value,
        "model.curvature_form": actuator.curvature_form.value,
    }
    extra = gripper.weight_per_length / STANDARD_GRAVITY - density * actuator.tube.wall_area
    if extra > 1e-12:
        fields["extra_mass_per_length"] = f"{extra!r} kg/m"
    root: dict[str, object] = {}
    put_fields(root, fields | {"name": name})
    sentence = shown_message(design.sentence)
    return f"# Written by spiral-gripper design: {sentence}.\n{changed_text(root)}"


def _margin(margin: Margin) -> Json:
    return _with(margin, unit="constraint.unit", room="room", relative="relative", met="is_met")


def _with(value: object, **names: str) -> Json:
    """Return a dataclass as plain data, with some of its properties, by key and dotted name."""
    return {**plain(value), **{key: attrgetter(name)(value) for key, name in names.items()}}


def _mm(length: float) -> str:
    return shown(length, "m")


def _material(design: Design) -> Json:
    elastomer = design.elastomer
    return {
        "name": elastomer.name,
        "law": law_name(type(elastomer.law)),
        **plain(elastomer.law),
        "density": elastomer.density,
        "pressure_law": elastomer.pressure_law.value,
    }


def _fiber_angles(design: Design) -> str:
    fibers = design.actuator.fiber_pair
    single = shown(design.fiber_angle, "rad") if design.fiber_angle else "straight"
    return f"{shown(fibers.alpha, 'rad')}, {shown(fibers.beta, 'rad')}, {single}"


def winding_rows_of(windings: Sequence[Winding]) -> Rows:
    """Return how each family is wound."""
    rows = []
    for w in windings:
        text = f"{w.hand}-handed, pitch {_mm(w.pitch)}, {w.turns:.1f} turns, "
        text += f"fiber {_mm(w.fiber_length)}"
        if w.pitch < LEAST_PITCH:
            text = "rings: too steep to be wound"
        rows.append((f"winding at {shown(w.angle, 'rad')}", text))
    return rows


def _placement_text(place: ObjectPlacement) -> str:
    center = ", ".join(number(x, "m") for x in place.center)
    along = ", ".join(f"{x:.3f}" for x in place.axis)
    gap = _mm(place.largest_gap)
    return f"({center}) {scale_of('m').unit} along ({along}); free coil up to {gap} off"


def _grip_text(grip: GripFigures) -> str:
    return (
        f"{shown(grip.pressure, 'Pa')}, strain {grip.strain:.4g}, {grip.turns:.3g} turns, "
        f"object length {_mm(grip.object_length)}"
    )


DESIGN = (
    Field("tube", "tube", "tube", lambda d: f"{d.tube.name}, {d.elastomer.name}"),
    Field("", "inner radius, wall", "tube", lambda d: (
        f"{_mm(d.tube.inner_radius)}, {_mm(d.tube.wall_thickness)}"
    )),
    Field("material", "", _material),
    Field("fiber_angle_alpha", "fiber angles", "actuator.fiber_pair.alpha", _fiber_angles),
    *data(fiber_angle_beta="actuator.fiber_pair.beta", fiber_angle_gamma="fiber_angle"),
    Field("length", "length (helix model)", "length", lambda d: (
        f"{_mm(d.length)} ({_mm(d.helix_length)})"
    )),
    Field("helix_length", "", "helix_length"),
    Field("cut_length", "cut length", "cut_length", "m"),
    Field("windings", "", lambda d: [_with(w, hand="hand") for w in d.windings],
          lambda d: winding_rows_of(d.windings)),
    *data(pressure_max="gripper.pressure_max", radius_min="radius_min", radius_max="radius_max"),
    Field("largest", lambda d: f"object of {_mm(d.largest.radius)}",
          lambda d: _with(d.largest, strain="strain"), lambda d: _grip_text(d.largest)),
    Field("smallest", lambda d: f"object of {_mm(d.smallest.radius)}",
          lambda d: _with(d.smallest, strain="strain"), lambda d: _grip_text(d.smallest)),
    Field("placements", "", "placements", lambda d: [
        (f"object of {_mm(place.radius)} lies at", _placement_text(place))
        for place in d.placements
    ]),
    Field("roll", "roll of the clamp", "roll", lambda d: (
        "arbitrary: gravity is along the tube" if d.roll is None
        else f"gravity {shown(d.roll, 'rad')} about the tube from the single fiber"
    )),
    Field("", "grips", "radius_max", lambda d: (
        f"{shown_range(d.radius_min, d.radius_max)} up to {shown(d.gripper.pressure_max, 'Pa')}"
    )),
    *data(
        curve=lambda d: [_with(point, strain="strain") for point in d.curve],
        margins=lambda d: [_margin(margin) for margin in d.margins],
    ),
)  # fmt: skip
POINT = data(
    tube="candidate.tube",
    material="candidate.elastomer.name",
    fiber_angle_beta="candidate.fiber_angle_beta",
    fiber_angle_gamma="candidate.fiber_angle_gamma",
    feasible="feasible",
    pressure="pressure",
    strain="strain",
    length="length",
    binding=lambda point: _margin(point.binding),
)
