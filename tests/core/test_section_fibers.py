# SPDX-License-Identifier: Apache-2.0
"""The section law for any set of fibers: helical, two, one family; stiffness; what is refused."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE
from core.section_cases import of_ring, one_family, section, uniform, wall
from scipy.optimize import newton

from spiral_core import (
    CurvatureForm,
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
    assert shape.torsion == pytest.approx(math.tan(math.radians(20.0)) / PAPER_TUBE.inner_radius)


def test_one_hoop_family_bends_without_twist():
    """Without a second family nothing turns it; at small strain the hoop keeps plane sections."""
    hoop = FreeActuation(one_family(90.0, NeoHookean(c1=145.0e3)))
    shape = hoop.unloaded_shape(20.0e3)
    assert shape.curvature > 1.0
    assert abs(shape.torsion) < 1e-9
    # Plane strain, bending about the straight fiber: P = 3/2 (A / pi r^2) 4/3 E (lambda - 1).
    area_ratio = PAPER_TUBE.wall_area / (math.pi * PAPER_TUBE.inner_radius**2)
    stretch = hoop.stretch_from_pressure(10.0)
    linear = 1.5 * area_ratio * (4.0 / 3.0) * 6.0 * 145.0e3 * (stretch - 1.0)
    assert linear == pytest.approx(10.0, rel=1e-3)  # of the order of the strain


BENT, ALONE = section(88.0, 60.0), one_family(70.0)
SHORTENING = section(45.0, -45.0)
STRAIGHT, UNIFORM = SHORTENING.without_single_fibers(), PressureLaw.UNIFORM
FIRST_ORDER = CurvatureForm.FIRST_ORDER


def fibers(*places):
    return tuple(SingleFiber(*place) for place in places)


@pytest.mark.parametrize(
    ("ask", "match"),
    [
        (partial(replace, BENT, twist_shear=False), "twist_shear"),
        (partial(replace, BENT, thick_wall=True, pressure_law=UNIFORM), "thick_wall"),
        (partial(replace, BENT, single_fibers=fibers([0.2]), pressure_law=UNIFORM), "section"),
        (partial(replace, BENT, single_fibers=fibers([0.2]), curvature_form=FIRST_ORDER), "exact"),
        (partial(replace, BENT, single_fibers=fibers([0.1], [0.2, 1.0])), "fibers that cross"),
        (partial(replace, BENT, single_fibers=fibers([math.radians(60.0)])), "another angle"),
        (partial(replace, BENT, single_fibers=fibers([], [0.0, 1.0], [0.0, 2.0])), "at most 2"),
        (partial(replace, BENT, single_fibers=fibers([], [0.0, math.pi])), "170 degrees"),
        (partial(replace, BENT, single_fibers=fibers([], [])), "they are one"),
        (partial(replace, ALONE, thick_wall=True), "famil"),
        (partial(replace, ALONE, pressure_law=UNIFORM), "famil"),
        (partial(replace, ALONE, curvature_form=FIRST_ORDER), "famil"),
        (lambda: FreeActuation(SHORTENING), "pair that extends"),
        (lambda: FreeActuation(STRAIGHT).pressure_from_stretch(1.01), "at most 1"),
        (lambda: unloaded_shape_from_stretch(STRAIGHT, 1.01), "at most 1 for these"),
        (lambda: unloaded_shape_from_stretch(ALONE, 1.1), "two families"),
        (lambda: FreeActuation(one_family(30.0)), "extends the tube"),
        (lambda: stiffness_from_section(ALONE, 0.0), "two families"),
        (lambda: stiffness_from_section(STRAIGHT, 0.0), "makes the section bend"),
        (lambda: stiffness_from_section(uniform(BENT), 20.0e3), "section"),
    ],
)
def test_contradictions_and_questions_without_an_answer_are_refused(ask, match):
    with pytest.raises(InvalidInputError, match=match):
        ask()


def test_bending_a_thin_tube_about_its_straight_fiber_takes_four_times_ei():
    """Plane strain (4/3 E) about the edge (3/2 x 2 of the diameter's I): 4 E I at rest."""
    thin = section(90.0, 89.9, tube=Tube(1.0, 1e-4, 10.0))
    stiffness, annulus = section_stiffness(FreeActuation(thin), 0.0), stiffness_from_actuator(thin)
    assert stiffness.bending == pytest.approx(4.0 * annulus.bending, rel=1e-3)  # t/r, 0.1 degrees
    assert section_stiffness(FreeActuation(section(65.0, -65.0)), 0.0).torsional == math.inf


@pytest.mark.parametrize("gamma", [0.0, 20.0])
def test_stiffness_is_the_second_derivative_of_energy_less_work(gamma):
    curve, pressure = FreeActuation(section(88.0, 60.0, gamma=gamma)), 60.0e3
    size = curve.size_from_pressure(pressure)
    h = 2e-3 * size
    energy, volume, *turns = wall(curve, size + h * np.arange(-2, 3))
    rise = (energy - pressure * volume) @ [-1, 16, -30, 16, -1] / (12 * h * h)
    bend, twist = np.array(turns) @ [1, -8, 0, 8, -1] / (12 * h)
    stiffness = section_stiffness(curve, pressure)
    assert stiffness.bending == pytest.approx(rise / bend**2, rel=1e-6)  # second differences
    assert stiffness.twist_per_curvature == pytest.approx(twist / bend, rel=1e-8)
    assert stiffness.torsional == pytest.approx(rise / twist**2, rel=1e-6)


@pytest.mark.parametrize("pair", [(88.0, 60.0), (75.0, 50.0), (65.0, -65.0)])
@pytest.mark.parametrize("gamma", [0.0, 20.0])
def test_bending_sideways_takes_a_third_at_rest(pair, gamma):
    """The strain around is K sin instead of K (1 - cos): means of 1/2 and 3/2, with twist too."""
    bent = section(*pair, gamma=math.copysign(gamma, pair[1]))
    stiffness = section_stiffness(FreeActuation(bent), 0.0)
    assert stiffness.sideways == pytest.approx(stiffness.bending / 3.0, rel=1e-5)


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
    assert sideways == pytest.approx(expected, rel=1e-5)
