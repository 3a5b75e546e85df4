# SPDX-License-Identifier: Apache-2.0
"""cosseratbench's scenarios are answered by the adapter, and judged by its own metrics."""

import re
from dataclasses import replace

import numpy as np
import pytest
from cosseratbench.experiment import run
from cosseratbench.registry import load_experiment
from cosseratbench.scenario import (
    Cylinder,
    End,
    EndCondition,
    Material,
    Motion,
    Plane,
    PointLoad,
    Rod,
    Scenario,
)

from benchmarks.cosserat_adapter import SpiralSolver, problem_of
from benchmarks.hanging_cable import hanging_cable
from spiral_core.rod.contact.solve import solve_contact

pytestmark = pytest.mark.long

SOFT = Material(youngs_modulus=1e6, shear_modulus=3e5, density=1000.0)
BEAM = Rod(((0.0, 0.0, 0.0), (0.4, 0.0, 0.0)), radius=0.01, material=SOFT)
CLAMPED = replace(BEAM, start=EndCondition.CLAMPED)
DOWN = (0.0, 0.0, -9.81)
CATENARIES = [{"youngs_modulus": 1e5}, {"youngs_modulus": 1e7}, {"span": 0.6}, {"span": 0.95}]


def answer(name, **values):
    """Return the result of a variant, which must have been answered."""
    result = run(load_experiment(name), SpiralSolver(), values=values)
    assert result.outcome == "completed", (result.missing, result.failure)
    return result


def answer_to(*rods, **scenario):
    """Return the nodes of the last frame."""
    posed = Scenario(rods, 1.0, **({"quasi_static": True} | scenario))
    return SpiralSolver().run(posed, n_elements=40, n_frames=2).positions[0][-1]


def test_cantilever_bends_as_a_beam():
    """What is left is the reference's: it is linear."""
    assert answer("cantilever").metrics["tip_deflection_error"] == pytest.approx(4.1e-4, abs=2e-5)


@pytest.mark.parametrize("values", CATENARIES)
def test_cable_hangs_as_the_exact_elastica(values):
    result = answer("catenary", **values)
    (rod,) = load_experiment("catenary").scenario_for(**values).rods
    exact = hanging_cable(
        rod.material.youngs_modulus * rod.area,
        rod.material.youngs_modulus * rod.second_moment_of_area,
        9.81e3 * rod.area,
        rod.length,
        rod.centerline[-1][0],
        count=50,
    )
    off = np.linalg.norm(result.trajectory.positions[0][-1] - exact, axis=1)
    # cosseratbench asks for 50 elements; the shortest boundary layer at a support takes six.
    assert off.max() < 3e-5 * rod.length
    assert result.metrics["settling_residual"] == 0.0


@pytest.mark.parametrize(
    ("friction", "overhang", "most"),
    [
        # Nothing slips: the rope rises by what its bending stiffness, absent from the start, takes.
        *((friction, overhang, 2e-5) for friction in (0.1, 0.3) for overhang in (0.5, 0.95)),
        # Its elements are long for its tension: 3.1e-5 m, with four times as many 1.3e-5.
        (0.6, 0.95, 4e-5),
        (0.1, 1.1, None),
        (0.6, 1.5, None),
    ],
)
def test_rope_on_a_cylinder_is_held_or_slides(friction, overhang, most):
    result = answer("capstan", friction=friction, overhang=overhang)
    if most is None:
        assert result.metrics["slide"] > 0.05
    else:
        assert result.metrics["slide"] < most
        # At the start, between whose points cosseratbench interpolates.
        assert result.observations["max_penetration"] < 1e-2


@pytest.mark.parametrize("friction", [0.1, 0.6])
def test_settled_rope_moves_no_more(friction):
    """What it slides is the way from the scenario's start, not creep."""
    scenario = load_experiment("capstan").scenario_for(friction=friction, overhang=0.98)
    (rod,) = scenario.rods
    nodes = rod.nodes(100)
    problem = problem_of(scenario, nodes, rod.directors(100))
    settled = here = solve_contact(problem, start=nodes, elements=100)
    for _ in range(100):
        here = solve_contact(problem, start=here)
    assert np.abs(here.positions - settled.positions).max() < 1e-9 * rod.length


def test_the_pendulum_swings_as_linear_theory_has_it():
    metrics = answer("pendulum").metrics
    assert metrics["period_error"] < 1.3e-4  # PyElastica: 1.37e-4
    assert abs(metrics["amplitude_change"]) < 5e-6  # PyElastica: 1e-5


@pytest.mark.parametrize("name", ["crossing", "pile", "twist"])
def test_what_is_not_statics_of_one_rod_is_declared_unsupported(name):
    result = run(load_experiment(name), SpiralSolver())
    assert result.outcome == "unsupported"
    assert result.missing


def test_first_frame_is_the_start_and_directors_stay_across():
    bent = replace(
        CLAMPED,
        centerline=tuple(
            (0.1 * np.cos(a), 0.1 * np.sin(a), 0.05 * a) for a in np.linspace(0.0, 2.0, 30)
        ),
        radius=0.004,
    )
    scenario = Scenario((bent,), 1.0, gravity=DOWN, quasi_static=True)
    trajectory = SpiralSolver().run(scenario, n_elements=30, n_frames=4)
    (positions,), (directors,) = trajectory.positions, trajectory.directors
    assert np.array_equal(trajectory.times, np.linspace(0.0, 1.0, 4))
    np.testing.assert_array_equal(positions[0], bent.nodes(30))
    np.testing.assert_array_equal(directors[0], bent.directors(30))
    chords = np.diff(positions[-1], axis=0)
    assert np.abs(np.sum(chords * directors[-1], axis=1)).max() < 1e-12
    np.testing.assert_allclose(np.linalg.norm(directors[-1], axis=1), 1.0, rtol=1e-12)
    # The clamp holds its director; the rod springs straight along its first element.
    assert directors[-1][0] @ directors[0][0] > 0.99
    assert np.ptp(positions[-1][:, 2]) < 0.2
    # Without cosseratbench's loop where the rod is planar.
    flat = load_experiment("capstan").scenario
    first = SpiralSolver().run(flat, n_elements=20, n_frames=2).directors[0][0]
    np.testing.assert_allclose(first, flat.rods[0].directors(20), atol=1e-9)


def test_loads_and_clamps_at_either_end():
    """The mirrored beam bends as the beam."""
    force = (0.0, 0.0, -2e-3)
    one = answer_to(replace(CLAMPED, loads=(PointLoad(force, End.END),)))
    mirrored = replace(BEAM, end=EndCondition.CLAMPED, loads=(PointLoad(force, End.START),))
    assert one[-1, 2] < -1e-3
    back = answer_to(mirrored)[::-1] * [-1.0, 1.0, 1.0] + [0.4, 0.0, 0.0]
    np.testing.assert_allclose(back, one, atol=1e-9)


def test_rod_rests_on_a_plane_and_on_a_cylinder_that_is_long_enough():
    floor = Plane((0.0, 0.0, -0.02), (0.0, 0.0, 2.0), friction=0.2)
    nodes = answer_to(CLAMPED, gravity=DOWN, obstacles=(floor,))
    assert nodes[:, 2].min() == pytest.approx(-0.01, abs=1e-6)
    bar = Cylinder((0.2, 0.05, -0.03), (0.0, 1.0, 0.0), radius=0.015, length=0.2)
    assert answer_to(CLAMPED, gravity=DOWN, obstacles=(bar,))[20, 2] > -0.02
    with pytest.raises(NotImplementedError, match="end of a cylinder"):
        answer_to(CLAMPED, gravity=DOWN, obstacles=(replace(bar, length=0.02),))


DRIVEN = Motion((0.0, 1.0), ((0, 0, 0), (0, 0, 1)), ((0, 0, 0),) * 2)


@pytest.mark.parametrize(
    ("rods", "quasi_static", "what"),
    [
        ((BEAM,), False, "contact of a rod with itself"),
        ((BEAM, BEAM), True, "several rods"),
        ((replace(CLAMPED, start_motion=DRIVEN),), True, "ends that are driven"),
    ],
)
def test_refusals_say_what_is_not_modeled(rods, quasi_static, what):
    with pytest.raises(NotImplementedError, match=re.escape(what)):
        answer_to(*rods, quasi_static=quasi_static)
