# SPDX-License-Identifier: Apache-2.0
"""Actuators of the section law that its tests share."""

from dataclasses import replace
from math import pi, radians

import numpy as np
from core.actuator_cases import LATEX, actuator

from spiral_core import (
    CurvatureForm,
    Gent,
    MooneyRivlin,
    NeoHookean,
    OneFamily,
    PressureLaw,
    SingleFiber,
    Yeoh,
)
from spiral_core.actuator.section import invariant_excess, motion_at

LAWS = (
    NeoHookean(145.0e3),
    MooneyRivlin(118.4e3, 105.7e3),
    Yeoh(145.0e3, -5.0e3, 1.0e3),
    Gent(290.0e3, 30.0),
)


def section(alpha, beta, material=LATEX, gamma=0.0, apart=0.0, **choices):
    """Return an actuator of the section law, by default in its exact form; angles in degrees."""
    half = radians(0.5 * apart)
    places = (half, -half) if apart else (0.0,)
    singles = tuple(SingleFiber(radians(gamma), place) for place in places)
    exact = {"curvature_form": CurvatureForm.EXACT, "pressure_law": PressureLaw.SECTION}
    return actuator(alpha, beta, material, **exact | {"single_fibers": singles} | choices)


def one_family(angle, law=LATEX, gamma=0.0):
    """Return a tube with one wound family and a single fiber; angles in degrees."""
    return replace(section(88.0, 60.0, law, gamma), fibers=OneFamily(radians(angle)))


def uniform(bent):
    return replace(
        bent,
        pressure_law=PressureLaw.UNIFORM,
        curvature_form=CurvatureForm.FIRST_ORDER,
        single_fibers=(SingleFiber(),),
    )


def wall(curve, sizes):
    """Return energy [J/m], volume [m^2], curvature and twist [1/m] at far-side strains.

    Per length at rest; the energy from the invariants alone.
    """
    return of_ring(curve, motion_at(curve.path.fibers, curve.path.direction * sizes).ring)


def of_ring(curve, ring):
    """Return the same of a section whether it closes or not."""
    bent = curve.actuator
    first, second, quadrature = invariant_excess(curve.path.fibers, ring)
    share = np.tile(ring.weight, len(quadrature) // ring.weight.shape[1]) * quadrature
    density = np.vectorize(bent.material.energy_density)(3.0 + first, 3.0 + second)
    energy = bent.tube.wall_area * (share * density).sum(axis=1)
    volume = pi * bent.wound_radius**2 * (1.0 + ring.stretch_change) * ring.hoop**2
    turns = (turn / ring.hoop / bent.wound_radius for turn in (ring.bend, ring.twist))
    return np.array([energy, volume, *turns])
