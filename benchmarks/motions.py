# SPDX-License-Identifier: Apache-2.0
"""Rods in time by our solver and by PyElastica: cosseratbench's pendulum, and a coil that closes.

The coil is the 70 degree design without weight: straight at first, its rest strain rises within a
second to the one that fits a cylinder of 15 mm radius, and stays. Both codes have the same
stiffness (shear and stretch, too), mass and drag. Processor times, since PyElastica takes long.
"""

from __future__ import annotations

import importlib
import math
import time
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from cosseratbench.experiment import Result, run
from cosseratbench.registry import load_experiment, load_solver

from benchmarks.cases import Array
from benchmarks.cosserat_adapter import SpiralSolver
from benchmarks.results import Effort, Section, Table
from spiral_core import Damping, Inertia, Rod, RodProblem, solve_motion
from spiral_core import Section as CrossSection

LENGTH, RADIUS, MASS = 0.36, 5.55625e-3, 0.0283
TWISTING, BENDING = 1.8e-4, 2.7e-4
# Rest strain in the end [1/m], how long it rises [s], drag [1/s]; when the tips are compared [s].
COILED, RISE, DRAG = np.array((-13.6, 0.0, 45.0)), 1.0, 2.0
LOOKS = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
SHEAR_COEFFICIENT = 27.0 / 28.0  # PyElastica's
# PyElastica's elements, and how far below its limit of stability it steps.
THEIRS, SAFETY = (60, 120, 240), 0.5
# Ours: elements, tolerance; among these the cheapest that errs no more than PyElastica counts.
OURS = (
    (16, 1e-4), (24, 1e-4), (32, 1e-4), (24, 3e-5), (32, 3e-5), (24, 1e-5), (32, 1e-5), (48, 1e-5),
    (32, 3e-6), (48, 3e-6), (64, 3e-6), (96, 1e-6),
)  # fmt: skip
# Both are judged by our own solver with many elements and steps of a millisecond.
EXACT, SHORT = (240, 1e-7), 1e-3


Row = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Answer:
    """Where the tip is at each look (n, 3) [m], and the processor time [s]."""

    tips: Array
    spent: float

    def error(self, exact: Array) -> float:
        """Return the largest distance of the tip from where it is, in lengths."""
        return float(np.linalg.norm(self.tips - exact, axis=1).max()) / LENGTH


def ours(elements: int, tolerance: float, longest_step: float = 0.02) -> Answer:
    """Return what our solver finds."""
    second, area = 0.25 * math.pi * RADIUS**4, math.pi * RADIUS**2
    section = CrossSection(
        (TWISTING, BENDING, BENDING),
        extension=BENDING / second * area,
        shear=SHEAR_COEFFICIENT * TWISTING / (2.0 * second) * area,
    )

    def problem(moment: float) -> RodProblem:
        torsion, _, curvature = (min(moment / RISE, 1.0) * COILED).tolist()
        return RodProblem(Rod(LENGTH, section, RADIUS, (torsion, 0.0, curvature)))

    begin = time.process_time()
    motion = solve_motion(
        problem, Inertia.round(MASS / area, RADIUS), (0.0, *LOOKS), damping=Damping(0.0, 0.0, DRAG),
        elements=elements, longest_step=longest_step, tolerance=tolerance,
    )  # fmt: skip
    return Answer(motion.positions[1:, -1], time.process_time() - begin)


def theirs(elements: int) -> Answer:
    """Return what PyElastica finds; its first element is clamped at its middle, the origin."""
    elastica: Any = importlib.import_module("elastica")
    parts = ("BaseSystemCollection", "Constraints", "Damping")
    simulator: Any = type("Simulator", tuple(getattr(elastica, part) for part in parts), {})()
    second, h = 0.25 * math.pi * RADIUS**4, LENGTH / (elements - 0.5)
    density = MASS / (math.pi * RADIUS**2)
    young, shear = BENDING / second, TWISTING / (2.0 * second)
    rod = elastica.CosseratRod.straight_rod(
        elements, np.array((-0.5 * h, 0.0, 0.0)), np.array((1.0, 0.0, 0.0)),
        np.array((0.0, 1.0, 0.0)), elements * h, RADIUS, density, youngs_modulus=young,
        shear_modulus=shear,
    )  # fmt: skip
    fast = math.sqrt(young / density)
    limit = min(h / fast, 4.0 * h**2 / (math.pi**2 * RADIUS * fast))
    steps = math.ceil(LOOKS[0] / (SAFETY * limit))
    step = np.float64(LOOKS[0] / steps)
    simulator.append(rod)
    simulator.constrain(rod).using(
        elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    simulator.dampen(rod).using(
        elastica.AnalyticalLinearDamper, uniform_damping_constant=DRAG, time_step=step
    )
    simulator.finalize()
    stepper, moment, tips = elastica.PositionVerlet(), np.float64(0.0), []
    rest = COILED[[1, 2, 0], None]  # its directors are our (y, z, x)
    stepper.step(simulator, moment, np.float64(1e-12))  # compiles
    begin = time.process_time()
    for _ in LOOKS:
        for _ in range(steps):
            rod.rest_kappa[...] = min(float(moment) / RISE, 1.0) * rest
            moment = stepper.step(simulator, moment, step)
        tips.append(rod.position_collection[:, -1].copy())
    return Answer(np.array(tips), time.process_time() - begin)


def pendulum(peers: bool) -> tuple[list[Row], dict[str, float]]:
    """Return the rows and values of cosseratbench's pendulum."""
    experiment = load_experiment("pendulum")

    def timed(solver: Any) -> tuple[Result, float]:  # noqa: ANN401
        begin = time.process_time()
        result = run(experiment, solver)
        return result, time.process_time() - begin

    timed(SpiralSolver())  # loads the kernels
    result, spent = timed(SpiralSolver())
    error = result.metrics["period_error"]
    values = {"pendulum_error": error, "pendulum_time": spent}
    cells = ("", "", "")
    if peers:
        theirs = load_solver("pyelastica")
        timed(theirs)  # compiles
        peer, long = timed(theirs)
        values["pendulum_peer_error"] = peer.metrics["period_error"]
        values["pendulum_ratio"] = long / spent
        cells = (f"{values['pendulum_peer_error']:.2e}", f"{long:.2f} s", f"{long / spent:.1f} ×")
    return [("pendulum, period", f"{error:.2e}", f"{spent:.2f} s", *cells)], values


def coil(effort: Effort, peers: bool) -> tuple[list[Row], dict[str, float]]:
    """Return the rows and values of the coil that closes."""
    full = effort.simulated >= 1.0
    ours(*OURS[0])  # loads the kernels
    exact = ours(*EXACT, SHORT).tips if full else ours(*OURS[-1]).tips
    found = [ours(*settings) for settings in (OURS if full else OURS[:1])]
    rows: list[Row] = []
    values: dict[str, float] = {}
    for elements in THEIRS if peers else ():
        peer = theirs(elements)
        bound = peer.error(exact)
        fit = [answer for answer in found if answer.error(exact) <= bound]
        best = min(fit, key=lambda answer: answer.spent)
        values[f"coil_{elements}_error"] = bound
        values[f"coil_{elements}_ratio"] = peer.spent / best.spent
        rows.append(
            (
                f"coil, tip; PyElastica with {elements} elements",
                f"{best.error(exact):.1e}", f"{best.spent:.2f} s", f"{bound:.1e}",
                f"{peer.spent:.2f} s", f"{peer.spent / best.spent:.1f} ×",
            )
        )  # fmt: skip
    if not rows:
        rows = [
            ("coil, tip", f"{found[0].error(exact):.1e}", f"{found[0].spent:.2f} s", "", "", "")
        ]
    return rows, values


def measure(effort: Effort) -> Section:
    """Compare both on the pendulum and on the coil."""
    peers = "pyelastica" in effort.peers and find_spec("elastica") is not None
    swung, closed = pendulum(peers), coil(effort, peers)
    note = (
        "Errors: of the period, and the largest distance of the tip at six times within 1.5 s, in "
        "lengths. Of ours, the cheapest setting that errs no more than PyElastica."
    )
    table = Table(
        "Rods in time", ("what", "ours errs", "takes", "PyElastica errs", "takes", "/ ours"),
        tuple(swung[0] + closed[0]), note if peers else "PyElastica: not installed or not asked.",
    )  # fmt: skip
    return Section((table,), swung[1] | closed[1])
