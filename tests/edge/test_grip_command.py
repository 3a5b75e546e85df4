# SPDX-License-Identifier: Apache-2.0
"""The command ``grip``: what it prints, and about which objects."""

from dataclasses import replace
from pathlib import Path

import pytest

from spiral_core.grip import grip
from spiral_core.grip.window import WindowEnd, grip_window
from spiral_gripper.cli.main import run
from spiral_gripper.reports.grip import document

pytestmark = pytest.mark.long

ASKED = "grip paper_design_70 --radius 25mm --friction 0.2 --frictionless-closing"


@pytest.fixture(autouse=True)
def _few_forces(monkeypatch):
    """At four pressures instead of ten."""
    monkeypatch.setattr(grip, "FORCE_PRESSURES", 4)


def test_tables_fit_80_columns_and_no_figure_is_cut(capsys):
    run(["grip", "paper_design_70", "--radius", "20mm", "--every-direction", "--pressure", "56kPa"])
    printed = capsys.readouterr().out
    assert "…" not in printed
    assert max(map(len, printed.splitlines())) <= 80


def test_what_a_grip_owes_to_next_to_nothing_is_printed_on_request(said, monkeypatch):
    asked = f"{ASKED} --pressure 50kPa --spread"

    def never(*asked, **_):
        return replace(grip_window(*asked), onset_wrap=None, end=WindowEnd.PASSED_BY)

    monkeypatch.setattr(
        document, "nudged_windows", lambda setup: (grip_window(setup), never(setup))
    )
    rows = said(asked)
    assert "moved aside by" in rows
    assert "or not at all" in rows
    monkeypatch.setattr(document, "grip_window", never)
    assert "moved aside by 0.000361 mm it is wrapped from" in said(asked, code=2)


@pytest.mark.slow
def test_a_profile_says_which_part_of_it_is_held(answer, said):
    Path("cone.csv").write_text("position [mm],radius [mm]\n0,18\n300,22\n", "utf-8")
    asked = "grip paper_design_70 --profile cone.csv --pressure 56kPa"
    found = answer(asked)
    place = 1e3 * found["profile_position"]
    assert 0.0 < place < 300.0
    assert f"object's {place:.4g} mm mark at (x, y, z)" in said(asked)
    # The profile is thinnest at 0: its middle of the coil has this radius.
    assert found["object_radius"] == pytest.approx(0.018)
