# SPDX-License-Identifier: Apache-2.0
"""cosseratbench's scenarios are answered by the adapter, and judged by its own metrics."""

import math
from functools import partial

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
from benchmarks.hanging_cable import hanging_cable

pytestmark = pytest.mark.long

SOFT = Material(youngs_modulus=1e6, shear_modulus=3e5, density=1000.0)


def answer(name, **values):
    """Return the result of a variant, which must have been answered."""
    result = run(load_experiment(name), SpiralSolver(), values=values)
    assert result.outcome == "completed", (result.missing, result.failure)
    return result


@pytest.mark.parametrize(
    ("name", "values", "metric", "low", "high"),
    [
        # What is left is the reference's: it is linear.
        ("cantilever", {}, "tip_deflection_error", 3.9e-4, 4.3e-4),
        ("pendulum", {}, "period_error", 0.0, 1.3e-4),  # PyElastica: 1.37e-4
        ("pendulum", {}, "amplitude_change", -5e-6, 5e-6),  # PyElastica: 1e-5
        # Nothing slips: the rope rises by what its bending stiffness, absent from the start, takes.
        ("capstan", {"friction": 0.1, "overhang": 0.95}, "slide", 0.0, 2e-5),
        # Its elements are long for its tension: 3.1e-5 m, with four times as many 1.3e-5.
        ("capstan", {"friction": 0.6, "overhang": 0.95}, "slide", 0.0, 4e-5),
        ("capstan", {"friction": 0.1, "overhang": 1.1}, "slide", 0.05, math.inf),
    ],
)
def test_the_metric_of_a_scenario_is_as_good_as_its_reference(name, values, metric, low, high):
    assert low <= answer(name, **values).metrics[metric] <= high


@pytest.mark.parametrize("values", [{"youngs_modulus": 1e5}, {"span": 0.95}])
def test_cable_hangs_as_the_exact_elastica(values):
    result = answer("catenary", **values)
    (rod,) = load_experiment("catenary").scenario_for(**values).rods
    young, weight = rod.material.youngs_modulus, 9.81e3 * rod.area
    stiffness = young * rod.area, young * rod.second_moment_of_area
    exact = hanging_cable(*stiffness, weight, rod.length, rod.centerline[-1][0], count=50)
    off = np.linalg.norm(result.trajectory.positions[0][-1] - exact, axis=1)
    # cosseratbench asks for 50 elements; the shortest boundary layer at a support takes six.
    assert off.max() < 3e-5 * rod.length
    assert result.metrics["settling_residual"] == 0.0


@pytest.mark.parametrize("name", ["crossing", "pile", "twist"])
def test_what_is_not_statics_of_one_rod_is_declared_unsupported(name):
    result = run(load_experiment(name), SpiralSolver())
    assert result.outcome == "unsupported"
    assert result.missing


@pytest.mark.parametrize("length", [0.2, 0.02])
def test_a_beam_lies_on_a_plane_or_a_bar_that_is_long_enough(length):
    ends = ((0.0, 0.0, 0.0), (0.4, 0.0, 0.0))
    beam = Rod(ends, radius=0.01, material=SOFT, start=EndCondition.CLAMPED)
    floor = Plane((0.0, 0.0, -0.05), (0.0, 0.0, 2.0), friction=0.2)
    bar = Cylinder((0.2, 0.05, -0.03), (0.0, 1.0, 0.0), radius=0.015, length=length)
    scenario = Scenario((beam,), 1.0, (0.0, 0.0, -9.81), (floor, bar), quasi_static=True)
    solve = partial(SpiralSolver().run, scenario, n_elements=40, n_frames=2)
    if length < 0.1:
        with pytest.raises(NotImplementedError, match="end of a cylinder"):
            solve()
        return
    found = solve()
    (first, last), (start, directors) = found.positions[0], found.directors[0]
    assert np.array_equal(first, beam.nodes(40))
    assert np.array_equal(start, beam.directors(40))
    assert last[20, 2] > -0.02
    assert last[:, 2].min() == pytest.approx(-0.04, abs=1e-6)
    assert np.einsum("ij,ij->i", np.diff(last, axis=0), directors) == pytest.approx(0.0, abs=1e-12)
