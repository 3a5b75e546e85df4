# SPDX-License-Identifier: Apache-2.0
"""A design that has to carry something: its grip decides, computed with contact."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from spiral_core import DesignRequirement, Gripper, MooneyRivlin, TubeSize, design_gripper
from spiral_core.design import payload
from spiral_core.design.margin import Constraint, Margin
from spiral_core.design.payload import carried_mass
from spiral_core.design.requirement import Elastomer
from spiral_core.design.rod_correction import gripper_of

pytestmark = pytest.mark.long

LATEX = Elastomer("latex", MooneyRivlin(c1=130.0e3, c2=15.0e3), 930.0)
TUBE = TubeSize("3/8 in x 1/32 in", 4.7625e-3, 0.79375e-3)
WANTED = DesignRequirement(
    radius_min=0.020,
    radius_max=0.020,
    tubes=(TUBE,),
    elastomers=(LATEX,),
    fiber_angles_beta=(math.radians(70.0),),
    turns_required=1.5,
)


def test_what_is_carried_grows_with_friction() -> None:
    gripper = gripper_of(WANTED, WANTED.candidates()[0], 0.33, 80e3)
    slippery, rough = (
        carried_mass(replace(WANTED, friction_coefficient=mu), gripper) for mu in (0.1, 0.4)
    )
    assert 0.0 < 2.0 * slippery < rough < 1.0


def test_a_payload_is_a_constraint_like_any_other(monkeypatch: pytest.MonkeyPatch) -> None:
    lengths = []

    def carried(requirement: DesignRequirement, gripper: Gripper) -> float:
        assert gripper.pressure_max > 0.0
        assert requirement.friction_coefficient == 0.3
        assert gripper.tube.inner_radius == TUBE.inner_radius
        lengths.append(gripper.tube.length)
        return 0.02

    monkeypatch.setattr(payload, "carried_mass", carried)
    light = design_gripper(replace(WANTED, payload=0.015), contact=False)
    assert light.feasible
    assert light.design is not None
    assert light.design.gripper.friction_coefficient == 0.3
    margins = {margin.constraint: margin for margin in light.design.margins}
    assert margins[Constraint.PAYLOAD] == Margin(Constraint.PAYLOAD, 0.02, 0.015)
    assert lengths[0] > 0.2
    heavy = design_gripper(replace(WANTED, payload=0.05), contact=False)
    assert not heavy.feasible
    assert heavy.binding.constraint is Constraint.PAYLOAD
    (relaxation,) = (r for r in heavy.relaxations if r.field == "payload")
    assert 0.0199 < relaxation.sufficient < 0.02
    lengths.clear()
    plain = design_gripper(WANTED, contact=False)
    assert plain.design is not None
    assert plain.design.gripper.friction_coefficient is None
    assert not lengths
