# SPDX-License-Identifier: Apache-2.0
"""Gripper description files and their page: what is read, and each kind of mistake."""

import math
import pickle
import re
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from edge.recorded import cases, changed, check
from hypothesis import given, settings
from hypothesis import strategies as st
from repo.source_tree import FENCED, ROOT, printed_by_python
from ruamel.yaml import YAML

from spiral_core import (
    CurvatureForm,
    SingleFiber,
    stiffness_from_actuator,
)
from spiral_core.wrap.gripper import stiffness_from_section
from spiral_gripper import DescriptionError, available_grippers, load_description
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
    assert gripper.stiffness == stiffness_from_actuator(actuator)
    one = read(SMALLEST + "stiffness:\n  torsional: 1e-4 N m^2\n").gripper.stiffness
    assert (one.bending, one.torsional) == (gripper.stiffness.bending, 1e-4)


def test_every_field_of_a_complete_file_reaches_the_gripper():
    description = read(COMPLETE)
    actuator, gripper = description.actuator, description.gripper
    parts = (actuator, actuator.tube, actuator.fibers, actuator.material, gripper)
    lines = [description.description, *map(repr, parts), repr(gripper.stiffness)]
    check("complete_description.txt", "complete", lines)


@pytest.mark.parametrize("law", LAWS)
def test_every_law_takes_its_constants(law):
    constants = {name: 50e3 + k for k, name in enumerate(constants_of(law))}
    lines = "".join(f"  {name}: {value} Pa\n" for name, value in constants.items())
    lines = re.sub("(extension_limit.*) Pa", r"\1", lines)
    old = "  law: mooney_rivlin\n  c1: 130 kPa\n  c2: 15 kPa\n"
    material = read(SMALLEST.replace(old, f"  law: {law}\n{lines}")).actuator.material
    assert material == LAWS[law](**constants)


@pytest.mark.parametrize("change", cases("descriptions.txt"))
def test_what_is_wrong_or_hardly_meant_is_named_in_its_place(change):
    try:
        said = read(changed(SMALLEST, change)).warnings
    except DescriptionError as error:
        said = str(pickle.loads(pickle.dumps(error))).splitlines()
    check("descriptions.txt", change, said)


def test_a_pressure_past_locking_is_refused_with_the_limit_in_the_files_unit():
    (problem,) = refused(UNIFORM.replace("16 psi", "1e8 bar")).problems
    stated = problem.requirement.partition(", the actuator's own limit: a fiber")[0]
    assert stated.endswith(" bar")
    gripper = read(UNIFORM.replace("16 psi", stated.removeprefix("at most "))).gripper
    # Four digits are stated, rounded down.
    limit = gripper.actuation.pressure_limit
    assert 0.9989 * limit < gripper.pressure_max <= limit


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
    "0 to 10": (("0", "10"), ("-0.1", "10.1")),
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
    assert field.allowed in ALLOWED or choices[0]
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
    wound = "" if "alpha" in fields else "alpha: 88 deg, beta: 60 deg, "
    change = (
        f"fibers:\n  alpha: 88 deg\n  beta: 60 deg -> fibers: {{{wound}{fields}}}; 16 psi -> 20 kPa"
    )
    actuation = read(changed(SMALLEST, change)).gripper.actuation
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
    assert str(refused(changed(SMALLEST, "4.7625 mm -> 4.7625"))) in PAGE


def test_the_constants_from_the_hardness_follow_gents_relation():
    rows = re.findall(r"^\| (?:Shore A|`c1` \[kPa\]) \|(.*) \|$", PAGE, re.MULTILINE)
    shore, c1 = (np.array(row.split("|"), float) for row in rows)
    modulus = 98.1 * (56.0 + 7.62336 * shore) / (0.137505 * (254.0 - 2.54 * shore))
    assert c1 == pytest.approx(modulus / 6.0, abs=0.5)


def test_a_command_warns_and_goes_on(said):
    Path("mine.yaml").write_text(changed(SMALLEST, "g/cm^3 -> kg/m^3"))
    assert said("shape mine.yaml --pressure 8psi").count("warning: mine.yaml:") == 1
