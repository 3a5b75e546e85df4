# SPDX-License-Identifier: Apache-2.0
"""The section's stiffness at fixed pressure."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE
from core.section_cases import one_family, section, wall_energy
from scipy.optimize import newton

from spiral_core import (
    InvalidInputError,
    Tube,
)
from spiral_core.actuator.actuation import FreeActuation, section_stiffness
from spiral_core.actuator.section import closures, invariant_excess, motion_at, ring_at
from spiral_core.wrap.gripper import stiffness_from_actuator

pytestmark = pytest.mark.long


def test_bending_a_thin_tube_about_its_straight_fiber_takes_four_times_ei() -> None:
    """Plane strain (4/3 E) about the edge (3/2 x 2 of the diameter's I): 4 E I at rest."""
    tube = Tube(1.0, 1e-4, 10.0)
    stiffness = section_stiffness(FreeActuation(section(90.0, 89.9, tube=tube)), 0.0)
    annulus = stiffness_from_actuator(section(90.0, 89.9, tube=tube))
    assert stiffness.bending == pytest.approx(4.0 * annulus.bending, rel=1e-3)  # t/r, 0.1 degrees
    assert section_stiffness(FreeActuation(section(65.0, -65.0)), 0.0).torsional == math.inf


@pytest.mark.parametrize("gamma", [0.0, 20.0])
def test_stiffness_is_the_second_derivative_of_energy_less_work(gamma: float) -> None:
    bent = section(88.0, 60.0, gamma=gamma)
    curve = FreeActuation(bent)
    pressure = 60.0e3
    size = curve.size_from_pressure(pressure)
    h = 2e-3 * size
    sizes = [size + k * h for k in (-2, -1, 0, 1, 2)]
    rings = motion_at(curve.path.fibers, np.array(sizes)).ring
    energy = PAPER_TUBE.wall_area * wall_energy(curve, bent, sizes)
    volume = math.pi * bent.wound_radius**2 * (1.0 + rings.stretch_change) * rings.hoop**2
    curvatures = rings.bend / rings.hoop / bent.wound_radius
    rise = np.dot([-1, 16, -30, 16, -1], energy - pressure * volume) / (12 * h * h)
    bend = np.dot([1, -8, 0, 8, -1], curvatures) / (12 * h)
    stiffness = section_stiffness(FreeActuation(bent), pressure)
    assert stiffness.bending == pytest.approx(rise / bend**2, rel=1e-6)  # second differences
    twists = rings.twist / rings.hoop / bent.wound_radius
    twist = np.dot([1, -8, 0, 8, -1], twists) / (12 * h)
    assert stiffness.twist_per_curvature == pytest.approx(twist / bend, rel=1e-8)
    assert stiffness.torsional == pytest.approx(rise / twist**2, rel=1e-6)


def test_stiffness_needs_two_families_and_a_single_fiber() -> None:
    with pytest.raises(InvalidInputError, match="makes the section bend"):
        section_stiffness(FreeActuation(section(88.0, 60.0).without_single_fibers()), 0.0)
    with pytest.raises(InvalidInputError, match="two families"):
        section_stiffness(FreeActuation(one_family(70.0)), 0.0)


@pytest.mark.parametrize("pair", [(88.0, 60.0), (75.0, 50.0), (65.0, -65.0)])
@pytest.mark.parametrize("gamma", [0.0, 20.0])
def test_bending_sideways_takes_a_third_at_rest(pair: tuple[float, float], gamma: float) -> None:
    """The strain around is K sin instead of K (1 - cos): means of 1/2 and 3/2, with twist too."""
    if gamma and pair[1] < 0.0:
        gamma = -gamma
    stiffness = section_stiffness(FreeActuation(section(*pair, gamma=gamma)), 0.0)
    assert stiffness.sideways == pytest.approx(stiffness.bending / 3.0, rel=1e-5)


@pytest.mark.parametrize("gamma", [0.0, 20.0])
@pytest.mark.parametrize("thick", [False, True])
def test_sideways_stiffness_is_the_second_difference_of_energy_less_work(
    gamma: float, thick: bool
) -> None:
    """The single fiber turned out of the coil's plane by an angle, the wall closed again."""
    bent = section(88.0, 60.0, gamma=gamma, thick_wall=thick)
    curve = FreeActuation(bent)
    pressure = 70.0e3
    far = np.array([curve.size_from_pressure(pressure)])
    (change,), _ = closures(curve.path.fibers, far)

    def turned(angle: float) -> tuple[float, float]:
        """Return energy less work [J/m], and the curvature [1/m], at an angle [rad]."""
        ring = ring_at(
            curve.path.fibers, far, newton(warp, change, args=(angle,)), np.array([angle])
        )
        first, second, quadrature = invariant_excess(curve.path.fibers, ring)
        share = np.tile(ring.weight, (1, len(quadrature) // ring.weight.shape[1])) * quadrature
        density = np.vectorize(bent.material.energy_density)(3.0 + first, 3.0 + second)
        volume = (1.0 + ring.stretch_change[0]) * ring.hoop[0] ** 2
        stored = bent.tube.wall_area * float((share * density).sum())
        work = pressure * math.pi * bent.wound_radius**2 * volume
        return stored - work, float((ring.bend / ring.hoop)[0]) / bent.wound_radius

    def warp(turn: np.ndarray, angle: float) -> np.ndarray:
        return np.asarray(ring_at(curve.path.fibers, far, turn, np.array([angle])).warp)

    rest, curvature = turned(0.0)
    near, farther = (
        2.0 * (turned(angle)[0] - rest) / (angle * curvature) ** 2 for angle in (0.03, 0.06)
    )
    expected = (4.0 * near - farther) / 3.0
    # The next term of the differences is of the fourth power of the angle.
    assert section_stiffness(FreeActuation(bent), pressure).sideways == pytest.approx(
        expected, rel=1e-5
    )


def test_two_single_fibers_leave_no_bending_sideways() -> None:
    assert (
        section_stiffness(FreeActuation(section(88.0, 60.0, apart=80.0)), 20.0e3).sideways
        == math.inf
    )
