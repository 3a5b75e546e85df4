# SPDX-License-Identifier: Apache-2.0
"""Quantities with units: what is read, to which SI value, and what is refused with which words."""

import math
import subprocess
import sys
from contextlib import suppress

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
PSI = 0.45359237 * 9.80665 / 0.0254**2
DIMENSIONS = st.sampled_from(Dimension)


SI_VALUES = {
    LENGTH: {
        "4.7625mm": 4.7625e-3,
        "3\N{NO-BREAK SPACE}mm": 3e-3,
        "-3/16 in": -4.7625e-3,
        "4 µm": 4e-6,
        "31.25 thou": 7.9375e-4,
    },
    PRESSURE: {"8 lbf/in^2": 8 * PSI, "1 kpa": 1e3, "760 torr": 101325.0},
    ANGLE: {"-60°": -math.radians(60), "2 °3 °-2": math.radians(2)},
    Dimension.DENSITY: {"0.95 g/cm3": 950.0},
    Dimension.FLEXURAL_STIFFNESS: {"200 N·mm²": 2e-4},
    Dimension.FORCE: {"1 kgf": 9.80665},
    Dimension.MASS: {"16 oz": 0.45359237},
    Dimension.CURVATURE: {"1 turn/m": 2.0 * math.pi},
    Dimension.PRESSURE_RATE: {"1 psi/min": PSI / 60.0},
}
# What is no quantity of a dimension, and the hint of the refusal.
NOT_READ = {
    PRESSURE: {
        8: ' (write "8 kPa" or "8 psi" or whichever unit is meant)',
        "8 mpa": ' (there is no unit "mpa"; did you mean "MPa"?)',
        "8 lb/in^2": ' ("lb/in^2" is not a pressure)',
        "8 psia": ' (pressures are gauge pressures: subtract 14.7 psi and write "psi")',
        "8 BarG": ' (pressures are gauge pressures: write "bar")',
    },
    Dimension.TIME: {"2 S": ' (there is no unit "S"; did you mean "s"?)'},
    LENGTH: {
        "3 kg": ' ("kg" is a mass, not a length)',
        "9^9^9^9 m": ' ("^9^9^9 m" is not a unit)',
        "1e400 mm": ", and finite",
        "1e9999999 m": ' ("e9999999 m" is not a unit)',
        "1,5 mm": ' (decimals follow a point, not a comma: "1.5 mm")',
        **dict.fromkeys(["1,500 mm", "nan mm", "1/0 in", "٣ mm", None, True], ""),
    },
    ANGLE: {
        "50 %": ' ("%" is a ratio, not an angle)',
    },
}


@pytest.mark.parametrize("dimension", SI_VALUES)
def test_quantity_in_si_units(dimension):
    for text, expected in SI_VALUES[dimension].items():
        assert parse_quantity(text, dimension) == pytest.approx(expected, rel=1e-15, abs=0.0), text


def test_values_are_rounded_once():
    """Floating-point conversion factors would give 0.0047624999...."""
    assert parse_quantity("3/16 in", LENGTH) == 0.0047625


@pytest.mark.parametrize("dimension", NOT_READ)
def test_refusal_says_what_would_be_right(dimension):
    needed = f'{dimension.noun} with its unit, such as "{dimension.example}"'
    for text, hint in NOT_READ[dimension].items():
        with pytest.raises(InvalidInputError) as caught:
            parse_quantity(text, dimension, field="--option")
        assert str(caught.value) == f"--option must be {needed}{hint}, got {text!r}"


UNITS = st.from_regex(r"[0-9]{1,3}[ ]?[a-zA-Zµ°%/*^ 0-9_.·()-]{1,12}", fullmatch=True)


@given(st.one_of(st.text(), UNITS), DIMENSIONS)
def test_any_text_is_a_finite_value_or_refused(text, dimension):
    with suppress(InvalidInputError):
        assert math.isfinite(parse_quantity(text, dimension))


@pytest.mark.parametrize("dimension", Dimension)
def test_stated_units_and_examples_are_of_their_dimension(dimension):
    assert parse_quantity(dimension.example, dimension) > 0.0
    assert parse_quantity(f"1 {dimension.si_unit}", dimension) == 1.0


@given(st.floats(1e-9, 1e9), DIMENSIONS, st.data())
def test_conversion_back_and_forth(value, dimension, data):
    unit = data.draw(st.sampled_from(dimension.usual_units))
    there = convert_from_si(value, unit, dimension)
    # Two roundings, one each way.
    assert parse_quantity(f"{there!r} {unit}", dimension) == pytest.approx(value, rel=4e-16)


def test_conversion_refuses_a_unit_of_another_dimension():
    with pytest.raises(InvalidInputError, match=r'a unit of length \("psi" is a pressure, not a'):
        convert_from_si(1.0, "psi", LENGTH)
    assert unit_of(" 3/16 inches ", LENGTH) == "inches"


@pytest.mark.parametrize("text", ["105 %", "nan", "1e999", "0x10", "1_000", ""])
def test_number_with_anything_else_is_refused(text):
    assert parse_number("-1.5e2") == -150.0
    with pytest.raises(InvalidInputError, match="must be a plain finite number"):
        parse_number(text)


def test_a_second_process_compiles_no_kernel():
    code = """
from numba.core import event
from spiral_gripper.cli.main import run
with event.install_recorder("numba:compile") as compiled:
    assert run(["wrap", "paper_design_70", "--radius", "20 mm", "--pressure", "60 kPa"]) == 0
print([record[1].data["dispatcher"] for record in compiled.buffer])
"""
    command = [sys.executable, "-c", code]
    # The first one may have to compile.
    printed = (subprocess.check_output(command, text=True).splitlines()[-1] for _ in range(2))
    assert "[]" in printed
