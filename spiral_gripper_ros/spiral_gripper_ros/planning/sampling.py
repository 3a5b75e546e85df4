# SPDX-License-Identifier: Apache-2.0
"""Selection of the nodes of a shape that are shown. No ROS."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from spiral_core.rod.types import RodState
from spiral_gripper_ros.planning.grip_figures import TubeShape


def picked_nodes(state: RodState | TubeShape, points: int) -> NDArray[np.intp]:
    """Return the indices of at most ``points`` >= 2 nodes, evenly spread, the ends always."""
    return _evenly(len(state.positions), points)


@lru_cache(maxsize=64)
def _evenly(count: int, points: int) -> NDArray[np.intp]:
    """Return indices of ``count`` nodes; shape after shape asks for the same ones."""
    last = count - 1
    picked = np.unique(np.linspace(0, last, min(points, count)).round().astype(np.intp))
    picked.flags.writeable = False
    return picked
