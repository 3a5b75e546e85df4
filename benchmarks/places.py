# SPDX-License-Identifier: Apache-2.0
"""Where an object is not held in the free coil: does the search for a place find one that holds it?

``python -m benchmarks.places`` takes random questions of ``benchmarks.verdicts`` that are refused
in their place, and looks for another: as ``--find-place`` does, and at random in the same box. Of
the questions in which any random place holds the object the search is to find one in at least 95 %.
Answers are kept in ``benchmarks/results/places.jsonl`` as they come: a run that was interrupted
goes on; delete the file to begin anew.
"""

from __future__ import annotations

import argparse
import json

import numpy as np
from rich.progress import track

from benchmarks.cases import SEED
from benchmarks.command import wide_console
from benchmarks.report import RESULTS, show
from benchmarks.results import Table
from benchmarks.verdicts import designs, mounted, question
from spiral_core import GripSetup, SpiralError, grip_window, lay_into_coil
from spiral_core.grip.places import FARTHEST_SHIFT, LARGEST_TILT, find_place
from spiral_gripper import available_grippers

KEPT = RESULTS / "places.jsonl"
QUESTIONS, PLACES = 200, 200


def is_held(setup: GripSetup) -> bool:
    """Return whether a rising pressure wraps the object."""
    try:
        return grip_window(setup, until_wrapped=True).onset_wrap is not None
    except SpiralError:
        return False


def held_at_random(setup: GripSetup, index: int, count: int) -> int:
    """Return how many random places are tried until one holds; 0: none of them does."""
    rng = np.random.default_rng((SEED, index))
    reach = FARTHEST_SHIFT * (setup.obstacle.shape.feature_radius + setup.gripper.tube.outer_radius)
    tilt = LARGEST_TILT if setup.gripper.object_axis is None else 0.0
    for tried in range(1, count + 1):
        if is_held(setup.moved(rng.uniform(-1.0, 1.0, 5) * (*[reach] * 3, tilt, tilt))):
            return tried
    return 0


def answer(index: int, grippers: list[str], count: int) -> dict[str, object] | None:
    """Return what search and chance find; None where the question is not refused in its place."""
    asked = question(index, grippers)
    try:
        setup = lay_into_coil(mounted(asked), asked.radius)
    except SpiralError:
        return None
    if is_held(setup):
        return None
    return {
        "question": index,
        "search": find_place(setup) is not None,
        "random": held_at_random(setup, index, count),
        "known_direction": asked.axis is not None,
    }


def main() -> None:
    """Ask what is missing and show what the search finds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--questions", type=int, default=QUESTIONS, help="how many refused ones")
    parser.add_argument("--places", type=int, default=PLACES, help="random ones of each")
    given = parser.parse_args()
    lines = KEPT.read_text(encoding="utf-8").splitlines() if KEPT.exists() else []
    found = {each["question"]: each for each in map(json.loads, lines)}
    grippers = [*available_grippers(), *designs()]
    index = max(found, default=-1) + 1
    with KEPT.open("a", encoding="utf-8") as kept:
        for _ in track(range(given.questions - len(found)), "looking for places"):
            while (said := answer(index, grippers, given.places)) is None:
                index += 1
            found[index] = said
            kept.write(json.dumps(said) + "\n")
            kept.flush()
            index += 1
    rows = []
    for name, known in (("fitted", False), ("known", True)):
        asked = [each for each in found.values() if each["known_direction"] == known]
        possible = [each["search"] for each in asked if each["random"]]
        counts = len(asked), len(possible), sum(possible), sum(each["search"] for each in asked)
        rows.append((name, *(f"{count:,}" for count in counts)))
    columns = ("direction", "refused", "held at random", "of them by search", "by search")
    show(
        Table("Places for objects that are refused in theirs", columns, tuple(rows)), wide_console()
    )


if __name__ == "__main__":
    main()
