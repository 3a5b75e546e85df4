# SPDX-License-Identifier: Apache-2.0
"""Every shape as an obstacle: alike ones agree, forces do the work, nothing passes through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from spiral_core import (
    Capsule,
    Clamped,
    Cone,
    Cylinder,
    Obstacle,
    Pinned,
    Plane,
    Profile,
    Rod,
    RodLoad,
    RodProblem,
    Section,
    SignedDistance,
    Sphere,
)
from spiral_core.rod.contact.shapes import Shape
from spiral_core.rod.contact.solve import follow_contact, solve_contact

Array = NDArray[np.float64]
LENGTH, BENDING, RADIUS = 0.4, 2.7e-4, 3e-3
ROD = Rod(LENGTH, Section((1.7e-4, BENDING, BENDING)), RADIUS)
WEIGHT = RodLoad((0.0, 0.02, -0.5))
R = 0.03


def round_distance(points: Array) -> tuple[Array, Array]:
    """Return the distance from a cylinder about z, as a user would write it."""
    away = points * (1.0, 1.0, 0.0)
    rho = np.linalg.norm(away, axis=1)
    return rho - R, away / rho[:, None]


def on(shape: Shape, friction: float = 0.0, axis: tuple[float, float, float] = (0.2, 1.0, 0.1)):
    """Return the rod that hangs over a shape whose axis lies across below it."""
    obstacle = Obstacle.along(shape, (0.2, 0.0, -0.07), axis, friction)
    return RodProblem(ROD, WEIGHT, obstacles=(obstacle,))


ALIKE = {
    "profile, cylinder": (Profile((-0.1, 0.0, 0.1), (R, R, R)), Cylinder(R)),
    "profile, cone": (Profile((-0.1, 0.1), (R - 0.02, R + 0.02)), Cone(R, 0.2)),
    "cone, cylinder": (Cone(R, 0.0), Cylinder(R)),
    "capsule, cylinder": (Capsule(R, 2.0), Cylinder(R)),
    "capsule, sphere": (Capsule(R, 1e-12), Sphere(R)),
    "signed distance, cylinder": (SignedDistance(round_distance, R), Cylinder(R)),
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
    np.testing.assert_allclose(one.positions, other.positions, atol=1e-6 * LENGTH)
    largest = np.abs(other.contact_forces).max()
    np.testing.assert_allclose(one.contact_forces, other.contact_forces, atol=1e-4 * largest)


def test_large_sphere_is_a_plane() -> None:
    """Its height above the plane is x^2 / 2 R: 8e-7 m at the tip."""
    far = 1e5
    sphere = RodProblem(ROD, WEIGHT, obstacles=(Obstacle(Sphere(far), (0, 0, -0.05 - far)),))
    plane = RodProblem(ROD, WEIGHT, obstacles=(Obstacle(Plane(), (0.0, 0.0, -0.05)),))
    one, other = (solve_contact(problem, elements=40) for problem in (sphere, plane))
    assert other.contact_lengths[0] > 0.02
    np.testing.assert_allclose(one.positions, other.positions, atol=2e-6)


SHAPES = {
    "cylinder": Cylinder(R),
    "cone": Cone(R, 0.3),
    "profile": Profile((-0.1, -0.03, 0.03, 0.1), (0.03, 0.035, 0.025, 0.04)),
    "sphere": Sphere(R),
    "capsule": Capsule(R, 0.02),
    "plane": Plane(),
    "signed distance": SignedDistance(round_distance, R),
}


@pytest.mark.parametrize("name", SHAPES)
def test_moved_and_turned_shape_does_the_work_of_its_forces(name: str) -> None:
    """A shape is lifted into a rod between two clamps and turned; without friction energy is work.

    What is left is of the trapezoidal sum, between whose points nodes begin to touch.
    """
    shape = SHAPES[name]
    ends = {"base": Clamped(), "tip": Clamped((0.39, 0.0, 0.0))}
    low = -0.06 if name == "plane" else -RADIUS - R - 0.02
    turn = np.array((0.15, 0.1, 0.2)) * (0.2 if name == "plane" else 1.0)
    axis = (0.05, 0.02, 1.0) if name == "plane" else (0.3, 1.0, 0.1)
    place = Obstacle.along(shape, (0.21, 0.003, low), axis)
    left = []
    for count in (8, 16):
        ways = np.linspace(0.0, 1.0, count + 1)
        stations = [
            RodProblem(
                ROD,
                WEIGHT,
                obstacles=(place.moved((0.0, 0.004 * t, 0.02 * t), tuple((t * turn).tolist())),),
                **ends,
            )
            for t in ways
        ]
        path = follow_contact(stations, elements=40)
        assert not path.events
        pairs = [state.on_obstacle() for state in path.states]
        forces = np.array([p.force for p in pairs])
        torques = np.array([p.torque for p in pairs])
        power = forces @ (0.0, 0.004, 0.02) + torques @ turn
        work = -np.sum(0.5 * (power[1:] + power[:-1])) / count
        gained = path.states[-1].energy - path.states[0].energy
        left.append(abs(gained - work))
        assert np.abs(torques).max() > 1e-6 or name == "sphere"
        assert path.states[-1].contact_lengths[0] > 0.0
    assert max(left) < 0.03 * abs(gained)
    assert left[1] < 0.01 * abs(gained)


def test_beam_on_three_supports_has_the_reactions_of_the_three_moment_equation() -> None:
    """Clamped level, and propped by a cylinder at its middle and a sphere at its end."""
    weight, span = 1e-3, 0.2
    props = (
        Obstacle.along(Cylinder(0.02), (span, 0.0, -0.02 - RADIUS), (0.0, 1.0, 0.0)),
        Obstacle(Sphere(0.02), (2.0 * span - 1e-6, 0.0, -0.02 - RADIUS)),
    )
    problem = RodProblem(ROD, RodLoad((0.0, 0.0, -weight)), obstacles=props)
    state = solve_contact(problem, elements=80)
    parts = (state.base_reaction[2], *state.contact_forces.sum(axis=1)[:, 2])
    # Clapeyron: 13, 32 and 11 of 28 w l; the rod sags by 1e-5 of its length.
    expected = np.array((13.0, 32.0, 11.0)) / 28.0 * weight * span
    assert parts == pytest.approx(expected, rel=2e-3)
    assert sum(parts) == pytest.approx(2.0 * weight * span, rel=1e-9)


def test_floor_drags_the_rod_with_coulombs_force() -> None:
    floor = Obstacle(Plane(), (0.0, 0.0, -0.03), friction=0.3)
    here = RodProblem(ROD, RodLoad((0.0, 0.0, -0.5)), obstacles=(floor,))
    gone = replace(here, obstacles=(floor.moved((-0.01, 0.0, 0.0)),))
    lying, dragged = follow_contact([here, gone], elements=40).states
    pressed = dragged.normal_forces.sum()
    assert dragged.on_obstacle().force[0] == pytest.approx(0.3 * pressed, rel=1e-6)
    assert not dragged.sticking.any()
    assert abs(lying.on_obstacle().force[0]) <= 0.3 * (1.0 + 1e-9) * lying.normal_forces.sum()


def test_spun_cylinder_bears_the_torque_of_sliding_friction() -> None:
    """The torque is mu N R, of the radius of the cylinder, at whose surface friction acts."""
    cylinder = Obstacle.along(Cylinder(R), (0.2, 0.0, -0.07), (0.0, 1.0, 0.0), friction=0.2)
    here = RodProblem(
        ROD, RodLoad((0.0, 0.0, -0.5)), base=Pinned(), tip=Pinned((0.385, 0.0, -0.02)),
        obstacles=(cylinder,),
    )  # fmt: skip
    spun = replace(here, obstacles=(cylinder.moved(rotation=(0.0, -1.0, 0.0)),))
    state = follow_contact([here, spun], elements=60).states[-1]
    around = state.on_obstacle().torque[1]
    assert around == pytest.approx(0.2 * state.normal_forces.sum() * R, rel=1e-6)
    assert not state.sticking[state.touching].any()
