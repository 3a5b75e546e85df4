# SPDX-License-Identifier: Apache-2.0
"""Actuators, strategies and settings that the tests of the actuator share."""

from dataclasses import astuple
from math import radians, sin

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from spiral_core import Actuator, FiberAngles, MooneyRivlin, PressureLaw, Tube
from spiral_core.actuator.fibers import initial_volume_slope

# The same examples in every run, and no wall clock: a failure repeats.
repeatable = settings(derandomize=True, deadline=None, database=None, max_examples=150)

PAPER_TUBE = Tube(4.7625e-3, 0.79375e-3, 0.5)
LATEX = MooneyRivlin(130.0e3, 15.0e3)


def degrees(alpha, beta):
    return FiberAngles(radians(alpha), radians(beta))


def mirrored(fibers):
    """Return families of the other handedness."""
    return type(fibers)(*(-angle for angle in astuple(fibers)))


def actuator(alpha=88.0, beta=60.0, material=LATEX, **choices):
    choices = {"tube": PAPER_TUBE, "pressure_law": PressureLaw.UNIFORM} | choices
    return Actuator(fibers=degrees(alpha, beta), material=material, **choices)


def derivative(function, at, step):
    """Return the derivative of a function of arrays, to fourth order in the step."""
    return function(at + step * np.array([-2, -1, 1, 2])) @ [1, -8, 8, -1] / (12.0 * step)


# From 0.1 degrees off the axis to 90, both hands, 90 itself and its neighbors well represented.
angles = st.one_of(
    st.floats(0.1, 90.0),
    st.floats(-90.0, -0.1),
    st.sampled_from([90.0, -90.0, 89.9999999, 88.0, 54.735610317245346]),
)
near_pairs = st.tuples(st.floats(5.0, 85.0), st.floats(0.01, 1.0)).map(np.cumsum)
fiber_pairs = (
    st.one_of(st.tuples(angles, angles), near_pairs)
    .filter(lambda pair: abs(sin(radians(pair[0] - pair[1]))) > 1.1e-4)
    .map(lambda pair: degrees(*pair))
)
extending_pairs = fiber_pairs.filter(lambda fibers: initial_volume_slope(fibers) > 1e-3)

# How far from rest (0) to fiber locking (1): close to both ends too.
fractions = st.one_of(
    st.floats(1e-3, 0.99), st.sampled_from([1e-12, 1e-9, 1e-6, 1.0 - 1e-6, 1.0 - 1e-9])
)
