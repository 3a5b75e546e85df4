# SPDX-License-Identifier: Apache-2.0
"""Quantities with units: what is read, to which SI value, and what is refused with which words."""

import math
import subprocess
import sys
from ast import literal_eval
from contextlib import suppress

import pytest
from edge.recorded import cases, check
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


@pytest.mark.parametrize("dimension", SI_VALUES)
def test_quantity_in_si_units(dimension):
    for text, expected in SI_VALUES[dimension].items():
        assert parse_quantity(text, dimension) == pytest.approx(expected, rel=1e-15, abs=0.0), text


def test_values_are_rounded_once():
    """Floating-point conversion factors would give 0.0047624999...."""
    assert parse_quantity("3/16 in", LENGTH) == 0.0047625


@pytest.mark.parametrize("case", cases("units.txt"))
def test_refusal_says_what_would_be_right(case):
    dimension, _, text = case.partition(": ")
    with pytest.raises(InvalidInputError) as caught:
        parse_quantity(literal_eval(text), Dimension[dimension], field="--option")
    check("units.txt", case, [str(caught.value)])


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
