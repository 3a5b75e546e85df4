# SPDX-License-Identifier: Apache-2.0
"""The design procedure next to what is possible, against a search that shares nothing with it."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from core.design_cases import LATEX, PAPER_TUBE

from spiral_core import (
    Constraint,
    DesignRequirement,
    NoCoilError,
    Preference,
    WrapCurve,
    design_gripper,
    gripper_from_actuator,
)
from spiral_core.design.report import DesignReport

pytestmark = [pytest.mark.long, pytest.mark.slow]

# Angles and limits at which the largest radius of the coil rises in waves with the length.
WANTED = DesignRequirement(
    radius_min=20e-3,
    radius_max=46e-3,
    tubes=(PAPER_TUBE,),
    elastomers=(LATEX,),
    fiber_angles_beta=tuple(math.radians(beta) for beta in (60.0, 75.0, 80.0)),
    turns_required=1.1,
    length_max=0.6,
    pressure_max=90e3,
    strain_max=0.2,
    preference=Preference.SHORTEST,
)
RADII = (44e-3, 46.7e-3, 47e-3, 48e-3, 49e-3, 50e-3, 55e-3)
# Of the scan: 2 % of the length in a step; then bisection to 1e-4 of it.
LENGTHS = np.geomspace(0.25, 0.85, 64)
BISECTIONS = 8


@cache
def held(beta: float, length: float) -> float:
    """Return the largest radius [m] that a hanging gripper of the paper's tube wraps."""
    (candidate,) = replace(WANTED, fiber_angles_beta=(beta,)).candidates()
    gripper = gripper_from_actuator(
        "scanned", candidate.actuator(WANTED, length), density=LATEX.density, pressure_max=90e3,
        turns_required=1.1,
    )  # fmt: skip
    try:
        curve = WrapCurve(gripper)
    except NoCoilError:
        return 0.0
    assert not curve.gaps
    assert curve.radius_min < WANTED.radius_min
    return curve.radius_max


def shortest_by_scan(radius: float) -> float:
    """Return the shortest length [m] of any angle that wraps a radius [m]."""
    found = [math.inf]
    for beta in WANTED.fiber_angles_beta:
        for below, above in pairwise(LENGTHS.tolist()):
            if held(beta, above) >= radius:
                low, high = below, above
                for _ in range(BISECTIONS):
                    middle = 0.5 * (low + high)
                    low, high = (low, middle) if held(beta, middle) >= radius else (middle, high)
                found.append(high)
                break
    return min(found)


@pytest.fixture(scope="module")
def reports() -> dict[float, DesignReport]:
    """Return the answer for each largest radius."""
    return {r: design_gripper(replace(WANTED, radius_max=r), contact=False) for r in RADII}


def test_the_limit_is_the_one_of_an_exhaustive_scan(reports: dict[float, DesignReport]) -> None:
    largest = max(held(beta, 0.6) for beta in WANTED.fiber_angles_beta)
    assert 46.7e-3 < largest < 46.9e-3
    for radius, report in reports.items():
        shortest = shortest_by_scan(radius)
        assert report.feasible == (radius <= largest), report.message
        changes = {change.field: change.sufficient for change in report.relaxations}
        if report.feasible:
            assert report.design is not None
            assert report.design.length == pytest.approx(shortest, rel=5e-3)
            continue
        assert changes["radius_max"] == pytest.approx(largest, rel=5e-3)
        if report.binding.constraint is Constraint.LENGTH:
            assert report.binding.value == pytest.approx(shortest, rel=5e-3)
            assert changes["length_max"] == pytest.approx(shortest, rel=5e-3)
        else:
            assert report.binding.constraint is Constraint.LARGEST_RADIUS
            assert report.binding.value == pytest.approx(largest, rel=1e-3)


def test_what_is_reached_never_falls_when_more_is_wanted(
    reports: dict[float, DesignReport],
) -> None:
    feasible = [report.feasible for report in reports.values()]
    assert feasible == sorted(feasible, reverse=True)
    reached = [
        report.binding.value
        for report in reports.values()
        if report.binding.constraint is Constraint.LARGEST_RADIUS
    ]
    assert len(reached) >= 2
    assert reached == sorted(reached)
