# SPDX-License-Identifier: Apache-2.0
r"""The bent section of a wound tube: strains around it, from the fibers' constraints alone.

In material coordinates along the single fibers and around the tube, the metric of the wall is

.. math:: M_{11} = 1 + T^2 + m, \quad M_{12} = T + z, \quad M_{22} = 1 + n, \quad T = \tan\gamma

A family at the angle :math:`\varphi` keeps its length if :math:`p^2 m + 2 p z + n = 0` with
:math:`p = 1 / (\tan\varphi - T)`: linear. Two families leave m alone free, with
:math:`z = -(p + q) m / 2` and :math:`n = p q m`.

The cross-section stays round. Swept along its helix, every material line along the single fiber's
direction has the local axial stretch :math:`\lambda = \bar\lambda - K \cos\theta` and the shear g,
so that :math:`M_{11} = \lambda^2 + g^2`. The wall closes around the section if

.. math:: h \langle \lambda / \sqrt D \rangle = 1, \qquad
    \langle (M_{12} \lambda / \sqrt D - g) / M_{11} \rangle = 0, \qquad
    D = M_{11} M_{22} - M_{12}^2

with the mean over the angle :math:`\theta` around the deformed section and h the section's radius
over its radius at rest. Derivation: ``docs/derivations/section.md``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spiral_core.errors import ActuationLimit, InvalidInputError
from spiral_core.numerics.panels import (
    Panels,
    graded_edges,
    panel_nodes,
    refined_panels,
    rising_root,
)
from spiral_core.numerics.roots import first_sign_change

Array = NDArray[np.float64]
# float64, or complex128 while a derivative is taken by the complex step
Numbers = NDArray[Any]


@dataclass(frozen=True, slots=True)
class FiberSet:
    """The fibers of a section, checked by who builds it; hashable, as paths are cached by it.

    Args:
        slopes: p of each wound family (one or two).
        single_slope: T, tangent of the single fibers' angle; 0 without any.
        half_spread: single fibers lie at plus and minus this material angle [rad]; None: none.
        single_radius: their distance from the axis over the radius of the wound fibers.
        wall_ratio: inner radius over the radius of the wound fibers; None takes the wall as thin.
        twist_shear: whether the energy of a thin wall counts the shear by the twist.
    """

    slopes: tuple[float, ...]
    single_slope: float = 0.0
    half_spread: float | None = 0.0
    single_radius: float = 1.0
    wall_ratio: float | None = None
    twist_shear: bool = True

    def wall_change(self, strain: Numbers, free: Numbers | None = None) -> tuple[Numbers, Numbers]:
        """Return z and n of the metric at a strain m; one family leaves z free, to be given."""
        if free is not None:
            (p,) = self.slopes
            return free, -p * (p * strain + 2.0 * free)
        p, q = self.slopes
        return -0.5 * (p + q) * strain, p * q * strain

    def collapse_strains(self) -> tuple[float, float]:
        """Return the strains m < 0 and m > 0 at which two families leave the wall no area."""
        p, q = self.slopes
        tangent = self.single_slope
        linear = 1.0 + p * q * (1.0 + tangent * tangent) + (p + q) * tangent
        square = 0.25 * (p - q) ** 2
        root = math.sqrt(linear * linear + 4.0 * square)
        # Neither root from a difference of what is nearly equal.
        large = 0.5 * (linear + math.copysign(root, linear)) / square
        other = -1.0 / (square * large)
        return min(large, other), max(large, other)


def family_slope(angle: float, single_slope: float) -> float:
    """Return p = 1/(tan(angle) - T), 0 for a hoop.

    Example:
        >>> family_slope(math.radians(45.0), 0.0).__round__(12), family_slope(math.pi / 2, 0.0)
        (1.0, 0.0)
    """
    cosine, sine = math.cos(angle), math.sin(angle)
    if abs(angle) == 0.5 * math.pi:
        cosine = 0.0
    return cosine / (sine - single_slope * cosine)


# Means over half a period of an even analytic function: the error falls by a factor per node. With
# 12 nodes it is at rounding for the paper's prototypes; a far side near collapse takes more.
ANGLES = 24
# One wound family leaves a field free, to be solved for at each node: it is as smooth.
FREE_ANGLES = 12
# Gauss nodes across a thick wall: pressures to 1e-11 with walls of a sixth of the radius.
DEPTHS = 6

_THETA: Array = (np.arange(ANGLES, dtype=np.float64) + 0.5) * (np.pi / ANGLES)
_COSINES: dict[int, Array] = {
    count: np.cos((np.arange(count) + 0.5) * (np.pi / count)) for count in (ANGLES, FREE_ANGLES)
}
_ORDERS: Array = np.arange(1, ANGLES, dtype=np.float64)


def _cosines(fibers: FiberSet) -> Array:
    """Return the cosines of the angles at which a section of two families is evaluated.

    Without single fibers one is enough: every point has the same strains.
    """
    return _COSINES[ANGLES][: ANGLES if fibers.half_spread is not None else 1]


class Ring(NamedTuple):
    """A section at (n,) far-side strains; fields around it are (n, angles).

    Attributes:
        stretch_change: mean axial stretch of the centerline, minus 1.
        bend: K, curvature per unstretched length times the section's radius.
        twist: g, torsion per unstretched length times the section's radius.
        hoop: h, the section's radius over that at rest.
        strain: m, around.
        weight: share of the wall's material at each angle; its mean is 1.
        shear: z, around.
        hoop_change: n, around.
        area_change: D - 1, around.
        warp: residual of the wall's closure along the axis.
        spread: material angle at which the near point lies, minus the single fibers' own [rad].
    """

    stretch_change: Numbers
    bend: Numbers
    twist: Numbers
    hoop: Numbers
    strain: Numbers
    weight: Numbers
    shear: Numbers
    hoop_change: Numbers
    area_change: Numbers
    warp: Numbers
    spread: Numbers


def ring_at(
    fibers: FiberSet,
    far_strain: Numbers,
    twist_change: Numbers,
    near_angle: Numbers | float = 0.0,
    free: Numbers | None = None,
    facing: complex = 1.0,
) -> Ring:
    """Return the section at a strain of its far side, not yet closed: see its residuals.

    Args:
        fibers: the fibers.
        far_strain: (n,) m opposite the single fibers.
        twist_change: (n,) g - T.
        near_angle: (n,) deformed angle of the single fibers [rad]; 0 for one.
        free: (n, FREE_ANGLES) z, for one wound family.
        facing: cosine of the angle between one single fiber and the plane of the coil; 1 unless the
            section is bent sideways.
    """
    cosines = _cosines(fibers) if free is None else _COSINES[free.shape[1]]
    tangent = fibers.single_slope
    turn = twist_change * (2.0 * tangent + twist_change)  # g^2 - T^2
    far = np.sqrt(1.0 + far_strain - turn)  # axial stretch of the far side
    bend = 0.0 * far
    if fibers.half_spread is not None:
        square = fibers.single_radius**2
        near = np.sqrt(1.0 - square * turn)  # that of the single fibers' line
        reach = fibers.single_radius * np.cos(near_angle) * facing
        bend = (far_strain - (1.0 - square) * turn) / ((far + near) * (1.0 + reach))
    stretch_change = (far_strain - turn) / (1.0 + far) - bend
    axial = 1.0 + stretch_change[:, None] - bend[:, None] * cosines
    twist = tangent + twist_change
    # m = (lambda - far)(lambda + far) + far_strain, without the cancellation near rest
    strain = far_strain[:, None] - bend[:, None] * (1.0 + cosines) * (axial + far[:, None])
    shear, hoop_change = fibers.wall_change(strain, free)
    area_change = (
        strain
        - 2.0 * tangent * shear
        + (1.0 + tangent * tangent) * hoop_change
        + strain * hoop_change
        - shear * shear
    )
    spacing = axial / np.sqrt(1.0 + area_change)
    hoop = 1.0 / spacing.mean(axis=1)
    weight = spacing * hoop[:, None]
    slope = ((tangent + shear) * spacing - twist[:, None]) / (1.0 + tangent * tangent + strain)
    spread = _material_angle(weight, near_angle) - (fibers.half_spread or 0.0)
    return Ring(
        stretch_change, bend, twist, hoop, strain, weight, shear, hoop_change, area_change,
        slope.mean(axis=1), spread,
    )  # fmt: skip


def _material_angle(weight: Numbers, angle: Numbers | float) -> Numbers:
    """Return the integral of the weight from 0 to an angle, by its cosine series."""
    if isinstance(angle, float):  # the single fiber itself marks zero
        return angle * weight[:, 0]
    orders = _ORDERS[:, None]
    series = (2.0 / ANGLES) * weight @ np.cos(orders * _THETA).T
    reached: Numbers = angle + (series * np.sin(angle[:, None] * _ORDERS) / _ORDERS).sum(axis=1)
    return reached


def invariant_excess(fibers: FiberSet, ring: Ring) -> tuple[Numbers, Numbers, Array]:
    """Return I1 - 3 and I2 - 3 at each quadrature point, and the points' share of the wall.

    Returns:
        Two arrays (n, points), and the shares (points,), which sum to the wall's 1 over the points
        times the ring's weight; points are angles, times depths for a thick wall.
    """
    if fibers.wall_ratio is None:
        mixed = ring.shear * ring.shear - ring.strain * ring.hoop_change
        square = ring.area_change * ring.area_change
        area = 1.0 + ring.area_change
        shear = 0.0 if fibers.twist_shear else ring.twist[:, None] ** 2
        first, second = mixed + square / area - shear, (square + mixed - shear) / area
        count = ring.weight.shape[1]
        return first, second, np.full(count, 1.0 / count)
    # Radii over the wound fibers' radius, and their shares of the wall's volume.
    nodes, weights = np.polynomial.legendre.leggauss(DEPTHS)
    inner = fibers.wall_ratio**2
    depths = np.sqrt(0.5 * (1.0 + inner) + 0.5 * (1.0 - inner) * nodes).tolist()
    layers = [_layer(fibers, ring, depth) for depth in depths]
    first, second = (np.concatenate(parts, axis=1) for parts in zip(*layers, strict=True))
    count = ring.weight.shape[1]
    return first, second, np.repeat(0.5 * weights / count, count)


def _layer(fibers: FiberSet, ring: Ring, depth: float) -> tuple[Numbers, Numbers]:
    """Return I1 - 3 and I2 - 3 at one radius of an incompressible thick wall."""
    mean, hoop = 1.0 + ring.stretch_change[:, None], ring.hoop[:, None]
    slant = ring.bend[:, None] / hoop * _cosines(fibers)
    room = 0.5 * (depth * depth - 1.0) * ring.weight
    radius = depth * hoop + 0.0 * ring.weight  # deformed, over the wound fibers' radius at rest
    for _ in range(12):  # volume between this radius and the fibers' stays: Newton's method
        cubic = radius**3 - hoop**3
        gap = 0.5 * mean * (radius**2 - hoop**2) - slant * cubic / 3.0 - room
        radius = radius - gap / (radius * (mean - slant * radius))
    outward = radius / hoop
    axial, around = mean - slant * radius, ring.twist[:, None] * outward
    tangent = fibers.single_slope
    metric = 1.0 + tangent * tangent + ring.strain
    spin = hoop / ring.weight  # sqrt(D) / lambda at the wound fibers
    slide = (tangent + ring.shear - ring.twist[:, None] * spin) / metric
    turning = spin * outward
    along = axial - tangent * slide * axial
    across = around - tangent * (slide * around + turning)
    hoop_square = ((slide * axial) ** 2 + (slide * around + turning) ** 2) / depth**2
    area = (axial * turning / depth) ** 2
    trace = along**2 + across**2 + hoop_square
    return trace + 1.0 / area - 3.0, area + trace / area - 3.0


# The complex step: derivatives to rounding.
STEP = 1e-30
NEWTON_STEPS, CONVERGED, ROUNDING = 8, 1e-14, 4e-15
# Rows solved at once. A first one beyond this strain, and one that is too far from the last, is
# approached in steps; those below this fraction of it find no way on: it is much less than
# END_MARGIN.
ROWS, FAR, LEAST_STEP = 6, 0.1, 1e-5


def ring_of(fibers: FiberSet, far_strains: Numbers, unknowns: Numbers) -> Ring:
    """Return the section at the unknowns of its closure: g - T, and the single fibers' angle."""
    near = unknowns[:, 1] if unknowns.shape[1] > 1 else 0.0
    return ring_at(fibers, far_strains, unknowns[:, 0], near)


def _residuals(fibers: FiberSet, far_strains: Numbers, unknowns: Numbers) -> Numbers:
    ring = ring_of(fibers, far_strains, unknowns)
    parts = (ring.warp, ring.spread)[: unknowns.shape[1]]
    return np.stack(parts, axis=1)


def _jacobian(fibers: FiberSet, far_strains: Numbers, unknowns: Array) -> Array:
    """Return the derivatives (n, equations, unknowns) of the closure."""
    columns = [
        _residuals(fibers, far_strains, unknowns + 1j * STEP * one).imag / STEP
        for one in np.eye(unknowns.shape[1])
    ]
    return np.stack(columns, axis=2)


def closure_slopes(fibers: FiberSet, far_strains: Array, unknowns: Array) -> Array:
    """Return d(unknowns)/dy along the path."""
    change = _residuals(fibers, far_strains + 1j * STEP, unknowns + 0j).imag / STEP
    jacobian = _jacobian(fibers, far_strains, unknowns)
    return np.asarray(-np.linalg.solve(jacobian, change[:, :, None])[:, :, 0], dtype=np.float64)


def closures(fibers: FiberSet, far_strains: Array) -> tuple[Array, NDArray[np.bool_], float]:
    """Return the unknowns (n, 1 or 2) that close the section, where they were found, and how far.

    From rest outwards, a few rows at a time, each guessed from the last, up to the first that does
    not close.
    """
    if fibers.half_spread is None:  # every point has the same strains
        shear, hoop_change = fibers.wall_change(far_strains)
        found = (shear / np.sqrt(1.0 + hoop_change))[:, None]
        return found, np.isfinite(found[:, 0]), math.inf
    rest = np.array([[0.0, fibers.half_spread] if fibers.half_spread else [0.0]])
    ratio, known = closure_slopes(fibers, np.zeros(1), rest), 0.0
    known_states: dict[float, Array] = {0.0: rest[0]}
    ordered = far_strains[np.argsort(np.abs(far_strains), kind="stable")]
    left = [ordered[k : k + ROWS] for k in range(0, len(ordered), ROWS)][::-1]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        while left:
            rows = left.pop()
            far = known == 0.0 and abs(rows[0]) > FAR
            states, good = _newton(fibers, rows, rest + ratio * rows[:, None])
            if good.all() and not far:
                known_states |= zip(rows.tolist(), states, strict=True)
                if rows[-1] != 0.0:
                    ratio, known = (states[-1:] - rest) / rows[-1], float(rows[-1])
            elif len(rows) > 1:  # the nearest first, then the others
                left += [rows[1:], rows[:1]]
            elif abs(rows[0] - known) > LEAST_STEP * abs(rows[0]):  # half-way first
                left += [rows, 0.5 * (known + rows)]
            else:
                break
    nowhere = np.full_like(rest[0], np.nan)
    unknowns = np.array([known_states.get(y, nowhere) for y in far_strains.tolist()])
    return unknowns, np.isfinite(unknowns[:, 0]), known


def _newton(
    fibers: FiberSet, far_strains: Array, unknowns: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the unknowns that close the section, from a guess, and where they were found."""
    closed = np.zeros(len(far_strains), dtype=np.bool_)
    for _ in range(NEWTON_STEPS):
        residuals = _residuals(fibers, far_strains, unknowns)
        jacobian = _jacobian(fibers, far_strains, unknowns)
        usable = np.isfinite(jacobian).all(axis=(1, 2)) & (np.linalg.det(jacobian) != 0.0)
        jacobian[~usable] = np.eye(unknowns.shape[1])
        step = np.linalg.solve(jacobian, residuals[:, :, None])[:, :, 0]
        unknowns = np.where(usable[:, None], unknowns - step, np.nan)
        floor = abs(fibers.single_slope) + (fibers.half_spread or 0.0)
        size = CONVERGED * (np.abs(far_strains) + np.abs(unknowns[:, 0])) + ROUNDING * floor
        closed = usable & (np.abs(step).max(axis=1) <= size)
        if closed.all():
            break
    return unknowns, closed


# The path stops short of where something diverges or turns back by this fraction of its strain.
END_MARGIN = 1e-4
# A panel is at most this fraction of the distance to the nearest strain at which the wall
# collapses, where the path is singular; one whose polynomials end above the tolerance is halved.
PANEL_WIDTH, TAIL_TOLERANCE, HALVINGS = 0.5, 1e-13, 3
# Two ends nearer to each other than this fraction are one.
SAME_END = 1e-9
# Strains at which the end of the path is looked for.
SCAN = 96
# Where the volume changes less with the strain at rest, pressure moves the tube to neither side.
LEAST_VOLUME_SLOPE = 1e-6


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
    unknowns, closed, _ = closures(fibers, far_strains)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        slopes = closure_slopes(fibers, far_strains, unknowns)
        moved = ring_of(fibers, far_strains + 1j * STEP, unknowns + 1j * STEP * slopes)
        return _motion(fibers, moved, closed)


def sideways_motion(fibers: FiberSet, far_strains: Array) -> Motion:
    """Return the closed section with derivatives as one single fiber leaves the coil's plane.

    The derivatives are those in the cosine of the angle between the two, at 1: by symmetry nothing
    changes in the first order of the angle itself.
    """
    unknowns, closed, _ = closures(fibers, far_strains)
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


@lru_cache(maxsize=64)
def section_path(fibers: FiberSet) -> SectionPath:
    """Return the path of a section of two families, from rest to its end.

    Args:
        fibers: two families, with or without single fibers.
    """
    # Pressure moves the far side in the direction in which the enclosed volume grows at rest.
    motion = motion_at(fibers, np.zeros(1))
    if not abs(motion.volume_slope[0]) >= LEAST_VOLUME_SLOPE:
        requirement = "a set that pressure moves: the enclosed volume must change with the stretch"
        raise InvalidInputError("fibers", "fibers at the magic angle", requirement)
    direction = 1.0 if motion.volume_slope[0] > 0.0 else -1.0
    low, high = fibers.collapse_strains()
    left, right = (-low, high) if direction > 0.0 else (high, -low)

    def sample(sizes: Array) -> Array:
        nonlocal motion
        motion = motion_at(fibers, direction * sizes.ravel())
        values = (motion.volume_slope, motion.ring.stretch_change, motion.first_slope[:, -1])
        return np.stack(values).reshape(-1, *sizes.shape)

    # Panels on which polynomials meet the path to rounding, whose states are the last sampled.
    past_end = _past_end(fibers, direction, right)
    edges = graded_edges(past_end, min(left, 1.0), right, PANEL_WIDTH)
    edges, _ = refined_panels(edges, sample, TAIL_TOLERANCE, HALVINGS)
    sizes, ring = panel_nodes(edges), motion.ring

    def panels(values: Array) -> Panels:
        return Panels(edges, values.reshape(sizes.shape))

    volume_slope = panels(direction * motion.volume_slope)
    nodes = np.linspace(0.0, edges[-1], SCAN).tolist()
    largest_volume = first_sign_change(volume_slope, nodes)
    end = first_sign_change(panels(motion.stretch_slope), nodes) or edges[-1]
    limit = ActuationLimit.FIBER_LOCKING
    # Next to a hoop family both come at once: then it is the other family that locks.
    if largest_volume is not None and largest_volume < (1.0 - SAME_END) * end:
        end, limit = largest_volume, ActuationLimit.VOLUME_MAXIMUM
    return SectionPath(
        fibers=fibers,
        direction=direction,
        edges=edges,
        strain_limit=end * (1.0 - END_MARGIN),
        limit=limit,
        motion=motion,
        stretch=panels(ring.stretch_change / sizes.ravel()),
        volume_slope=volume_slope,
        curvature=panels(ring.bend / ring.hoop / sizes.ravel()),
        torsion=panels((ring.twist / ring.hoop - fibers.single_slope) / sizes.ravel()),
    )


def _past_end(fibers: FiberSet, direction: float, collapse: float) -> float:
    """Return a |y| at which the section still closes, just past the end of its path."""
    sizes = collapse * (1.0 - END_MARGIN) * (np.arange(SCAN + 1) / SCAN) ** 2
    motion = motion_at(fibers, direction * sizes)
    ended = ~((direction * motion.volume_slope > 0.0) & (motion.stretch_slope > 0.0))
    first = int(np.argmax(ended[1:])) + 1 if ended[1:].any() else SCAN
    if motion.closed[first]:
        return float(sizes[first])
    # A little before the last state found, so that it is found from elsewhere too.
    reached = closures(fibers, direction * sizes[first - 1 : first + 1])[2]
    return abs(reached) * (1.0 - END_MARGIN)
