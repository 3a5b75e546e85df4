# SPDX-License-Identifier: Apache-2.0
"""Many grips at once, and where the arm should hold the gripper."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from numpy.testing import assert_allclose

from spiral_core import (
    Closing,
    grip_cases,
    lay_into_coil,
    solve_cases,
)
from spiral_core.grip import grip
from spiral_core.grip.grip import GripOutcome
from spiral_core.grip.places import moved
from spiral_gripper import load_gripper

pytestmark = pytest.mark.long

SMOOTH = Closing.FRICTIONLESS
PLAIN = load_gripper("paper_design_70")


def test_cases_are_every_combination_in_order():
    """Without friction they take each gripper's own or the default, without gravity its mount."""
    cases = grip_cases([PLAIN], [0.01, 0.02], [0.1, 0.3], [(9.8, 0.0, 0.0), (0.0, 0.0, 9.8)])
    found = [(case.radius, case.friction, case.gripper.gravity[0]) for case in cases]
    assert found == [(r, f, g) for r in (0.01, 0.02) for f in (0.1, 0.3) for g in (9.8, 0.0)]
    rough = replace(PLAIN, friction_coefficient=0.6)
    found = grip_cases([PLAIN, rough], [0.01], closing=SMOOTH)
    assert [case.friction for case in found] == [0.3, 0.6]


@pytest.mark.parametrize("parallel", [False, True])
def test_an_interrupted_study_goes_on(monkeypatch, parallel):
    """Known outcomes are kept; the others are solved, kept one by one, and stay in order."""
    solved, kept, seen = [], {}, []

    def solve(case):
        solved.append(case.radius)
        return GripOutcome(f"{case.radius:g}")

    monkeypatch.setattr(grip, "solve_case", solve)
    before = {1: GripOutcome("known")}
    with ThreadPoolExecutor(2) as pool:
        outcomes = solve_cases(
            grip_cases([PLAIN], [0.01, 0.02, 0.03], [0.3]),
            pool if parallel else None,
            lambda *progress: seen.append(progress),
            known=before,
            keep=kept.__setitem__,
        )
    assert [outcome.refusal for outcome in outcomes] == ["0.01", "known", "0.03"]
    assert sorted(solved) == [0.01, 0.03]
    assert sorted(kept) == [0, 2]
    assert seen == [(2, 3), (3, 3)]


HELD_AND_REFUSED = list(grip_cases([PLAIN], [0.025, 0.06], [0.3], closing=SMOOTH))


@pytest.mark.slow
def test_a_study_gives_the_same_in_another_process():
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        assert solve_cases(HELD_AND_REFUSED, pool) == solve_cases(HELD_AND_REFUSED)


def test_a_case_keeps_its_window_and_forces_and_a_refusal_its_reason():
    kept: dict[int, GripOutcome] = {}
    outcomes = solve_cases(HELD_AND_REFUSED, keep=kept.__setitem__)
    assert kept == dict(enumerate(outcomes))
    held, refused = outcomes
    assert held.refusal == ""
    assert held.onset_wrap < held.pressure < held.loss
    assert held.away > held.towards > 0.0
    assert "too thick" in refused.refusal
    assert refused.away is None


def test_an_object_moves_by_its_shift_and_tilt():
    """Along the object, from the base square to it, and across both."""
    setup = lay_into_coil(PLAIN, 0.025, closing=SMOOTH, elements=40)
    frame, shift, tilt = setup.frame, (0.002, 0.004, -0.003), (0.05, -0.02)
    place, axis = setup.obstacle.position, setup.axis
    across = np.cross(axis, frame[1])
    assert_allclose(frame, (axis, frame[1], across), atol=1e-12)
    assert np.linalg.norm(across) == pytest.approx(1.0)
    assert place @ frame[1] > 0.0 == pytest.approx(place @ across)
    there = moved(setup, np.array((*shift, *tilt)))
    step = np.subtract(there.obstacle.position, place)
    assert_allclose(frame @ step, shift, atol=1e-12)
    # Turned a little about the second and the third of these directions.
    tipped = np.cross((0.0, *tilt), (1.0, 0.0, 0.0))
    assert_allclose(frame @ (there.axis - axis), tipped, atol=2e-3)
