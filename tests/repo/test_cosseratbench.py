# SPDX-License-Identifier: Apache-2.0
"""cosseratbench's scenarios are answered by the adapter, and judged by its own metrics."""

import math

import numpy as np
import pytest
from cosseratbench.experiment import run
from cosseratbench.registry import load_experiment
from cosseratbench.scenario import (
    Cylinder,
    EndCondition,
    Material,
    Plane,
    Rod,
    Scenario,
)

from benchmarks.cosserat_adapter import SpiralSolver

pytestmark = pytest.mark.long

SOFT = Material(youngs_modulus=1e6, shear_modulus=3e5, density=1000.0)


# A scenario, its changed values, and the most of its metrics.
SCENARIOS = [
    # What is left is the reference's: it is linear; the catenary neglects bending.
    ("cantilever", {}, {"tip_deflection_error": 4.3e-4}),
    ("catenary", {"span": 0.95}, {"shape_error": 4.05e-4, "settling_residual": 0.0}),
    # PyElastica: 1.37e-4 and 1e-5.
    ("pendulum", {}, {"period_error": 1.3e-4, "amplitude_change": 5e-6}),
    # Nothing slips: the rope rises by what its bending stiffness, absent from the start, takes.
    ("capstan", {"friction": 0.1, "overhang": 0.95}, {"slide": 2e-5}),
    ("capstan", {"friction": 0.1, "overhang": 1.1}, {"slide": math.inf}),
    # These are not statics of one rod.
    ("crossing", {}, {}),
    ("twist", {}, {}),
]


@pytest.mark.parametrize(("name", "values", "most"), SCENARIOS)
def test_the_metrics_of_a_scenario_are_as_good_as_its_reference(name, values, most):
    result = run(load_experiment(name), SpiralSolver(), values=values)
    assert result.outcome == ("completed" if most else "unsupported"), result.failure
    assert bool(result.missing) != bool(most)
    for metric, high in most.items():
        assert abs(result.metrics[metric]) <= high, metric
    assert name != "capstan" or (result.metrics["slide"] > 0.05) == (values["overhang"] > 1.0)


def test_a_beam_lies_on_a_plane_and_a_bar_unless_it_touches_the_bars_end():
    ends = ((0.0, 0.0, 0.0), (0.4, 0.0, 0.0))
    beam = Rod(ends, radius=0.01, material=SOFT, start=EndCondition.CLAMPED)

    def lying(length):
        floor = Plane((0.0, 0.0, -0.05), (0.0, 0.0, 2.0), friction=0.2)
        bar = Cylinder((0.2, 0.05, -0.03), (0.0, 1.0, 0.0), radius=0.015, length=length)
        scenario = Scenario((beam,), 1.0, (0.0, 0.0, -9.81), (floor, bar), quasi_static=True)
        return SpiralSolver().run(scenario, n_elements=40, n_frames=2)

    found = lying(0.2)
    _, last = found.positions[0]
    assert last[20, 2] > -0.02
    assert last[:, 2].min() == pytest.approx(-0.04, abs=1e-6)
    across = (np.diff(last, axis=0) * found.directors[0][1]).sum(axis=1)
    assert across == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(NotImplementedError, match="end of a cylinder"):
        lying(0.02)
