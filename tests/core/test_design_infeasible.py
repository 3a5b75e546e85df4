# SPDX-License-Identifier: Apache-2.0
"""What the design procedure says when nothing fits: what binds, and what would do."""

from contextlib import suppress
from dataclasses import replace
from functools import cache
from math import inf

import numpy as np
import pytest
from core.design_cases import CATALOG, LATEX, PAPER_EXAMPLE, PAPER_TUBE, angles, answered
from core.recorded import recorded
from numpy.testing import assert_allclose

from spiral_core import (
    Constraint,
    DesignRequirement,
    Gent,
    NoCoilError,
    Preference,
    RodStatus,
    SolverError,
    WrapCurve,
    gripper_from_actuator,
)
from spiral_core.design import relaxations, rod_correction

pytestmark = pytest.mark.long

# A megapascal limits none of these; without any limit a range takes ten times as long to solve.
FREE = replace(
    PAPER_EXAMPLE, object_length=None, pressure_max=1.0e6, strain_max=None, length_max=None
)
TWO = replace(FREE, fiber_angles_beta=angles(70.0, 80.0))
# What cannot be had, and whether the first relaxation is the least that does.
INFEASIBLE = [
    ({"radius_min": 2.0e-3, "strain_max": 0.2}, "strain_max"),
    ({"radius_min": 2.0e-3, "pressure_max": 80.0e3}, None),
    ({"radius_min": 2.0e-3, "fiber_angles_beta": (1.48,)}, None),
    ({"radius_max": 0.12, "fiber_angles_beta": angles(60.0)}, None),
    ({"length_max": 0.3}, "length_max"),
    ({"object_length": 0.06}, "object_length"),
    ({"pressure_max": 50.0e3}, "pressure_max"),
    # Rubber whose chains are fully extended before the coil is as narrow as the smallest object.
    (
        {
            "elastomers": (replace(LATEX, law=Gent(290.0e3, 0.1)),),
            "fiber_angles_beta": angles(70.0),
        },
        None,
    ),
    # Absurd ones.
    ({"radius_min": 11.0e3, "radius_max": 30.0e3}, None),
    ({"radius_min": 11.0e-9, "radius_max": 30.0e-9}, None),
    # What longer tubes hold than are tried for an object that size is not offered.
    ({"radius_max": 0.1, "turns_required": 1.05, "fiber_angles_beta": angles(60.0)}, None),
]


@pytest.mark.parametrize(("wanted", "least"), INFEASIBLE)
def test_what_binds_is_recorded_and_every_relaxation_suffices(wanted, least):
    requirement = replace(TWO, **wanted)
    report = answered(requirement)
    changes = {change.field: change.sufficient for change in report.relaxations}
    found = [report.message, report.binding, changes]
    recorded(f"infeasible/{INFEASIBLE.index((wanted, least))}", found)
    assert not report.feasible
    for changed, sufficient in changes.items():
        assert answered(requirement, **{changed: sufficient}).feasible, changed
    if least:
        assert not answered(requirement, **{least: 0.99 * changes[least]}).feasible


def test_what_comes_nearest_is_shown_and_relaxed_whatever_fails(monkeypatch):
    """A solver that fails inside a search for relaxations costs that relaxation only."""

    def fails(*_):
        raise SolverError(RodStatus.UNSTABLE, 1.0, 1)

    monkeypatch.setattr(relaxations, "solve_candidate", fails)
    report = answered(TWO, pressure_max=50.0e3)
    assert [change.field for change in report.relaxations] == ["pressure_max"]
    nearest = report.design
    assert nearest.smallest.pressure > 50.0e3 == nearest.gripper.pressure_max
    # At the limit it grips down to another radius.
    assert PAPER_EXAMPLE.radius_min < nearest.radius_min < PAPER_EXAMPLE.radius_max


@pytest.mark.slow
def test_absurdly_many_turns_are_refused_without_solving_every_tube(monkeypatch):
    """Counted, not timed: 392 grippers of the whole catalog were solved for this once."""
    solved = []
    monkeypatch.setattr(
        rod_correction, "WrapCurve", lambda gripper: solved.append(gripper) or WrapCurve(gripper)
    )
    wanted = replace(FREE, tubes=CATALOG[::3], turns_required=100.0)
    report = answered(wanted)
    assert report.binding.constraint is Constraint.TURNS
    assert len(solved) <= 45
    (first, *_) = report.relaxations
    fewer = replace(wanted, **{first.field: first.sufficient})
    named = next(c for c in fewer.candidates() if c.label == first.design)
    only = replace(fewer, tubes=(named.tube,), fiber_angles_beta=(named.fiber_angle_beta,))
    assert (first.field, answered(only).feasible) == ("turns_required", True)


# Angles and limits at which the largest radius of the coil rises in waves with the length.
WAVES = DesignRequirement(
    radius_min=20e-3,
    radius_max=46e-3,
    tubes=(PAPER_TUBE,),
    elastomers=(LATEX,),
    fiber_angles_beta=angles(60.0, 75.0, 80.0),
    turns_required=1.1,
    length_max=0.6,
    pressure_max=90e3,
    strain_max=0.2,
    preference=Preference.SHORTEST,
)
RADII = (44e-3, 46.7e-3, 47e-3, 48e-3, 50e-3, 55e-3)
# Of the scan: 2 % of the length in a step; then bisection to 1e-4 of it.
LENGTHS = np.geomspace(0.25, 0.85, 64).tolist()
BISECTIONS = 8


@cache
def held(beta, length):
    """Return the largest radius [m] that a hanging gripper of the paper's tube wraps."""
    (candidate,) = replace(WAVES, fiber_angles_beta=(beta,)).candidates()
    actuator, limits = candidate.actuator(WAVES, length), {"pressure_max": 90e3}
    with suppress(NoCoilError):
        return WrapCurve(
            gripper_from_actuator("g", actuator, density=950.0, turns_required=1.1, **limits)
        ).radius_max
    return 0.0


def shortest_by_scan(radius):
    """Return the shortest length [m] of any angle that wraps a radius [m]."""
    found = [inf]
    for beta in WAVES.fiber_angles_beta:
        reaches = [held(beta, length) >= radius for length in LENGTHS]
        if any(reaches):
            low, high = LENGTHS[reaches.index(True) - 1 :][:2]
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                low, high = (low, middle) if held(beta, middle) >= radius else (middle, high)
            found.append(high)
    return min(found)


@pytest.mark.slow
@pytest.mark.parametrize("radius", RADII)
def test_the_limit_is_the_one_of_an_exhaustive_scan_that_shares_nothing(radius):
    largest = max(held(beta, 0.6) for beta in WAVES.fiber_angles_beta)
    shortest = shortest_by_scan(radius)
    report = answered(WAVES, radius_max=radius)
    assert report.feasible == (radius <= largest) == (radius < 46.8e-3), report.message
    if report.feasible:
        assert_allclose(report.design.length, shortest, 5e-3)
        return
    changes = {change.field: change.sufficient for change in report.relaxations}
    assert_allclose(changes["radius_max"], largest, 5e-3)
    if report.binding.constraint is Constraint.LENGTH:
        assert_allclose((report.binding.value, changes["length_max"]), shortest, 5e-3)
    else:
        assert report.binding.constraint is Constraint.LARGEST_RADIUS
        # What is reached does not fall when more is wanted.
        assert_allclose(report.binding.value, largest, 1e-3)
