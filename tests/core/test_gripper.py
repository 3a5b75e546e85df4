# SPDX-License-Identifier: Apache-2.0
"""A gripper: the rod, load and stiffness it stands for, the section's own stiffness among them."""

import dataclasses
import math
from functools import cache

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE, actuator
from core.gripper_cases import linear_gripper, paper_gripper
from core.section_cases import section

from spiral_core import (
    CurvatureForm,
    FreeActuation,
    InvalidInputError,
    Section,
    WrapCurve,
    grip_window,
    gripper_from_actuator,
    lay_into_coil,
    solve_rod,
)
from spiral_core.actuator.actuation import section_stiffness
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.grip.setup import Closing
from spiral_core.rod.contact.solve import solve_contact
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
    mass = 930.0 * math.pi * (o**2 - r**2)
    light = gripper_from_actuator("light", actuator(), density=930.0)
    assert light.stiffness == stiffness
    assert light.weight_per_length == pytest.approx(9.80665 * mass, rel=1e-12)
    assert light.pressure_max == light.actuation.pressure_limit
    given = gripper_from_actuator(
        "given",
        actuator(),
        density=930.0,
        extra_mass_per_length=0.01,
        stiffness=linear_gripper().stiffness,
    )
    assert given.stiffness == linear_gripper().stiffness
    assert given.weight_per_length == pytest.approx(9.80665 * (mass + 0.01), rel=1e-12)


def test_a_stretched_backbone_keeps_its_mass():
    gripper = linear_gripper(weight=0.3, gravity=(0.0, -9.80665, 0.0))
    shape = UnloadedShape(20.0, -10.0, 0.6)
    load, rod = gripper.load(shape), gripper.rod(shape)
    assert load.distributed == pytest.approx((0.0, -0.3 * 0.5 / 0.6, 0.0))
    assert (rod.length, rod.rest_strain) == (0.6, (-10.0, 0.0, 20.0))


def test_another_mount_changes_nothing_else():
    gripper = paper_gripper("P1")
    tilted = gripper.with_mount((0.0, 0.0, -9.8), (0.0, 1.0, 0.0))
    assert (tilted.gravity, tilted.object_axis) == ((0.0, 0.0, -9.8), (0.0, 1.0, 0.0))
    assert tilted.with_mount(gripper.gravity, gripper.object_axis) == gripper


@pytest.mark.parametrize("stiffness", [{"sideways": 1.1e-2}, {"coupling": 0.99e-4}])
def test_stiffnesses_that_no_tube_has_are_refused(stiffness):
    linear = linear_gripper()
    dataclasses.replace(linear, stiffness=Section.inextensible(1e-4, 99e-4))
    with pytest.raises(InvalidInputError, match="at most 100 times as stiff"):
        dataclasses.replace(linear, stiffness=Section.inextensible(1e-4, 1e-4, **stiffness))


@pytest.mark.parametrize("form", CurvatureForm)
@pytest.mark.parametrize("beta", [60.0, -88.0])
def test_the_sections_matrix_is_that_of_one_free_motion(form, beta):
    bent = section(88.0, beta, curvature_form=form)
    curve = FreeActuation(bent)
    found = section_stiffness(curve, 60.0e3)
    stretch = curve.stretch_from_pressure(60.0e3)
    along = stretch if form is CurvatureForm.EXACT else 1.0  # the backbone's length
    matrix = np.array(stiffness_from_section(bent, 60.0e3).matrix) / along
    slope = found.twist_per_curvature
    free, held = np.array([slope, 0.0, 1.0]), np.array([1.0, 0.0, -slope])
    assert free @ matrix @ free == pytest.approx(found.bending, rel=1e-9)
    assert held @ matrix @ held == pytest.approx(FIBER_STIFFNESS * found.bending, rel=1e-9)
    assert free @ matrix @ held == pytest.approx(0.0, abs=1e-9 * found.bending)
    assert matrix[1, 1] == pytest.approx(found.sideways, rel=1e-9)


def test_two_single_fibers_resist_sideways_as_the_held_motion():
    bent = section(88.0, 60.0, apart=80.0)
    curve = FreeActuation(bent)
    found = section_stiffness(curve, 20.0e3)
    assert found.sideways == math.inf
    stretch = curve.stretch_from_pressure(20.0e3)
    single = found.bending * stretch / (1.0 + found.twist_per_curvature**2)
    sideways = stiffness_from_section(bent, 20.0e3).sideways
    assert sideways == pytest.approx(FIBER_STIFFNESS * single, rel=1e-9)


@cache
def stiff_gripper():
    """Return a gripper of the 70 degree design whose section was asked at 55 kPa."""
    tube = dataclasses.replace(PAPER_TUBE, length=0.4)
    bent = section(88.0, 70.0, tube=tube, curvature_form=CurvatureForm.FIRST_ORDER)
    stiffness = stiffness_from_section(bent, 55.0e3)
    return gripper_from_actuator(
        "section", bent, density=950.0, stiffness=stiffness, pressure_max=95.0e3
    )


def test_the_hanging_gripper_is_that_of_the_rod_with_contact():
    """Two codes, two elements; on the way both must take the whole matrix."""
    mine, pressure = stiff_gripper(), 40.0e3
    setup = lay_into_coil(mine, 0.02, elements=120)
    far = dataclasses.replace(setup.obstacle, position=(0.0, 5.0, 0.0))
    hanging = solve_contact(setup.problem(pressure, far), elements=120).tip_position
    annulus = stiffness_from_actuator(mine.actuation.actuator)
    free, softer = (
        solve_rod(one.rod(shape), one.load(shape)).tip_position
        for one in (mine, dataclasses.replace(mine, stiffness=annulus))
        for shape in [one.unloaded_shape(pressure)]
    )
    assert np.linalg.norm(hanging - free) < 1e-5 * 0.4
    assert np.linalg.norm(softer - free) > 0.05 * 0.4


def test_wraps_and_grips_agree_on_the_knee():
    """The tip's criterion on the free rod, contact on the other: with the same stiffness."""
    curve = WrapCurve(stiff_gripper())
    pressure = curve.pressure_from_radius(0.02)
    assert curve.radius_from_pressure(pressure) == pytest.approx(0.02, rel=1e-6)
    window = grip_window(lay_into_coil(stiff_gripper(), 0.02, closing=Closing.SLOW, curve=curve))
    assert window.onset_wrap == pytest.approx(pressure, rel=0.02)  # gravity and friction
    assert window.loss is None or window.loss > 1.1 * pressure
    assert math.isfinite(window.points[-1].normal_force)
