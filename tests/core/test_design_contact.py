# SPDX-License-Identifier: Apache-2.0
"""Designs judged with contact: what does not wrap, or not carry, is not feasible."""

from dataclasses import replace
from math import degrees

import pytest
from core.design_cases import PAPER_TUBE, angles, answered, designed
from core.recorded import recorded
from numpy.testing import assert_allclose

from spiral_core import DesignRequirement, MooneyRivlin, TubeSize, design_gripper
from spiral_core.design import closing, payload, sweep
from spiral_core.design.closing import close_on_objects, objects_of
from spiral_core.design.evaluation import ClosedObject, solve_candidate
from spiral_core.design.margin import Constraint, Margin
from spiral_core.design.payload import carried_mass
from spiral_core.design.procedure import LOOK_AHEAD
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
    elastomers=(Elastomer("latex", MooneyRivlin(130.0e3, 15.0e3), 950.0),),
    fiber_angles_beta=angles(50.0, 60.0),
)


def wrapped(requirement, first, shift=0.0):
    """Return objects that are wrapped, the first of them perhaps not."""
    lost = {} if first else {"onset": None, "reason": "the coil loses stability"}
    one, *others = (ClosedObject(radius, 5e4) for radius in objects_of(requirement))
    return (replace(one, shift=shift, **lost), *others)


# Candidates by their angle [deg], and whether other places are tried.
AT_ONCE, NEXT, ELSEWHERE = (50, False), (60, False), (50, True)


@pytest.mark.parametrize("wraps", [NEXT, ELSEWHERE, None])
def test_the_first_candidate_that_wraps_every_object_is_taken(wraps, monkeypatch):
    made, told = [], []

    def close(requirement, evaluation, say, *, anywhere=False):
        made.append((round(degrees(evaluation.candidate.fiber_angle_beta)), anywhere))
        say("closing")
        return wrapped(requirement, made[-1] == wraps, 0.02 * anywhere)

    monkeypatch.setattr(closing, "close_on_objects", close)
    monkeypatch.setitem(LOOK_AHEAD, WANTED.preference, 0)  # the next is solved when the first fails
    report = design_gripper(WANTED, lambda *call: told.append(call))
    assert made == [AT_ONCE, NEXT, ELSEWHERE][: 2 if wraps == NEXT else 3]
    assert all(done < total for done, total, _ in told)
    step = report.steps[-1]
    recorded(f"design/{wraps}", [step, report.binding, report.relaxations])
    assert (step.satisfied, report.feasible) == (bool(wraps), bool(wraps))
    # Nothing is closed on where a limit forbids.
    made.clear()
    assert len(design_gripper(replace(WANTED, pressure_max=30e3)).steps) == 7
    assert not made


def test_closing_is_grips_own():
    wanted = replace(WANTED, friction_coefficient=0.5, fiber_angles_beta=angles(50.0))
    evaluation, told = solve_candidate(wanted, *wanted.candidates()), []
    *others, closed = close_on_objects(wanted, evaluation, told.append)
    assert_allclose([one.radius for one in others], [0.025, 0.0185])
    assert told == ["closing on 0.025 m", "closing on 0.0185 m", "closing on 0.012 m"]
    window = grip_window(lay_into_coil(designed(wanted).gripper, 0.012, friction=0.5))
    assert_allclose(closed.onset, window.onset_wrap, 1e-6)
    assert (closed.shift, closed.reason) == (0.0, "")


def test_an_upright_tube_is_told_to_fall_to_any_side():
    wanted = replace(WANTED, radius_min=0.025, fiber_angles_beta=angles(50.0))
    remarks = [
        design_gripper(replace(wanted, gravity=(9.80665 * x, 9.80665 * y, 0.0))).steps[-1].remark
        for x, y in ((-1.0, 0.0), (1.0, 0.0))
    ]
    assert ["upright" in remark for remark in remarks] == [True, False]


def test_the_pareto_set_leaves_out_what_contact_does_not_wrap(monkeypatch):
    points = solve_points(WANTED, WANTED.candidates())
    first = pareto_set(points)[0]

    def close(requirement, point, _):
        return wrapped(requirement, point.candidate != first.candidate)

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
        carried_mass(replace(LOADED, friction_coefficient=mu), gripper)[0] for mu in (0.1, 0.4)
    )
    assert 0.0 < 2.0 * slippery < rough < 1.0


def test_a_payload_raises_a_pressure_limit_that_nobody_requires():
    wanted = replace(LOADED, radius_max=0.022, turns_required=1.05)
    own = designed(wanted).gripper.pressure_max
    carries, required = designed(wanted, payload=0.018), designed(wanted, pressure_max=150e3)
    assert own < carries.gripper.pressure_max < required.gripper.pressure_max
    mass, pressure = carried_mass(replace(wanted, payload=0.018), carries.gripper)
    assert mass > 0.018
    assert own < pressure < carries.gripper.pressure_max / 1.1  # a fifth above what it needs
    # Not beyond the largest strain.
    report = answered(wanted, payload=0.018, strain_max=0.18)
    assert not report.feasible
    assert report.tried[0].exact.gripper.pressure_max == own


def test_a_payload_is_a_constraint_like_any_other(monkeypatch):
    asked = []
    monkeypatch.setattr(payload, "carried_mass", lambda *call: asked.append(call) or (0.02, 6e4))
    light, heavy = (answered(LOADED, payload=mass) for mass in (0.015, 0.05))
    requirement, gripper = asked[0]
    assert (requirement.friction_coefficient, gripper.friction_coefficient) == (0.3, 0.3)
    assert gripper == light.design.gripper
    recorded("design/payload", [light.message, heavy.binding, heavy.relaxations])
    assert Margin(Constraint.PAYLOAD, 0.02, 0.015) in light.design.margins
    asked.clear()
    assert designed(LOADED).gripper.friction_coefficient is None
    assert not asked
