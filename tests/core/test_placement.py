# SPDX-License-Identifier: Apache-2.0
"""Where the object lies in the coil; objects whose radius varies along their axis."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from core.recorded import recorded, said
from core.wrap_cases import G, paper_curve
from numpy.linalg import norm
from numpy.testing import assert_allclose
from scipy.optimize import least_squares

from spiral_core import (
    Cylinder,
    GripSetup,
    ObjectProfile,
    Obstacle,
    WrapRegime,
    wrap_for_profile,
)
from spiral_core.wrap.placement import (
    distances_from_axis,
    misplacement,
    place_object,
    touching_nodes,
)

# So light that the coil is the unloaded helix.
WEIGHTLESS = (1.0e-9, 0.0, 0.0)


def wrap_of(gravity, fraction):
    curve = paper_curve("70 degrees", gravity)
    return curve.wrap_for_radius(
        curve.radius_min + fraction * (curve.radius_max - curve.radius_min)
    )


def misses(wrap, center, turns=1.0):
    """Return how far the nodes of the last turns are from touching [m]."""
    distances = distances_from_axis(touching_nodes(wrap, turns), center, wrap.axis)
    return distances - wrap.object_radius - wrap.outer_radius


def test_every_node_of_a_helix_touches_the_object():
    for fraction in [0.02, 0.5, 0.98]:
        wrap = wrap_of(WEIGHTLESS, fraction)
        placement = place_object(wrap)
        largest = np.abs(misses(wrap, placement.center, wrap.turns_required)).max()
        # The wrap's radius is found to 1e-9 of the contact radius; the fit is as good.
        assert largest < 1e-8 * wrap.object_radius
        assert_allclose(placement.largest_gap, largest, 0, 1e-15)
        assert (placement.radius, placement.axis) == (wrap.object_radius, wrap.coil.axis)
        # The object is as long as the turns that hold it.
        along = (touching_nodes(wrap, wrap.turns_required) - placement.center) @ placement.axis
        reach = 0.5 * placement.length - wrap.outer_radius
        assert_allclose((along.min(), along.max()), (-reach, reach), 1e-6)
        # A fifth of a turn lies on the same side, and determines the axis less sharply than one.
        short = place_object(replace(wrap, turns_required=0.2))
        apart = np.cross(np.subtract(short.center, placement.center), short.axis)
        assert norm(apart) < 1e-6 * wrap.object_radius


@pytest.mark.parametrize(
    # Weight bends a wide coil out of the helix; measured: 2 %, 11 % and 28 % of the contact radius.
    ("gravity", "fraction", "tolerance"),
    [((G, 0.0, 0.0), 0.02, 0.03), ((0.0, 0.0, -G), 0.3, 0.15), ((0.0, -G, 0.0), 0.6, 0.35)],
)
def test_a_heavy_coil_has_the_axis_that_fits_best(gravity, fraction, tolerance):
    wrap = wrap_of(gravity, fraction)
    placement = place_object(wrap)
    contact = wrap.object_radius + wrap.outer_radius
    assert np.abs(misses(wrap, placement.center)).max() < tolerance * contact
    found = least_squares(
        lambda shift: misses(wrap, placement.center + shift),
        np.zeros(3),
        **dict.fromkeys(("xtol", "ftol", "gtol"), 1e-15),
    )
    shift = np.cross(found.x, placement.axis)  # along the axis it does not matter
    # scipy stops when the cost no longer falls: its own error is about the root of rounding.
    assert norm(shift) < 1e-6 * contact


def test_an_axis_that_the_coil_does_not_take_leaves_a_gap():
    wraps = [paper_curve("70 degrees", axis=a).wrap_for_radius(0.02) for a in (None, (1.0, 0, 0))]
    fitted, along = map(place_object, wraps)
    assert along.largest_gap > 2.0 * fitted.largest_gap
    recorded("placement/axis", [fitted, along, along.largest_gap, *wraps])


def profile_wrap(positions, radii):
    """Return the paper's 70 degree design, hanging, about an object."""
    return wrap_for_profile(paper_curve("70 degrees"), ObjectProfile(positions, radii))


WAVE = np.linspace(0.0, 0.4, 81)
CONE = [0.0, 0.3], [0.030, 0.011]
PERFECT, CURLING = WrapRegime.PERFECT_WRAP, WrapRegime.CURLING


def test_the_thinnest_place_is_wrapped_perfectly_and_thicker_ones_past_that():
    curve = paper_curve("70 degrees")
    for positions, radii, regimes in [
        ([0.0, 0.5], [0.02, 0.02], {PERFECT}),
        # A steep cone with a cylinder at its thin end: the most even place is taken.
        ([0.0, 0.3, 0.45], [0.035, 0.015, 0.015], {PERFECT}),
        (*CONE, {PERFECT, CURLING}),
        # The paper's cylinder that varies between its two objects.
        (WAVE, 0.0205 + 0.0095 * np.cos(5.0 * pi * WAVE), {PERFECT, CURLING}),
    ]:
        wrap = profile_wrap(positions, radii)
        thin, thick = wrap.radius_min, wrap.radius_max
        assert min(radii) <= thin <= thick <= max(radii)
        pressures = wrap.pressure, wrap.pressure_of_mean, wrap.pressure_of_thickest
        wrapped = thin, 0.5 * (thin + thick), thick
        perfect = [curve.pressure_from_radius(radius) for radius in wrapped]
        assert_allclose(pressures, perfect, 1e-9)
        assert {station.regime for station in wrap.stations} == regimes
        assert min(wrap.stations, key=lambda station: station.radius).regime is PERFECT
        # The thickest place decides how much of the object the coil covers.
        needed = curve.wrap_for_radius(thick).object_length_needed
        assert_allclose(wrap.end - wrap.start, needed, 1e-9)


def test_the_two_ends_of_an_object_are_alike():
    here, there = (profile_wrap(CONE[0], CONE[1][::way]) for way in (1, -1))
    # Starts are tried at 101 places: the two windows differ by at most one step.
    ends = np.transpose([(wrap.radius_min, wrap.radius_max) for wrap in (here, there)])
    assert (abs(np.diff(ends).ravel()) < (0.019 / 100.0, 2 * 0.019 / 100.0)).all()


def test_what_cannot_be_wrapped_says_why():
    """The radius is not what forbids a grip where there is room for some of the object."""
    found = [
        said(profile_wrap, *given)
        for given in (
            ([0.0, 0.3], [0.0005, 0.0004]),
            ([0.0, 0.3], [0.08, 0.09]),
            ([0.0, 0.01, 0.02], [0.02] * 3),
            ([0.0, 0.1, 0.2], [0.09, 0.01, 0.09]),
        )
    ]
    recorded("placement/cone", [*found, profile_wrap(*CONE)])


def test_a_misplacement_is_what_the_object_was_moved_by():
    for axis in [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.3, -0.8, 0.5)]:
        for off in [(0.0, 0.0, 0.0, 0.0), (-0.01, 0.02, 0.4, -0.3)]:
            obstacle = Obstacle.along(Cylinder(0.015), (0.02, -0.03, 0.1), axis)
            setup = GripSetup(paper_curve("70 degrees").gripper, obstacle)
            there = setup.moved(np.array((0.0, *off)))
            for sense, way in ((1.0, 0.0), (1.0, -3.0), (-1.0, 0.5)):
                point = np.array(there.obstacle.position) + way * there.axis
                found = misplacement(point, sense * there.axis, obstacle.position, setup.frame)
                assert_allclose(found, off, 0, 1e-12)


def test_an_object_square_to_its_place_is_as_far_away_as_can_be_told():
    frame = np.eye(3)[[2, 0, 1]]
    found = misplacement((0.1, 0.0, 0.02), (1.0, 0.0, 0.0), (0.1, 0.0, 0.0), frame)
    assert 1e99 > norm(found[:2]) > 1e9
    assert_allclose(norm(found[2:]), 0.5 * pi)
