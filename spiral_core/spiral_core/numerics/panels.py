# SPDX-License-Identifier: Apache-2.0
"""Smooth functions of one variable as polynomials on panels: fast, and accurate to rounding."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Interpolation through this many Chebyshev nodes on each panel.
NODES = 14
_CHEBYSHEV: Array = np.cos(np.pi * (np.arange(NODES, dtype=np.float64) + 0.5) / NODES)
_INVERSE: Array = np.asarray(
    np.linalg.inv(chebyshev.chebvander(_CHEBYSHEV, NODES - 1)), dtype=np.float64
)
# Chebyshev series to powers, highest first as Horner's scheme takes them.
_POWERS: Array = np.array([np.pad(chebyshev.cheb2poly(row), (0, NODES))[:NODES]
                           for row in np.eye(NODES)]).T[::-1] @ _INVERSE  # fmt: skip


def panel_nodes(edges: Sequence[float]) -> Array:
    """Return the (panels, NODES) points at which a function on panels is sampled."""
    low, high = np.array(edges[:-1])[:, None], np.array(edges[1:])[:, None]
    nodes: Array = 0.5 * (low + high) + 0.5 * (high - low) * _CHEBYSHEV
    return nodes


def relative_tail(samples: Array) -> float:
    """Return the last two Chebyshev coefficients of one panel's samples over the largest."""
    series = np.abs(_INVERSE @ samples)
    largest = float(series.max())
    return float(series[-2:].max()) / largest if largest > 0.0 else 0.0


class Panels:
    """A function known at the nodes of panels, between them by polynomials.

    Args:
        edges: increasing ends of the panels.
        samples: (panels, NODES) values at :func:`panel_nodes`.

    Example:
        >>> edges = (0.0, 1.0, 2.0)
        >>> sine = Panels(edges, np.sin(panel_nodes(edges)))
        >>> round(sine(1.3) - float(np.sin(1.3)), 14)
        0.0
    """

    __slots__ = ("_coefficients", "_edges", "_inner", "_scales")

    def __init__(self, edges: Sequence[float], samples: Array) -> None:
        self._edges = [float(edge) for edge in edges]
        self._inner = self._edges[1:-1]
        self._coefficients: list[list[float]] = (samples @ _POWERS.T).tolist()
        self._scales = [
            (0.5 * (a + b), 2.0 / (b - a))
            for a, b in zip(self._edges[:-1], self._edges[1:], strict=True)
        ]

    def __call__(self, point: float) -> float:
        """Return the function at a point of the panels."""
        panel = bisect_right(self._inner, point)
        middle, scale = self._scales[panel]
        x = (point - middle) * scale
        value = 0.0
        for coefficient in self._coefficients[panel]:
            value = value * x + coefficient
        return value

    def with_slope(self, point: float) -> tuple[float, float]:
        """Return the function and its derivative at a point of the panels."""
        panel = bisect_right(self._inner, point)
        middle, scale = self._scales[panel]
        x = (point - middle) * scale
        value = slope = 0.0
        for coefficient in self._coefficients[panel]:
            slope = slope * x + value
            value = value * x + coefficient
        return value, slope * scale
