# SPDX-License-Identifier: Apache-2.0
"""Is a random approach better than those that the search finds?

``python -m benchmarks.approach`` lets the search hold the paper's gripper at random objects, and
closes it in random base poses as well: any orientation, the object in the free coil or up to half a
radius beside it. A random pose beats the search if it holds with over 10 % more force and has a
larger region of capture than the best approach; only those that may hold so much, by few elements,
are judged by their region, and wholly only where they hold at the next larger errors of the pose.
Answers are kept in ``benchmarks/results/approach.jsonl`` as they come: a run that was interrupted
goes on; delete the file to begin anew.
"""

from __future__ import annotations

import argparse
import json
import math
from contextlib import suppress
from functools import partial

import numpy as np
from rich.progress import track
from scipy.spatial.transform import Rotation

from benchmarks.cases import SEED
from benchmarks.command import wide_console
from benchmarks.report import RESULTS, show
from benchmarks.results import Table
from spiral_core import ApproachTask
from spiral_core.grip.approach import (
    ERRORS,
    REFUSALS,
    BasePose,
    Search,
    Trial,
    gripped,
    holds_shifted,
    judge,
    screen,
)
from spiral_core.grip.holding import Pull, holding_force
from spiral_gripper import load_gripper
from spiral_gripper.cli.workers import core_count, process_pool

KEPT = RESULTS / "approach.jsonl"
OBJECTS, POSES = 40, 300
GRIPPER, GRAVITY = "paper_design_70", (0.0, 0.0, -9.80665)
RADII, PAYLOAD = (0.010, 0.028), 0.010
# Directions of the object: to this angle from gravity; random ones farther away hardly ever grip.
LARGEST_LEAN = math.radians(25.0)
SHIFT, MORE_FORCE = 0.5, 1.1
# Forces on few elements are right to a tenth.
SCREENED = 0.9


def task_of(index: int) -> ApproachTask:
    """Return a random object."""
    rng = np.random.default_rng((SEED, index))
    lean, turn = LARGEST_LEAN * math.sqrt(rng.uniform()), rng.uniform(0.0, 2.0 * math.pi)
    axis = (math.sin(lean) * math.cos(turn), math.sin(lean) * math.sin(turn), math.cos(lean))
    return ApproachTask(load_gripper(GRIPPER), float(rng.uniform(*RADII)), axis, GRAVITY, PAYLOAD)


def random_pose(task: ApproachTask, rng: np.random.Generator) -> BasePose:
    """Return a random orientation of the base, with the object near the free coil."""
    turn = Rotation.random(random_state=rng)
    shift = SHIFT * task.radius * rng.uniform(-1.0, 1.0, 3)
    rows = np.stack((turn.apply(task.down), turn.apply(task.axis), shift))
    gravity, axis, place = ((x, y, z) for x, y, z in rows.tolist())
    return BasePose(gravity, axis, place)


def contend(task: ApproachTask, force: float, size: float, pose: BasePose) -> Trial:
    """Return what a pose does: refused where it holds less, or no larger errors than a size [m]."""
    larger = [error for error in ERRORS if 1e-3 * error > size]
    with suppress(*REFUSALS):
        point = gripped(task, pose)
        more = holding_force(point, Pull.DOWN).force > force
        if more and (size < 0.0 or (larger and holds_shifted(task, point, larger[0]))):
            return judge(task, pose)
    return Trial("weaker")


def answer(index: int, count: int) -> dict[str, object]:
    """Return what search and chance find for an object."""
    task, rng = task_of(index), np.random.default_rng((SEED, index, 1))
    poses = [random_pose(task, rng) for _ in range(count)]
    with process_pool(core_count()) as executor:
        search = Search(task, executor)
        judged = search.judged(search.screened(coarse=False), coarse=False)
        searched = [each for each in judged.values() if not each.refusal]
        best = max(searched, key=lambda each: each.score, default=None)
        tried = list(executor.map(screen, [task] * count, poses))
        force, size = (0.0, -1.0) if best is None else (MORE_FORCE * best.force, best.size + 1e-9)
        strong = [
            pose
            for pose, trial in zip(poses, tried, strict=True)
            if not trial.refusal and trial.force >= SCREENED * force
        ]
        chance = list(executor.map(partial(contend, task, force, size), strong))
    better = [t for t in chance if not t.refusal and t.force > force and t.size > size]
    return {
        "object": index,
        "poses": count,
        "search": best is not None,
        "random": sum(not each.refusal for each in tried),
        "better": len(better),
    }


def main() -> None:
    """Ask what is missing and show how often chance beats the search."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--objects", type=int, default=OBJECTS)
    parser.add_argument("--poses", type=int, default=POSES, help="random ones of each")
    given = parser.parse_args()
    lines = KEPT.read_text(encoding="utf-8").splitlines() if KEPT.exists() else []
    kept_answers = map(json.loads, lines)
    found = {each["object"]: each for each in kept_answers if each["poses"] == given.poses}
    with KEPT.open("a", encoding="utf-8") as kept:
        for index in track(range(given.objects), "approaching"):
            if index not in found:
                found[index] = answer(index, given.poses)
                kept.write(json.dumps(found[index]) + "\n")
                kept.flush()
    some = [found[index] for index in range(given.objects)]
    rows = (
        ("objects", str(len(some))),
        ("random poses of each", str(given.poses)),
        ("objects that the search grips", str(sum(each["search"] for each in some))),
        ("objects that a random pose grips", str(sum(each["random"] > 0 for each in some))),
        ("random poses that grip", str(sum(each["random"] for each in some))),
        ("objects with a better random pose", str(sum(each["better"] > 0 for each in some))),
    )
    show(Table("Approaches: search and chance", ("what", "count"), rows), wide_console())


if __name__ == "__main__":
    main()
