# SPDX-License-Identifier: Apache-2.0
"""Positions and moments from orientations: closed forms, duality with the energy, balance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.rod_cases import Case, gripper_rod
from scipy.spatial.transform import Rotation

from spiral_core import Rod, RodLoad, RodState, Section, solve_rod
from spiral_core.rod._element import strain_factor
from spiral_core.rod._shape import arc_shortening
from spiral_core.rod._system import discrete_strain_scale

VARIED = Case(
    Rod(
        0.4,
        Section.varying(lambda s: 2.5e-4 * (1.0 + 0.5 * s), lambda s: 1.7e-4 * (1.0 - 0.8 * s)),
        rest_strain=lambda s: np.column_stack((-12.0 + 9.0 * s, 3.0 * s, 22.0 - 20.0 * s)),
    ),
    RodLoad(
        distributed=lambda s: np.column_stack((0.2 + 0.3 * s, 0.1 * s, -0.2 + s * s)),
        tip_force=(0.01, -0.02, 0.015),
        tip_moment=(1e-4, 2e-4, -2e-4),
    ),
)
CASES = {
    "hanging": gripper_rod(),
    "tilted": gripper_rod(length=0.5, gravity=(0.3, -0.8, 0.52), tip_force=(0.02, 0.01, 0.0)),
    "varied": VARIED,
}


def base_moments(state: RodState) -> np.ndarray:
    """Return the moments in the base frame."""
    turned: np.ndarray = Rotation.from_quat(state.orientations).apply(np.array(state.moments))
    return turned


def weight(case: Case, sites: np.ndarray) -> np.ndarray:
    """Return the distributed load at arc lengths (n, 3)."""
    w = case.load.distributed
    return w(sites) if callable(w) else np.tile(w, (len(sites), 1))


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 0.1, 0.19, 0.21, 0.5, 1.5, 3.0])
def test_the_chord_of_an_arc(angle: float) -> None:
    sine = math.sin(0.5 * angle)
    shortening = arc_shortening(sine * sine) * sine * sine
    chord = sine / (0.5 * angle) if angle else 1.0
    # Where the series is used, below z = 0.1, it leaves out 35/1152 z^8 of the element's length.
    left_out = 35.0 / 1152.0 * sine**8 if sine < 0.1 else 0.0
    assert 1.0 - shortening == pytest.approx(chord, abs=1.1 * left_out + 1e-15)
    assert arc_shortening(sine * sine) == pytest.approx(1.0 / 6.0, abs=0.05 + 0.1 * angle**2)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-5, 0.3, 1.0, 2.5])
def test_rest_strain_goes_through_the_elements_series(angle: float) -> None:
    scale = discrete_strain_scale(angle)
    sine = math.sin(0.5 * angle)
    factor = strain_factor(sine * sine)[0]
    assert scale * angle == pytest.approx(2.0 * factor * sine, rel=1e-14)
    # 1.0 is approached as the first term left out, 35/1152 z^8, and the ones after it.
    assert 1.0 - 0.1 * sine**8 <= scale <= 1.0 + 1e-15


@pytest.mark.parametrize("name", CASES)
def test_neighboring_elements_agree_on_the_moment(name: str) -> None:
    """The momentum at an inner node is the same from either side: that is equilibrium."""
    case = CASES[name]
    state = solve_rod(case.rod, case.load, elements=60)
    moments = base_moments(state)
    np.testing.assert_allclose(moments[-1], case.load.tip_moment, atol=1e-11)
    # The discrete balance of moments is Simpson-like: m_i - m_i+1 = integral of t x n.
    h = state.arc_lengths[1]
    t, n = state.tangents, state.forces
    bent = np.einsum(
        "ijk,ik->ij", Rotation.from_quat(state.orientations).as_matrix(),
        np.cross(state.strains, [1.0, 0.0, 0.0]),
    )  # fmt: skip
    w = weight(case, state.arc_lengths)
    torque = np.cross(t, n)
    slope = np.cross(bent, n) - np.cross(t, w)
    step = 0.5 * h * (torque[:-1] + torque[1:]) + h * h / 12.0 * (slope[:-1] - slope[1:])
    # The Hermite rule's own error is h^5 / 720 per element, about 1e-5 of the largest moment.
    np.testing.assert_allclose(moments[:-1] - moments[1:], step, atol=1e-5 * np.abs(moments).max())


@pytest.mark.parametrize("name", CASES)
def test_forces_and_moments_balance_at_every_node(name: str) -> None:
    """m + p x n falls by the moment of the weight: m' = -p' x n and n' = -w, integrated."""
    case = CASES[name]
    errors = []
    for elements in (60, 120):
        state = solve_rod(case.rod, case.load, elements=elements)
        s, p, n = state.arc_lengths, state.positions, state.forces
        w = weight(case, s)
        h = s[1]
        # Euler-Maclaurin at every node, so that the quadrature is of fourth order too.
        moment = np.cross(p, w)
        slope = np.cross(state.tangents, w)
        slope += np.cross(p, np.gradient(w, s, axis=0, edge_order=2))
        parts = 0.5 * h * (moment[:-1] + moment[1:]) + h * h / 12.0 * (slope[:-1] - slope[1:])
        beyond = np.vstack((np.cumsum(parts[::-1], axis=0)[::-1], np.zeros(3)))
        total = base_moments(state) + np.cross(p, n)
        miss = total - total[-1] - (beyond - np.cross(0.0 * p, n))
        errors.append(np.abs(miss).max() / np.abs(state.moments).max())
        weight_step = 0.5 * h * (w[:-1] + w[1:])
        # The trapezoidal rule for a load that varies quadratically.
        np.testing.assert_allclose(n[:-1] - n[1:], weight_step, atol=h**3)
    # The scheme's order is four: a fifteenth of 3e-5 or so when the elements are halved.
    assert errors[0] < 1e-4
    assert errors[1] < errors[0] / 10.0


@pytest.mark.parametrize("name", ["hanging", "tilted"])
def test_the_tip_is_the_energys_derivative_by_the_force(name: str) -> None:
    """Castigliano: at equilibrium dE/dF = -p(L); to the scheme's order, since p is its dual."""
    case = CASES[name]
    errors = []
    for elements in (48, 96):
        d = 1e-4
        derivative = np.empty(3)
        state = solve_rod(case.rod, case.load, elements=elements)
        for k in range(3):
            energies = []
            for sign in (-1.0, 1.0):
                force = list(case.load.tip_force)
                force[k] += sign * d
                load = RodLoad(case.load.distributed, (force[0], force[1], force[2]))
                near = solve_rod(
                    case.rod, load, elements=elements, start=state, estimate_error=False
                )
                energies.append(near.energy)
            derivative[k] = (energies[1] - energies[0]) / (2.0 * d)
        errors.append(np.linalg.norm(derivative + state.tip_position) / case.rod.length)
    # Finite differences of a minimum: d^2 times the third derivative leaves 1e-6 or so.
    assert errors[0] < 1e-4
    assert errors[1] < 5e-6


def test_strains_are_those_of_the_moments() -> None:
    state = solve_rod(VARIED.rod, VARIED.load, elements=60)
    s = state.arc_lengths
    kt, kb = 1.7e-4 * (1.0 - 0.8 * s), 2.5e-4 * (1.0 + 0.5 * s)
    rest = np.column_stack((-12.0 + 9.0 * s, 3.0 * s, 22.0 - 20.0 * s))
    stiffness = np.column_stack((kt, kb, kb))
    np.testing.assert_allclose(state.moments, stiffness * (state.strains - rest), atol=1e-15)


def test_tangents_are_the_orientations_first_axis() -> None:
    state = solve_rod(VARIED.rod, VARIED.load, elements=40)
    matrices = Rotation.from_quat(state.orientations).as_matrix()
    np.testing.assert_allclose(state.tangents, matrices[:, :, 0], atol=1e-14)
    np.testing.assert_array_equal(state.tip_position, state.positions[-1])
