# SPDX-License-Identifier: Apache-2.0
"""The section law: closed forms, consistency of its derivatives, its limits."""

from dataclasses import astuple, replace
from math import sqrt

import numpy as np
import pytest
from core.actuator_cases import derivative, mirrored
from core.section_cases import LAWS, one_family, section, uniform, wall
from numpy.testing import assert_allclose
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
from spiral_core.errors import ActuationLimit

CASES = [
    section(88.0, 60.0),
    section(65.0, -65.0, LAWS[2]),
    section(88.0, 60.0, LAWS[3], gamma=20.0),
    section(80.0, 50.0, gamma=-30.0),
    section(88.0, 60.0, LAWS[1], apart=80.0),
    section(88.0, 60.0, thick_wall=True),
    section(45.0, -45.0).without_single_fibers(),
]


def test_small_strain_without_twist_costs_half_as_much_again():
    """Bending about the straight fiber: the mean of (1 + cos)^2 is 3/2, whatever the law."""
    for law in LAWS:
        for pair in [(60.0, -60.0), (75.0, -75.0), (89.0, -89.0), (90.0, 89.9)]:
            bent = section(*pair, law)
            pressures = [
                FreeActuation(one).pressure_from_stretch(1.0 + 1e-7)
                for one in (bent, uniform(bent))
            ]
            # The next term is of order strain.
            assert_allclose(np.divide(*pressures), 1.5, 0, 1e-5)


@pytest.mark.parametrize("bent", CASES)
def test_curve_is_that_of_states_solved_alone_has_an_inverse_and_does_the_work_stored(bent):
    """Between its nodes too: the polynomials carry stretch and shape to twelve digits."""
    curve = FreeActuation(bent)
    path, sizes = curve.path, np.linspace(0.013, 0.97, 7) * curve.size_limit
    stretches, bends, turns = (
        np.vectorize(part)(sizes) for part in (path.stretch_at, path.curvature, path.torsion)
    )
    change = motion_at(path.fibers, path.direction * sizes).ring.stretch_change
    assert_allclose(stretches - 1.0, change, 1e-12)
    _, _, *shapes = wall(curve, sizes) * bent.wound_radius
    turns += path.fibers.single_slope / sizes
    assert_allclose(sizes * [bends, turns], np.array(shapes), 1e-11, 1e-13)
    assert curve.stretch_from_pressure(0.0) == 1.0
    for size in np.multiply([1e-9, 1e-4, 0.2, 0.999], curve.size_limit):
        pressure, _ = curve.pressure.with_slope(size)
        assert_allclose(curve.size_from_pressure(pressure), size, 1e-12)
    stretch = curve.stretch_from_pressure(pressure)
    assert_allclose(curve.pressure_from_stretch(stretch), pressure, 1e-9)
    for fraction, part in ((0.02, 2e-3), (0.2, 5e-4), (0.7, 5e-4)):
        size = fraction * min(curve.size_limit, 2.0)
        h = part * size  # rounding near rest, poles at the end
        energy, volume, *_ = derivative(lambda sizes: wall(curve, sizes), size, h)
        pressure, slope = curve.pressure.with_slope(size)
        # Fourth-order differences: nine digits.
        pressures = np.vectorize(lambda size: curve.pressure.with_slope(size)[0])
        found = energy / volume, derivative(pressures, size, h)
        assert_allclose((pressure, slope), found, 1e-9)


THICK_AND_HELICAL = section(88.0, 60.0, gamma=25.0, thick_wall=True)


@pytest.mark.parametrize("bent", [*CASES, one_family(70.0), THICK_AND_HELICAL])
def test_mirror_image_turns_the_other_way(bent):
    singles = tuple(
        replace(one, angle=-one.angle, position=-one.position) for one in bent.single_fibers
    )
    image = replace(bent, fibers=mirrored(bent.fibers), single_fibers=singles)
    right, left = map(FreeActuation, (bent, image))
    digits = 1e-8 if isinstance(bent.fibers, OneFamily) else 1e-11
    assert_allclose(left.pressure_limit, right.pressure_limit, max(digits, 1e-9))
    for pressure in (0.0, 20.0e3, 80.0e3):
        one, other = (each.unloaded_shape(pressure) for each in (right, left))
        assert_allclose(astuple(other), astuple(replace(one, torsion=-one.torsion)), digits)


def test_thick_wall_of_a_straight_section_is_a_thick_walled_tube():
    """Inflation and extension of an incompressible tube whose outside follows the fibers."""
    bent = section(75.0, -75.0, NeoHookean(145.0e3), thick_wall=True).without_single_fibers()

    def work(stretch):
        hoop = fiber_state(bent.fibers, stretch).hoop_stretch

        def density(radius):
            around = sqrt(hoop**2 + (radius**2 - 1.0) / stretch) / radius
            first = stretch**2 + around**2 + 1.0 / (stretch * around) ** 2
            return 145.0e3 * (first - 3.0) * 2.0 * radius

        inner = bent.tube.inner_radius / bent.tube.outer_radius
        return quad(density, inner, 1.0, epsabs=0.0, epsrel=1e-13)[0], stretch * hoop**2

    for stretch in (1.01, 1.1, 1.3):
        rise, room = derivative(lambda at: np.transpose([*map(work, at)]), stretch, 1e-4)
        assert_allclose(FreeActuation(bent).pressure_from_stretch(stretch), rise / room, 1e-9)


def test_thick_and_thin_walls_agree_as_the_wall_thins():
    for gamma in [0.0, 25.0]:
        differences = []
        for thickness in (1e-3, 1e-4):
            tube = Tube(1.0, thickness, 10.0)
            thin, thick = (
                FreeActuation(
                    section(88.0, 60.0, gamma=gamma, tube=tube, thick_wall=flag)
                ).pressure_from_stretch(1.1)
                for flag in (False, True)
            )
            differences.append(abs(thick / thin - 1.0))
        assert differences[0] < 3e-3
        assert_allclose(differences[1], 0.1 * differences[0], 0.02)


def test_the_range_ends_with_the_volume_the_pressure_or_the_rubber():
    largest = FreeActuation(section(88.0, 60.0))
    soft = FreeActuation(section(88.0, 70.0, Yeoh(145.0e3, -400.0e3, 400.0e3)))
    brittle = FreeActuation(section(88.0, 60.0, Gent(290.0e3, 0.1)))
    limits = [each.limit.name for each in (largest, soft, brittle)]
    assert limits == ["VOLUME_MAXIMUM", "LIMIT_POINT", "MATERIAL_LIMIT"]
    slope = largest.path.volume_slope
    assert 0.0 < slope(largest.size_limit) < 1e-3 * slope(0.0)
    past = largest.stretch_limit + 1e-6
    with pytest.raises(ActuationLimitError, match="stretch"):
        largest.pressure_from_stretch(past)
    with pytest.raises(ActuationLimitError, match="stretch"):
        unloaded_shape_from_stretch(largest.actuator, past)
    assert abs(soft.pressure.with_slope(soft.size_limit)[1]) < 1e-6 * soft.pressure_limit
    motion = motion_at(brittle.path.fibers, np.array([brittle.size_limit]))
    assert 0.099 < motion.first.max() < 0.1


def test_first_order_shapes_are_those_of_the_even_tube_and_end_with_its_twist():
    for bent, limit in [
        (section(88.0, 60.0), ActuationLimit.VOLUME_MAXIMUM),
        (section(30.0, 60.0), ActuationLimit.FIBER_LOCKING),
        (section(50.0, -40.0).without_single_fibers(), ActuationLimit.VOLUME_MAXIMUM),
    ]:
        actuation = FreeActuation(replace(bent, curvature_form=CurvatureForm.FIRST_ORDER))
        assert actuation.limit is limit
        assert actuation.stretch_limit < locking_stretch(bent.fibers)
        for part in (1e-6, 1e-3, 0.1, 0.6, 0.999, 1.0):
            shape = actuation.unloaded_shape(part * actuation.pressure_limit)
            even = unloaded_shape_from_stretch(actuation.actuator, shape.stretch)
            # The stretch is rounded, curvature and torsion are not.
            rounding = 1e-12 + 1e-15 / abs(shape.stretch - 1.0)
            assert_allclose(astuple(shape), astuple(even), rounding)
