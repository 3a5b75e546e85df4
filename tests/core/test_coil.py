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

from spiral_core import solve_rod
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.wrap.coil import coil_from_state
from spiral_core.wrap.helix import Helix
from spiral_core.wrap.wrap import wrapped_radius

LENGTH = 0.5


def shape(torsion, curvature=21.0, gravity=(0.0, 0.0, 0.0), elements=60):
    """Return a rod at rest; without gravity it is an exact helix."""
    case = gripper_rod(LENGTH, curvature=curvature, torsion=torsion, gravity=gravity)
    return solve_rod(case, elements=elements, estimate_error=False)


def coil_of(state, torsion, curvature=21.0):
    """Return a shape as the coil about the axis of what it fits."""
    free = UnloadedShape(math.hypot(torsion, curvature), 0.0, LENGTH)
    return coil_from_state(state, wrapped_radius(linear_gripper(), free, state)[1])


@pytest.mark.parametrize(
    ("torsion", "curvature"), [*product((-30.0, 25.0), (1e-6, 1e-3, 1.0, 60.0)), (0.1, 21.0)]
)
def test_a_helix_is_its_own_coil(torsion, curvature):
    """Along its axis the tangents vary least: the smallest of eigenvalues many decades apart.

    It has just as many turns as it has, but for rounding.
    """
    helix, coil = Helix(curvature, torsion), coil_of(shape(torsion, curvature), torsion, curvature)
    axis = np.array((torsion, 0.0, curvature)) / math.copysign(helix.angular_rate, torsion)
    assert_allclose(coil.axis, axis, atol=1e-6 if curvature < 1.0 else 1e-7)
    if curvature < 1.0:
        return
    assert coil.helix_angle == pytest.approx(helix.helix_angle, abs=1e-7)
    for part in (0.0, 0.6, 1.0, 1.0 + 1e-12):
        turns = part * coil.total_turns
        assert turns == pytest.approx(helix.turns(part * LENGTH), rel=1e-7)
        assert coil.length_for_turns(turns) == pytest.approx(part * LENGTH, rel=1e-6)
        assert coil.advance_for_turns(turns) == pytest.approx(helix.object_length(turns), rel=1e-5)
    for more in (coil.total_turns * (1.0 + 1e-6), math.nan):
        assert coil.length_for_turns(more) is coil.advance_for_turns(more) is None


def test_a_fitted_axis_turns_with_the_shape_and_not_with_the_elements():
    plain, finer, mirrored = (
        coil_of(shape(torsion, gravity=(0.3, 0.5, z), elements=elements), torsion)
        for torsion, z, elements in ((-13.5, 0.81, 60), (-13.5, 0.81, 240), (13.5, -0.81, 60))
    )
    # The element in which the coil begins is cut by a straight line: 0.003 of a turn at N = 60.
    assert plain.total_turns == pytest.approx(finer.total_turns, abs=5e-3)
    assert_allclose(np.multiply(plain.axis, (1.0, 1.0, -1.0)), mirrored.axis, atol=1e-7)
    assert plain.total_turns == pytest.approx(mirrored.total_turns, rel=1e-7)


def test_turns_are_continuous_where_the_tangent_passes_the_axis():
    """A base that swings through the axis by 1e-6 rad must not gain a turn."""
    state = shape(13.5)
    tangent, turns = state.tangents[3], []
    for swing in (-1e-6, 1e-6):
        axis = tangent + swing * np.cross(tangent, (0.0, 0.0, 1.0))
        turns.append(coil_from_state(state, axis / np.linalg.norm(axis)).turns)
    assert_allclose(*turns, atol=1e-4)


@repeatable
@given(
    curvature=st.one_of(st.floats(1.0, 60.0), st.sampled_from((1e-200, 1e200))),
    torsion=st.one_of(st.floats(-50.0, 50.0), st.sampled_from((0.0, 1e200))),
    turns=st.one_of(st.just(0.0), st.floats(1e-9, 5.0)),
)
def test_lengths_and_turns_of_a_helix_are_consistent(curvature, torsion, turns):
    """A circle, and the huge and the tiny, are helices too."""
    helix = Helix(curvature, torsion)
    length, sine = helix.length_for_turns(turns), math.sin(helix.helix_angle)
    assert helix.turns(length) == pytest.approx(turns, rel=1e-14)
    unrolled = turns * math.hypot(math.tau * helix.radius, helix.pitch)
    assert length == pytest.approx(unrolled, rel=1e-13)
    projected = length * math.cos(helix.helix_angle)
    assert helix.object_length(turns) == pytest.approx(projected, rel=1e-12, abs=1e-15 * length)
    assert helix.radius == pytest.approx(sine / curvature * sine, rel=1e-13, abs=0.0)
    assert math.copysign(1.0, helix.pitch) == math.copysign(1.0, torsion)
