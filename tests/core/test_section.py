# SPDX-License-Identifier: Apache-2.0
"""The section law: closed forms, consistency of its derivatives, its limits."""

import math
from dataclasses import astuple, replace

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE, derivative
from core.section_cases import LAWS, one_family, section, uniform, wall
from scipy.integrate import quad

from spiral_core import (
    ActuationLimitError,
    CurvatureForm,
    FreeActuation,
    Gent,
    NeoHookean,
    OneFamily,
    Tube,
    Yeoh,
)
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.fibers import fiber_state, locking_stretch
from spiral_core.actuator.section import motion_at
from spiral_core.actuator.uniform_law import pressure_from_stretch
from spiral_core.errors import ActuationLimit

every_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
CASES = [
    section(88.0, 60.0),
    section(65.0, -65.0, LAWS[2]),
    section(88.0, 60.0, LAWS[3], gamma=20.0),
    section(80.0, 50.0, gamma=-30.0),
    section(88.0, 60.0, LAWS[1], apart=80.0),
    section(88.0, 60.0, thick_wall=True),
    section(45.0, -45.0).without_single_fibers(),
]
every_case = pytest.mark.parametrize("bent", CASES, ids=range(len(CASES)))


@pytest.mark.parametrize("pair", [(88.0, 60.0), (90.0, 70.0), (75.0, 50.0), (65.0, -65.0)])
@every_law
def test_a_straight_section_is_the_uniform_law(pair, law):
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
        turned = shape.curvature, shape.torsion * stretch
        assert turned == (0.0, pytest.approx(twist, rel=1e-8 + near, abs=1e-12))


@every_law
@pytest.mark.parametrize("pair", [(60.0, -60.0), (75.0, -75.0), (89.0, -89.0), (90.0, 89.9)])
def test_small_strain_without_twist_costs_half_as_much_again(pair, law):
    """Bending about the straight fiber: the mean of (1 + cos)^2 is 3/2, whatever the law."""
    bent = section(*pair, law)
    pressure, even = (pressure_from_stretch(one, 1.0 + 1e-7) for one in (bent, uniform(bent)))
    assert pressure / even == pytest.approx(1.5, abs=1e-5)  # the next term is of order strain


@every_case
@pytest.mark.parametrize("fraction", [0.02, 0.2, 0.7])
def test_work_done_is_energy_stored(bent, fraction):
    curve = FreeActuation(bent)
    size = fraction * min(curve.size_limit, 2.0)
    h = (2e-3 if fraction < 0.1 else 5e-4) * size  # rounding near rest, poles at the end
    energy, volume, *_ = derivative(lambda sizes: wall(curve, sizes), size, h)
    pressure, slope = curve.pressure.with_slope(size)
    # Fourth-order differences: nine digits.
    assert pressure == pytest.approx(energy / volume, rel=1e-9)
    pressures = np.vectorize(lambda size: curve.pressure.with_slope(size)[0])
    assert slope == pytest.approx(derivative(pressures, size, h), rel=1e-9)


@every_case
def test_curve_is_that_of_states_solved_alone_and_has_an_inverse(bent):
    """Between its nodes too: the polynomials carry stretch and shape to twelve digits."""
    curve = FreeActuation(bent)
    path, sizes = curve.path, np.linspace(0.013, 0.97, 7) * curve.size_limit
    stretches, bends, turns = (
        np.vectorize(part)(sizes) for part in (path.stretch_at, path.curvature, path.torsion)
    )
    change = motion_at(path.fibers, path.direction * sizes).ring.stretch_change
    assert stretches - 1.0 == pytest.approx(change, rel=1e-12)
    _, _, *shapes = wall(curve, sizes) * bent.wound_radius
    turns += path.fibers.single_slope / sizes
    assert sizes * [bends, turns] == pytest.approx(np.array(shapes), rel=1e-11, abs=1e-13)
    assert curve.stretch_from_pressure(0.0) == 1.0
    for size in np.multiply([1e-9, 1e-4, 0.2, 0.999], curve.size_limit).tolist():
        pressure = curve.pressure.with_slope(size)[0]
        assert curve.size_from_pressure(pressure) == pytest.approx(size, rel=1e-12)
    stretch = curve.stretch_from_pressure(pressure)
    assert curve.pressure_from_stretch(stretch) == pytest.approx(pressure, rel=1e-9)


@pytest.mark.parametrize(
    "bent",
    [
        one_family(70.0),
        *(
            section(88.0, 60.0, gamma=gamma, thick_wall=thick)
            for gamma in (0.0, 25.0)
            for thick in (False, True)
        ),
    ],
)
def test_mirror_image_turns_the_other_way(bent):
    (single,), pair = bent.single_fibers, bent.fibers.mirrored()
    single = replace(single, angle=-single.angle)
    right = FreeActuation(bent)
    left = FreeActuation(replace(bent, fibers=pair, single_fibers=(single,)))
    digits = 1e-8 if isinstance(pair, OneFamily) else 1e-11
    assert left.pressure_limit == pytest.approx(right.pressure_limit, rel=max(digits, 1e-9))
    for pressure in (0.0, 20.0e3, 80.0e3):
        one = right.unloaded_shape(pressure)
        mirrored = astuple(replace(one, torsion=-one.torsion))
        found = astuple(left.unloaded_shape(pressure))
        assert found == pytest.approx(mirrored, rel=digits)


def test_thick_wall_of_a_straight_section_is_a_thick_walled_tube():
    """Inflation and extension of an incompressible tube whose outside follows the fibers."""
    bent = section(75.0, -75.0, NeoHookean(c1=145.0e3), thick_wall=True).without_single_fibers()
    inner = bent.tube.inner_radius / bent.tube.outer_radius

    def work(stretch):
        hoop = fiber_state(bent.fibers, stretch).hoop_stretch

        def density(radius):
            around = math.sqrt(hoop**2 + (radius**2 - 1.0) / stretch) / radius
            first = stretch**2 + around**2 + 1.0 / (stretch * around) ** 2
            return 145.0e3 * (first - 3.0) * 2.0 * radius

        return quad(density, inner, 1.0, epsabs=0.0, epsrel=1e-13)[0], stretch * hoop**2

    for stretch in (1.01, 1.1, 1.3):
        rise, room = derivative(lambda at: np.transpose([work(s) for s in at]), stretch, 1e-4)
        assert pressure_from_stretch(bent, stretch) == pytest.approx(rise / room, rel=1e-9)


@pytest.mark.parametrize("gamma", [0.0, 25.0])
def test_thick_and_thin_walls_agree_as_the_wall_thins(gamma):
    differences = []
    for thickness in (1e-3, 1e-4):
        choices = {"gamma": gamma, "tube": Tube(1.0, thickness, 10.0)}
        thin, thick = (
            FreeActuation(section(88.0, 60.0, thick_wall=flag, **choices)) for flag in (False, True)
        )
        ratio = thick.pressure_from_stretch(1.1) / thin.pressure_from_stretch(1.1)
        differences.append(abs(ratio - 1.0))
    assert differences[0] < 3e-3
    assert differences[1] == pytest.approx(0.1 * differences[0], rel=0.02)


def test_the_range_ends_where_the_volume_does():
    actuation = FreeActuation(section(88.0, 60.0))
    assert actuation.limit is ActuationLimit.VOLUME_MAXIMUM
    slope = actuation.path.volume_slope
    assert 0.0 < slope(actuation.size_limit) < 1e-3 * slope(0.0)
    end = actuation.stretch_limit
    with pytest.raises(ActuationLimitError, match="stretch"):
        actuation.pressure_from_stretch(end + 1e-6)
    with pytest.raises(ActuationLimitError, match="stretch"):
        unloaded_shape_from_stretch(actuation.actuator, end + 1e-2)


def test_a_soft_law_balloons_and_a_short_one_runs_out():
    soft = FreeActuation(section(88.0, 70.0, Yeoh(c1=145.0e3, c2=-400.0e3, c3=400.0e3)))
    assert soft.limit is ActuationLimit.LIMIT_POINT
    assert abs(soft.pressure.with_slope(soft.size_limit)[1]) < 1e-6 * soft.pressure_limit
    brittle = FreeActuation(section(88.0, 60.0, Gent(290.0e3, 0.1)))
    assert brittle.limit is ActuationLimit.MATERIAL_LIMIT
    motion = motion_at(brittle.path.fibers, np.array([brittle.size_limit]))
    assert 0.099 < motion.first.max() < 0.1


@pytest.mark.parametrize(
    ("bent", "limit"),
    [
        (section(88.0, 60.0), ActuationLimit.VOLUME_MAXIMUM),
        (section(30.0, 60.0), ActuationLimit.FIBER_LOCKING),
        (section(50.0, -40.0).without_single_fibers(), ActuationLimit.VOLUME_MAXIMUM),
    ],
)
def test_first_order_shapes_are_those_of_the_even_tube_and_end_with_its_twist(bent, limit):
    actuation = FreeActuation(replace(bent, curvature_form=CurvatureForm.FIRST_ORDER))
    assert actuation.limit is limit
    assert actuation.stretch_limit < locking_stretch(bent.fibers)
    for part in (1e-6, 1e-3, 0.03, 0.1, 0.3, 0.6, 0.9, 0.999, 1.0):
        shape = actuation.unloaded_shape(part * actuation.pressure_limit)
        even = unloaded_shape_from_stretch(actuation.actuator, shape.stretch)
        # The stretch is rounded, curvature and torsion are not.
        rounding = 1e-12 + 1e-15 / abs(shape.stretch - 1.0)
        assert astuple(shape) == pytest.approx(astuple(even), rel=rounding)
