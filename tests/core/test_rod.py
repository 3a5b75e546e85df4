# SPDX-License-Identifier: Apache-2.0
"""Choice of the element, few elements, breaks, statuses, reproducible results."""

from __future__ import annotations

import math
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, replace
from itertools import product
from multiprocessing import get_context

import numpy as np
import pytest
from core.contact_cases import bar, down, floor, line
from core.rod_cases import COUPLED, HELICAL, STRAIGHT, gripper_rod, round_rod
from numpy.linalg import norm

from spiral_core import (
    Clamped,
    Free,
    InvalidInputError,
    Pinned,
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
    rod = Rod(0.5, COUPLED, rest_strain=(-21.0, 0.0, 31.0))
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        other = pool.submit(solve_rod, rod, LOAD).result()
    for state in (solve_rod(rod, LOAD), solve_rod(rod, LOAD)):
        for each in (one.name for one in fields(state) if not one.name.startswith("_")):
            np.testing.assert_array_equal(getattr(state, each), getattr(other, each))


def test_what_the_fast_element_cannot_take_goes_to_the_mixed_one():
    plain = RodProblem(HELICAL, RodLoad((0.0, 0.02, 0.0)))
    rods = [
        replace(HELICAL, section=each)
        for each in (
            Section(COUPLED.stiffness, extension=100.0),
            Section(COUPLED.stiffness, shear=100.0),
            Section(((5e-4, 1e-4, 0), (1e-4, 4e-4, 0), (0, 0, 4e-4))),
            lambda s: np.tile(np.diag((5e-4, 4e-4, 4e-4, 90.0, 40.0, 40.0)), (len(s), 1, 1)),
        )
    ]
    asked = [
        plain,
        replace(plain, obstacles=(floor(-0.2),)),
        replace(plain, tip=Pinned((0.3, 0.0, 0.0))),
        replace(plain, base=Clamped((0.1, 0.0, 0.0))),
        replace(plain, point_loads=(PointLoad(0.1, force=(0.0, 0.0, 0.01)),)),
        *(replace(plain, rod=rod) for rod in (replace(HELICAL, radius=1e-3), *rods)),
    ]
    for problem in asked:
        start = line(0.36, 40) if problem is plain else None
        assert solve_rod(problem, elements=40, start=start).element is RodElement.MIXED
        with pytest.raises(InvalidInputError, match="element"):
            solve_rod(problem, start=start, element=RodElement.INEXTENSIBLE)


@pytest.mark.parametrize("parts", [2, 3, 6])
def test_equal_pieces_have_equally_many_elements(parts):
    """Whatever rounding makes of their lengths; an odd number of elements, many of them too."""
    for length, count in product((0.4, 0.28, 1.32), (None, (10_001 // parts | 1) * parts)):
        ends = [length * k / parts for k in range(parts + 1)]
        state = solve_rod(Rod(length, COUPLED, breaks=np.array(ends[1:-1])), elements=count)
        nodes = np.abs(state.arc_lengths - np.transpose([ends])).argmin(axis=1)
        assert len({*np.diff(nodes)}) == 1


@pytest.mark.parametrize(
    "profile",
    [
        lambda s: 1.0 + np.abs(s - 0.1234),
        lambda s: 1.5 + np.tanh((s - 0.15) / 0.01),
        lambda s: 1.0 + 0.5 * np.sin(60.0 * s),
    ],
)
def test_kinks_and_steep_slopes_are_not_jumps(profile):
    section = Section.varying(lambda s: 3e-4 * profile(s), 2e-4)
    rod = Rod(0.3, section, rest_strain=(-5.0, 0.0, 10.0))
    assert_estimated(*(solve_rod(rod, LOAD, elements=n) for n in (None, 2400)), 3.0)


def assert_estimated(state, exact, within):
    """Check a state's error, next to a state on many elements, against its estimate."""
    error = norm(state.tip_position - exact.tip_position)
    assert error < within * state.discretization_error + 1e-9
    return error


@pytest.mark.parametrize(
    ("elements", "turned"), [*product((2, 3, 5, 8), (0.5, 3.0, 8.0, 20.0, 1e99))]
)
def test_few_elements_are_honest(elements, turned):
    """Refused where an element turns too far, else an estimate that holds."""
    case = gripper_rod(curvature=turned / 0.36, torsion=0.4 * turned / 0.36)
    if math.hypot(1.0, 0.4) * turned > 2.0 * elements:
        with pytest.raises(InvalidInputError, match=r" \d{1,6}, for each to turn by 2 rad at most"):
            solve_rod(case, elements=elements)
        return
    state = solve_rod(case, elements=elements, throw=False)
    if state.status is RodStatus.UNRESOLVED:
        assert turned / elements > 0.9
        return
    error = assert_estimated(state, solve_rod(case, elements=240, start=state), 1.5)
    assert state.discretization_error < 10.0 * max(error, 1e-6)


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
        couples = coupling * min(torsional, bending)
        section = Section.inextensible(bending, torsional, bending * sideways, couples)
        other = solve_rod(replace(rod, section=section), load)
        assert len(other.arc_lengths) - 1 == pytest.approx(count, abs=2)


TUBE = Rod(0.4, Section((2e-4, 3e-4, 3e-4)), 3e-3)


def over_bar(z, load):
    """Return a tube and a bar across it at this height."""
    return RodProblem(TUBE, load, obstacles=(bar(0.03, 0.2, z),))


NO_ANSWERS = [
    (RodStatus.NOT_FINITE, 10, RodProblem(STRAIGHT, RodLoad(tip_force=(0.0, 1e300, 0.0)))),
    (None, 20, over_bar(-0.5, RodLoad(tip_force=(0.0, 1e200, 0.0)))),  # it overflows
    # Twisting a straight rod past its limit: no certificate, and the figures say so.
    (None, 40, RodProblem(STRAIGHT, RodLoad(tip_moment=(5e-3, 0.0, 0.0)))),
    # Elements that turn too far from end to end, and inside.
    *(
        (RodStatus.UNRESOLVED, 3, RodProblem(STRAIGHT, RodLoad(tip_force=force)))
        for force in ((-1.0, 0.01, 0.0), (0.0, 1.0, 0.0))
    ),
    (RodStatus.INSIDE_OBSTACLE, None, over_bar(-0.03, RodLoad())),
    (RodStatus.NOT_HELD, None, RodProblem(TUBE, down(1.0), base=Free())),
    (RodStatus.SELF_CONTACT, None, RodProblem(replace(TUBE, rest_strain=(0.0, 0.0, 120.0)))),
]


@pytest.mark.filterwarnings("ignore:.*encountered:RuntimeWarning")
@pytest.mark.parametrize(("status", "elements", "problem"), NO_ANSWERS)
def test_what_has_no_answer_has_a_status_that_says_why(status, elements, problem):
    """An overflow is no small residual."""
    state = solve_rod(problem, elements=elements, throw=False)
    assert state.status is (status or state.status)
    assert state.status is not RodStatus.CONVERGED
    assert not (state.residual < 1.0 and np.max(problem.load.tip_force) >= 1e200)
    with pytest.raises(SolverError) as caught:
        solve_rod(problem, elements=elements)
    assert (caught.value.status, caught.value.iterations) == (state.status, state.iterations)
    assert state.status.value in str(caught.value)
    if state.element is RodElement.MIXED:  # what is no answer is no start either
        with pytest.raises(InvalidInputError, match="start"):
            follow_rod([problem], start=state)
