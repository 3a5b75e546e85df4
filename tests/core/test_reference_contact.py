# SPDX-License-Identifier: Apache-2.0
"""The closed forms of contact fulfill the equations they solve, integrated or differentiated."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.reference_contact import (
    Section,
    cantilever_over_cylinder,
    helix_in_tube,
    helix_on_cylinder,
    holding_overhang,
    lift_off_angle,
    relaxed_angle,
    thick_capstan_exponent,
    thick_holding_overhang,
)
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

SECTION = Section(bending=2.5e-4, torsional=1.7e-4, curvature=40.0, torsion=-22.0)
RHO = 0.0205
ANGLE = -1.1  # left-handed, as the torsion is


def frenet(rho: float, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Return arc lengths, and positions, t, N, b of a helix (4, n, 3)."""
    s = np.linspace(0.0, 2.0 * math.pi * rho / abs(math.sin(angle)), 20_001)
    phi = s * math.sin(angle) / rho
    zero, one = np.zeros_like(s), np.ones_like(s)
    around = np.stack((-np.sin(phi), np.cos(phi), zero), axis=1)
    inward = np.stack((-np.cos(phi), -np.sin(phi), zero), axis=1)
    up = np.stack((zero, zero, one), axis=1)
    tangent = math.sin(angle) * around + math.cos(angle) * up
    position = -rho * inward + (s * math.cos(angle))[:, None] * up
    return s, np.stack((position, tangent, inward, np.cross(tangent, inward)))


def slope(values: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Return the derivative, without the two ends where the difference is one-sided."""
    return np.gradient(values, s, axis=0)[1:-1]


@pytest.mark.parametrize("tension", [None, 0.2, -0.1])
def test_wrapped_helix_is_in_balance(tension: float | None) -> None:
    helix = helix_on_cylinder(SECTION, RHO, ANGLE, tension)
    s, (position, t, inward, b) = frenet(RHO, ANGLE)
    force = helix.tension * t + helix.binormal_force * b
    moment = helix.axial_moment * t + helix.binormal_moment * b
    # A difference with 20,000 steps a turn leaves 1e-8 of it.
    left = slope(force, s) - helix.line_force * inward[1:-1]
    assert np.abs(left).max() < 1e-6 * np.abs(slope(force, s)).max()
    left = slope(moment, s) + np.cross(t, force)[1:-1]
    assert np.abs(left).max() < 1e-6 * np.abs(slope(moment, s)).max()
    about_axis = moment[:, 2] + np.cross(position, force)[:, 2]
    assert np.ptp(about_axis) < 1e-9 * np.abs(moment).max()


def test_relaxed_helix_needs_nobody_at_its_ends_and_has_the_least_energy() -> None:
    angle = relaxed_angle(SECTION, RHO, ANGLE)
    helix = helix_on_cylinder(SECTION, RHO, angle)
    _, (position, t, _, b) = frenet(RHO, angle)
    force = helix.tension * t + helix.binormal_force * b
    moment = helix.axial_moment * t + helix.binormal_moment * b
    assert abs(force[0, 2]) < 1e-12
    assert abs((moment + np.cross(position, force))[0, 2]) < 1e-12 * SECTION.bending / RHO

    def energy(theta: float, rho: float = RHO) -> float:
        sin, cos = math.sin(theta), math.cos(theta)
        bent, twisted = sin * sin / rho - SECTION.curvature, sin * cos / rho - SECTION.torsion
        return 0.5 * SECTION.bending * bent**2 + 0.5 * SECTION.torsional * twisted**2

    least = minimize_scalar(energy, bracket=(angle - 0.1, angle + 0.1), tol=1e-12)
    assert least.x == pytest.approx(angle, abs=1e-6)  # the root of a parabola's floor
    # The cylinder's force does the work that winds the helix wider.
    change = (energy(angle, RHO * 1.0001) - energy(angle, RHO * 0.9999)) / (2e-4 * RHO)
    assert helix.line_force == pytest.approx(change, rel=1e-6)


@pytest.mark.parametrize("angle", [0.02, 0.3, 0.9])
def test_buckled_rod_pushes_the_tube_outward(angle: float) -> None:
    bending, rho = 0.3, 0.01
    push, line_force = helix_in_tube(bending, rho, angle)
    straight = Section(bending, torsional=1.0)
    sin, cos = math.sin(angle), math.cos(angle)
    # Without torque in the rod: take the twist out of the section's rest torsion.
    untwisted = Section(bending, 1.0, torsion=sin * cos / rho)
    tension = -bending * sin**2 * (1.0 + cos**2) / rho**2
    helix = helix_on_cylinder(untwisted, rho, angle, tension)
    assert helix.axial_moment == 0.0
    assert helix.line_force == pytest.approx(-line_force, rel=1e-12)
    _, (position, t, _, b) = frenet(rho, angle)
    force = helix.tension * t[0] + helix.binormal_force * b[0]
    assert force[2] == pytest.approx(-push, rel=1e-12)
    about_axis = helix.binormal_moment * b[0] + np.cross(position[0], force)
    assert abs(about_axis[2]) < 1e-12 * straight.bending / rho
    if angle < 0.1:  # of relative order theta^2
        assert angle**2 == pytest.approx(push * rho**2 / (2.0 * bending), rel=1e-3)
        assert line_force == pytest.approx(rho * push**2 / (4.0 * bending), rel=1e-3)


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.6])
def test_thick_rope_on_a_capstan(friction: float) -> None:
    """Balance along and across with the moment of friction, integrated from any start."""
    rho, r_o = 0.051, 0.006
    a = r_o / rho

    def balance(phi: float, state: np.ndarray, weight: float) -> list[float]:
        tension, line_force = state
        shear = -a * friction * line_force
        along = shear + friction * line_force + weight * math.cos(phi)
        across = -tension + line_force - weight * math.sin(phi)
        return [along, across / (-a * friction)]

    exponent = thick_capstan_exponent(friction, rho, r_o)
    tight = {"method": "Radau", "rtol": 1e-10, "atol": 1e-12}
    sites = [0.0, 3.0, 6.0]
    for begin in (1.0, 0.7):  # a boundary layer as wide as the rope fades
        found = solve_ivp(balance, (0.0, 6.0), [1.0, begin], t_eval=sites, args=(0.0,), **tight).y
        assert math.log(found[0, 2] / found[0, 1]) == pytest.approx(3.0 * exponent, rel=1e-7)
    assert thick_capstan_exponent(friction, rho, 1e-9) == pytest.approx(friction, rel=1e-6)

    long = thick_holding_overhang(friction, rho, r_o, short=0.15)
    # From 1 rad before, where the layer of any start has faded at 0; the tension there is linear
    # in the one at the start.
    ends = [
        solve_ivp(balance, (-1.0, math.pi), [y, y], t_eval=[0.0, math.pi], args=(1.0,), **tight).y[
            0
        ]
        for y in (1.0, 5.0)
    ]
    share = (0.15 / rho - ends[0][0]) / (ends[1][0] - ends[0][0])
    assert rho * (ends[0][1] + share * (ends[1][1] - ends[0][1])) == pytest.approx(long, rel=1e-7)
    thin = thick_holding_overhang(friction, rho, 1e-9, short=0.15)
    assert thin == pytest.approx(holding_overhang(friction, rho, 0.15), rel=1e-6)


def test_rod_lifts_off_toward_its_asymptote() -> None:
    bending, rho, tension = 1.3, 0.4, 6.0
    psi = lift_off_angle(bending, rho, tension)
    # theta'' = F / EI sin(theta), theta from the asymptote; unstable, so not far.
    free = solve_ivp(
        lambda _, y: [y[1], tension / bending * math.sin(y[0])],
        (0.0, 4.0), [psi, -1.0 / rho], method="DOP853", rtol=1e-12, atol=1e-14,
    ).y[:, -1]  # fmt: skip
    assert np.abs(free).max() < 1e-3 * psi
    small = lift_off_angle(1e-6 * bending, rho, tension)
    assert small == pytest.approx(math.sqrt(1e-6 * bending / tension) / rho, rel=1e-5)


def test_cantilever_over_a_cylinder_sinks_by_the_closed_form_where_it_is_flat() -> None:
    bending, length, rho, force = 1.0, 1.0, 100.0, 0.03
    free, (x, z) = cantilever_over_cylinder(bending, length, rho, force)
    assert free == pytest.approx(bending / (force * rho), rel=1e-3)
    flat = length**2 / (2.0 * rho) - bending**2 / (6.0 * force**2 * rho**3)
    assert -z == pytest.approx(flat, rel=1e-3)
    assert x == pytest.approx(1.0, abs=1e-4)
