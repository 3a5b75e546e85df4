# SPDX-License-Identifier: Apache-2.0
"""What three times the elements change of a grip.

``python -m benchmarks.elements`` closes each grip on its own elements and on three times as many,
and compares verdicts and figures: contact lengths, forces and normal forces at 1.1 times the first
one's onset. Grips are those whose answers are nearest to a change of kind: the shipped grippers,
hanging and otherwise, around the radii at which the curl's bridge is about as high as the curl's
threshold. Answers are kept in ``benchmarks/results/elements.jsonl`` as they come: a run that was
interrupted goes on; delete the file to begin anew.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.cases import Vector
from benchmarks.command import wide_console
from benchmarks.report import RESULTS, show
from benchmarks.results import Table
from benchmarks.rounding import GRAVITY
from spiral_core import (
    Grip,
    GripSetup,
    Pull,
    SpiralError,
    grip_window,
    holding_force,
    lay_into_coil,
)
from spiral_gripper import load_gripper

KEPT = RESULTS / "elements.jsonl"
FINER = 3
FRICTION = 0.3
HANGING, UPRIGHT, LEVEL, ASIDE, LEANING = (
    (GRAVITY, 0.0, 0.0),
    (-GRAVITY, 0.0, 0.0),
    (0.0, GRAVITY, 0.0),
    (0.0, 0.0, -GRAVITY),
    (0.8 * GRAVITY, 0.6 * GRAVITY, 0.0),
)
# By gripper and mount, the objects' radii [mm].
RADII: tuple[tuple[str, Vector, tuple[float, ...]], ...] = (
    ("paper_design_70", HANGING, (11, 12, 12.5, 12.8, 13.1, 13.3, 13.6, 14, 14.5, 15, 16, 17)),
    ("paper_design_70", HANGING, (18, 20, 22, 25)),
    ("paper_design_70", UPRIGHT, (12, 13.1, 13.6, 15, 16, 20)),
    ("paper_design_70", LEVEL, (12, 13.1, 13.6, 15, 16, 20)),
    ("paper_design_70", ASIDE, (12, 13.1, 13.6, 15, 16, 20)),
    ("prototype_p1", HANGING, (10, 11, 12, 13.1, 14, 15, 16, 18)),
    ("prototype_p1", LEANING, (13.1, 20)),
    ("prototype_p2", HANGING, (10, 11, 12, 13.1, 13.6, 14, 15, 16, 18, 20)),
    ("prototype_p2", ASIDE, (13.1, 15, 18, 20)),
    ("prototype_p2", LEANING, (13.1, 20)),
)
GRIPS = tuple((name, mount, 1e-3 * r) for name, mount, radii in RADII for r in radii)
# What docs/grip.md promises of each figure, as a fraction.
BOUNDS = {
    "onset": 0.01,
    "curling": 0.02,
    "loss": 0.01,
    "recommended": 0.01,
    "contact": 0.02,
    "force": 0.02,
    "normal force": 0.02,
}


def answer(index: int) -> list[dict[str, Any]]:
    """Return the answers to a grip, on its own elements and on more."""
    name, mount, radius = GRIPS[index]
    gripper = replace(load_gripper(name), gravity=mount)
    try:
        setup = lay_into_coil(gripper, radius, friction=FRICTION)
        first = _answered(setup, None)
        more = replace(setup, elements=FINER * setup.element_count)
        return [first, _answered(more, first.get("onset"))]
    except SpiralError as error:
        return [{"verdict": type(error).__name__}] * 2


def _answered(setup: GripSetup, onset: float | None) -> dict[str, Any]:
    """Return verdict and figures of one closing, forces at 1.1 times a given onset or its own."""
    window = grip_window(setup)
    if window.onset_wrap is None:
        return {"verdict": window.end.value}
    grip = Grip(window, (), {})
    point = window.at(min(1.1 * (onset or window.onset_wrap), window.top))
    return {
        "verdict": f"{window.end.value}; {grip.range_end.value}",
        "onset": window.onset_wrap,
        "curling": window.onset_curling,
        "loss": window.loss,
        "recommended": grip.recommended_pressure(),
        "contact": point.contact_length,
        "force": holding_force(point, Pull.AWAY).force,
        "normal force": point.normal_force,
    }


def tables(found: dict[int, list[dict[str, Any]]]) -> tuple[Table, Table]:
    """Return how far the figures differ, and the grips in which one differs by too much."""
    rows, exceptions = [], []
    for name, bound in BOUNDS.items():
        pairs = {i: (a.get(name), b.get(name)) for i, (a, b) in found.items()}
        changes = {i: abs(a / b - 1.0) for i, (a, b) in pairs.items() if a and b}
        only = [i for i, (a, b) in pairs.items() if (a is None) != (b is None)]
        apart = [i for i, change in changes.items() if not change <= bound]
        at = np.array(list(changes.values()) or [0.0])
        shown = (
            f"{100.0 * value:.2f} %" for value in (np.median(at), np.quantile(at, 0.9), at.max())
        )
        rows.append((name, str(len(changes)), *shown, f"{100 * bound:g} %", str(len(apart))))
        exceptions += [(named(i), name, *map(_shown, pairs[i])) for i in only + apart]
    exceptions += [
        (named(i), "verdict", a["verdict"], b["verdict"])
        for i, (a, b) in found.items()
        if a["verdict"] != b["verdict"]
    ]
    columns = ("figure", "grips", "median", "nine in ten", "largest", "bound", "beyond it")
    title = f"What three times the elements change: {len(found)} grips, friction {FRICTION:g}"
    return (
        Table(title, columns, tuple(rows)),
        Table("What differs", ("grip", "figure", "default", "three times"), tuple(exceptions)),
    )


def named(index: int) -> str:
    """Return a grip in words."""
    name, (x, y, z), radius = GRIPS[index]
    return f"{name}, gravity ({x:.3g}, {y:.3g}, {z:.3g}), {1e3 * radius:g} mm"


def _shown(value: float | None) -> str:
    """Return a figure as text."""
    return "none" if value is None else f"{value:.6g}"


def main() -> None:
    """Close what is missing and show what differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--grips", type=int, default=len(GRIPS), help="how many of them")
    count = min(parser.parse_args().grips, len(GRIPS))
    asked = np.linspace(0, len(GRIPS), count, endpoint=False).astype(int).tolist()
    lines = KEPT.read_text(encoding="utf-8").splitlines() if KEPT.exists() else []
    found = {each["grip"]: each["answers"] for each in map(json.loads, lines)}
    with KEPT.open("a", encoding="utf-8") as kept:
        for index in asked:
            if index not in found:
                found[index] = answer(index)
                kept.write(json.dumps({"grip": index, "answers": found[index]}) + "\n")
                kept.flush()
    for table in tables({index: found[index] for index in asked}):
        show(table, wide_console())


if __name__ == "__main__":
    main()
