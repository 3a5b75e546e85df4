# SPDX-License-Identifier: Apache-2.0
"""The gripper as it really is: as described, or of a material that is stiffer or softer."""

from dataclasses import replace

import numpy as np
import pytest

from spiral_core import InvalidInputError, Section, SolverError
from spiral_core.rod.state import RodStatus
from spiral_gripper_ros.simulation.simulated_gripper import (
    Grip,
    ScaledActuation,
    SimulatedGripper,
    stiffened,
)

RADIUS = 0.02


@pytest.fixture(scope="module")
def simulated(gripper):
    return SimulatedGripper(gripper)


def test_as_described_it_wraps_at_the_planned_pressure(simulated, curve):
    pressure = curve.pressure_from_radius(RADIUS)
    assert simulated.grip(pressure, RADIUS) is Grip.PERFECT_WRAP
    assert simulated.grip(0.8 * pressure, RADIUS) is Grip.OVERHANG
    assert simulated.grip(1.19 * pressure, RADIUS) is Grip.PERFECT_WRAP
    assert simulated.grip(1.21 * pressure, RADIUS) is Grip.CURLING
    expected = curve.state_at_pressure(pressure).tip_position
    assert np.allclose(simulated.shape(pressure).tip_position, expected, rtol=1e-12, atol=0.0)


def test_what_is_no_object_or_no_grip_is_called_so(simulated, gripper):
    assert simulated.grip(5.0e4, None) is Grip.NO_OBJECT
    assert simulated.grip(5.0e4, 0.1) is Grip.NOT_GRIPPABLE
    assert simulated.grip(5.0e4, 0.001) is Grip.NOT_GRIPPABLE
    assert simulated.grip(1.01 * gripper.pressure_max, RADIUS) is Grip.OVERPRESSURE
    assert simulated.shape(1.01 * gripper.pressure_max) is None


@pytest.mark.parametrize("factor", [0.7, 1.5])
def test_without_gravity_a_stiffer_material_takes_proportionally_more_pressure(gripper, factor):
    weightless = gripper.with_mount((0.0, 0.0, 0.0), None)
    described = SimulatedGripper(weightless)
    other = SimulatedGripper(weightless, factor)
    assert np.allclose(
        other.shape(factor * 5.0e4).tip_position,
        described.shape(5.0e4).tip_position,
        rtol=1e-6,
        atol=1e-9,
    )


@pytest.mark.parametrize(("factor", "grip"), [(0.7, Grip.CURLING), (1.5, Grip.OVERHANG)])
def test_an_uncalibrated_gripper_misses_the_wrap(gripper, curve, factor, grip):
    pressure = curve.pressure_from_radius(RADIUS)
    assert SimulatedGripper(gripper, factor).grip(pressure, RADIUS) is grip


def test_a_stiffer_tube_sags_less(gripper):
    heavy = stiffened(gripper, 4.0)
    shapes = [g.unloaded_shape(p) for g, p in ((gripper, 1.0e4), (heavy, 4.0e4))]
    assert shapes[0] == shapes[1]
    assert heavy.stiffness.bending == 4.0 * gripper.stiffness.bending
    assert heavy.stiffness.torsional == 4.0 * gripper.stiffness.torsional
    assert heavy.pressure_max == 4.0 * gripper.pressure_max


def test_a_section_with_its_own_stiffness_keeps_it(gripper):
    stiffness = Section.inextensible(3e-4, 2e-4, sideways=1e-4, coupling=-1e-4)
    kept = stiffened(replace(gripper, stiffness=stiffness), 1.0).stiffness
    assert kept == stiffness


@pytest.mark.parametrize("factor", [0.1, 1.0 / 3.0, 0.7, 1.1, 3.0])
def test_the_whole_range_of_pressures_is_answered(gripper, factor):
    scaled = stiffened(gripper, factor)
    full = stiffened(replace(gripper, pressure_max=gripper.actuation.pressure_limit), factor)
    for one in (scaled, full):
        assert one.unloaded_shape(one.pressure_max).curvature > 0.0


def test_no_rounding_takes_a_pressure_past_the_limit(gripper):
    limit = gripper.actuation.pressure_limit
    # One factor in a hundred takes the limit, scaled and scaled back, to a little more than it.
    for factor in np.linspace(0.2, 5.0, 1000):
        scaled = ScaledActuation(gripper.actuation, float(factor))
        curvature = scaled.unloaded_shape(scaled.pressure_limit).curvature
        assert curvature == pytest.approx(gripper.actuation.unloaded_shape(limit).curvature)


def test_the_middle_radius_can_be_gripped(simulated, curve):
    assert simulated.middle_radius == 0.5 * (curve.radius_min + curve.radius_max)


def test_a_shape_without_a_certificate_is_unknown(gripper, monkeypatch):
    simulated = SimulatedGripper(gripper)

    def fails(*_):
        raise SolverError(RodStatus.UNSTABLE, 0.1, 3)

    for name in ("state_at_pressure", "regime"):
        monkeypatch.setattr(simulated._curve, name, fails)
    assert simulated.shape(5.0e4) is None
    assert simulated.grip(5.0e4, RADIUS) is Grip.UNKNOWN


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan"), float("inf")])
def test_a_stiffness_that_cannot_be_is_refused(gripper, bad):
    with pytest.raises(InvalidInputError, match="stiffness_factor"):
        SimulatedGripper(gripper, bad)
