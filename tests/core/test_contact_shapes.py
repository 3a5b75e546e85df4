# SPDX-License-Identifier: Apache-2.0
"""Every shape's gradient and Hessian are the derivatives of its distance; alike ones agree."""

import math
from dataclasses import replace

import numpy as np
import pytest
from core.contact_paths import ROUND, SPAN, round_distance

from spiral_core import (
    Capsule,
    Cone,
    Cylinder,
    Obstacle,
    Plane,
    Profile,
    RodLoad,
    RodProblem,
    SignedDistance,
    Sphere,
)
from spiral_core.rod.contact.shapes import Shape
from spiral_core.rod.contact.solve import solve_contact


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


WEIGHT = RodLoad((0.0, 0.02, -0.5))


def on(shape: Shape, friction: float = 0.0, axis: tuple[float, float, float] = (0.2, 1.0, 0.1)):
    """Return the rod that hangs over a shape whose axis lies across below it."""
    obstacle = Obstacle.along(shape, (0.2, 0.0, -0.07), axis, friction)
    return RodProblem(SPAN, WEIGHT, obstacles=(obstacle,))


ALIKE = {
    "profile, cylinder": (Profile((-0.1, 0.0, 0.1), 3 * (ROUND,)), Cylinder(ROUND)),
    "profile, cone": (Profile((-0.1, 0.1), (0.01, 0.05)), Cone(ROUND, 0.2)),
    "cone, cylinder": (Cone(ROUND, 0.0), Cylinder(ROUND)),
    "capsule, cylinder": (Capsule(ROUND, 2.0), Cylinder(ROUND)),
    "capsule, sphere": (Capsule(ROUND, 1e-12), Sphere(ROUND)),
    "signed distance, cylinder": (SignedDistance(round_distance, ROUND), Cylinder(ROUND)),
}


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("name", ALIKE)
def test_alike_shapes_hold_the_rod_alike(name: str, friction: float) -> None:
    smooth = (solve_contact(on(shape), elements=40) for shape in ALIKE[name])
    one, other = (
        # What falls off the smooth ball stays away from the rough one.
        solve_contact(replace(on(shape, friction), load=RodLoad((0.0, 0.02, -0.6))), start=state)
        for shape, state in zip(ALIKE[name], smooth, strict=True)
    )
    assert (one.contact_lengths[0] > 0.0) == (name != "capsule, sphere")
    # A user's shape has its Hessian by differences, so that the path takes other steps.
    np.testing.assert_allclose(one.positions, other.positions, atol=1e-6 * SPAN.length)
    largest = np.abs(other.contact_forces).max()
    np.testing.assert_allclose(one.contact_forces, other.contact_forces, atol=1e-4 * largest)


def test_large_sphere_is_a_plane() -> None:
    """Its height above the plane is x^2 / 2 ROUND: 8e-7 m at the tip."""
    far = 1e5
    sphere = RodProblem(SPAN, WEIGHT, obstacles=(Obstacle(Sphere(far), (0, 0, -0.05 - far)),))
    plane = RodProblem(SPAN, WEIGHT, obstacles=(Obstacle(Plane(), (0.0, 0.0, -0.05)),))
    one, other = (solve_contact(problem, elements=40) for problem in (sphere, plane))
    assert other.contact_lengths[0] > 0.02
    np.testing.assert_allclose(one.positions, other.positions, atol=2e-6)
