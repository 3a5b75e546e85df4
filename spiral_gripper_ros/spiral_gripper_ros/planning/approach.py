# SPDX-License-Identifier: Apache-2.0
"""The search for approaches in a worker process, and how far it is. No ROS."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from tempfile import NamedTemporaryFile

import numpy as np

from spiral_core.rod.contact.obstacles import Quaternion
from spiral_core.rod.types import Vector
from spiral_core.wrap.gripper import Gripper
from spiral_gripper_ros.planning.worker import Worker


@dataclass(frozen=True, slots=True)
class ApproachQuestion:
    """What a search is asked; see :class:`spiral_core.ApproachTask`.

    Args:
        gripper: with its friction.
        radius: of the cylinder [m].
        object_axis: direction of its axis in the world.
        gravity: in the world [m/s^2].
        payload: mass of the object [kg]; None: not stated.
        tilt_max: of the tube at the base [rad]; None: any.
        regions: whether regions of capture are computed too.
    """

    gripper: Gripper
    radius: float
    object_axis: Vector
    gravity: Vector
    payload: float | None
    tilt_max: float | None
    regions: bool


@dataclass(frozen=True, slots=True)
class FoundApproach:
    """A base pose that grips.

    Args:
        position: of the base in the world, from the middle of what is gripped of the object [m].
        orientation: of the base in the world, scalar last.
        pressure: recommended [Pa].
        force: that holds the object against gravity [N].
        capture_size: errors of the pose that are safe [m]; None: not computed.
    """

    position: Vector
    orientation: Quaternion
    pressure: float
    force: float
    capture_size: float | None


def search(question: ApproachQuestion, told: str) -> tuple[list[FoundApproach], str]:
    """Return the approaches, and how many poses grip or why none does.

    To be called in a process of its own.

    Args:
        question: the object in the world.
        told: path of the file that tells how far the search is: the closings that are done in a
            stage, and that it needs.

    Raises:
        SpiralError: see :func:`spiral_core.find_approaches`.
    """
    from spiral_core.grip.approach import ApproachTask, find_approaches  # the node needs none of it

    q = question
    tilt_max = math.pi if q.tilt_max is None else q.tilt_max
    task = ApproachTask(q.gripper, q.radius, q.object_axis, q.gravity, q.payload, tilt_max)
    progress = np.memmap(told, np.int64, "r+", shape=2)

    def tell(*closings: int) -> None:
        progress[:] = closings

    answer = find_approaches(task, coarse=not q.regions, progress=tell)
    found = [
        FoundApproach(
            one.position,
            one.orientation,
            one.found.pressure,
            one.found.force,
            one.found.size if q.regions else None,
        )
        for one in answer.approaches
    ]
    text = f"{answer.gripping} of {len(answer.tried)} poses tried grip"
    if not found:
        text += "".join(f"; {reason} ({n} poses)" for reason, n in answer.reasons.most_common(3))
    return found, text


def searched(
    question: ApproachQuestion, is_wanted: Callable[[int, int], bool]
) -> tuple[list[FoundApproach], str]:
    """Return the answer of :func:`search` in a process of its own; blocks until it is there.

    Args:
        question: the object in the world.
        is_wanted: called ten times a second with the closings that are done in a stage, and that it
            needs; returns whether somebody still waits.

    Raises:
        SpiralError: there is none, nobody waits, or the process has ended.
    """
    worker = Worker("approach")
    with NamedTemporaryFile() as told:
        progress = np.memmap(told, np.int64, "w+", shape=2)
        try:
            answer: tuple[list[FoundApproach], str] = worker.answer(
                search, question, told.name, is_wanted=lambda: is_wanted(*progress.tolist())
            )
        finally:
            worker.end("nobody waits for it any more")
    return answer
