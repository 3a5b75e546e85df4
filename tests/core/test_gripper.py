# SPDX-License-Identifier: Apache-2.0
"""A gripper: the rod, load and stiffness it stands for, the section's own stiffness among them."""

from dataclasses import replace
from math import isinf, pi

import numpy as np
from core.actuator_cases import PAPER_TUBE, actuator
from core.gripper_cases import linear_gripper
from core.section_cases import section
from numpy.testing import assert_allclose

from spiral_core import CurvatureForm, FreeActuation, Rod, Section, gripper_from_actuator
from spiral_core.actuator.actuation import section_stiffness
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.wrap.gripper import FIBER_STIFFNESS, stiffness_from_section

STIFFNESS = Section.inextensible(3e-4, 2e-4, sideways=4e-4, coupling=1e-4)


def test_stiffness_and_weight_are_those_of_the_annulus_unless_given():
    r, o = PAPER_TUBE.inner_radius, PAPER_TUBE.outer_radius
    light, given = (
        gripper_from_actuator("a name", actuator(), density=930.0, **choices)
        for choices in ({}, {"extra_mass_per_length": 0.01, "stiffness": STIFFNESS})
    )
    found = light.stiffness.bending, light.stiffness.torsional, light.pressure_max
    bending = 6.0 * 145.0e3 * pi / 4.0 * (o**4 - r**4)
    assert_allclose(found, (bending, bending / 1.5, light.actuation.pressure_limit), 1e-12)
    assert given.stiffness == STIFFNESS
    mass = 930.0 * pi * (o**2 - r**2) + 0.01
    assert_allclose(given.weight_per_length, 9.80665 * mass, 1e-12)


def test_a_stretched_backbone_keeps_its_mass_and_the_whole_stiffness():
    gripper = replace(linear_gripper(weight=0.3, gravity=(0.0, -9.80665, 0.0)), stiffness=STIFFNESS)
    shape = UnloadedShape(20.0, -10.0, 0.6)
    assert_allclose(gripper.load(shape).distributed, (0.0, -0.3 * 0.5 / 0.6, 0.0))
    assert gripper.rod(shape) == Rod(0.6, STIFFNESS, rest_strain=(-10.0, 0.0, 20.0))


def test_the_sections_matrix_is_that_of_one_free_motion():
    """Two single fibers forbid bending sideways too: it counts as the motion that is held."""
    for form, beta, apart in [
        (CurvatureForm.FIRST_ORDER, 60.0, 0.0),
        (CurvatureForm.FIRST_ORDER, -88.0, 0.0),
        (CurvatureForm.EXACT, 60.0, 0.0),
        (CurvatureForm.EXACT, 60.0, 80.0),
    ]:
        bent = section(88.0, beta, apart=apart, curvature_form=form)
        curve, pressure = FreeActuation(bent), 20.0e3
        found, shape = section_stiffness(curve, pressure), curve.unloaded_shape(pressure)
        assert isinf(found.sideways) == bool(apart)
        matrix = np.array(stiffness_from_section(bent, pressure).matrix)
        matrix *= bent.tube.length / shape.backbone_length
        slope, most = found.twist_per_curvature, FIBER_STIFFNESS * found.bending
        # Free, sideways, held.
        motions = np.array([(slope, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, -slope)])
        sideways = min(found.sideways, most / (1.0 + slope * slope))
        expected = np.diag((found.bending, sideways, most))
        assert_allclose(motions @ matrix @ motions.T, expected, 1e-9, 1e-9 * found.bending)
