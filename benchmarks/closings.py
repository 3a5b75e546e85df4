# SPDX-License-Identifier: Apache-2.0
"""Random closings in real time: how many are computed, how many are reported as not, and how fast.

A closing that is computed is checked by itself: finite, never inside the object, nor through it,
every step in balance. One that fails a check although it says that it is complete is *wrong
without a word*. Closings are kept in ``benchmarks/results/closings.jsonl`` as they come, so
that a run that was interrupted goes on where it was; delete the file to begin anew.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from functools import cache

import numpy as np

from benchmarks.cases import SEED, random_direction
from benchmarks.report import RESULTS
from benchmarks.results import Effort, Section, Table, three_digits
from benchmarks.sample import spread
from spiral_core import (
    Gripper,
    GripSetup,
    NotGrippableError,
    PressureCourse,
    SpiralError,
    close_on,
    lay_into_coil,
)
from spiral_core.grip.closing import TimedClosing
from spiral_gripper import load_gripper

GRIPPERS = ("paper_design_70", "prototype_p1", "prototype_p2")
STANDARD_GRAVITY = 9.80665
# Of the closings: pressure over the perfect wrap's, time of its rise [s], then so long at it [s].
BEYOND, RISES, WAIT = (0.9, 1.4), (0.05, 4.0), 0.5
# A node or the middle of an element may lie so deep inside the object [tube's radii].
NODE_DEEP, MIDDLE_DEEP = 1e-3, 0.5
# A step counts as in balance up to this residual; the solver accepts none above it.
BALANCE = 1e-4
KEPT = RESULTS / "closings.jsonl"


@dataclass(frozen=True, slots=True)
class Outcome:
    """How one closing of the sample went.

    Args:
        index: in the sample; together with the seed it makes the closing.
        outcome: "complete", "stalled" (and says so), "not grippable", the name of another error of
            this project, or "wrong: " and what.
        simulated: time that was computed [s].
        spent: processor time for it [s].
        steps: in time.
        passes: Newton iterations.
        contact: part of the tube that touches in the end.
    """

    index: int
    outcome: str
    simulated: float = 0.0
    spent: float = 0.0
    steps: int = 0
    passes: int = 0
    contact: float = 0.0


@cache
def shipped(name: str) -> Gripper:
    """Return a shipped gripper."""
    return load_gripper(name)


def random_closing(index: int) -> tuple[GripSetup, PressureCourse]:
    """Return one closing of the sample; the same index gives the same one.

    Raises:
        SpiralError: the gripper cannot wrap the object, or the object lies in its way.
    """
    rng = np.random.default_rng([SEED, index])
    gripper = shipped(GRIPPERS[int(rng.integers(len(GRIPPERS)))])
    outer = gripper.tube.outer_radius
    radius = float(rng.uniform(1.5, 7.0)) * outer
    pull = STANDARD_GRAVITY * float(rng.choice((0.0, 1.0), p=(0.1, 0.9)))
    x, y, z = (pull * c for c in random_direction(rng))
    friction = float(rng.choice((0.0, rng.uniform(0.05, 1.0)), p=(0.1, 0.9)))
    setup = lay_into_coil(replace(gripper, gravity=(x, y, z)), radius, friction=friction)
    wrap = setup.tip_pressure or gripper.pressure_max
    pressure = min(gripper.pressure_max, float(rng.uniform(*BEYOND)) * wrap)
    rise = math.exp(rng.uniform(*np.log(RISES)))
    return setup, PressureCourse.ramp(pressure / rise, pressure, WAIT)


def fault(closing: TimedClosing) -> str | None:
    """Return what is wrong with a closing that was computed; None if nothing is."""
    outer = closing.setup.gripper.tube.outer_radius
    obstacle = closing.setup.obstacle
    axis, center = closing.setup.axis, np.asarray(obstacle.position)
    reach = obstacle.shape.feature_radius + outer
    for frame in closing.frames:
        state = frame.state
        if not (np.isfinite(state.positions).all() and np.isfinite(frame.velocities).all()):
            return "not finite"
        if frame.residual > BALANCE:
            return "a step out of balance"
        if state.gaps[0, 1:].min() < -NODE_DEEP * outer:
            return "a node inside the object"
        middle = 0.5 * (state.positions[1:] + state.positions[:-1]) - center
        away = np.linalg.norm(middle - np.outer(middle @ axis, axis), axis=1)
        if away.min() < reach - MIDDLE_DEEP * outer:
            return "an element through the object"
    return None


def close_one(index: int) -> Outcome:
    """Close one gripper and check what was computed."""
    begin = time.process_time()
    try:
        setup, course = random_closing(index)
        closing = close_on(setup, course)
    except NotGrippableError:
        return Outcome(index, "not grippable")
    except SpiralError as error:
        return Outcome(index, f"{type(error).__name__}: {error}")
    except Exception as error:  # any other is a failure that is not reported as one
        return Outcome(index, f"wrong: {type(error).__name__}: {error}")
    wrong = fault(closing)
    last = closing.frames[-1]
    outcome = "complete" if closing.is_complete else "stalled"
    return Outcome(
        index,
        outcome if wrong is None else f"wrong: {wrong}",
        simulated=last.time,
        spent=time.process_time() - begin,
        steps=last.steps,
        passes=sum(frame.state.iterations for frame in closing.frames[1:]),
        contact=closing.contact_fractions[-1],
    )


def kept() -> list[Outcome]:
    """Return the closings that earlier runs have computed, in order."""
    if not KEPT.exists():
        return []
    lines = KEPT.read_text(encoding="utf-8").splitlines()
    return [Outcome(**json.loads(line)) for line in lines]


def closings(count: int) -> Iterator[Outcome]:
    """Yield closings until so many were computed; refused ones do not count."""
    index = done = 0
    for outcome in kept():
        yield outcome
        index, done = outcome.index + 1, done + counted(outcome)
        if done >= count:
            return
    close_one(index)  # loads the kernels
    with KEPT.open("a", encoding="utf-8") as file:
        while done < count:
            outcome = close_one(index)
            file.write(json.dumps(asdict(outcome)) + "\n")
            file.flush()
            yield outcome
            index, done = index + 1, done + counted(outcome)


def counted(outcome: Outcome) -> bool:
    """Return whether an outcome is one of a closing."""
    return outcome.outcome != "not grippable"


def measure(effort: Effort) -> Section:
    """Measure the sample, at low priority."""
    os.nice(10)
    outcomes = list(closings(effort.closings))
    computed = [outcome for outcome in outcomes if counted(outcome)]
    kinds = Counter(o.outcome for o in computed)
    wrong = sum(n for kind, n in kinds.items() if kind.startswith("wrong"))
    moved = [o for o in computed if o.simulated > 0.0]
    pace = np.array([o.spent / o.simulated for o in moved])
    per_step = np.array([o.passes / max(1, o.steps) for o in moved])
    rows = [(kind, str(n)) for kind, n in kinds.most_common()]
    rows += [
        ("processor time per simulated second", spread(pace, three_digits)),
        ("steps per simulated second", spread(_steps(moved), three_digits)),
        ("Newton iterations per step", spread(per_step, three_digits)),
    ]
    slowest = max(moved, key=lambda o: o.spent / o.simulated)
    refused = len(outcomes) - len(computed)
    return Section(
        (
            Table(
                f"{len(computed):,} random closings",
                ("what", "number; or median / 99th percentile / most"),
                tuple(rows),
                f"Shipped grippers, radii 1.5 to 7 of the tube's, friction 0 to 1, every direction "
                f"of gravity and none, rises of {RISES[0]:g} to {RISES[1]:g} s. {refused} more "
                f"were refused before anything moved. Slowest: closing {slowest.index}.",
            ),
        ),
        {
            "closings": float(len(computed)),
            "complete": float(kinds["complete"]),
            "stalled": float(kinds["stalled"]),
            "wrong": float(wrong),
            "pace_median": float(np.median(pace)),
        },
    )


def _steps(moved: list[Outcome]) -> np.typing.NDArray[np.float64]:
    """Return the steps per simulated second of each closing."""
    return np.array([o.steps / o.simulated for o in moved])
