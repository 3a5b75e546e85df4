# SPDX-License-Identifier: Apache-2.0
"""The command ``approach``: poses in tables, data and a picture; a file from which it goes on."""

import math
from pathlib import Path
from types import SimpleNamespace

import pytest
from edge.recorded import cases

from spiral_core.grip import approach
from spiral_core.grip.approach import Trial, approach_setup
from spiral_core.grip.setup import hanging_tube
from spiral_core.grip.window import GripPoint

UPRIGHT = (
    "approach paper_design_70 --radius 15mm --coarse --jobs 1 --object-axis 0 0 1 --payload 20g"
)


@pytest.fixture
def screened(monkeypatch):
    """Poses that were closed on; only those that hang within 15 degrees grip."""
    poses = []

    def screen(_, pose):
        poses.append(pose)
        hangs = pose.gravity[0] > math.cos(math.radians(15.0)) and not any(pose.shift)
        return Trial("", 0.0, 70e3, pose.gravity[0]) if hangs else Trial("far away", 2.0)

    def gripped(task, pose):
        setup = approach_setup(task, pose, 20)
        return GripPoint(70e3, setup, hanging_tube(setup))

    monkeypatch.setattr(approach, "screen", screen)
    monkeypatch.setattr(approach, "gripped", gripped)
    monkeypatch.setattr(approach, "holding_force", lambda *_: SimpleNamespace(force=0.7))
    monkeypatch.setattr(approach, "COARSE_DIRECTIONS", 2)
    return poses


@pytest.mark.usefixtures("screened")
@pytest.mark.parametrize("asked", cases("approach.txt"))
def test_poses_are_printed_and_drawn_as_recorded(asked, recorded):
    recorded("approach.txt", asked)


def test_a_search_goes_on_from_its_file_and_another_question_begins_anew(screened, answer):
    asked = f"{UPRIGHT} --results approach.jsonl"
    first, count = answer(asked, "--gravity 0 0 -2"), len(screened)
    assert answer(asked) == first
    assert len(screened) == count
    answer(asked, "--tilt-max 11deg")
    assert len(screened) > count


@pytest.mark.usefixtures("screened")
@pytest.mark.parametrize(
    "outcome",
    ['{"refusal": "", "force": NaN}', '{"refusal": "", "pressure": "high"}', '"UNKNOWN"'],
)
def test_a_damaged_file_of_results_is_refused(outcome, said):
    other = '{"case": ["a", [1.0]], "outcome": "HOLDS"}'
    Path("approach.jsonl").write_text(f'{other}\n{{"case": [], "outcome": {outcome}}}\n', "utf-8")
    refused = said(UPRIGHT, "--results approach.jsonl", code=2)
    assert "line 2 must be an outcome of a study" in refused


@pytest.mark.parametrize("nearest", [True, False])
def test_where_nothing_grips_the_reasons_and_the_nearest_are_printed(said, monkeypatch, nearest):
    def screen(_, pose):
        return Trial("too far", 1.0 - pose.gravity[0] if nearest else math.inf)

    monkeypatch.setattr(approach, "screen", screen)
    printed = said(UPRIGHT, "--results kept.jsonl", code=1)
    assert "70 x too far" in printed
    assert "Infinity" not in Path("kept.jsonl").read_text("utf-8")
    assert said(UPRIGHT, "--results kept.jsonl", code=1) == printed.removesuffix(" closing ...")
    nearest_pose = "the nearest: with the tube at the base along +0.000 +0.000 -1.000"
    assert (nearest_pose in printed) is nearest
