# SPDX-License-Identifier: Apache-2.0
"""From a rod and its load to the system that the compiled kernels solve."""

from __future__ import annotations

import math

import numpy as np

from spiral_core.rod._mesh import Counts
from spiral_core.rod._profiles import (
    pieces,
    sites_in,
    stiffness_samples,
    uniform_rod,
    varies,
    vector_samples,
)
from spiral_core.rod._system import System, discrete_strain_scale, uniform_system
from spiral_core.rod.types import Array, Rod, RodLoad

# What the coupling adds to K u: the twist's share to bending about z, and the other way round.
COUPLED = np.array([1.0, 0.0, 1.0])


def discretize(rod: Rod, load: RodLoad, counts: Counts) -> System:
    """Return ``rod`` and ``load`` on ``counts`` elements in each piece.

    Raises:
        InvalidInputError: a profile's values have the wrong shape, are not finite or not positive.
    """
    if not varies(rod, load):
        return uniform_system(sum(counts), uniform_rod(rod, load))
    parts = [_piece(rod, load, *each) for each in zip(pieces(rod), counts, strict=True)]
    elements, steps, weights, sections, energies = zip(*parts, strict=True)
    h, mean_weights = np.concatenate(steps), np.concatenate([_simpson(w) for w in weights])
    force = np.empty((len(h) + 1, 3))
    force[-1] = load.tip_force
    force[:-1] = force[-1] + np.cumsum((h[:, None] * mean_weights)[::-1], axis=0)[::-1]
    distributed = [np.hstack((w[:-2:2], w[2::2])) for w in weights]
    nodes = [s[:-1:2] for s in sections] + [sections[-1][-1:]]
    return System(
        force=force,
        distributed=np.ascontiguousarray(np.concatenate(distributed)),
        tip_moment=np.array(load.tip_moment, dtype=np.float64),
        elements=np.ascontiguousarray(np.concatenate(elements)),
        steps=h,
        sections=np.ascontiguousarray(np.concatenate(nodes)),
        rest_energy=math.fsum(energies),
    )


def _piece(
    rod: Rod, load: RodLoad, piece: tuple[float, float], count: int
) -> tuple[Array, Array, Array, Array, float]:
    """Return one piece's elements (n, 14) and steps (n,), its load, sections and rest energy.

    Load (2 n + 1, 3) and sections (2 n + 1, 7) are at nodes and midpoints; Simpson's means over
    elements keep the order.
    """
    h = (piece[1] - piece[0]) / count
    sites = sites_in(rod, piece, 2 * count + 1)
    stiffness = stiffness_samples(rod, sites)
    rest_strain = vector_samples("rest_strain", rod.rest_strain, sites)
    angles = h * np.sqrt(np.sum(rest_strain**2, axis=1))
    scales = np.array([discrete_strain_scale(float(angle)) for angle in angles])[:, None]
    moment = stiffness[:, :3] * rest_strain + stiffness[:, 3:] * COUPLED * rest_strain[:, ::-1]
    columns = np.hstack((stiffness, scales * moment))
    elements = np.hstack((_simpson(columns), np.diff(columns[::2], axis=0) / h))
    density = np.sum(scales**2 * moment * rest_strain, axis=1)
    return (
        elements,
        np.full(count, h),
        vector_samples("distributed", load.distributed, sites),
        np.hstack((stiffness, moment)),
        0.5 * h * float(np.sum(_simpson(density[:, None]))),
    )


def _simpson(samples: Array) -> Array:
    """Return the means over the elements (n, k) of samples at nodes and midpoints (2 n + 1, k)."""
    means: Array = (samples[:-2:2] + 4.0 * samples[1:-1:2] + samples[2::2]) / 6.0
    return means
