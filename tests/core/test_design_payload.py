# SPDX-License-Identifier: Apache-2.0
"""A design that has to carry something: its grip decides, computed with contact."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from spiral_core import DesignRequirement, InvalidInputError, MooneyRivlin, TubeSize, design_gripper
from spiral_core.design import payload
from spiral_core.design.margin import Constraint, Margin
from spiral_core.design.payload import carried_mass
from spiral_core.design.requirement import Candidate, Elastomer

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
    candidate = Candidate(TUBE, LATEX, math.radians(70.0))
    slippery, rough = (
        carried_mass(replace(WANTED, friction_coefficient=mu), candidate, 0.33, 80e3)
        for mu in (0.1, 0.4)
    )
    assert 0.0 < 2.0 * slippery < rough < 1.0


def test_a_payload_is_a_constraint_like_any_other(monkeypatch: pytest.MonkeyPatch) -> None:
    lengths = []

    def carried(
        requirement: DesignRequirement, candidate: Candidate, length: float, pressure_max: float
    ) -> float:
        assert pressure_max > 0.0
        assert requirement.friction_coefficient == 0.3
        assert candidate.tube is TUBE
        lengths.append(length)
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


def test_a_payload_needs_gravity_and_a_positive_mass() -> None:
    for wrong in ({"payload": -1.0}, {"payload": math.nan}, {"friction_coefficient": -0.1}):
        with pytest.raises(InvalidInputError):
            replace(WANTED, **wrong)
    with pytest.raises(InvalidInputError, match="no gravity"):
        replace(WANTED, payload=0.1, gravity=(0.0, 0.0, 0.0))
