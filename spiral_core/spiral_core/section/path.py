# SPDX-License-Identifier: Apache-2.0
"""The deformation path of a section with two wound families: its states from rest to its end."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spiral_core.errors import ActuationLimit
from spiral_core.numerics.panels import Panels, graded_edges, halved_edges, panel_nodes, rising_root
from spiral_core.numerics.roots import first_sign_change
from spiral_core.section.closure import ROWS, STEP, closure_slopes, closures, ring_of
from spiral_core.section.fiber_set import Array, FiberSet
from spiral_core.section.ring import Ring, invariant_excess, ring_at

# The path stops short of where something diverges or turns back by this fraction of its strain.
END_MARGIN = 1e-4
# A panel is at most this fraction of the distance to the nearest strain at which the wall
# collapses, where the path is singular; one whose polynomials end above the tolerance is halved.
PANEL_WIDTH, TAIL_TOLERANCE, HALVINGS = 0.5, 1e-13, 3
# Two ends nearer to each other than this fraction are one.
SAME_END = 1e-9
# Strains at which the end of the path is looked for.
SCAN = 96
# Where the section stops closing is found to this fraction of itself, much less than END_MARGIN.
CLOSED_TOLERANCE = 1e-6


class Motion(NamedTuple):
    """Closed sections at (n,) strains y of the far side, and their derivatives in y.

    Of :func:`sideways_motion` the derivatives are those in the cosine that it names.

    Attributes:
        ring: the states.
        stretch_slope: d(mean axial stretch)/dy.
        volume_slope: d(enclosed volume over that at rest)/dy.
        first: (n, points) I1 - 3 at the quadrature points.
        second: I2 - 3.
        first_slope: dI1/dy.
        second_slope: dI2/dy.
        share: of the wall's volume at the points; sums to 1.
        share_slope: its derivative.
        closed: whether the wall's closure was found.
    """

    ring: Ring
    stretch_slope: Array
    volume_slope: Array
    first: Array
    second: Array
    first_slope: Array
    second_slope: Array
    share: Array
    share_slope: Array
    closed: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class ShapePath:
    """Shapes of a section from rest to the end of its range, over the far side's strain y.

    Attributes:
        fibers: which fibers.
        direction: 1 if pressure lengthens the far side, -1 if it shortens it.
        strain_limit: |y| at which the path ends, just short of what ends it.
        limit: what ends the path.
        stretch: (mean axial stretch - 1) / |y|.
        curvature: curvature per unstretched length, times the wound radius, over |y|.
        torsion: change of the torsion likewise.
    """

    fibers: FiberSet
    direction: float
    strain_limit: float
    limit: ActuationLimit
    stretch: Panels
    curvature: Panels
    torsion: Panels

    def stretch_at(self, size: float) -> float:
        """Return the mean axial stretch at |y|."""
        return 1.0 + size * self.stretch(size)

    def change(self, size: float) -> tuple[float, float]:
        """Return how far the mean axial stretch is from 1 at |y|, and the derivative."""
        value, slope = self.stretch.with_slope(size)
        return self.direction * size * value, self.direction * (value + size * slope)

    def strain_from_stretch(self, stretch: float) -> float:
        """Return |y| at a mean axial stretch between 1 and that of the path's end."""
        target, end = self.direction * (stretch - 1.0), self.strain_limit
        return rising_root(self.change, target, 0.0, end, end * target / self.change(end)[0])


@dataclass(frozen=True, slots=True, kw_only=True)
class SectionPath(ShapePath):
    """The path of a section of two families, which does not depend on the elastomer.

    Attributes:
        edges: |y| at the ends of the panels, rising from 0.
        motion: the states at the panels' nodes, in their order.
        volume_slope: d(volume ratio)/d|y|.
    """

    edges: tuple[float, ...]
    motion: Motion
    volume_slope: Panels


def motion_at(fibers: FiberSet, far_strains: Array) -> Motion:
    """Return the closed section at (n,) far-side strains, with derivatives along the path."""
    unknowns, closed = closures(fibers, far_strains)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        slopes = closure_slopes(fibers, far_strains, unknowns)
        moved = ring_of(fibers, far_strains + 1j * STEP, unknowns + 1j * STEP * slopes)
        return _motion(fibers, moved, closed)


def sideways_motion(fibers: FiberSet, far_strains: Array) -> Motion:
    """Return the closed section with derivatives as one single fiber leaves the coil's plane.

    The derivatives are those in the cosine of the angle between the two, at 1: by symmetry nothing
    changes in the first order of the angle itself.
    """
    unknowns, closed = closures(fibers, far_strains)
    change, step = unknowns[:, 0], 1j * STEP
    by_change = ring_at(fibers, far_strains, change + step).warp.imag
    by_facing = ring_at(fibers, far_strains, change + 0j, facing=1.0 + step).warp.imag
    slope = -by_facing / by_change
    moved = ring_at(fibers, far_strains, change + step * slope, facing=1.0 + step)
    return _motion(fibers, moved, closed)


def _motion(fibers: FiberSet, moved: Ring, closed: NDArray[np.bool_]) -> Motion:
    """Return states and derivatives from a section moved by the complex step."""
    first, second, quadrature = invariant_excess(fibers, moved)
    share = np.tile(moved.weight, (1, len(quadrature) // moved.weight.shape[1])) * quadrature
    volume = (1.0 + moved.stretch_change) * moved.hoop**2
    return Motion(
        ring=Ring(*(np.real(part) for part in moved)),
        stretch_slope=moved.stretch_change.imag / STEP,
        volume_slope=volume.imag / STEP,
        first=first.real,
        second=second.real,
        first_slope=first.imag / STEP,
        second_slope=second.imag / STEP,
        share=share.real,
        share_slope=share.imag / STEP,
        closed=closed,
    )


def initial_volume_slope(fibers: FiberSet) -> float:
    """Return d(volume ratio)/dy at rest; pressure moves the far side in its direction."""
    return float(motion_at(fibers, np.zeros(1)).volume_slope[0])


@lru_cache(maxsize=64)
def section_path(fibers: FiberSet) -> SectionPath:
    """Return the path of a section of two families, from rest to its end.

    Args:
        fibers: two families, with or without single fibers.
    """
    slope = initial_volume_slope(fibers)
    direction = 1.0 if slope >= 0.0 else -1.0
    low, high = fibers.collapse_strains()
    edges = _edges(fibers, direction, _past_end(fibers, direction, (low, high)), (low, high))
    sizes = panel_nodes(edges)
    motion = motion_at(fibers, direction * sizes.ravel())
    ring = motion.ring

    def quotient(values: Array) -> Panels:
        return Panels(edges, values.reshape(sizes.shape) / sizes)

    volume_slope = Panels(edges, direction * motion.volume_slope.reshape(sizes.shape))
    end, limit = _end(edges, volume_slope, Panels(edges, motion.stretch_slope.reshape(sizes.shape)))
    return SectionPath(
        fibers=fibers,
        direction=direction,
        edges=edges,
        strain_limit=end * (1.0 - END_MARGIN),
        limit=limit,
        motion=motion,
        stretch=quotient(ring.stretch_change),
        volume_slope=volume_slope,
        curvature=quotient(ring.bend / ring.hoop),
        torsion=quotient(ring.twist / ring.hoop - fibers.single_slope),
    )


def _past_end(fibers: FiberSet, direction: float, collapse: tuple[float, float]) -> float:
    """Return a |y| at which the section still closes, just past the end of its path."""
    reach = (collapse[1] if direction > 0.0 else -collapse[0]) * (1.0 - END_MARGIN)
    sizes = reach * (np.arange(1, SCAN + 1) / SCAN) ** 2
    before = 0.0
    for part in np.split(sizes, SCAN // ROWS):
        motion = motion_at(fibers, direction * part)
        ended = ~((direction * motion.volume_slope > 0.0) & (motion.stretch_slope > 0.0))
        if ended.any():
            first = int(np.argmax(ended))
            if motion.closed[first]:
                return float(part[first])
            low = float(part[first - 1]) if first else before
            return _last_closed(fibers, direction, low, float(part[first]))
        before = float(part[-1])
    return reach


def _last_closed(fibers: FiberSet, direction: float, low: float, high: float) -> float:
    """Return the largest |y| at which the section closes, to :data:`CLOSED_TOLERANCE`.

    Args:
        fibers: which fibers.
        direction: sign of y.
        low: |y| at which it closes.
        high: |y| at which it does not.
    """
    while high - low > CLOSED_TOLERANCE * high:
        sizes = np.linspace(low, high, ROWS + 2)
        _, closed = closures(fibers, direction * sizes[1:-1])
        count = ROWS if closed.all() else int(np.argmin(closed))
        low, high = float(sizes[count]), float(sizes[count + 1])
    return low


def _end(
    edges: tuple[float, ...], volume_slope: Panels, stretch_slope: Panels
) -> tuple[float, ActuationLimit]:
    """Return |y| at which the volume is largest or the stretch is, or where the path ends."""
    nodes = np.linspace(0.0, edges[-1], SCAN).tolist()
    volume = first_sign_change(volume_slope, nodes)
    stretch = first_sign_change(stretch_slope, nodes) or edges[-1]
    # Next to a hoop family both come at once: then it is the other family that locks.
    if volume is not None and volume < (1.0 - SAME_END) * stretch:
        return volume, ActuationLimit.VOLUME_MAXIMUM
    return stretch, ActuationLimit.FIBER_LOCKING


def _edges(
    fibers: FiberSet, direction: float, end: float, collapse: tuple[float, float]
) -> tuple[float, ...]:
    """Return panels on which polynomials meet the path to rounding."""
    left, right = (-collapse[0], collapse[1]) if direction > 0.0 else (collapse[1], -collapse[0])
    edges = graded_edges(end, min(left, 1.0), right, PANEL_WIDTH)
    for _ in range(HALVINGS):
        sizes = panel_nodes(edges)
        motion = motion_at(fibers, direction * sizes.ravel())
        samples = np.stack(
            (motion.volume_slope, motion.ring.stretch_change, motion.first_slope[:, -1])
        )
        finer = halved_edges(edges, samples.reshape(-1, *sizes.shape), TAIL_TOLERANCE)
        if finer == edges:
            break
        edges = finer
    return edges
