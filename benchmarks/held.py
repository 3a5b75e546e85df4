# SPDX-License-Identifier: Apache-2.0
"""Random grips, window found or refused with a true reason: ``python -m benchmarks.held``.

The shipped grippers in random lengths and mounts, random cylinders, friction and closing. Each
window is checked for balance and order, a tenth of the losses by following the coil's fall; each
refusal's reason by another way than the one that found it. Some half an hour for 1,000 on one core.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
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
    follow_contact,
    grip_window,
    gripper_from_actuator,
    lay_into_coil,
    solve_rod,
)
from spiral_gripper import available_grippers, load_description

CHUNK = 5
# Of the weight of the tube.
BALANCE = 1e-6
# Every so many losses are followed to where the coil comes to rest.
FOLLOWED = 10


class Verdict(NamedTuple):
    """How one grip ended.

    Attributes:
        kind: in words.
        off: onset of the wrap over the tip criterion; NaN without a wrap.
        seed: repeats it.
    """

    kind: str
    off: float
    seed: int


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
    try:
        setup = random_setup(seed)
    except (NoCoilError, NotGrippableError) as error:
        return Verdict(f"refused before closing: {type(error).__name__}", math.nan, seed)
    try:
        window = grip_window(setup)
    except NotGrippableError:
        clear = _clearance(setup.gripper, setup)
        kind = "refused: hanging tube in the way" if clear < 0.0 else "WRONG: tube is clear"
        return Verdict(kind, math.nan, seed)
    except SolverError as error:
        return Verdict(f"no answer: {error.status.name}", math.nan, seed)
    wrong = _wrong(window)
    if wrong:
        return Verdict(f"WRONG: {wrong}", math.nan, seed)
    if window.onset_wrap is None:
        return Verdict(f"refused: tip never touches, {window.end.name}", math.nan, seed)
    off = window.onset_wrap / float(setup.tip_pressure or math.nan)
    if window.end is WindowEnd.LOST and seed % FOLLOWED == 0:
        kept = _kept_after_loss(window)
        if kept > 0.5:
            return Verdict("WRONG: keeps its contact after the loss", off, seed)
        return Verdict("window, loss confirmed by following the fall", off, seed)
    return Verdict(f"window, ended by: {window.end.name}", off, seed)


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


def _kept_after_loss(window: GripWindow) -> float:
    """Return the fraction of contact that is left after following the coil's fall."""
    last, loss = window.points[-1], float(window.loss or 0.0)
    limit = window.setup.gripper.pressure_max
    beyond = min(limit, loss + 0.01 * limit)
    path = follow_contact([window.setup.closing_problem(beyond)], start=last.state)
    after = path.states[-1] if path.states else path.events[-1].last
    return float(after.contact_lengths[0]) / last.contact_length


def main() -> None:
    """Judge many random grips and print how they ended."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    count = parser.parse_args().count
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(WORKERS, mp_context=context) as pool:
        verdicts = list(pool.map(judge, range(count), chunksize=CHUNK))
    kinds = Counter(verdict.kind for verdict in verdicts)
    offs = np.array([verdict.off for verdict in verdicts])
    offs = 100.0 * (offs[np.isfinite(offs)] - 1.0)
    spread = "No window was found."
    if offs.size:
        spread = (
            f"The wrap begins {np.median(offs):+.1f} % from the tip criterion in the median, "
            f"{offs.min():+.1f} to {offs.max():+.1f} % at the extremes."
        )
    rows = tuple((kind, str(number)) for kind, number in kinds.most_common())
    show(Table(f"{count} random grips", ("outcome", "grips"), rows, spread), wide_console())
    for verdict in verdicts:
        if verdict.kind.startswith(("WRONG", "no answer")):
            print(f"seed {verdict.seed}: {verdict.kind}")


if __name__ == "__main__":
    main()
