# SPDX-License-Identifier: Apache-2.0
"""A recorded stream of radius estimates, read from a file. Knows no ROS."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.resources import files

from spiral_core.errors import InvalidInputError
from spiral_gripper.files.table import TableError, csv_lines

SHIPPED_RECORDING = "radii.csv"
ROWS = "rows of time [s], radius [m], label"


@dataclass(frozen=True, slots=True)
class RadiusSample:
    """One estimate.

    Args:
        time: since the start of the recording [s].
        radius: the estimate [m]; anything a float can be, as estimators are.
        label: what was in front of the gripper.
    """

    time: float
    radius: float
    label: str


def shipped_recording() -> tuple[RadiusSample, ...]:
    """Return the recording that the demo plays.

    Example:
        >>> shipped_recording()[0].label
        'tube light'
    """
    text = (files("spiral_gripper_ros") / "data" / SHIPPED_RECORDING).read_text(encoding="utf-8")
    return samples_from_lines(text.splitlines())


def samples_from_lines(lines: Iterable[str]) -> tuple[RadiusSample, ...]:
    """Return the samples of a CSV text with the columns time, radius, label; ``#`` is a comment.

    Raises:
        InvalidInputError: it is no such table, or the times are not finite and in order.

    Example:
        >>> samples_from_lines(["time,radius,label", "0.0,nan,nothing"])
        (RadiusSample(time=0.0, radius=nan, label='nothing'),)
    """
    try:
        rows = [cells for _, cells in csv_lines("\n".join(lines), "recording")]
    except TableError as error:
        raise InvalidInputError("recording", str(error), ROWS) from None
    if rows[:1] != [["time", "radius", "label"]]:
        raise InvalidInputError("recording", rows[:1], ROWS)
    samples: list[RadiusSample] = []
    for row in rows[1:]:
        try:
            time, radius, label = row
            sample = RadiusSample(float(time), float(radius), label)
        except ValueError:
            raise InvalidInputError("recording", row, ROWS) from None
        if not (math.isfinite(sample.time) and (not samples or sample.time > samples[-1].time)):
            raise InvalidInputError("time", sample.time, "finite and later than the row before")
        samples.append(sample)
    if not samples:
        raise InvalidInputError("recording", "no rows", ROWS)
    return tuple(samples)
