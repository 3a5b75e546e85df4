# SPDX-License-Identifier: Apache-2.0
"""What rounding decides: the same questions to another processor, and perturbed.

``python -m benchmarks.rounding`` asks every question as it is, with kernels compiled for the
generic processor (in a process of its own), and with inputs perturbed by a relative 1e-12; exact
mounts also leaning by 1e-5, paths with friction among several obstacles also turned, mirrored and
shifted. Verdicts must be the same and figures within 0.5 %, the ends of paths within 1e-7 of the
length; exceptions are listed. Paths on which the rod snaps are counted apart. Answers are kept in
``benchmarks/results/rounding.jsonl`` as they come: a run that was interrupted goes on, and larger
counts add to it; delete the file to begin anew.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.cases import SEED, Array, Vector, random_case
from benchmarks.closings import random_closing
from benchmarks.command import wide_console
from benchmarks.contact_paths import MIRROR, PATH_ELEMENTS, mirrored, moved, random_path
from benchmarks.contact_wraps import random_wrap
from benchmarks.held import random_setup
from benchmarks.report import RESULTS, show
from benchmarks.results import Table
from spiral_core import (
    GripSetup,
    RodProblem,
    SpiralError,
    close_on,
    grip_window,
    holding_force,
    lay_into_coil,
    solve_rod,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact
from spiral_core.rod.state import RodPath
from spiral_gripper import available_grippers, load_gripper

KEPT = RESULTS / "rounding.jsonl"
# Figures that differ by more than this fraction are exceptions.
AGREE = 5e-3
# Positions at the ends of paths, as a fraction of the length.
AGREE_PATHS = 1e-7
PERTURBED, LEANING = 1e-12, 1e-5
GRAVITY = 9.80665
MOUNTS = tuple(
    tuple(sign * GRAVITY * unit for unit in row)
    for row, sign in product(np.eye(3).tolist(), (1.0, -1.0))
)
RADII = (0.011, 0.012, 0.0135, 0.016, 0.02, 0.025, 0.03)
EXACT = tuple(product(available_grippers(), MOUNTS, RADII))
COUNTS = {
    "exact": len(EXACT),
    "random": 300,
    "rods": 2000,
    "wraps": 300,
    "closings": 300,
    "paths": 200,
}
VERSIONS = ("as is", "generic", "perturbed", "leaning", "turned", "mirrored", "shifted")
# Versions that are asked of one kind alone.
ONLY = {"leaning": "exact", "turned": "paths", "mirrored": "paths", "shifted": "paths"}
SHIFT = np.array((0.3, -0.2, 0.15))
SNAPS = "snaps"
Figures = dict[str, float | None]


class Nudge:
    """Changes inputs by a fraction, at random; one of zero changes nothing."""

    def __init__(self, size: float, index: int) -> None:
        self.size, self.random = size, np.random.default_rng((SEED, index))

    def number(self, value: float) -> float:
        """Return a number changed by the fraction."""
        return value * (1.0 + self.size * float(self.random.uniform(-1.0, 1.0)))

    def vector(self, values: Array | Vector) -> Vector:
        """Return a vector changed by the fraction of its length, every component."""
        given = np.asarray(values, dtype=np.float64)
        change = self.size * float(np.linalg.norm(given)) * self.random.uniform(-1.0, 1.0, 3)
        x, y, z = (given + change).tolist()
        return (x, y, z)


def exact_grip(index: int, nudge: Nudge, leaning: float) -> tuple[str, Figures]:
    """Answer a grip on an exact mount, or on one that leans to where the tube bends."""
    name, mount, radius = EXACT[index]
    lean = np.asarray(mount) + GRAVITY * leaning * np.array((0.3, 1.0, 0.2))
    gripper = load_gripper(name)
    gripper = replace(
        gripper,
        gravity=nudge.vector(lean),
        weight_per_length=nudge.number(gripper.weight_per_length),
    )
    return _gripped(lay_into_coil(gripper, nudge.number(radius)))


def random_grip(index: int, nudge: Nudge) -> tuple[str, Figures]:
    """Answer one of the random grips."""
    setup = random_setup(index)
    if nudge.size:
        weight = nudge.number(setup.gripper.weight_per_length)
        gravity = nudge.vector(setup.gripper.gravity)
        obstacle = replace(
            setup.obstacle,
            position=nudge.vector(setup.obstacle.position),
            friction=nudge.number(setup.obstacle.friction),
        )
        gripper = replace(setup.gripper, gravity=gravity, weight_per_length=weight)
        setup = replace(setup, gripper=gripper, obstacle=obstacle)
    return _gripped(setup)


def _gripped(setup: GripSetup) -> tuple[str, Figures]:
    """Return the verdict on a grip, and its figures."""
    window = grip_window(setup)
    figures: Figures = {
        "wrap": window.onset_wrap,
        "curling": window.onset_curling,
        "loss": window.loss,
    }
    if window.onset_wrap is not None:
        point = window.at(min(1.1 * window.onset_wrap, window.top))
        figures["force"] = holding_force(point).force
    return window.end.value, figures


def rod(index: int, nudge: Nudge) -> tuple[str, Figures]:
    """Answer one of the random rods: where its tip is, from a place outside of it."""
    case = random_case(index)
    case = replace(
        case,
        length=nudge.number(case.length),
        rest_strain=nudge.vector(case.rest_strain),
        distributed=nudge.vector(case.distributed),
    )
    state = solve_rod(case.rod, case.load, throw=False)
    return state.status.value, _tip(state.positions[-1], case.length)


def wrap(index: int, nudge: Nudge) -> tuple[str, Figures]:
    """Answer one of the random wraps."""
    problem = random_wrap(index)
    (obstacle,) = problem.obstacles
    strain = problem.rod.rest_strain
    length = nudge.number(problem.rod.length)
    problem = replace(
        problem,
        rod=replace(problem.rod, length=length, rest_strain=nudge.vector(np.asarray(strain))),
        load=replace(problem.load, distributed=nudge.vector(np.asarray(problem.load.distributed))),
        obstacles=(replace(obstacle, position=nudge.vector(obstacle.position)),),
    )
    state = solve_contact(problem, throw=False)
    return state.status.value, _tip(state.positions[-1], length)


def closing(index: int, nudge: Nudge) -> tuple[str, Figures]:
    """Answer one of the random closings."""
    setup, course = random_closing(index)
    gripper = replace(setup.gripper, gravity=nudge.vector(setup.gripper.gravity))
    closed = close_on(replace(setup, gripper=gripper), course)
    last = closed.frames[-1].state
    verdict = "complete" if closed.is_complete else "stalled"
    return verdict, _tip(last.positions[-1], float(last.arc_lengths[-1]))


def followed(index: int, version: str) -> tuple[RodPath, Array]:
    """Return a random path in a version, and its last positions seen as in the path as it is."""
    stations, rng = random_path(index), np.random.default_rng((SEED, index))
    turn = Rotation.from_quat(rng.normal(size=4))
    if version == "perturbed":
        stations = [_perturbed(station, Nudge(PERTURBED, index)) for station in stations]
    elif version == "turned":
        stations = [moved(station, np.zeros(3), turn) for station in stations]
    elif version == "mirrored":
        stations = [mirrored(station) for station in stations]
    elif version == "shifted":
        stations = [moved(station, SHIFT, Rotation.identity()) for station in stations]
    path = follow_contact(stations, elements=PATH_ELEMENTS)
    last = path.states[-1].positions
    if version == "turned":
        return path, turn.inv().apply(last)
    return path, {"mirrored": last @ MIRROR, "shifted": last - SHIFT}.get(version, last)


def _perturbed(station: RodProblem, nudge: Nudge) -> RodProblem:
    """Return a station of a path, changed; the same nudges change every station alike."""
    load: Any = station.load
    load = replace(
        load, distributed=nudge.vector(load.distributed), tip_force=nudge.vector(load.tip_force)
    )
    obstacles = tuple(
        replace(each, position=nudge.vector(each.position), friction=nudge.number(each.friction))
        for each in station.obstacles
    )
    rod: Any = station.rod
    rod = replace(rod, rest_strain=nudge.vector(rod.rest_strain))
    return replace(station, rod=rod, load=load, obstacles=obstacles)


def path_end(index: int, version: str) -> tuple[str, Figures]:
    """Answer one of the random paths: where every sixth node is in the end, in lengths."""
    path, last = followed(index, version)
    length = random_path(index)[-1].rod.length
    verdict = f"{len(path.states)} stations, {len(path.events)} {SNAPS}"
    places = last[6::6] / length
    return verdict, {
        f"{axis} of node {6 * row + 6}": float(value)
        for row, place in enumerate(places)
        for axis, value in zip("xyz", place, strict=True)
    }


def _tip(place: Array, length: float) -> Figures:
    """Return a tip's place as figures near one."""
    return {axis: 1.0 + float(x) / length for axis, x in zip("xyz", place, strict=True)}


def answer(kind: str, index: int, version: str) -> dict[str, Any]:
    """Return the answer to a question, as it is kept."""
    nudge = Nudge(PERTURBED if version == "perturbed" else 0.0, index)
    ask = {"random": random_grip, "rods": rod, "wraps": wrap, "closings": closing}
    try:
        if kind == "exact":
            found = exact_grip(index, nudge, LEANING if version == "leaning" else 0.0)
        elif kind == "paths":
            found = path_end(index, version)
        else:
            found = ask[kind](index, nudge)
    except SpiralError as error:
        found = (type(error).__name__, {})
    finite = {n: None if v is None or math.isnan(v) else v for n, v in found[1].items()}
    return {"kind": kind, "index": index, "version": version, "verdict": found[0]} | finite


def read() -> dict[tuple[str, int, str], dict[str, Any]]:
    """Return the answers that are kept, by kind, index and version."""
    lines = KEPT.read_text(encoding="utf-8").splitlines() if KEPT.exists() else []
    found = [json.loads(line) for line in lines]
    return {(each["kind"], each["index"], each["version"]): each for each in found}


def compute(version: str, counts: dict[str, int]) -> None:
    """Answer what is missing in one version."""
    known = read()
    with KEPT.open("a", encoding="utf-8") as lines:
        for kind, count in counts.items():
            # Spread over the questions, so that a few of them are a sample.
            for index in np.linspace(0, COUNTS[kind], count, endpoint=False).astype(int).tolist():
                skipped = ONLY.get(version, kind) != kind
                if not skipped and (kind, index, version) not in known:
                    lines.write(json.dumps(answer(kind, index, version)) + "\n")
                    lines.flush()


def differences(plain: dict[str, Any], other: dict[str, Any]) -> list[str]:
    """Return in what two answers differ, in words."""
    if plain["verdict"] != other["verdict"]:
        return [f"{plain['verdict']}, or {other['verdict']}"]
    if plain["kind"] == "paths":
        apart = max(abs(plain[name] - other[name]) for name in plain if " of node " in name)
        return [f"{apart:.1e} of the length"] if apart > AGREE_PATHS else []
    found = []
    for name in sorted((plain.keys() | other.keys()) - {"kind", "index", "version", "verdict"}):
        a, b = plain.get(name), other.get(name)
        if (a is None) != (b is None) or (a is not None and abs(a - b) > AGREE * abs(a)):
            found.append(f"{name} {_shown(a)} or {_shown(b)}")
    return found


def _shown(value: float | None) -> str:
    """Return a figure as text."""
    return "none" if value is None else f"{value:.6g}"


def tables() -> tuple[Table, Table]:
    """Return the counts of what agrees, and the exceptions."""
    known = read()
    rows, exceptions = [], []
    for kind, version in product(COUNTS, VERSIONS[1:]):
        pairs = [
            (known[key], other)
            for (k, index, v), other in sorted(known.items())
            if (k, v) == (kind, version) and (key := (kind, index, VERSIONS[0])) in known
        ]
        for snapping in (False, True):
            asked = [(plain, other) for plain, other in pairs if _snaps(plain) == snapping]
            apart = [(plain, differences(plain, other)) for plain, other in asked]
            apart = [each for each in apart if each[1]]
            name = f"{kind} that snap" if snapping else kind
            if asked:
                rows.append((name, version, f"{len(asked):,}", f"{len(apart):,}"))
            exceptions += [
                (f"{name} {plain['index']}{_named(plain)}", version, "; ".join(words))
                for plain, words in apart
            ]
    counts = ("questions", "compared with", "asked", "answered otherwise")
    note = (
        f"Otherwise: another verdict, or a figure off by more than {100 * AGREE:g} %; a node at "
        f"the end of a path by more than {AGREE_PATHS:g} of the length."
    )
    return (
        Table("Rounding: the same questions as they are and otherwise", counts, tuple(rows), note),
        Table("What differs", ("question", "version", "as is, or otherwise"), tuple(exceptions)),
    )


def _snaps(answer: dict[str, Any]) -> bool:
    """Return whether a rod loses its stability on its path."""
    verdict = answer["verdict"]
    return answer["kind"] == "paths" and SNAPS in verdict and f" 0 {SNAPS}" not in verdict


def _named(plain: dict[str, Any]) -> str:
    """Return an exact grip in words."""
    if plain["kind"] != "exact":
        return ""
    name, mount, radius = EXACT[plain["index"]]
    towards = "+-"[int(min(mount) < 0.0)] + "xyz"[int(np.argmax(np.abs(mount)))]
    return f" ({name}, gravity {towards}, {1e3 * radius:g} mm)"


def main() -> None:
    """Ask what is missing and show what differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    for kind, count in COUNTS.items():
        parser.add_argument(f"--{kind}", type=int, default=count, help="how many of them")
    parser.add_argument("--version", choices=VERSIONS, help="compute one version in this process")
    arguments = parser.parse_args()
    counts = {kind: min(getattr(arguments, kind), COUNTS[kind]) for kind in COUNTS}
    if arguments.version is not None:
        compute(arguments.version, counts)
        return
    cache = Path(tempfile.gettempdir()) / "spiral-gripper-generic-kernels"
    for version in VERSIONS:
        environment = dict(os.environ)
        if version == "generic":
            environment |= {"NUMBA_CPU_NAME": "generic", "NUMBA_CACHE_DIR": str(cache)}
        numbers = [f"--{kind}={count}" for kind, count in counts.items()]
        command = [sys.executable, "-m", "benchmarks.rounding", f"--version={version}", *numbers]
        subprocess.run(command, check=True, env=environment)
    for table in tables():
        show(table, wide_console())


if __name__ == "__main__":
    main()
