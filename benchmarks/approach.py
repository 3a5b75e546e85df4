# SPDX-License-Identifier: Apache-2.0
"""Is a random approach better than those that the search finds?

``python -m benchmarks.approach`` lets the search hold the paper's gripper at random objects, and
closes it in random base poses as well: any orientation, the object in the free coil or up to half a
radius beside it. A random pose beats the search if it holds with over 10 % more force and has a
larger region of capture than the best approach; only those that may hold so much, by few elements,
are judged by their region: by the errors of the pose next larger than those of the best approach;
where that holds with the largest asked, by these.
As in the search, what is not wrapped at the tip criterion's pressure does not grip.
Answers are kept in ``benchmarks/results/approach.jsonl`` as they come, first numbers and forces of
the random poses that grip, then how they compare. Each object takes some ten minutes of processor:
the file is part of the repository, and a run goes on where it ended. Delete it, or its lines of the
second kind, to begin anew.
"""

from __future__ import annotations

import argparse
import json
import math
from collections import Counter
from concurrent.futures import Executor
from contextlib import suppress
from functools import partial
from typing import Any, TextIO

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
    coarse_grip,
    gripped,
    holds_shifted,
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


def coarse_force(task: ApproachTask, pose: BasePose) -> float | None:
    """Return with what force a pose holds, on few elements [N]; None where it does not grip."""
    found = coarse_grip(task, pose)
    return None if isinstance(found, Trial) else holding_force(found, Pull.DOWN).force


def contend(task: ApproachTask, force: float, size: float, pose: BasePose) -> bool:
    """Return whether a pose holds more than a force [N], and larger errors than a size [m]."""
    larger = next((error for error in ERRORS if 1e-3 * error > size), ERRORS[-1])
    with suppress(*REFUSALS):
        point = gripped(task, pose)
        more = holding_force(point, Pull.DOWN, force).force > force
        return more and (size < 0.0 or holds_shifted(point, larger, task.payload))
    return False


def compare(
    task: ApproachTask, gripping: list[tuple[BasePose, float]], executor: Executor
) -> dict[str, float | int | None]:
    """Return the best of a search, and the number of random poses that are better."""
    search = Search(task, executor)
    judged = search.judged(search.screened(coarse=False), coarse=False)
    searched = [each for each in judged.values() if not each.refusal]
    best = max(searched, key=lambda each: each.score, default=None)
    force, size = (0.0, -1.0) if best is None else (MORE_FORCE * best.force, best.size + 1e-9)
    strong = [pose for pose, coarse in gripping if coarse >= SCREENED * force]
    better = executor.map(partial(contend, task, force, size), strong)
    return {"size": None if best is None else best.size, "better": sum(better)}


def main() -> None:
    """Ask what is missing and show how often chance beats the search."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--objects", type=int, default=OBJECTS)
    parser.add_argument("--poses", type=int, default=POSES, help="random ones of each")
    given = parser.parse_args()
    found: dict[int, dict[str, Any]] = {index: {} for index in range(given.objects)}
    for line in KEPT.read_text(encoding="utf-8").splitlines() if KEPT.exists() else ():
        kept = json.loads(line)
        if kept["poses"] == given.poses and kept["object"] in found:
            found[kept["object"]] |= kept
    with KEPT.open("a", encoding="utf-8") as file, process_pool(core_count()) as executor:
        for index, own in track(found.items(), "approaching"):
            task, rng = task_of(index), np.random.default_rng((SEED, index, 1))
            poses = [random_pose(task, rng) for _ in range(given.poses)]
            if "forces" not in own:
                forces = enumerate(executor.map(partial(coarse_force, task), poses))
                own["forces"] = [(n, force) for n, force in forces if force is not None]
                keep(file, {"object": index, "poses": given.poses, "forces": own["forces"]})
            if "better" not in own:
                gripping = [(poses[n], force) for n, force in own["forces"]]
                answer = compare(task, gripping, executor)
                keep(file, {"object": index, "poses": given.poses, **answer})
                own.update(answer)
    some = list(found.values())
    counts = [len(each["forces"]) for each in some]
    sizes = Counter(each["size"] for each in some if each["size"] is not None)
    rows = (
        ("objects", str(len(some))),
        ("random poses of each", str(given.poses)),
        ("objects that the search grips", str(sizes.total())),
        *(
            (f"of these, best region {1e3 * size:.0f} mm", str(sizes[size]))
            for size in sorted(sizes)
        ),
        ("objects that a random pose grips", str(sum(count > 0 for count in counts))),
        ("random poses that grip", str(sum(counts))),
        ("objects with a better random pose", str(sum(each["better"] > 0 for each in some))),
        ("better random poses", str(sum(each["better"] for each in some))),
    )
    show(Table("Approaches: search and chance", ("what", "count"), rows), wide_console())


def keep(file: TextIO, answer: dict[str, Any]) -> None:
    """Write an answer."""
    print(json.dumps(answer), file=file, flush=True)


if __name__ == "__main__":
    main()
