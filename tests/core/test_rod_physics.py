# SPDX-License-Identifier: Apache-2.0
"""The rod's physics: closed forms and symmetries."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.rod_cases import gripper_rod, random_direction, straight_rod
from scipy.integrate import solve_bvp
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from spiral_core import Rod, RodLoad, Section, solve_rod

FREE = RodLoad()
MIRROR = np.array([1.0, 1.0, -1.0])  # through the plane of the free curvature


def helix(strain: tuple[float, float, float], sites: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and rotations of a rod of constant strain: the exponential of its twist."""
    u = np.array(strain)
    twist = np.zeros((4, 4))
    twist[:3, :3] = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
    twist[0, 3] = 1.0
    frames = np.array([expm(s * twist) for s in sites])
    return frames[:, :3, 3], frames[:, :3, :3]


@pytest.mark.parametrize("elements", [2, 3, 7, 24, 100])
@pytest.mark.parametrize(
    "strain",
    [
        (-13.5, 0.0, 21.0),
        (13.5, 4.0, 21.0),
        (0.0, 0.0, 21.0),
        (15.0, 0.0, 0.0),
        (1e-9, 0.0, 21.0),
        (-13.5, 0.0, 1e-9),
        (1e-7, 0.0, 1e-8),
        (0.0, 0.0, 0.0),
    ],
)
def test_an_unloaded_rod_is_the_exact_helix(
    strain: tuple[float, float, float], elements: int
) -> None:
    length = min(0.36, 1.2 * elements / max(1.0, math.hypot(*strain)))
    rod = Rod(length, Section.inextensible(2.5e-4, 1.7e-4), rest_strain=strain)
    state = solve_rod(rod, FREE, elements=elements, estimate_error=False)
    positions, rotations = helix(strain, state.arc_lengths)
    assert state.stable
    assert np.abs(state.positions - positions).max() < 1e-9 * length
    turned = Rotation.from_quat(state.orientations).as_matrix()
    # The tolerance on the moments, 1e-8 EI/L, lets an orientation be off by as much at worst.
    assert np.abs(turned - rotations).max() < 1e-8
    np.testing.assert_allclose(state.strains, np.tile(strain, (elements + 1, 1)), atol=1e-6)
    assert abs(state.energy) < 1e-12
    assert state.folds == 0


@pytest.mark.parametrize("seed", range(5))
def test_mirrored_rods_have_mirrored_shapes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    gravity = np.array(random_direction(rng)) * [1.0, 1.0, 0.7]
    force = 0.02 * rng.normal(size=3)
    left = gripper_rod(
        length=0.3, torsion=-9.0, gravity=tuple(gravity.tolist()), tip_force=tuple(force.tolist())
    )
    right = gripper_rod(
        length=0.3,
        torsion=9.0,
        gravity=tuple((MIRROR * gravity).tolist()),
        tip_force=tuple((MIRROR * force).tolist()),
    )
    a, b = solve_rod(left.rod, left.load), solve_rod(right.rod, right.load)
    np.testing.assert_allclose(b.positions, a.positions * MIRROR, atol=1e-9)
    assert b.energy == pytest.approx(a.energy, rel=1e-9)
    assert b.smallest_pivot == pytest.approx(a.smallest_pivot, rel=1e-6)
    # A moment is an axial vector: in a mirror, (x, y, z) -> (-x, -y, z).
    np.testing.assert_allclose(b.moments, a.moments * -MIRROR, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_rotating_base_and_gravity_together_rotates_the_shape(seed: int) -> None:
    """The base frame is the clamped frame; a mount turns world vectors into it and back."""
    rng = np.random.default_rng(seed)
    mount, turn = Rotation.random(2, random_state=seed)
    gravity_world = np.array(random_direction(rng))

    def world_shape(base: Rotation, gravity: np.ndarray) -> np.ndarray:
        x, y, z = base.inv().apply(gravity).tolist()
        case = gripper_rod(gravity=(x, y, z))
        shape: np.ndarray = base.apply(np.array(solve_rod(case.rod, case.load).positions))
        return shape

    plain = world_shape(mount, gravity_world)
    turned = world_shape(turn * mount, turn.apply(gravity_world))
    np.testing.assert_allclose(turned, turn.apply(plain), atol=1e-9)
    # Turning only the base is another shape.
    assert np.abs(world_shape(turn * mount, gravity_world) - turn.apply(plain)).max() > 1e-3


@pytest.mark.parametrize("angle", [0.4, math.pi / 2.0, 2.9])
def test_a_round_section_knows_no_direction(angle: float) -> None:
    """Rolling rest curvature and loads about the tube turns the shape: a symmetry of the solver."""
    roll = Rotation.from_rotvec([angle, 0.0, 0.0])
    gravity, force, moment = (0.5, -0.6, 0.62), (0.01, 0.02, -0.01), (2e-4, -3e-4, 1e-4)
    plain = gripper_rod(gravity=gravity, tip_force=force, tip_moment=moment)

    def rolled(vector: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = roll.apply(vector).tolist()
        return (x, y, z)

    rod = Rod(
        plain.rod.length,
        plain.rod.section,
        rest_strain=rolled((-13.5, 0.0, 21.0)),
    )
    assert not callable(plain.load.distributed)
    load = RodLoad(rolled(plain.load.distributed), rolled(force), rolled(moment))
    a, b = solve_rod(plain.rod, plain.load), solve_rod(rod, load)
    np.testing.assert_allclose(b.positions, roll.apply(np.array(a.positions)), atol=1e-9)
    np.testing.assert_allclose(b.moments, roll.apply(np.array(a.moments)), atol=1e-9)


def test_scaling_lengths_and_loads_scales_the_shape() -> None:
    """Only w L^3 / EI and the rest angles count."""
    small = gripper_rod(length=0.36)
    factor = 2.5
    rod = Rod(
        0.9, Section.inextensible(0.003, 0.002), rest_strain=(-13.5 / factor, 0.0, 21.0 / factor)
    )
    same = Rod(0.36, Section.inextensible(0.003, 0.002), rest_strain=(-13.5, 0.0, 21.0))
    weight = small.load.distributed[0]  # type: ignore[index]
    a = solve_rod(same, RodLoad(distributed=(weight, 0.0, 0.0)), elements=50)
    b = solve_rod(rod, RodLoad(distributed=(weight / factor**3, 0.0, 0.0)), elements=50)
    np.testing.assert_allclose(b.positions, factor * a.positions, atol=1e-9)
    assert b.smallest_pivot == pytest.approx(a.smallest_pivot, rel=1e-6)


def test_small_deflections_are_eulers_and_bernoullis() -> None:
    rod = straight_rod()
    tiny, length, bending = 1e-6, 0.5, 2.0e-4
    tip = solve_rod(rod, RodLoad(tip_force=(0.0, tiny, 0.0))).tip_position[1]
    assert tip == pytest.approx(tiny * length**3 / (3.0 * bending), rel=1e-5)  # of second order
    state = solve_rod(rod, RodLoad(distributed=(0.0, 0.0, tiny)))
    s = state.arc_lengths
    deflection = tiny * s**2 * (6.0 * length**2 - 4.0 * length * s + s**2) / (24.0 * bending)
    np.testing.assert_allclose(state.positions[:, 2], deflection, atol=1e-5 * deflection[-1])
    tip = solve_rod(rod, RodLoad(tip_moment=(0.0, 0.0, tiny))).tip_position[1]
    assert tip == pytest.approx(tiny * length**2 / (2.0 * bending), rel=1e-5)


@pytest.mark.parametrize("load", [0.5, 2.0, 5.0, 10.0])
def test_a_cantilever_under_a_tip_force_follows_elliptic_integrals(load: float) -> None:
    """P L^2 / EI = load, across: Bisshopp and Drucker (1945)."""
    length, bending = 0.5, 2.0e-4

    # With m = k^2 = (1 + sin(tip slope)) / 2 and sin(theta) = 1 / (sqrt(2) k):
    # K(k) - F(theta, k) = sqrt(load).
    def miss(m: float) -> float:
        theta = math.asin(1.0 / math.sqrt(2.0 * m))
        return float(ellipk(m) - ellipkinc(theta, m)) - math.sqrt(load)

    m = brentq(miss, 0.5 + 1e-12, 1.0 - 1e-12, xtol=1e-14)
    theta = math.asin(1.0 / math.sqrt(2.0 * m))
    across = 1.0 - 2.0 / math.sqrt(load) * float(ellipe(m) - ellipeinc(theta, m))
    along = math.sqrt(2.0 * (2.0 * m - 1.0) / load)
    force = load * bending / length**2
    state = solve_rod(straight_rod(), RodLoad(tip_force=(0.0, force, 0.0)), elements=100)
    # At N = 100 the scheme's own error is a few 1e-7 of the length.
    np.testing.assert_allclose(
        state.tip_position / length, [along, across, 0.0], atol=2e-6 * max(1.0, load / 5.0)
    )
    assert state.moments[0, 2] == pytest.approx(force * along * length, rel=1e-5)


def test_a_heavy_cantilever_follows_the_elastica() -> None:
    """EI theta'' + w (L - s) cos(theta) = 0 solved by scipy's collocation."""
    length, bending, weight = 0.5, 2.0e-4, 0.05
    ratio = weight * length**3 / bending

    def slope(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.vstack((y[1], -ratio * (1.0 - x) * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])))

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.array([a[0], b[1], a[2], a[3]])

    grid = np.linspace(0.0, 1.0, 50)
    solution = solve_bvp(slope, ends, grid, np.zeros((4, 50)), tol=1e-9, max_nodes=20_000)
    assert solution.success
    state = solve_rod(straight_rod(), RodLoad(distributed=(0.0, weight, 0.0)), elements=100)
    x, y = solution.y[2:, -1]
    # The discretization's error at N = 100 is 1e-7 or so.
    np.testing.assert_allclose(state.tip_position / length, [x, y, 0.0], atol=1e-6)
    assert abs(state.tip_position[1]) > 0.5 * length


def test_a_tip_moment_about_the_tube_twists_it() -> None:
    moment, torsional = 1.0e-4, 1.3e-4
    state = solve_rod(straight_rod(), RodLoad(tip_moment=(moment, 0.0, 0.0)), elements=10)
    expected, _ = helix((moment / torsional, 0.0, 0.0), state.arc_lengths)
    np.testing.assert_allclose(state.positions, expected, atol=1e-12)
    np.testing.assert_allclose(state.strains[:, 0], moment / torsional, rtol=1e-8)
    turned = Rotation.from_quat(state.orientations[-1]).as_rotvec()
    np.testing.assert_allclose(turned, [0.5 * moment / torsional, 0.0, 0.0], atol=1e-9)


@pytest.mark.parametrize("turn", [0.3, 1.0, 2.0])
def test_a_tip_moment_across_the_tube_bends_it_to_a_circle(turn: float) -> None:
    bending, length = 2.0e-4, 0.5
    load = RodLoad(tip_moment=(0.0, 0.0, turn * bending / length))
    state = solve_rod(straight_rod(), load, elements=24)
    expected, _ = helix((0.0, 0.0, turn / length), state.arc_lengths)
    # The moment is what the tolerance bounds; the series of the strain leaves 35/1152 z^8.
    np.testing.assert_allclose(state.positions, expected, atol=1e-8)


def test_hanging_straight_is_stable_and_carries_the_weight() -> None:
    state = solve_rod(straight_rod(), RodLoad(distributed=(0.3, 0.0, 0.0), tip_force=(0.1, 0, 0)))
    np.testing.assert_allclose(state.positions[:, 0], state.arc_lengths, atol=1e-15)
    np.testing.assert_allclose(state.forces[:, 0], 0.1 + 0.3 * (0.5 - state.arc_lengths))
    assert state.stable
    # All energy is the load's: -F L - w L^2 / 2.
    assert state.energy == pytest.approx(-0.1 * 0.5 - 0.3 * 0.125, rel=1e-12)
