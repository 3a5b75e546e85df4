# SPDX-License-Identifier: Apache-2.0
"""The design procedure: the paper's example, what each step says, and that the answer holds."""

import pickle
from dataclasses import replace
from math import pi, radians

import numpy as np
import pytest
from core.design_cases import (
    CATALOG,
    LATEX,
    PAPER_EXAMPLE,
    PAPER_TUBE,
    WEIGHTLESS,
    angles,
    answered,
    designed,
)
from core.recorded import recorded
from numpy.testing import assert_allclose

from spiral_core import (
    Constraint,
    CurvatureForm,
    Elastomer,
    FreeActuation,
    MooneyRivlin,
    NotGrippableError,
    Preference,
    TubeSize,
    WrapCurve,
    design_gripper,
)
from spiral_core.design.evaluation import estimate_candidate
from spiral_core.design.helix_estimate import helix_radius, helix_stretch, widest_helix
from spiral_core.wrap.placement import place_object

pytestmark = pytest.mark.long

G = 9.80665


@pytest.fixture(scope="module")
def report():
    """Return the paper's example, designed."""
    return design_gripper(PAPER_EXAMPLE, contact=False)


@pytest.fixture(scope="module")
def design(report):
    assert report.feasible
    return report.design


def test_the_papers_example_is_recorded(report):
    """It has the paper's 70 degrees; its 361 mm is asked of the helix, by test_paper_charts."""
    recorded("design/paper", [report, [margin.sentence for margin in report.design.margins]])
    assert_allclose(report.design.actuator.fibers.beta, radians(70.0))
    assert pickle.loads(pickle.dumps(report)) == report
    chosen = [one for one in report.design.margins if not one.constraint.is_met_just_so]
    assert report.binding is min(chosen, key=lambda margin: margin.relative)


def test_the_object_length_decides_between_the_angles():
    for object_length, beta in [(0.15, 80.0), (0.205, 70.0), (0.258, 70.0), (0.27, 60.0)]:
        # The limits under which the paper's choice is ours: an object length of 201 to 262 mm.
        design = designed(object_length=object_length)
        assert_allclose(design.actuator.fibers.beta, radians(beta))


def test_the_answer_meets_the_requirement_when_solved_afresh(design):
    curve = WrapCurve(design.gripper)
    for grip, placement in zip((design.largest, design.smallest), design.placements, strict=True):
        wrap = curve.wrap_for_radius(grip.radius)
        # Another pressure range is sampled than in the search: other elements, 1e-4 of the figures.
        found = wrap.pressure, wrap.unloaded_shape.stretch
        assert_allclose(found, (grip.pressure, grip.stretch), 1e-4)
        assert wrap.turns >= 1.5
        # The turns that hold the object end at a node.
        assert_allclose(placement.center, place_object(wrap).center, atol=1e-3)
    assert curve.pressure_max <= design.gripper.pressure_max == 110.316e3
    assert type(design.gripper.name) is str  # for a file: no message that keeps its quantities
    ends = design.radius_min, design.radius_max
    assert_allclose((curve.radius_min, curve.radius_max), ends, 1e-3)
    assert 1.5 <= design.largest.turns < 1.51
    points = [(point.radius, point.pressure) for point in design.curve]
    assert_allclose(points[-1], (11.0e-3, design.smallest.pressure), 1e-4)
    assert np.diff(points, axis=0)[:, 1].min() > 0.0


def test_without_gravity_the_helix_is_exact():
    for form in CurvatureForm:
        wanted = replace(PAPER_EXAMPLE, **WEIGHTLESS, fiber_angles_beta=(1.2,), curvature_form=form)
        design, estimate = designed(wanted), estimate_candidate(wanted, *wanted.candidates())
        assert design.actuator.curvature_form is form
        # The search for the length ends within 3e-3 of the largest radius.
        assert 1.0 - 1e-6 <= design.length / design.helix_length <= 1.003
        # The rod's discretization: 1e-5 of the length.
        assert_allclose(design.smallest.pressure, estimate.smallest.pressure, 2e-4)


def test_mirrored_fibers_give_the_mirrored_gripper():
    right, left = (
        designed(fiber_angle_alpha=radians(hand * 88.0), fiber_angles_beta=angles(hand * 70.0))
        for hand in (1, -1)
    )
    assert_allclose(left.length, right.length, 1e-9)
    assert_allclose(left.smallest.pressure, right.smallest.pressure, 1e-7)
    assert {winding.hand for winding in left.windings} == {"left"}


def test_without_gravity_lengths_scale_with_the_radii_and_pressures_with_the_stiffness():
    weightless = replace(PAPER_EXAMPLE, **WEIGHTLESS)
    scaled = replace(
        weightless,
        radius_min=5.5e-3,
        radius_max=15.0e-3,
        tubes=(TubeSize("s", 0.5 * PAPER_TUBE.inner_radius, 0.5 * PAPER_TUBE.wall_thickness),),
        elastomers=(replace(LATEX, law=MooneyRivlin(260.0e3, 30.0e3)),),
    )
    one, other = designed(weightless), designed(scaled)
    assert_allclose(other.length, 0.5 * one.length, 1e-6)
    assert_allclose(other.smallest.pressure, 2.0 * one.smallest.pressure, 1e-6)
    assert_allclose(one.gripper.pressure_max, 1.2 * one.smallest.pressure, 1e-12)
    assert one.radius_min == WrapCurve(one.gripper).radius_min < PAPER_EXAMPLE.radius_min


def test_the_roll_of_the_clamp_is_from_the_straight_fiber_to_gravity(design):
    for gravity, roll in [
        ((-G, 0.0, 0.0), None),
        ((0.0, 0.0, 0.0), None),
        ((0.0, G, 0.0), 0.0),
        ((0.6 * G, 0.0, -0.8 * G), -0.5 * pi),
    ]:
        mounted = replace(design, gripper=design.gripper.with_mount(gravity, None))
        assert mounted.roll == (roll and pytest.approx(roll))


@pytest.mark.slow
def test_a_known_direction_of_the_objects_is_designed_for():
    """Gaps of the range do not lie between the objects, and no error ends the procedure."""
    tilted = {"gravity": (0.8 * G, 0.6 * G, 0.0), "object_axis": (1.0, 0.0, 0.0)}
    found = answered(**tilted, object_length=None)
    assert found.binding is not None
    if found.feasible:
        curve = WrapCurve(found.design.gripper)
        for radius in np.linspace(11.0e-3, 30.0e-3, 25):
            assert curve.wrap_for_radius(radius).turns >= 1.5 - 1e-6


FIGURES = {
    "LEAST_STRAIN": lambda d: d.smallest.strain,
    "LEAST_PRESSURE": lambda d: d.smallest.pressure,
    "SHORTEST": lambda d: d.length,
    "LARGEST_MARGIN": lambda d: (
        -min(m.relative for m in d.margins if not m.constraint.is_met_just_so)
    ),
}


@pytest.mark.parametrize(
    "name", [*[*FIGURES][:3], pytest.param("LARGEST_MARGIN", marks=pytest.mark.slow)]
)
def test_preference_is_kept_over_the_catalog(name):
    wanted, tubes = replace(PAPER_EXAMPLE, preference=Preference[name]), CATALOG[9:16:3]
    chosen, *others = (
        FIGURES[name](designed(wanted, tubes=among))
        for among in (tubes, *((tube,) for tube in tubes))
    )
    # Candidates are ordered as helices: gravity may shift figures that are this near.
    assert chosen <= min(other + 0.02 * abs(other) for other in others)


HELICAL = replace(
    PAPER_EXAMPLE,
    elastomers=(Elastomer("section latex", MooneyRivlin(95.0e3, 10.0e3), density=950.0),),
    fiber_angles_beta=angles(70.0),
    **dict.fromkeys(("object_length", "pressure_max", "strain_max")),
)


def test_the_single_fibers_angle_is_chosen_when_asked():
    straight, wanted = designed(HELICAL), replace(HELICAL, fiber_angles_gamma=angles(0.0, 2.0))
    assert designed(wanted).fiber_angle == 0.0  # the least strain
    shorter = designed(wanted, preference=Preference.SHORTEST)
    assert_allclose(shorter.fiber_angle, radians(2.0))
    assert shorter.length < 0.99 * straight.length
    assert "gamma 2 deg" in shorter.sentence
    for grip in (shorter.largest, shorter.smallest):
        wrap = WrapCurve(shorter.gripper).wrap_for_radius(grip.radius)
        assert_allclose(wrap.pressure, grip.pressure, 1e-6)
        assert wrap.turns >= 1.5 - 1e-6


def test_a_helix_about_a_helical_fiber_is_widest_at_some_stretch():
    (candidate,) = replace(HELICAL, fiber_angles_gamma=angles(4.0)).candidates()
    actuation = FreeActuation(candidate.actuator(HELICAL, 0.36))
    widest, _ = widest_helix(actuation)
    radii = [helix_radius(actuation, x) for x in np.linspace(1.001, actuation.stretch_limit, 400)]
    assert radii[0] < max(radii) <= widest < 1.001 * max(radii)
    stretch = helix_stretch(actuation, 0.9 * widest)
    assert_allclose(helix_radius(actuation, stretch), 0.9 * widest, 1e-9)
    with pytest.raises(NotGrippableError, match="too thick: the single fiber winds") as caught:
        helix_stretch(actuation, 1.01 * widest)
    assert caught.value.nearest_radius == widest
    # So steep that no coil is wide enough.
    steep = replace(HELICAL, fiber_angles_gamma=angles(12.0))
    report = answered(steep)
    assert report.binding.constraint is Constraint.LARGEST_RADIUS
    designed(steep, radius_max=report.relaxations[0].sufficient)
