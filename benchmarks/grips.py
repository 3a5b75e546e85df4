# SPDX-License-Identifier: Apache-2.0
"""Random rods that wrap random cylinders: ``python -m benchmarks.grips --count 2000``.

Each answer is checked by its equations of equilibrium. Some ten minutes on one core.
"""

from __future__ import annotations

import argparse
import math
import time
from collections import Counter
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.cases import (
    OUTER_RADIUS,
    SECOND_MOMENT,
    SEED,
    WEIGHT,
    Array,
    Vector,
    random_direction,
)
from benchmarks.command import wide_console
from benchmarks.report import show
from benchmarks.results import Section, Table, milli
from benchmarks.sample import solve_all, spread
from spiral_core import (
    Cylinder,
    Obstacle,
    Rod,
    RodLoad,
    RodProblem,
    RodState,
    RodStatus,
    SolverError,
)
from spiral_core import (
    Section as Stiffness,
)
from spiral_core.rod.contact.solve import follow_contact
from spiral_core.rod.state import RodPath

# How far the answer may be from balance and from the laws of contact.
BALANCE = 1e-6  # of the forces at work
PENETRATION = 1e-3  # of the rod's radius
CONE = 1e-6  # of the normal force
# Moments from strains and from forces differ by the discretization, which is of second order where
# contact begins.
MOMENTS = 0.03  # of the largest moment


@dataclass(frozen=True, slots=True)
class Grip:
    """One rod that is to wrap one cylinder.

    Args:
        length: of the rod [m].
        modulus: Young's [Pa].
        rest_strain: of the curled rod [1/m].
        gravity: weight per length [N/m].
        radius: of the cylinder [m].
        point: on its axis [m].
        axis: its direction, a unit vector.
        friction: Coulomb's coefficient.
        away: how far the cylinder is at first [m]; it comes when the rod has half curled.
    """

    length: float
    modulus: float
    rest_strain: Vector
    gravity: Vector
    radius: float
    point: Vector
    axis: Vector
    friction: float
    away: float

    def problem(self, curled: float, loaded: bool = True, there: bool = True) -> RodProblem:
        """Return the problem with a fraction of the rest strain, with gravity, and the cylinder."""
        bending = self.modulus * SECOND_MOMENT
        torsion, across, curvature = (curled * u for u in self.rest_strain)
        x, y, z = self.point
        rod = Rod(
            self.length,
            Stiffness((2.0 / 3.0 * bending, bending, bending)),
            OUTER_RADIUS,
            (torsion, across, curvature),
        )
        point = (x, y if there else y + self.away, z)
        return RodProblem(
            rod,
            RodLoad(distributed=self.gravity if loaded else (0.0, 0.0, 0.0)),
            obstacles=(Obstacle.along(Cylinder(self.radius), point, self.axis, self.friction),),
        )

    def stations(self) -> list[RodProblem]:
        """Return what happens in turn: gravity, curling, and the cylinder's coming."""
        if self.away == 0.0:
            return [self.problem(0.0), self.problem(1.0)]
        return [
            self.problem(0.0, there=False),
            self.problem(0.5, there=False),
            self.problem(0.5),
            self.problem(1.0),
        ]


def random_grip(index: int) -> Grip:
    """Return one grip of the sample; the same index gives the same one."""
    rng = np.random.default_rng([SEED, 13, index])
    radius = math.exp(rng.uniform(math.log(8e-3), math.log(40e-3)))
    rho = (radius + OUTER_RADIUS) * rng.uniform(0.75, 1.1)
    angle = math.radians(rng.uniform(55.0, 80.0))
    hand = rng.choice((-1.0, 1.0))
    torsion, curvature = hand * math.sin(angle) * math.cos(angle) / rho, math.sin(angle) ** 2 / rho
    turns = rng.uniform(0.7, 2.0)
    coil = np.array((torsion, 0.0, curvature)) * rho / math.sin(angle)
    tilt = Rotation.from_rotvec(np.radians(rng.uniform(0.0, 5.0)) * np.array(random_direction(rng)))
    axis = tilt.apply(coil / np.linalg.norm(coil))
    weight = WEIGHT * rng.choice((0.0, rng.uniform()))
    gx, gy, gz = (weight * g for g in random_direction(rng))
    ax, ay, az = axis.tolist()
    # The straight rod is clear of the cylinder: the shortest way between both is across both.
    across = abs(axis[1]) / math.hypot(axis[1], axis[2])
    y = (radius + OUTER_RADIUS) / math.sqrt(1.0 - across**2) + rng.uniform(0.0, 1e-3)
    return Grip(
        length=turns * 2.0 * math.pi * rho / math.sin(angle),
        modulus=rng.uniform(0.5e6, 3.0e6),
        rest_strain=(torsion, 0.0, curvature),
        gravity=(gx, gy, gz),
        radius=radius,
        point=(0.0, y, 0.0),
        axis=(ax, ay, az),
        friction=float(rng.choice((0.0, rng.uniform(0.0, 0.8)))),
        away=float(rng.choice((0.0, 0.02))),
    )


def faults(problem: RodProblem, state: RodState) -> list[str]:
    """Return which laws a state breaks, from its positions, orientations and contact forces alone.

    The internal moment that bends the rod must be that of all forces beyond it, whose balance must
    include the base; nothing penetrates, pulls, or rubs harder than Coulomb's law allows.
    """
    (obstacle,) = problem.obstacles
    rod, p = problem.rod, state.positions
    axis = Rotation.from_quat(obstacle.orientation).apply((0.0, 0.0, 1.0))
    away = p - np.asarray(obstacle.position)
    away -= (away @ axis)[:, None] * axis
    distance = np.linalg.norm(away, axis=1)
    normal = away / distance[:, None]
    if not isinstance(obstacle.shape, Cylinder):
        raise TypeError("a grip is on a cylinder")
    gap = distance - obstacle.shape.radius - rod.radius
    push = state.contact_forces[0]
    pressing = np.sum(push * normal, axis=1)
    rubbing = np.linalg.norm(push - pressing[:, None] * normal, axis=1)
    steps = np.diff(state.arc_lengths)[:, None]
    weight = np.asarray(problem.load.distributed)
    half = np.zeros_like(p)
    half[1:] += 0.5 * steps * weight
    half[:-1] += 0.5 * steps * weight
    couples = np.cross(-rod.radius * normal, push)
    # An element's weight acts on its arc, not on its chord.
    couples[1:] += np.cross(steps**2 / 12.0 * -np.diff(state.tangents, axis=0), weight)
    total = push + half
    stiffness = stiffness_of(rod)[1, 1]
    scale = np.abs(total).sum() + stiffness / rod.length**2
    bent = _bending_moments(problem, state)
    statics = np.array(
        [
            (np.cross(p[i:] - 0.5 * (p[i - 1] + p[i]), total[i:]) + couples[i:]).sum(axis=0)
            for i in range(1, len(p))
        ]
    )
    largest = max(float(np.abs(bent).max()), BALANCE * stiffness / rod.length)
    lever = (np.cross(p, total) + couples).sum(axis=0)
    checks = {
        "not stable": not state.stable,
        "penetration": gap[1:].min() < -PENETRATION * rod.radius,
        "pull": pressing.min() < -BALANCE * scale,
        "contact at a distance": pressing[gap > PENETRATION * rod.radius].max(initial=0.0)
        > 1e-4 * scale,
        "friction": (rubbing - obstacle.friction * pressing).max() > CONE * scale,
        "force": np.abs(total.sum(axis=0) + state.base_reaction[:3]).max() > BALANCE * scale,
        "moment": np.abs(lever + state.base_reaction[3:]).max() > BALANCE * scale * rod.length,
        "internal moment": np.abs(bent - statics).max() > MOMENTS * largest,
    }
    return [name for name, broken in checks.items() if broken]


def stiffness_of(rod: Rod) -> Array:
    """Return a uniform rod's stiffness (3, 3) [N m^2]."""
    section: Any = rod.section
    matrix: Array = section.matrix
    return matrix


def _bending_moments(problem: RodProblem, state: RodState) -> Array:
    """Return K (u - u*) in the middle of the elements (N, 3), base frame."""
    turns = Rotation.from_quat(state.orientations)
    between = (turns[:-1].inv() * turns[1:]).as_rotvec()
    strains = between / np.diff(state.arc_lengths)[:, None]
    local = (strains - np.asarray(problem.rod.rest_strain)) @ stiffness_of(problem.rod)
    return (turns[:-1] * Rotation.from_rotvec(0.5 * between)).apply(local)


class Outcome(NamedTuple):
    """How one grip of the sample went; time in seconds."""

    grip: int
    verdict: str
    events: int
    iterations: int
    elements: int
    contact: float
    time: float


def grip_one(index: int) -> Outcome:
    """Let one rod wrap its cylinder, and judge the answer."""
    stations = random_grip(index).stations()
    begin = time.perf_counter()
    try:
        path = follow_contact(stations)
    except SolverError as error:
        spent = time.perf_counter() - begin
        verdict = f"refused: {error.status.name}"
        return Outcome(index, verdict, 0, error.iterations, 0, 0.0, spent)
    spent = time.perf_counter() - begin
    return _judged(index, stations, path, spent)


def _judged(index: int, stations: list[RodProblem], path: RodPath, spent: float) -> Outcome:
    """Return the outcome of a path."""
    iterations = sum(state.iterations for state in path.states)
    if len(path.states) < len(stations):
        lost = path.events[-1].last.status if path.events else RodStatus.CONVERGED
        verdict = f"lost: {lost.name}"
        return Outcome(index, verdict, len(path.events), iterations, 0, 0.0, spent)
    state = path.states[-1]
    broken = faults(stations[-1], state)
    verdict = f"wrong: {', '.join(broken)}" if broken else "certified"
    share = float(state.contact_lengths[0]) / stations[-1].rod.length
    elements = len(state.arc_lengths) - 1
    return Outcome(index, verdict, len(path.events), iterations, elements, share, spent)


def measure(count: int) -> Section:
    """Measure the first ``count`` grips of the sample."""
    outcomes = solve_all(grip_one, count)
    kinds = Counter(outcome.verdict.partition(":")[0] for outcome in outcomes)
    named = Counter(o.verdict for o in outcomes if o.verdict != "certified")
    smooth = [o for o in outcomes if o.verdict == "certified" and o.events == 0]
    times = np.array([o.time for o in outcomes])
    iterations = np.array([o.iterations for o in outcomes])
    total = f"of {len(outcomes):,}"
    rows = (
        ("certified and in balance", f"{kinds['certified']:,} {total}"),
        ("... without a snap on the way", f"{len(smooth):,}"),
        ("loss or limit reported", f"{kinds['lost'] + kinds['refused']:,}"),
        ("wrong without a word", f"{kinds['wrong']:,}"),
        ("Newton passes", spread(iterations, "{:.0f}".format)),
        ("time", spread(times, milli)),
        (
            "... where nothing snapped",
            spread(np.array([o.time for o in smooth] or [math.nan]), milli),
        ),
        (
            "in contact, of the length",
            spread(np.array([o.contact for o in outcomes]), "{:.2f}".format),
        ),
    )
    first = {o.verdict: o.grip for o in reversed(outcomes)}
    words = "; ".join(f"{n} x {name} (first: {first[name]})" for name, n in named.most_common(8))
    note = (
        "Cylinders of 8 to 40 mm, tilted by up to 5° from the coil's axis, in place or coming when "
        "the rod has half curled; coils of 0.75 to 1.1 times the size that fits, 0.7 to 2 turns; "
        "any direction of gravity or none, friction 0 to 0.8. Every answer is checked: base "
        "reaction, penetration, Coulomb's law, and the moment in every element against the forces "
        "beyond it."
    )
    table = Table(
        f"Robustness of grips: {len(outcomes):,} random rods wrap random cylinders",
        ("what", "median / 99th percentile / most"),
        rows,
        f"{note} {words}".strip(),
    )
    figures = {
        "grips": len(outcomes),
        "certified": kinds["certified"],
        "reported": kinds["lost"] + kinds["refused"],
        "wrong": kinds["wrong"],
        "smooth": len(smooth),
        "time_median": np.median(times),
        "time_max": times.max(),
        "iterations_median": np.median(iterations),
    }
    return Section((table,), {name: float(value) for name, value in figures.items()})


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.grips", description=__doc__)
    parser.add_argument("--count", type=int, default=2000, help="grips of the sample")
    (table,) = measure(parser.parse_args().count).tables
    show(table, wide_console())


if __name__ == "__main__":
    main()
