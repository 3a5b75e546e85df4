# SPDX-License-Identifier: Apache-2.0
"""A shape as a coil: exact for helices, continuous where the base passes the axis."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from core.actuator_cases import repeatable
from core.gripper_cases import linear_gripper
from core.rod_cases import gripper_rod
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from spiral_core import Rod, RodLoad, Section, solve_rod
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.wrap.coil import coil_from_state
from spiral_core.wrap.helix import Helix
from spiral_core.wrap.wrap import wrapped_radius

LENGTH = 0.5


def helix_state(torsion, curvature=21.0):
    """Return an unloaded rod: an exact helix."""
    rod = Rod(LENGTH, Section.inextensible(2.5e-4, 1.7e-4), rest_strain=(torsion, 0.0, curvature))
    return solve_rod(rod, RodLoad(), elements=60, estimate_error=False)


def weighed(torsion=-13.5, z=0.81, elements=60):
    case = gripper_rod(length=LENGTH, torsion=torsion, gravity=(0.3, 0.5, z))
    return solve_rod(case, elements=elements, estimate_error=False)


def coil_axis(state, turn):
    """Return the axis of the cylinder that a shape fits, whose free coil turns once in a length."""
    return wrapped_radius(linear_gripper(), UnloadedShape(math.tau / turn, 0.0, LENGTH), state)[1]


@pytest.mark.parametrize(
    ("torsion", "curvature"), [*product((-30.0, -2.0, 0.1, 25.0), (1e-6, 1e-3, 1.0, 21.0, 60.0))]
)
def test_a_helix_is_its_own_coil(torsion, curvature):
    """Along its axis the tangents vary least: the smallest of eigenvalues many decades apart."""
    rate, helix = math.hypot(torsion, curvature), Helix(curvature, torsion)
    if LENGTH * rate < math.tau:
        return  # less than a turn has no axis
    state = helix_state(torsion, curvature)
    axis = coil_axis(state, math.tau / rate)
    expected = np.array((torsion, 0.0, curvature)) / math.copysign(rate, torsion)
    assert_allclose(axis, expected, atol=1e-6 if curvature < 1.0 else 1e-7)
    if curvature < 1.0:
        return
    coil = coil_from_state(state, axis)
    turns = 0.6 * coil.total_turns
    assert coil.helix_angle == pytest.approx(helix.helix_angle, abs=1e-7)
    assert turns == pytest.approx(helix.turns(0.6 * LENGTH), rel=1e-7)
    assert coil.length_for_turns(turns) == pytest.approx(0.6 * LENGTH, rel=1e-6)
    assert coil.advance_for_turns(turns) == pytest.approx(helix.object_length(turns), rel=1e-5)
    assert coil.length_for_turns(0.0) == 0.0


def test_a_fitted_axis_turns_with_the_shape_and_not_with_the_elements():
    states = weighed(), weighed(elements=240), weighed(torsion=13.5, z=-0.81)
    axes = [coil_axis(state, math.tau / math.hypot(21.0, 13.5)) for state in states]
    coils = map(coil_from_state, states, axes)
    turns, finer, mirrored = (coil.total_turns for coil in coils)
    # The element in which the coil begins is cut by a straight line: 0.003 of a turn at N = 60.
    assert turns == pytest.approx(finer, abs=5e-3)
    assert_allclose(np.multiply(axes[0], (1.0, 1.0, -1.0)), axes[2], atol=1e-7)
    assert turns == pytest.approx(mirrored, rel=1e-7)


def test_turns_are_continuous_where_the_tangent_passes_the_axis():
    """A base that swings through the axis by 1e-6 rad must not gain a turn."""
    state = helix_state(13.5)
    tangent = state.tangents[3]
    across, turns = np.cross(tangent, np.cross(tangent, (0.0, 0.0, 1.0))), []
    for swing in (-1e-6, 1e-6):
        axis = Rotation.from_rotvec(swing * across).apply(tangent)
        turns.append(coil_from_state(state, axis / np.linalg.norm(axis)).turns)
    assert_allclose(*turns, atol=1e-4)


@repeatable
@given(
    curvature=st.floats(1.0, 60.0),
    torsion=st.one_of(st.floats(-50.0, 50.0), st.just(0.0)),
    turns=st.one_of(st.just(0.0), st.floats(1e-9, 5.0)),
)
def test_lengths_and_turns_of_a_helix_are_consistent(curvature, torsion, turns):
    helix = Helix(curvature, torsion)
    length = helix.length_for_turns(turns)
    assert helix.turns(length) == pytest.approx(turns, rel=1e-14)
    unrolled = turns * math.hypot(math.tau * helix.radius, helix.pitch)
    assert length == pytest.approx(unrolled, rel=1e-13)
    projected = length * math.cos(helix.helix_angle)
    assert helix.object_length(turns) == pytest.approx(projected, rel=1e-12, abs=1e-15 * length)
    assert helix.radius == pytest.approx(math.sin(helix.helix_angle) ** 2 / curvature, rel=1e-13)
    assert math.copysign(1.0, helix.pitch) == math.copysign(1.0, torsion)


def test_a_helix_may_be_a_circle_or_huge_or_tiny():
    circle = Helix(20.0, 0.0)
    assert (circle.radius, circle.pitch, circle.helix_angle) == (0.05, 0.0, math.pi / 2.0)
    assert Helix(1e200, 1e200).radius == pytest.approx(0.5e-200)
    assert Helix(1e-200, 0.0).radius == pytest.approx(1e200)


def test_a_coil_with_just_as_many_turns_has_them_but_for_rounding():
    coil = coil_from_state(helix_state(13.5), (1.0, 0.0, 0.0))
    turns = coil.total_turns
    for same in (turns, turns * (1.0 + 1e-12)):
        assert coil.length_for_turns(same) == pytest.approx(LENGTH)
        assert coil.advance_for_turns(same) == pytest.approx(coil.advances[-1] - coil.advances[0])
    for more in (turns * (1.0 + 1e-6), math.nan):
        assert coil.length_for_turns(more) is coil.advance_for_turns(more) is None
