# SPDX-License-Identifier: Apache-2.0
"""Smooth functions as polynomials on panels, accurate to rounding, and their inverse."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from itertools import pairwise

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
# Chebyshev series to powers, highest first as Horner's scheme takes them. Not multiplied with the
# inverse: high powers have large coefficients, and only small ones of the series meet them.
_POWERS: Array = np.array([np.pad(chebyshev.cheb2poly(row), (0, NODES))[:NODES]
                           for row in np.eye(NODES)]).T[::-1]  # fmt: skip
# Bisection alone would be done in 60 steps; the margin is for Newton steps that help little.
ITERATIONS_MAX = 100
# Relative change of the point at which Newton's method ends: what is left is its square.
CONVERGED_CHANGE = 1e-9


def panel_nodes(edges: Sequence[float]) -> Array:
    """Return the (panels, NODES) points at which a function on panels is sampled."""
    low, high = np.array(edges[:-1])[:, None], np.array(edges[1:])[:, None]
    nodes: Array = 0.5 * (low + high) + 0.5 * (high - low) * _CHEBYSHEV
    return nodes


def graded_edges(end: float, left: float, right: float, width: float) -> tuple[float, ...]:
    """Return edges from 0 to ``end`` of panels that become narrow towards singular points.

    Args:
        end: of the last panel, before ``right``.
        left: distance of the nearest singular point below 0.
        right: the nearest singular point above ``end``.
        width: of a panel, at most, over the distance of its low end to the nearer of the two.

    Example:
        >>> graded_edges(0.75, 9.0, 1.0, width=0.5)
        (0.0, 0.5, 0.75)
    """
    edges = [0.0]
    while edges[-1] < end:
        near = min(left + edges[-1], right - edges[-1])
        edges.append(min(edges[-1] + width * near, end))
    return tuple(edges)


def relative_tails(samples: Array) -> Array:
    """Return the last two Chebyshev coefficients of samples (..., NODES) over the largest."""
    series = np.abs(samples @ _INVERSE.T)
    largest = series.max(axis=-1)
    tails: Array = series[..., -2:].max(axis=-1) / np.where(largest > 0.0, largest, 1.0)
    return tails


def refined_panels(
    edges: tuple[float, ...], sample: Callable[[Array], Array], tolerance: float, halvings: int
) -> tuple[tuple[float, ...], Array]:
    """Return panels halved where a function's polynomial ends too large, and the samples there.

    Args:
        edges: increasing ends of the panels.
        sample: returns values (functions, panels, NODES) at nodes (panels, NODES); the first three
            functions are looked at.
        tolerance: of :func:`relative_tails`.
        halvings: how many times a panel may be halved.
    """
    samples = sample(panel_nodes(edges))
    for _ in range(halvings):
        rough = relative_tails(samples[:3]).max(axis=0) > tolerance
        if not rough.any():
            break
        halves = [0.5 * (edges[k] + edges[k + 1]) for k in np.flatnonzero(rough).tolist()]
        edges = tuple(sorted([*edges, *halves]))
        samples = sample(panel_nodes(edges))
    return edges, samples


class Panels:
    """A function known at the nodes of panels, between them by polynomials.

    Args:
        edges: increasing ends of the panels.
        samples: (panels, NODES) values at :func:`panel_nodes`.

    Attributes:
        inner: edges between two panels.

    Example:
        >>> edges = (0.0, 1.0, 2.0)
        >>> sine = Panels(edges, np.sin(panel_nodes(edges)))
        >>> round(sine(1.3) - float(np.sin(1.3)), 14)
        0.0
    """

    __slots__ = ("_coefficients", "_scales", "inner")

    def __init__(self, edges: Sequence[float], samples: Array) -> None:
        ends = [float(edge) for edge in edges]
        self.inner = ends[1:-1]
        self._coefficients: list[list[float]] = ((samples @ _INVERSE.T) @ _POWERS.T).tolist()
        self._scales = [(0.5 * (a + b), 2.0 / (b - a)) for a, b in pairwise(ends)]

    def __call__(self, point: float) -> float:
        """Return the function at a point of the panels."""
        panel = bisect_right(self.inner, point)
        middle, scale = self._scales[panel]
        x = (point - middle) * scale
        value = 0.0
        for coefficient in self._coefficients[panel]:
            value = value * x + coefficient
        return value

    def with_slope(self, point: float) -> tuple[float, float]:
        """Return the function and its derivative at a point of the panels."""
        panel = bisect_right(self.inner, point)
        middle, scale = self._scales[panel]
        x = (point - middle) * scale
        value = slope = 0.0
        for coefficient in self._coefficients[panel]:
            slope = slope * x + value
            value = value * x + coefficient
        return value, slope * scale


def rising_root(
    function: Callable[[float], tuple[float, float]],
    target: float,
    low: float,
    high: float,
    start: float,
) -> float:
    """Return where a rising function meets a target: Newton's method inside a bracket.

    Args:
        function: returns its value and its derivative; rising from ``low`` to ``high``.
        target: between the values at the two, which are not evaluated.
        low: start of the bracket, >= 0.
        high: end of the bracket.
        start: first guess.

    Returns:
        The root, to rounding of the function; a bracket that shrinks to neighboring floats ends it.

    Example:
        >>> round(rising_root(lambda x: (x * x, 2.0 * x), 2.0, 0.0, 2.0, start=1.0), 15)
        1.414213562373095
    """
    point = min(max(start, low), high)
    for _ in range(ITERATIONS_MAX):
        value, slope = function(point)
        if value > target:
            high = point
        else:
            low = point
        following = point - (value - target) / slope if slope > 0.0 else math.inf
        if low <= following <= high and abs(following - point) <= CONVERGED_CHANGE * point:
            return following
        if not low < following < high:
            following = 0.5 * (low + high)
            if not low < following < high:
                return point
        point = following
    return point
