# SPDX-License-Identifier: Apache-2.0
"""Rods and obstacles that the contact tests share."""

import math
from functools import cache

import numpy as np
from scipy.optimize import brentq

from spiral_core import (
    Actuator,
    Cylinder,
    FiberAngles,
    NeoHookean,
    Obstacle,
    Plane,
    Rod,
    RodLoad,
    RodProblem,
    Section,
    Tube,
    gripper_from_actuator,
)
from spiral_core.actuator.fibers import fiber_state

LENGTH = 0.36
INNER, WALL = 4.7625e-3, 0.79375e-3
OUTER = INNER + WALL
YOUNG = 0.78e6
INERTIA = 0.25 * math.pi * (OUTER**4 - INNER**4)
BENDING = YOUNG * INERTIA
SECTION = Section((2.0 / 3.0 * BENDING, BENDING, BENDING))
ANGLES = FiberAngles(alpha=math.radians(88.0), beta=math.radians(70.0))


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
    actuator = Actuator(Tube(INNER, WALL, LENGTH), ANGLES, NeoHookean(0.13e6))
    return gripper_from_actuator(
        "example",
        actuator,
        density=930.0,
        stiffness=Section.inextensible(BENDING, 2.0 / 3.0 * BENDING),
    )


def rest_strain(stretch):
    """Return (torsion, 0, curvature) of the 70 degree gripper."""
    return (fiber_state(ANGLES, stretch).twist / INNER, 0.0, (stretch - 1.0) / INNER)


@cache
def wrap_stretch(radius):
    """Return the stretch at which the helix just fits a cylinder."""

    def room(stretch):
        torsion, _, curvature = rest_strain(stretch)
        return curvature / (curvature**2 + torsion**2) - OUTER - radius

    return brentq(room, 1.02, 1.3, xtol=1e-15)


def curled(radius, fraction):
    """Return the rest strain at a fraction of the stretch that wraps a cylinder."""
    return rest_strain(1.0 + fraction * (wrap_stretch(radius) - 1.0))


def grip(radius, fraction, friction=0.0, shift=0.0):
    """Return the gripper tangent to a cylinder, which is shifted along its axis."""
    axis = np.array(curled(radius, 1.0))
    obstacle = Obstacle.along(Cylinder(radius), (0.0, radius + OUTER, 0.0), axis, friction)
    obstacle = obstacle.moved(shift * axis / np.linalg.norm(axis))
    return RodProblem(Rod(LENGTH, SECTION, OUTER, curled(radius, fraction)), obstacles=(obstacle,))
