# SPDX-License-Identifier: Apache-2.0
"""How many files a reader opens to follow one computation, counted by tracing it."""

from __future__ import annotations

import pytest
from repo.tracing import files_entered

from spiral_core import WrapCurve, solve_rod
from spiral_gripper import load_gripper

GRIPPER = load_gripper("paper_design_70")
RADIUS = 0.02


@pytest.fixture(scope="module")
def curve() -> WrapCurve:
    return WrapCurve(GRIPPER)


def test_a_solve_enters_few_files() -> None:
    shape = GRIPPER.unloaded_shape(3.0e4)
    rod, load = GRIPPER.rod(shape), GRIPPER.load(shape)
    assert 3 <= len(files_entered(lambda: solve_rod(rod, load))) <= 6


def test_a_wrap_enters_few_files(curve: WrapCurve) -> None:
    assert 5 <= len(files_entered(lambda: curve.wrap_for_radius(RADIUS))) <= 12
