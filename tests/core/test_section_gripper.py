# SPDX-License-Identifier: Apache-2.0
"""A gripper with the section's own stiffness: its matrix, and that every rod takes it."""

from __future__ import annotations

import dataclasses
import math
from functools import cache

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE
from core.section_cases import section, uniform

from spiral_core import (
    ActuationLimitError,
    CurvatureForm,
    FreeActuation,
    Gripper,
    InvalidInputError,
    Section,
    WrapCurve,
    grip_window,
    gripper_from_actuator,
    lay_into_coil,
    solve_rod,
    stiffness_from_actuator,
)
from spiral_core.actuator.actuation import section_stiffness
from spiral_core.grip.setup import Closing
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.wrap.gripper import FIBER_STIFFNESS, stiffness_from_section


@cache
def gripper() -> Gripper:
    """Return a gripper of the 70 degree design whose section was asked at 55 kPa."""
    actuator = dataclasses.replace(
        section(88.0, 70.0, tube=dataclasses.replace(PAPER_TUBE, length=0.4)),
        curvature_form=CurvatureForm.FIRST_ORDER,
    )
    stiffness = stiffness_from_section(actuator, 55.0e3)
    return gripper_from_actuator(
        "section", actuator, density=950.0, stiffness=stiffness, pressure_max=95.0e3
    )


@pytest.mark.parametrize("form", CurvatureForm)
@pytest.mark.parametrize("beta", [60.0, -88.0])
def test_the_matrix_is_that_of_one_free_motion(form: CurvatureForm, beta: float) -> None:
    actuator = dataclasses.replace(section(88.0, beta), curvature_form=form)
    found = section_stiffness(FreeActuation(actuator), 60.0e3)
    stretch = FreeActuation(actuator).stretch_from_pressure(60.0e3)
    along = stretch if form is CurvatureForm.EXACT else 1.0  # the backbone's length
    matrix = np.array(stiffness_from_section(actuator, 60.0e3).matrix) / along
    free = np.array([found.twist_per_curvature, 0.0, 1.0])
    assert free @ matrix @ free == pytest.approx(found.bending, rel=1e-9)
    held = np.array([1.0, 0.0, -found.twist_per_curvature])
    square = float(free @ free)
    assert held @ matrix @ held == pytest.approx(FIBER_STIFFNESS * found.bending, rel=1e-9)
    assert free @ matrix @ held == pytest.approx(0.0, abs=1e-9 * found.bending)
    assert square == pytest.approx(float(held @ held), rel=1e-12)
    assert matrix[1, 1] == pytest.approx(found.sideways, rel=1e-9)


def test_two_single_fibers_resist_sideways_as_the_held_motion() -> None:
    actuator = section(88.0, 60.0, apart=80.0)
    found = section_stiffness(FreeActuation(actuator), 20.0e3)
    stiffness = stiffness_from_section(actuator, 20.0e3)
    stretch = FreeActuation(actuator).stretch_from_pressure(20.0e3)
    single = found.bending * stretch / (1.0 + found.twist_per_curvature**2)
    assert stiffness.sideways == pytest.approx(FIBER_STIFFNESS * single, rel=1e-9)


def test_what_has_no_stiffness_of_a_section_says_so() -> None:
    with pytest.raises(InvalidInputError, match="section"):
        stiffness_from_section(uniform(section(88.0, 60.0)), 20.0e3)
    with pytest.raises(ActuationLimitError):
        stiffness_from_section(section(88.0, 60.0), 1e12)


def test_stiffnesses_that_no_tube_has_are_refused() -> None:
    for stiffness in (
        Section.inextensible(1e-4, 1e-4, sideways=1.1e-2),
        Section.inextensible(1e-4, 1e-4, coupling=0.99e-4),
    ):
        with pytest.raises(InvalidInputError, match="at most 100 times as stiff"):
            dataclasses.replace(gripper(), stiffness=stiffness)


def test_the_hanging_gripper_is_that_of_the_rod_with_contact() -> None:
    """Two codes, two elements; on the way both must take the whole matrix."""
    mine, pressure = gripper(), 40.0e3
    setup = lay_into_coil(mine, 0.02, elements=120)
    far = dataclasses.replace(setup.obstacle, position=(0.0, 5.0, 0.0))
    hanging = solve_contact(setup.problem(pressure, far), elements=120)
    shape = mine.unloaded_shape(pressure)
    free = solve_rod(mine.rod(shape), mine.load(shape))
    assert np.linalg.norm(hanging.tip_position - free.tip_position) < 1e-5 * 0.4
    annulus = dataclasses.replace(mine, stiffness=stiffness_from_actuator(section(88.0, 70.0)))
    softer = solve_rod(annulus.rod(shape), annulus.load(shape))
    assert np.linalg.norm(softer.tip_position - free.tip_position) > 0.05 * 0.4


def test_wraps_and_grips_agree_on_the_knee() -> None:
    """The tip's criterion on the free rod, contact on the other: with the same stiffness."""
    curve = WrapCurve(gripper())
    pressure = curve.pressure_from_radius(0.02)
    assert curve.radius_from_pressure(pressure) == pytest.approx(0.02, rel=1e-6)
    setup = lay_into_coil(gripper(), 0.02, closing=Closing.SLOW, curve=curve)
    window = grip_window(setup)
    assert window.onset_wrap == pytest.approx(pressure, rel=0.02)  # gravity and friction
    assert window.loss is None or window.loss > 1.1 * pressure
    assert math.isfinite(window.points[-1].normal_force)
