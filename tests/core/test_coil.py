# SPDX-License-Identifier: Apache-2.0
"""A shape as a coil: exact for helices, continuous where the base passes the axis."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.rod_cases import gripper_rod
from scipy.spatial.transform import Rotation

from spiral_core import InvalidInputError, Rod, RodLoad, RodState, Section, solve_rod
from spiral_core.wrap.coil import coil_axis, coil_from_state, helix_angle

CURVATURE, LENGTH = 21.0, 0.5


def helix_state(torsion: float, elements: int = 60) -> RodState:
    """Return an unloaded rod: an exact helix."""
    rod = Rod(LENGTH, Section.inextensible(2.5e-4, 1.7e-4), rest_strain=(torsion, 0.0, CURVATURE))
    return solve_rod(rod, RodLoad(), elements=elements, estimate_error=False)


def helix_axis(torsion: float) -> np.ndarray:
    """Return the axis of that helix in the base frame, along its advance."""
    u = np.array([torsion, 0.0, CURVATURE]) / math.hypot(torsion, CURVATURE)
    return u if torsion > 0.0 else -u


@pytest.mark.parametrize("torsion", [-30.0, -13.5, -2.0, 5.0, 25.0])
def test_a_helix_is_its_own_coil(torsion: float) -> None:
    rate = math.hypot(torsion, CURVATURE)
    state = helix_state(torsion)
    axis = coil_axis(state, None, 2.0 * math.pi / rate)
    np.testing.assert_allclose(axis, helix_axis(torsion), atol=1e-7)
    coil = coil_from_state(state, axis)
    assert coil.helix_angle == pytest.approx(math.atan2(CURVATURE, abs(torsion)), abs=1e-7)
    assert coil.total_turns == pytest.approx(LENGTH * rate / (2.0 * math.pi), rel=1e-7)
    assert coil.length_for_turns(1.05) == pytest.approx(1.05 * 2.0 * math.pi / rate, rel=1e-6)
    pitch = 2.0 * math.pi * abs(torsion) / rate**2
    assert coil.advance_for_turns(1.05) == pytest.approx(1.05 * pitch, rel=1e-5)
    assert coil.length_for_turns(0.0) == 0.0
    assert coil.length_for_turns(coil.total_turns + 1e-6) is None
    assert coil.advance_for_turns(coil.total_turns + 1e-6) is None
    everything = coil.length_for_turns(coil.total_turns)
    assert everything == pytest.approx(LENGTH, rel=1e-9)


@pytest.mark.parametrize("curvature", [1e-6, 1e-3, 1.0, 60.0])
@pytest.mark.parametrize("torsion", [-30.0, 0.1, 25.0])
def test_the_axis_of_a_steep_or_flat_helix_is_found(curvature: float, torsion: float) -> None:
    """Along it the tangents vary least: the smallest of eigenvalues many decades apart."""
    rod = Rod(LENGTH, Section.inextensible(2.5e-4, 1.7e-4), rest_strain=(torsion, 0.0, curvature))
    state = solve_rod(rod, RodLoad(), elements=60, estimate_error=False)
    rate = math.hypot(torsion, curvature)
    if LENGTH * rate < 2.0 * math.pi:
        return  # less than a turn has no axis
    axis = np.array((torsion, 0.0, curvature)) / rate * np.sign(torsion)
    np.testing.assert_allclose(coil_axis(state, None, 2.0 * math.pi / rate), axis, atol=1e-6)


def test_a_given_axis_is_kept_and_turned_along_the_advance() -> None:
    state = helix_state(-13.5)
    forward = coil_axis(state, (0.6, 0.0, 0.8), 0.1)
    backward = coil_axis(state, (-0.6, 0.0, -0.8), 0.1)
    assert forward == backward
    assert forward in ((0.6, 0.0, 0.8), (-0.6, 0.0, -0.8))
    assert np.dot(forward, state.tip_position) > 0.0


@pytest.mark.parametrize("axis", [(math.nan, 0.0, 1.0), (0.0, 0.0, 0.0), (2.0, 0.0, 0.0)])
def test_what_is_no_axis_is_refused(axis: tuple[float, float, float]) -> None:
    state = helix_state(-13.5)
    with pytest.raises(InvalidInputError, match="axis"):
        coil_axis(state, axis, 0.1)
    with pytest.raises(InvalidInputError, match="axis"):
        helix_angle(state, axis)


def test_the_helix_angle_is_between_tangent_and_axis() -> None:
    state = helix_state(-13.5)
    assert helix_angle(state, (1.0, 0.0, 0.0)) == pytest.approx(
        math.acos(state.tangents[-1, 0]), abs=1e-9
    )


def test_turns_do_not_depend_on_the_elements() -> None:
    case = gripper_rod(length=0.5, gravity=(0.2, 0.9, -0.4))
    counts = []
    for elements in (60, 240):
        state = solve_rod(case.rod, case.load, elements=elements, estimate_error=False)
        axis = coil_axis(state, None, 2.0 * math.pi / math.hypot(21.0, 13.5))
        counts.append(coil_from_state(state, axis).total_turns)
    # The element in which the coil begins is cut by a straight line: 0.003 of a turn at N = 60.
    assert counts[0] == pytest.approx(counts[1], abs=5e-3)


def test_turns_are_continuous_where_the_tangent_passes_the_axis() -> None:
    """A base that swings through the axis by 1e-6 rad must not gain a turn."""
    state = helix_state(13.5)
    tangent = state.tangents[3]
    side = np.cross(tangent, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    turns = []
    for swing in (-1e-6, 1e-6):
        axis = Rotation.from_rotvec(swing * np.cross(tangent, side)).apply(tangent)
        x, y, z = axis.tolist()
        turns.append(coil_from_state(state, (x, y, z)).turns)
    np.testing.assert_allclose(turns[0], turns[1], atol=1e-4)


def test_a_fitted_axis_turns_with_the_shape() -> None:
    case = gripper_rod(length=0.5, gravity=(0.3, 0.5, 0.81))
    state = solve_rod(case.rod, case.load, elements=60, estimate_error=False)
    mirrored = gripper_rod(length=0.5, torsion=13.5, gravity=(0.3, 0.5, -0.81))
    other = solve_rod(mirrored.rod, mirrored.load, elements=60, estimate_error=False)
    turn = 2.0 * math.pi / math.hypot(21.0, 13.5)
    axis, mirror = coil_axis(state, None, turn), coil_axis(other, None, turn)
    np.testing.assert_allclose(np.array(axis) * [1.0, 1.0, -1.0], mirror, atol=1e-7)
    a, b = coil_from_state(state, axis), coil_from_state(other, mirror)
    assert a.total_turns == pytest.approx(b.total_turns, rel=1e-7)
    assert np.linalg.norm(axis) == pytest.approx(1.0, abs=1e-12)
