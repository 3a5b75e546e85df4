# SPDX-License-Identifier: Apache-2.0
"""Actuators of the section law that its tests share."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from core.actuator_cases import LATEX, PAPER_TUBE, degrees

from spiral_core import (
    Actuator,
    CurvatureForm,
    Gent,
    HyperelasticLaw,
    MooneyRivlin,
    NeoHookean,
    OneFamily,
    PressureLaw,
    SingleFiber,
    Tube,
    Yeoh,
)
from spiral_core.actuator.actuation import FreeActuation
from spiral_core.actuator.section import motion_at

LAWS = (
    NeoHookean(c1=145.0e3),
    MooneyRivlin(c1=118.4e3, c2=105.7e3),
    Yeoh(c1=145.0e3, c2=-5.0e3, c3=1.0e3),
    Gent(shear_modulus=290.0e3, extension_limit=30.0),
)


STRAIGHT = (SingleFiber(),)


def section(
    alpha: float,
    beta: float,
    material: HyperelasticLaw = LATEX,
    tube: Tube = PAPER_TUBE,
    gamma: float = 0.0,
    apart: float = 0.0,
    thick_wall: bool = False,
) -> Actuator:
    """Return an actuator of the section law in its exact form; angles in degrees."""
    half = math.radians(0.5 * apart)
    places = (half, -half) if apart else (0.0,)
    singles = tuple(SingleFiber(math.radians(gamma), place) for place in places)
    return Actuator(
        tube,
        degrees(alpha, beta),
        material,
        curvature_form=CurvatureForm.EXACT,
        single_fibers=singles,
        thick_wall=thick_wall,
    )


def uniform(actuator: Actuator) -> Actuator:
    return dataclasses.replace(
        actuator,
        pressure_law=PressureLaw.UNIFORM,
        curvature_form=CurvatureForm.FIRST_ORDER,
        single_fibers=STRAIGHT,
        thick_wall=False,
    )


def wall_energy(curve: FreeActuation, actuator: Actuator, sizes: list[float]) -> np.ndarray:
    """Return the mean energy density [Pa] at far-side strains, from the invariants alone."""
    motion = motion_at(curve.path.fibers, curve.path.direction * np.array(sizes))
    densities = np.vectorize(actuator.material.energy_density)(
        3.0 + motion.first, 3.0 + motion.second
    )
    return np.asarray((motion.share * densities).sum(axis=1))


def one_family(angle: float, law: HyperelasticLaw = LATEX, gamma: float = 0.0) -> Actuator:
    """Return a tube with one wound family and a single fiber; angles in degrees."""
    return Actuator(
        PAPER_TUBE,
        OneFamily(math.radians(angle)),
        law,
        curvature_form=CurvatureForm.EXACT,
        single_fibers=(SingleFiber(math.radians(gamma)),),
    )
