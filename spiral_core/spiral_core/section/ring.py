# SPDX-License-Identifier: Apache-2.0
r"""Strains around the section of a bent, twisted tube whose cross-section stays round.

Swept along its helix, every material line along the single fiber's direction has the local axial
stretch :math:`\lambda = \bar\lambda - K \cos\theta` and the shear g, so that
:math:`M_{11} = \lambda^2 + g^2`. The wall closes around the section if

.. math:: h \langle \lambda / \sqrt D \rangle = 1, \qquad
    \langle (M_{12} \lambda / \sqrt D - g) / M_{11} \rangle = 0, \qquad
    D = M_{11} M_{22} - M_{12}^2

with the mean over the angle :math:`\theta` around the deformed section and h the section's radius
over its radius at rest. Derivation: ``docs/derivations/section.md``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spiral_core.section.fiber_set import Array, FiberSet, Numbers

# Means over half a period of an even analytic function: the error falls by a factor per node. With
# 12 nodes it is at rounding for the paper's prototypes; a far side near collapse takes more.
ANGLES = 24
# One wound family leaves a field free, to be solved for at each node: it is as smooth.
FREE_ANGLES = 12
# Gauss nodes across a thick wall: pressures to 1e-11 with walls of a sixth of the radius.
DEPTHS = 6

_THETA: Array = (np.arange(ANGLES, dtype=np.float64) + 0.5) * (np.pi / ANGLES)
_COSINES = {
    count: np.cos((np.arange(count) + 0.5) * (np.pi / count)) for count in (ANGLES, FREE_ANGLES)
}
_ORDERS: Array = np.arange(1, ANGLES, dtype=np.float64)


class Ring(NamedTuple):
    """A section at (n,) far-side strains; fields around it are (n, ANGLES).

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
    cosines = _COSINES[ANGLES if free is None else free.shape[1]]
    tangent = fibers.single_slope
    turn = twist_change * (2.0 * tangent + twist_change)  # g^2 - T^2
    far = np.sqrt(1.0 + far_strain - turn)  # axial stretch of the far side
    bend = 0.0 * far
    if fibers.is_bending:
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
        count = ring.weight.shape[1]
        return mixed + square / area, (square + mixed) / area, np.full(count, 1.0 / count)
    depths, shares = _depths(fibers.wall_ratio)
    layers = [_layer(fibers, ring, float(depth)) for depth in depths]
    first = np.concatenate([one for one, _ in layers], axis=1)
    second = np.concatenate([two for _, two in layers], axis=1)
    return first, second, np.repeat(shares / ANGLES, ANGLES)


def _depths(wall_ratio: float) -> tuple[Array, Array]:
    """Return radii over the wound fibers' radius, and their shares of the wall's volume."""
    nodes, weights = np.polynomial.legendre.leggauss(DEPTHS)
    squares = 0.5 * (1.0 + wall_ratio**2) + 0.5 * (1.0 - wall_ratio**2) * nodes
    return np.sqrt(squares), 0.5 * weights


def _layer(fibers: FiberSet, ring: Ring, depth: float) -> tuple[Numbers, Numbers]:
    """Return I1 - 3 and I2 - 3 at one radius of an incompressible thick wall."""
    mean, hoop = 1.0 + ring.stretch_change[:, None], ring.hoop[:, None]
    slant = ring.bend[:, None] / hoop * _COSINES[ANGLES]
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
