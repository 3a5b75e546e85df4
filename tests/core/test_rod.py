# SPDX-License-Identifier: Apache-2.0
"""Choice of the element, few elements, breaks, statuses, reproducible results."""

from __future__ import annotations

import math
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, replace
from multiprocessing import get_context

import numpy as np
import pytest
from core.rod_cases import COUPLED, HELICAL, STRAIGHT, gripper_rod, round_rod
from numpy.linalg import norm

from spiral_core import (
    Clamped,
    Cylinder,
    Free,
    InvalidInputError,
    Obstacle,
    Pinned,
    Plane,
    PointLoad,
    Rod,
    RodElement,
    RodLoad,
    RodProblem,
    RodStatus,
    Section,
    SolverError,
    follow_rod,
    solve_rod,
)

LOAD = RodLoad((0.24, 0.05, 0.0), (0.01, 0.0, 0.02))


def test_results_are_bit_identical_in_one_process_and_in_two():
    rod = Rod(0.5, Section.inextensible(2.5e-4, 1.7e-4), rest_strain=(-21.0, 0.0, 31.0))
    load = RodLoad((0.1, -0.2, 0.05), (0.0, 0.01, 0.0))
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        other = pool.submit(solve_rod, rod, load).result()
    for state in (solve_rod(rod, load), solve_rod(rod, load)):
        for each in (one for one in fields(state) if not one.name.startswith("_")):
            np.testing.assert_array_equal(getattr(state, each.name), getattr(other, each.name))


MIXED_CASES = {
    "obstacle": {"obstacles": (Obstacle(Plane(), position=(0.0, 0.0, -0.2)),)},
    "held tip": {"tip": Pinned((0.3, 0.0, 0.0))},
    "clamped elsewhere": {"base": Clamped((0.1, 0.0, 0.0))},
    "point load": {"point_loads": (PointLoad(0.1, force=(0.0, 0.0, 0.01)),)},
    "stretch": {"section": Section(COUPLED.stiffness, extension=100.0)},
    "shear": {"section": Section(COUPLED.stiffness, shear=100.0)},
    "coupled otherwise": {"section": Section(((5e-4, 1e-4, 0), (1e-4, 4e-4, 0), (0, 0, 4e-4)))},
    "varying 6x6": {
        "section": lambda s: np.tile(np.diag((5e-4, 4e-4, 4e-4, 90.0, 40.0, 40.0)), (len(s), 1, 1))
    },
    "radius": {"radius": 1e-3},
    "centerline": {"start": np.linspace((0.0, 0.0, 0.0), (0.36, 0.0, 0.0), 41).tolist()},
}


@pytest.mark.parametrize("case", MIXED_CASES)
def test_what_the_fast_element_cannot_take_goes_to_the_mixed_one(case):
    given = dict(MIXED_CASES[case])
    kind = {name: given.pop(name) for name in ("section", "radius") if name in given}
    rod, load = replace(HELICAL, **kind), RodLoad((0.0, 0.02, 0.0))
    state = solve_rod(rod, load, elements=40, **given)
    assert state.stable
    assert state.element is RodElement.MIXED
    with pytest.raises(InvalidInputError, match="element"):
        solve_rod(rod, load, elements=40, element=RodElement.INEXTENSIBLE, **given)


def test_sections_are_compared_and_scaled_as_a_whole():
    scaled = Section.inextensible(3e-4, 2e-4, sideways=1e-4, coupling=-1e-4).scaled(4.0)
    assert scaled == Section.inextensible(12e-4, 8e-4, sideways=4e-4, coupling=-4e-4)
    assert Section(np.eye(6)) == Section(tuple(map(tuple, np.eye(6).tolist())))


@pytest.mark.parametrize("scale", [1.0, 0.7, 3.3])
@pytest.mark.parametrize("parts", [2, 3, 6])
def test_equal_pieces_have_equally_many_elements(scale, parts):
    """Whatever rounding makes of their lengths."""
    ends = [0.4 * scale * k / parts for k in range(1, parts)]
    rod = Rod(0.4 * scale, Section.inextensible(1.0, 1.0), breaks=tuple(ends))
    arcs = solve_rod(rod).arc_lengths
    nodes = [int(np.abs(arcs - at).argmin()) for at in (0.0, *ends, rod.length)]
    assert len(set(np.diff(nodes))) == 1


@pytest.mark.parametrize(
    "profile",
    [
        lambda s: 3e-4 * (1.0 + np.abs(s - 0.1234)),
        lambda s: 3e-4 * (1.5 + np.tanh((s - 0.15) / 0.01)),
        lambda s: 3e-4 * (1.0 + 0.5 * np.sin(60.0 * s)),
    ],
)
def test_kinks_and_steep_slopes_are_not_jumps(profile):
    rod = Rod(0.3, Section.varying(profile, 2e-4), rest_strain=(-5.0, 0.0, 10.0))
    state, exact = solve_rod(rod, LOAD), solve_rod(rod, LOAD, elements=2400)
    error = norm(state.tip_position - exact.tip_position)
    assert error < 3.0 * state.discretization_error + 1e-9


@pytest.mark.parametrize("elements", [2, 3, 5, 8])
@pytest.mark.parametrize("turned", [0.5, 3.0, 8.0, 20.0])
def test_few_elements_are_honest(elements, turned):
    """Refused where an element turns too far, else an estimate that holds."""
    case = gripper_rod(curvature=turned / 0.36, torsion=0.4 * turned / 0.36)
    if math.hypot(1.0, 0.4) * turned > 2.0 * elements:
        with pytest.raises(InvalidInputError, match="turn by 2 rad at most"):
            solve_rod(case, elements=elements)
        return
    state = solve_rod(case, elements=elements, throw=False)
    if state.status is RodStatus.UNRESOLVED:
        assert turned / elements > 0.9
        return
    exact = solve_rod(case, elements=240, start=state)
    error = norm(state.tip_position - exact.tip_position)
    assert error < 1.5 * state.discretization_error < 15.0 * max(error, 1e-6)


@pytest.mark.parametrize("ratio", [1e-3, 0.1, 10.0, 1000.0])
def test_any_torsional_stiffness_has_the_elements_it_needs(ratio):
    """And as many where its bending is stated with a breath of anisotropy."""
    rod, load = round_rod(ratio), RodLoad((0.1, 0.1, 0.0))
    state = solve_rod(rod, load)
    count = len(state.arc_lengths) - 1
    exact = solve_rod(rod, load, elements=2 * count, start=state)
    assert exact.folds == 0
    assert norm(state.tip_position - exact.tip_position) < 5e-5 * rod.length
    bending, torsional = rod.section.bending, rod.section.torsional
    for sideways, coupling in ((1.0 + 1e-12, 0.0), (1.0, 1e-12), (1.003, 0.0)):
        section = Section.inextensible(
            bending, torsional, bending * sideways, coupling * min(torsional, bending)
        )
        other = solve_rod(replace(rod, section=section), load)
        assert len(other.arc_lengths) - 1 == pytest.approx(count, abs=2)


TUBE = Rod(0.4, Section((2e-4, 3e-4, 3e-4)), 3e-3)
INSIDE = Obstacle.along(Cylinder(0.03), (0.2, 0.0, -0.03), (0.0, 1.0, 0.0))
NO_ANSWERS = [
    (RodStatus.NOT_FINITE, 10, RodProblem(STRAIGHT, RodLoad(tip_force=(0.0, 1e300, 0.0)))),
    # Twisting a straight rod past its limit: no certificate, and the figures say so.
    (None, 40, RodProblem(STRAIGHT, RodLoad(tip_moment=(5e-3, 0.0, 0.0)))),
    (RodStatus.UNRESOLVED, 3, RodProblem(STRAIGHT, RodLoad(tip_force=(-1.0, 0.01, 0.0)))),
    (RodStatus.INSIDE_OBSTACLE, None, RodProblem(TUBE, obstacles=(INSIDE,))),
    (RodStatus.NOT_HELD, None, RodProblem(TUBE, RodLoad((0.0, 0.0, -1.0)), base=Free())),
    (RodStatus.SELF_CONTACT, None, RodProblem(replace(TUBE, rest_strain=(0.0, 0.0, 120.0)))),
]


def test_an_overflow_is_no_small_residual():
    far = Obstacle.along(Cylinder(0.03), (0.2, 0.0, -0.5), (0.0, 1.0, 0.0))
    problem = RodProblem(TUBE, RodLoad(tip_force=(0.0, 1e200, 0.0)), obstacles=(far,))
    with np.errstate(all="ignore"):
        state = solve_rod(problem, elements=20, throw=False)
    assert np.isnan(state.residual)
    assert not state.stable


@pytest.mark.parametrize(("status", "elements", "problem"), NO_ANSWERS)
def test_what_has_no_answer_has_a_status_that_says_why(status, elements, problem):
    state = solve_rod(problem, elements=elements, throw=False)
    assert state.status is (status or state.status)
    assert state.status is not RodStatus.CONVERGED
    assert not state.stable
    with pytest.raises(SolverError) as caught:
        solve_rod(problem, elements=elements)
    assert (caught.value.status, caught.value.iterations) == (state.status, state.iterations)
    assert state.status.value in str(caught.value)
    assert isinstance(caught.value.residual, float)
    if state.element is RodElement.MIXED:  # what is no answer is no start either
        with pytest.raises(InvalidInputError, match="start"):
            follow_rod([problem], start=state)
