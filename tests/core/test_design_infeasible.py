# SPDX-License-Identifier: Apache-2.0
"""What the design procedure says when nothing fits: what binds, and what would do."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from core.design_cases import CATALOG, PAPER_EXAMPLE

from spiral_core import (
    Constraint,
    DesignRequirement,
    Elastomer,
    Gent,
    Gripper,
    PressureLaw,
    RodStatus,
    SolverError,
    WrapCurve,
    design_gripper,
)
from spiral_core.design import relaxations, rod_correction
from spiral_core.design.margin import Margin, tightest
from spiral_core.design.report import DesignReport

pytestmark = pytest.mark.long

# A megapascal limits none of these; without any limit a range takes ten times as long to solve.
FREE = replace(
    PAPER_EXAMPLE, object_length=None, pressure_max=1.0e6, strain_max=None, length_max=None
)
INFEASIBLE = {
    "too thin for the strain": (
        replace(FREE, radius_min=2.0e-3, strain_max=0.2), Constraint.STRAIN, "radius_min",
    ),
    "too thin for the pressure": (
        replace(FREE, radius_min=2.0e-3, pressure_max=80.0e3), Constraint.PRESSURE, "radius_min",
    ),
    "too thin for the turns' clearance": (
        replace(FREE, radius_min=2.0e-3, fiber_angles_beta=(1.48,)),
        Constraint.TURN_CLEARANCE,
        "radius_min",
    ),
    "too thick for gravity": (
        replace(FREE, radius_max=0.12), Constraint.LARGEST_RADIUS, "radius_max",
    ),
    "too thick for the length": (
        replace(FREE, length_max=0.3), Constraint.LENGTH, "radius_max",
    ),
    "too short an object": (
        replace(FREE, object_length=0.06), Constraint.OBJECT_LENGTH, "radius_max",
    ),
    "too little pressure": (
        replace(FREE, pressure_max=50.0e3), Constraint.PRESSURE, "pressure_max",
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def reports() -> dict[str, DesignReport]:
    """Return every infeasible case, designed once."""
    return {
        name: design_gripper(requirement, contact=False)
        for name, (requirement, _, _) in INFEASIBLE.items()
    }


@pytest.mark.parametrize("name", INFEASIBLE)
def test_the_right_constraint_binds(name: str, reports: dict[str, DesignReport]) -> None:
    report, (_, constraint, _) = reports[name], INFEASIBLE[name]
    assert not report.feasible
    assert report.binding.constraint is constraint
    assert report.binding.room < 0.0
    assert constraint.value in report.message
    assert not all(step.satisfied for step in report.steps)


@pytest.mark.parametrize("name", INFEASIBLE)
def test_every_relaxation_suffices(name: str, reports: dict[str, DesignReport]) -> None:
    requirement, _, field = INFEASIBLE[name]
    relaxations = reports[name].relaxations
    assert field in [relaxation.field for relaxation in relaxations]
    for relaxation in relaxations:
        assert relaxation.requested == getattr(requirement, relaxation.field)
        relaxed = replace(requirement, **{relaxation.field: relaxation.sufficient})
        assert design_gripper(relaxed, contact=False).feasible, relaxation


@pytest.mark.parametrize(
    ("name", "field"),
    [("too thin for the strain", "strain_max"), ("too little pressure", "pressure_max"),
     ("too short an object", "object_length"), ("too thick for the length", "length_max")],
)  # fmt: skip
def test_a_limit_is_relaxed_no_more_than_needed(
    name: str, field: str, reports: dict[str, DesignReport]
) -> None:
    requirement = INFEASIBLE[name][0]
    (relaxation,) = (r for r in reports[name].relaxations if r.field == field)
    short = replace(requirement, **{field: 0.99 * relaxation.sufficient})
    assert not design_gripper(short, contact=False).feasible


def test_what_comes_nearest_is_shown_with_its_violation(reports: dict[str, DesignReport]) -> None:
    design = reports["too little pressure"].design
    assert design is not None
    assert design.smallest.pressure > 50.0e3
    assert design.gripper.pressure_max == 50.0e3
    # At the limit it grips down to another radius.
    assert PAPER_EXAMPLE.radius_min < design.radius_min < PAPER_EXAMPLE.radius_max


@pytest.mark.slow
def test_a_coil_that_gravity_opens_has_no_design(reports: dict[str, DesignReport]) -> None:
    report = reports["too thick for gravity"]
    assert report.design is None
    assert [step.satisfied for step in report.steps][5:] == [False, False]
    # In free fall the same request is met.
    assert design_gripper(
        replace(FREE, radius_max=0.12, gravity=(0.0, 0.0, 0.0)), contact=False
    ).feasible


def test_two_wishes_at_odds_name_one_and_offer_both() -> None:
    report = design_gripper(replace(PAPER_EXAMPLE, radius_min=3.0e-3), contact=False)
    assert not report.feasible
    fields = {relaxation.field for relaxation in report.relaxations}
    assert {"object_length", "radius_min"} <= fields


def test_over_the_catalog_the_nearest_is_found() -> None:
    wanted = replace(PAPER_EXAMPLE, tubes=CATALOG, object_length=0.06)
    report = design_gripper(wanted, contact=False)
    assert report.binding.constraint is Constraint.OBJECT_LENGTH
    (relaxation,) = (r for r in report.relaxations if r.field == "object_length")
    assert design_gripper(
        replace(wanted, object_length=relaxation.sufficient), contact=False
    ).feasible


def test_rubber_that_ends_first_names_the_actuator() -> None:
    # Its chains are fully extended before the coil is as narrow as the smallest object.
    brittle = Elastomer(
        "brittle", Gent(shear_modulus=290.0e3, extension_limit=0.1), 950.0, PressureLaw.UNIFORM
    )
    wanted = replace(FREE, elastomers=(brittle,), fiber_angles_beta=(math.radians(70.0),))
    report = design_gripper(wanted, contact=False)
    assert not report.feasible
    assert report.binding.constraint is Constraint.SMALLEST_RADIUS
    assert report.design is not None
    assert report.design.smallest.radius == pytest.approx(report.binding.value)


def test_margins_know_both_directions() -> None:
    upper = Margin(Constraint.PRESSURE, 120.0, 100.0)
    lower = Margin(Constraint.TURN_CLEARANCE, 120.0, 100.0)
    assert (upper.is_met, lower.is_met) == (False, True)
    assert lower.room == 20.0
    assert tightest((upper, lower)) is upper
    just_so = Margin(Constraint.TURNS, 1.05, 1.05)
    assert tightest((just_so, lower)) is lower
    assert tightest((just_so,)) is just_so


@pytest.mark.slow
def test_absurdly_many_turns_are_refused_without_solving_every_tube(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Counted, not timed: 392 grippers of the whole catalog were solved for this once."""
    solved = []

    def counted(gripper: Gripper) -> WrapCurve:
        solved.append(gripper)
        return WrapCurve(gripper)

    monkeypatch.setattr(rod_correction, "WrapCurve", counted)
    wanted = replace(FREE, tubes=CATALOG[::3], turns_required=100.0)
    report = design_gripper(wanted, contact=False)
    assert not report.feasible
    assert report.binding.constraint is Constraint.TURNS
    assert len(solved) <= 45
    (first, *_) = report.relaxations
    assert first.field == "turns_required"
    fewer = replace(wanted, turns_required=first.sufficient)
    named = next(c for c in fewer.candidates() if c.label == first.design)
    only = replace(fewer, tubes=(named.tube,), fiber_angles_beta=(named.fiber_angle_beta,))
    assert design_gripper(only, contact=False).feasible


def test_what_cannot_be_certified_ends_no_design(monkeypatch: pytest.MonkeyPatch) -> None:
    """A solver that fails inside a search for relaxations costs that relaxation only."""

    def fails(*_: object) -> None:
        raise SolverError(RodStatus.UNSTABLE, 1.0, 1)

    monkeypatch.setattr(relaxations, "_nearest", fails)
    report = design_gripper(INFEASIBLE["too little pressure"][0], contact=False)
    assert {r.field for r in report.relaxations} == {"pressure_max"}


ONE_ANGLE = replace(FREE, fiber_angles_beta=FREE.fiber_angles_beta[:1])
ON_THE_MOON = {"gravity": (0.0, 0.0, -1.62), "object_axis": (1.0, 0.0, 0.0), "radius_max": 0.2}


@pytest.mark.parametrize(
    "wanted",
    [
        replace(FREE, radius_min=11.0e3, radius_max=30.0e3),
        replace(FREE, radius_min=11.0e-9, radius_max=30.0e-9),
        replace(ONE_ANGLE, turns_required=1.0e6, pressure_max=None),
        pytest.param(replace(ONE_ANGLE, **ON_THE_MOON), marks=pytest.mark.slow),
        pytest.param(replace(FREE, **ON_THE_MOON), marks=pytest.mark.slow),
    ],
)
def test_absurd_wishes_are_answered_too(wanted: DesignRequirement) -> None:
    report = design_gripper(wanted, contact=False)
    assert not report.feasible
    assert report.binding.room < 0.0
    assert [step.number for step in report.steps] == [1, 2, 3, 4, 5, 6, 7]
