# SPDX-License-Identifier: Apache-2.0
"""Closed forms of rods in contact. Nothing of ``spiral_core`` is used.

``rho`` is the distance of the centerline from the cylinder's axis, ``r_o`` the rod's radius.
``test_contact_closed_forms.py`` finds the solver to converge to each of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


@dataclass(frozen=True, slots=True)
class Section:
    """EI [N m^2], GJ [N m^2], and the rest curvature and torsion [1/m] of a uniform rod."""

    bending: float
    torsional: float
    curvature: float = 0.0
    torsion: float = 0.0


@dataclass(frozen=True, slots=True)
class WrappedHelix:
    """What a helix carries that lies evenly on a cylinder, in its Frenet frame t, N, b.

    Args:
        binormal_moment: m_b [N m].
        axial_moment: m_t [N m].
        tension: n_t [N].
        binormal_force: n_b [N].
        line_force: q [N/m] of the cylinder on the rod, outward positive.
    """

    binormal_moment: float
    axial_moment: float
    tension: float
    binormal_force: float
    line_force: float


def helix_on_cylinder(
    section: Section, rho: float, angle: float, tension: float | None = None
) -> WrappedHelix:
    """Return the loads of a helix at ``angle`` between tangent and axis (Kirchhoff's equations).

    Without ``tension`` it is the one for which no force acts along the axis, as with free ends.
    """
    sin, cos = math.sin(angle), math.cos(angle)
    curvature, torsion = sin * sin / rho, sin * cos / rho
    m_b = section.bending * (curvature - section.curvature)
    m_t = section.torsional * (torsion - section.torsion)
    n_b = m_t * curvature - m_b * torsion
    n_t = -n_b * math.tan(angle) if tension is None else tension
    return WrappedHelix(m_b, m_t, n_t, n_b, n_t * curvature - torsion * n_b)


def relaxed_angle(section: Section, rho: float, near: float) -> float:
    """Return the angle at which a helix with free ends rests on a frictionless cylinder.

    There is no moment about the axis: m_t cos 2 theta + m_b sin 2 theta = 0.
    """

    def moment(angle: float) -> float:
        helix = helix_on_cylinder(section, rho, angle)
        return helix.axial_moment * math.cos(2.0 * angle) + helix.binormal_moment * math.sin(
            2.0 * angle
        )

    width = 0.05
    while moment(near - width) * moment(near + width) > 0.0:
        width *= 1.5
    return brentq(moment, near - width, near + width, xtol=1e-14)


def helix_in_tube(bending: float, rho: float, angle: float) -> tuple[float, float]:
    """Return push F [N] and wall force q [N/m], inward positive, of a buckled straight rod.

    Free of moment about the axis and of torque at its ends, for any angle; at small ones
    theta^2 = F rho^2 / (2 EI) and q = rho F^2 / (4 EI).
    """
    sin, cos = math.sin(angle), math.cos(angle)
    return 2.0 * bending * sin**2 * cos / rho**2, bending * sin**4 / rho**3


def thick_capstan_exponent(friction: float, rho: float, r_o: float) -> float:
    """Return lambda in T ~ exp(lambda phi) of a rod that slides, where its curvature is constant.

    Friction acts at the surface, so it turns the section too: a mu lambda^2 + lambda - mu b = 0.
    """
    a, b = r_o / rho, (rho - r_o) / rho
    return (math.sqrt(1.0 + 4.0 * friction**2 * a * b) - 1.0) / (2.0 * friction * a)


def lift_off_angle(bending: float, rho: float, tension: float) -> float:
    """Return psi, by which the tangent of a long straight rod still turns after it lifts off.

    sin(psi / 2) = sqrt(EI / F) / (2 rho). A point force F sin(psi) acts where it lifts off.
    """
    return 2.0 * math.asin(math.sqrt(bending / tension) / (2.0 * rho))


def cantilever_over_cylinder(
    bending: float, length: float, rho: float, force: float
) -> tuple[float, NDArray[np.float64]]:
    """Return the free length [m] and the tip (x, z) of a straight rod pressed over a cylinder.

    Clamped level on top of it, with a dead force down at the tip; large deflections. The free part
    is an elastica of curvature 1 / rho where it lifts off. For small deflections its length is
    EI / (P rho) and the tip sinks by L^2 / (2 rho) - EI^2 / (6 P^2 rho^3).
    """

    def tip(free: float) -> NDArray[np.float64]:
        turned = (length - free) / rho
        start = [rho * math.sin(turned), rho * (math.cos(turned) - 1.0), -turned, -1.0 / rho]
        return solve_ivp(
            lambda _, y: [math.cos(y[2]), math.sin(y[2]), y[3], force / bending * math.cos(y[2])],
            (0.0, free), start, method="DOP853", rtol=1e-12, atol=1e-14,
        ).y[:, -1]  # fmt: skip

    free = brentq(lambda f: tip(f)[3], 1e-6 * length, length, xtol=1e-14)
    return free, tip(free)[:2]
