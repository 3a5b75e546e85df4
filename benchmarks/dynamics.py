# SPDX-License-Identifier: Apache-2.0
"""The same rod in PyElastica: released as an unloaded helix, damped until it hangs at rest.

PyElastica gets favors that a user would not have: an element size, time step and damping tuned for
this very rod (:data:`TUNED`), and the clamp of its first element turned by the exact solution's
strain over half an element (it clamps the middle of an element, not its end).
"""

from __future__ import annotations

import importlib
import importlib.util
import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.cases import OUTER_RADIUS, Array, Case

# At rest: no node moves by more than this fraction of the length per second.
REST_SPEED = 1e-3
# Steps between two looks at the rod, which are not timed.
STRIDE = 20


@dataclass(frozen=True, slots=True)
class Settings:
    """How PyElastica is run; a solid rod of ``radius`` [m] has the tube's EI, GJ and weight."""

    elements: int
    time_step: float
    damping: float
    radius: float = OUTER_RADIUS
    exact_clamp: bool = True


@dataclass(frozen=True, slots=True)
class Relaxation:
    """What a run gave.

    Args:
        near: wall time [s] of the steps until the tip was near for good; NaN if it never was.
        rest: wall time [s] until, besides, no node was faster than :data:`REST_SPEED`.
        steps: steps until rest.
        error: distance of the tip at the end, as a fraction of the length.
        speed: fastest node at the end, as a fraction of the length per second.
    """

    near: float
    rest: float
    steps: int
    error: float
    speed: float


def available() -> bool:
    """Return whether PyElastica is installed."""
    return importlib.util.find_spec("elastica") is not None


def relax(
    case: Case, base_strain: Array, tip: Array, settings: Settings, duration: float, near: float
) -> Relaxation:
    """Run for ``duration`` [s] of simulated time; when does the tip stay within ``near`` x L?"""
    elastica: Any = importlib.import_module("elastica")

    simulator, rod = _simulator(case, base_strain, settings)
    stepper = elastica.PositionVerlet()
    length = case.length
    moment, spent, steps = np.float64(0.0), 0.0, 0
    near_since = rest_since = math.nan
    rest_steps = 0
    error = speed = math.inf
    while moment < duration:
        begin = time.perf_counter()
        for _ in range(STRIDE):
            moment = stepper.step(simulator, moment, settings.time_step)
        spent += time.perf_counter() - begin
        steps += STRIDE
        error = float(np.linalg.norm(rod.position_collection[:, -1] - tip)) / length
        speed = float(np.linalg.norm(rod.velocity_collection, axis=0).max()) / length
        if not math.isfinite(error):
            return Relaxation(math.nan, math.nan, steps, error, speed)
        if error > near:
            near_since = math.nan
        elif math.isnan(near_since):
            near_since = spent
        if error > near or speed > REST_SPEED:
            rest_since = math.nan
        elif math.isnan(rest_since):
            rest_since, rest_steps = spent, steps
    return Relaxation(near_since, rest_since, rest_steps, error, speed)


def _simulator(case: Case, base_strain: Array, settings: Settings) -> tuple[Any, Any]:
    """Return PyElastica's simulator and rod. Its directors are our (y, z, x)."""
    elastica: Any = importlib.import_module("elastica")

    parts = ("BaseSystemCollection", "Constraints", "Forcing", "Damping")
    composed = type("Simulator", tuple(getattr(elastica, part) for part in parts), {})
    n, radius, length = settings.elements, settings.radius, case.length
    step = length / n
    rest = np.array(case.rest_strain)
    second_moment = math.pi / 4.0 * radius**4
    weight = np.array(case.distributed)
    density = float(np.linalg.norm(weight)) / 9.80665 / (math.pi * radius**2)
    clamp = Rotation.from_rotvec(base_strain * step / 2.0 * settings.exact_clamp)
    frames = clamp * Rotation.from_rotvec(rest * step * np.arange(n)[:, None])
    axes = frames.as_matrix()  # columns: x, y, z
    positions = np.vstack((np.zeros(3), np.cumsum(step * axes[:, :, 0], axis=0))).T
    shear = case.torsional / (2.0 * second_moment)
    elastic = elastica.CosseratRod.straight_rod(
        n,
        np.zeros(3),
        axes[0, :, 0].copy(),
        axes[0, :, 1].copy(),
        length,
        radius,
        density,
        youngs_modulus=case.bending / second_moment,
        shear_modulus=shear,
        position=np.ascontiguousarray(positions),
        directors=np.ascontiguousarray(axes[:, :, [1, 2, 0]].transpose(2, 1, 0)),
        rest_kappa=np.tile(rest[[1, 2, 0], None], (1, n - 1)),
    )
    simulator: Any = composed()
    simulator.append(elastic)
    simulator.constrain(elastic).using(
        elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    simulator.add_forcing_to(elastic).using(
        elastica.GravityForces, acc_gravity=weight * 9.80665 / np.linalg.norm(weight)
    )
    simulator.dampen(elastic).using(
        elastica.AnalyticalLinearDamper,
        uniform_damping_constant=settings.damping,
        time_step=settings.time_step,
    )
    simulator.finalize()
    return simulator, elastic
