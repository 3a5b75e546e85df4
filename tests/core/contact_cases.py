# SPDX-License-Identifier: Apache-2.0
"""Rods and obstacles that the contact tests share."""

from dataclasses import replace
from functools import cache

import numpy as np
from core.actuator_cases import PAPER_TUBE, degrees
from scipy.optimize import brentq

from spiral_core import (
    Actuator,
    Cylinder,
    NeoHookean,
    Obstacle,
    Plane,
    Rod,
    RodLoad,
    RodProblem,
    Section,
    gripper_from_actuator,
)
from spiral_core.actuator.fibers import fiber_state
from spiral_core.wrap.helix import Helix

LENGTH = 0.36
INNER, OUTER = PAPER_TUBE.inner_radius, PAPER_TUBE.outer_radius
SECTION = Section(Section.round(OUTER, 0.78e6, 0.26e6, INNER).stiffness)
BENDING = SECTION.bending
ANGLES = degrees(88.0, 70.0)


def bar(radius, x, z, friction=0.0):
    """Return a cylinder along y."""
    return Obstacle.along(Cylinder(radius), (x, 0.0, z), (0.0, 1.0, 0.0), friction)


def floor(z, friction=0.0, x=0.0):
    return Obstacle(Plane(), (x, 0.0, z), friction=friction)


def down(weight, pull=0.0):
    """Return a weight per length, and a force at the tip, both along -z."""
    return RodLoad((0.0, 0.0, -weight), (0.0, 0.0, -pull))


def line(length, elements):
    """Return a straight centerline along x."""
    return np.linspace((0.0, 0.0, 0.0), (length, 0.0, 0.0), elements + 1)


@cache
def gripper():
    """Return the 70 degree gripper, hanging."""
    actuator = Actuator(replace(PAPER_TUBE, length=LENGTH), ANGLES, NeoHookean(0.13e6))
    return gripper_from_actuator("example", actuator, density=930.0, stiffness=SECTION)


@cache
def curled(radius, fraction):
    """Return the gripper's rest strain at a fraction of the stretch that wraps a cylinder."""

    def strain(more):
        return fiber_state(ANGLES, 1.0 + more).twist / INNER, 0.0, more / INNER

    def room(more):
        torsion, _, curvature = strain(more)
        return Helix(curvature, torsion).radius - OUTER - radius

    return strain(fraction * brentq(room, 0.02, 0.3, xtol=1e-15))


def grip(radius, fraction, friction=0.0, shift=0.0):
    """Return the gripper tangent to a cylinder, which is shifted along its axis."""
    axis = np.array(curled(radius, 1.0))
    point = (0.0, radius + OUTER, 0.0) + shift * axis / np.linalg.norm(axis)
    obstacle = Obstacle.along(Cylinder(radius), point, axis, friction)
    return RodProblem(Rod(LENGTH, SECTION, OUTER, curled(radius, fraction)), obstacles=(obstacle,))
