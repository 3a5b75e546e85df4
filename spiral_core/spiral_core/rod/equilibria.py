# SPDX-License-Identifier: Apache-2.0
"""Other stable equilibria of a rod under load, searched from many starts."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from spiral_core.errors import InvalidInputError
from spiral_core.rod._algebra import composed
from spiral_core.rod._continuation import minimize_to_stable
from spiral_core.rod._mesh import discretize
from spiral_core.rod.solve import (
    checked_counts,
    solve_with_counts,
    state_at,
)
from spiral_core.rod.state import RodState
from spiral_core.rod.types import DEFAULT_TOLERANCE, Array, Rod, RodLoad

DEFAULT_STARTS = 64
# Two states are one if no node differs by more than this angle [rad].
SAME_ANGLE = 1e-3
# Waves of rotation along the rod that make a start, and how many turns they bring at the most.
WAVES = 3
START_TURNS = 1.5


def find_equilibria(
    rod: Rod,
    load: RodLoad,
    *,
    starts: int = DEFAULT_STARTS,
    seed: int = 0,
    elements: int | None = None,
) -> tuple[RodState, ...]:
    """Return the stable states found from many starts, the lowest energy first.

    The first start is the loading path; the others bend and twist its end by random smooth
    rotations. Each state is certified; that there are no more is not.

    Args:
        rod: the rod.
        load: its load; without a tip moment, for energies to be compared.
        starts: how many to try, >= 1.
        seed: of the random starts; the same seed gives the same answer.
        elements: as in :func:`~spiral_core.rod.solve.solve_rod`.

    Returns:
        Different states, by increasing energy; empty if none converged.

    Raises:
        InvalidInputError: ``starts`` is not a positive whole number, ``seed`` not one from 0, or
            what :func:`~spiral_core.rod.solve.solve_rod` refuses.

    Example:
        >>> from spiral_core import Section
        >>> rod = Rod(0.3, Section.inextensible(3e-4, 2e-4), rest_strain=(0.0, 0.0, 5.0))
        >>> len(find_equilibria(rod, RodLoad(distributed=(0.24, 0.0, 0.0)), starts=4))
        1
    """
    if type(starts) is not int or starts < 1:
        raise InvalidInputError("starts", starts, "a whole number of at least 1")
    if type(seed) is not int or seed < 0:
        raise InvalidInputError("seed", seed, "a whole number of at least 0")
    counts = checked_counts(rod, load, elements)
    system = discretize(rod, load, counts)
    first = solve_with_counts(rod, load, counts, None)
    states = [first] if first.stable else []
    generator = np.random.default_rng(seed)
    for _ in range(starts - 1):
        q = _scrambled(first.orientations, generator)
        found = minimize_to_stable(q, system, DEFAULT_TOLERANCE, 0)
        state = state_at(q, system, 0, found)
        if state.stable and not any(_same(state, other) for other in states):
            states.append(state)
    return tuple(sorted(states, key=lambda state: state.energy))


def _scrambled(orientations: Array, generator: np.random.Generator) -> Array:
    """Return orientations turned by a random smooth rotation that vanishes at the base."""
    reach = np.linspace(0.0, 1.0, len(orientations))[:, None]
    size = 2.0 * np.pi * START_TURNS / WAVES
    turn = np.zeros((len(orientations), 3))
    for wave in range(1, WAVES + 1):
        turn += size / wave * generator.normal(size=3) * np.sin(0.5 * np.pi * wave * reach)
    # Scipy keeps neighbors on one side of the sphere of quaternions, as the elements need them.
    return composed(orientations, Rotation.from_rotvec(turn).as_quat())


def _same(a: RodState, b: RodState) -> bool:
    """Return whether two states' nodes differ by no more than :data:`SAME_ANGLE`.

    Those that may turn about the base's axis are compared as shapes.
    """
    if a.neutral_modes and b.neutral_modes:
        apart = np.abs(_upright(a) - _upright(b)).max()
        return bool(apart < SAME_ANGLE * a.arc_lengths[-1])
    overlap = np.abs(np.sum(a.orientations * b.orientations, axis=1))
    return bool(np.all(2.0 * np.arccos(np.minimum(1.0, overlap)) < SAME_ANGLE))


def _upright(state: RodState) -> Array:
    """Return nodes (N + 1, 3) turned about the x axis: the farthest from it lies beside +y [m]."""
    x, y, z = state.positions.T
    far = int(np.argmax(np.hypot(y, z)))
    turned = (y + 1j * z) * np.exp(-1j * np.arctan2(z[far], y[far]))
    nodes: Array = np.stack((x, turned.real, turned.imag), axis=1)
    return nodes
