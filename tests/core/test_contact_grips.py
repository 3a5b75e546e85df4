# SPDX-License-Identifier: Apache-2.0
"""Random grips are certified and in balance; the judge sees what is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.grips import faults, grip_one, random_grip
from spiral_core import follow_contact


@pytest.mark.slow
@pytest.mark.parametrize("index", range(6))
def test_random_grip_is_certified(index: int) -> None:
    assert grip_one(index).verdict == "certified"


def test_judge_sees_forces_that_do_not_balance() -> None:
    stations = random_grip(3).stations()
    state = follow_contact(stations).states[-1]
    assert faults(stations[-1], state) == []
    lighter = replace(state, contact_forces=0.99 * state.contact_forces)
    assert {"force", "moment"} <= set(faults(stations[-1], lighter))
    sunk = state.positions + np.array([0.0, 1e-3, 0.0])
    assert "penetration" in faults(stations[-1], replace(state, positions=sunk))
    assert "not stable" in faults(stations[-1], replace(state, smallest_pivot=-1.0))
