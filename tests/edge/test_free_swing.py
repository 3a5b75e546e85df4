# SPDX-License-Identifier: Apache-2.0
"""``calibrate --free-swing``: from a CSV file to the damping, and refusals by name."""

import re

import pytest
from repo.source_tree import ROOT

DATA = ROOT / "examples" / "data"
SWING = (DATA / "free_swing.csv").read_text(encoding="utf-8")


@pytest.fixture
def asked(tmp_path):
    """Return a function that gives the arguments for a swing, written to a file."""

    def asked(text, *options):
        path = tmp_path / "swing.csv"
        path.write_text(text, encoding="utf-8")
        return ["calibrate", str(DATA / "my_gripper.yaml"), str(path), "--free-swing", *options]

    return asked


def test_the_example_tells_the_damping_it_was_made_with(answer, said, asked):
    told = answer(*asked(SWING))
    for name, true in (("retardation_time", 0.020), ("air", 1.0)):
        low, high = told["values"][name]["interval"]
        assert low < true < high
    assert told["warnings"] == []
    report = said(*asked(SWING, "--hold", "air=1"))
    assert re.search("free swing of 1.1.*retardation_time: 0.0.*95 % interval", report)
    assert "air:" not in report
    # An error stated beside the file is that of its column; a large swing is warned of.
    cells = [line.split(",") for line in SWING.splitlines()[1:]]
    bare = "\n".join(f"{t},{y},{p}" for t, y, _, p in cells)
    assert answer(*asked(bare, "--error", "displacement=0.3 mm")) == told
    wide = [",".join(cells[0])] + [f"{t},{2.0 * float(y)},{e},{p}" for t, y, e, p in cells[1:]]
    assert "the swing is large" in said(*asked("\n".join(wide)))


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
def test_a_file_that_cannot_be_used_is_refused_by_name(said, asked, change):
    old, new = change.split(" -> ")
    assert old in SWING
    assert UNUSABLE[change] in said(*asked(SWING.replace(old, new)), code=2)
