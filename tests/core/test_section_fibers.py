# SPDX-License-Identifier: Apache-2.0
"""The section law for any set of fibers: helical, two, one family; stiffness; what is refused."""

from dataclasses import replace
from functools import partial
from math import atan, copysign, inf, pi, radians, sqrt, tan

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE
from core.recorded import recorded, said
from core.section_cases import of_ring, one_family, section, uniform, wall
from numpy.testing import assert_allclose
from scipy.optimize import newton

from spiral_core import (
    CurvatureForm,
    FiberAngles,
    FreeActuation,
    InvalidInputError,
    NeoHookean,
    PressureLaw,
    SingleFiber,
    Tube,
)
from spiral_core.actuator.actuation import section_stiffness
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.section import closures, ring_at
from spiral_core.wrap.gripper import stiffness_from_actuator, stiffness_from_section

pytestmark = pytest.mark.long


def test_a_helical_fiber_coils_at_rest_as_it_is_wound():
    shape = FreeActuation(section(88.0, 60.0, gamma=20.0)).unloaded_shape(0.0)
    assert shape.curvature == 0.0
    assert_allclose(shape.torsion, tan(radians(20.0)) / PAPER_TUBE.inner_radius)


def test_one_hoop_family_bends_without_twist():
    """Without a second family nothing turns it; at small strain the hoop keeps plane sections."""
    hoop = FreeActuation(one_family(90.0, NeoHookean(145.0e3)))
    shape = hoop.unloaded_shape(20.0e3)
    assert shape.curvature > 1.0
    assert abs(shape.torsion) < 1e-9
    # Plane strain, bending about the straight fiber: P = 3/2 (A / pi r^2) 4/3 E (lambda - 1).
    area_ratio = PAPER_TUBE.wall_area / (pi * PAPER_TUBE.inner_radius**2)
    stretch = hoop.stretch_from_pressure(10.0)
    linear = 1.5 * area_ratio * (4.0 / 3.0) * 6.0 * 145.0e3 * (stretch - 1.0)
    assert_allclose(linear, 10.0, 1e-3)  # of the order of the strain


BENT, ALONE = section(88.0, 60.0), one_family(70.0)
SHORTENING = section(45.0, -45.0)
STRAIGHT, UNIFORM = SHORTENING.without_single_fibers(), PressureLaw.UNIFORM
FIRST_ORDER = CurvatureForm.FIRST_ORDER


def test_contradictions_and_questions_without_an_answer_are_refused():
    def bent(*places, **choices):
        """Return the bent tube with single fibers at other places."""
        singles = tuple(SingleFiber(*place) for place in places)
        return replace(BENT, **({"single_fibers": singles} if places else {}), **choices)

    asked = (
        *(
            partial(bent, **choices)
            for choices in ({"twist_shear": False}, {"thick_wall": True, "pressure_law": UNIFORM})
        ),
        partial(bent, [0.2], pressure_law=UNIFORM),
        partial(bent, [0.2], curvature_form=FIRST_ORDER),
        partial(bent, [0.1], [0.2, 1.0]),
        partial(bent, [radians(60.0)]),
        partial(bent, [], [0.0, 1.0], [0.0, 2.0]),
        partial(bent, [], [0.0, pi]),
        partial(bent, [], []),
        partial(replace, ALONE, thick_wall=True),
        partial(replace, ALONE, pressure_law=UNIFORM),
        partial(replace, ALONE, curvature_form=FIRST_ORDER),
        *(
            partial(FreeActuation, of)
            for of in (SHORTENING, uniform(section(50.0, -50.0)), one_family(30.0))
        ),
        partial(FreeActuation(STRAIGHT).pressure_from_stretch, 1.01),
        *(partial(unloaded_shape_from_stretch, of, 1.1) for of in (STRAIGHT, ALONE)),
        *(partial(stiffness_from_section, of, 2e4) for of in (ALONE, STRAIGHT, uniform(BENT))),
    )
    found = {f"{k}": f"{said(ask)}".partition(", got")[0] for k, ask in enumerate(asked)}
    recorded("refusals/fibers", found)


@pytest.mark.parametrize("law", PressureLaw)
@pytest.mark.parametrize("singles", [(SingleFiber(),), ()])
@pytest.mark.parametrize("off", [0.0, 1e-14, -1e-15, 1e-8])
def test_fibers_at_the_magic_angle_move_no_tube(law, singles, off):
    magic = atan(sqrt(2.0)) + off
    tube = replace(BENT, fibers=FiberAngles(magic, -magic), pressure_law=law, single_fibers=singles)
    with pytest.raises(InvalidInputError, match="fibers must be"):
        FreeActuation(tube)


def test_bending_a_thin_tube_about_its_straight_fiber_takes_four_times_ei():
    """Plane strain (4/3 E) about the edge (3/2 x 2 of the diameter's I): 4 E I at rest."""
    thin = section(90.0, 89.9, tube=Tube(1.0, 1e-4, 10.0))
    stiffness, annulus = section_stiffness(FreeActuation(thin), 0.0), stiffness_from_actuator(thin)
    assert_allclose(stiffness.bending, 4.0 * annulus.bending, 1e-3)  # t/r, 0.1 degrees
    assert section_stiffness(FreeActuation(section(65.0, -65.0)), 0.0).torsional == inf


def test_stiffness_is_the_second_derivative_of_energy_less_work():
    for gamma in [0.0, 20.0]:
        curve, pressure = FreeActuation(section(88.0, 60.0, gamma=gamma)), 60.0e3
        size = curve.size_from_pressure(pressure)
        h = 2e-3 * size
        energy, volume, *turns = wall(curve, size + h * np.arange(-2, 3))
        rise = (energy - pressure * volume) @ [-1, 16, -30, 16, -1] / (12 * h * h)
        bend, twist = np.array(turns) @ [1, -8, 0, 8, -1] / (12 * h)
        stiffness = section_stiffness(curve, pressure)
        assert_allclose(stiffness.bending, rise / bend**2, 1e-6)  # second differences
        assert_allclose(stiffness.twist_per_curvature, twist / bend, 1e-8)
        assert_allclose(stiffness.torsional, rise / twist**2, 1e-6)


def test_bending_sideways_takes_a_third_at_rest():
    """The strain around is K sin instead of K (1 - cos): means of 1/2 and 3/2, with twist too."""
    for pair in [(88.0, 60.0), (75.0, 50.0), (65.0, -65.0)]:
        for gamma in [0.0, 20.0]:
            bent = section(*pair, gamma=copysign(gamma, pair[1]))
            stiffness = section_stiffness(FreeActuation(bent), 0.0)
            assert_allclose(stiffness.sideways, stiffness.bending / 3.0, 1e-5)


@pytest.mark.parametrize("gamma", [0.0, 20.0])
@pytest.mark.parametrize("thick", [False, True])
def test_sideways_stiffness_is_the_second_difference_of_energy_less_work(gamma, thick):
    """The single fiber turned out of the coil's plane by an angle, the wall closed again."""
    curve = FreeActuation(section(88.0, 60.0, gamma=gamma, thick_wall=thick))
    fibers, pressure = curve.path.fibers, 70.0e3
    far = np.array([curve.size_from_pressure(pressure)])
    (change,), *_ = closures(fibers, far)

    def ring(turn, angle):
        return ring_at(fibers, far, turn, np.array([angle]))

    def turned(angle):
        """Return energy less work [J/m], and the curvature [1/m], at an angle [rad]."""
        closed = newton(lambda turn: ring(turn, angle).warp, change)
        ((energy,), (volume,), (curvature,), _) = of_ring(curve, ring(closed, angle))
        return energy - pressure * volume, curvature

    rest, curvature = turned(0.0)
    near, farther = (
        2.0 * (turned(angle)[0] - rest) / (angle * curvature) ** 2 for angle in (0.03, 0.06)
    )
    # The next term of the differences is of the fourth power of the angle.
    expected = (4.0 * near - farther) / 3.0
    sideways = section_stiffness(curve, pressure).sideways
    assert_allclose(sideways, expected, 1e-5)
