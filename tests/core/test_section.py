# SPDX-License-Identifier: Apache-2.0
"""The section law: closed forms, consistency of its derivatives, its limits."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE
from core.section_cases import LAWS, section, uniform, wall_energy
from scipy.integrate import quad

from spiral_core import (
    ActuationLimitError,
    Actuator,
    CurvatureForm,
    FreeActuation,
    Gent,
    HyperelasticLaw,
    NeoHookean,
    Tube,
    Yeoh,
)
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.fibers import fiber_state
from spiral_core.actuator.section import motion_at, section_path
from spiral_core.actuator.uniform_law import pressure_from_stretch
from spiral_core.errors import ActuationLimit


@pytest.mark.parametrize("pair", [(88.0, 60.0), (90.0, 70.0), (75.0, 50.0), (65.0, -65.0)])
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_a_straight_section_is_the_uniform_law(
    pair: tuple[float, float], law: HyperelasticLaw
) -> None:
    bent = section(*pair, law)
    even, paper = FreeActuation(bent.without_single_fibers()), FreeActuation(uniform(bent))
    assert even.limit is paper.limit
    for fraction in (1e-6, 0.01, 0.2, 0.5, 0.9, 0.99):
        stretch = 1.0 + fraction * (min(even.stretch_limit, paper.stretch_limit) - 1.0)
        # the uniform law's own stretch is known to the last bit of lambda_1 - 1
        near = 4e-16 / (fraction * (even.stretch_limit - 1.0))
        assert even.pressure_from_stretch(stretch) == pytest.approx(
            paper.pressure_from_stretch(stretch), rel=1e-11 + near
        )
        shape = even.unloaded_shape_from_stretch(stretch)
        twist = fiber_state(bent.fibers, stretch).twist / PAPER_TUBE.inner_radius
        assert shape.curvature == 0.0
        assert shape.torsion * stretch == pytest.approx(twist, rel=1e-8 + near, abs=1e-12)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("alpha", [60.0, 75.0, 89.0])
def test_small_strain_without_twist_costs_half_as_much_again(
    alpha: float, law: HyperelasticLaw
) -> None:
    """Bending about the straight fiber: the mean of (1 + cos)^2 is 3/2, whatever the law."""
    bent = section(alpha, -alpha, law)
    ratio = pressure_from_stretch(bent, 1.0 + 1e-7) / pressure_from_stretch(
        uniform(bent), 1.0 + 1e-7
    )
    assert ratio == pytest.approx(1.5, abs=1e-5)  # the next term is of the order of the strain


@pytest.mark.parametrize(
    ("beta", "stretch", "factor"),
    [(70.0, 1.02, 1.474), (70.0, 1.1, 1.401), (70.0, 1.2, 1.359), (60.0, 1.1, 1.422),
     (60.0, 1.2, 1.416), (50.0, 1.1, 1.470), (50.0, 1.2, 1.578)],
)  # fmt: skip
def test_factors_of_the_papers_actuators(beta: float, stretch: float, factor: float) -> None:
    bent = section(88.0, beta, NeoHookean(c1=145.0e3))
    even = pressure_from_stretch(uniform(bent), stretch)
    assert pressure_from_stretch(bent, stretch) / even == pytest.approx(factor, abs=1e-3)


CASES = [
    section(88.0, 60.0),
    section(65.0, -65.0, LAWS[2]),
    section(88.0, 60.0, LAWS[3], gamma=20.0),
    section(80.0, 50.0, gamma=-30.0),
    section(88.0, 60.0, LAWS[1], apart=80.0),
    section(88.0, 60.0, thick_wall=True),
    section(45.0, -45.0).without_single_fibers(),
]


@pytest.mark.parametrize("bent", CASES, ids=range(len(CASES)))
@pytest.mark.parametrize("fraction", [0.02, 0.2, 0.7])
def test_work_done_is_energy_stored(bent: Actuator, fraction: float) -> None:
    curve = FreeActuation(bent)
    size = fraction * min(curve.size_limit, 2.0)
    h = (2e-3 if fraction < 0.1 else 5e-4) * size  # rounding near rest, poles at the end
    sizes = [size + k * h for k in (-2, -1, 1, 2)]
    energy = wall_energy(curve, bent, sizes)
    rings = motion_at(curve.path.fibers, curve.path.direction * np.array(sizes)).ring
    volume = (1.0 + rings.stretch_change) * rings.hoop**2
    ratio = np.dot([1, -8, 8, -1], energy) / np.dot([1, -8, 8, -1], volume)
    pressure, slope = curve.pressure.with_slope(size)
    wall = bent.tube.wall_area / (math.pi * bent.wound_radius**2)
    # Fourth-order differences: nine digits.
    assert pressure == pytest.approx(wall * ratio, rel=1e-9)
    steps = [curve.pressure.with_slope(one)[0] for one in sizes]
    assert slope == pytest.approx(np.dot([1, -8, 8, -1], steps) / (12 * h), rel=1e-9)


@pytest.mark.parametrize("bent", CASES, ids=range(len(CASES)))
def test_curve_is_that_of_states_solved_alone(bent: Actuator) -> None:
    """Between its nodes too: the polynomials carry stretch and shape to twelve digits."""
    curve = FreeActuation(bent)
    sizes = np.linspace(0.013, 0.97, 7) * curve.size_limit
    ring = motion_at(curve.path.fibers, curve.path.direction * sizes).ring
    for k, size in enumerate(sizes.tolist()):
        assert curve.path.stretch_at(size) - 1.0 == pytest.approx(ring.stretch_change[k], rel=1e-12)
        turn = ring.twist[k] / ring.hoop[k] - curve.path.fibers.single_slope
        assert size * curve.path.torsion(size) == pytest.approx(turn, rel=1e-11, abs=1e-13)
        bend = ring.bend[k] / ring.hoop[k]
        assert size * curve.path.curvature(size) == pytest.approx(bend, rel=1e-11)


@pytest.mark.parametrize("bent", CASES, ids=range(len(CASES)))
def test_inverse_and_forward_agree(bent: Actuator) -> None:
    actuation = FreeActuation(bent)
    assert actuation.stretch_from_pressure(0.0) == 1.0
    for fraction in (1e-9, 1e-4, 0.01, 0.2, 0.6, 0.999):
        size = fraction * actuation.size_limit
        pressure = actuation.pressure.with_slope(size)[0]
        assert actuation.size_from_pressure(pressure) == pytest.approx(size, rel=1e-12)
        stretch = actuation.stretch_from_pressure(pressure)
        if fraction > 1e-3:
            assert actuation.pressure_from_stretch(stretch) == pytest.approx(pressure, rel=1e-9)


@pytest.mark.parametrize("gamma", [0.0, 25.0])
@pytest.mark.parametrize("thick", [False, True])
def test_mirror_image_turns_the_other_way(gamma: float, thick: bool) -> None:
    right = FreeActuation(section(88.0, 60.0, gamma=gamma, thick_wall=thick))
    left = FreeActuation(section(-88.0, -60.0, gamma=-gamma, thick_wall=thick))
    assert left.pressure_limit == pytest.approx(right.pressure_limit, rel=1e-9)
    for pressure in (0.0, 20.0e3, 80.0e3):
        one, other = right.unloaded_shape(pressure), left.unloaded_shape(pressure)
        assert other.torsion == pytest.approx(-one.torsion, rel=1e-11)
        assert other.curvature == pytest.approx(one.curvature, rel=1e-11)
        assert other.stretch == pytest.approx(one.stretch, rel=1e-11)


def test_thick_wall_of_a_straight_section_is_a_thick_walled_tube() -> None:
    """Inflation and extension of an incompressible tube whose outside follows the fibers."""
    bent = section(75.0, -75.0, NeoHookean(c1=145.0e3), thick_wall=True).without_single_fibers()
    tube = bent.tube
    inner = tube.inner_radius / tube.outer_radius

    def work(stretch: float) -> tuple[float, float]:
        hoop = fiber_state(bent.fibers, stretch).hoop_stretch

        def density(radius: float) -> float:
            around = math.sqrt(hoop**2 + (radius**2 - 1.0) / stretch) / radius
            first = stretch**2 + around**2 + 1.0 / (stretch * around) ** 2
            return 145.0e3 * (first - 3.0) * 2.0 * radius

        return quad(density, inner, 1.0, epsabs=0.0, epsrel=1e-13)[0], stretch * hoop**2

    for stretch in (1.01, 1.1, 1.3):
        h = 1e-4
        at = [work(stretch + k * h) for k in (-2, -1, 1, 2)]
        rise, room = (np.dot([1, -8, 8, -1], [one[k] for one in at]) for k in (0, 1))
        assert pressure_from_stretch(bent, stretch) == pytest.approx(rise / room, rel=1e-9)


@pytest.mark.parametrize("gamma", [0.0, 25.0])
def test_thick_and_thin_walls_agree_as_the_wall_thins(gamma: float) -> None:
    differences = []
    for wall in (1e-3, 1e-4):
        tube = Tube(1.0, wall, 10.0)
        thin = FreeActuation(section(88.0, 60.0, tube=tube, gamma=gamma))
        thick = FreeActuation(section(88.0, 60.0, tube=tube, gamma=gamma, thick_wall=True))
        ratio = thick.pressure_from_stretch(1.1) / thin.pressure_from_stretch(1.1)
        differences.append(abs(ratio - 1.0))
    assert differences[0] < 3e-3
    assert differences[1] == pytest.approx(0.1 * differences[0], rel=0.02)


def test_the_range_ends_where_the_volume_does() -> None:
    actuation = FreeActuation(section(88.0, 60.0))
    assert actuation.limit is ActuationLimit.VOLUME_MAXIMUM
    path = section_path(actuation.actuator.fiber_set)
    size = actuation.size_limit
    assert 0.0 < path.volume_slope(size) < 1e-3 * path.volume_slope(0.0)
    with pytest.raises(ActuationLimitError, match="stretch"):
        actuation.pressure_from_stretch(actuation.stretch_limit + 1e-6)
    with pytest.raises(ActuationLimitError, match="stretch"):
        unloaded_shape_from_stretch(actuation.actuator, actuation.stretch_limit + 1e-2)


def test_a_soft_law_balloons_and_a_short_one_runs_out() -> None:
    soft = section(88.0, 70.0, Yeoh(c1=145.0e3, c2=-400.0e3, c3=400.0e3))
    actuation = FreeActuation(soft)
    assert actuation.limit is ActuationLimit.LIMIT_POINT
    size = actuation.size_limit
    assert abs(actuation.pressure.with_slope(size)[1]) < 1e-6 * actuation.pressure_limit
    brittle = FreeActuation(section(88.0, 60.0, Gent(290.0e3, 0.1)))
    assert brittle.limit is ActuationLimit.MATERIAL_LIMIT
    motion = motion_at(brittle.path.fibers, np.array([brittle.size_limit]))
    assert 0.099 < motion.first.max() < 0.1


def test_first_order_form_ends_with_the_even_tubes_twist() -> None:
    bent = dataclasses.replace(section(30.0, 40.0), curvature_form=CurvatureForm.FIRST_ORDER)
    actuation = FreeActuation(bent)
    assert actuation.limit is ActuationLimit.FIBER_LOCKING
    assert actuation.stretch_limit < 1.0 / math.cos(math.radians(30.0))
    actuation.unloaded_shape(actuation.pressure_limit)


@pytest.mark.parametrize("pair", [(88.0, 60.0), (70.0, -65.0), (30.0, 40.0)])
@pytest.mark.parametrize("bends", [True, False])
def test_first_order_shapes_are_those_of_the_even_tube(
    pair: tuple[float, float], bends: bool
) -> None:
    bent = section(*pair) if bends else section(*pair).without_single_fibers()
    actuation = FreeActuation(dataclasses.replace(bent, curvature_form=CurvatureForm.FIRST_ORDER))
    for part in (1e-6, 1e-3, 0.03, 0.1, 0.3, 0.6, 0.9, 0.999, 1.0):
        shape = actuation.unloaded_shape(part * actuation.pressure_limit)
        even = unloaded_shape_from_stretch(actuation.actuator, shape.stretch)
        # The stretch is rounded, curvature and torsion are not.
        rounding = 1e-12 + 1e-15 / (shape.stretch - 1.0)
        assert shape.curvature == pytest.approx(even.curvature, rel=rounding)
        assert shape.torsion == pytest.approx(even.torsion, rel=rounding)
