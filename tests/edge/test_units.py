# SPDX-License-Identifier: Apache-2.0
"""Quantities with units: what is read, to which SI value, and what is refused with which words."""

import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiral_core import InvalidInputError
from spiral_gripper.files.units import (
    Dimension,
    convert_from_si,
    parse_number,
    parse_quantity,
    unit_of,
)

LENGTH, PRESSURE, ANGLE = Dimension.LENGTH, Dimension.PRESSURE, Dimension.ANGLE
POUND_FORCE = 0.45359237 * 9.80665
PSI = POUND_FORCE / 0.0254**2
DIMENSIONS = st.sampled_from(Dimension)


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("4.7625mm", LENGTH, 4.7625e-3),
        ("3\N{NO-BREAK SPACE}mm", LENGTH, 3e-3),
        ("-3/16 in", LENGTH, -4.7625e-3),
        ("+1e-3 m", LENGTH, 1e-3),
        ("4 µm", LENGTH, 4e-6),
        ("31.25 thou", LENGTH, 7.9375e-4),
        ("8 lbf/in^2", PRESSURE, 8 * PSI),
        ("0.13 MPa", PRESSURE, 130e3),
        ("1 kpa", PRESSURE, 1e3),
        ("1 kN/m^2", PRESSURE, 1e3),
        ("760 torr", PRESSURE, 101325.0),
        ("-60°", ANGLE, -math.radians(60)),
        ("2 °3 °-2", ANGLE, math.radians(2)),
        ("0.95 g/cm3", Dimension.DENSITY, 950.0),
        ("950 kg/m³", Dimension.DENSITY, 950.0),
        ("1 standard_gravity", Dimension.ACCELERATION, 9.80665),
        ("200 N·mm²", Dimension.FLEXURAL_STIFFNESS, 2e-4),
        ("1 kgf", Dimension.FORCE, 9.80665),
        ("1 lbf", Dimension.FORCE, POUND_FORCE),
        ("16 oz", Dimension.MASS, 0.45359237),
        ("1 turn/m", Dimension.CURVATURE, 2.0 * math.pi),
        ("2 min", Dimension.TIME, 120.0),
        ("1 psi/min", Dimension.PRESSURE_RATE, PSI / 60.0),
    ],
)
def test_quantity_in_si_units(text, dimension, expected):
    assert parse_quantity(text, dimension) == pytest.approx(expected, rel=1e-15, abs=0.0)


def test_values_are_rounded_once():
    """Floating-point conversion factors would give 0.0047624999... and 949.9999...."""
    assert parse_quantity("3/16 in", LENGTH) == 0.0047625
    assert parse_quantity("0.95 g/cm^3", Dimension.DENSITY) == 950.0
    assert parse_quantity("0.794 mm", LENGTH) == 0.000794


@pytest.mark.parametrize(
    ("text", "dimension", "hint"),
    [
        (8, PRESSURE, ' (write "8 kPa" or "8 psi" or whichever unit is meant)'),
        ("4.7625", LENGTH, ' (write "4.7625 mm" or "4.7625 in" or whichever unit is meant)'),
        ("8 mpa", PRESSURE, ' (there is no unit "mpa"; did you mean "MPa"?)'),
        ("2 S", Dimension.TIME, ' (there is no unit "S"; did you mean "s"?)'),
        ("3 kg", LENGTH, ' ("kg" is a mass, not a length)'),
        ("8 lb/in^2", PRESSURE, ' ("lb/in^2" is not a pressure)'),
        ("3 m/m", ANGLE, ' ("m/m" is not an angle)'),
        ("50 %", ANGLE, ' ("%" is a ratio, not an angle)'),
        ("9^9^9^9 m", LENGTH, ' ("^9^9^9 m" is not a unit)'),
        ("8 psia", PRESSURE, ' (pressures are gauge pressures: subtract 14.7 psi and write "psi")'),
        ("8 BarG", PRESSURE, ' (pressures are gauge pressures: write "bar")'),
        ("1e400 mm", LENGTH, ", and finite"),
        ("1e9999999 m", LENGTH, ' ("e9999999 m" is not a unit)'),
        ("1,5 mm", LENGTH, ' (decimals follow a point, not a comma: "1.5 mm")'),
        ("1,500 mm", LENGTH, ""),
        ("nan mm", LENGTH, ""),
        ("1/0 in", LENGTH, ""),
        ("٣ mm", LENGTH, ""),
        (None, LENGTH, ""),
        (True, LENGTH, ""),
    ],
)
def test_refusal_says_what_would_be_right(text, dimension, hint):
    with pytest.raises(InvalidInputError) as caught:
        parse_quantity(text, dimension, field="--option")
    needed = f'{dimension.noun} with its unit, such as "{dimension.example}"'
    assert str(caught.value) == f"--option must be {needed}{hint}, got {text!r}"
    assert (caught.value.field, caught.value.value) == ("--option", text)


UNITS = st.from_regex(r"[0-9]{1,3}[ ]?[a-zA-Zµ°%/*^ 0-9_.·()-]{1,12}", fullmatch=True)


@given(st.one_of(st.text(), UNITS), DIMENSIONS)
def test_any_text_is_a_finite_value_or_refused(text, dimension):
    try:
        requirement = "" if math.isfinite(parse_quantity(text, dimension)) else "infinite"
    except InvalidInputError as error:
        requirement = error.requirement
    assert requirement == "" or requirement.startswith(dimension.requirement)


@pytest.mark.parametrize("dimension", Dimension)
def test_stated_units_and_examples_are_of_their_dimension(dimension):
    assert parse_quantity(dimension.example, dimension) > 0.0
    assert parse_quantity(f"1 {dimension.si_unit}", dimension) == 1.0
    assert len(dimension.usual_units) >= 2


@given(value=st.floats(min_value=1e-9, max_value=1e9), dimension=DIMENSIONS, data=st.data())
def test_conversion_back_and_forth(value, dimension, data):
    unit = data.draw(st.sampled_from(dimension.usual_units))
    there = convert_from_si(value, unit, dimension)
    # Two roundings, one each way.
    assert parse_quantity(f"{there!r} {unit}", dimension) == pytest.approx(value, rel=4e-16)


def test_conversion_refuses_a_unit_of_another_dimension():
    with pytest.raises(InvalidInputError, match=r'a unit of length \("psi" is a pressure, not a'):
        convert_from_si(1.0, "psi", LENGTH)
    assert unit_of(" 3/16 inches ", LENGTH) == "inches"


@pytest.mark.parametrize("text", ["105 %", "nan", ".inf", "1e999", "0x10", "1_000", "1.05 m", ""])
def test_number_with_anything_else_is_refused(text):
    assert parse_number("-1.5e2") == -150.0
    with pytest.raises(InvalidInputError, match="must be a plain finite number"):
        parse_number(text)


def printed_by(program):
    """Return the last line that a fresh interpreter prints."""
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[-1]


def test_the_package_imports_nothing_heavy_until_it_is_needed():
    heavy = "{'ruamel.yaml', 'numba', 'matplotlib'} & set(sys.modules)"
    assert printed_by(f"import sys, spiral_gripper\nprint({heavy})") == "set()"


def test_a_second_process_compiles_no_kernel():
    code = """
from numba.core import event
from spiral_gripper.cli.main import run
with event.install_recorder("numba:compile") as compiled:
    assert run(["wrap", "paper_design_70", "--radius", "20 mm", "--pressure", "60 kPa"]) == 0
print([record[1].data["dispatcher"] for record in compiled.buffer])
"""
    # The first one may have to compile.
    assert printed_by(code) == "[]" or printed_by(code) == "[]"
