# SPDX-License-Identifier: Apache-2.0
"""Random questions to the shipped grippers: every answer and every refusal against a plain scan.

The scan follows the loading path through the pressure range in many small steps and looks at every
state by itself: no interpolation, no search, no notion of branches.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.cases import Vector, random_direction
from benchmarks.results import Effort, Section, Table
from spiral_core import (
    Gripper,
    NoCoilError,
    NotGrippableError,
    RodState,
    SolverError,
    SpiralError,
    Wrap,
    WrapCurve,
)
from spiral_core.rod.path import follow_path
from spiral_core.rod.state import RodPath
from spiral_core.wrap.branch import LEAST_RADIUS
from spiral_core.wrap.wrap import wrapped_radius
from spiral_gripper import available_grippers, load_gripper

SEED = 2024
STATIONS = 400
# A step of the scan in which a lower pressure seems to do is looked at again, in so many parts.
PARTS = 64
AXES, RADII = 5, 20
G = 9.80665
ROOT = math.sqrt(0.5)
# Gravity and axes along the tube, across it, in its plane of bending, between them, and none.
SYMMETRIC: tuple[Vector, ...] = (
    *((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)),
    *((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (ROOT, ROOT, 0.0), (-ROOT, ROOT, 0.0)),
    *((ROOT, 0.0, ROOT), (-ROOT, 0.0, -ROOT), (0.0, ROOT, ROOT), (0.0, -ROOT, ROOT)),
)
# An answer is right to this fraction of the contact radius ...
RADIUS_ERROR = 1e-6
# ... and the scan, which has other elements, tells radii apart from this fraction on.
SCAN_ERROR = 1e-4
# So do turns, counted from node to node: a sample of the scan is coiled with this many to spare.
SURE = 5e-3


@dataclass(frozen=True, slots=True)
class Scan:
    """Every state of a plain scan: pressures [Pa], radii [m], turns, and where the tube snapped."""

    gripper: Gripper
    pressures: list[float]
    states: Sequence[RodState]
    radii: list[float]
    turns: list[float]
    snapped: set[int]
    required: float
    outer_radius: float

    def is_coiled(self, i: int) -> bool:
        """Return whether a sample wraps something, surely."""
        return self.turns[i] >= self.required + SURE and self.radii[i] > 2e-3 * self.outer_radius

    def coiled(self) -> list[int]:
        """Return the samples that are coiled and whose next one is: a range, not a single place."""
        steps = range(len(self.radii) - 1)
        return [i for i in steps if self.is_coiled(i) and self.is_coiled(i + 1)]

    def crossings(self, radius: float) -> Iterator[int]:
        """Return the steps of the scan over which a coil passes a radius [m]."""
        coiled = set(self.coiled())
        for i in coiled:
            low, high = sorted(self.radii[i : i + 2])
            if (
                i not in self.snapped
                and i in coiled
                and self.slack(radius) < min(radius - low, high - radius)
            ):
                yield i

    def slack(self, radius: float) -> float:
        """Return the scan's own error of a radius [m]."""
        return SCAN_ERROR * (radius + self.outer_radius)


def path_of(
    gripper: Gripper, pressures: list[float] | None = None, start: RodState | None = None
) -> tuple[list[float], RodPath]:
    """Return pressures and states of a gripper, from almost zero to its limit where none are given.

    Args:
        gripper: the gripper.
        pressures: stations [Pa].
        start: the state at the first of them.
    """
    if pressures is None:
        pressures = np.linspace(0.0, gripper.pressure_max, STATIONS + 1)[1:].tolist()
    shapes = [gripper.unloaded_shape(pressure) for pressure in pressures]
    return pressures, follow_path([(gripper.rod(s), gripper.load(s)) for s in shapes], start=start)


def scan_of(gripper: Gripper, pressures: list[float], path: RodPath) -> Scan:
    """Return what the states of a path wrap about the gripper's axis."""
    wraps = []
    for pressure, state in zip(pressures, path.states, strict=True):
        shape = gripper.unloaded_shape(pressure)
        radius, axis = wrapped_radius(gripper, shape, state)
        turns = gripper.turns_required
        wraps.append(Wrap(pressure, radius, shape, state, axis, turns, gripper.tube))
    return Scan(
        gripper,
        pressures,
        path.states,
        [wrap.object_radius for wrap in wraps],
        [wrap.turns for wrap in wraps],
        {math.floor(fold.position) for fold in path.events},
        gripper.turns_required,
        gripper.tube.outer_radius,
    )


def is_crossed(scan: Scan, i: int, radius: float) -> bool:
    """Return whether step i of the scan, followed in small parts, wraps a radius [m] in coils.

    Turns may fall short for a part of a step that begins and ends with enough of them.
    """
    parts = np.linspace(scan.pressures[i], scan.pressures[i + 1], PARTS + 1).tolist()
    near = scan_of(scan.gripper, *path_of(scan.gripper, parts, scan.states[i]))
    return any(
        (near.radii[k] - radius) * (near.radii[k + 1] - radius) <= 0.0 for k in near.coiled()
    )


def judge_answer(scan: Scan, wrap: Wrap, radius: float) -> str | None:
    """Return what is wrong with an answer; None if nothing is."""
    if abs(wrap.object_radius - radius) > RADIUS_ERROR * (radius + scan.outer_radius):
        return "another radius"
    if not wrap.state.stable or wrap.turns < scan.required - RADIUS_ERROR:
        return "not stable, or too few turns"
    here = int(np.searchsorted(scan.pressures, wrap.pressure)) - 1
    if any(i < here and is_crossed(scan, i, radius) for i in scan.crossings(radius)):
        return "a lower pressure does"
    if 0 < here < len(scan.radii) - 2 and not scan.snapped & {here - 1, here, here + 1}:
        near = scan.radii[here - 1 : here + 3]
        slack = max(near) - min(near)
        if not min(near) - slack <= radius <= max(near) + slack:
            return "another state than the scan's"
    return None


def judge_refusal(scan: Scan, curve: WrapCurve, error: NotGrippableError) -> str | None:
    """Return what is untrue in a refusal; None if nothing is."""
    nearest = error.nearest_radius
    if any(is_crossed(scan, i, error.radius) for i in scan.crossings(error.radius)):
        return "it can be gripped"
    if nearest is None or not error.margin < 0.0:
        return "no nearest radius, or a margin that is met"
    low, high = sorted((error.radius, nearest))
    inside = [scan.radii[i] for i in scan.coiled() if low < scan.radii[i] < high]
    if inside and max(min(r - low, high - r) for r in inside) > scan.slack(high):
        return "a nearer radius can be gripped"
    wrap = curve.wrap_for_radius(nearest)
    step = scan.pressures[0]
    limit = curve.gripper.pressure_max
    around = [p for p in (wrap.pressure - 0.1 * step, wrap.pressure + 0.1 * step) if p > 0.0]
    sides = [curve.wrap_at_pressure(min(p, limit)) for p in around]
    true = {
        "pressure limit": math.isclose(wrap.pressure, limit, rel_tol=1e-9),
        "turns of this": any(side.turns < scan.required for side in sides),
        "closes": any(side.object_radius < 1e-3 * scan.outer_radius for side in sides),
        "snaps": bool(scan.snapped),
        "turns back": len(sides) == 2
        and (sides[0].object_radius - nearest) * (sides[1].object_radius - nearest) > 0.0,
    }
    stated = [word for word in true if word in error.constraint]
    return None if len(stated) == 1 and true[stated[0]] else f"untrue: {error.constraint}"


def judge_no_coil(scan: Scan, error: NoCoilError) -> str | None:
    """Return what is untrue in the statement that nothing coils; None if nothing is."""
    if scan.coiled():
        return "it coils"
    # Where it says that the coil closes, the turns are those with room inside, else all of them.
    counted = [
        turns
        for turns, radius in zip(scan.turns, scan.radii, strict=True)
        if radius > 0.0 or error.closes_at is None
    ]
    # A sharp maximum between samples is missed by a little.
    if max(counted, default=0.0) > 1.05 * error.turns:
        return f"{max(counted):.4g} turns"
    if error.closes_at is None:
        untrue = not (scan.radii[-1] > 0.0 or error.at_actuator_limit)
        return "closed at the limit that is to be raised" if untrue else None
    i = min(int(np.searchsorted(scan.pressures, error.closes_at)), len(scan.pressures) - 1)
    there = scan_of(scan.gripper, *path_of(scan.gripper, [error.closes_at], scan.states[i]))
    closed = there.radii[0] <= scan.slack(0.0) + LEAST_RADIUS * scan.outer_radius
    return None if closed else f"open at {error.closes_at:.6g} Pa"


def axes_for(gripper: Gripper, rng: np.random.Generator) -> list[Vector | None]:
    """Return axes: fitted, the coil's own at some pressure, tilted from it, symmetric."""
    symmetric = SYMMETRIC[int(rng.integers(len(SYMMETRIC)))]
    try:
        curve = WrapCurve(replace(gripper, object_axis=None))
    except SpiralError:
        return [None, symmetric, random_direction(rng), random_direction(rng), (1.0, 0.0, 0.0)]
    share = rng.uniform()
    pressure = (1.0 - share) * curve.pressure_min + share * curve.pressure_max
    own = curve.wrap_at_pressure(pressure).axis
    tilted = np.array(own) + math.tan(math.radians(30.0)) * rng.uniform() * rng.normal(size=3)
    x, y, z = (tilted / np.linalg.norm(tilted)).tolist()
    return [None, own, (x, y, z), symmetric, random_direction(rng)]


def radii_for(curve: WrapCurve, rng: np.random.Generator) -> list[float]:
    """Return radii over and beyond the range, and its ends to the last digit."""
    low, high = curve.radius_min, curve.radius_max
    ends = [low, high, low * (1.0 - 1e-9), high * (1.0 + 1e-9), 0.5 * low, 2.0 * high]
    inside = rng.uniform(low, high, RADII - len(ends) - 4)
    anywhere = np.exp(rng.uniform(math.log(1e-6), math.log(0.2), 4))
    return [*ends, *inside.tolist(), *anywhere.tolist()]


def ask(gripper: Gripper, scan: Scan, rng: np.random.Generator) -> list[str]:
    """Ask one gripper in one mount :data:`RADII` questions; return each outcome."""
    try:
        curve = WrapCurve(gripper)
    except NoCoilError as error:
        fault = judge_no_coil(scan, error)
        return [f"FAULT {fault} ({error})" if fault else "refused: too few turns"] * RADII
    return [outcome_of(scan, curve, radius) for radius in radii_for(curve, rng)]


def outcome_of(scan: Scan, curve: WrapCurve, radius: float) -> str:
    """Return how one question ended."""
    try:
        fault = judge_answer(scan, curve.wrap_for_radius(radius), radius)
    except NotGrippableError as error:
        fault = judge_refusal(scan, curve, error)
        word = next(w for w in ("thick", "thin", "between") if w in error.constraint)
        return f"FAULT {fault} ({error})" if fault else f"refused: {word}"
    return f"FAULT {fault} ({radius:.6g} m)" if fault else "answered"


def ask_all(questions: int, only: Sequence[int] | None = None) -> tuple[Counter[str], list[str]]:
    """Return how often each outcome came, and the faults with the mounts they came in."""
    outcomes: Counter[str] = Counter()
    faults: list[str] = []
    names = available_grippers()
    mounts = range(max(1, questions // (AXES * RADII))) if only is None else only
    for index in mounts:
        rng = np.random.default_rng([SEED, index])
        name = names[index % len(names)]
        turn = index // len(names)
        direction = SYMMETRIC[turn] if turn < len(SYMMETRIC) else random_direction(rng)
        scale = 0.0 if turn == len(SYMMETRIC) else G
        x, y, z = (scale * component for component in direction)
        gripper = replace(load_gripper(name), gravity=(x, y, z), object_axis=None)
        mounted = gripper
        try:
            pressures, path = path_of(gripper)
            for axis in axes_for(gripper, rng):
                mounted = replace(gripper, object_axis=axis)
                for outcome in ask(mounted, scan_of(mounted, pressures, path), rng):
                    outcomes["FAULT" if "FAULT" in outcome else outcome] += 1
                    if "FAULT" in outcome:
                        faults.append(f"{_mount(index, mounted)}: {outcome}")
        except SolverError as error:
            outcomes["FAULT"] += 1
            faults.append(f"{_mount(index, mounted)}: {error}")
    return outcomes, faults


def _mount(index: int, gripper: Gripper) -> str:
    return f"{index}: {gripper.name}, gravity {gripper.gravity}, axis {gripper.object_axis}"


def measure(effort: Effort) -> Section:
    """Ask the questions and count."""
    return section(*ask_all(effort.questions))


def section(outcomes: Counter[str], faults: list[str]) -> Section:
    """Return the counts as a table."""
    total = sum(outcomes.values())
    rows = [(kind, f"{count:,}") for kind, count in outcomes.most_common() if kind != "FAULT"]
    return Section(
        (
            Table(
                f"Perfect wrap: {total:,} random questions",
                ("outcome, true as the scan shows", "questions"),
                (*rows, ("wrong answer, untrue reason or solver error", f"{len(faults):,}")),
                "The shipped grippers under gravity from every side, symmetric ones on purpose; "
                "the object's axis fitted, the coil's own, tilted from it by some 30°, symmetric, "
                f"or any. The scan takes {STATIONS} steps. {'; '.join(faults[:5])}".strip(),
            ),
        ),
        {"questions": float(total), "faults": float(len(faults))},
    )
