# SPDX-License-Identifier: Apache-2.0
"""The gripper as it really is: as described, or of a material that is stiffer or softer."""

import math
from dataclasses import replace

import numpy as np
import pytest
from ros.control_bench import rows

from spiral_core import InvalidInputError, SolverError, WrapCurve
from spiral_core.rod.state import RodStatus
from spiral_gripper_ros.simulation.simulated_gripper import (
    Grip,
    ScaledActuation,
    SimulatedGripper,
    stiffened,
)

RADIUS = 0.02


# The pressure as a multiple of the planned one, the radius of the object, the stiffness: the grip.
GRIPS = """
1 0.02 1 PERFECT_WRAP
0.8 0.02 1 OVERHANG
1.19 0.02 1 PERFECT_WRAP
1.21 0.02 1 CURLING
1 0.02 0.7 CURLING
1 0.02 1.5 OVERHANG
1 - 1 NO_OBJECT
1 0.1 1 NOT_GRIPPABLE
1 0.001 1 NOT_GRIPPABLE
5 0.02 1 OVERPRESSURE
"""


@pytest.mark.parametrize("row", rows(GRIPS))
def test_the_planned_pressure_wraps_as_the_material_lets_it(gripper, curve, row):
    ratio, radius, factor, name = row.split()
    ratio, factor, grip = float(ratio), float(factor), Grip[name]
    radius = None if radius == "-" else float(radius)
    pressure = ratio * curve.pressure_from_radius(RADIUS)
    simulated = SimulatedGripper(gripper, factor)
    assert simulated.grip(pressure, radius) is grip
    assert (simulated.shape(pressure) is None) is (grip is Grip.OVERPRESSURE)


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


def test_no_rounding_takes_a_pressure_past_the_limit(gripper):
    limit = gripper.actuation.pressure_limit
    full = replace(gripper, pressure_max=limit)
    for scaled in (stiffened(full, factor) for factor in (0.1, 1.0 / 3.0, 1.1)):
        assert scaled.unloaded_shape(scaled.pressure_max).curvature > 0.0
    # One factor in a hundred takes the limit, scaled and scaled back, to a little more than it.
    for factor in np.linspace(0.2, 5.0, 1000):
        scaled = ScaledActuation(gripper.actuation, float(factor))
        curvature = scaled.unloaded_shape(scaled.pressure_limit).curvature
        assert curvature == pytest.approx(gripper.actuation.unloaded_shape(limit).curvature)


@pytest.mark.parametrize("bad", [0.0, math.inf])
def test_a_stiffness_that_cannot_be_is_refused(gripper, bad):
    with pytest.raises(InvalidInputError, match="stiffness_factor"):
        SimulatedGripper(gripper, bad)


def test_a_shape_without_a_certificate_is_unknown(gripper, monkeypatch):
    def fails(*_):
        raise SolverError(RodStatus.UNSTABLE, 0.1, 3)

    simulated = SimulatedGripper(gripper)
    for name in ("state_at_pressure", "regime"):
        monkeypatch.setattr(WrapCurve, name, fails)
    assert simulated.shape(5.0e4) is None
    assert simulated.grip(5.0e4, RADIUS) is Grip.UNKNOWN
