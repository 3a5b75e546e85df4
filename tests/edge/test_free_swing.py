# SPDX-License-Identifier: Apache-2.0
"""``calibrate --free-swing``: from a CSV file to the damping, and refusals by name."""

import re
from pathlib import Path

import pytest
from repo.source_tree import ROOT

DATA = ROOT / "examples" / "data"
SWING = (DATA / "free_swing.csv").read_text("utf-8")


def asked(text=SWING):
    """Return the arguments for a swing, written to a file."""
    Path("swing.csv").write_text(text)
    return f"calibrate {DATA}/my_gripper.yaml swing.csv --free-swing"


def test_the_example_tells_the_damping_it_was_made_with(answer, said):
    told = answer(asked())
    for name, true in (("retardation_time", 0.020), ("air", 1.0)):
        low, high = told["values"][name]["interval"]
        assert low < true < high
    report = said(asked(), "--hold air=1")
    assert re.search("free swing of 1.1.*retardation_time: 0.0.*95 % interval", report)
    assert "air:" not in report
    # An error stated beside the file is that of its column; a large swing is warned of.
    bare = re.sub("(,.*?),.*?,", r"\1,", SWING)
    assert answer(asked(bare), "--error displacement=0.3mm") == told
    wide = re.sub(r"(?<=,)-?\d+\.\d+(?=,0)", lambda cell: str(2.0 * float(cell[0])), SWING)
    assert "the swing is large" in said(asked(wide))


# What is changed in the file -> a part of the refusal.
UNUSABLE = {
    "time [s] -> time [min]": "check the unit of time",
    "displacement [mm] -> displacement [in]": "check the unit",
    "displacement [mm] -> extension [mm]": "holds a measurement: one of displacement",
    "displacement_error [mm] -> arc_length [mm]": '"displacement_error": is missing',
    "displacement_error [mm],p -> arc_length [mm],p": "does not belong to a free swing",
    "1.04, -> 1.00,": "holds a time twice",
    "1.04, -> ,": "is blank",
    "1.04, -> abc,": ":4: column 1",
    "0.3,0\n1.04 -> 0.3,5\n1.04": "one gauge pressure",
    "0.3,0\n1.04 -> -0.3,0\n1.04": "positive",
    "0.3,0\n -> 0.3,900\n": "at most the gripper's limit",
    ",0.3, -> ,1e-300,": "from 1e-12",
}


@pytest.mark.parametrize("change", UNUSABLE)
def test_a_file_that_cannot_be_used_is_refused_by_name(said, change):
    old, new = change.split(" -> ")
    assert old in SWING
    assert UNUSABLE[change] in said(asked(SWING.replace(old, new)), code=2)
