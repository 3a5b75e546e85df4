# SPDX-License-Identifier: Apache-2.0
"""Many grips at once, and where the arm should hold the gripper."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from unittest.mock import Mock

import pytest
from core.recorded import recorded
from numpy import array, cross, eye, subtract
from numpy.testing import assert_allclose

from spiral_core import Closing, grip_cases, lay_into_coil, solve_cases
from spiral_core.grip import grip
from spiral_core.grip.grip import GripOutcome
from spiral_gripper import load_gripper

pytestmark = pytest.mark.long

SMOOTH = Closing.FRICTIONLESS
PLAIN = load_gripper("paper_design_70")


@pytest.mark.parametrize("parallel", [False, True])
def test_an_interrupted_study_goes_on(monkeypatch, parallel):
    """Known outcomes are kept; the others are solved, kept one by one, and stay in order."""
    kept, seen = {}, []
    said = lambda case: GripOutcome(f"{case.radius:g} {case.friction:g}")  # noqa: E731
    monkeypatch.setattr(grip, "solve_case", said)
    with ThreadPoolExecutor(2) as pool:
        outcomes = solve_cases(
            CASES,
            pool if parallel else None,
            lambda *progress: seen.append(progress),
            known={1: GripOutcome("known")},
            keep=kept.__setitem__,
        )
    assert [each.refusal for each in outcomes] == ["0.01 0.3", "known", "0.01 0.6", "0.02 0.6"]
    assert kept == {k: outcomes[k] for k in (0, 2, 3)}
    assert seen == [(2, 4), (3, 4), (4, 4)]


def test_a_study_that_fails_cancels_what_has_not_begun():
    pool = Mock()
    with pytest.raises(TypeError):
        solve_cases(CASES, pool, keep=len)
    assert pool.submit().cancel.called


# Without friction they take each gripper's own or the default.
CASES = grip_cases([PLAIN, replace(PLAIN, friction_coefficient=0.6)], [0.01, 0.02])


def test_a_case_keeps_its_window_and_forces_and_a_refusal_its_reason():
    cases = grip_cases([PLAIN], [0.025, 0.06], [0.3], closing=SMOOTH)
    recorded("study/outcomes", solve_cases(cases))


@pytest.mark.parametrize("beside", [True, False])
def test_an_object_moves_by_its_shift_and_tilt(beside):
    """Along the object, from the base square to it, and across both: its axis may meet the base."""
    setup = lay_into_coil(PLAIN, 0.025, closing=SMOOTH, elements=40)
    place, axis = setup.obstacle.position if beside else 0.1 * setup.axis, setup.axis
    setup = replace(setup, obstacle=replace(setup.obstacle, position=tuple(place)))
    frame, shift, tilt = setup.frame, (0.002, 0.004, -0.003), (0.05, -0.02)
    assert_allclose(frame @ frame.T, eye(3), atol=1e-12)
    assert_allclose(frame[0], axis)
    assert_allclose(frame[2] @ place, 0.0, atol=1e-12)
    assert (frame[1] @ place > 1e-3) == beside
    there = setup.moved(array((*shift, *tilt)))
    assert_allclose(frame @ subtract(there.obstacle.position, place), shift, atol=1e-12)
    # Turned a little about the second and the third of these directions.
    tipped = cross((0.0, *tilt), (1.0, 0.0, 0.0))
    assert_allclose(frame @ (there.axis - axis), tipped, atol=2e-3)
