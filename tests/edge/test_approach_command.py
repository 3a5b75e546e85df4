# SPDX-License-Identifier: Apache-2.0
"""The command ``approach``: poses in tables, data and a picture; a file from which it goes on."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from spiral_core.grip import approach
from spiral_core.grip.approach import Trial, approach_setup
from spiral_core.grip.setup import hanging_tube
from spiral_core.grip.window import GripPoint

ASKED = ["approach", "paper_design_70", "--radius", "15 mm", "--coarse", "--jobs", "1"]
UPRIGHT = [*ASKED, "--object-axis", "0", "0", "1", "--payload", "20 g"]


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


def test_programs_get_the_pose_of_the_base_in_the_world(screened, answer, tmp_path):
    picture = tmp_path / "approach.png"
    found = answer(*UPRIGHT, "--plot", str(picture))
    assert (found["poses_tried"], found["poses_gripping"]) == (len(screened), 1)
    assert found["reasons"] == {"far away": len(screened) - 1}
    (best,) = found["approaches"]
    turn = Rotation.from_quat(best["orientation"])
    assert turn.apply((1.0, 0.0, 0.0)) == pytest.approx(best["tube_direction"])
    assert best["tube_direction"] == pytest.approx((0.0, 0.0, -1.0), abs=1e-12)
    assert best["position"][2] > 0.1  # the base is above the object's middle
    assert best["payload_ratio"] == pytest.approx(best["force"] / (0.02 * 9.80665))
    assert (best["capture_size"], best["capture"]) == (0.0, None)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_people_get_tables_in_their_units(screened, said):
    printed = said(*UPRIGHT, "--units", "in,psi")
    for part in ("approach 1", "+0.000 +0.000 -1.000", "10.15 psi", "3.57 times"):
        assert part in printed
    assert f"1 of {len(screened)} poses tried grip" in printed


def test_an_interrupted_search_goes_on_and_another_question_begins_anew(screened, said, tmp_path):
    file = tmp_path / "approach.jsonl"
    asked = [*ASKED, "--object-axis", "1", "0", "0", "--results", str(file), "--tilt-max"]
    first, count = said(*asked, "10 deg", "--gravity", "0", "0", "-2"), len(screened)
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    file.write_text("".join(lines[:-2]) + lines[-2][:40], encoding="utf-8")
    assert said(*asked, "10 deg") == first
    assert len(screened) == count + 2
    said(*asked, "11 deg")
    assert len(screened) > count + 4


@pytest.mark.usefixtures("screened")
@pytest.mark.parametrize("value", ['"force": NaN', '"pressure": "high"', '"missing": NaN', ""])
def test_a_damaged_file_of_results_is_refused_and_other_questions_are_left(value, said, tmp_path):
    file, others = tmp_path / "approach.jsonl", '{"case": ["a", [1.0]], "outcome": "HOLDS"}\n'
    outcome = f'{{"refusal": "", {value}}}' if value else '"UNKNOWN"'
    file.write_text(f'{others}{{"case": [], "outcome": {outcome}}}\n', encoding="utf-8")
    asked = [*UPRIGHT, "--results", str(file)]
    assert "line 2 must be an outcome of a study" in said(*asked, code=2)
    file.write_text(others, encoding="utf-8")
    said(*asked)
    assert file.read_text(encoding="utf-8").startswith(others)


def test_where_nothing_grips_the_reasons_and_the_nearest_are_printed(said, monkeypatch):
    def answered(missing):
        screen = lambda _, pose: Trial("too far", missing(pose))  # noqa: E731
        screen.__name__ = "screen"
        monkeypatch.setattr(approach, "screen", screen)
        return said(*UPRIGHT, code=1)

    nearest = "poses: too far the nearest: with the tube at the base along "
    printed = answered(lambda pose: 1.0 - pose.gravity[0])
    place = printed.partition(nearest)[2].split()[:3]
    assert np.array(place, dtype=float) == pytest.approx((0.0, 0.0, -1.0), abs=1e-3)
    assert "the nearest" not in answered(lambda _: math.inf)
