# SPDX-License-Identifier: Apache-2.0
"""The gripper as it really is: as described, or of a material that is stiffer or softer."""

from dataclasses import replace

import pytest
from ros.control_bench import rows

from spiral_core import InvalidInputError, SolverError, WrapCurve
from spiral_core.rod.state import RodStatus
from spiral_gripper import load_description
from spiral_gripper.files.grips import read_grips
from spiral_gripper_ros.simulation.simulated_gripper import Grip, SimulatedGripper

# The pressure as a multiple of the planned one, the radius of the object, the stiffness: the grip.
GRIPS = """
0.8 0.02 1 OVERHANG
1.19 0.02 1 PERFECT_WRAP
1.21 0.02 1 CURLING
1 0.02 0.7 CURLING
1 0.02 1.5 OVERHANG
1 0 1 NO_OBJECT
1 0.1 1 NOT_GRIPPABLE
5 0.02 1 OVERPRESSURE
"""


@pytest.mark.parametrize("row", rows(GRIPS))
def test_the_planned_pressure_wraps_as_the_material_lets_it(gripper, curve, row):
    *numbers, name = row.split()
    ratio, radius, factor = map(float, numbers)
    pressure = ratio * curve.pressure_from_radius(0.02)
    simulated = SimulatedGripper(gripper, factor)
    assert curve.radius_min < simulated.middle_radius < curve.radius_max
    assert simulated.grip(pressure, radius or None) is Grip[name]
    assert (simulated.shape(pressure) is None) is (name == "OVERPRESSURE")


def test_contact_says_how_an_object_is_held_where_its_table_applies():
    description = load_description("prototype_p1")
    described, table = description.gripper, read_grips(description)
    radius = table.held[-2]
    answer = table.grips[table.radii.index(radius)]
    pressure = 0.5 * (answer.onset_wrap + answer.highest_good)
    told = [
        SimulatedGripper(gripper, factor, table).grip(pressure, radius)
        for gripper, factor in (
            (described, 1.0),
            (described, 1.01),
            (described.with_mount((0.0, 9.80665, 0.0), None), 1.0),
        )
    ]
    assert told == [Grip.PERFECT_WRAP, Grip.OVERHANG, Grip.OVERHANG]
    simulated = SimulatedGripper(described, table=table)
    assert simulated.middle_radius in table.held
    unheld = table.radii[table.grips.index(None)]
    assert simulated.grip(WrapCurve(described).pressure_from_radius(unheld), unheld) is (
        Grip.NOT_GRIPPABLE
    )
    # The tip criterion knows thicker ones; a planner with this table tells those that are held.
    assert WrapCurve(described).radius_max > 1.5 * table.held[-1]


def test_a_stiffer_material_sags_as_one_of_that_stiffness(gripper):
    stiffer = replace(gripper, stiffness=gripper.stiffness.scaled(1.5))
    expected = WrapCurve(stiffer).state_at_pressure(5.0e4).tip_position
    found = SimulatedGripper(gripper, 1.5).shape(1.5 * 5.0e4).tip_position
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-9)
    with pytest.raises(InvalidInputError, match="stiffness_factor"):
        SimulatedGripper(gripper, 0.0)


def test_a_shape_without_a_certificate_is_unknown(gripper, monkeypatch):
    def fails(*_):
        raise SolverError(RodStatus.UNSTABLE, 0.1, 3)

    simulated = SimulatedGripper(gripper)
    for name in ("state_at_pressure", "regime"):
        monkeypatch.setattr(WrapCurve, name, fails)
    assert simulated.shape(5.0e4) is None
    assert simulated.grip(5.0e4, 0.02) is Grip.UNKNOWN
