# SPDX-License-Identifier: Apache-2.0
"""A rod that could go to either side goes to one of them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from spiral_core import Clamped, Obstacle, Rod, RodLoad, RodProblem, Section, Sphere
from spiral_core.rod.contact.solve import solve_contact

pytestmark = pytest.mark.long


@pytest.mark.parametrize(
    ("turn", "lean"),
    [
        (Rotation.identity(), 0.0),
        (Rotation.from_rotvec((0.4, -1.1, 2.0)), 0.0),
        (Rotation.identity(), -1e-9),
    ],
)
def test_column_under_its_weight_falls_towards_the_y_axis_of_its_sections(
    turn: Rotation, lean: float
) -> None:
    """Nothing else says to which side: neither rounding does, nor a weight that leans by as much.

    A rough ball that stands on the other side is not met.
    """
    rod = Rod(0.5, Section((1e-3, 1e-3, 1e-3)), 2e-3)
    x, y, z = turn.apply(np.array((-1.0, 0.6 * lean, lean))).tolist()
    ball = Obstacle(Sphere(0.03), tuple(turn.apply((0.2, -0.1, 0.0)).tolist()), friction=0.3)
    base = Clamped((0.0, 0.0, 0.0), tuple(turn.as_quat().tolist()))
    problem = RodProblem(rod, RodLoad((x, y, z)), base=base, obstacles=(ball,))
    state = solve_contact(problem, elements=40)
    assert state.stable
    tip = turn.inv().apply(state.tip_position)
    # Once fallen, nothing resists its turning about the base's axis.
    assert tip[1] > 0.9 * math.hypot(tip[1], tip[2])
    assert tip[1] > 0.1


@pytest.mark.parametrize("side", [(0.0, 1.0, 0.0), (0.0, -0.6, -0.8)])
def test_column_that_is_bent_falls_to_the_side_to_which_it_is_bent(
    side: tuple[float, float, float],
) -> None:
    """From a pressure that bends the tube, however little, and from a tilt alike."""
    rod = Rod(0.5, Section((1e-3, 1e-3, 1e-3)), 2e-3)
    _, y, z = side
    bent = replace(rod, rest_strain=(0.0, -1e-3 * z, 1e-3 * y))
    leaning = RodLoad((-1.0, 1e-4 * y, 1e-4 * z))
    for problem in (RodProblem(bent, RodLoad((-1.0, 0.0, 0.0))), RodProblem(rod, leaning)):
        tip = solve_contact(problem, elements=40).tip_position
        assert float(tip @ side) > 0.1
        assert math.hypot(tip[1], tip[2]) == pytest.approx(float(tip @ side), rel=1e-4)


def test_rod_on_top_of_a_ball_falls_beside_it() -> None:
    ball = Obstacle(Sphere(0.03), (0.2, 0.0, -0.05))
    rod = Rod(0.4, Section((1e-3, 1e-3, 1e-3)), 2e-3)
    problem = RodProblem(rod, RodLoad((0.0, 0.0, -3.0)), obstacles=(ball,))
    state = solve_contact(problem, elements=60)
    assert state.stable
    assert not state.touching.any()
    assert state.tip_position[2] < -0.35
