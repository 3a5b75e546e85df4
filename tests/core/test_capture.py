# SPDX-License-Identifier: Apache-2.0
"""Region of capture: how far off an object may be for closing to end wrapped and holding."""

from __future__ import annotations

from concurrent.futures import Future
from functools import cache
from math import inf, radians
from unittest.mock import Mock

import numpy as np
import pytest
from core.gripper_cases import linear_gripper, paper_gripper
from core.recorded import recorded
from numpy import array, eye, ones, sqrt
from numpy.linalg import norm
from numpy.testing import assert_allclose

from spiral_core import Cylinder, GripSetup, Obstacle, Pull, lay_into_coil
from spiral_core.grip.capture import (
    BALL_STEPS,
    CaptureOutcome,
    capture_region,
    close_misplaced,
)

pytestmark = pytest.mark.long

PRESSURE, PAYLOAD = 58.98e3, 0.010
NOWHERE = (0.0,) * 5
DEGREE = radians(1.0)


@cache
def hanging():
    """Return the paper's gripper on a cylinder of 20 mm."""
    return lay_into_coil(paper_gripper("70 degrees"), 0.020)


def region_of(rule, **options):
    """Return the region of a rule: what closing on a misplaced object ends in."""

    def submit(_, place):
        job = Future()
        job.set_result(rule(array(place)))
        return job

    return capture_region(hanging(), PRESSURE, executor=Mock(submit=submit), **options)


SEMI_AXES = (0.011, 0.006, 12.3 * DEGREE, 7.7 * DEGREE, 0.0023)


def inside(order):
    """Return the rule of an ellipsoid (order 2), or of a region with corners on the axes (1)."""

    def rule(place):
        held = norm(place / array(SEMI_AXES), order) <= 1.0
        return CaptureOutcome.HOLDS if held else CaptureOutcome.PASSES_BY

    return rule


def test_limits_outlines_and_margins_of_an_ellipsoid_are_its_own():
    """Each is the last misplacement that holds, within the resolution."""
    region = region_of(inside(2))
    coarse = array((2e-4, 2e-4, 0.5 * DEGREE, 0.5 * DEGREE, 2e-4))
    short = SEMI_AXES - np.abs(region.limits.T)
    assert (short >= 0.0).all()
    assert (short <= coarse).all()
    for boundaries in (region.shifts, region.tilts):
        assert len(boundaries) >= 16
        for boundary, place in zip(boundaries, region.outline(boundaries), strict=True):
            way = array(boundary.direction) * region.reach
            exact = way / norm(way / SEMI_AXES)
            assert np.all(np.abs(place) <= np.abs(exact) + 1e-12)
            assert np.all(np.abs(place - exact) <= coarse)
            assert boundary.beyond is CaptureOutcome.PASSES_BY
    assert 0.93 < region.ball <= 1.0
    assert region_of(inside(inf)).ball_beyond is CaptureOutcome.PASSES_BY
    assert region.closings < 400
    assert region.margin(NOWHERE) == 1.0
    # Along each axis and between them.
    for part in (0.25, 0.5, 1.5):
        for way in (*eye(5), -sqrt(0.2) * ones(5)):
            margin = region.margin(part * array(SEMI_AXES) * way)
            assert 1.0 - 1.07 * part <= margin <= 1.0 - part


def strip(place):
    """Hold again beyond a strip that is not held; with no error of the radius at all."""
    off = 0.004 < place[0] < 0.009 or place[4]
    return CaptureOutcome.TOO_WEAK if off else CaptureOutcome.HOLDS


def notch(place):
    """Hold but between the directions in which the ellipsoid is closed on directly."""
    off = 0.3 < place[3] / max(place[2], 1e-9) < 0.5 and place[2] > 5.0 * DEGREE
    return CaptureOutcome.TOO_WEAK if off else CaptureOutcome.HOLDS


def everywhere(_):
    return CaptureOutcome.HOLDS


@pytest.mark.parametrize("rule", [strip, notch, everywhere, inside(1)])
def test_the_first_boundary_counts_and_the_ellipsoid_lies_within_both_outlines(rule):
    """And what is kept of one search is all that the next one needs."""
    kept, seen = {}, []
    progress = lambda *step: seen.append(step)  # noqa: E731
    region = region_of(rule, keep=kept.__setitem__, progress=progress)
    outlines = [region.outline(each) for each in (region.shifts, region.tilts)]
    found = [[*region.limits], region.semi_axes, region.closings, region.ball_beyond, outlines]
    recorded(f"capture/{rule.__name__}", found)
    places = region.outline([each for each in region.tilts if each.beyond is not region.center])
    assert max((region.margin(place) for place in places), default=0.0) <= 1e-12
    assert region.closings == len(kept) == len(seen)
    assert all(done <= total for done, total in seen)
    again = region_of(None, known=kept)
    assert ((again.limits == region.limits).all(), again.ball) == (True, region.ball)
    rough = region_of(rule, outlines=False)
    assert (rough.limits == region.limits).all()
    assert rough.ball > region.ball - 1.0 / BALL_STEPS  # a notch between directions is not seen
    assert [*map(len, (rough.shifts, rough.tilts))] == [8, 8]
    assert set(rough.shifts + rough.tilts) <= set(region.shifts + region.tilts)
    assert rough.closings < region.closings


def ending(off=NOWHERE, payload=PAYLOAD, **options):
    """Return what closing on a misplaced object ends in."""
    return close_misplaced(hanging(), PRESSURE, off, payload, **options).outcome.name


def test_real_outcomes():
    """The hanging gripper in its place, too heavy an object, one in its way, one passed by."""
    assert ending() == ending((0.010, -0.010, 0.0, 0.0, 0.001)) == "HOLDS"
    assert ending((0.0, 0.0, -16 * DEGREE, 0.0, 0.0)) == "PASSES_BY"
    assert ending((0.0, 0.0, 0.0, 0.0, -0.003)) == "PASSES_BY"
    away = hanging().frame[1] @ hanging().obstacle.position
    over = 0.020 + 0.8 * hanging().gripper.tube.outer_radius - away  # by a fifth of that radius
    for elements in (45, 90, 180):
        assert ending((over, *NOWHERE[1:]), elements=elements) == "IN_THE_WAY"
    assert ending(payload=1.5 * PAYLOAD) == "HOLDS"  # not twice over
    heavy = close_misplaced(hanging(), PRESSURE, NOWHERE, 3.0 * PAYLOAD)
    assert (heavy.outcome, heavy.held.pull) == (CaptureOutcome.TOO_WEAK, Pull.DOWN)
    assert 1.0 < heavy.held.force / (PAYLOAD * 9.80665) < 3.0


@pytest.mark.slow
def test_outcomes_do_not_depend_on_the_elements():
    """Also in mounts that are symmetric or have no weight at all."""
    for gravity, object_axis in [
        ((9.80665, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((-9.80665, 0.0, 0.0), None),
        ((0.0, 0.0, 0.0), None),
        ((0.0, 0.0, 9.80665), (0.0, 0.0, 1.0)),
    ]:
        setup = lay_into_coil(paper_gripper("70 degrees", gravity, object_axis), 0.020)
        for off in (NOWHERE, (0.004, 0.004, 0.0, 0.0, 0.001), (0.0, 0.0, 0.0, 0.0, -0.004)):
            coarse, fine = (
                close_misplaced(setup, PRESSURE, off, elements=count).outcome for count in (60, 180)
            )
            assert coarse is fine is not CaptureOutcome.NOT_ANSWERED


def test_a_mirrored_misplacement_ends_in_the_mirrored_grip():
    """A planar gripper without weight, and a cylinder across its plane."""
    for off in [
        NOWHERE,
        (0.002, 0.0, 8.0 * DEGREE, 0.0, 0.0),
        (0.0, 0.001, 0.0, 9.0 * DEGREE, 0.0),
    ]:
        obstacle = Obstacle.along(Cylinder(0.020), (0.03, 0.0255, 0.0), (0.0, 0.0, 1.0), 0.3)
        setup = GripSetup(linear_gripper(torsion=0.0, length=0.14), obstacle)
        assert abs(setup.frame[0, 2]) == 1.0
        one, other = (
            close_misplaced(setup, 90e3, array(off) * (1, 1, side, side, 1)) for side in (1, -1)
        )
        assert one.outcome is other.outcome is CaptureOutcome.HOLDS
        assert_allclose(one.point.contact_length, other.point.contact_length, 1e-6)


def test_an_object_that_is_not_held_in_its_place_has_no_region():
    """The center's outcome is the answer, after a single closing."""
    region = capture_region(hanging(), 40e3, PAYLOAD)
    assert (region.center, region.closings) == (CaptureOutcome.PASSES_BY, 1)
    assert not region.limits.any()
    assert region.margin(NOWHERE) == -inf
