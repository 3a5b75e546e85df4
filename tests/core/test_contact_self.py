# SPDX-License-Identifier: Apache-2.0
"""Where a rod touches itself: distances between elements, at rest and on the way."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from spiral_core.rod.contact._results import crossing_places, nearest_places, self_clearance

pytestmark = pytest.mark.long

Array = NDArray[np.float64]
RADIUS = 0.01


def lengths(curve: Array) -> Array:
    """Return the arc lengths of a polygon's nodes."""
    steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    return np.append(0.0, np.cumsum(steps))


@pytest.mark.parametrize("elements", [24, 60, 121])
def test_least_distance_is_that_of_all_places_on_elements_apart(elements: int) -> None:
    """Against all pairs of 21 points on each element, on rough coils; elements of 0.8 to 4 radii.

    Points miss the nearest place by at most half of their distance h / 20 on both: its square
    adds at most h^2 / 800 to that of the least distance.
    """
    rng = np.random.default_rng(elements)
    touching = 0
    for turns in (0.3, 2.0, *np.linspace(3.0, 5.0, 12)):
        angle = 2.0 * np.pi * turns * np.linspace(0.0, 1.0, elements + 1)
        curve = 0.05 * np.column_stack((np.cos(angle), np.sin(angle), 0.08 * angle))
        curve += rng.normal(scale=5e-4, size=curve.shape)
        sites = lengths(curve)
        points = (
            curve[:-1, None] + np.linspace(0.0, 1.0, 21)[:, None] * np.diff(curve, axis=0)[:, None]
        )
        nodes = np.linalg.norm(curve[:, None] - curve[None], axis=2)
        expected = nodes[np.abs(sites[:, None] - sites) > np.pi * RADIUS].min()
        for i in range(elements):
            apart = np.nonzero(sites[:-1] - sites[i + 1] > np.pi * RADIUS)[0]
            if apart.size:
                away = np.linalg.norm(points[i][:, None, None] - points[apart], axis=-1)
                expected = min(expected, float(away.min()))
        found, first, second = nearest_places(curve, sites, RADIUS)
        assert found <= expected
        missed = np.diff(sites).max() ** 2 / 800.0
        assert found >= min(math.sqrt(max(0.0, expected**2 - missed)), 4.0 * RADIUS)
        if found < 4.0 * RADIUS:
            touching += 1
            assert second > first
            a, b = (
                np.array([np.interp(s, sites, curve[:, c]) for c in range(3)])
                for s in (first, second)
            )
            assert np.linalg.norm(a - b) == pytest.approx(found, abs=1e-12)
    assert touching > 5
    assert self_clearance(curve, sites, 0.0) == math.inf


@pytest.mark.parametrize("leg", [3.0, 10.0, 40.0])
@pytest.mark.parametrize("gap", [0.0, 0.5, 1.9, 2.1])
def test_legs_that_cross_between_their_nodes_touch(leg: float, gap: float) -> None:
    """A loop of six elements whose first and last cross in their middles, all nodes far away."""
    h = leg * RADIUS
    curve = h * np.array([(-0.5, 0, 0), (0.5, 0, 0), (1, 0.9, 0), (0.6, 1.7, 0), (0, 1.3, 0),
                          (0, 0.5, 0), (0, -0.5, 0)])  # fmt: skip
    curve[5:, 2] = gap * RADIUS
    nodes = np.linalg.norm(curve[:2, None] - curve[5:], axis=2)
    assert nodes.min() > 2.0 * RADIUS
    distance, first, second = nearest_places(curve, lengths(curve), RADIUS)
    assert distance == pytest.approx(gap * RADIUS, abs=1e-15)
    sites = lengths(curve)
    assert (first, second) == pytest.approx((0.5 * h, 0.5 * (sites[5] + sites[6])))
    assert self_clearance(curve, sites, RADIUS) == pytest.approx((gap - 2.0) * RADIUS, abs=1e-15)


@pytest.mark.parametrize("shift", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("h", [0.5, 1.0, 3.0, 7.0])
def test_parallel_legs_are_as_far_apart_as_they_are(h: float, shift: float) -> None:
    """A hairpin of legs at two radii, its nodes opposite each other or shifted along."""
    length, gap = h * RADIUS, 2.0 * RADIUS
    out = np.arange(12)[:, None] * np.array((length, 0.0, 0.0))
    bend = out[-1] + np.array([(3.0 * RADIUS, -RADIUS, 0.0), (3.0 * RADIUS, 3.0 * RADIUS, 0.0)])
    back = out[::-1] + np.array((shift * length, gap, 0.0))
    curve = np.vstack((out, bend, back))
    assert self_clearance(curve, lengths(curve), RADIUS) == pytest.approx(0.0, abs=1e-15)
    curve[14:, 1] += 0.1 * RADIUS
    clear = self_clearance(curve, lengths(curve), RADIUS)
    assert clear == pytest.approx(0.1 * RADIUS, abs=1e-15)


@pytest.mark.parametrize("h", [0.05, 0.5, 1.0, 1.6, 2.5, 5.0, 40.0])
@pytest.mark.parametrize("bend", [0.0, 0.2])
def test_neighbors_do_not_touch(h: float, bend: float) -> None:
    """Straight, and in an arc of at least two radii: elements that share a node, and the next."""
    angle = min(bend, h / 2.0) * np.arange(41)
    steps = h * RADIUS * np.column_stack((np.cos(angle), np.sin(angle), 0.3 * np.ones(41)))
    curve = np.cumsum(steps, axis=0)[:12]
    assert self_clearance(curve, lengths(curve), RADIUS) > 0.0


def test_short_rod_cannot_touch_itself() -> None:
    """Below pi radii; above, what is far counts as two radii."""
    for length, clearance in ((3.1, math.inf), (3.2, 1.2 * RADIUS), (60.0, 2.0 * RADIUS)):
        curve = np.linspace((0.0, 0.0, 0.0), (length * RADIUS, 0.0, 0.0), 31)
        assert self_clearance(curve, lengths(curve), RADIUS) == pytest.approx(clearance)


def knot(elements: int) -> Array:
    """Return an open trefoil that comes near itself at three places."""
    t = np.linspace(0.2, 2.0 * np.pi + 0.1, elements + 1)
    return 0.045 * np.column_stack(
        (np.sin(t) + 2.0 * np.sin(2.0 * t), np.cos(t) - 2.0 * np.cos(2.0 * t), -0.4 * np.sin(3 * t))
    )


@pytest.mark.parametrize("elements", [13, 40, 160])
def test_distance_is_of_the_shape_not_of_its_pose_or_direction(elements: int) -> None:
    curve = knot(elements)
    sites = lengths(curve)
    distance, first, second = nearest_places(curve, sites, RADIUS)
    assert RADIUS < distance < 4.0 * RADIUS
    turn = Rotation.from_rotvec((0.3, -1.0, 2.0))
    mirror = np.diag((1.0, -1.0, 1.0))
    for image in (turn.apply(curve) + np.array((1.0, 2.0, -3.0)), curve @ mirror):
        assert nearest_places(image, sites, RADIUS)[0] == pytest.approx(distance, abs=1e-14)
    backwards = np.ascontiguousarray(curve[::-1])
    found = nearest_places(backwards, lengths(backwards), RADIUS)
    assert found[0] == pytest.approx(distance, abs=1e-14)
    ends = sorted((first, second)), sorted(sites[-1] - s for s in found[1:])
    if elements == 160:  # a place that is nearest among three alike may be another one
        assert ends[0] == pytest.approx(ends[1], abs=1e-9)


def two_arms(height: float, elements: int) -> Array:
    """Return a rod that comes back across itself, the far leg at a height."""
    corner = np.array([(-0.2, 0.013, 0), (0.2, 0.013, 0), (0.3, 0.2, 0), (0.2, 0.4, 0),
                       (0.011, 0.4, 0), (0.011, 0.2, height), (0.011, -0.2, height)])  # fmt: skip
    at = np.linspace(0.0, 6.0, 6 * elements + 1)
    return np.column_stack([np.interp(at, np.arange(7), corner[:, c]) for c in range(3)])


@pytest.mark.parametrize("elements", [1, 3, 20])
def test_crossing_is_seen_on_the_way(elements: int) -> None:
    """Clear at both ends of a move, by as much as one likes; thin rods, too."""
    above, below = two_arms(0.05, elements), two_arms(-0.08, elements)
    sites = lengths(above)
    for radius in (RADIUS, 1e-3, 1e-5):
        for first, last in ((above, below), (below, above)):
            assert self_clearance(last, sites, radius) > 0.0
            places = crossing_places(first, last, sites, radius)
            assert places[0] == pytest.approx(0.211, abs=max(radius, 1e-9) * 1.5)
            assert places[1] > 0.8
        assert np.isnan(crossing_places(above, two_arms(0.03, elements), sites, radius)[0])
        carried = above - np.array((0.0, 0.0, 0.3))
        assert np.isnan(crossing_places(above, carried, sites, radius)[0])
    lowered = two_arms(0.0, elements)  # where it lies at the end counts as touching, not as passed
    assert nearest_places(lowered, sites, RADIUS)[0] == pytest.approx(0.0, abs=1e-15)


def test_coil_that_turns_as_a_whole_does_not_cross_itself() -> None:
    """Nodes move straight, which brings turns that nearly touch nearer by a tenth."""
    angle = np.linspace(0.0, 8.0 * np.pi, 161)
    curve = np.column_stack(
        (0.04 * np.cos(angle), 0.04 * np.sin(angle), 2.02 * RADIUS * angle / (2.0 * np.pi))
    )
    sites = lengths(curve)
    assert 0.0 < self_clearance(curve, sites, RADIUS) < 0.05 * RADIUS
    for axis in np.eye(3):
        turned = Rotation.from_rotvec(0.9 * axis).apply(curve)
        assert np.isnan(crossing_places(curve, turned, sites, RADIUS)[0])
