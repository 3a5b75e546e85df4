# SPDX-License-Identifier: Apache-2.0
"""Random grips: window found or refused with a true reason.

The shipped grippers in random lengths and mounts, random cylinders, friction and closing. Each
window is checked for balance and order, and for what a pull at the wrap's onset finds. A tenth of
them is computed again on half as many elements again, and its loss is followed to where the coil
rests: a loss without a snap is *wrong*. A refusal's reason is checked by another way than the one
that found it: the free tube's distance, or the same grip on more elements. Verdicts are kept in
``benchmarks/results/held.jsonl`` as they come, so that a run that was interrupted goes on;
``python -m benchmarks.held`` names another file.
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
from benchmarks.report import RESULTS, show
from benchmarks.results import Effort, Section, Table
from benchmarks.sample import WORKERS
from spiral_core import (
    Closing,
    Gripper,
    GripSetup,
    NoCoilError,
    NotGrippableError,
    SolverError,
    SpiralError,
    WrapCurve,
    grip_window,
    gripper_from_actuator,
    holding_force,
    lay_into_coil,
    solve_rod,
)
from spiral_core.grip.window import GripPoint, GripWindow, WindowEnd, follow_loss
from spiral_core.rod.contact.solve import follow_contact
from spiral_gripper import available_grippers, load_description

# Of the weight of the tube and the normal forces.
BALANCE = 1e-6
# One of so many answers is asked again on so many times the elements, and its loss followed.
SAMPLED = 10
FINER = 1.5
# An end that lets go takes most of the coil along where less than this of its contact stays.
MOST = 0.5
# Of the way beyond a loss, to see the snap.
SMALL = 0.03
KEPT = RESULTS / "held.jsonl"


class Verdict(NamedTuple):
    """How one grip ended.

    Attributes:
        kind: in words.
        off: onset of the wrap over the tip criterion; None without a wrap.
        seed: repeats it.
        seconds: of CPU, without the checks.
        remaining: contact after the loss over contact before it; None where it was not followed.
        wrap_change, loss_change: of onset and loss on finer elements, as fractions, or None.
    """

    kind: str
    off: float | None
    seed: int
    seconds: float
    remaining: float | None = None
    wrap_change: float | None = None
    loss_change: float | None = None


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
    try:
        setup = random_setup(seed)
        window = grip_window(setup)
    except (NoCoilError, NotGrippableError, SolverError) as error:
        spent = time.process_time() - begin
        return Verdict(_refused(seed, error), None, seed, spent)
    verdict = Verdict(f"window, {window.end.value}", None, seed, time.process_time() - begin)
    wrong = _wrong(window)
    if wrong:
        return verdict._replace(kind=f"WRONG: {wrong}")
    sampled = seed % SAMPLED == 0
    if window.onset_wrap is None:
        if sampled and _finer(setup).onset_wrap is not None:
            return verdict._replace(kind="WRONG: held on finer elements")
        confirmed = ", the same on finer elements" if sampled else ""
        return verdict._replace(kind=f"refused: no touch, {window.end.value}{confirmed}")
    verdict = verdict._replace(off=window.onset_wrap / float(setup.tip_pressure or math.nan))
    unheld = _unheld(window.at(window.onset_wrap))
    if unheld:
        return verdict._replace(kind=unheld)
    return _sampled(verdict, window) if sampled else verdict


def _unheld(point: GripPoint) -> str:
    """Return what is wrong with the pull away from the base at the onset of the wrap, or nothing.

    With friction a wrapped coil holds something: its ends press on the object.
    """
    held = holding_force(point)
    if math.isnan(held.force):
        return f"no answer: a pull, {held.end.value}"
    return "" if held.force > 0.0 else "WRONG: nothing is held at the onset"


def _refused(seed: int, error: SpiralError) -> str:
    """Return why a random grip has no window, and whether that is true."""
    if isinstance(error, SolverError):
        return f"no answer: {error.status.name}"
    try:
        setup = random_setup(seed)
    except (NoCoilError, NotGrippableError):
        return f"refused before closing: {type(error).__name__}"
    clear = _clearance(setup.gripper, setup)
    return "refused: hanging tube in the way" if clear < 0.0 else "WRONG: tube is clear"


def _sampled(verdict: Verdict, window: GripWindow) -> Verdict:
    """Return a verdict with what follows the loss, and what finer elements change."""
    finer = _finer(window.setup)
    verdict = verdict._replace(
        wrap_change=_change(window.onset_wrap, finer.onset_wrap),
        loss_change=_change(window.loss, finer.loss),
    )
    if finer.onset_wrap is None:
        return verdict._replace(kind="WRONG: not held on finer elements")
    if window.end is not WindowEnd.LOST:
        return verdict
    rest = follow_loss(window)
    if rest is None:
        return verdict._replace(kind="window, the end lets go and finds no rest")
    remaining = rest.contact_length / window.points[-1].contact_length
    if rest.is_wrapped:
        how = "followed: a part snaps, the end stays wrapped"
        kind = f"window, {how}" if _snaps(window, rest) else "WRONG: nothing snaps at the loss"
        return verdict._replace(kind=kind, remaining=remaining)
    how = "most of the coil with it" if remaining < MOST else "most of the contact stays"
    return verdict._replace(kind=f"window, the end lets go, followed: {how}", remaining=remaining)


def _snaps(window: GripWindow, rest: GripPoint) -> bool:
    """Return whether a branch of stable states ends between the window's last one and a rest.

    In small increments: a snap of a part of the coil may be stepped over.
    """
    problem = window.setup.closing_problem(rest.pressure)
    start = window.points[-1].state
    return bool(follow_contact([problem], start=start, largest_increment=SMALL).events)


def _finer(setup: GripSetup) -> GripWindow:
    """Return the window on more elements."""
    return grip_window(replace(setup, elements=math.ceil(FINER * setup.element_count)))


def _change(pressure: float | None, finer: float | None) -> float | None:
    """Return how far two pressures differ, as a fraction; None where one of them is missing."""
    return None if pressure is None or finer is None else abs(finer / pressure - 1.0)


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
        weight = np.asarray(gripper.load(shape).distributed) * shape.backbone_length
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


def section(verdicts: list[Verdict]) -> Section:
    """Return how random grips ended: a table and its figures."""
    kinds = Counter(verdict.kind for verdict in verdicts)
    wrong = [v for v in verdicts if _is_unanswered(v.kind)]
    rows = [(kind, str(number)) for kind, number in kinds.most_common()]
    rows += [
        (what, _spread([100.0 * value for value in values if value is not None]))
        for what, values in (
            ("wrap begins off the tip criterion, %", [_percent_off(v) for v in verdicts]),
            ("... changed by finer elements by, %", [v.wrap_change for v in verdicts]),
            ("loss changed by finer elements by, %", [v.loss_change for v in verdicts]),
            ("contact that stays after the loss, %", [v.remaining for v in verdicts]),
        )
    ]
    rows.append(("processor time, s", _spread([v.seconds for v in verdicts])))
    note = "Spreads: median, least and most. " + "; ".join(
        f"seed {verdict.seed}: {verdict.kind}" for verdict in wrong
    )
    values = {
        "grips": float(len(verdicts)),
        "windows": float(sum(v.off is not None for v in verdicts)),
        "wrong": float(len(wrong)),
    }
    columns = ("outcome", "grips; or median (least, most)")
    title = f"{len(verdicts):,} random grips"
    return Section((Table(title, columns, tuple(rows), note.strip()),), values)


def _is_unanswered(kind: str) -> bool:
    """Return whether a verdict is wrong, or says that no answer was found."""
    return kind.startswith(("WRONG", "no answer")) or WindowEnd.NOT_FOLLOWED.value in kind


def _percent_off(verdict: Verdict) -> float | None:
    """Return how far the onset of the wrap is from the tip criterion, as a fraction."""
    return None if verdict.off is None else verdict.off - 1.0


def _spread(values: list[float]) -> str:
    """Return median, least and most of some figures."""
    if not values:
        return "none"
    return f"{np.median(values):.3g} ({min(values):.3g}, {max(values):.3g}) of {len(values)}"


def measure(effort: Effort) -> Section:
    """Judge the sample; verdicts that are kept are not computed again."""
    return section(judge_all(effort.grips, KEPT, WORKERS))


def main() -> None:
    """Judge many random grips and print how they ended."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--results", type=Path, help="verdicts are kept here, one a line")
    parser.add_argument("--workers", type=int, default=WORKERS, help="processes")
    arguments = parser.parse_args()
    verdicts = judge_all(arguments.count, arguments.results, arguments.workers)
    for table in section(verdicts).tables:
        show(table, wide_console())


if __name__ == "__main__":
    main()
