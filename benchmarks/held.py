# SPDX-License-Identifier: Apache-2.0
"""Random grips, window found or refused with a true reason: ``python -m benchmarks.held``.

The shipped grippers in random lengths and mounts, random cylinders, friction and closing. Each
window is checked for balance and order, a tenth of the losses by following the coil's fall; a
refusal's reason by another way than the one that found it: the free tube's distance, or the same
grip on half as many elements again. With ``--results FILE`` verdicts are kept one by one and an
interrupted run goes on. Some half an hour for 1,000 on one core.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.cases import SEED, random_direction
from benchmarks.command import wide_console
from benchmarks.report import show
from benchmarks.results import Table
from benchmarks.robustness import WORKERS
from spiral_core import (
    Closing,
    Gripper,
    GripSetup,
    GripWindow,
    NoCoilError,
    NotGrippableError,
    SolverError,
    WindowEnd,
    WrapCurve,
    follow_loss,
    grip_window,
    gripper_from_actuator,
    lay_into_coil,
    solve_rod,
)
from spiral_gripper import available_grippers, load_description

# Of the weight of the tube.
BALANCE = 1e-6
# Every so many losses are followed to where the coil comes to rest, and refusals asked again on so
# many times the elements.
FOLLOWED = 10
FINER = 1.5


class Verdict(NamedTuple):
    """How one grip ended.

    Attributes:
        kind: in words.
        off: onset of the wrap over the tip criterion; None without a wrap.
        seed: repeats it.
        seconds: of CPU.
    """

    kind: str
    off: float | None
    seed: int
    seconds: float


def random_setup(seed: int) -> GripSetup:
    """Return a random grip: shipped actuators, 0.25 to 0.6 m, any mount, any radius in range.

    Raises:
        NoCoilError: the gripper makes no coil.
        NotGrippableError: its coil wraps no such radius.
    """
    rng = np.random.default_rng((SEED, seed))
    names = available_grippers()
    described = load_description(names[rng.integers(len(names))])
    tube = replace(described.actuator.tube, length=float(rng.uniform(0.25, 0.6)))
    gripper = gripper_from_actuator(
        described.gripper.name, replace(described.actuator, tube=tube), density=described.density
    )
    if rng.uniform() < 0.5:
        x, y, z = random_direction(rng)
        gripper = replace(gripper, gravity=(9.80665 * x, 9.80665 * y, 9.80665 * z))
    curve = WrapCurve(gripper)
    radius = float(rng.uniform(max(0.004, curve.radius_min), 1.05 * curve.radius_max))
    closing = Closing.SLOW if rng.uniform() < 0.5 else Closing.FRICTIONLESS
    return lay_into_coil(
        gripper, radius, friction=float(rng.uniform(0.05, 1.0)), closing=closing, curve=curve
    )


def judge(seed: int) -> Verdict:
    """Return what became of a random grip."""
    begin = time.process_time()
    kind, off = _judged(seed)
    return Verdict(kind, off, seed, time.process_time() - begin)


def _judged(seed: int) -> tuple[str, float | None]:
    """Return how a random grip ended, and its onset over the tip criterion."""
    try:
        setup = random_setup(seed)
    except (NoCoilError, NotGrippableError) as error:
        return f"refused before closing: {type(error).__name__}", None
    try:
        window = grip_window(setup)
    except NotGrippableError:
        clear = _clearance(setup.gripper, setup)
        return "refused: hanging tube in the way" if clear < 0.0 else "WRONG: tube is clear", None
    except SolverError as error:
        return f"no answer: {error.status.name}", None
    wrong = _wrong(window)
    if wrong:
        return f"WRONG: {wrong}", None
    sampled = seed % FOLLOWED == 0
    if window.onset_wrap is None:
        if sampled and _is_held_on_finer_elements(setup):
            return "WRONG: held on finer elements", None
        confirmed = ", the same on finer elements" if sampled else ""
        return f"refused: tip never touches, {window.end.name}{confirmed}", None
    off = window.onset_wrap / float(setup.tip_pressure or math.nan)
    if window.end is WindowEnd.LOST and sampled:
        rest = follow_loss(window)
        if rest is not None and rest.is_wrapped:
            return "WRONG: still wrapped after the loss", off
        if rest is not None and rest.contact_length > 0.5 * window.points[-1].contact_length:
            return "WRONG: keeps its contact after the loss", off
        return "window, loss confirmed by following the fall", off
    return f"window, ended by: {window.end.name}", off


def _is_held_on_finer_elements(setup: GripSetup) -> bool:
    """Return whether a grip that was refused is held on more elements."""
    finer = replace(setup, elements=math.ceil(FINER * setup.element_count))
    return grip_window(finer).onset_wrap is not None


def _clearance(gripper: Gripper, setup: GripSetup) -> float:
    """Return the distance between the free hanging tube and the object's surface [m]."""
    shape = gripper.unloaded_shape(0.0)
    state = solve_rod(gripper.rod(shape), gripper.load(shape))
    offsets = state.positions - np.asarray(setup.obstacle.position)
    distance = np.linalg.norm(np.cross(offsets, setup.axis), axis=1)
    return float(distance.min() - setup.obstacle.shape.feature_radius - gripper.tube.outer_radius)


def _wrong(window: GripWindow) -> str:
    """Return what is wrong with a window, or nothing."""
    order = [window.onset_wrap, window.onset_curling, window.loss]
    known = [pressure for pressure in order if pressure is not None]
    if known != sorted(known):
        return "onsets out of order"
    gripper = window.setup.gripper
    for point in window.points:
        shape = gripper.unloaded_shape(point.pressure)
        weight = np.asarray(gripper.weight(shape)) * shape.backbone_length
        total = point.state.contact_forces[0].sum(axis=0) + weight + point.base_reaction[:3]
        scale = gripper.weight_per_length * gripper.tube.length + point.normal_force
        if not np.abs(total).max() <= BALANCE * scale:
            return "forces do not balance"
        if not point.state.gaps.min() > -1e-3 * point.outer_radius:
            return "tube inside of the object"
        if not point.state.stable:
            return "a state is not certified"
    return ""


def judge_all(count: int, kept: Path | None, workers: int) -> list[Verdict]:
    """Judge the first ``count`` random grips, but for those that a file has already."""
    verdicts = []
    if kept is not None and kept.exists():
        verdicts = [Verdict(**json.loads(line)) for line in kept.read_text().splitlines()]
    verdicts = [verdict for verdict in verdicts if verdict.seed < count]
    missing = sorted(set(range(count)) - {verdict.seed for verdict in verdicts})
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        for verdict in pool.map(judge, missing):
            verdicts.append(verdict)
            if kept is not None:
                with kept.open("a", encoding="utf-8") as lines:
                    lines.write(json.dumps(verdict._asdict()) + "\n")
    return verdicts


def main() -> None:
    """Judge many random grips and print how they ended."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--results", type=Path, help="verdicts are kept here, one a line")
    parser.add_argument("--workers", type=int, default=WORKERS, help="processes")
    arguments = parser.parse_args()
    verdicts = judge_all(arguments.count, arguments.results, arguments.workers)
    kinds = Counter(verdict.kind for verdict in verdicts)
    offs = np.array([100.0 * (v.off - 1.0) for v in verdicts if v.off is not None])
    seconds = np.array([verdict.seconds for verdict in verdicts])
    spread = "No window was found."
    if offs.size:
        spread = (
            f"The wrap begins {np.median(offs):+.1f} % from the tip criterion in the median, "
            f"{offs.min():+.1f} to {offs.max():+.1f} % at the extremes."
        )
    spread += f" CPU time: {np.median(seconds):.2f} s in the median, {seconds.max():.1f} s at most."
    rows = tuple((kind, str(number)) for kind, number in kinds.most_common())
    show(Table(f"{len(verdicts)} random grips", ("outcome", "grips"), rows, spread), wide_console())
    for verdict in verdicts:
        if verdict.kind.startswith(("WRONG", "no answer")):
            print(f"seed {verdict.seed}: {verdict.kind}")


if __name__ == "__main__":
    main()
