# SPDX-License-Identifier: Apache-2.0
"""Approaches as rows for people, as data for programs, and as a picture from the side."""

from __future__ import annotations

import math
from typing import Any

from rich.console import Console
from rich.markup import escape

from spiral_core.grip.approach import (
    Approach,
    ApproachAnswer,
    ApproachTask,
    BasePose,
    base_rotation,
)
from spiral_core.rod.types import Array
from spiral_core.rounding import rounded_down
from spiral_gripper.files.shown import shown, shown_message
from spiral_gripper.reports.fields import Field, document_of, rows_of
from spiral_gripper.reports.grip.capture import CAPTURE
from spiral_gripper.reports.grip.rows import falls_by_choice
from spiral_gripper.reports.tables import row_table

# Reasons of refusals that are printed.
MOST_REASONS = 4


def _vector(values: Any) -> str:  # noqa: ANN401
    return " ".join(f"{value:+.3f}" for value in values)


def _tube(approach: Approach) -> Array:
    """Return the direction of the tube at the base, in the world."""
    return _direction(approach.task, approach.pose)


def _direction(task: ApproachTask, pose: BasePose) -> Array:
    return base_rotation(task, pose).as_matrix()[:, 0]


def _ratio(approach: Approach) -> float | None:
    task = approach.task
    if task.payload is None:
        return None
    return approach.found.force / (task.payload * math.hypot(*task.gravity))


def _holds(approach: Approach) -> str:
    """Return the holding force, and how often it carries the payload."""
    ratio = _ratio(approach)
    times = "" if ratio is None else f", {ratio:.3g} times the payload"
    return f"{shown(approach.found.force, 'N', 3, rounded_down)} along gravity{times}"


def _errors(approach: Approach) -> str | None:
    """Return the errors of the pose that are safe; None in a coarse answer."""
    if approach.region is None:
        return None
    size = shown(approach.found.size, "m", 2, rounded_down)
    return f"{size} in all, a degree counted as a millimeter"


APPROACH = (
    Field("tube_direction", "tube at the base, world", _tube, lambda each: _vector(_tube(each))),
    Field("position", "base from the object's middle, world", "position", "m"),
    Field(
        "orientation",
        "base in the world, quaternion x y z w",
        "orientation",
        lambda approach: _vector(approach.orientation),
    ),
    Field("pressure", "recommended pressure", "found.pressure", "Pa"),
    Field("force", "holds", "found.force", _holds),
    Field("payload_ratio", "", _ratio),
    Field("regime", "at that pressure", "point.regime", "{.value}"),
    falls_by_choice("point.setup"),
    Field(
        "capture_size",
        "errors of the pose",
        lambda approach: None if approach.region is None else approach.found.size,
        _errors,
    ),
    Field(
        "capture",
        "",
        lambda approach: approach.region and document_of(CAPTURE, approach.region),
    ),
)


def answer_as_dict(answer: ApproachAnswer) -> dict[str, Any]:
    """Return an answer for programs, in SI."""
    return {
        "object_axis": answer.task.axis,
        "gravity": answer.task.gravity,
        "poses_tried": len(answer.tried),
        "poses_gripping": answer.gripping,
        "approaches": [document_of(APPROACH, each) for each in answer.approaches],
        "reasons": dict(answer.reasons),
    }


def print_answer(answer: ApproachAnswer, console: Console) -> None:
    """Print a table for each approach; where there is none, why, and the nearest pose."""
    name, count = answer.task.gripper.name, len(answer.tried)
    for number, approach in enumerate(answer.approaches, start=1):
        console.print(row_table(f"{name}, approach {number}", rows_of(APPROACH, approach)))
    console.print(f"{answer.gripping} of {count} poses tried grip", highlight=False)
    if answer.approaches:
        return
    for reason, times in answer.reasons.most_common(MOST_REASONS):
        console.print(escape(f"{times} x {shown_message(reason)}"), highlight=False)
    if math.isinf(answer.tried[answer.nearest].missing):  # no tube came near
        return
    tube = _vector(_direction(answer.task, answer.nearest))
    console.print(f"the nearest: with the tube at the base along {tube}", highlight=False)
