# SPDX-License-Identifier: Apache-2.0
"""Gripper description files: what is read, and each kind of mistake with its exact message."""

import math
import pickle

import pytest
from edge.description_cases import (
    COMPLETE,
    PRESSURE,
    SMALLEST,
    STANDARD_PSI,
    UNIFORM,
    WRONG_VALUES,
    changed,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from spiral_core import (
    CurvatureForm,
    Gent,
    MooneyRivlin,
    NeoHookean,
    PressureLaw,
    SpiralError,
    Yeoh,
)
from spiral_core.errors import ActuationLimit
from spiral_core.wrap.gripper import DEFAULT_TURNS, STANDARD_GRAVITY
from spiral_gripper import DescriptionError, ProblemKind, load_description, load_gripper


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Return a function that loads a text as the file mine.yaml of the current folder."""
    monkeypatch.chdir(tmp_path)

    def load(text):
        (tmp_path / "mine.yaml").write_text(text, encoding="utf-8")
        return load_description("mine.yaml")

    return load


def test_smallest_file_and_its_defaults(load):
    description = load(SMALLEST)
    gripper = description.gripper
    assert (description.source.name, description.description) == ("mine.yaml", "")
    assert gripper.name == "smallest"
    assert gripper.tube == description.actuator.tube
    assert gripper.tube.inner_radius == 4.7625e-3
    assert gripper.tube.wall_thickness == 0.79375e-3
    assert gripper.tube.length == 0.5
    assert description.actuator.fibers.alpha == pytest.approx(math.radians(88), rel=1e-15)
    assert description.actuator.fibers.beta == pytest.approx(math.radians(60), rel=1e-15)
    assert description.actuator.material == MooneyRivlin(c1=130e3, c2=15e3)
    assert description.actuator.straight_fiber_radius is None
    assert description.actuator.curvature_form is CurvatureForm.FIRST_ORDER
    assert description.actuator.pressure_law is PressureLaw.SECTION
    assert description.actuator.twist_shear is True
    assert (description.density, description.extra_mass_per_length) == (950.0, 0.0)
    assert gripper.gravity == (STANDARD_GRAVITY, 0.0, 0.0)
    assert gripper.object_axis is None
    assert gripper.pressure_max == pytest.approx(16 * STANDARD_PSI, rel=1e-15)
    assert gripper.turns_required == DEFAULT_TURNS
    assert gripper.friction_coefficient is None
    tube = gripper.tube
    modulus = description.actuator.material.small_strain_modulus
    assert gripper.stiffness.bending == modulus * tube.second_moment_of_area
    assert gripper.stiffness.torsional == modulus / 3 * tube.polar_moment_of_area
    assert gripper.weight_per_length == 950.0 * tube.wall_area * STANDARD_GRAVITY


def test_complete_file(load):
    description = load(COMPLETE)
    actuator, gripper = description.actuator, description.gripper
    assert description.description == "Everything that a file can say"
    assert actuator.fibers.beta == pytest.approx(-math.radians(60), rel=1e-15)
    assert actuator.straight_fiber_radius == 5.5e-3
    assert actuator.material == Gent(shear_modulus=290e3, extension_limit=50.0)
    assert actuator.curvature_form is CurvatureForm.EXACT
    assert actuator.pressure_law is PressureLaw.UNIFORM
    assert actuator.twist_shear is False
    assert (gripper.stiffness.bending, gripper.stiffness.torsional) == (4e-4, 3e-4)
    assert description.extra_mass_per_length == 2e-3
    mass = 960.0 * gripper.tube.wall_area + 2e-3
    assert gripper.weight_per_length == pytest.approx(mass * STANDARD_GRAVITY, rel=1e-15)
    assert gripper.gravity == pytest.approx((0.0, 6.0, -8.0), rel=1e-15)
    assert gripper.object_axis == (0.0, 0.0, -1.0)
    assert gripper.pressure_max == 90e3
    assert (gripper.turns_required, gripper.friction_coefficient) == (1.5, 0.6)


def test_one_stiffness_alone_may_be_measured(load):
    from_material = load(SMALLEST).gripper.stiffness
    gripper = load(SMALLEST + "stiffness:\n  torsional: 1e-4 N m^2\n").gripper
    assert gripper.stiffness.torsional == 1e-4
    assert gripper.stiffness.bending == from_material.bending


@pytest.mark.parametrize(
    ("law", "material"),
    [
        ("{law: neo_hookean, c1: 145 kPa, density: 1 g/cm^3}", NeoHookean(145e3)),
        (
            "{law: mooney_rivlin, c1: 118.4 kPa, c2: 105.7 kPa, density: 1 g/cm^3}",
            MooneyRivlin(118.4e3, 105.7e3),
        ),
        (
            "{law: yeoh, c1: 145 kPa, c2: -5 kPa, c3: 1 kPa, density: 1 g/cm^3}",
            Yeoh(145e3, -5e3, 1e3),
        ),
        (
            "{law: gent, shear_modulus: 0.29 MPa, extension_limit: 50, density: 1 g/cm^3}",
            Gent(290e3, 50.0),
        ),
    ],
)
def test_every_law(load, law, material):
    text = SMALLEST.replace(SMALLEST[SMALLEST.index("material:") : SMALLEST.index("mount:")], "")
    assert load(f"{text}material: {law}\n").actuator.material == material


@pytest.mark.parametrize(("change", "message"), WRONG_VALUES.values(), ids=WRONG_VALUES.keys())
def test_each_mistake_has_its_message(load, change, message):
    with pytest.raises(DescriptionError) as caught:
        load(changed(*change))
    assert str(caught.value) == f"mine.yaml:{message}".replace("mine.yaml::", "mine.yaml:")


def test_a_pressure_past_locking_is_refused_in_the_unit_of_the_file(load):
    limit = load(UNIFORM).gripper.actuation.pressure_limit / STANDARD_PSI
    assert 100.0 < limit < 1000.0  # so that four digits are one decimal
    with pytest.raises(DescriptionError) as caught:
        load(changed("16 psi", "1000 psi", UNIFORM))
    assert str(caught.value) == (
        f"mine.yaml:17:17: limits.pressure_max must be at most {math.floor(limit * 10) / 10:.4g} "
        f"psi, the actuator's own limit: {ActuationLimit.FIBER_LOCKING.value}, got 1000 psi"
    )


def test_ballooning_is_named_as_the_limit(load):
    softening = "law: yeoh\n  c1: 50 kPa\n  c2: -50 kPa\n  c3: 1 kPa"
    with pytest.raises(DescriptionError) as caught:
        load(changed("law: mooney_rivlin\n  c1: 130 kPa\n  c2: 15 kPa", softening))
    assert caught.value.problems[0].field == "limits.pressure_max"
    limit = f"psi, the actuator's own limit: {ActuationLimit.LIMIT_POINT.value}"
    assert caught.value.problems[0].requirement.endswith(limit)


def test_the_limit_that_the_message_states_is_accepted(load):
    for unit in ("psi", "MPa", "Pa", "bar"):
        with pytest.raises(DescriptionError) as caught:
            load(changed("16 psi", f"1e8 {unit}", UNIFORM))
        stated = caught.value.problems[0].requirement.split(",")[0].removeprefix("at most ")
        gripper = load(changed("16 psi", stated, UNIFORM)).gripper
        assert gripper.pressure_max <= gripper.actuation.pressure_limit
        # Four digits are stated, rounded down.
        assert gripper.pressure_max == pytest.approx(gripper.actuation.pressure_limit, rel=1.1e-3)


def test_a_pair_of_fibers_that_pressure_shortens_is_refused_at_its_section(load):
    with pytest.raises(DescriptionError) as caught:
        load(changed("alpha: 88 deg\n  beta: 60 deg", "alpha: 30 deg\n  beta: -30 deg"))
    problem = caught.value.problems[0]
    assert (problem.line, problem.field) == (6, "fibers")
    assert problem.requirement.startswith("a pair that extends under pressure")


def test_the_error_carries_its_parts(load):
    with pytest.raises(DescriptionError) as caught:
        load(changed("16 psi", "16"))
    error = caught.value
    assert isinstance(error, SpiralError)
    assert isinstance(error, ValueError)
    (problem,) = error.problems
    assert (problem.file, problem.line, problem.field) == ("mine.yaml", 17, "limits.pressure_max")
    assert problem.value == "16"
    assert problem.requirement.startswith(PRESSURE)
    assert problem.kind is ProblemKind.WRONG
    assert problem.column == 17
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.problems) == (str(error), error.problems)


def test_all_mistakes_of_a_file_are_reported_together_in_their_order(load):
    text = changed("inner_radius: 4.7625 mm\n  wall_thickness", "inner_radius: 5\n  wall_thicknes")
    text = changed("  c1: 130 kPa\n", "  c1: 130 mm\n", text)
    text = changed("limits:\n  pressure_max: 16 psi\n", "", text)
    with pytest.raises(DescriptionError) as caught:
        load(text)
    assert [(p.line, p.kind, p.field) for p in caught.value.problems] == [
        (None, ProblemKind.MISSING, "limits.pressure_max"),
        (2, ProblemKind.MISSING, "tube.wall_thickness"),
        (3, ProblemKind.WRONG, "tube.inner_radius"),
        (4, ProblemKind.UNKNOWN, "tube.wall_thicknes"),
        (11, ProblemKind.WRONG, "material.c1"),
    ]
    assert len(str(caught.value).splitlines()) == 5


def test_all_that_the_core_refuses_is_reported_together(load):
    text = changed("length: 500 mm", "length: -500 mm")
    text = changed("88 deg", "95 deg", text)
    text = changed("c2: 15 kPa", "c2: -150 kPa", text)
    text = changed("0.95 g/cm^3", "0 g/cm^3", text)
    text = changed("[1, 0, 0]", "[1, 0, 0]\n  gravity_magnitude: -1 m/s^2", text)
    text = changed("16 psi", "0 psi\nextra_mass_per_length: -1 g/m", text)
    with pytest.raises(DescriptionError) as caught:
        load(text)
    assert [problem.field for problem in caught.value.problems] == [
        "tube.length",
        "fibers.alpha",
        "material.c1 + material.c2",
        "material.density",
        "mount.gravity_magnitude",
        "limits.pressure_max",
        "extra_mass_per_length",
    ]


lengths = st.floats(min_value=1e-4, max_value=1e2)
angles = st.floats(min_value=50.0, max_value=80.0)
pressures = st.floats(min_value=1.0, max_value=1e4)


@settings(deadline=None)
@given(radius=lengths, wall=lengths, length=lengths, beta=angles, c1=pressures, mass=lengths)
def test_the_same_gripper_in_other_units(tmp_path_factory, radius, wall, length, beta, c1, mass):
    """Tolerance 1e-12: the other unit's text is itself rounded to a float, as is the angle's."""
    folder = tmp_path_factory.mktemp("units")

    def load(radius, wall, length, beta, c1, density, gravity, pressure, mass):
        path = folder / "gripper.yaml"
        path.write_text(
            f"name: same\nextra_mass_per_length: {mass}\n"
            f"tube: {{inner_radius: {radius}, wall_thickness: {wall}, length: {length}}}\n"
            f"fibers: {{alpha: 90 deg, beta: {beta}}}\n"
            f"material: {{law: neo_hookean, c1: {c1}, density: {density}}}\n"
            f"mount: {{gravity_direction: [0, 0, -1], gravity_magnitude: {gravity}}}\n"
            f"limits: {{pressure_max: {pressure}}}\n"
        )
        return load_description(path)

    pressure = c1 * 1e-3 * wall / radius
    metric = load(
        f"{radius!r} mm",
        f"{wall!r} mm",
        f"{length!r} cm",
        f"{beta!r} deg",
        f"{c1!r} kPa",
        "0.95 g/cm^3",
        "9.80665 m/s^2",
        f"{pressure!r} kPa",
        f"{mass!r} kg/m",
    )
    other = load(
        f"{radius / 25.4!r} in",
        f"{wall / 25.4!r} inch",
        f"{length / 30.48!r} ft",
        f"{math.radians(beta)!r} rad",
        f"{c1 * 1e3 / STANDARD_PSI!r} psi",
        "950 kg/m^3",
        "1 standard_gravity",
        f"{pressure / 100!r} bar",
        f"{mass * 0.3048 / 0.45359237!r} lb/ft",
    )
    assert numbers_of(metric) == pytest.approx(numbers_of(other), rel=1e-12)


def numbers_of(description):
    actuator, gripper = description.actuator, description.gripper
    return [
        actuator.tube.inner_radius,
        actuator.tube.wall_thickness,
        actuator.tube.length,
        actuator.fibers.alpha,
        actuator.fibers.beta,
        actuator.material.c1,
        description.density,
        description.extra_mass_per_length,
        gripper.weight_per_length,
        gripper.pressure_max,
        gripper.stiffness.bending,
        gripper.stiffness.torsional,
        *gripper.gravity,
    ]


def test_numbers_that_overflow_are_refused(load, monkeypatch):
    def overflowing(*_):
        raise OverflowError

    # Each number is bounded; this is for those that are only together too large.
    monkeypatch.setattr("spiral_gripper.files.description._description", overflowing)
    with pytest.raises(DescriptionError) as caught:
        load(SMALLEST)
    assert str(caught.value) == (
        "mine.yaml: this file cannot be read: "
        "its numbers are too large or too small to compute with; check the units"
    )


VALUES = ("0", "1e300", "1e-300", "-1", "1e5", "1e-5", "1", ".nan", "true", "[1, 0, 0]", "{}", "")
UNITS = ("", " m", " mm", " Pa", " psi", " deg", " %", " kg/m^3", " N m^2", " kg/m", " m/s^2")


def problems_or_gripper(path):
    try:
        return [], load_gripper(path)
    except DescriptionError as error:
        return error.problems, None


@settings(deadline=None, max_examples=300)
@given(
    line=st.integers(min_value=0, max_value=len(COMPLETE.splitlines()) - 1),
    value=st.sampled_from(VALUES),
    unit=st.sampled_from(UNITS),
)
def test_any_value_anywhere_is_read_or_refused_as_a_description(
    tmp_path_factory, line, value, unit
):
    lines = COMPLETE.splitlines()
    lines[line] = f"{lines[line].partition(':')[0]}: {value}{unit}"
    path = tmp_path_factory.mktemp("any") / "mine.yaml"
    path.write_text("\n".join(lines))
    problems, gripper = problems_or_gripper(path)
    assert all(problem.file == str(path) for problem in problems)
    assert problems or math.isfinite(gripper.weight_per_length)


@pytest.mark.parametrize(
    ("fields", "place", "match"),
    [
        ("single_angles: [10 deg, 20 deg]\n  single_positions: [0 deg, 60 deg]",
         "fibers.single_angles", "fibers that cross"),
        ("single_angles: [0 deg, 0 deg, 0 deg]", "fibers.single_angles", "at most 2"),
        ("single_angles: [60 deg]", "fibers.single_angles", "another angle"),
        ("single_angles: [0 deg, 0 deg]\n  single_positions: [0 deg, 180 deg]",
         "fibers.single_angles", "170 degrees apart"),
        ("single_positions: [0 deg, 1 deg]", "fibers.single_positions", "as many as single_angles"),
        ("single_angles: [85 deg]", "fibers.single_angles", "from -80 to 80 deg"),
    ],
)  # fmt: skip
def test_single_fibers_that_leave_no_motion_are_refused_in_their_place(load, fields, place, match):
    with pytest.raises(DescriptionError, match=match) as caught:
        load(changed("beta: 60 deg", f"beta: 60 deg\n  {fields}"))
    assert caught.value.problems[0].field == place
    assert caught.value.problems[0].line > 6


def test_choices_that_contradict_are_refused_in_their_place(load):
    for lines, field in (
        ("  twist_shear: false\n", "model.twist_shear"),
        ("  pressure_law: uniform\n  thick_wall: true\n", "model.thick_wall"),
    ):
        with pytest.raises(DescriptionError) as caught:
            load(f"{SMALLEST}model:\n{lines}")
        assert caught.value.problems[0].field == field
    helical = changed("beta: 60 deg", "beta: 60 deg\n  single_angles: [20 deg]")
    with pytest.raises(DescriptionError, match="exact for fibers other than"):
        load(f"{helical}model:\n  curvature_form: first_order\n")
    assert load(helical).actuator.curvature_form is CurvatureForm.EXACT
