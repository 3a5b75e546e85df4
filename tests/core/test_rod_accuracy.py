# SPDX-License-Identifier: Apache-2.0
"""Order, error estimate, and agreement with shooting from the tip (``reference_shooting``)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.reference_shooting import Rods, Shapes, continue_from_rest, shoot
from core.rod_cases import Case, gripper_rod, random_direction

from spiral_core import Rod, RodLoad, RodState, Section, solve_rod

pytestmark = pytest.mark.long

SITES = np.array([0.0, 0.5, 1.0])


def torsional(s: np.ndarray) -> np.ndarray:
    """Return GJ along the varied rod."""
    return 1.7e-4 * (1.0 - 0.9 * s)


def bending(s: np.ndarray) -> np.ndarray:
    """Return EI along the varied rod."""
    return 2.5e-4 * (1.0 + 0.4 * np.sin(9.0 * s))


def rest_strain(s: np.ndarray) -> np.ndarray:
    """Return u* along the varied rod."""
    return np.column_stack((-12.0 + 9.0 * s, 4.0 * np.sin(7.0 * s), 22.0 - 25.0 * s))


def distributed(s: np.ndarray) -> np.ndarray:
    """Return w along the varied rod."""
    return np.column_stack((0.2 + 0.3 * np.cos(8.0 * s), 0.3 * s, -0.2 + s * s))


VARIED = Case(
    Rod(0.4, Section.varying(bending, torsional), rest_strain=rest_strain),
    RodLoad(distributed, tip_force=(0.01, -0.02, 0.015), tip_moment=(3e-4, 2e-4, -5e-4)),
)
CASES = {
    "weight": gripper_rod(gravity=(0.3, 0.8, -0.52)),
    "tip force": gripper_rod(gravity=(0.0, 0.0, 0.0), tip_force=(0.03, -0.04, 0.05)),
    "tip moment": gripper_rod(tip_moment=(5e-4, 1e-3, -2.5e-4)),
    "varied": VARIED,
}


def as_rods(cases: list[Case]) -> Rods:
    """Return uniform rods as the reference wants them."""
    return Rods(
        np.array([c.rod.length for c in cases]),
        np.array([c.rod.section.stiffness for c in cases]),
        np.array([c.rod.rest_strain for c in cases]),
        np.array([c.load.distributed for c in cases]),
        np.array([c.load.tip_force for c in cases]),
        np.array([c.load.tip_moment for c in cases]),
    )


def varied_rods() -> Rods:
    """Return the varied rod as the reference wants it."""

    def at(x: float) -> np.ndarray:
        return np.array([0.4 * x])

    return Rods(
        np.array([0.4]),
        lambda x: np.column_stack((torsional(at(x)), bending(at(x)), bending(at(x)))),
        lambda x: rest_strain(at(x)),
        lambda x: distributed(at(x)),
        np.array([VARIED.load.tip_force]),
        np.array([VARIED.load.tip_moment]),
    )


def reference(name: str) -> Shapes:
    """Return the reference's shape of a named case."""
    case = CASES[name]
    guess = solve_rod(case.rod, case.load, elements=40, estimate_error=False)
    rods = varied_rods() if name == "varied" else as_rods([case])
    shape = shoot(rods, guess.orientations[-1:], SITES)
    assert shape.miss.max() < 1e-9
    return shape


def distance(state: RodState, shape: Shapes, row: int = 0) -> float:
    """Return the largest distance of middle and tip from the reference, over the length."""
    middle = len(state.positions) // 2
    miss = state.positions[[middle, -1]] - shape.positions[row, 1:]
    return float(np.linalg.norm(miss, axis=1).max() / state.arc_lengths[-1])


@pytest.mark.parametrize("name", CASES)
def test_order_is_four_in_positions_orientations_moments_and_strains(name: str) -> None:
    case, shape = CASES[name], reference(name)
    moment_scale = np.abs(shape.moments[0]).max()
    rows = []
    for elements in (40, 80, 160):
        state = solve_rod(case.rod, case.load, elements=elements, estimate_error=False)
        ends = [0, elements // 2, elements]
        sign = np.sign(np.sum(state.orientations[ends] * shape.orientations[0], axis=1))
        rows.append(
            [
                distance(state, shape),
                np.abs(sign[:, None] * state.orientations[ends] - shape.orientations[0]).max(),
                np.abs(state.moments[ends] - shape.moments[0]).max() / moment_scale,
            ]
        )
    errors = np.array(rows)
    assert errors[0].max() < 1e-4
    # Measured: 3.94 to 4.12; the rest is the next term of the error's expansion.
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders.min() > 3.9
    assert orders.max() < 4.2
    assert errors[1, 0] < 1e-6  # the tip, with 80 elements


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("elements", [30, 60, 120])
def test_the_error_estimate_is_honest(name: str, elements: int) -> None:
    """Within a factor of 2.5 of the true error: what asymptotics on a coarse grid can promise."""
    case, shape = CASES[name], reference(name)
    state = solve_rod(case.rod, case.load, elements=elements)
    assert state.discretization_error is not None
    ratio = state.discretization_error / (case.rod.length * distance(state, shape))
    assert 1.0 / 2.5 < ratio < 2.5


@pytest.mark.parametrize("name", CASES)
def test_the_energy_is_of_fourth_order(name: str) -> None:
    case = CASES[name]
    energies = [
        solve_rod(case.rod, case.load, elements=n, estimate_error=False).energy
        for n in (60, 120, 240, 960)
    ]
    errors = np.abs(np.array(energies[:3]) - energies[3])
    orders = np.log2(errors[:-1] / errors[1:])
    # The finest of them stands in for the exact energy.
    assert orders.min() > 3.7  # a zero of the error is not far for the tip force
    assert orders.max() < 4.3


def test_an_error_estimate_is_made_only_when_asked_for() -> None:
    case = CASES["weight"]
    assert solve_rod(case.rod, case.load, estimate_error=False).discretization_error is None


def random_rods(count: int, seed: int) -> list[Case]:
    """Return gripper-sized rods on tilted mounts."""
    rng = np.random.default_rng(seed)
    cases = []
    for _ in range(count):
        curvature = rng.uniform(5.0, 60.0)
        cases.append(
            gripper_rod(
                length=rng.uniform(0.15, 1.0),
                modulus=rng.uniform(0.6e6, 3.0e6),
                curvature=curvature,
                torsion=rng.uniform(-0.9, 0.9) * curvature,
                gravity=random_direction(rng),
            )
        )
    return cases


def test_forty_random_rods_agree_with_shooting() -> None:
    """The requirement is 1e-3 of the length; the elements are chosen for about 1e-5 of it."""
    cases = random_rods(40, seed=11)
    states = [solve_rod(case.rod, case.load) for case in cases]
    assert all(state.stable for state in states)
    guesses = np.array([state.orientations[-1] for state in states])
    shapes = shoot(as_rods(cases), guesses, SITES)
    # Where the weight presses a long rod together the base reacts a million times to its tip, so
    # that the integrator's 1e-13 leaves 2e-10 or so.
    assert shapes.miss.max() < 1e-8
    errors = np.array([distance(state, shapes, i) for i, state in enumerate(states)])
    # Measured: 2.9e-5 at worst, at one of the smallest numbers of elements, and 2e-6 at the median.
    assert errors.max() < 5e-5
    assert np.median(errors) < 5e-6
    estimates = np.array([state.discretization_error or np.inf for state in states])
    lengths = np.array([case.rod.length for case in cases])
    ratios = estimates / (lengths * errors)
    # Honest: a factor of 3 where errors cross zero between the sites that are compared.
    assert ratios.min() > 1.0 / 3.0
    moments = [
        np.abs(s.moments[0] - shapes.moments[i, 0]).max() / np.abs(shapes.moments[i]).max()
        for i, s in enumerate(states)
    ]
    # Moments follow from the curvature's error, ten times the position's.
    assert max(moments) < 2e-4


def test_shooting_on_its_own_finds_the_same() -> None:
    """The reference continued from the unloaded helix, knowing nothing of the solver's answer."""
    rng = np.random.default_rng(12)
    cases = [
        gripper_rod(
            length=rng.uniform(0.15, 0.4),
            modulus=rng.uniform(1.0e6, 3.0e6),
            curvature=(curvature := rng.uniform(5.0, 40.0)),
            torsion=rng.uniform(-0.9, 0.9) * curvature,
            gravity=random_direction(rng),
        )
        for _ in range(12)
    ]
    shapes = continue_from_rest(as_rods(cases), steps=5, sites=SITES)
    assert shapes.miss.max() < 1e-8
    for i, case in enumerate(cases):
        state = solve_rod(case.rod, case.load)
        assert state.stable
        assert distance(state, shapes, i) < 2e-5  # the elements are chosen for 1e-5


def test_the_chosen_elements_grow_with_the_rods_turning() -> None:
    counts = [
        len(solve_rod(case.rod, case.load, estimate_error=False).arc_lengths) - 1
        for case in (gripper_rod(length=0.36), gripper_rod(length=0.9, torsion=-20.0))
    ]
    for count, strain, length in zip(
        counts, (math.hypot(21.0, 13.5), 29.0), (0.36, 0.9), strict=True
    ):
        assert count % 2 == 0
        assert count == pytest.approx(length * strain / 0.25, abs=4.0)
