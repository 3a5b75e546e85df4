# SPDX-License-Identifier: Apache-2.0
"""docs/gripper_files.md against the code: the format stands once, the page follows it."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from spiral_core import OneFamily, SingleFiber
from spiral_core.wrap.gripper import FIBER_STIFFNESS
from spiral_gripper import DescriptionError, available_grippers, load_description
from spiral_gripper.files.description import parse_description
from spiral_gripper.files.fields import FIELDS

pytestmark = pytest.mark.long

PAGE = (Path(__file__).parents[2] / "docs" / "gripper_files.md").read_text(encoding="utf-8")


def table_after(heading):
    section = PAGE.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    rows = [line.strip()[1:-1].split("|") for line in section.splitlines() if line[:1] == "|"]
    return [[cell.strip() for cell in row] for row in rows[2:]]


def codes(cell):
    return re.findall(r"`([^`]+)`", cell)


ROWS = {codes(row[0])[0]: row[1:] for row in table_after("Fields")}
SMALLEST = re.search(r"```yaml\n(.*?)```", PAGE, re.DOTALL)[1]


# The lists of a measured curve go together: one of them is tried with the others as here.
MEASURED = {
    "pressures": "[0 kPa, 100 kPa, 200 kPa]",
    "curvatures": "[0 rad/m, 8 rad/m, 18 rad/m]",
    "torsions": "[0 rad/m, -4 rad/m, -9 rad/m]",
}


def with_field(name, value):
    """Return the smallest file with one field added or replaced."""
    section, _, key = name.rpartition(".")
    if section == "measured":
        lists = MEASURED | {key: value}
        limited = SMALLEST.replace("pressure_max: 16 psi", "pressure_max: 30 kPa")
        return limited + "measured:\n" + "".join(f"  {k}: {v}\n" for k, v in lists.items())
    lines = [line for line in SMALLEST.splitlines() if line.strip().partition(":")[0] != key]
    if not section:
        return "\n".join([*lines, f"{key}: {value}"])
    if f"{section}:" not in lines:
        lines.append(f"{section}:")
    at = lines.index(f"{section}:") + 1
    return "\n".join([*lines[:at], f"  {key}: {value}", *lines[at:]])


def read(text):
    return parse_description(text, Path("page.yaml"))


@pytest.mark.parametrize("name", [name for name, row in ROWS.items() if row[2][:1] == ">"])
def test_allowed_numbers(name):
    unit = f" {FIELDS[name].dimension.si_unit}" if FIELDS[name].dimension else ""
    with pytest.raises(DescriptionError) as caught:
        read(with_field(name, f"-1{unit}"))
    assert [problem.field for problem in caught.value.problems] == [name]
    if ROWS[name][2] == ">= 0":
        read(with_field(name, f"0{unit}"))
    else:
        assert ROWS[name][2] == "> 0"
        with pytest.raises(DescriptionError) as caught:
            read(with_field(name, f"0{unit}"))
        assert [problem.field for problem in caught.value.problems] == [name]


@pytest.mark.parametrize("name", ["fibers.alpha", "fibers.beta"])
def test_allowed_angles(name):
    assert ROWS[name][2].removesuffix(", or `none`") == "-90 to 90 deg, not 0"
    for angle in ("90 deg", "-90 deg"):
        read(with_field(name, angle))
    for angle in ("90.1 deg", "-90.1 deg", "0 deg"):
        with pytest.raises(DescriptionError) as caught:
            read(with_field(name, angle))
        assert caught.value.problems[0].field == name


@pytest.mark.parametrize("name", ["mount.gravity_direction", "mount.object_axis"])
def test_allowed_directions(name):
    assert ROWS[name][2] == "not zero"
    with pytest.raises(DescriptionError):
        read(with_field(name, "[0, 0, 0]"))


def test_allowed_switches():
    uniform = SMALLEST + "model:\n  pressure_law: uniform\n"
    for name, text in (("twist_shear", uniform), ("thick_wall", SMALLEST + "model:\n")):
        assert codes(ROWS[f"model.{name}"][2]) == ["true", "false"]
        for word, value in (("true", True), ("false", False)):
            actuator = read(f"{text}  {name}: {word}\n").actuator
            assert getattr(actuator, name) is value


def test_allowed_single_fibers():
    assert ROWS["fibers.single_angles"][2] == "-80 to 80 deg"
    assert ROWS["fibers.single_positions"][2] == "as many as the angles"
    text = with_field("fibers.single_angles", "[-80 deg]")
    (fiber,) = read(text).actuator.single_fibers
    assert fiber.angle == pytest.approx(math.radians(-80.0))
    assert read(SMALLEST).actuator.single_fibers == (SingleFiber(0.0, 0.0),)
    for name, value in (("single_angles", "[80.1 deg]"), ("single_positions", "[0 deg, 9 deg]")):
        with pytest.raises(DescriptionError, match=f"fibers.{name}"):
            read(with_field(f"fibers.{name}", value))


def test_allowed_pressures_of_the_sections_stiffness():
    assert ROWS["stiffness.section_at"][2] == "0 to the pressure limit"
    annulus = read(SMALLEST).gripper.stiffness
    for pressure, (bending, torsional, sideways, slope) in {
        "0 kPa": (3.8, 15.0, 1.26, -0.61), "80 kPa": (2.2, 10.3, 0.97, -0.56),
    }.items():  # fmt: skip
        section = read(with_field("stiffness.section_at", pressure)).gripper.stiffness
        compliance = np.linalg.inv(np.array(section.matrix))
        # One motion is free, of bending and twist; what the fibers give adds to both.
        bends = annulus.bending * bending / (1.0 + slope**2 / FIBER_STIFFNESS)
        twists = annulus.torsional * torsional / (1.0 + 1.0 / (FIBER_STIFFNESS * slope**2))
        assert 1.0 / compliance[2, 2] == pytest.approx(bends, rel=0.02)
        assert 1.0 / compliance[0, 0] == pytest.approx(twists, rel=0.02)
        twist_as_it_bends = compliance[0, 2] / compliance[2, 2]
        expected = slope * (1.0 - 1.0 / FIBER_STIFFNESS) / (1.0 + slope**2 / FIBER_STIFFNESS)
        assert twist_as_it_bends == pytest.approx(expected, rel=0.02)
        assert section.sideways == pytest.approx(sideways * annulus.bending, rel=0.01)
        stiff = np.linalg.eigvalsh(np.array(section.matrix)[np.ix_([0, 2], [0, 2])])
        assert stiff[1] == pytest.approx(FIBER_STIFFNESS * stiff[0])
    straight = with_field("stiffness.section_at", "0 kPa").replace("beta: 60", "beta: -88")
    bends = read(straight).gripper.stiffness
    assert abs(bends.coupling) < 1e-9 * bends.bending  # a pair that does not twist
    assert bends.torsional == pytest.approx(FIBER_STIFFNESS * bends.bending)
    both = with_field("stiffness.section_at", "0 kPa") + "\n"
    both = both.replace("section_at: 0 kPa", "section_at: 0 kPa\n  bending: 2e-4 N m^2")
    even = with_field("stiffness.section_at", "0 kPa") + "\nmodel: {pressure_law: uniform}\n"
    for text, reason in (
        (both, "left out where bending or torsional is stated"),
        (even, "pressure_law must be section"),
        (with_field("stiffness.section_at", "16.1 psi"), "from 0 to limits.pressure_max"),
        (with_field("stiffness.section_at", "-1 kPa"), "from 0 to limits.pressure_max"),
    ):
        with pytest.raises(DescriptionError, match=r"stiffness\.section_at must be") as caught:
            read(text)
        assert reason in str(caught.value)


def single_fiber_rows():
    return {row[0]: codes(row[1]) for row in table_after("Single fibers, which make the tube bend")}


@pytest.mark.parametrize("fields", single_fiber_rows().values(), ids=single_fiber_rows())
def test_single_fibers_as_the_table_writes_them(fields):
    lines = "".join(f"  {field}\n" for field in fields)
    text = SMALLEST.replace("  beta: 60 deg\n", "") if "beta: none" in fields else SMALLEST
    actuator = read(text.replace("fibers:\n", f"fibers:\n{lines}")).actuator
    if fields == ["beta: none"]:
        assert actuator.fibers == OneFamily(actuator.fibers.angle)
        return
    stated = re.findall(r"[\d.]+(?= deg)", fields[0]) if fields else ["0"]
    angles = [math.degrees(fiber.angle) for fiber in actuator.single_fibers]
    assert angles == pytest.approx([float(angle) for angle in stated])


def with_fibers(fields):
    """Return the smallest file with its section of fibers replaced, of the section law."""
    start, rest = SMALLEST.split("fibers:\n")
    _, end = rest.split("material:\n")
    return f"{start}{fields}\nmaterial:\n{end}".replace("16 psi", "20 kPa")


@pytest.mark.parametrize(("motion", "fields"), table_after("A set of fibers for each motion"))
def test_each_set_of_fibers_moves_as_the_table_says(motion, fields):
    actuation = read(with_fibers(*codes(fields))).gripper.actuation
    rest, shape = actuation.unloaded_shape(0.0), actuation.unloaded_shape(20.0e3)
    bends = shape.curvature > 1.0
    turns = abs(shape.torsion - rest.torsion) > 0.1
    found = {(True, False): "bends", (True, True): "coils", (False, True): "twists"}
    axial = "extends" if shape.stretch > 1.0 else "shortens"
    assert motion.split(",")[0] == found.get((bends, turns), axial)
    assert ("coiled at rest" in motion) == (rest.torsion != 0.0)


COIL = "alpha: 88 deg, beta: 60 deg"
TWO = "single_angles: [0 deg, 0 deg]"
THREE = "single_angles: [0 deg, 0 deg, 0 deg], single_positions: [0 deg, 120 deg, 240 deg]"
CONTRADICTIONS = [
    ("alpha: 60 deg, beta: 60 deg", "angles of two families that cross"),
    ("alpha: 40 deg, beta: -40 deg", "a pair that extends under pressure"),
    ("alpha: 40 deg, beta: none", "a family with which pressure extends the tube"),
    (
        f"{COIL}, single_angles: [60 deg]",
        "at another angle than the wound families, or left out",
    ),
    (
        f"{COIL}, single_angles: [0 deg, 10 deg]",
        "at one angle: fibers that cross leave no uniform shape",
    ),
    (
        f"{COIL}, {TWO}, single_positions: [0 deg, 180 deg]",
        "two fibers 0.1 to 170 degrees apart",
    ),
    (
        f"{COIL}, {THREE}",
        "at most 2: three hold the section on all sides",
    ),
    (
        f"alpha: 90 deg, beta: none, {TWO}, single_positions: [0 deg, 60 deg]",
        "a thin wall and at most one fiber with one family",
    ),
]


@pytest.mark.parametrize(("fields", "reason"), CONTRADICTIONS)
def test_contradictory_fibers_are_refused_with_the_reason(fields, reason):
    with pytest.raises(DescriptionError, match="must be") as caught:
        read(with_fibers(f"fibers: {{{fields}}}"))
    assert reason in str(caught.value)


def test_the_example_with_a_helical_fiber_coils():
    example = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)[1]
    gripper = read(example).gripper
    shape = gripper.unloaded_shape(gripper.pressure_max)
    assert shape.curvature > 5.0
    assert shape.torsion > 30.0


@pytest.mark.parametrize(
    ("name", "allowed", "refused"),
    [
        ("measured.pressures", "rising from 0", "[0 kPa, 100 kPa, 100 kPa]"),
        ("measured.pressures", "rising from 0", "[10 kPa, 100 kPa, 200 kPa]"),
        ("measured.curvatures", "never falling", "[0 rad/m, 8 rad/m, 7 rad/m]"),
    ],
)
def test_allowed_lists(name, allowed, refused):
    assert ROWS[name][2] == allowed
    assert read(with_field(name, MEASURED[name.partition(".")[2]])).gripper.unloaded_shape(0.0)
    with pytest.raises(DescriptionError) as caught:
        read(with_field(name, refused))
    assert [problem.field for problem in caught.value.problems] == [name]


def test_every_statement_of_what_is_allowed_is_tested():
    tested = {
        "rising from 0",
        "never falling",
        "-80 to 80 deg",
        "as many as the angles",
        "> 0",
        ">= 0",
        "-90 to 90 deg, not 0",
        "not zero",
        "by the law",
        "any",
        "0 to the pressure limit",
    }
    stated = {row[2] for name, row in ROWS.items() if not codes(row[2])}
    assert stated == tested


@pytest.mark.parametrize("name", [name for name, row in ROWS.items() if codes(row[3])])
def test_stated_default_is_what_leaving_out_means(name):
    (default,) = codes(ROWS[name][3])
    if default in FIELDS:  # another field's value
        default = "4.7625 mm"
    left_out, stated = read(SMALLEST), read(with_field(name, default))
    assert stated.actuator.fiber_radius == left_out.actuator.fiber_radius
    assert stated.actuator.curvature_form == left_out.actuator.curvature_form
    for choice in ("twist_shear", "pressure_law", "thick_wall"):
        assert getattr(stated.actuator, choice) == getattr(left_out.actuator, choice)
    assert stated.extra_mass_per_length == left_out.extra_mass_per_length
    for attribute in ("gravity", "object_axis", "turns_required", "weight_per_length"):
        assert getattr(stated.gripper, attribute) == getattr(left_out.gripper, attribute)


def test_other_defaults_are_stated_in_words():
    words = {name: row[3] for name, row in ROWS.items() if row[3] and not codes(row[3])}
    assert words == {
        "description": "empty",
        "fibers.single_angles": "one straight fiber",
        "fibers.single_positions": "0 deg",
        "stiffness.bending": "from tube and material",
        "stiffness.torsional": "from tube and material",
        "stiffness.section_at": "stiffness of the annulus",
        "grip.friction_coefficient": "unknown",
    }
    without = {name for name, row in ROWS.items() if row[3] == "" and row[1] == "no"}
    assert without == {name for name in FIELDS if name.startswith("measured.")}
    assert all(row[3] == "" for name, row in ROWS.items() if row[1] != "no")


EXAMPLE_FIELDS = {
    "number": "grip.turns_required",
    "name": "name",
    "text": "description",
    "choice": "material.law",
    "switch": "model.thick_wall",
    "direction": "mount.gravity_direction",
    "pressures": "measured.pressures",
    "curvatures": "measured.curvatures",
    "angles": "fibers.single_angles",
    "axis": "mount.object_axis",
}


def test_kinds_and_their_examples():
    table = PAGE.split("| other kind |")[1].split("\n\n")[0]
    rows = [line.strip("|").split("|") for line in table.splitlines()[2:]]
    examples = {kind.strip(): codes(first) + codes(other) for kind, first, other in rows}
    assert examples.keys() == EXAMPLE_FIELDS.keys()
    for kind, name in EXAMPLE_FIELDS.items():
        for example in examples[kind]:
            read(with_field(name, example))


def test_the_shipped_grippers_are_named():
    opening = PAGE.split("\n## ")[0]
    assert tuple(codes(opening))[: len(available_grippers())] == available_grippers()


def test_the_python_example_runs(capsys):
    example = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1]
    exec(compile(example, "gripper_files.md", "exec"), {})
    length = load_description("prototype_p1").gripper.tube.length
    assert capsys.readouterr().out.splitlines() == [str(available_grippers()), str(length)]


def test_the_error_example_is_what_the_code_says():
    block = re.search(r"```text\n(.*?)```", PAGE, re.DOTALL)[1]
    text = SMALLEST.replace("inner_radius: 4.7625 mm", "inner_radius: 4.7625")
    text = text.replace("500 mm", "500 mm\n  colour: red").replace("88 deg", "88 %")
    with pytest.raises(DescriptionError) as caught:
        parse_description(text, Path("mine.yaml"))
    assert str(caught.value) == block.strip()


def test_the_constants_from_the_hardness_follow_gents_relation():
    section = PAGE.split("\n## Only the hardness is known\n")[1].split("\n## ")[0]
    rows = [line.strip("| ").split(" | ") for line in section.splitlines() if line[:1] == "|"]
    hardness, constants = ([float(cell) for cell in row[1:]] for row in (rows[0], rows[2]))
    assert len(constants) == 7
    for shore, c1 in zip(hardness, constants, strict=True):
        modulus = 0.0981 * (56.0 + 7.62336 * shore) / (0.137505 * (254.0 - 2.54 * shore))
        assert c1 == pytest.approx(modulus * 1e3 / 6.0, abs=0.5)
