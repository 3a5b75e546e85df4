# SPDX-License-Identifier: Apache-2.0
"""A region of capture as rows for people and as data for programs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from spiral_core.grip.capture import Boundary, CaptureOutcome, CaptureRegion
from spiral_core.rounding import rounded_down, rounded_up
from spiral_gripper.files.shown import shown
from spiral_gripper.reports.fields import Field, Rows
from spiral_gripper.reports.grip.rows import falls_by_choice

# What limits the region, in few words.
BEYOND = {
    CaptureOutcome.HOLDS: "not looked further",
    CaptureOutcome.TOO_WEAK: "too weak",
    CaptureOutcome.PASSES_BY: "passes by",
    CaptureOutcome.IN_THE_WAY: "in the way",
    CaptureOutcome.NOT_ANSWERED: "not answered",
}
# The components of a misplacement: key, name and unit.
COMPONENTS = (
    ("away", "shift away from the base", "m"),
    ("across", "shift across", "m"),
    ("tilt_away", "tilt about away", "rad"),
    ("tilt_across", "tilt about across", "rad"),
    ("radius", "error of the radius", "m"),
)


def limit_texts(region: CaptureRegion) -> list[str]:
    """Return the largest safe error in each direction, with what limits it."""
    rounding = (rounded_up, rounded_down)
    return [
        " to ".join(
            f"{shown(limit, unit, 3, rounds)} ({BEYOND[boundary.beyond]})"
            for limit, boundary, rounds in zip(limits, boundaries, rounding, strict=True)
        )
        for (_, _, unit), limits, boundaries in zip(
            COMPONENTS, region.limits.tolist(), region.axes, strict=True
        )
    ]


def ball_text(region: CaptureRegion) -> str:
    """Return the semi-axes of the ellipsoid in which all errors at once are safe."""
    sizes = zip(region.semi_axes.tolist(), COMPONENTS, strict=True)
    axes = ", ".join(shown(size, unit, 3, rounded_down) for size, (_, _, unit) in sizes)
    return f"within an ellipsoid of {axes} ({BEYOND[region.ball_beyond]})"


def _rows(region: CaptureRegion) -> Rows:
    """Return a row for each direction, and one for all of them."""
    if not region.axes:
        return []
    names = [name for _, name, _ in COMPONENTS]
    return [*zip(names, limit_texts(region), strict=True), ("all at once", ball_text(region))]


def _outline(region: CaptureRegion, boundaries: Sequence[Boundary]) -> list[dict[str, Any]]:
    """Return an outline for programs."""
    places = region.outline(boundaries)
    return [
        {"misplacement": place, "beyond": boundary.beyond}
        for place, boundary in zip(places, boundaries, strict=True)
    ]


CAPTURE = (
    Field("pressure", "closes up to", "pressure", "Pa"),
    Field(
        "payload",
        "payload",
        "payload",
        lambda region: None if region.payload is None else shown(region.payload, "kg"),
    ),
    Field("friction", "friction", "setup.obstacle.friction"),
    falls_by_choice("setup"),
    Field("center", "in its place", "center", lambda region: region.center.value),
    Field(
        "limits",
        "",
        lambda region: {
            key: list(pair)
            for (key, _, _), pair in zip(COMPONENTS, region.limits.tolist(), strict=True)
        },
        _rows,
    ),
    Field(
        "beyond",
        "",
        lambda region: {
            key: [boundary.beyond for boundary in pair]
            for (key, _, _), pair in zip(COMPONENTS, region.axes, strict=False)
        },
    ),
    Field("reach", "", "reach"),
    Field("semi_axes", "", "semi_axes"),
    Field("ball", "", "ball"),
    Field("shifts", "", lambda region: _outline(region, region.shifts)),
    Field("tilts", "", lambda region: _outline(region, region.tilts)),
    Field("closings", "closings", "closings"),
)
