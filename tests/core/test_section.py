# SPDX-License-Identifier: Apache-2.0
"""The section law: closed forms, brute force, consistency of its derivatives, its limits."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from core.actuator_cases import LATEX, PAPER_TUBE, degrees
from core.reference_section import POINTS, BruteSection, Found
from numpy.typing import NDArray
from scipy.integrate import quad

from spiral_core import (
    ActuationLimit,
    ActuationLimitError,
    Actuator,
    CurvatureForm,
    FreeActuation,
    Gent,
    HyperelasticLaw,
    InvalidInputError,
    MooneyRivlin,
    NeoHookean,
    OneFamily,
    PressureLaw,
    SingleFiber,
    Tube,
    Yeoh,
    design_space,
    fiber_state,
    pressure_from_stretch,
    rest_shape_from_stretch,
)
from spiral_core.actuator.curvature import longest_stretch
from spiral_core.actuator.section_curve import SectionCurve
from spiral_core.section import path
from spiral_core.section.closure import closures
from spiral_core.section.fiber_set import Array, FiberSet
from spiral_core.section.path import motion_at, section_path
from spiral_core.wrap.gripper import stiffness_from_actuator

LAWS = (
    NeoHookean(c1=145.0e3),
    MooneyRivlin(c1=118.4e3, c2=105.7e3),
    Yeoh(c1=145.0e3, c2=-5.0e3, c3=1.0e3),
    Gent(shear_modulus=290.0e3, extension_limit=30.0),
)
STRAIGHT = (SingleFiber(),)


def section(
    alpha: float,
    beta: float,
    material: HyperelasticLaw = LATEX,
    tube: Tube = PAPER_TUBE,
    gamma: float = 0.0,
    apart: float = 0.0,
    thick_wall: bool = False,
) -> Actuator:
    """Return an actuator of the section law in its exact form; angles in degrees."""
    half = math.radians(0.5 * apart)
    places = (half, -half) if apart else (0.0,)
    singles = tuple(SingleFiber(math.radians(gamma), place) for place in places)
    return Actuator(
        tube,
        degrees(alpha, beta),
        material,
        curvature_form=CurvatureForm.EXACT,
        single_fibers=singles,
        thick_wall=thick_wall,
    )


def uniform(actuator: Actuator) -> Actuator:
    return dataclasses.replace(
        actuator,
        pressure_law=PressureLaw.UNIFORM,
        curvature_form=CurvatureForm.FIRST_ORDER,
        single_fibers=STRAIGHT,
        thick_wall=False,
    )


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
        shape = even.rest_shape_from_stretch(stretch)
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


def test_small_strain_of_a_hoop_family_is_three_halves_too() -> None:
    bent = section(90.0, 89.9)  # as good as no twist
    ratio = pressure_from_stretch(bent, 1.0 + 1e-7) / pressure_from_stretch(
        uniform(bent), 1.0 + 1e-7
    )
    assert ratio == pytest.approx(1.5, abs=1e-5)


@pytest.mark.parametrize(
    ("beta", "stretch", "factor"),
    [(70.0, 1.02, 1.474), (70.0, 1.1, 1.401), (70.0, 1.2, 1.359), (60.0, 1.1, 1.422),
     (60.0, 1.2, 1.416), (50.0, 1.1, 1.470), (50.0, 1.2, 1.578)],
)  # fmt: skip
def test_factors_of_the_papers_actuators(beta: float, stretch: float, factor: float) -> None:
    bent = section(88.0, beta, NeoHookean(c1=145.0e3))
    even = pressure_from_stretch(uniform(bent), stretch)
    assert pressure_from_stretch(bent, stretch) / even == pytest.approx(factor, abs=1e-3)


def energy(law: HyperelasticLaw):  # type: ignore[no-untyped-def]
    """Return a law's energy as its docstring has it, for complex arguments too."""
    match law:
        case NeoHookean(c1=c1):
            return lambda i, j: c1 * (i - 3.0)
        case MooneyRivlin(c1=c1, c2=c2):
            return lambda i, j: c1 * (i - 3.0) + c2 * (j - 3.0)
        case Yeoh(c1=c1, c2=c2, c3=c3):
            return lambda i, j: c1 * (i - 3.0) + c2 * (i - 3.0) ** 2 + c3 * (i - 3.0) ** 3
        case Gent(shear_modulus=mu, extension_limit=jm):
            return lambda i, j: -0.5 * mu * jm * np.log(1.0 - (i - 3.0) / jm)
    raise AssertionError(law)


def check_against_brute_force(bent: Actuator, singles: tuple[int, ...], fraction: float) -> None:
    """Compare a state with the minimum of energy minus pressure times volume."""
    actuation = FreeActuation(bent)
    assert isinstance(actuation.curve, SectionCurve)
    size = fraction * actuation.curve.strain_limit
    pressure = actuation.curve.energy.pressure_with_slope(size)[0]
    shape = actuation.unloaded_shape(pressure)
    radius, stretch = bent.wound_radius, shape.stretch or math.nan
    gamma = bent.single_fibers[0].angle if bent.single_fibers else 0.0
    brute = BruteSection((bent.fibers.alpha, bent.fibers.beta), gamma, singles)
    guess = Found(1.0, 0.01 if singles else 0.0, math.tan(gamma), 0.0, 0.0)
    wall = bent.tube.wall_area / (math.pi * radius**2)
    found = brute.solve(energy(bent.material), pressure, wall, guess)
    # SLSQP ends at a change of 1e-15 of the energy: half the digits of what minimizes it.
    assert found.stretch == pytest.approx(stretch, abs=2e-8)
    assert found.curvature == pytest.approx(shape.curvature * stretch * radius, abs=2e-8)
    assert found.torsion == pytest.approx(shape.torsion * stretch * radius, abs=2e-8)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pair", "gamma", "singles", "law", "fraction"),
    [
        ((88.0, 60.0), 0.0, (0,), 1, 0.1),
        ((88.0, 50.0), 0.0, (0,), 3, 0.2),
        ((65.0, -65.0), 0.0, (0,), 2, 0.5),
        ((88.0, 60.0), 20.0, (0,), 0, 0.1),
        ((75.0, 50.0), -35.0, (0,), 1, 0.1),
        ((88.0, 60.0), 15.0, (3, -3), 1, 0.1),
        ((88.0, 60.0), 0.0, (), 1, 0.1),
        ((45.0, -45.0), 0.0, (), 1, 0.4),
    ],
)
def test_brute_force_finds_the_same_state(
    pair: tuple[float, float],
    gamma: float,
    singles: tuple[int, ...],
    law: int,
    fraction: float,
) -> None:
    apart = 360.0 * 2 * max(singles, default=0) / POINTS
    bent = section(*pair, LAWS[law], gamma=gamma, apart=apart)
    check_against_brute_force(bent if singles else bent.without_single_fibers(), singles, fraction)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_brute_force_agrees_on_random_actuators(seed: int) -> None:
    """Pairs of one handedness and of opposite ones, straight and helical fibers, every law."""
    draw = np.random.default_rng(20260300 + seed)
    beta = draw.uniform(35.0, 75.0)
    alpha = draw.uniform(beta + 8.0, 90.0)
    if seed % 3 == 2:  # opposite hands, beyond the magic angle
        alpha, beta = draw.uniform(65.0, 85.0), -draw.uniform(65.0, 85.0)
    gamma = 0.0 if seed % 2 else draw.uniform(-30.0, 30.0)
    bent = section(alpha, beta, LAWS[seed % 4], gamma=gamma)
    limit = SectionCurve(bent).strain_limit
    check_against_brute_force(bent, (0,), draw.uniform(0.05, 0.3) * min(1.0, 2.0 / limit))


CASES = [
    section(88.0, 60.0),
    section(65.0, -65.0, LAWS[2]),
    section(88.0, 60.0, LAWS[3], gamma=20.0),
    section(80.0, 50.0, gamma=-30.0),
    section(88.0, 60.0, LAWS[1], apart=80.0),
    section(88.0, 60.0, thick_wall=True),
    section(45.0, -45.0).without_single_fibers(),
]


def wall_energy(curve: SectionCurve, actuator: Actuator, sizes: list[float]) -> np.ndarray:
    """Return the mean energy density [Pa] at far-side strains, from the invariants alone."""
    motion = motion_at(curve.path.fibers, curve.path.direction * np.array(sizes))
    densities = np.vectorize(actuator.material.energy_density)(
        3.0 + motion.first, 3.0 + motion.second
    )
    return np.asarray((motion.share * densities).sum(axis=1))


@pytest.mark.parametrize("bent", CASES, ids=range(len(CASES)))
@pytest.mark.parametrize("fraction", [0.02, 0.2, 0.7])
def test_work_done_is_energy_stored(bent: Actuator, fraction: float) -> None:
    curve = SectionCurve(bent)
    size = fraction * min(curve.strain_limit, 2.0)
    h = (2e-3 if fraction < 0.1 else 5e-4) * size  # rounding near rest, poles at the end
    sizes = [size + k * h for k in (-2, -1, 1, 2)]
    energy = wall_energy(curve, bent, sizes)
    rings = motion_at(curve.path.fibers, curve.path.direction * np.array(sizes)).ring
    volume = (1.0 + rings.stretch_change) * rings.hoop**2
    ratio = np.dot([1, -8, 8, -1], energy) / np.dot([1, -8, 8, -1], volume)
    pressure, slope = curve.energy.pressure_with_slope(size)
    wall = bent.tube.wall_area / (math.pi * bent.wound_radius**2)
    # Fourth-order differences: nine digits.
    assert pressure == pytest.approx(wall * ratio, rel=1e-9)
    steps = [curve.energy.pressure_with_slope(one)[0] for one in sizes]
    assert slope == pytest.approx(np.dot([1, -8, 8, -1], steps) / (12 * h), rel=1e-9)


@pytest.mark.parametrize("bent", CASES, ids=range(len(CASES)))
def test_curve_is_that_of_states_solved_alone(bent: Actuator) -> None:
    """Between its nodes too: the polynomials carry stretch and shape to twelve digits."""
    curve = SectionCurve(bent)
    sizes = np.linspace(0.013, 0.97, 7) * curve.strain_limit
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
        size = fraction * actuation.curve.strain_limit
        pressure = actuation.curve.energy.pressure_with_slope(size)[0]
        assert actuation.curve.strain_from_pressure(pressure) == pytest.approx(size, rel=1e-12)
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


def test_a_helical_fiber_coils_at_rest_as_it_is_wound() -> None:
    shape = FreeActuation(section(88.0, 60.0, gamma=20.0)).unloaded_shape(0.0)
    assert shape.curvature == 0.0
    assert shape.torsion == pytest.approx(math.tan(math.radians(20.0)) / PAPER_TUBE.inner_radius)


def test_the_end_of_a_steep_fibers_path_is_found_in_few_states(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where the section stops closing each state is dear: it is found in some ten rounds."""
    rounds = []

    def counted(fibers: FiberSet, strains: Array) -> tuple[Array, NDArray[np.bool_]]:
        rounds.append(len(strains))
        return closures(fibers, strains)

    monkeypatch.setattr(path, "closures", counted)
    fibers = section(88.0, 60.0, gamma=-60.0).fiber_set
    found = section_path.__wrapped__(fibers)
    assert len(rounds) < 30
    up_to_end = np.linspace(0.0, found.edges[-1], 97)[1:]
    assert closures(fibers, up_to_end)[1].all()


def test_two_fibers_bend_as_one_when_they_meet() -> None:
    one, two = FreeActuation(section(88.0, 60.0)), FreeActuation(section(88.0, 60.0, apart=0.2))
    shape, other = one.unloaded_shape(60.0e3), two.unloaded_shape(60.0e3)
    assert other.curvature == pytest.approx(shape.curvature, rel=1e-5)  # cos(0.1 deg)
    assert other.torsion == pytest.approx(shape.torsion, rel=1e-5)


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
    size = actuation.curve.strain_limit
    assert 0.0 < path.volume_slope(size) < 1e-3 * path.volume_slope(0.0)
    with pytest.raises(ActuationLimitError, match="stretch"):
        actuation.pressure_from_stretch(actuation.stretch_limit + 1e-6)
    with pytest.raises(ActuationLimitError, match="stretch"):
        rest_shape_from_stretch(actuation.actuator, actuation.stretch_limit + 1e-2)


def test_a_soft_law_balloons_and_a_short_one_runs_out() -> None:
    soft = section(88.0, 70.0, Yeoh(c1=145.0e3, c2=-400.0e3, c3=400.0e3))
    actuation = FreeActuation(soft)
    assert actuation.limit is ActuationLimit.LIMIT_POINT
    size = actuation.curve.strain_limit
    assert (
        abs(actuation.curve.energy.pressure_with_slope(size)[1]) < 1e-6 * actuation.pressure_limit
    )
    brittle = FreeActuation(section(88.0, 60.0, Gent(290.0e3, 0.1)))
    assert brittle.limit is ActuationLimit.MATERIAL_LIMIT
    motion = motion_at(brittle.curve.path.fibers, np.array([brittle.curve.strain_limit]))
    assert 0.099 < motion.first.max() < 0.1


def test_first_order_form_ends_with_the_even_tubes_twist() -> None:
    bent = dataclasses.replace(section(30.0, 40.0), curvature_form=CurvatureForm.FIRST_ORDER)
    actuation = FreeActuation(bent)
    assert actuation.limit is ActuationLimit.FIBER_LOCKING
    assert actuation.stretch_limit < 1.0 / math.cos(math.radians(30.0))
    actuation.unloaded_shape(actuation.pressure_limit)


def test_a_contracting_tube_shortens_unless_a_single_fiber_would_have_to_push() -> None:
    actuation = FreeActuation(section(45.0, -45.0).without_single_fibers())
    assert actuation.stretch_limit < actuation.stretch_from_pressure(20.0e3) < 1.0
    with pytest.raises(InvalidInputError, match="at most 1"):
        actuation.pressure_from_stretch(1.01)
    with pytest.raises(InvalidInputError, match="pair that extends"):
        FreeActuation(section(45.0, -45.0))


@pytest.mark.parametrize(
    ("choices", "match"),
    [
        ({"twist_shear": False}, "twist_shear"),
        ({"thick_wall": True, "pressure_law": PressureLaw.UNIFORM}, "thick_wall"),
        ({"single_fibers": (SingleFiber(0.2),), "pressure_law": PressureLaw.UNIFORM}, "section"),
        ({"single_fibers": (SingleFiber(0.2),), "curvature_form": CurvatureForm.FIRST_ORDER},
         "exact"),
        ({"single_fibers": (SingleFiber(0.1), SingleFiber(0.2, 1.0))}, "fibers that cross"),
        ({"single_fibers": (SingleFiber(math.radians(60.0)),)}, "another angle"),
        ({"single_fibers": (SingleFiber(), SingleFiber(0.0, 1.0), SingleFiber(0.0, 2.0))},
         "at most 2"),
        ({"single_fibers": (SingleFiber(), SingleFiber(0.0, math.pi))}, "170 degrees"),
        ({"single_fibers": (SingleFiber(), SingleFiber())}, "they are one"),
        ({"single_fibers": (3.0,)}, "SingleFiber"),
    ],
)  # fmt: skip
def test_contradictions_are_refused(choices: dict[str, object], match: str) -> None:
    with pytest.raises(InvalidInputError, match=match):
        dataclasses.replace(section(88.0, 60.0), **choices)  # type: ignore[arg-type]


def one_family(angle: float, law: HyperelasticLaw = LATEX, gamma: float = 0.0) -> Actuator:
    """Return a tube with one wound family and a single fiber; angles in degrees."""
    return Actuator(
        PAPER_TUBE,
        OneFamily(math.radians(angle)),
        law,
        curvature_form=CurvatureForm.EXACT,
        single_fibers=(SingleFiber(math.radians(gamma)),),
    )


def test_one_hoop_family_bends_without_twist() -> None:
    """Without a second family nothing turns it; at small strain the hoop keeps plane sections."""
    hoop = FreeActuation(one_family(90.0, NeoHookean(c1=145.0e3)))
    shape = hoop.unloaded_shape(20.0e3)
    assert shape.curvature > 1.0
    assert abs(shape.torsion) < 1e-9
    # Plane strain, bending about the straight fiber: P = 3/2 (A / pi r^2) 4/3 E (lambda - 1).
    wall = PAPER_TUBE.wall_area / (math.pi * PAPER_TUBE.inner_radius**2)
    stretch = hoop.stretch_from_pressure(10.0)
    linear = 1.5 * wall * (4.0 / 3.0) * 6.0 * 145.0e3 * (stretch - 1.0)
    assert linear == pytest.approx(10.0, rel=1e-3)  # of the order of the strain


def test_one_family_and_its_mirror_image() -> None:
    right, left = FreeActuation(one_family(70.0)), FreeActuation(one_family(-70.0))
    one, other = right.unloaded_shape(40.0e3), left.unloaded_shape(40.0e3)
    assert one.torsion < -1.0
    assert other.torsion == pytest.approx(-one.torsion, rel=1e-8)
    assert other.curvature == pytest.approx(one.curvature, rel=1e-8)
    pressure = right.pressure_from_stretch(one.stretch or math.nan)
    assert pressure == pytest.approx(40.0e3, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize(("angle", "gamma"), [(70.0, 0.0), (90.0, 0.0), (75.0, 20.0)])
def test_brute_force_finds_the_same_hoop(angle: float, gamma: float) -> None:
    bent = one_family(angle, gamma=gamma)
    actuation = FreeActuation(bent)
    pressure = actuation.curve.energy.pressure_with_slope(0.3)[0]
    shape = actuation.unloaded_shape(pressure)
    radius, stretch = PAPER_TUBE.inner_radius, shape.stretch or math.nan
    brute = BruteSection((math.radians(angle),), math.radians(gamma))
    wall = PAPER_TUBE.wall_area / (math.pi * radius**2)
    guess = Found(1.0, 0.01, math.tan(math.radians(gamma)), 0.0, 0.0)
    found = brute.solve(energy(LATEX), pressure, wall, guess)
    # Twelve angles there, 21 points here; SLSQP ends at half the digits of what it minimizes.
    assert found.stretch == pytest.approx(stretch, abs=1e-7)
    assert found.curvature == pytest.approx(shape.curvature * stretch * radius, abs=1e-7)
    assert found.torsion == pytest.approx(shape.torsion * stretch * radius, abs=1e-7)


def test_what_needs_two_families_says_so() -> None:
    with pytest.raises(InvalidInputError, match="two families"):
        rest_shape_from_stretch(one_family(70.0), 1.1)
    for choices in ({"thick_wall": True}, {"pressure_law": PressureLaw.UNIFORM},
                    {"curvature_form": CurvatureForm.FIRST_ORDER}):  # fmt: skip
        with pytest.raises(InvalidInputError, match="famil"):
            dataclasses.replace(one_family(70.0), **choices)
    with pytest.raises(InvalidInputError, match="extends the tube"):
        FreeActuation(one_family(30.0))


def test_bending_a_thin_tube_about_its_straight_fiber_takes_four_times_ei() -> None:
    """Plane strain (4/3 E) about the edge (3/2 x 2 of the diameter's I): 4 E I at rest."""
    tube = Tube(1.0, 1e-4, 10.0)
    stiffness = FreeActuation(section(90.0, 89.9, tube=tube)).curve.stiffness(0.0)
    annulus = stiffness_from_actuator(section(90.0, 89.9, tube=tube))
    assert stiffness.bending == pytest.approx(4.0 * annulus.bending, rel=1e-3)  # t/r, 0.1 degrees
    assert FreeActuation(section(65.0, -65.0)).curve.stiffness(0.0).torsional == math.inf


@pytest.mark.parametrize("gamma", [0.0, 20.0])
def test_stiffness_is_the_second_derivative_of_energy_less_work(gamma: float) -> None:
    bent = section(88.0, 60.0, gamma=gamma)
    curve = SectionCurve(bent)
    pressure = 60.0e3
    size = curve.strain_from_pressure(pressure)
    h = 2e-3 * size
    sizes = [size + k * h for k in (-2, -1, 0, 1, 2)]
    rings = motion_at(curve.path.fibers, np.array(sizes)).ring
    energy = PAPER_TUBE.wall_area * wall_energy(curve, bent, sizes)
    volume = math.pi * bent.wound_radius**2 * (1.0 + rings.stretch_change) * rings.hoop**2
    curvatures = rings.bend / rings.hoop / bent.wound_radius
    rise = np.dot([-1, 16, -30, 16, -1], energy - pressure * volume) / (12 * h * h)
    bend = np.dot([1, -8, 0, 8, -1], curvatures) / (12 * h)
    stiffness = curve.stiffness(pressure)
    assert stiffness.bending == pytest.approx(rise / bend**2, rel=1e-6)  # second differences
    twists = rings.twist / rings.hoop / bent.wound_radius
    twist = np.dot([1, -8, 0, 8, -1], twists) / (12 * h)
    assert stiffness.twist_per_curvature == pytest.approx(twist / bend, rel=1e-8)
    assert stiffness.torsional == pytest.approx(rise / twist**2, rel=1e-6)


def test_stiffness_needs_two_families_and_a_single_fiber() -> None:
    with pytest.raises(InvalidInputError, match="makes the section bend"):
        SectionCurve(section(88.0, 60.0).without_single_fibers()).stiffness(0.0)
    with pytest.raises(InvalidInputError, match="two families"):
        SectionCurve(one_family(70.0)).stiffness(0.0)


def test_straight_sections_that_shorten_have_shapes_in_both_forms() -> None:
    exact = section(45.0, -45.0).without_single_fibers()
    for form in CurvatureForm:
        actuation = FreeActuation(dataclasses.replace(exact, curvature_form=form))
        shape = actuation.unloaded_shape(20.0e3)
        assert shape.curvature == 0.0
        assert shape.stretch == pytest.approx(actuation.stretch_from_pressure(20.0e3), rel=1e-14)
    with pytest.raises(InvalidInputError, match="at most 1 for these"):
        rest_shape_from_stretch(exact, 1.01)
    spiral = dataclasses.replace(section(50.0, -40.0), single_fibers=())
    even = FreeActuation(spiral).unloaded_shape(10.0e3)
    first = dataclasses.replace(spiral, curvature_form=CurvatureForm.FIRST_ORDER)
    paper = FreeActuation(first).unloaded_shape(10.0e3)
    assert even.torsion * (even.stretch or 0.0) == pytest.approx(paper.torsion, rel=1e-10)


def test_first_order_twist_of_a_thick_wall_is_that_of_its_wound_fibers() -> None:
    thick = dataclasses.replace(
        section(88.0, 60.0, thick_wall=True), curvature_form=CurvatureForm.FIRST_ORDER
    )
    shape = rest_shape_from_stretch(thick, 1.1)
    twist = fiber_state(thick.fiber_pair, 1.1).twist
    assert shape.torsion == pytest.approx(twist / PAPER_TUBE.outer_radius, rel=1e-14)
    assert shape.curvature == pytest.approx(0.1 / PAPER_TUBE.outer_radius, rel=1e-14)


def test_design_space_ends_where_the_fibers_do() -> None:
    (space,) = design_space(section(88.0, 60.0), [math.radians(50.0)], stretch_max=3.0)
    assert 1.47 < space.stretch[-1] < longest_stretch(section(88.0, 50.0)) < 1.48
