# SPDX-License-Identifier: Apache-2.0
"""Gripper description files and their page: what is read, and each kind of mistake."""

import math
import pickle
import re
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from repo.source_tree import FENCED, ROOT, printed_by_python
from ruamel.yaml import YAML

from spiral_core import (
    CurvatureForm,
    Gent,
    PressureLaw,
    SingleFiber,
    stiffness_from_actuator,
)
from spiral_core.wrap.gripper import stiffness_from_section
from spiral_gripper import DescriptionError, ProblemKind, available_grippers, load_description
from spiral_gripper.files.description import parse_description
from spiral_gripper.files.fields import FIELDS, LAWS, constants_of

PAGE = (ROOT / "docs" / "gripper_files.md").read_text("utf-8")
(SMALLEST,) = (text for kind, text in FENCED.findall(PAGE) if kind == "yaml")
HELICAL = """\
name: helical_fiber
tube: {inner_radius: 4.7625 mm, wall_thickness: 1/32 in, length: 400 mm}
fibers:
  alpha: 88 deg
  beta: 70 deg
  single_angles: [20 deg]
material: {law: neo_hookean, c1: 100 kPa, density: 0.95 g/cm^3}
mount: {gravity_direction: [1, 0, 0]}
limits: {pressure_max: 10 psi}
"""
UNIFORM = SMALLEST + "model:\n  pressure_law: uniform\n"
PSI = 0.45359237 * 9.80665 / 0.0254**2
COMPLETE = """\
name: complete
description: Everything that a file can say
tube:
  inner_radius: 5 mm
  wall_thickness: 1 mm
  length: 40 cm
fibers:
  alpha: 88 deg
  beta: -60 deg
  straight_fiber_radius: 5.5 mm
material:
  law: gent
  shear_modulus: 290 kPa
  extension_limit: 50
  density: 960 kg/m^3
model:
  curvature_form: exact
  pressure_law: uniform
  twist_shear: false
stiffness:
  bending: 4e-4 N m^2
  torsional: 3e-4 N m^2
extra_mass_per_length: 2 g/m
mount:
  gravity_direction: [0, 3, -4]
  gravity_magnitude: 10 m/s^2
  object_axis: [0, 0, -2]
limits:
  pressure_max: 90 kPa
grip:
  turns_required: 1.5
  friction_coefficient: 0.6
"""
# The lists of a measured curve go together: one of them is tried with the others as here.
MEASURED = {
    "pressures": "[0 kPa, 100 kPa, 200 kPa]",
    "curvatures": "[0 rad/m, 8 rad/m, 18 rad/m]",
    "torsions": "[0 rad/m, -4 rad/m, -9 rad/m]",
}


def read(text):
    return parse_description(text, Path("mine.yaml"))


def changed(old, new, text=SMALLEST):
    assert text.count(old) == 1
    return text.replace(old, new)


def refused(text):
    with pytest.raises(DescriptionError) as caught:
        read(text)
    return caught.value


def with_field(name, value):
    """Return the smallest file with one field added or replaced, in braces."""
    fields, (section, _, key) = YAML(typ="safe").load(SMALLEST), name.rpartition(".")
    if section == "measured":
        fields |= {"measured": dict(MEASURED), "limits": {"pressure_max": "30 kPa"}}
    (fields.setdefault(section, {}) if section else fields)[key] = value
    return str(fields).replace("'", "")


def test_the_smallest_file_has_one_straight_fiber_and_the_stiffness_of_the_annulus():
    description = read(SMALLEST)
    gripper, actuator = description.gripper, description.actuator
    assert actuator.single_fibers == (SingleFiber(0.0, 0.0),)
    assert actuator.fiber_radius == actuator.tube.inner_radius
    assert gripper.friction_coefficient is None
    assert gripper.stiffness == stiffness_from_actuator(actuator)
    one = read(SMALLEST + "stiffness:\n  torsional: 1e-4 N m^2\n").gripper.stiffness
    assert (one.bending, one.torsional) == (gripper.stiffness.bending, 1e-4)


def test_every_field_of_a_complete_file_reaches_the_gripper():
    description = read(COMPLETE)
    actuator, gripper = description.actuator, description.gripper
    tube, fibers, stiffness = gripper.tube, actuator.fibers, gripper.stiffness
    assert [
        tube.inner_radius, tube.wall_thickness, tube.length, fibers.alpha, fibers.beta,
        actuator.fiber_radius, gripper.weight_per_length, gripper.pressure_max,
        gripper.turns_required, gripper.friction_coefficient, stiffness.bending,
        stiffness.torsional, *gripper.gravity, *gripper.object_axis,
    ] == pytest.approx([
        5e-3, 1e-3, 0.4, math.radians(88), -math.radians(60), 5.5e-3,
        (960.0 * tube.wall_area + 2e-3) * 9.80665, 90e3, 1.5, 0.6, 4e-4, 3e-4, 0, 6, -8, 0, 0, -1,
    ])  # fmt: skip
    assert description.description == "Everything that a file can say"
    assert actuator.material == Gent(shear_modulus=290e3, extension_limit=50.0)
    choices = (actuator.curvature_form, actuator.pressure_law, actuator.twist_shear)
    assert choices == (CurvatureForm.EXACT, PressureLaw.UNIFORM, False)


@pytest.mark.parametrize("law", LAWS)
def test_every_law_takes_its_constants(law):
    constants = {name: 50e3 + k for k, name in enumerate(constants_of(law))}
    lines = "".join(f"  {name}: {value} Pa\n" for name, value in constants.items())
    lines = re.sub("(extension_limit.*) Pa", r"\1", lines)
    old = "  law: mooney_rivlin\n  c1: 130 kPa\n  c2: 15 kPa\n"
    material = read(changed(old, f"  law: {law}\n{lines}")).actuator.material
    assert material == LAWS[law](**constants)


# What is changed in the smallest file -> a part of the message.
MISTAKES = {
    "500 mm -> 500": '5:11: tube.length must be a length with its unit, such as "4.7625 mm" (w',
    "500 mm -> 0 mm": "5:11: tube.length must be a positive finite number, got 0 mm",
    "500 mm -> 500 m": "5:11: tube.length must be at most 10 m, got 500 m",
    "500 mm -> ": "6:1: tube.length is missing; it must be a length with its unit",
    "  length: 500 mm\n -> ": "2:1: tube.length is missing; it must be a length with its unit",
    "0.95 g/cm^3 -> 1e9 kg/m^3": "13:12: material.density must be at most 100000 kg/m^3, got",
    "88 deg -> 95 deg": "not 0 (95 deg, if counted from 0 to 180 deg, is -85 deg here)",
    "88 deg -> 60 deg": "7:10: fibers.alpha, fibers.beta must be angles of two families that cr",
    "130 kPa -> -16 kPa": "11:7: material.c1 + material.c2 must be positive, so that the modulus",
    "mooney_rivlin -> Ogden": "yeoh, gent (did you mean yeoh?), got Ogden",
    "15 kPa -> 15 kPa\n  c3: 1 kPa": "material.c3 is not a field here; the constants of mooney",
    "  c2: 15 kPa\n -> ": "9:1: material.c2 is missing; it must be a pressure with its unit",
    "smallest -> 12": "1:7: name must be one line of text, in quotes if it looks like a number",
    "smallest -> |\n  two\n  lines": "1:7: name must be one line of text",
    "[1, 0, 0] -> [1, 0]": "15:22: mount.gravity_direction must be three finite",
    "[1, 0, 0] -> [.inf, 0, 0]": "15:22: mount.gravity_direction must be three finite",
    "[1, 0, 0] -> [1, 0, 0]\n  object_axis: fit": "16:16: mount.object_axis must be fitted, or",
    "[1, 0, 0] -> [1, 0, 0]\n  gravity_magnitude: 1e5 m/s^2": "must be at most 10000 m/s^2, got",
    "limits:\n  pressure_max: 16 psi\n -> ": "mine.yaml: limits.pressure_max is missing",
    "limits: -> model: {twist_shear: 'true'}\nlimits:": "16:22: model.twist_shear must be true",
    "limits: -> model: {twist_shear: false}\nlimits:": "16:22: model.twist_shear must be",
    "limits: -> model: {pressure_law: uniform, thick_wall: true}\nlimits:": "model.thick_wall",
    "limits: -> extra_mass_per_length: 2e3 kg/m\nlimits:": "16:24: extra_mass_per_length must",
    "limits: -> grip: {turns_required: 105 %}\nlimits:": "grip.turns_required must be a plain fi",
    "limits: -> stiffness: {section_at: 1 kPa, bending: 1 N m^2}\nlimits:": "be left out where b",
    "limits: -> model: {pressure_law: uniform}\nstiffness: {section_at: 1 kPa}\nlimits:": "a pr",
    "law: mooney_rivlin\n  c1: 130 kPa\n  c2: 15 kPa -> law: yeoh\n  c1: 50 kPa\n"
    "  c2: -50 kPa\n  c3: 1 kPa": "own limit: the actuator balloons",
    "inner_radius: 4.7625 mm -> inner_radius: 1e-200 mm": "mine.yaml: this file cannot be read",
}


@pytest.mark.parametrize("change", MISTAKES)
def test_each_mistake_has_its_place_and_its_message(change):
    error = refused(changed(*change.split(" -> ")))
    assert MISTAKES[change] in str(error)
    (problem,) = pickle.loads(pickle.dumps(error)).problems
    assert str(problem) == str(error)


# Fibers that leave no motion, in place of those of the smallest file, and where this is said.
CONTRADICTIONS = {
    "alpha: 40 deg, beta: -40 deg": "fibers must be a pair that extends under pressure",
    "alpha: 40 deg, beta: none": "fibers must be a family with which pressure extends",
    "single_angles: [60 deg]": "fibers.single_angles must be at another angle than the wound",
    "single_angles: [0 deg, 10 deg], single_positions: [0 deg, 60 deg]": "at one angle: fibers",
    "single_angles: [0 deg, 0 deg], single_positions: [0 deg, 180 deg]": "two fibers 0.1 to 170",
    "single_angles: [0 deg, 0 deg, 0 deg]": "fibers.single_angles must be at most 2",
    "single_positions: [0 deg, 9 deg]": "fibers.single_positions must be as many as single_angles",
    "single_angles: [9 deg]}\nmodel: {curvature_form: first_order": "7:25: model.curvature_form",
    "alpha: 90 deg, beta: none, single_angles: [0 deg, 0 deg], single_positions: [0 deg, 60 deg]": (
        "a thin wall and at most one fiber with one family"
    ),
}


def with_fibers(fields, text=SMALLEST):
    wound = "" if "alpha" in fields else "alpha: 88 deg, beta: 60 deg, "
    return re.sub(r"fibers:.*?\n(?=\w)", f"fibers: {{{wound}{fields}}}\n", text, flags=re.DOTALL)


@pytest.mark.parametrize("fields", CONTRADICTIONS)
def test_fibers_that_leave_no_motion_are_refused_in_their_place(fields):
    (problem,) = refused(with_fibers(fields)).problems
    assert problem.line == 6 + ("model" in fields)
    assert CONTRADICTIONS[fields] in str(problem)


def test_a_pressure_past_locking_is_refused_with_the_limit_in_the_files_unit():
    (problem,) = refused(changed("16 psi", "1e8 bar", UNIFORM)).problems
    stated = problem.requirement.partition(", the actuator's own limit: a fiber")[0]
    assert stated.endswith(" bar")
    gripper = read(changed("16 psi", stated.removeprefix("at most "), UNIFORM)).gripper
    # Four digits are stated, rounded down.
    limit = gripper.actuation.pressure_limit
    assert 0.9989 * limit < gripper.pressure_max <= limit


def test_all_mistakes_of_a_file_are_reported_together_in_their_order():
    text = changed("inner_radius: 4.7625 mm\n  wall_thickness", "inner_radius: 5\n  wall_thicknes")
    text = changed("limits:\n  pressure_max: 16 psi\n", "", changed("130 kPa", "130 mm", text))
    assert [(p.line, p.kind, p.field) for p in refused(text).problems] == [
        (None, ProblemKind.MISSING, "limits.pressure_max"),
        (2, ProblemKind.MISSING, "tube.wall_thickness"),
        (3, ProblemKind.WRONG, "tube.inner_radius"),
        (4, ProblemKind.UNKNOWN, "tube.wall_thicknes"),
        (11, ProblemKind.WRONG, "material.c1"),
    ]
    # What the core refuses, once all values are read.
    text = changed("500 mm", "-500 mm", changed("88 deg", "95 deg"))
    assert [p.field for p in refused(text).problems] == ["tube.length", "fibers.alpha"]


VALUES = ("0", "1e300", "1e-300", "-1", "1e5", "1e-5", "1", ".nan", "true", "[1, 0, 0]", "{}", "")
UNITS = ("", " m", " mm", " Pa", " psi", " deg", " %", " kg/m^3", " N m^2", " kg/m", " m/s^2")


@settings(max_examples=300)
@given(
    line=st.sampled_from(COMPLETE.splitlines()),
    value=st.sampled_from(VALUES),
    unit=st.sampled_from(UNITS),
)
def test_any_value_anywhere_is_read_or_refused_as_a_description(line, value, unit):
    text = COMPLETE.replace(line, f"{line.partition(':')[0]}: {value}{unit}", 1)
    with suppress(DescriptionError):
        assert math.isfinite(read(text).gripper.weight_per_length)


def codes(cell):
    return re.findall(r"`([^`]+)`", cell)


# What a field is allowed to be -> the nearest values that it may have, and that it may not.
ALLOWED = {
    "> 0": ((), ("0 {}", "-1 {}")),
    ">= 0": (("0 {}",), ("-1 {}",)),
    "-90 to 90 deg, not 0": (("90 deg", "-90 deg"), ("90.1 deg", "-90.1 deg", "0 deg")),
    "-80 to 80 deg": (("[-80 deg]", "[]"), ("[80.1 deg]", "[-80.1 deg]")),
    "as many as the angles": (("[90 deg]",), ("[0 deg, 9 deg]", "[361 deg]")),
    "not zero": (("[0, 0, 1e-9]",), ("[0, 0, 0]",)),
    "`true`, `false`": (("true",), ("True",)),
    "0 to the pressure limit": (("0 kPa", "16 psi"), ("16.1 psi", "-1 kPa")),
    "rising from 0": ((), ("[0 kPa, 9 kPa, 9 kPa]", "[1 kPa, 9 kPa, 40 kPa]")),
    "never falling": ((), ("[0 rad/m, 8 rad/m, 7 rad/m]",)),
    "any": ((), ("[]",)),
}
ALLOWED["-90 to 90 deg, not 0, or `none`"] = ALLOWED["-90 to 90 deg, not 0"]


@pytest.mark.parametrize("name", [name for name in FIELDS if name.partition(".")[0] != "material"])
def test_a_field_is_what_the_page_allows(name):
    """The page's table is written from the fields; here they are held to what it says."""
    field = FIELDS[name]
    unit = field.dimension.si_unit if field.dimension else ""
    choices = (codes(field.allowed), ("other",))
    accepted, not_accepted = ALLOWED.get(field.allowed, choices)
    for value in accepted:
        read(with_field(name, value.format(unit)))
    for value in not_accepted:
        assert refused(with_field(name, value.format(unit))).problems[0].field == name


DEFAULTS = {name: codes(field.default) for name, field in FIELDS.items()}
# Without those whose default is another field's value.
STATED = [name for name, default in DEFAULTS.items() if default and default[0] not in FIELDS]


@pytest.mark.parametrize("name", STATED)
def test_a_stated_default_is_what_leaving_out_means(name):
    left_out, stated = read(SMALLEST), read(with_field(name, *DEFAULTS[name]))
    assert (stated.gripper, stated.actuator) == (left_out.gripper, left_out.actuator)
    assert read(HELICAL).actuator.curvature_form is CurvatureForm.EXACT


def test_a_measured_curve_and_the_sections_stiffness_reach_the_gripper():
    shape = read(with_field("measured.pressures", MEASURED["pressures"])).gripper
    assert shape.unloaded_shape(2e4).torsion < 0.0 < shape.unloaded_shape(2e4).curvature
    described = read(with_field("stiffness.section_at", "80 kPa"))
    assert described.gripper.stiffness == stiffness_from_section(described.actuator, 80e3)


@pytest.mark.parametrize(
    ("motion", "fields"), re.findall(r"^\| ([a-z, ]+) \| `fibers: {(.*)}` \|$", PAGE, re.MULTILINE)
)
def test_each_set_of_fibers_moves_as_the_table_says(motion, fields):
    actuation = read(with_fibers(fields, changed("16 psi", "20 kPa"))).gripper.actuation
    rest, shape = actuation.unloaded_shape(0.0), actuation.unloaded_shape(20.0e3)
    turns = abs(shape.torsion - rest.torsion) > 0.1
    found = {(True, False): "bends", (True, True): "coils", (False, True): "twists"}
    axial = "extends" if shape.stretch > 1.0 else "shortens"
    assert motion.split(",")[0] == found.get((shape.curvature > 1.0, turns), axial)
    assert ("coiled at rest" in motion) == (rest.torsion != 0.0)


def test_the_pages_examples_do_what_it_says():
    helical = read(HELICAL).gripper
    assert helical.unloaded_shape(helical.pressure_max).curvature > 5.0
    assert not any(load_description(name).warnings for name in available_grippers())
    code = dict(FENCED.findall(PAGE))["python"]
    assert printed_by_python(code) == f"{available_grippers()}\n0.5\n"
    assert str(refused(changed("4.7625 mm", "4.7625"))) in PAGE


def test_the_constants_from_the_hardness_follow_gents_relation():
    rows = re.findall(r"^\| (?:Shore A|`c1` \[kPa\]) \|(.*) \|$", PAGE, re.MULTILINE)
    shore, c1 = (np.array(row.split("|"), float) for row in rows)
    modulus = 98.1 * (56.0 + 7.62336 * shore) / (0.137505 * (254.0 - 2.54 * shore))
    assert c1 == pytest.approx(modulus / 6.0, abs=0.5)


# Written in place of a value of the smallest file, with a limit out of reach: what is doubted.
HARDLY_MEANT = {
    "radius: 4.7625 mm -> radius: 4.7625 m": ":3:17: tube.inner_radius 4.7625 m is not between",
    "radius: 4.7625 mm -> radius: 99 mm": "",
    "1/32 in -> 1.19 mm": "",
    "1/32 in -> 1.2 mm": "holds up to 0.25; calibrate it, or set model.thick_wall to true",
    "1/32 in -> 9 mm": "is 1.9 of the bore radius",
    "1/32 in -> 10 mm": "is 2.1 times the bore radius",
    "c1: 130 kPa -> c1: 4 MPa": ":9:1: material has a Young's modulus of 24.1 MPa; elastomers",
    "c1: 130 kPa -> c1: -14 kPa": "modulus of 0.006 MPa; elastomers have 0.01 to 20 MPa",
    "0.95 g/cm^3 -> 0.95 kg/m^3": ":13:12: material.density 0.95 kg/m^3 is not between 100 and",
    "0.95 g/cm^3 -> 4.1 g/cm^3": "100 and 4000 kg/m^3",
}


@pytest.mark.parametrize("change", HARDLY_MEANT)
def test_a_value_that_is_hardly_meant_is_named(change):
    found = read(changed(*change.split(" -> "), changed("16 psi", "1 Pa"))).warnings
    assert HARDLY_MEANT[change] in " ".join(found)
    assert bool(found) == bool(HARDLY_MEANT[change])


def test_a_pressure_limit_that_is_hardly_meant_is_named_and_the_doubt_told_with_a_refusal():
    wound = changed("16 psi", "1.2 MPa", changed("60 deg", "86 deg", UNIFORM))
    (warning,) = read(wound).warnings
    assert "17:17: limits.pressure_max 1.2 MPa stresses the wall alone with 8.3 times" in warning
    error = str(refused(changed("radius: 4.7625 mm", "radius: 4.75 m", UNIFORM)))
    assert "limits.pressure_max must be at most" in error
    assert "mine.yaml:3:17: tube.inner_radius 4.75 m is not between" in error


def test_a_command_warns_and_goes_on(said):
    Path("mine.yaml").write_text(changed("0.95 g/cm^3", "0.95 kg/m^3"))
    assert said("shape mine.yaml --pressure 8psi").count("warning: mine.yaml:") == 1
