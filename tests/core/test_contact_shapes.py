# SPDX-License-Identifier: Apache-2.0
"""Every shape's gradient and Hessian are the derivatives of its distance; alike ones agree."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from spiral_core import Capsule, Cone, Cylinder, Obstacle, Plane, Profile, SignedDistance, Sphere
from spiral_core.rod.contact.obstacles import turns_about


def round_distance(points):
    """Return the distance from a cylinder about z, as a user would write it."""
    away = points * (1.0, 1.0, 0.0)
    rho = norm(away, axis=1)
    return rho - 0.03, away / rho[:, None]


RANDOM = np.random.default_rng(1)
POINTS = RANDOM.uniform(0.021, 0.04, (30, 3)) * RANDOM.choice((-1.0, 1.0), (30, 3))
UPRIGHT = Cylinder(0.03)
ROUND = SignedDistance(round_distance, 0.03)
WAVY = Profile((-0.05, -0.02, 0.01, 0.05), (0.02, 0.025, 0.018, 0.03))
TUBE = Cylinder(0.05, inside=True)


@pytest.mark.parametrize(
    "shape",
    [UPRIGHT, TUBE, Cone(0.02, 0.3), Sphere(0.02), Capsule(0.01, 0.03), Plane(), WAVY, ROUND],
)
def test_derivatives_are_those_of_the_distance(shape):
    _, normal, hessian = shape.distance(POINTS)
    assert_allclose(norm(normal, axis=1), 1.0, rtol=1e-9)
    for k, shift in enumerate(1e-6 * np.eye(3)):
        ahead, behind = (shape.distance(POINTS + sign * shift) for sign in (1.0, -1.0))
        rise, slope = ((up - down) / 2e-6 for up, down in zip(ahead[:2], behind[:2], strict=True))
        assert_allclose(normal[:, k], rise, atol=1e-8)
        assert_allclose(hessian[:, :, k], slope, atol=1e-4 * np.abs(slope).max() + 1e-6)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (UPRIGHT, Profile((-0.1, 0.0, 0.1), 3 * (0.03,))),
        (Cone(0.03, 0.2), Profile((-0.01, 0.01), (0.028, 0.032))),  # a cone beyond its ends
        (UPRIGHT, Cone(0.03, 0.0)),
        (UPRIGHT, Capsule(0.03, 2.0)),
        (Sphere(0.03), Capsule(0.03, 1e-12)),
        (UPRIGHT, ROUND),
        (Plane(), Sphere(1e5)),
    ],
)
def test_alike_shapes_are_as_far_away(one, other):
    lift = (0.0, 0.0, 1e5 * isinstance(one, Plane))
    # The Hessian of a user's shape is by differences.
    for this, that, within in zip(
        one.distance(POINTS), other.distance(POINTS + lift), (1e-7, 1e-6, 2e-5), strict=True
    ):
        assert_allclose(this, that, atol=within)


ANGLE = np.linspace(0.0, 4.5 * np.pi, 200)
HELIX = np.column_stack((0.02 * np.cos(ANGLE), 0.02 * np.sin(ANGLE), 0.01 * ANGLE - 0.03))


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
    shift = (0.3, -0.2, 0.1)
    for turn in map(Rotation.from_rotvec, ((0.0, 0.0, 0.0), (0.4, -1.1, 2.0), (math.pi, 0.0, 0.0))):
        there = Obstacle.along(shape, shift, turn.apply((0.0, 0.0, 1.0)))
        curve = turn.apply(HELIX) + shift
        assert turns_about(there, curve) == pytest.approx(turns, nan_ok=True)
        assert turns_about(there, curve[::-1]) == pytest.approx(-turns, nan_ok=True)
