# SPDX-License-Identifier: Apache-2.0
"""Surfaces to draw, look at and export: the tube of a gripper, and objects that are round."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from spiral_core.rod.types import Array

# Points around a section: the surface is then 1 % smaller than that of a round tube.
SIDES = 24


class Mesh(NamedTuple):
    """Triangles in the base frame.

    Attributes:
        vertices: (v, 3) [m].
        faces: (f, 3) indices of vertices, counterclockwise as seen from outside.
        rows: (v,) which section each vertex lies on; its color follows.
    """

    vertices: Array
    faces: NDArray[np.int64]
    rows: NDArray[np.int64]


class Solved(Protocol):
    """A rod's shape, free or in contact."""

    @property
    def positions(self) -> Array:
        """Nodes (n, 3) [m]."""
        ...

    @property
    def orientations(self) -> Array:
        """Unit quaternions (n, 4), scalar last; x is along the rod, y at the straight fiber."""
        ...


def tube_mesh(state: Solved, radius: float) -> Mesh:
    """Return the closed surface of a tube of this outer radius [m] around a rod's centerline."""
    x, y, z, w = state.orientations.T
    first = np.column_stack((1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)))
    second = np.column_stack((2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)))
    return _swept(state.positions, second, np.cross(first, second), radius, SIDES)


def line_mesh(points: Array, radius: float) -> Mesh:
    """Return the closed surface of a tube of this outer radius [m] around points (n, 3), n > 1.

    Its sections turn as little as they can from one to the next.
    """
    along = np.gradient(points, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1), 1e-12)[:, None]
    across = np.empty_like(points)
    side = np.eye(3)[np.argmin(np.abs(along[0]))]
    for number, tangent in enumerate(along):
        side = side - (side @ tangent) * tangent
        side /= max(float(np.linalg.norm(side)), 1e-12)
        across[number] = side
    return _swept(points, across, np.cross(along, across), radius, SIDES)


def turned_mesh(ends: Array, radii: Array, sides: int = 2 * SIDES) -> Mesh:
    """Return the closed surface of an object whose radius varies along a straight axis.

    Args:
        ends: (2, 3) where its axis begins and ends [m].
        radii: (n,) at equal distances from one end to the other [m], n >= 2.
        sides: points around a section.
    """
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    helper = np.zeros(3)
    helper[np.argmin(np.abs(along))] = 1.0
    across = np.cross(along, helper)
    across /= np.linalg.norm(across)
    places = np.linspace(0.0, 1.0, len(radii))[:, None]
    centers = (1.0 - places) * ends[0] + places * ends[1]
    shape = (len(radii), 3)
    up = np.cross(along, across)
    return _swept(centers, np.broadcast_to(across, shape), np.broadcast_to(up, shape), radii, sides)


def _swept(centers: Array, across: Array, up: Array, radii: Array | float, sides: int) -> Mesh:
    """Return a tube with caps; ``across`` and ``up`` (n, 3) span its sections, in this order."""
    count = len(centers)
    angles = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    cosines, sines = np.cos(angles)[None, :, None], np.sin(angles)[None, :, None]
    ring = cosines * across[:, None] + sines * up[:, None]
    size = np.broadcast_to(np.asarray(radii, dtype=np.float64), count)
    side = (centers[:, None] + size[:, None, None] * ring).reshape(-1, 3)
    here = np.arange((count - 1) * sides)
    beside = here - here % sides + (here + 1) % sides
    first = np.column_stack((here, beside, here + sides))
    second = np.column_stack((beside, beside + sides, here + sides))
    turn = np.arange(sides)
    base = np.column_stack((np.full(sides, count * sides), (turn + 1) % sides, turn))
    tip = np.column_stack((np.full(sides, count * sides + 1), turn, (turn + 1) % sides))
    tip[:, 1:] += (count - 1) * sides
    return Mesh(
        vertices=np.vstack((side, centers[:1], centers[-1:])),
        faces=np.vstack((first, second, base, tip)),
        rows=np.concatenate((np.repeat(np.arange(count), sides), [0, count - 1])),
    )
