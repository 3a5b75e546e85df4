# SPDX-License-Identifier: Apache-2.0
"""Both forms of the shape, what ends them, and the winding sheet."""

import math
from dataclasses import replace

import numpy as np
from core.actuator_cases import PAPER_TUBE, actuator, extending_pairs, mirrored, repeatable
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from spiral_core import CurvatureForm
from spiral_core.actuator.actuator import windings_of
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.fibers import fiber_state, locking_stretch
from spiral_core.wrap.helix import Helix


@repeatable
@given(
    fibers=extending_pairs,
    fraction=st.one_of(st.floats(1e-9, 0.3), st.sampled_from([0.0, 1e-12])),
    placed=st.sampled_from([None, 1.0e-3, 5.5e-3]),
    form=st.sampled_from(CurvatureForm),
)
def test_shapes_follow_from_stretch_twist_and_the_straight_fiber(fibers, fraction, placed, form):
    stretch = 1.0 + fraction * (locking_stretch(fibers) - 1.0)
    twist = fiber_state(fibers, stretch).twist / PAPER_TUBE.inner_radius
    exact, radius = form is CurvatureForm.EXACT, placed or PAPER_TUBE.inner_radius
    assume(not exact or abs(twist) * radius < 1.0)
    choices = {"straight_fiber_radius": placed, "curvature_form": form}
    shape, image = (
        unloaded_shape_from_stretch(replace(actuator(**choices), fibers=pair), stretch)
        for pair in (fibers, mirrored(fibers))
    )
    assert image == replace(shape, torsion=-shape.torsion)
    backbone = stretch if exact else 1.0
    assert shape.backbone_length == backbone * PAPER_TUBE.length
    assert_allclose(shape.torsion, twist / backbone, 1e-14)
    if exact:
        # A unit of fiber inside the bent tube: shorter by the bend, longer by the twist.
        along = 1.0 - shape.curvature * radius
        assert_allclose(stretch * math.hypot(along, radius * shape.torsion), 1.0, 1e-14)
    else:
        assert_allclose(shape.curvature, (stretch - 1.0) / radius, 1e-14)


def test_forms_coil_left_handed_and_differ_at_working_stretch_as_documented():
    rows = []
    for form in (CurvatureForm.FIRST_ORDER, CurvatureForm.EXACT):
        shape = unloaded_shape_from_stretch(actuator(curvature_form=form), 1.1)
        coil = Helix(shape.curvature, shape.torsion)
        rows.append((shape.curvature, coil.radius, coil.turns(shape.backbone_length)))
        assert shape.torsion < 0.0
    assert_allclose(np.divide(*reversed(rows)), (0.93, 1.09, 1.015), 0, 5e-3)


def test_pitch_turns_and_length_of_a_winding_unroll_to_the_angle():
    height = PAPER_TUBE.length
    for beta in [-70.0, 10.0, 89.0]:
        _, winding = windings_of(actuator(88.0, beta))
        around = 2.0 * math.pi * PAPER_TUBE.outer_radius * winding.turns
        found = math.atan2(around, height), winding.turns * winding.pitch, winding.fiber_length
        expected = math.radians(abs(beta)), height, math.hypot(height, around)
        assert_allclose(found, expected, 1e-12)
        assert winding.hand == ("right" if beta > 0.0 else "left")
