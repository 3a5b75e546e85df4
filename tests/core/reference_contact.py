# SPDX-License-Identifier: Apache-2.0
"""Closed forms of rods in contact. Nothing of ``spiral_core`` is used.

``rho`` is the distance of the centerline from the cylinder's axis, ``r_o`` the rod's radius.
``test_contact_closed_forms.py`` finds the solver to converge to each of them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Array = NDArray[np.float64]


def helix_on_cylinder(stiffness, strain, rho, angle):
    """Return what a helix carries that lies evenly on a cylinder (Kirchhoff's equations).

    Without force along the axis, as with free ends.

    Args:
        stiffness: GJ and EI [N m^2].
        strain: rest torsion and curvature [1/m].
        rho: see above.
        angle: between tangent and axis.

    Returns:
        Force [N] and moment [N m] along tangent, normal and binormal, and the line force q [N/m]
        of the cylinder on the rod, outward positive.
    """
    sin, cos = math.sin(angle), math.cos(angle)
    curvature, torsion = sin * sin / rho, sin * cos / rho
    m_t, m_b = stiffness[0] * (torsion - strain[0]), stiffness[1] * (curvature - strain[1])
    n_b = m_t * curvature - m_b * torsion
    n_t = -n_b * math.tan(angle)
    return np.array((n_t, 0.0, n_b)), np.array((m_t, 0.0, m_b)), n_t * curvature - torsion * n_b


def helix_in_tube(bending, rho, angle):
    """Return push F [N] and wall force q [N/m], inward positive, of a buckled straight rod.

    Free of moment about the axis and of torque at its ends, for any angle; at small ones
    theta^2 = F rho^2 / (2 EI) and q = rho F^2 / (4 EI).
    """
    sin, cos = math.sin(angle), math.cos(angle)
    return 2.0 * bending * sin**2 * cos / rho**2, bending * sin**4 / rho**3


def thick_capstan_exponent(friction, rho, r_o):
    """Return lambda in T ~ exp(lambda phi) of a rod that slides, where its curvature is constant.

    Friction acts at the surface, so it turns the section too: a mu lambda^2 + lambda - mu b = 0.
    """
    a, b = r_o / rho, (rho - r_o) / rho
    return (math.sqrt(1.0 + 4.0 * friction**2 * a * b) - 1.0) / (2.0 * friction * a)


def lift_off_angle(bending, rho, tension):
    """Return psi, by which the tangent of a long straight rod still turns after it lifts off.

    sin(psi / 2) = sqrt(EI / F) / (2 rho). A point force F sin(psi) acts where it lifts off.
    """
    return 2.0 * math.asin(math.sqrt(bending / tension) / (2.0 * rho))


def cantilever_over_cylinder(bending, length, rho, force):
    """Return the free length [m] and the tip (x, z) of a straight rod pressed over a cylinder.

    Clamped level on top of it, with a dead force down at the tip; large deflections. The free part
    is an elastica of curvature 1 / rho where it lifts off. For small deflections its length is
    EI / (P rho) and the tip sinks by L^2 / (2 rho) - EI^2 / (6 P^2 rho^3).
    """

    def tip(free):
        turned = (length - free) / rho
        start = [rho * math.sin(turned), rho * (math.cos(turned) - 1.0), -turned, -1.0 / rho]
        return solve_ivp(
            lambda _, y: [math.cos(y[2]), math.sin(y[2]), y[3], force / bending * math.cos(y[2])],
            (0.0, free), start, method="DOP853", rtol=1e-12, atol=1e-14,
        ).y[:, -1]  # fmt: skip

    free = brentq(lambda f: tip(f)[3], 1e-6 * length, length, xtol=1e-14)
    return free, tip(free)[:2]
