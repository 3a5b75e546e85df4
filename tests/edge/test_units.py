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

INCH = 0.0254
POUND_FORCE = 0.45359237 * 9.80665
PSI = POUND_FORCE / INCH**2


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("4.7625 mm", Dimension.LENGTH, 4.7625e-3),
        ("4.7625mm", Dimension.LENGTH, 4.7625e-3),
        ("  4.7625   mm ", Dimension.LENGTH, 4.7625e-3),
        ("3\N{NO-BREAK SPACE}mm", Dimension.LENGTH, 3e-3),
        ("3/16 in", Dimension.LENGTH, 4.7625e-3),
        ("-3/16 in", Dimension.LENGTH, -4.7625e-3),
        ("+1e-3 m", Dimension.LENGTH, 1e-3),
        (".5 ft", Dimension.LENGTH, 0.1524),
        ("4 µm", Dimension.LENGTH, 4e-6),
        ("8 psi", Dimension.PRESSURE, 8 * PSI),
        ("8 lbf/in^2", Dimension.PRESSURE, 8 * PSI),
        ("0.13 MPa", Dimension.PRESSURE, 130e3),
        ("1.5 bar", Dimension.PRESSURE, 150e3),
        ("88 deg", Dimension.ANGLE, math.radians(88)),
        ("-60°", Dimension.ANGLE, -math.radians(60)),
        ("1.25 rad", Dimension.ANGLE, 1.25),
        ("2 °3 °-2", Dimension.ANGLE, math.radians(2)),
        ("0.95 g/cm^3", Dimension.DENSITY, 950.0),
        ("0.95 g/cm3", Dimension.DENSITY, 950.0),
        ("0.95 g cm-3", Dimension.DENSITY, 950.0),
        ("950 kg/m³", Dimension.DENSITY, 950.0),
        ("9.81 m/s^2", Dimension.ACCELERATION, 9.81),
        ("9.81 m/s**2", Dimension.ACCELERATION, 9.81),
        ("1 standard_gravity", Dimension.ACCELERATION, 9.80665),
        ("2e-4 N m^2", Dimension.FLEXURAL_STIFFNESS, 2e-4),
        ("200 N·mm²", Dimension.FLEXURAL_STIFFNESS, 2e-4),
        ("200 N*mm^2", Dimension.FLEXURAL_STIFFNESS, 2e-4),
        ("1.5 g/m", Dimension.MASS_PER_LENGTH, 1.5e-3),
    ],
)
def test_quantity_in_si_units(text, dimension, expected):
    assert parse_quantity(text, dimension) == pytest.approx(expected, rel=1e-15, abs=0.0)


def test_values_are_rounded_once():
    """Floating-point conversion factors would give 0.0047624999... and 949.9999...."""
    assert parse_quantity("3/16 in", Dimension.LENGTH) == 0.0047625
    assert parse_quantity("0.95 g/cm^3", Dimension.DENSITY) == 950.0
    assert parse_quantity("0.794 mm", Dimension.LENGTH) == 0.000794


LENGTH = 'must be a length with its unit, such as "4.7625 mm"'
PRESSURE = 'must be a pressure with its unit, such as "55 kPa"'
ANGLE = 'must be an angle with its unit, such as "60 deg"'


@pytest.mark.parametrize(
    ("text", "dimension", "message"),
    [
        (
            8,
            Dimension.PRESSURE,
            f'pressure {PRESSURE} (write "8 kPa" or "8 psi" or whichever unit is meant), got 8',
        ),
        (
            "4.7625",
            Dimension.LENGTH,
            (
                f'length {LENGTH} (write "4.7625 mm" or "4.7625 in" or whichever unit is meant), '
                "got '4.7625'"
            ),
        ),
        (
            "8 mpa",
            Dimension.PRESSURE,
            f'pressure {PRESSURE} (there is no unit "mpa"; did you mean "MPa"?), got \'8 mpa\'',
        ),
        (
            "5 MM",
            Dimension.LENGTH,
            f'length {LENGTH} (there is no unit "MM"; did you mean "mm"?), got \'5 MM\'',
        ),
        (
            "8 flurbs",
            Dimension.PRESSURE,
            f"pressure {PRESSURE} (there is no unit \"flurbs\"), got '8 flurbs'",
        ),
        (
            "3 kg",
            Dimension.LENGTH,
            f"length {LENGTH} (\"kg\" is a mass, not a length), got '3 kg'",
        ),
        (
            "8 lb/in^2",
            Dimension.PRESSURE,
            f"pressure {PRESSURE} (\"lb/in^2\" is not a pressure), got '8 lb/in^2'",
        ),
        (
            "8 psi rad",
            Dimension.PRESSURE,
            (f"pressure {PRESSURE} (\"psi rad\" is not a pressure), got '8 psi rad'"),
        ),
        (
            "3 m/m",
            Dimension.ANGLE,
            f"angle {ANGLE} (\"m/m\" is not an angle), got '3 m/m'",
        ),
        (
            "50 %",
            Dimension.ANGLE,
            f"angle {ANGLE} (\"%\" is a ratio, not an angle), got '50 %'",
        ),
        (
            "8 psi percent",
            Dimension.PRESSURE,
            (f"pressure {PRESSURE} (\"percent\" is a ratio, not a pressure), got '8 psi percent'"),
        ),
        (
            "8 Pa dB",
            Dimension.PRESSURE,
            f"pressure {PRESSURE} (\"dB\" is a ratio, not a pressure), got '8 Pa dB'",
        ),
        (
            "20 degC",
            Dimension.LENGTH,
            f"length {LENGTH} (there is no unit \"degC\"), got '20 degC'",
        ),
        (
            "9^9^9^9 m",
            Dimension.LENGTH,
            f"length {LENGTH} (\"^9^9^9 m\" is not a unit), got '9^9^9^9 m'",
        ),
        (
            "3 mm + 2 mm",
            Dimension.LENGTH,
            f"length {LENGTH} (\"mm + 2 mm\" is not a unit), got '3 mm + 2 mm'",
        ),
        ("1e400 mm", Dimension.LENGTH, f"length {LENGTH}, and finite, got '1e400 mm'"),
        (
            "1e9999999 m",
            Dimension.LENGTH,
            f"length {LENGTH} (\"e9999999 m\" is not a unit), got '1e9999999 m'",
        ),
        ("1e308 km", Dimension.LENGTH, f"length {LENGTH}, and finite, got '1e308 km'"),
        (
            "3 nan",
            Dimension.LENGTH,
            f"length {LENGTH} (there is no unit \"nan\"), got '3 nan'",
        ),
        (
            "1,5 mm",
            Dimension.LENGTH,
            f"length {LENGTH} (decimals follow a point, not a comma: \"1.5 mm\"), got '1,5 mm'",
        ),
        ("1,500 mm", Dimension.LENGTH, f"length {LENGTH}, got '1,500 mm'"),
        ("1.0.0 mm", Dimension.LENGTH, f"length {LENGTH}, got '1.0.0 mm'"),
        ("±3 mm", Dimension.LENGTH, f"length {LENGTH}, got '±3 mm'"),
        ("mm", Dimension.LENGTH, f"length {LENGTH}, got 'mm'"),
        ("nan mm", Dimension.LENGTH, f"length {LENGTH}, got 'nan mm'"),
        ("inf mm", Dimension.LENGTH, f"length {LENGTH}, got 'inf mm'"),
        ("1/0 in", Dimension.LENGTH, f"length {LENGTH}, got '1/0 in'"),
        ("٣ mm", Dimension.LENGTH, f"length {LENGTH}, got '٣ mm'"),
        ("", Dimension.LENGTH, f"length {LENGTH}, got ''"),
        (None, Dimension.LENGTH, f"length {LENGTH}, got None"),
        (True, Dimension.LENGTH, f"length {LENGTH}, got True"),
    ],
)
def test_refusal_says_what_would_be_right(text, dimension, message):
    with pytest.raises(InvalidInputError) as caught:
        parse_quantity(text, dimension)
    assert str(caught.value) == message


def test_refusal_names_the_field_given():
    with pytest.raises(InvalidInputError) as caught:
        parse_quantity("3 kg", Dimension.LENGTH, field="--length")
    assert caught.value.field == "--length"
    assert caught.value.value == "3 kg"


def value_or_refusal(text, dimension):
    try:
        return parse_quantity(text, dimension), ""
    except InvalidInputError as error:
        return 0.0, error.requirement


@given(st.text(), st.sampled_from(list(Dimension)))
def test_any_text_is_a_finite_value_or_refused(text, dimension):
    value, requirement = value_or_refusal(text, dimension)
    assert math.isfinite(value)
    assert requirement == "" or requirement.startswith(dimension.requirement)


@given(
    st.from_regex(r"[0-9]{1,3}[ ]?[a-zA-Zµ°%/*^ 0-9_.·()-]{1,12}", fullmatch=True),
    st.sampled_from(list(Dimension)),
)
def test_any_unit_is_a_finite_value_or_refused(text, dimension):
    value, requirement = value_or_refusal(text, dimension)
    assert math.isfinite(value)
    assert requirement == "" or requirement.startswith(dimension.requirement)


@pytest.mark.parametrize("dimension", list(Dimension))
def test_stated_units_and_examples_are_of_their_dimension(dimension):
    assert parse_quantity(dimension.example, dimension) > 0.0
    assert parse_quantity(f"1 {dimension.si_unit}", dimension) == 1.0
    assert len(dimension.usual_units) >= 2
    for unit in dimension.usual_units:
        assert parse_quantity(f"2 {unit}", dimension) > 0.0


@given(
    value=st.floats(min_value=1e-9, max_value=1e9),
    dimension=st.sampled_from(list(Dimension)),
    data=st.data(),
)
def test_conversion_back_and_forth(value, dimension, data):
    unit = data.draw(st.sampled_from(dimension.usual_units))
    there = convert_from_si(value, unit, dimension)
    # Two roundings, one each way.
    assert parse_quantity(f"{there!r} {unit}", dimension) == pytest.approx(value, rel=4e-16)


def test_conversion_refuses_a_unit_of_another_dimension():
    with pytest.raises(InvalidInputError) as caught:
        convert_from_si(1.0, "psi", Dimension.LENGTH)
    assert str(caught.value) == (
        "unit must be a unit of length (\"psi\" is a pressure, not a length), got 'psi'"
    )


def test_unit_of_a_quantity_is_as_written():
    assert unit_of(" 3/16 inches ", Dimension.LENGTH) == "inches"


def test_plain_number():
    assert parse_number("-1.5e2") == -150.0


@pytest.mark.parametrize("text", ["105 %", "nan", ".inf", "1e999", "0x10", "1_000", "1.05 m", ""])
def test_number_with_anything_else_is_refused(text):
    with pytest.raises(InvalidInputError, match="must be a plain finite number"):
        parse_number(text)


def test_the_package_imports_no_yaml_until_they_are_needed():
    program = (
        "import sys, spiral_gripper\n"
        "heavy = {'ruamel.yaml', 'numba', 'matplotlib'} & set(sys.modules)\n"
        "sys.exit(f'imported at once: {heavy}' if heavy else 0)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("1 kpa", Dimension.PRESSURE, 1e3),
        ("1 PSI", Dimension.PRESSURE, PSI),
        ("1 Bar", Dimension.PRESSURE, 1e5),
        ("1 atm", Dimension.PRESSURE, 101325.0),
        ("760 torr", Dimension.PRESSURE, 101325.0),
        ("1 kN/m^2", Dimension.PRESSURE, 1e3),
        ("1 kgf", Dimension.FORCE, 9.80665),
        ("1 lb", Dimension.MASS, 0.45359237),
        ("16 oz", Dimension.MASS, 0.45359237),
        ("1 lbf", Dimension.FORCE, POUND_FORCE),
        ("31.25 thou", Dimension.LENGTH, 7.9375e-4),
        ("1 inch", Dimension.LENGTH, INCH),
        ("1 turn/m", Dimension.CURVATURE, 2.0 * math.pi),
        ("2 min", Dimension.TIME, 120.0),
        ("1 psi/min", Dimension.PRESSURE_RATE, PSI / 60.0),
    ],
)
def test_units_have_their_size(text, dimension, expected):
    assert parse_quantity(text, dimension) == pytest.approx(expected, rel=1e-15)


def test_a_second_process_compiles_no_kernel():
    code = """
from numba.core import event
from spiral_gripper.cli.main import run
with event.install_recorder("numba:compile") as compiled:
    assert run(["wrap", "paper_design_70", "--radius", "20 mm", "--pressure", "60 kPa"]) == 0
print([record[1].data["dispatcher"] for record in compiled.buffer])
"""
    for _ in range(2):  # the first one may have to compile
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        )
        if "[]" in done.stdout.splitlines():
            break
    assert done.stdout.splitlines()[-1] == "[]"
