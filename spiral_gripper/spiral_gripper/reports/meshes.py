# SPDX-License-Identifier: Apache-2.0
"""Surfaces to draw, look at and export: the tube of a gripper, and objects that are round."""

from __future__ import annotations

from typing import NamedTuple

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


def tube_mesh(points: Array, radii: Array | float, sides: int = SIDES) -> Mesh:
    """Return the closed surface, with caps, of a tube or a body of revolution.

    Its sections turn as little as they can from one to the next.

    Args:
        points: (n, 3) on its centerline [m], n > 1.
        radii: outer radius, one or (n,) [m].
        sides: points around a section.
    """
    count = len(points)
    along = np.gradient(points, axis=0, edge_order=1 if count == 2 else 2)
    along /= np.maximum(np.linalg.norm(along, axis=1), 1e-12)[:, None]
    across = np.empty_like(along)
    side = np.eye(3)[np.argmin(np.abs(along[0]))]
    for number, tangent in enumerate(along):
        side = side - (side @ tangent) * tangent
        side /= max(float(np.linalg.norm(side)), 1e-12)
        across[number] = side
    angles = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    cosines, sines = np.cos(angles)[None, :, None], np.sin(angles)[None, :, None]
    ring = cosines * across[:, None] + sines * np.cross(along, across)[:, None]
    size = np.broadcast_to(np.asarray(radii, dtype=np.float64), count)
    side_points = (points[:, None] + size[:, None, None] * ring).reshape(-1, 3)
    here = np.arange(count * sides).reshape(count, sides)
    beside, (base, tip) = np.roll(here, -1, axis=1), (count * sides, count * sides + 1)
    faces = (
        (here[:-1], beside[:-1], here[1:]),
        (beside[:-1], beside[1:], here[1:]),
        (base, beside[0], here[0]),
        (tip, here[-1], beside[-1]),
    )
    corners = [np.stack(np.broadcast_arrays(*each), axis=-1).reshape(-1, 3) for each in faces]
    return Mesh(
        vertices=np.vstack((side_points, points[:1], points[-1:])),
        faces=np.vstack(corners),
        rows=np.concatenate((np.repeat(np.arange(count), sides), [0, count - 1])),
    )
