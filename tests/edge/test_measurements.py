# SPDX-License-Identifier: Apache-2.0
"""Files of measurements: what is read, and each kind of bad file with its line and column."""

import math
from contextlib import suppress
from dataclasses import astuple
from pathlib import Path

import pytest
from edge.recorded import cases, check, written
from hypothesis import given
from hypothesis import strategies as st

from spiral_gripper.bench.measurements import load_measurements
from spiral_gripper.bench.options import CalibrationOptions
from spiral_gripper.files.table import TableError

PSI = 6894.757293168361


def parse(text, **options):
    stated = CalibrationOptions(**options)
    Path("bench.csv").write_text(text, "utf-8")
    return load_measurements("bench.csv", 0.361, stated)


def problems(text, **options):
    """Return the problems with a text."""
    with pytest.raises(TableError) as caught:
        parse(text, **options)
    return caught.value.problems


@pytest.mark.parametrize("heading", ["pressure [psi]", "pressure (psi)", "pressure_psi"])
def test_units_in_the_heading_or_beside_the_file(heading):
    text = f"{heading},extension [in],extension_error_mm,twist,twist_error\n4,0.1,0.2,90,2\n"
    stretched, twisted = parse(text, units={"twist": "deg", "twist_error": "deg"}).readings
    found = (*astuple(stretched), *astuple(twisted))
    expected = (4 * PSI, 0.00254, 0.361, 2e-4, 0, 4 * PSI, math.pi / 2, 0.361, math.radians(2), 0)
    assert found == pytest.approx(expected, rel=1e-12)


def test_every_kind_of_reading_and_the_lines_they_come_from():
    text = (
        "# synthetic\n"
        "pressure [kPa],extension [mm],twist [deg],bend_angle [rad],"
        "x [mm],y [mm],z [mm],arc_length [mm],object_radius [mm],section_length [mm],remark\n"
        "20,4,-10,,,,,,,100,\n"
        "\n"
        "30,,,1.5,,,,,,,fine\n"
        "40,,,,100,20,-3,150,,,\n"
        "40,,,,200,40,-6,,,,\n"
        "50,,,,,,,,21,,\n"
    )
    errors = {
        "extension": "0.2 mm", "twist": "2 %", "bend_angle": "0.02 rad", "position": "1 mm",
        "object_radius": "0.1 mm", "pressure": "1 kPa",
    }  # fmt: skip
    found = parse(text, errors=errors, section_length=0.2, ignored=("remark",))
    readings = zip(found.lines, found.readings, strict=True)
    check("readings.txt", "every kind", [f"line {line}: {each!r}" for line, each in readings])


HEADER = "pressure [kPa],extension [mm],extension_error [mm]"
GOOD = f"{HEADER}\n20,4.0,0.2\n40,9.5,0.2\n"


@pytest.mark.parametrize("case", cases("measurements.txt"))
def test_a_bad_file_is_named_with_line_and_column(case):
    said = problems(written(case))
    check("measurements.txt", case, map(str, said))


def test_what_is_stated_beside_the_file_must_fit_it():
    for reason, stated in {
        "no column": {"units": {"presure": "psi"}},
        'but "psi" is stated for it': {"units": {"pressure": "psi"}},
        "only these can have one: pressure, extension": {"errors": {"colour": "1 mm"}},
    }.items():
        assert reason in problems(GOOD, **stated)[0].reason
    stray = {"stray3": "mm", "stray1": "mm"}
    assert [problem.heading for problem in problems(GOOD, units=stray)] == list(stray)
    bare = GOOD.replace(",extension_error [mm]", "").replace(",0.2\n", "\n")
    for wrong in ("0.2", "2 kPa", "-1 %", "0 mm"):
        found = problems(bare, errors={"extension": wrong})
        assert [(p.line, p.heading) for p in found] == [(k, "extension_error") for k in (2, 3)]
    (share,) = problems(bare.replace("20,4.0", "20,0"), errors={"extension": "2 %"})
    assert (share.line, share.heading) == (2, "extension_error")
    assert share.reason.endswith("a share of a reading of 0 is no error, got 2 %")


@given(st.text(max_size=200), st.sampled_from(["", f"{HEADER}\n"]))
def test_any_text_gives_readings_or_a_measurement_error(text, header):
    with suppress(TableError):
        assert parse(header + text).readings
