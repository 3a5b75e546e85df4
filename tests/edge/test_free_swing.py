# SPDX-License-Identifier: Apache-2.0
"""``calibrate --free-swing``: from a CSV file to the damping, and refusals by name."""

import re
import shlex
from pathlib import Path

import pytest
from edge.recorded import cases, changed, check
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
    assert "air:" not in said(asked(), "--hold air=1")
    # An error stated beside the file is that of its column; a large swing is warned of.
    bare = re.sub("(,.*?),.*?,", r"\1,", SWING)
    assert answer(asked(bare), "--error displacement=0.3mm") == told
    still = re.sub(r"(?<=\n1.04,)[^,]+", "0", bare)
    told = said(asked(still), "--error", shlex.quote("displacement=2 %"), code=2)
    assert '"displacement_error": must be a quantity' in told
    assert told.endswith("got 2 %")
    upright = DATA.joinpath("my_gripper.yaml").read_text("utf-8").replace("[1, 0, 0]", "[-1, 0, 0]")
    Path("upright.yaml").write_text(upright)
    told = said(asked().replace(f"{DATA}/my_gripper.yaml", "upright.yaml"), code=2)
    assert "gravity must be one that holds the tube on one side" in told
    wide = re.sub(r"(?<=,)-?\d+\.\d+(?=,0)", lambda cell: str(2.0 * float(cell[0])), SWING)
    assert "the swing is large" in said(asked(wide))


@pytest.mark.parametrize("change", cases("free_swings.txt"))
def test_a_file_that_cannot_be_used_is_refused_by_name(said, change):
    check("free_swings.txt", change, [said(asked(changed(SWING, change)), code=2)[:300]])
