# SPDX-License-Identifier: Apache-2.0
"""The perfect wrap: there and back, its closed form without weight, regimes, what is refused."""

from dataclasses import astuple
from math import atan2, copysign, cos, hypot, pi, sin, sqrt

import numpy as np
import pytest
from core.actuator_cases import derivative
from core.gripper_cases import DESIGNS, PRESSURE_MAX
from core.recorded import recorded, said
from core.wrap_cases import OUTER_RADIUS, TILTED, G, linear_curve, paper_curve
from numpy.testing import assert_allclose, assert_array_equal

from spiral_core import Section, WrapRegime
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.wrap.curve import RADIUS_TOLERANCE
from spiral_core.wrap.wrap import PERFECT_BAND, line_force

MOUNTS = {
    "hanging": [],
    "tilted": [(0.8 * G, -0.36 * G, 0.48 * G)],
    "given axis": [(G, 0.0, 0.0), (1.0, 0.0, 0.0)],
    "tilted about a given axis": [TILTED, (1.0, 0.0, 0.0)],
}


@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize("name", DESIGNS)
def test_radius_to_pressure_to_radius(name, mount):
    """Many questions, and in another order, have the same answers to the last bit."""
    curve = paper_curve(name, *MOUNTS[mount])
    assert 0.0 < curve.pressure_min < curve.pressure_max <= PRESSURE_MAX
    inside = [
        radius
        for radius in np.linspace(curve.radius_min, curve.radius_max, 33)
        if not any(low < radius < high for low, high in curve.gaps)
    ]
    assert len(inside) > 28
    wraps = [curve.wrap_for_radius(radius) for radius in inside]
    pressures = np.array([wrap.pressure for wrap in wraps])
    assert_array_equal([curve.pressure_from_radius(radius) for radius in inside], pressures)
    assert_allclose([curve.radius_from_pressure(each) for each in pressures], inside, 1e-6)
    for radius, wrap in zip(inside, wraps, strict=True):
        contact = radius + OUTER_RADIUS
        assert abs(wrap.object_radius - radius) <= 2.0 * RADIUS_TOLERANCE * contact
        assert wrap.state.stable
        # The bisection for where the required turns begin ends at 1e-10 of the pressure limit.
        assert wrap.turns >= 1.05 - 1e-6
    if "axis" not in mount:  # else the radius rises and falls with pressure
        assert np.diff(pressures).max() < 0.0
        # Where the curve begins at its largest radius it is flat.
        assert_allclose(pressures[[0, -1]], (curve.pressure_max, curve.pressure_min), 1e-3)


def test_without_weight_the_wrap_is_the_helix():
    for torsion in [-25.0, 12.0]:
        curvature, length = 50.0, 0.5
        curve = linear_curve(curvature=curvature, torsion=torsion, length=length)
        # r_w = rho - r_o with rho = kappa / (kappa^2 + tau^2), everything proportional to pressure.
        rate = hypot(curvature, torsion)
        needed = 1.05 * 2.0 * pi / length
        assert_allclose(curve.pressure_min, 1.0e5 * needed / rate, 1e-6)
        assert curve.pressure_max == 1.0e5
        for x in (needed / rate * 1.001, 0.6, 1.0):
            wrap = curve.wrap_at_pressure(1.0e5 * x)
            rho = curvature / (x * rate**2)
            one = 1.05 * 2.0 * pi / (x * rate)
            # The fitted axis of sampled tangents is right to the elements' order, 1e-7 or so.
            found = wrap.object_radius, wrap.turns, wrap.helix_angle
            angle = atan2(curvature, abs(torsion))
            assert_allclose(found, (rho - OUTER_RADIUS, 1.05 * length / one, angle), 1e-6)
            lengths = wrap.gripper_length_needed, wrap.object_length_needed
            assert_allclose(lengths, (one, one * abs(torsion) / rate), 1e-5)
            assert wrap.contact_length == length
            found = astuple(wrap.unloaded_shape)[:3]
            assert_allclose(found, (curvature * x, torsion * x, length), 1e-12)
        few = curve.wrap_at_pressure(0.5 * curve.pressure_min)
        assert few.gripper_length_needed is few.object_length_needed is None


def test_the_tip_curves_freely_and_fits_the_cylinder():
    """The formula against the shape itself: no moment at the tip, sin^2 / kappa."""
    wrap = paper_curve().wrap_for_radius(0.02)
    shape, state = wrap.unloaded_shape, wrap.state
    assert_allclose(state.strains[-1], [shape.torsion, 0.0, shape.curvature], atol=1e-6)
    sine = np.linalg.norm(np.cross(state.tangents[-1], wrap.coil.axis))
    assert_allclose(sine**2 / shape.curvature - OUTER_RADIUS, 0.02, 1e-7)


def test_the_three_regimes():
    curve = paper_curve("70 degrees")
    radius = sqrt(curve.radius_min * curve.radius_max)
    perfect = curve.pressure_from_radius(radius)
    # The band is about the radius: just inside and just outside of it.
    tight, tighter, wider = (
        curve.pressure_from_radius(radius * (1.0 + share * PERFECT_BAND))
        for share in (-0.9, -1.1, 1.1)
    )
    for regime, *pressures in (
        (WrapRegime.PERFECT_WRAP, perfect, tight),
        (WrapRegime.OVERHANG, 0.0, wider),
        (WrapRegime.CURLING, tighter, min(1.2 * perfect, PRESSURE_MAX)),
    ):
        # Told from a state that is known already it is the same, without another solve.
        for pressure in pressures:
            known = curve.state_at_pressure(pressure)
            assert {curve.regime(pressure, radius, state) for state in (None, known)} == {regime}
    few_turns = curve.regime(0.9999 * curve.pressure_min, curve.radius_max)
    assert few_turns is WrapRegime.OVERHANG
    wrong = (perfect, 10.0 * curve.radius_max), (-1.0, radius)
    recorded("range/regimes", [said(curve.regime, *given) for given in wrong])


def test_a_coil_that_closes_on_itself_ends_the_range_and_past_it_the_tip_curls():
    """Where rho reaches the tube's own radius nothing fits inside any more."""
    curve = linear_curve(curvature=250.0, torsion=-30.0)
    assert_allclose(curve.radius_min, 1e-3 * OUTER_RADIUS, 1e-3)
    closes = 250.0 / (250.0**2 + 30.0**2) / OUTER_RADIUS / 1.001
    assert_allclose(curve.pressure_max, 1.0e5 * closes, 1e-5)
    heavy = linear_curve(curvature=250.0, torsion=-30.0, weight=0.24)
    for share in (0.01, 0.3, 1.0):
        pressure = heavy.pressure_max + share * (heavy.gripper.pressure_max - heavy.pressure_max)
        assert heavy.regime(pressure, heavy.radius_max) is WrapRegime.CURLING


@pytest.mark.parametrize("torsion", [-15.0, 15.0])
@pytest.mark.parametrize("coupling", [0.0, 1.5e-4, -1.0e-4])
def test_the_line_force_is_the_energys_slope(torsion, coupling):
    """Squeezing the cylinder by d(rho) gives back the energy q d(rho) per length of rod."""
    stiffness = Section.inextensible(3.0e-4, 2.0e-4, coupling=coupling)
    shape, radius, angle = UnloadedShape(40.0, torsion, 0.4), 0.02, 1.2
    sine, cosine = sin(angle), copysign(cos(angle), torsion)

    @np.vectorize
    def energy(rho):
        coiled = np.array([cosine, 0.0, sine]) * sine / rho - [torsion, 0.0, shape.curvature]
        return 0.5 * coiled @ np.array(stiffness.matrix) @ coiled

    forces = [line_force(stiffness, shape, radius, at, OUTER_RADIUS) for at in (angle, pi - angle)]
    slope = derivative(energy, radius + OUTER_RADIUS, 1e-5)
    assert_allclose(forces, [slope, slope], 1e-6)
    assert slope > 0.0
