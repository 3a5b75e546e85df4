# SPDX-License-Identifier: Apache-2.0
"""A 6x6 stiffness, which couples twist and bending with stretch and shear, against integration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import root

from benchmarks.contact_paths import imbalance
from spiral_core import (
    Inertia,
    InvalidInputError,
    Rod,
    RodLoad,
    RodProblem,
    Section,
    solve_motion,
)
from spiral_core.rod.contact.solve import solve_contact

pytestmark = pytest.mark.long

Array = NDArray[np.float64]
LENGTH = 0.5
REST = (2.0, 1.0, -4.0)
LOAD = RodLoad((2e-3, 1e-3, -8e-3), (2e-3, 3e-3, -1e-3), (2e-4, -1e-4, 3e-4))


def six(strength: float) -> Array:
    """Return a full stiffness: of a rod as soft in stretch as coils and bellows are."""
    bending = np.array(((3e-4, 2e-5, -1e-5), (2e-5, 2e-4, 3e-5), (-1e-5, 3e-5, 4e-4)))
    stretch = np.array(((1.0, 0.05, -0.1), (0.05, 0.5, 0.04), (-0.1, 0.04, 0.8)))
    between = strength * np.array(((8, 2, -3), (2, -3, 4), (-5, 2, 3))) * 1e-3
    return np.block([[bending, between], [between.T, stretch]])


def rows(matrix: Array) -> tuple[tuple[float, ...], ...]:
    """Return a matrix as sections are written with."""
    return tuple(tuple(row) for row in matrix.tolist())


def integrated(matrix: Array, load: RodLoad) -> Array:
    """Return the tip's position of a clamped rod, by shooting for the base's moment.

    Kirchhoff's equations with all six strains from the inverse stiffness, to 1e-11: no code, no
    elements and no coordinates of orientation in common with the solver.
    """
    inverse, force = np.linalg.inv(matrix), np.asarray(load.tip_force)
    scaled = np.zeros(3)

    def change(s: float, y: Array, part: float) -> Array:
        frame, moment = y[3:12].reshape(3, 3), y[12:]
        inner = frame.T @ (force + np.asarray(load.distributed) * (LENGTH - s)) * part
        strains = inverse @ np.concatenate((moment, inner))
        u, v = strains[:3] + REST, strains[3:] + np.array((1.0, 0.0, 0.0))
        turning = frame @ np.array(((0, -u[2], u[1]), (u[2], 0, -u[0]), (-u[1], u[0], 0)))
        twisting = -np.cross(u, moment) - np.cross(v, inner)
        return np.concatenate((frame @ v, turning.ravel(), twisting))

    def shot(moment: Array, part: float) -> Array:
        start = np.concatenate((np.zeros(3), np.eye(3).ravel(), moment))
        tight = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
        return solve_ivp(change, (0.0, LENGTH), start, args=(part,), **tight).y[:, -1]

    def miss(scaled: Array, part: float) -> Array:
        tip = shot(1e-3 * scaled, part)
        return 1e3 * (tip[3:12].reshape(3, 3) @ tip[12:] - part * np.asarray(load.tip_moment))

    for part in (0.25, 0.5, 0.75, 1.0):
        scaled = root(miss, scaled, (part,), tol=1e-12).x
    assert np.abs(miss(scaled, 1.0)).max() < 1e-8
    return shot(1e-3 * scaled, 1.0)[:3]


def solved(matrix: Array, load: RodLoad, elements: int) -> Array:
    """Return the tip's position from the solver."""
    rod = Rod(LENGTH, Section(rows(matrix)), rest_strain=REST)
    state = solve_contact(RodProblem(rod, load), elements=elements)
    assert state.stable
    return state.tip_position


@pytest.mark.parametrize("strength", [1.0, -0.6])
@pytest.mark.parametrize("load", [LOAD, RodLoad(tip_force=(8e-3, 0.0, 3e-3))], ids=["all", "tip"])
def test_coupled_rod_is_the_integrated_one_to_fourth_order(strength: float, load: RodLoad) -> None:
    exact = integrated(six(strength), load)
    errors = [np.linalg.norm(solved(six(strength), load, n) - exact) for n in (16, 32, 64)]
    uncoupled = solved(six(0.0), load, 64)
    assert np.linalg.norm(uncoupled - exact) > 5e-3 * LENGTH  # the coupling counts
    assert errors[-1] < 1e-6 * LENGTH
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders.min() > 3.5


def test_zero_coupling_is_the_section_of_parts() -> None:
    matrix = np.diag((2e-4, 3e-4, 5e-4, 2.0, 1.5, 1.5))
    parts = Section((2e-4, 3e-4, 5e-4), extension=2.0, shear=1.5)
    rod = Rod(LENGTH, parts, rest_strain=REST)
    state = solve_contact(RodProblem(rod, LOAD), elements=20)
    np.testing.assert_allclose(solved(matrix, LOAD, 20), state.tip_position, atol=1e-12)


def test_pulled_rod_twists_by_its_coupling() -> None:
    """Straight: strains are the inverse stiffness times the load; a helix of fibers twists so."""
    matrix = np.diag((2e-4, 3e-4, 3e-4, 40.0, 20.0, 20.0))
    matrix[0, 3] = matrix[3, 0] = 0.03
    force, moment = 2.0, 1e-4
    rod = Rod(LENGTH, Section(rows(matrix)))
    load = RodLoad(tip_force=(force, 0.0, 0.0), tip_moment=(moment, 0.0, 0.0))
    state = solve_contact(RodProblem(rod, load), elements=10)
    twist, stretch = np.linalg.solve(matrix[::3, ::3], (moment, force))
    assert state.tip_position[0] == pytest.approx(LENGTH * (1.0 + stretch), rel=1e-9)
    half = 0.5 * (twist * LENGTH % math.tau)
    assert np.abs(state.orientations[-1, 0]) == pytest.approx(np.abs(np.sin(half)), rel=1e-3)
    assert max(imbalance(RodProblem(rod, load), state)) < 1e-9


def test_section_may_couple_more_along_the_rod() -> None:
    """A coupling that grows evenly twists by its mean, to second order in the stiffness."""
    force, grown = 2.0, 6e-3

    def section(s: np.ndarray) -> np.ndarray:
        matrices = np.tile(np.diag((2e-4, 3e-4, 3e-4, 40.0, 20.0, 20.0)), (len(s), 1, 1))
        matrices[:, 0, 3] = matrices[:, 3, 0] = grown * s / LENGTH
        return matrices

    load = RodLoad(tip_force=(force, 0.0, 0.0))
    state = solve_contact(RodProblem(Rod(LENGTH, section), load), elements=40)
    twist = -0.5 * grown / 40.0 * force / 2e-4 * LENGTH
    assert 2.0 * np.arcsin(state.orientations[-1, 0]) == pytest.approx(twist, rel=5e-3)


def test_parts_of_a_section_are_those_of_its_matrix() -> None:
    """At given forces: the condensed stiffness, the compliance, and the moment by the force."""
    matrix = six(1.0)
    section = Section(rows(matrix))
    inverse = np.linalg.inv(matrix)
    stiffness, compliance, coupling = section.parts
    np.testing.assert_allclose(np.linalg.inv(stiffness), inverse[:3, :3], rtol=1e-9)
    np.testing.assert_allclose(compliance, np.linalg.inv(matrix[3:, 3:]), rtol=1e-12)
    np.testing.assert_allclose(-stiffness @ inverse[:3, 3:], coupling, rtol=1e-9)
    assert not Section((1.0, 2.0, 3.0)).parts[2].any()


def test_motion_of_a_coupled_rod_is_refused() -> None:
    """At its start, and when a section becomes one."""
    coupled = RodProblem(Rod(LENGTH, Section(rows(six(1.0)))))
    plain = RodProblem(Rod(LENGTH, Section(rows(six(0.0)))))
    for first, later in ((coupled, coupled), (plain, coupled)):
        with pytest.raises(InvalidInputError, match=r"section.*couple bending with stretch"):
            solve_motion(
                lambda t, a=first, b=later: b if t > 0.0 else a,
                Inertia(1e-2, 1e-8),
                (0.0, 0.01),
                elements=8,
            )
