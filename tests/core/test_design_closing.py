# SPDX-License-Identifier: Apache-2.0
"""The eighth step of a design: what contact does not wrap is not feasible."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from spiral_core import DesignRequirement, MooneyRivlin, TubeSize, design_gripper
from spiral_core.design import closing
from spiral_core.design.closing import close_on_objects, judged, objects_of
from spiral_core.design.evaluation import ClosedObject, Evaluation, solve_candidate
from spiral_core.design.margin import Constraint
from spiral_core.design.requirement import Elastomer
from spiral_core.design.rod_correction import gripper_of
from spiral_core.design.sweep import (
    closed_pareto_set,
    pareto_set,
    solve_points,
)
from spiral_core.grip.setup import GripSetup, lay_into_coil
from spiral_core.grip.window import grip_window

pytestmark = pytest.mark.long

WANTED = DesignRequirement(
    radius_min=0.012,
    radius_max=0.025,
    tubes=(TubeSize("9.5 mm x 0.8 mm", 4.75e-3, 0.8e-3),),
    elastomers=(Elastomer("latex", MooneyRivlin(c1=130.0e3, c2=15.0e3), 950.0),),
    fiber_angles_beta=tuple(math.radians(beta) for beta in (50.0, 60.0)),
)
LOST = "the coil loses stability"


def closed_where(
    wraps: Callable[[float, bool], bool], calls: list[tuple[float, bool]]
) -> Callable[..., tuple[ClosedObject, ...]]:
    """Return a closing that wraps what a rule says of the angle [deg] and of other places."""

    def close(
        requirement: DesignRequirement,
        evaluation: Evaluation,
        told: Callable[[str], None],
        *,
        anywhere: bool = False,
    ) -> tuple[ClosedObject, ...]:
        beta = round(math.degrees(evaluation.candidate.fiber_angle_beta))
        calls.append((beta, anywhere))
        told("closing")
        first, *others = objects_of(requirement)
        wrapped = [ClosedObject(radius, 5e4) for radius in others]
        if wraps(beta, anywhere):
            return (ClosedObject(first, 4e4, shift=0.02 if anywhere else 0.0), *wrapped)
        return (ClosedObject(first, reason=LOST), *wrapped)

    return close


@pytest.mark.parametrize(
    ("wraps", "taken", "calls", "remark"),
    [
        (lambda *_: True, 50, [(50, False)], "all objects are wrapped where the free coil lies"),
        (lambda beta, _: beta == 60, 60, [(50, False), (60, False)], "all objects are wrapped"),
        (
            lambda _, anywhere: anywhere,
            50,
            [(50, False), (60, False), (50, True)],
            "0.025 m is wrapped from another place than the free coil's",
        ),
        (
            lambda *_: False,
            None,
            [(50, False), (60, False), (50, True)],
            f"0.025 m is not wrapped: {LOST}",
        ),
    ],
    ids=["at once", "the next", "elsewhere", "nowhere"],
)
def test_the_first_candidate_that_wraps_every_object_is_taken(
    wraps: Callable[[float, bool], bool],
    taken: int | None,
    calls: list[tuple[float, bool]],
    remark: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[tuple[float, bool]] = []
    told: list[tuple[int, int, str]] = []
    monkeypatch.setattr(closing, "close_on_objects", closed_where(wraps, made))
    report = design_gripper(WANTED, lambda *call: told.append(call))
    assert made == calls
    assert all(done < total for done, total, _ in told)
    verdicts = report.steps[2].remark
    assert ("beta 50 deg fails as a rod (objects wrapped" in verdicts) == (taken == 60)
    step = report.steps[-1]
    assert (step.number, step.satisfied) == (8, taken is not None)
    assert step.remark.startswith(remark)
    assert report.feasible == (taken is not None)
    if taken is not None:
        assert report.design is not None
        assert math.degrees(report.design.actuator.fibers.beta) == pytest.approx(taken)
        assert report.binding.constraint is not Constraint.WRAPPED
    else:
        assert report.binding.constraint is Constraint.WRAPPED
        assert (report.binding.value, report.binding.bound) == (2.0, 3.0)
        assert report.relaxations == ()
        assert report.message.endswith(step.remark)


def test_nothing_is_closed_on_where_a_limit_forbids(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[tuple[float, bool]] = []
    monkeypatch.setattr(closing, "close_on_objects", closed_where(lambda *_: True, calls))
    report = design_gripper(replace(WANTED, pressure_max=30e3))
    assert not report.feasible
    assert len(report.steps) == 7
    assert not calls


def evaluated(requirement: DesignRequirement) -> Evaluation:
    """Return the requirement's first candidate as a rod."""
    return solve_candidate(requirement, requirement.candidates()[0])


def test_closing_is_grips_own() -> None:
    wanted = replace(WANTED, friction_coefficient=0.5)
    evaluation = evaluated(wanted)
    told: list[str] = []
    closed = close_on_objects(wanted, evaluation, told.append)
    assert [one.radius for one in closed] == pytest.approx([0.025, 0.0185, 0.012])
    assert told == ["closing on 0.025 m", "closing on 0.0185 m", "closing on 0.012 m"]
    first = replace(wanted, fiber_angles_beta=wanted.fiber_angles_beta[:1])
    design = design_gripper(first, contact=False).design
    assert design is not None
    window = grip_window(lay_into_coil(design.gripper, 0.012, friction=0.5))
    assert closed[2].onset == pytest.approx(window.onset_wrap, rel=1e-6)
    assert (closed[2].shift, closed[2].reason) == (0.0, "")


def test_an_object_is_looked_for_elsewhere_only_if_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = replace(WANTED, radius_min=0.02, radius_max=0.02)
    evaluation = evaluated(wanted)
    assert evaluation.exact is not None
    length = evaluation.exact.length
    place = lay_into_coil(gripper_of(wanted, evaluation.candidate, length, 1e5), 0.02)
    asked: list[GripSetup] = []

    def found(setup: GripSetup) -> GripSetup:
        asked.append(setup)
        x, y, z = setup.obstacle.position
        return replace(setup, obstacle=replace(setup.obstacle, position=(x, y, z + 0.01)))

    def closed(radius: float, setup: GripSetup) -> ClosedObject:
        if setup.obstacle.position[2] > place.obstacle.position[2] + 0.005:
            return ClosedObject(radius, 6e4)
        return ClosedObject(radius, reason=LOST)

    monkeypatch.setattr(closing, "find_place", found)
    monkeypatch.setattr(closing, "_closed", closed)
    (here,) = close_on_objects(wanted, evaluation, lambda _: None)
    assert (here.onset, here.reason, asked) == (None, LOST, [])
    (there,) = close_on_objects(wanted, evaluation, lambda _: None, anywhere=True)
    assert (there.onset, there.reason) == (6e4, "")
    assert there.shift == pytest.approx(0.01)


def test_the_pareto_set_leaves_out_what_contact_does_not_wrap() -> None:
    wanted = replace(
        WANTED, radius_min=0.006, radius_max=0.0125, tubes=(TubeSize("8", 4e-3, 1e-3),)
    )
    points = solve_points(wanted, wanted.candidates())
    closed = [judged(point, close_on_objects(wanted, point, lambda _: None)) for point in points]
    assert closed_pareto_set(wanted, points) == pareto_set(closed)
    # Laid along the tube, tilted, the free coil of one fits the objects, and none is wrapped.
    x, y = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
    tilted = replace(wanted, gravity=(9.81 * x, 9.81 * y, 0.0), object_axis=(x, y, 0.0))
    points = solve_points(tilted, tilted.candidates())
    assert pareto_set(points)
    assert closed_pareto_set(tilted, points) == ()
