# SPDX-License-Identifier: Apache-2.0
"""Designs judged with contact: what does not wrap, or not carry, is not feasible."""

import math
from dataclasses import replace

import pytest
from core.design_cases import PAPER_TUBE, angles, answered, designed

from spiral_core import DesignRequirement, MooneyRivlin, TubeSize, design_gripper
from spiral_core.design import closing, payload, sweep
from spiral_core.design.closing import close_on_objects, objects_of
from spiral_core.design.evaluation import ClosedObject, solve_candidate
from spiral_core.design.margin import Constraint, Margin
from spiral_core.design.payload import carried_mass
from spiral_core.design.requirement import Elastomer
from spiral_core.design.rod_correction import gripper_of
from spiral_core.design.sweep import closed_pareto_set, pareto_set, solve_points
from spiral_core.grip.setup import lay_into_coil
from spiral_core.grip.window import grip_window

pytestmark = pytest.mark.long

WANTED = DesignRequirement(
    radius_min=0.012,
    radius_max=0.025,
    tubes=(TubeSize("9.5 mm x 0.8 mm", 4.75e-3, 0.8e-3),),
    elastomers=(Elastomer("latex", MooneyRivlin(c1=130.0e3, c2=15.0e3), 950.0),),
    fiber_angles_beta=angles(50.0, 60.0),
)
LOST = "the coil loses stability"


# Candidates by their angle [deg], and whether other places are tried.
AT_ONCE, NEXT, ELSEWHERE = (50, False), (60, False), (50, True)


@pytest.mark.parametrize(
    ("wraps", "calls", "remark"),
    [
        (AT_ONCE, [AT_ONCE], "all objects are wrapped where the free coil lies"),
        (NEXT, [AT_ONCE, NEXT], "all objects are wrapped where the free coil lies"),
        (ELSEWHERE, [AT_ONCE, NEXT, ELSEWHERE], "0.025 m is wrapped from another place than"),
        (None, [AT_ONCE, NEXT, ELSEWHERE], f"0.025 m is not wrapped: {LOST}"),
    ],
)
def test_the_first_candidate_that_wraps_every_object_is_taken(wraps, calls, remark, monkeypatch):
    made, told = [], []

    def close(requirement, evaluation, say, *, anywhere=False):
        made.append((round(math.degrees(evaluation.candidate.fiber_angle_beta)), anywhere))
        say("closing")
        lost = {} if made[-1] == wraps else {"onset": None, "reason": LOST}
        first, *others = (ClosedObject(radius, 5e4) for radius in objects_of(requirement))
        return (replace(first, shift=0.02 * anywhere, **lost), *others)

    monkeypatch.setattr(closing, "close_on_objects", close)
    report = design_gripper(WANTED, lambda *call: told.append(call))
    assert made == calls
    assert all(done < total for done, total, _ in told)
    step = report.steps[-1]
    assert (step.number, step.satisfied, report.feasible) == (8, bool(wraps), bool(wraps))
    assert step.remark.startswith(remark)
    if wraps:
        assert report.design.actuator.fibers.beta == pytest.approx(math.radians(wraps[0]))
    else:
        assert report.binding == Margin(Constraint.WRAPPED, 2.0, 3.0)
        assert report.relaxations == ()
    made.clear()
    # Nothing is closed on where a limit forbids.
    assert len(design_gripper(replace(WANTED, pressure_max=30e3)).steps) == 7
    assert not made


def test_closing_is_grips_own():
    wanted = replace(WANTED, friction_coefficient=0.5, fiber_angles_beta=angles(50.0))
    evaluation, told = solve_candidate(wanted, *wanted.candidates()), []
    closed = close_on_objects(wanted, evaluation, told.append)
    assert [one.radius for one in closed] == pytest.approx([0.025, 0.0185, 0.012])
    assert told == ["closing on 0.025 m", "closing on 0.0185 m", "closing on 0.012 m"]
    window = grip_window(lay_into_coil(designed(wanted).gripper, 0.012, friction=0.5))
    assert closed[2].onset == pytest.approx(window.onset_wrap, rel=1e-6)
    assert (closed[2].shift, closed[2].reason) == (0.0, "")


def test_the_pareto_set_leaves_out_what_contact_does_not_wrap(monkeypatch):
    points = solve_points(WANTED, WANTED.candidates())
    first = pareto_set(points)[0]

    def close(requirement, point, _):
        lost = {"onset": None, "reason": LOST} if point.candidate == first.candidate else {}
        closed = (ClosedObject(radius, 5e4) for radius in objects_of(requirement))
        return tuple(replace(one, **lost) for one in closed)

    monkeypatch.setattr(sweep, "close_on_objects", close)
    found = [point.candidate for point in closed_pareto_set(WANTED, points)]
    left = pareto_set([point for point in points if point is not first])
    assert found == [point.candidate for point in left] != []


LOADED = replace(
    WANTED,
    radius_min=0.020,
    radius_max=0.020,
    tubes=(PAPER_TUBE,),
    fiber_angles_beta=angles(70.0),
    turns_required=1.5,
)


def test_what_is_carried_grows_with_friction():
    gripper = gripper_of(LOADED, *LOADED.candidates(), 0.33, 80e3)
    slippery, rough = (
        carried_mass(replace(LOADED, friction_coefficient=mu), gripper) for mu in (0.1, 0.4)
    )
    assert 0.0 < 2.0 * slippery < rough < 1.0


def test_a_payload_is_a_constraint_like_any_other(monkeypatch):
    asked = []
    monkeypatch.setattr(payload, "carried_mass", lambda *call: asked.append(call) or 0.02)
    light = designed(replace(LOADED, payload=0.015))
    ((requirement, gripper),) = asked
    assert (requirement.friction_coefficient, gripper.friction_coefficient) == (0.3, 0.3)
    assert gripper == light.gripper
    assert Margin(Constraint.PAYLOAD, 0.02, 0.015) in light.margins
    heavy = answered(replace(LOADED, payload=0.05))
    assert not heavy.feasible
    assert heavy.binding.constraint is Constraint.PAYLOAD
    (relaxation,) = (r for r in heavy.relaxations if r.field == "payload")
    assert 0.0199 < relaxation.sufficient < 0.02
    asked.clear()
    assert designed(LOADED).gripper.friction_coefficient is None
    assert not asked
