# SPDX-License-Identifier: Apache-2.0
"""cosseratbench's scenarios are answered by the adapter, and judged by its own metrics."""

import math

import pytest
from cosseratbench.experiment import run
from cosseratbench.registry import load_experiment

from benchmarks.cosserat_adapter import SpiralSolver

pytestmark = pytest.mark.long

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
    # Not statics of one rod.
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
