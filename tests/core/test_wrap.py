# SPDX-License-Identifier: Apache-2.0
"""The perfect wrap: there and back, its closed form without weight, regimes, what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.gripper_cases import DESIGNS, PRESSURE_MAX, linear_gripper, paper_gripper

from spiral_core import (
    InvalidInputError,
    NoCoilError,
    NotGrippableError,
    Section,
    WrapCurve,
    WrapRegime,
)
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.wrap.wrap import PERFECT_BAND, line_force

G = 9.80665
MOUNTS = {
    "hanging": ((G, 0.0, 0.0), None),
    "tilted": ((0.8 * G, -0.36 * G, 0.48 * G), None),
    "given axis": ((G, 0.0, 0.0), (1.0, 0.0, 0.0)),
}
OUTER_RADIUS = 4.7625e-3 + 0.79375e-3


@pytest.fixture(scope="module")
def curves() -> dict[str, WrapCurve]:
    """Return the curves of the paper's grippers, hanging."""
    return {name: WrapCurve(paper_gripper(name)) for name in DESIGNS}


@pytest.mark.parametrize("magnitude", [1e10, 1e300])
def test_a_gravity_that_cannot_be_is_refused_at_once(magnitude: float) -> None:
    with pytest.raises(InvalidInputError, match="elements must be at most 20000"):
        WrapCurve(paper_gripper("P1", (magnitude, 0.0, 0.0)))


@pytest.mark.parametrize("length", [361.0, 1000.0])
def test_millimeters_taken_for_meters_are_refused_at_once(length: float) -> None:
    gripper = linear_gripper(length=length)
    with pytest.raises(InvalidInputError, match=r"length must be at most [\d.]+ m, so that no"):
        WrapCurve(gripper)


@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize("name", DESIGNS)
def test_radius_to_pressure_to_radius(name: str, mount: str) -> None:
    gravity, axis = MOUNTS[mount]
    curve = WrapCurve(paper_gripper(name, gravity, axis))
    assert 0.0 < curve.radius_min < curve.radius_max
    assert 0.0 < curve.pressure_min < curve.pressure_max <= PRESSURE_MAX
    inside = [
        radius
        for radius in np.linspace(curve.radius_min, curve.radius_max, 33).tolist()
        if not any(low < radius < high for low, high in curve.gaps)
    ]
    assert len(inside) > 28
    pressures = []
    for radius in inside:
        wrap = curve.wrap_for_radius(radius)
        assert wrap.object_radius == pytest.approx(radius, rel=1e-7)
        assert curve.radius_from_pressure(wrap.pressure) == pytest.approx(radius, rel=1e-6)
        assert wrap.state.stable
        # The bisection for where the required turns begin ends at 1e-10 of the pressure limit.
        assert wrap.turns >= 1.05 - 1e-6
        pressures.append(wrap.pressure)
    if axis is not None:  # the radius rises and falls with pressure
        return
    assert np.diff(pressures).max() < 0.0
    assert curve.pressure_from_radius(curve.radius_min) == pytest.approx(
        curve.pressure_max, rel=1e-6
    )
    assert curve.pressure_from_radius(curve.radius_max) == pytest.approx(
        curve.pressure_min,
        rel=1e-3,  # where the curve begins at its largest radius it is flat
    )


@pytest.mark.parametrize("name", DESIGNS)
def test_outside_the_range_the_nearest_is_named(name: str, curves: dict[str, WrapCurve]) -> None:
    curve = curves[name]
    for radius, nearest, word in (
        (curve.radius_min * (1.0 - 1e-9), curve.radius_min, "thin"),
        (0.5 * curve.radius_min, curve.radius_min, "thin"),
        (curve.radius_max * (1.0 + 1e-9), curve.radius_max, "thick"),
        (1.0, curve.radius_max, "thick"),
    ):
        with pytest.raises(NotGrippableError) as caught:
            curve.pressure_from_radius(radius)
        assert caught.value.nearest_radius == nearest
        assert caught.value.radius == radius
        assert caught.value.margin == pytest.approx(-abs(radius - nearest), rel=1e-9)
        assert word in caught.value.constraint
        curve.pressure_from_radius(nearest)


@pytest.mark.parametrize("pressure", [-1.0, math.nan, 1.001 * PRESSURE_MAX])
def test_pressures_out_of_range_are_refused(pressure: float, curves: dict[str, WrapCurve]) -> None:
    curve = curves["P2"]
    for question in (curve.wrap_at_pressure, curve.radius_from_pressure, curve.state_at_pressure):
        with pytest.raises(InvalidInputError) as caught:
            question(pressure)
        assert caught.value.field == "pressure"
    with pytest.raises(InvalidInputError):
        curve.radius_from_pressure(0.999 * curve.pressure_min)
    with pytest.raises(InvalidInputError):
        curve.wrap_at_pressure(0.0)
    assert curve.state_at_pressure(0.0).stable


@pytest.mark.parametrize("torsion", [-25.0, -5.0, 12.0])
def test_without_weight_the_wrap_is_the_helix(torsion: float) -> None:
    curvature, length = 50.0, 0.5
    curve = WrapCurve(linear_gripper(curvature, torsion, length))
    # r_w = rho - r_o with rho = kappa / (kappa^2 + tau^2), everything proportional to pressure.
    rate = math.hypot(curvature, torsion)
    needed = 1.05 * 2.0 * math.pi / length
    assert curve.pressure_min == pytest.approx(1.0e5 * needed / rate, rel=1e-6)
    assert curve.pressure_max == 1.0e5
    for x in (needed / rate * 1.001, 0.6, 0.9, 1.0):
        wrap = curve.wrap_at_pressure(1.0e5 * x)
        rho = curvature / (x * rate**2)
        # The fitted axis of sampled tangents is right to the elements' order, 1e-7 or so.
        assert wrap.object_radius == pytest.approx(rho - OUTER_RADIUS, rel=1e-6)
        assert wrap.turns == pytest.approx(length * x * rate / (2.0 * math.pi), rel=1e-6)
        assert wrap.helix_angle == pytest.approx(math.atan2(curvature, abs(torsion)), abs=1e-6)
        one = 1.05 * 2.0 * math.pi / (x * rate)
        assert wrap.gripper_length_needed == pytest.approx(one, rel=1e-5)
        assert wrap.object_length_needed == pytest.approx(one * abs(torsion) / rate, rel=1e-5)
        assert wrap.contact_length == length
        assert (wrap.unloaded_shape.curvature, wrap.unloaded_shape.torsion) == (
            pytest.approx(curvature * x),
            pytest.approx(torsion * x),
        )
    few = curve.wrap_at_pressure(0.5 * curve.pressure_min)
    assert few.gripper_length_needed is None
    assert few.object_length_needed is None


def test_a_long_coil_wraps_too() -> None:
    """Eleven turns: the range is sampled as finely as the coil's turning asks for."""
    curve = WrapCurve(linear_gripper(length=1.3, weight=0.01, gravity=(0.0, G, 0.0)))
    for radius in np.linspace(curve.radius_min, min(curve.radius_max, 0.06), 9).tolist():
        pressure = curve.pressure_from_radius(radius)
        assert curve.radius_from_pressure(pressure) == pytest.approx(radius, rel=1e-6)


def test_mirrored_fibers_wrap_the_same() -> None:
    left = WrapCurve(linear_gripper(torsion=-20.0, weight=0.24, gravity=(G, 0.0, 0.0)))
    right = WrapCurve(linear_gripper(torsion=20.0, weight=0.24, gravity=(G, 0.0, 0.0)))
    assert left.radius_max == pytest.approx(right.radius_max, rel=1e-7)
    assert left.pressure_from_radius(0.02) == pytest.approx(
        right.pressure_from_radius(0.02), rel=1e-7
    )


def test_the_tip_curves_freely_and_fits_the_cylinder() -> None:
    """The formula against the shape itself: no moment at the tip, sin^2 / kappa."""
    curve = WrapCurve(paper_gripper("P2"))
    wrap = curve.wrap_for_radius(0.02)
    shape, state = wrap.unloaded_shape, wrap.state
    np.testing.assert_allclose(state.strains[-1], [shape.torsion, 0.0, shape.curvature], atol=1e-6)
    sine = np.linalg.norm(np.cross(state.tangents[-1], wrap.coil.axis))
    assert sine**2 / shape.curvature - OUTER_RADIUS == pytest.approx(0.02, rel=1e-7)
    # The turns that count and the lengths they need are consistent along the rod.
    assert wrap.gripper_length_needed is not None
    start = state.arc_lengths[-1] - wrap.gripper_length_needed
    counted = np.interp(start, wrap.coil.arc_lengths, wrap.coil.turns)
    assert wrap.turns - counted == pytest.approx(1.05, abs=1e-9)


def test_gravity_matters_and_vanishes_with_the_weight() -> None:
    free = WrapCurve(linear_gripper()).pressure_from_radius(0.02)
    shifts = []
    for weight in (0.24, 0.0024):
        heavy = linear_gripper(weight=weight, gravity=(0.0, -G, 0.0))
        shifts.append(WrapCurve(heavy).pressure_from_radius(0.02) - free)
    assert abs(shifts[0]) > 100.0
    # Linear in the weight to first order.
    assert abs(shifts[1]) < 0.05 * abs(shifts[0])


def test_a_given_axis_is_used() -> None:
    fitted = WrapCurve(paper_gripper("P2"))
    wrap = fitted.wrap_for_radius(0.02)
    same = WrapCurve(paper_gripper("P2", object_axis=wrap.coil.axis))
    again = same.wrap_at_pressure(wrap.pressure)
    assert again.object_radius == pytest.approx(0.02, rel=1e-7)
    assert again.turns == pytest.approx(wrap.turns, rel=1e-7)
    other = WrapCurve(paper_gripper("P2", object_axis=(1.0, 0.0, 0.0)))
    assert other.wrap_at_pressure(wrap.pressure).object_radius != pytest.approx(0.02, rel=1e-3)


def test_answers_do_not_depend_on_the_order_of_questions() -> None:
    forward, backward = (WrapCurve(paper_gripper("P1")) for _ in range(2))
    radii = np.linspace(forward.radius_min, forward.radius_max, 9).tolist()
    rising = [forward.wrap_for_radius(r) for r in radii]
    falling = [backward.wrap_for_radius(r) for r in reversed(radii)][::-1]
    for a, b in zip(rising, falling, strict=True):
        assert a.pressure == b.pressure
        np.testing.assert_array_equal(a.state.positions, b.state.positions)


def test_the_three_regimes(curves: dict[str, WrapCurve]) -> None:
    curve = curves["70 degrees"]
    radius = math.sqrt(curve.radius_min * curve.radius_max)
    perfect = curve.pressure_from_radius(radius)
    assert curve.regime(perfect, radius) is WrapRegime.PERFECT_WRAP
    assert curve.regime(0.0, radius) is WrapRegime.OVERHANG
    assert curve.regime(0.9 * perfect, radius) is WrapRegime.OVERHANG
    assert curve.regime(min(1.2 * perfect, PRESSURE_MAX), radius) is WrapRegime.CURLING
    # The band is about the radius: just inside and just outside of it.
    for share, regime in ((0.9, WrapRegime.PERFECT_WRAP), (1.1, WrapRegime.CURLING)):
        tighter = curve.pressure_from_radius(radius * (1.0 - share * PERFECT_BAND))
        assert curve.regime(tighter, radius) is regime
    wider = curve.pressure_from_radius(radius * (1.0 + 1.1 * PERFECT_BAND))
    assert curve.regime(wider, radius) is WrapRegime.OVERHANG
    # Told from a state that is known already it is the same, without another solve.
    state = curve.state_at_pressure(tighter)
    assert curve.regime(tighter, radius, state) is WrapRegime.CURLING
    with pytest.raises(NotGrippableError):
        curve.regime(perfect, 10.0 * curve.radius_max)
    with pytest.raises(InvalidInputError):
        curve.regime(-1.0, radius)


def test_past_a_coil_that_closes_on_itself_the_tip_curls() -> None:
    curve = WrapCurve(linear_gripper(curvature=250.0, torsion=-30.0, weight=0.24))
    assert curve.pressure_max < curve.gripper.pressure_max
    for share in (0.01, 0.3, 0.7, 1.0):
        pressure = curve.pressure_max + share * (curve.gripper.pressure_max - curve.pressure_max)
        assert curve.regime(pressure, curve.radius_max) is WrapRegime.CURLING


def test_a_gripper_too_short_to_coil_says_how_many_turns_it_makes() -> None:
    with pytest.raises(NoCoilError) as caught:
        WrapCurve(linear_gripper(length=0.1))
    assert caught.value.turns == pytest.approx(0.1 * math.hypot(50, 20) / (2 * math.pi), rel=1e-6)
    assert caught.value.turns_required == 1.05
    assert caught.value.pressure == pytest.approx(1.0e5)


def test_a_coil_that_closes_on_itself_ends_the_range() -> None:
    """Where rho reaches the tube's own radius nothing fits inside any more."""
    curve = WrapCurve(linear_gripper(curvature=250.0, torsion=-30.0))
    assert curve.radius_min == pytest.approx(1e-3 * OUTER_RADIUS, rel=1e-3)
    closes = 250.0 / (250.0**2 + 30.0**2) / OUTER_RADIUS / 1.001
    assert curve.pressure_max == pytest.approx(1.0e5 * closes, rel=1e-5)


@pytest.mark.parametrize("torsion", [-15.0, 15.0])
@pytest.mark.parametrize("coupling", [0.0, 1.5e-4, -1.0e-4])
def test_the_line_force_is_the_energys_slope(torsion: float, coupling: float) -> None:
    """Squeezing the cylinder by d(rho) gives back the energy q d(rho) per length of rod."""
    stiffness = Section.inextensible(3.0e-4, 2.0e-4, coupling=coupling)
    shape = UnloadedShape(40.0, torsion, 0.4)
    radius, angle = 0.02, 1.2

    def energy(rho: float) -> float:
        bent = math.sin(angle) ** 2 / rho - shape.curvature
        coiled = math.copysign(math.sin(angle) * math.cos(angle) / rho, torsion)
        change = np.array([coiled - torsion, 0.0, bent])
        return 0.5 * float(change @ np.array(stiffness.matrix) @ change)

    rho, d = radius + OUTER_RADIUS, 1e-6
    slope = (energy(rho + d) - energy(rho - d)) / (2.0 * d)
    force = line_force(stiffness, shape, radius, angle, OUTER_RADIUS)
    assert force == pytest.approx(slope, rel=1e-6)
    assert force > 0.0
    assert line_force(stiffness, shape, radius, math.pi - angle, OUTER_RADIUS) == pytest.approx(
        force, rel=1e-12
    )


def test_many_questions_are_the_single_ones(curves: dict[str, WrapCurve]) -> None:
    curve = curves["P1"]
    radii = np.array([[0.010, 0.012], [0.015, 0.011]])
    pressures = curve.pressures_from_radii(radii)
    assert pressures.shape == radii.shape
    assert pressures[1, 0] == curve.pressure_from_radius(0.015)
    assert curve.radii_from_pressures(pressures) == pytest.approx(radii, rel=1e-8)
    assert curve.pressures_from_radii([]).shape == (0,)
    with pytest.raises(NotGrippableError):
        curve.pressures_from_radii([0.010, 0.5])
    with pytest.raises(InvalidInputError, match="radii must be"):
        curve.pressures_from_radii([0.010, math.nan])
