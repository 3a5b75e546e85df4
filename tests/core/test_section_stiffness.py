# SPDX-License-Identifier: Apache-2.0
"""The section's stiffness at fixed pressure."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE
from core.section_cases import one_family, section, wall_energy

from spiral_core import (
    FreeActuation,
    InvalidInputError,
    Tube,
)
from spiral_core.actuator.section_curve import SectionCurve
from spiral_core.section.path import motion_at
from spiral_core.wrap.gripper import stiffness_from_actuator


def test_bending_a_thin_tube_about_its_straight_fiber_takes_four_times_ei() -> None:
    """Plane strain (4/3 E) about the edge (3/2 x 2 of the diameter's I): 4 E I at rest."""
    tube = Tube(1.0, 1e-4, 10.0)
    stiffness = FreeActuation(section(90.0, 89.9, tube=tube)).curve.stiffness(0.0)
    annulus = stiffness_from_actuator(section(90.0, 89.9, tube=tube))
    assert stiffness.bending == pytest.approx(4.0 * annulus.bending, rel=1e-3)  # t/r, 0.1 degrees
    assert FreeActuation(section(65.0, -65.0)).curve.stiffness(0.0).torsional == math.inf


@pytest.mark.parametrize("gamma", [0.0, 20.0])
def test_stiffness_is_the_second_derivative_of_energy_less_work(gamma: float) -> None:
    bent = section(88.0, 60.0, gamma=gamma)
    curve = SectionCurve(bent)
    pressure = 60.0e3
    size = curve.strain_from_pressure(pressure)
    h = 2e-3 * size
    sizes = [size + k * h for k in (-2, -1, 0, 1, 2)]
    rings = motion_at(curve.path.fibers, np.array(sizes)).ring
    energy = PAPER_TUBE.wall_area * wall_energy(curve, bent, sizes)
    volume = math.pi * bent.wound_radius**2 * (1.0 + rings.stretch_change) * rings.hoop**2
    curvatures = rings.bend / rings.hoop / bent.wound_radius
    rise = np.dot([-1, 16, -30, 16, -1], energy - pressure * volume) / (12 * h * h)
    bend = np.dot([1, -8, 0, 8, -1], curvatures) / (12 * h)
    stiffness = curve.stiffness(pressure)
    assert stiffness.bending == pytest.approx(rise / bend**2, rel=1e-6)  # second differences
    twists = rings.twist / rings.hoop / bent.wound_radius
    twist = np.dot([1, -8, 0, 8, -1], twists) / (12 * h)
    assert stiffness.twist_per_curvature == pytest.approx(twist / bend, rel=1e-8)
    assert stiffness.torsional == pytest.approx(rise / twist**2, rel=1e-6)


def test_stiffness_needs_two_families_and_a_single_fiber() -> None:
    with pytest.raises(InvalidInputError, match="makes the section bend"):
        SectionCurve(section(88.0, 60.0).without_single_fibers()).stiffness(0.0)
    with pytest.raises(InvalidInputError, match="two families"):
        SectionCurve(one_family(70.0)).stiffness(0.0)
