# SPDX-License-Identifier: Apache-2.0
"""What commands print, write and draw is what was recorded."""

import re
from pathlib import Path

import pytest
from edge.recorded import cases

from spiral_core.design import charts
from spiral_core.grip import grip

pytestmark = pytest.mark.long


@pytest.mark.parametrize("asked", cases("commands.txt"))
def test_a_command_prints_writes_and_draws_what_was_recorded(asked, recorded, monkeypatch):
    monkeypatch.setattr(grip, "FORCE_PRESSURES", 2)
    monkeypatch.setattr(charts, "CONTACT_POINTS", 3)
    Path("cone.csv").write_text("position [cm], radius [mm]\n0, 30\n30, 11\n", "utf-8")
    lines = recorded("commands.txt", asked)
    if "--units psi,in,rad,lbf,oz" in asked:  # no usual unit is left where all are chosen
        named = " ".join(lines).replace("9.5 mm x 0.8 mm", "")  # the tube's name, as it was typed
        assert re.findall(r"\d (?:mm|m|kPa|Pa|deg|N|N mm|kg)\b", named) == []
