# SPDX-License-Identifier: Apache-2.0
"""cosseratbench's scenarios are answered by the adapter, and judged by its own metrics."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from cosseratbench.experiment import Experiment, Result, run
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
CATENARIES = [
    {}, {"youngs_modulus": 1e5}, {"youngs_modulus": 1e7}, {"span": 0.6}, {"span": 0.95}
]  # fmt: skip


def answer(experiment: Experiment | str, **values: float) -> Result:
    """Return the result of a variant, which must have been answered."""
    if isinstance(experiment, str):
        experiment = load_experiment(experiment)
    result = run(experiment, SpiralSolver(), values=values)
    assert result.outcome == "completed", (result.missing, result.failure)
    return result


def answer_to(scenario: Scenario, elements: int = 40) -> np.ndarray:
    """Return the nodes of the last frame."""
    return SpiralSolver().run(scenario, n_elements=elements, n_frames=2).positions[0][-1]


def test_cantilever_bends_as_a_beam() -> None:
    """What is left is the reference's: it is linear."""
    assert answer("cantilever").metrics["tip_deflection_error"] == pytest.approx(4.1e-4, abs=2e-5)


@pytest.mark.parametrize("values", CATENARIES)
def test_cable_hangs_as_the_exact_elastica(values: dict[str, float]) -> None:
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
    "values",
    [{"friction": f, "overhang": o} for f in (0.1, 0.3) for o in (0.5, 0.8, 0.95)],
)
def test_rope_on_a_cylinder_is_held(values: dict[str, float]) -> None:
    result = answer("capstan", **values)
    # Nothing slips: the rope rises by what its bending stiffness, absent from the start, takes.
    assert result.metrics["slide"] < 2e-5
    # At the start, between whose points cosseratbench interpolates.
    assert result.observations["max_penetration"] < 1e-2


@pytest.mark.parametrize("overhang", [0.5, 0.8, 0.95])
def test_heavy_rope_is_held_by_much_friction(overhang: float) -> None:
    """Its elements are long for its tension: 3.1e-5 m at 0.95, with four times as many 1.3e-5."""
    assert answer("capstan", friction=0.6, overhang=overhang).metrics["slide"] < 4e-5


@pytest.mark.parametrize("overhang", [0.95, 0.98])
@pytest.mark.parametrize("friction", [0.1, 0.6])
def test_settled_rope_moves_no_more(friction: float, overhang: float) -> None:
    """What it slides is the way from the scenario's start, not creep."""
    scenario = load_experiment("capstan").scenario_for(friction=friction, overhang=overhang)
    (rod,) = scenario.rods
    nodes = rod.nodes(100)
    problem = problem_of(scenario, nodes, rod.directors(100))
    settled = here = solve_contact(problem, start=nodes, elements=100)
    for _ in range(100):
        here = solve_contact(problem, start=here)
    assert np.abs(here.positions - settled.positions).max() < 1e-9 * rod.length


@pytest.mark.parametrize(
    "values", [{"friction": f, "overhang": o} for f in (0.1, 0.3, 0.6) for o in (1.1, 1.5)]
)
def test_rope_on_a_cylinder_slides(values: dict[str, float]) -> None:
    assert answer("capstan", **values).metrics["slide"] > 0.05


@pytest.mark.parametrize("name", ["crossing", "pile", "twist"])
def test_what_is_not_statics_of_one_rod_is_declared_unsupported(name: str) -> None:
    result = run(load_experiment(name), SpiralSolver())
    assert result.outcome == "unsupported"
    assert result.missing


def test_first_frame_is_the_start_and_directors_stay_across() -> None:
    bent = Rod(
        tuple((0.1 * np.cos(a), 0.1 * np.sin(a), 0.05 * a) for a in np.linspace(0.0, 2.0, 30)),
        radius=0.004,
        material=SOFT,
        start=EndCondition.CLAMPED,
    )
    scenario = Scenario((bent,), 1.0, gravity=(0.0, 0.0, -9.81), quasi_static=True)
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
    assert np.ptp(positions[-1] @ np.array([0.0, 0.0, 1.0])) < 0.2


def test_straight_or_planar_rod_starts_with_cosseratbenchs_directors() -> None:
    for name in ("cantilever", "catenary", "capstan"):
        (rod,) = load_experiment(name).scenario.rods
        first = SpiralSolver().run(load_experiment(name).scenario, n_elements=20, n_frames=2)
        np.testing.assert_allclose(first.directors[0][0], rod.directors(20), atol=1e-9)


def test_loads_and_clamps_at_either_end() -> None:
    """The mirrored beam bends as the beam."""
    loaded = replace(
        BEAM, start=EndCondition.CLAMPED, loads=(PointLoad((0.0, 0.0, -2e-3), End.END),)
    )
    mirrored = replace(
        BEAM, end=EndCondition.CLAMPED, loads=(PointLoad((0.0, 0.0, -2e-3), End.START),)
    )
    one = answer_to(Scenario((loaded,), 1.0, quasi_static=True))
    other = answer_to(Scenario((mirrored,), 1.0, quasi_static=True))
    assert one[-1, 2] < -1e-3
    np.testing.assert_allclose(other[::-1] * [-1.0, 1.0, 1.0] + [0.4, 0.0, 0.0], one, atol=1e-9)


def test_rod_rests_on_a_plane() -> None:
    fallen = replace(BEAM, start=EndCondition.CLAMPED)
    floor = Plane((0.0, 0.0, -0.02), (0.0, 0.0, 2.0), friction=0.2)
    nodes = answer_to(Scenario((fallen,), 1.0, (0.0, 0.0, -9.81), (floor,), quasi_static=True))
    assert nodes[:, 2].min() == pytest.approx(-0.01, abs=1e-6)


def test_contact_past_the_end_of_a_cylinder_is_refused() -> None:
    beam = replace(BEAM, start=EndCondition.CLAMPED)
    for length, refused in ((0.2, False), (0.02, True)):
        bar = Cylinder((0.2, 0.05, -0.03), (0.0, 1.0, 0.0), radius=0.015, length=length)
        scenario = Scenario((beam,), 1.0, (0.0, 0.0, -9.81), (bar,), quasi_static=True)
        if refused:
            with pytest.raises(NotImplementedError, match="end of a cylinder"):
                answer_to(scenario)
        else:
            assert answer_to(scenario)[20, 2] > -0.02


@pytest.mark.parametrize(
    ("scenario", "what"),
    [
        (Scenario((BEAM,), 1.0), "contact of a rod with itself"),
        (Scenario((BEAM, BEAM), 1.0, quasi_static=True), "several rods"),
        (
            Scenario(
                (
                    replace(
                        BEAM,
                        start=EndCondition.CLAMPED,
                        start_motion=Motion((0.0, 1.0), ((0, 0, 0), (0, 0, 1)), ((0, 0, 0),) * 2),
                    ),
                ),
                1.0,
                quasi_static=True,
            ),
            "ends that are driven",
        ),
    ],
)
def test_refusals_say_what_is_not_modeled(scenario: Scenario, what: str) -> None:
    with pytest.raises(NotImplementedError, match=re.escape(what)):
        answer_to(scenario)


def test_the_pendulum_swings_as_linear_theory_has_it() -> None:
    result = run(load_experiment("pendulum"), SpiralSolver())
    assert result.outcome == "completed"
    assert result.metrics["period_error"] < 1.3e-4  # PyElastica: 1.37e-4
    assert abs(result.metrics["amplitude_change"]) < 5e-6  # PyElastica: 1e-5
