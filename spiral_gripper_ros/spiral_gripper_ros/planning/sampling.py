"""Which nodes of a shape are shown. Knows no ROS."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from spiral_core.rod import RodState


def picked_nodes(state: RodState, points: int) -> NDArray[np.intp]:
    """Return the indices of at most ``points`` >= 2 nodes, evenly spread, the ends always."""
    last = len(state.positions) - 1
    return np.unique(np.linspace(0, last, min(points, last + 1)).round().astype(np.intp))
