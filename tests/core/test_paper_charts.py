# SPDX-License-Identifier: Apache-2.0
"""What the paper states about the helix model, next to what this model gives.

N. K. Uppalapati, G. Krishnan, Soft Robotics 5(6), 2018, doi 10.1089/soro.2017.0144.
"""

import numpy as np
from core.actuator_cases import PAPER_TUBE, actuator, degrees
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from spiral_core import FreeActuation
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.fibers import locking_stretch
from spiral_core.wrap.helix import Helix


def helix(alpha, beta, stretch):
    shape = unloaded_shape_from_stretch(actuator(alpha, beta), stretch)
    return Helix(shape.curvature, shape.torsion)


def object_radius(alpha, beta, stretch):
    return helix(alpha, beta, stretch).object_radius(PAPER_TUBE.outer_radius)


def stretch_for_radius(alpha, beta, radius):
    end = 0.9999 * locking_stretch(degrees(alpha, beta))
    return brentq(lambda s: object_radius(alpha, beta, s) - radius, 1.001, end, xtol=1e-14)


def test_design_example_has_the_papers_length_and_covers_both_of_its_objects():
    for alpha, length in [(90.0, 0.35949), (88.0, 0.36403)]:
        # beta 70 degrees, 30 mm pipe; the paper says 361 mm, without the number of turns: at 1.5
        # turns it lies between alpha = 90 and 88 degrees. As documented, to the last digit.
        large, small = (stretch_for_radius(alpha, 70.0, radius) for radius in (0.030, 0.011))
        found = helix(alpha, 70.0, large).length_for_turns(1.5)
        assert_allclose(found, length, 0, 0.5e-5)
        assert_allclose(found, 0.361, 0.01)
    # The strain interval as documented, to its last digit.
    assert_allclose((large, small), (1.1135, 1.2386), 0, 5e-5)
    assert small < FreeActuation(actuator(alpha, 70.0)).stretch_limit


def changes(figures, values):
    """Return by which share alpha = 88 degrees instead of 90 changes figures, beta = 50."""
    near, at = (
        np.array([figures(alpha, 50.0, value) for value in values]) for alpha in (88.0, 90.0)
    )
    return near / at - 1.0


def test_88_degrees_moves_the_needed_stretch_by_less_than_one_percent():
    # The paper: alpha = 88 instead of 90 changes the charts by less than 1 %, beta = 50. Read along
    # the stretch, at equal object radius, so it does: by 0.55 % at most from r_w/r = 20 to 0.25.
    radii = np.geomspace(0.25, 20.0, 25) * PAPER_TUBE.inner_radius
    stretch = changes(stretch_for_radius, radii)
    assert -0.0056 < stretch.min() < stretch.max() < 0.0


def test_88_degrees_moves_object_length_but_not_radius_by_less_than_one_percent():
    # Read at equal stretch, beta = 50, it holds for the object length alone. The twist rate at rest
    # is proportional to cot(alpha) + cot(beta): 4.2 % more, and radius and length feel it.
    def figures(*given):
        coil = helix(*given)
        return object_radius(*given), coil.object_length(1.0), coil.length_for_turns(1.0)

    radius, covered, length = changes(figures, np.linspace(1.01, 1.25, 25)).T
    assert np.abs(covered).max() < 0.01
    assert -0.0174 < length.min() < length.max() < -0.0169
    assert -0.089 < radius.min() < radius.max() < -0.034
