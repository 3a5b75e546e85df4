# SPDX-License-Identifier: Apache-2.0
"""Region of capture: how far off an object may be for closing to end wrapped and holding."""

from __future__ import annotations

import math
from concurrent.futures import Executor, Future
from functools import cache

import numpy as np
import pytest
from core.gripper_cases import linear_gripper, paper_gripper
from numpy.linalg import norm

from spiral_core import Cylinder, GripSetup, Obstacle, Pull, lay_into_coil
from spiral_core.grip.capture import (
    CaptureOutcome,
    capture_region,
    close_misplaced,
)

pytestmark = pytest.mark.long

PRESSURE, PAYLOAD = 58.98e3, 0.010
NOWHERE = (0.0,) * 5
DEGREE = math.radians(1.0)


@cache
def hanging():
    """Return the paper's gripper on a cylinder of 20 mm."""
    return lay_into_coil(paper_gripper("70 degrees"), 0.020)


class Rule(Executor):
    """Answers by a rule what closing on a misplaced object ends in."""

    def __init__(self, rule):
        """Take the rule."""
        self.rule, self.asked = rule, 0

    def submit(self, _, /, *places, **__):
        """Answer at once."""
        self.asked += 1
        future: Future[CaptureOutcome] = Future()
        future.set_result(self.rule(np.array(places[0])))
        return future


SEMI_AXES = (0.011, 0.006, 12.3 * DEGREE, 7.7 * DEGREE, 0.0023)


def inside(order):
    """Return the rule of an ellipsoid (order 2), or of a region with corners on the axes (1)."""

    def rule(place):
        held = norm(place / np.array(SEMI_AXES), order) <= 1.0
        return CaptureOutcome.HOLDS if held else CaptureOutcome.PASSES_BY

    return rule


@cache
def ellipsoidal():
    """Return the region of an ellipsoid."""
    return capture_region(hanging(), PRESSURE, PAYLOAD, executor=Rule(inside(2)))


def test_limits_and_outlines_of_an_ellipsoid_are_its_own():
    """Each is the last misplacement that holds, within the resolution."""
    region = ellipsoidal()
    coarse = np.array((2e-4, 2e-4, 0.5 * DEGREE, 0.5 * DEGREE, 2e-4))
    for low, high, semi, error in zip(*region.limits.T, SEMI_AXES, coarse, strict=True):
        assert semi - error <= high <= semi
        assert -semi <= low <= error - semi
    for boundaries in (region.shifts, region.tilts):
        assert len(boundaries) >= 16
        for boundary, place in zip(boundaries, region.outline(boundaries), strict=True):
            way = np.array(boundary.direction) * region.reach
            exact = way / norm(way / SEMI_AXES)
            assert np.all(np.abs(place) <= np.abs(exact) + 1e-12)
            assert np.all(np.abs(place - exact) <= coarse)
            assert boundary.beyond is CaptureOutcome.PASSES_BY
    assert 0.93 < region.ball <= 1.0
    assert region.closings < 400


def test_margin_is_the_way_left_to_the_ellipsoid():
    """Along each axis and between them."""
    region = ellipsoidal()
    assert region.margin(NOWHERE) == 1.0
    for part in (0.25, 0.5, 1.5):
        for way in (*np.eye(5), -np.sqrt(0.2) * np.ones(5)):
            margin = region.margin(part * np.array(SEMI_AXES) * way)
            assert margin == pytest.approx(1.0 - part, abs=0.07 * part)
            assert margin <= 1.0 - part


def test_the_first_boundary_counts_and_a_component_may_have_no_room():
    """Held again beyond a strip that is not; with no error of the radius at all."""

    def rule(place):
        strip = 0.004 < place[0] < 0.009
        return CaptureOutcome.TOO_WEAK if strip or place[4] else CaptureOutcome.HOLDS

    region = capture_region(hanging(), PRESSURE, executor=Rule(rule))
    assert 0.0038 <= region.limits[0, 1] <= 0.004
    assert region.limits[0, 0] == -region.reach[0]
    assert region.axes[0][0].beyond is CaptureOutcome.HOLDS
    assert region.axes[0][1].beyond is region.ball_beyond is CaptureOutcome.TOO_WEAK
    assert region.limits[4].tolist() == [0.0, 0.0]
    assert region.margin((0.0, 0.0, 0.0, 0.0, 1e-6)) < 0.0


def test_the_ellipsoid_lies_within_both_outlines():
    """A notch between the directions in which the ellipsoid is closed on directly."""

    def rule(place):
        notch = 0.3 < place[3] / max(place[2], 1e-9) < 0.5 and place[2] > 5.0 * DEGREE
        return CaptureOutcome.TOO_WEAK if notch else CaptureOutcome.HOLDS

    region = capture_region(hanging(), PRESSURE, executor=Rule(rule))
    places = region.outline([each for each in region.tilts if each.beyond is not region.center])
    assert len(places) > 0
    assert max(region.margin(place) for place in places) <= 1e-12
    assert region.ball_beyond is CaptureOutcome.TOO_WEAK


def test_known_outcomes_are_not_asked_again():
    """What is kept of one search is all that the next one needs."""
    kept, seen, first, again = {}, [], Rule(inside(1)), Rule(inside(1))
    progress = lambda *step: seen.append(step)  # noqa: E731
    one = capture_region(
        hanging(), PRESSURE, executor=first, keep=kept.__setitem__, progress=progress
    )
    assert first.asked == one.closings == len(kept) == len(seen)
    assert all(done <= total for done, total in seen)
    assert one.ball < 0.5  # the ellipsoid was looked for several times
    other = capture_region(hanging(), PRESSURE, executor=again, known=kept)
    assert again.asked == 0
    assert (other.limits == one.limits).all()
    assert other.ball == one.ball


def test_real_outcomes():
    """The hanging gripper in its place, too heavy an object, one in its way, one passed by."""
    expected = {
        NOWHERE: CaptureOutcome.HOLDS,
        (0.0, 0.0, -16 * DEGREE, 0.0, 0.0): CaptureOutcome.PASSES_BY,
        (0.0, 0.0, 0.0, 0.0, -0.003): CaptureOutcome.PASSES_BY,
        (0.010, -0.010, 0.0, 0.0, 0.001): CaptureOutcome.HOLDS,
    }
    for off, outcome in expected.items():
        assert close_misplaced(hanging(), PRESSURE, off, PAYLOAD).outcome is outcome, off
    away = np.asarray(hanging().obstacle.position) @ hanging().frame[1]
    over = 0.020 + 0.8 * hanging().gripper.tube.outer_radius - away  # by a fifth of that radius
    for elements in (45, 90, 180):
        found = close_misplaced(hanging(), PRESSURE, (over, *NOWHERE[1:]), PAYLOAD, elements)
        assert found.outcome is CaptureOutcome.IN_THE_WAY
    once = close_misplaced(hanging(), PRESSURE, NOWHERE, 1.5 * PAYLOAD)  # not twice over
    assert once.outcome is CaptureOutcome.HOLDS
    heavy = close_misplaced(hanging(), PRESSURE, NOWHERE, 3.0 * PAYLOAD)
    assert heavy.outcome is CaptureOutcome.TOO_WEAK
    assert heavy.held is not None
    assert heavy.held.pull is Pull.DOWN
    assert 1.0 < heavy.held.force / (PAYLOAD * 9.80665) < 3.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("gravity", "object_axis"),
    [
        ((9.80665, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((-9.80665, 0.0, 0.0), None),
        ((0.0, 0.0, 0.0), None),
        ((0.0, 0.0, 9.80665), (0.0, 0.0, 1.0)),
    ],
    ids=["object along gravity", "upright", "no weight", "object along gravity and across"],
)
def test_outcomes_do_not_depend_on_the_elements(gravity, object_axis):
    """Also in mounts that are symmetric or have no weight at all."""
    gripper = paper_gripper("70 degrees", gravity, object_axis)
    setup = lay_into_coil(gripper, 0.020)
    for off in (NOWHERE, (0.004, 0.004, 0.0, 0.0, 0.001), (0.0, 0.0, 0.0, 0.0, -0.004)):
        coarse, fine = (
            close_misplaced(setup, PRESSURE, off, elements=count).outcome for count in (60, 180)
        )
        assert coarse is fine
        assert coarse is not CaptureOutcome.NOT_ANSWERED


def test_a_mirrored_misplacement_ends_in_the_mirrored_grip():
    """A planar gripper without weight, and a cylinder across its plane."""
    gripper = linear_gripper(torsion=0.0, length=0.14)
    obstacle = Obstacle.along(Cylinder(0.020), (0.03, 0.0255, 0.0), (0.0, 0.0, 1.0), 0.3)
    setup = GripSetup(gripper, obstacle)
    ends = setup.frame @ np.eye(3)[2]
    assert abs(ends[0]) == 1.0
    for off in (
        NOWHERE,
        (0.002, 0.0, 8.0 * DEGREE, 0.0, 0.0),
        (0.0, 0.001, 0.0, 9.0 * DEGREE, 0.0),
    ):
        mirrored = np.array(off) * (1, 1, -1, -1, 1)
        one, other = (close_misplaced(setup, 90e3, each) for each in (off, mirrored))
        assert one.outcome is other.outcome is CaptureOutcome.HOLDS
        assert one.point.contact_length == pytest.approx(other.point.contact_length, rel=1e-6)


def test_an_object_that_is_not_held_in_its_place_has_no_region():
    """The center's outcome is the answer, after a single closing."""
    region = capture_region(hanging(), 40e3, PAYLOAD)
    assert region.center is CaptureOutcome.PASSES_BY
    assert region.closings == 1
    assert not region.limits.any()
    assert region.margin(NOWHERE) == -math.inf
