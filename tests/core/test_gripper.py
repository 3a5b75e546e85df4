# SPDX-License-Identifier: Apache-2.0
"""A gripper: the rod, load and stiffness it stands for, the section's own stiffness among them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from core.actuator_cases import actuator
from core.gripper_cases import linear_gripper
from core.section_cases import section

from spiral_core import (
    CurvatureForm,
    FreeActuation,
    Section,
    gripper_from_actuator,
)
from spiral_core.actuator.actuation import section_stiffness
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.wrap.gripper import (
    FIBER_STIFFNESS,
    stiffness_from_actuator,
    stiffness_from_section,
)


def test_stiffness_and_weight_are_those_of_the_annulus_unless_given():
    r, o = 4.7625e-3, 4.7625e-3 + 0.79375e-3
    second, modulus = math.pi / 4.0 * (o**4 - r**4), 6.0 * 145.0e3
    stiffness = stiffness_from_actuator(actuator())
    assert stiffness.bending == pytest.approx(modulus * second, rel=1e-12)
    assert stiffness.torsional == pytest.approx(modulus / 3.0 * 2.0 * second, rel=1e-12)
    light = gripper_from_actuator("light", actuator(), density=930.0)
    assert light.stiffness == stiffness
    assert light.pressure_max == light.actuation.pressure_limit
    stiffness = linear_gripper().stiffness
    given = gripper_from_actuator(
        "given", actuator(), density=930.0, extra_mass_per_length=0.01, stiffness=stiffness
    )
    assert given.stiffness == stiffness
    mass = 930.0 * math.pi * (o**2 - r**2) + 0.01
    assert given.weight_per_length == pytest.approx(9.80665 * mass, rel=1e-12)


def test_a_stretched_backbone_keeps_its_mass_and_the_whole_stiffness():
    stiffness = Section.inextensible(3e-4, 2e-4, sideways=4e-4, coupling=1e-4)
    gripper = linear_gripper(weight=0.3, gravity=(0.0, -9.80665, 0.0))
    gripper, shape = replace(gripper, stiffness=stiffness), UnloadedShape(20.0, -10.0, 0.6)
    load, rod = gripper.load(shape), gripper.rod(shape)
    assert load.distributed == pytest.approx((0.0, -0.3 * 0.5 / 0.6, 0.0))
    assert (rod.length, rod.rest_strain) == (0.6, (-10.0, 0.0, 20.0))
    assert rod.section == stiffness


@pytest.mark.parametrize(
    ("form", "beta", "apart"),
    [
        (CurvatureForm.FIRST_ORDER, 60.0, 0.0),
        (CurvatureForm.FIRST_ORDER, -88.0, 0.0),
        (CurvatureForm.EXACT, 60.0, 0.0),
        (CurvatureForm.EXACT, 60.0, 80.0),
    ],
)
def test_the_sections_matrix_is_that_of_one_free_motion(form, beta, apart):
    """Two single fibers forbid bending sideways too: it counts as the motion that is held."""
    bent = section(88.0, beta, apart=apart, curvature_form=form)
    curve, pressure = FreeActuation(bent), 20.0e3
    found, shape = section_stiffness(curve, pressure), curve.unloaded_shape(pressure)
    assert math.isinf(found.sideways) == bool(apart)
    matrix = np.array(stiffness_from_section(bent, pressure).matrix)
    matrix *= bent.tube.length / shape.backbone_length
    slope = found.twist_per_curvature
    free, held = np.array([slope, 0.0, 1.0]), np.array([1.0, 0.0, -slope])
    most = FIBER_STIFFNESS * found.bending
    assert free @ matrix @ free == pytest.approx(found.bending, rel=1e-9)
    assert held @ matrix @ held == pytest.approx(most, rel=1e-9)
    assert free @ matrix @ held == pytest.approx(0.0, abs=1e-9 * found.bending)
    sideways = min(found.sideways, most / (1.0 + slope * slope))
    assert matrix[1, 1] == pytest.approx(sideways, rel=1e-9)
