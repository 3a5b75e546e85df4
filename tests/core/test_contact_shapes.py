# SPDX-License-Identifier: Apache-2.0
"""Every shape's gradient and Hessian are the derivatives of its distance."""

import math

import numpy as np
import pytest

from spiral_core import (
    Capsule,
    Cone,
    Cylinder,
    InvalidInputError,
    Obstacle,
    Plane,
    Profile,
    SignedDistance,
    Sphere,
)


def _egg(points):
    away = np.linalg.norm(points, axis=1)
    return away - 0.02, points / away[:, None]


SHAPES = (
    Cylinder(0.02),
    Cylinder(0.05, inside=True),
    Cone(0.02, 0.3),
    Sphere(0.02),
    Capsule(0.01, 0.03),
    Plane(),
    Profile((-0.05, -0.02, 0.01, 0.05), (0.02, 0.025, 0.018, 0.03)),
    SignedDistance(_egg, 0.02),
)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_derivatives(shape):
    random = np.random.default_rng(1)
    angle, z = random.uniform(0, 2 * math.pi, 30), random.uniform(-0.04, 0.04, 30)
    radius = random.uniform(0.03, 0.04, 30)
    points = np.column_stack((radius * np.cos(angle), radius * np.sin(angle), z))
    _, normal, hessian = shape.distance(points)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, rtol=1e-9)
    step = 1e-6
    for k in range(3):
        shift = step * np.eye(3)[k]
        (up, rising, _), (down, falling, _) = (
            shape.distance(points + shift),
            shape.distance(points - shift),
        )
        # of the differences
        np.testing.assert_allclose(normal[:, k], (up - down) / (2.0 * step), atol=1e-8)
        slope = (rising - falling) / (2.0 * step)
        np.testing.assert_allclose(hessian[:, :, k], slope, atol=1e-4 * np.abs(slope).max() + 1e-6)


def test_an_obstacle_stands_along_its_axis():
    for axis in ((0.0, 0.0, -1.0), (1.0, 2.0, -0.5), (0.0, 0.0, 3.0)):
        obstacle = Obstacle.along(Plane(), (0.0, 0.0, 0.0), axis)
        x, y, z, w = obstacle.orientation
        third = (2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y))
        np.testing.assert_allclose(third, np.array(axis) / np.linalg.norm(axis), atol=1e-12)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Cylinder(-1.0),
        lambda: Cylinder(math.nan),
        lambda: Profile((0.0, 0.0), (1.0, 1.0)),
        lambda: Profile((0.0, 1.0), (1.0,)),
        lambda: Obstacle(Plane(), friction=-0.1),
        lambda: Obstacle(Plane(), friction=math.nan),
        lambda: Obstacle.along(Plane(), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        lambda: Obstacle(Plane(), orientation=(0.0, 0.0, 0.0, 2.0)),
    ],
)
def test_bad_values_are_refused(make):
    with pytest.raises(InvalidInputError):
        make()


def test_a_profile_builds_its_spline_once(monkeypatch):
    import scipy.interpolate

    built = []
    spline = scipy.interpolate.CubicSpline
    monkeypatch.setattr(
        scipy.interpolate,
        "CubicSpline",
        lambda *args, **kw: built.append(args) or spline(*args, **kw),
    )
    shape = Profile([0.0, 0.0123, 0.031], [0.02, 0.0217, 0.019])
    for _ in range(3):
        shape.distance(np.array([[0.03, 0.0, 0.01]]))
    assert len(built) == 1
