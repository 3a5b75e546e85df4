# SPDX-License-Identifier: Apache-2.0
"""Every shape's gradient and Hessian are the derivatives of its distance; alike ones agree."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from spiral_core import Capsule, Cone, Cylinder, Obstacle, Plane, Profile, SignedDistance, Sphere
from spiral_core.rod.contact._contact import distances
from spiral_core.rod.contact.obstacles import turns_about


def round_distance(points):
    """Return the distance from a cylinder about z, as a user would write it."""
    away = points * (1.0, 1.0, 0.0)
    rho = norm(away, axis=1, keepdims=True)
    return rho[:, 0] - 0.03, away / rho


POINTS = np.random.default_rng(1).choice((-0.036, -0.022, 0.025, 0.04), (30, 3))
UPRIGHT = Cylinder(0.03)
WAVY = Profile(np.array((-0.05, -0.02, 0.01, 0.05)), [0.02, 0.025, 0.018, 0.03])
SHOULDER = Profile((0.013, 0.023, 0.033, 0.043), (0.02, 0.02, 0.04, 0.04))
TUBE = Cylinder(0.05, inside=True)


@pytest.mark.parametrize(
    "shape",
    [
        UPRIGHT,
        TUBE,
        Cone(0.02, 0.3),
        Sphere(0.02),
        Capsule(0.01, 0.03),
        Plane(),
        WAVY,
        SHOULDER,
        SignedDistance(round_distance, 0.03),
    ],
)
def test_derivatives_are_those_of_the_distance(shape):
    """And a distance changes by no more than a point moves; a shape is a value."""
    gap, normal, hessian = shape.distance(POINTS)
    apart = norm(POINTS[:, None] - POINTS, axis=2)
    assert np.all(np.abs(gap[:, None] - gap) <= apart + 1e-9)
    assert hash(shape)
    assert_allclose(norm(normal, axis=1), 1.0, rtol=1e-9)
    for k, shift in enumerate(1e-6 * np.eye(3)):
        (up, ahead, _), (down, behind, _) = map(shape.distance, (POINTS + shift, POINTS - shift))
        assert_allclose(normal[:, k], (up - down) / 2e-6, atol=1e-8)
        slope = (ahead - behind) / 2e-6
        assert_allclose(hessian[:, :, k], slope, atol=1e-4 * np.abs(slope).max() + 1e-6)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (UPRIGHT, Profile((-0.1, 0.0, 0.1), 3 * (0.03,))),
        (Cone(0.03, 0.2), Profile((-0.01, 0.01), (0.028, 0.032))),  # a cone beyond its ends
        (UPRIGHT, Capsule(0.03, 2.0)),
        (Sphere(0.03), Capsule(0.03, 1e-12)),
    ],
)
def test_alike_shapes_are_as_far_away(one, other):
    for this, that in zip(one.distance(POINTS), other.distance(POINTS), strict=True):
        assert_allclose(this, that, atol=1e-7)


class Floor:
    """A plane whose user writes whole numbers."""

    feature_radius = math.inf

    def distance(self, points):
        normal = np.tile((0, 0, 1), (len(points), 1))
        return points[:, 2], normal, np.zeros((len(points), 3, 3), dtype=int)


def test_whole_numbers_are_turned_as_others_are():
    seen = [
        distances(Obstacle.along(shape, (0.0, 0.0, 0.01), (0.3, 0.2, 0.9)), POINTS, 0.002)
        for shape in (Floor(), Plane())
    ]
    for this, that in zip(*seen, strict=True):
        assert_allclose(this, that, atol=1e-15)
    whole = np.array([[1, 2, 3]])
    assert_allclose(UPRIGHT.distance(whole)[1], UPRIGHT.distance(1.0 * whole)[1])


@pytest.mark.parametrize(
    ("shape", "turns"),
    [
        (Cylinder(0.01), 2.25),
        (Capsule(0.01, 0.05), 5.0 / math.tau),
        (Cone(0.01, -0.2), 8.0 / math.tau),  # its apex at 50 mm
        (Cone(0.01, 0.5), 2.25 - 1.0 / math.tau),  # at -20 mm
        (Profile((-0.01, 0.01), (0.012, 0.008)), 8.0 / math.tau),
        (Plane(), math.nan),
        (TUBE, math.nan),
    ],
)
def test_turns_are_those_of_a_helix_about_the_axis(shape, turns):
    """Two and a quarter, right-handed; beyond the ends of the solid nothing counts."""
    angle = np.linspace(0.0, 4.5 * np.pi, 200)
    helix = np.column_stack((0.02 * np.cos(angle), 0.02 * np.sin(angle), 0.01 * angle - 0.03))
    shift = (0.3, -0.2, 0.1)
    for turn in map(Rotation.from_rotvec, ((0.4, -1.1, 2.0), (math.pi, 0.0, 0.0))):
        there = Obstacle.along(shape, shift, turn.apply((0.0, 0.0, 1.0)))
        rounded = replace(there, orientation=tuple(1.0000009 * np.array(there.orientation)))
        assert rounded.orientation == pytest.approx(there.orientation, rel=1e-12)
        found = turns_about(there, turn.apply(helix) + shift)
        assert found == pytest.approx(turns, nan_ok=True)
