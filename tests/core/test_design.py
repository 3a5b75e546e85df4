# SPDX-License-Identifier: Apache-2.0
"""The design procedure: the paper's example, what each step says, and that the answer holds."""

import math
import pickle
import re
from dataclasses import replace

import numpy as np
import pytest
from core.design_cases import (
    CATALOG,
    PAPER_EXAMPLE,
    PAPER_TUBE,
    WEIGHTLESS,
    angles,
    answered,
    designed,
)

from spiral_core import (
    Constraint,
    CurvatureForm,
    Elastomer,
    FreeActuation,
    MooneyRivlin,
    NotGrippableError,
    Preference,
    PressureLaw,
    TubeSize,
    WrapCurve,
    design_gripper,
)
from spiral_core.design.evaluation import estimate_candidate
from spiral_core.design.helix_estimate import helix_radius, helix_stretch, widest_helix
from spiral_core.wrap.placement import place_object

pytestmark = pytest.mark.long

G = 9.80665
CALLS = []


@pytest.fixture(scope="module")
def report():
    """Return the paper's example, designed."""
    return design_gripper(PAPER_EXAMPLE, lambda *call: CALLS.append(call), contact=False)


@pytest.fixture(scope="module")
def design(report):
    assert report.feasible
    return report.design


def test_paper_example_chooses_70_degrees_and_the_papers_length(design):
    assert math.degrees(design.actuator.fibers.beta) == pytest.approx(70.0)
    # The paper's 361 mm, whose turns it does not state; we infer 1.5.
    assert design.helix_length == pytest.approx(0.361, rel=0.01)
    assert design.helix_length == pytest.approx(0.36403, abs=5e-6)
    # Pinned to the tolerance of the length's search (3e-3 of the largest radius).
    assert design.length == pytest.approx(0.3728, rel=3e-3)
    assert design.largest.pressure == pytest.approx(44.03e3, rel=3e-3)
    assert design.smallest.pressure == pytest.approx(78.19e3, rel=3e-3)
    assert design.smallest.strain == pytest.approx(0.2412, rel=3e-3)
    assert design.cut_length == pytest.approx(design.length + 0.04, rel=1e-12)


@pytest.mark.parametrize(
    ("object_length", "beta"), [(0.15, 80.0), (0.205, 70.0), (0.258, 70.0), (0.27, 60.0)]
)
def test_the_object_length_decides_between_the_angles(object_length, beta):
    # The limits under which the paper's choice is ours: an object length of 201 to 262 mm.
    design = designed(replace(PAPER_EXAMPLE, object_length=object_length))
    assert design.actuator.fibers.beta == pytest.approx(math.radians(beta))


def test_the_answer_meets_the_requirement_when_solved_afresh(design):
    curve = WrapCurve(design.gripper)
    for grip, placement in zip((design.largest, design.smallest), design.placements, strict=True):
        wrap = curve.wrap_for_radius(grip.radius)
        # Another pressure range is sampled than in the search: other elements, 1e-4 of the figures.
        assert wrap.pressure == pytest.approx(grip.pressure, rel=1e-4)
        assert wrap.unloaded_shape.stretch == pytest.approx(grip.stretch, rel=1e-4)
        assert wrap.turns >= 1.5
        # The turns that hold the object end at a node.
        assert placement.center == pytest.approx(place_object(wrap).center, abs=1e-3)
    assert curve.pressure_max <= design.gripper.pressure_max == 110.316e3
    ends = pytest.approx((design.radius_min, design.radius_max), rel=1e-3)
    assert (curve.radius_min, curve.radius_max) == ends
    assert 1.5 <= design.largest.turns < 1.51
    points = [(point.radius, point.pressure) for point in design.curve]
    assert points[-1] == pytest.approx((11.0e-3, design.smallest.pressure), rel=1e-4)
    assert np.diff(points, axis=0)[:, 1].min() > 0.0


def test_seven_steps_each_with_its_result(report):
    assert [step.number for step in report.steps] == [1, 2, 3, 4, 5, 6, 7]
    figures = {f"{s.number} {f.name}": f.value for s in report.steps for f in s.figures}
    assert all(step.satisfied and step.remark for step in report.steps)
    assert all(map(math.isfinite, figures.values()))
    assert figures["2 largest object radius / tube radius"] == pytest.approx(30.0 / 4.7625)
    helix, exact = (figures[f"{k} object length at the largest object"] for k in (5, 6))
    # Gravity pulls the coil apart.
    assert 1.2 * helix < exact < 1.6 * helix
    assert re.search(
        r"50 deg fails as a helix \(object length.*60 deg fails as a rod \(object length"
        ".*70 deg taken.*80 deg would do too",
        report.steps[2].remark,
    )
    numbers, _, names = zip(*CALLS, strict=True)
    assert numbers == tuple(range(len(report.tried)))
    assert [name[-6:] for name in names] == ["60 deg", "70 deg", "80 deg"]
    assert pickle.loads(pickle.dumps(report)) == report
    chosen = [one for one in report.design.margins if not one.constraint.is_met_just_so]
    assert report.binding is min(chosen, key=lambda margin: margin.relative)


def test_without_gravity_the_helix_is_exact():
    wanted = replace(PAPER_EXAMPLE, **WEIGHTLESS, fiber_angles_beta=(1.2,))
    for form in CurvatureForm:
        one_form = replace(wanted, curvature_form=form)
        design = designed(one_form)
        assert design.actuator.curvature_form is form
        # The search for the length ends within 3e-3 of the largest radius.
        assert 1.0 - 1e-6 <= design.length / design.helix_length <= 1.003
        estimate = estimate_candidate(one_form, *one_form.candidates())
        # The rod's discretization: 1e-5 of the length.
        assert design.smallest.pressure == pytest.approx(estimate.smallest.pressure, rel=2e-4)


def test_mirrored_fibers_give_the_mirrored_gripper():
    wanted = replace(PAPER_EXAMPLE, fiber_angles_beta=angles(70.0))
    right, left = (
        designed(wanted),
        designed(
            replace(wanted, fiber_angle_alpha=math.radians(-88.0), fiber_angles_beta=angles(-70.0))
        ),
    )
    assert left.length == pytest.approx(right.length, rel=1e-9)
    assert left.smallest.pressure == pytest.approx(right.smallest.pressure, rel=1e-7)
    assert {winding.hand for winding in left.windings} == {"left"}


def test_without_gravity_lengths_scale_with_the_radii_and_pressures_with_the_stiffness():
    weightless = replace(PAPER_EXAMPLE, **WEIGHTLESS)
    stiff = Elastomer("stiff", MooneyRivlin(260.0e3, 30.0e3), 950.0, PressureLaw.UNIFORM)
    scaled = replace(
        weightless,
        radius_min=5.5e-3,
        radius_max=15.0e-3,
        tubes=(TubeSize("s", 0.5 * PAPER_TUBE.inner_radius, 0.5 * PAPER_TUBE.wall_thickness),),
        elastomers=(stiff,),
    )
    one, other = designed(weightless), designed(scaled)
    assert other.length == pytest.approx(0.5 * one.length, rel=1e-6)
    assert other.smallest.pressure == pytest.approx(2.0 * one.smallest.pressure, rel=1e-6)
    assert one.gripper.pressure_max == pytest.approx(1.2 * one.smallest.pressure, rel=1e-12)
    assert one.radius_min == WrapCurve(one.gripper).radius_min < PAPER_EXAMPLE.radius_min


@pytest.mark.parametrize(
    ("gravity", "roll"),
    [
        ((-G, 0.0, 0.0), None),
        ((0.0, 0.0, 0.0), None),
        ((0.0, G, 0.0), 0.0),
        ((0.6 * G, 0.0, -0.8 * G), -0.5 * math.pi),
    ],
)
def test_the_roll_of_the_clamp_is_from_the_straight_fiber_to_gravity(design, gravity, roll):
    mounted = replace(design, gripper=design.gripper.with_mount(gravity, None))
    assert mounted.roll == (None if roll is None else pytest.approx(roll))


@pytest.mark.slow
def test_a_known_direction_of_the_objects_is_designed_for():
    """Gaps of the range do not lie between the objects, and no error ends the procedure."""
    tilted = {"gravity": (0.8 * G, 0.6 * G, 0.0), "object_axis": (1.0, 0.0, 0.0)}
    found = answered(replace(PAPER_EXAMPLE, **tilted, object_length=None))
    assert found.binding is not None
    if found.feasible:
        curve = WrapCurve(found.design.gripper)
        for radius in np.linspace(11.0e-3, 30.0e-3, 25).tolist():
            assert curve.wrap_for_radius(radius).turns >= 1.5 - 1e-6


FIGURES = {
    Preference.LEAST_STRAIN: lambda d: d.smallest.strain,
    Preference.LEAST_PRESSURE: lambda d: d.smallest.pressure,
    Preference.SHORTEST: lambda d: d.length,
    Preference.LARGEST_MARGIN: lambda d: (
        -min(m.relative for m in d.margins if not m.constraint.is_met_just_so)
    ),
}


@pytest.mark.parametrize(
    "preference",
    [
        pytest.param(each, marks=pytest.mark.slow if each is Preference.LARGEST_MARGIN else ())
        for each in Preference
    ],
)
def test_preference_is_kept_over_the_catalog(preference):
    wanted, figure = replace(PAPER_EXAMPLE, preference=preference), FIGURES[preference]
    tubes = CATALOG[9:16:3]
    chosen = figure(designed(replace(wanted, tubes=tubes)))
    for tube in tubes:
        other = figure(designed(replace(wanted, tubes=(tube,))))
        # Candidates are ordered as helices: gravity may shift figures that are this near.
        assert chosen <= other + 0.02 * abs(other)


def test_one_radius_only_is_a_range_too():
    design = designed(replace(PAPER_EXAMPLE, radius_min=0.02, radius_max=0.02))
    assert design.largest.pressure == pytest.approx(design.smallest.pressure, rel=1e-6)
    assert type(design.gripper.name) is str  # for a file: no message that keeps its quantities


HELICAL = replace(
    PAPER_EXAMPLE,
    elastomers=(Elastomer("section latex", MooneyRivlin(c1=95.0e3, c2=10.0e3), density=950.0),),
    fiber_angles_beta=angles(70.0),
    object_length=None,
    pressure_max=None,
    strain_max=None,
)


def test_the_single_fibers_angle_is_chosen_when_asked():
    straight, wanted = designed(HELICAL), replace(HELICAL, fiber_angles_gamma=angles(0.0, 2.0))
    assert designed(wanted).fiber_angle == 0.0  # the least strain
    shorter = designed(replace(wanted, preference=Preference.SHORTEST))
    assert shorter.fiber_angle == pytest.approx(math.radians(2.0))
    assert shorter.length < 0.99 * straight.length
    assert "gamma 2 deg" in shorter.sentence
    for grip in (shorter.largest, shorter.smallest):
        wrap = WrapCurve(shorter.gripper).wrap_for_radius(grip.radius)
        assert wrap.pressure == pytest.approx(grip.pressure, rel=1e-6)
        assert wrap.turns >= 1.5 - 1e-6


def test_a_helix_about_a_helical_fiber_is_widest_at_some_stretch():
    (candidate,) = replace(HELICAL, fiber_angles_gamma=angles(4.0)).candidates()
    actuation = FreeActuation(candidate.actuator(HELICAL, 0.36))
    widest, _ = widest_helix(actuation)
    radii = [helix_radius(actuation, x) for x in np.linspace(1.001, actuation.stretch_limit, 400)]
    assert radii[0] < max(radii) <= widest < 1.001 * max(radii)
    stretch = helix_stretch(actuation, 0.9 * widest)
    assert helix_radius(actuation, stretch) == pytest.approx(0.9 * widest, rel=1e-9)
    with pytest.raises(NotGrippableError, match="too thick: the single fiber winds") as caught:
        helix_stretch(actuation, 1.01 * widest)
    assert caught.value.nearest_radius == widest
    # So steep that no coil is wide enough.
    steep = replace(HELICAL, fiber_angles_gamma=angles(12.0))
    report = answered(steep)
    assert report.binding.constraint is Constraint.LARGEST_RADIUS
    designed(replace(steep, radius_max=report.relaxations[0].sufficient))


def test_the_fifth_step_states_the_margin_of_the_object_length(report):
    assert report.steps[4].remark.startswith("object length: ")
