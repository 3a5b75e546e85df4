# SPDX-License-Identifier: Apache-2.0
"""The commands ``shape``, ``wrap``, ``chart`` and ``grippers``: answers, profiles, pictures."""

import json
from pathlib import Path

import numpy as np
import pytest
from edge.recorded import cases

from spiral_core.grip import grip, places
from spiral_gripper import available_grippers, load_description
from spiral_gripper.cli.main import run

pytestmark = pytest.mark.long


def test_without_gravity_a_tube_at_rest_is_straight(answer):
    asked = "shape prototype_p1 --pressure 0kPa --gravity-direction 0 0 1"
    free = answer(asked, "--gravity-magnitude 0m/s^2")
    assert free["positions"][-1] == pytest.approx([0.5, 0.0, 0.0], abs=1e-9)


def test_a_direction_of_gravity_keeps_the_magnitude_of_the_file(answer, mine):
    text, asked = mine.read_text("utf-8"), "shape mine.yaml --pressure 20kPa"
    for magnitude, own in ((1.62, 1.62), (0.0, 9.80665)):
        changed = text.replace("gravity_magnitude: 9.80665", f"gravity_magnitude: {magnitude}")
        mine.write_text(changed, "utf-8")
        assert answer(asked)["gravity"] == [magnitude, 0.0, 0.0]
        assert answer(asked, "--gravity-direction 0 2 0")["gravity"] == [0.0, own, 0.0]
        assert answer(asked, "--gravity-magnitude 3m/s^2")["gravity"] == [3.0, 0.0, 0.0]


# What is asked, and what both commands say: a regime, or why not.
QUESTIONS = {
    "prototype_p1 --radius 16.5mm --gravity-direction -0.719 0.678 0.152 --object-axis 1 0 0": (
        "mm from the surface"
    ),
    "prototype_p1 --radius 16.5mm --pressure 50kPa": "perfect_wrap",
    "prototype_p1 --radius 20mm": "never with more than a tenth",
    "prototype_p1 --radius 90mm": "too thick",
    "paper_design_70 --radius 20mm --pressure 50kPa": "overhang",
    "paper_design_70 --radius 20mm --pressure 70kPa": "curling",
    "paper_design_70 --radius 20mm --pressure 95kPa": "95kPa is too much",
    "paper_design_70 --radius 37.3mm --pressure 37kPa": "perfect_wrap",
}


def random_question(seed):
    rng = np.random.default_rng(seed)
    asked = [str(rng.choice(available_grippers())), f"--radius {rng.uniform(8.0, 30.0):.3f}mm"]
    for option in ("--gravity-direction", "--object-axis")[: rng.integers(1, 3)]:
        asked += [option, *(f"{each:.4f}" for each in rng.normal(size=3))]
    return pytest.param(" ".join(asked), marks=pytest.mark.slow)


# The first and the third compute for long.
SLOW = [pytest.param(asked, marks=pytest.mark.slow) for asked in [*QUESTIONS][:3:2]]


@pytest.mark.parametrize(
    "asked", [*SLOW, *[*QUESTIONS][1:2], *[*QUESTIONS][3:], *map(random_question, range(3))]
)
def test_wrap_says_what_grip_finds(asked, capsys, monkeypatch):
    monkeypatch.setattr(grip, "FORCE_PRESSURES", 3)  # forces are not compared
    answers = []
    for command in ("wrap", "grip"):
        code = run([command, *asked.split(), "--json"])
        printed = capsys.readouterr()
        answers.append(printed.err if code else json.loads(printed.out))
    (wrapped, held), expected = answers, QUESTIONS.get(asked)
    if isinstance(wrapped, str):
        assert wrapped == held
        assert expected is None or expected in wrapped
        return
    assert wrapped["gripped"]
    assert expected is None or wrapped["regime"] == expected
    assert wrapped["pressure"] == wrapped["onset_wrap"]
    assert wrapped["at_pressure"] == held["at_pressure"]["pressure"]
    shared = wrapped.keys() & held.keys() - {"at_pressure", "turns"}
    assert len(shared) > 10
    assert {key: wrapped[key] for key in shared} == {key: held[key] for key in shared}


def test_a_pdf_has_letters_and_any_name_is_printed_as_it_is(mine, said):
    name = "grip [/x] [red] $frac{$"
    mine.write_text(mine.read_text("utf-8").replace("name: paper_design_70", f'name: "{name}"'))
    assert said("winding-sheet mine.yaml").startswith(name)
    said("chart gravity mine.yaml --plot=plot.pdf")
    content = Path("plot.pdf").read_bytes()
    assert content.startswith(b"%PDF")
    assert b"/Type3" not in content
    assert b"/TrueType" in content or b"/CIDFontType2" in content


def test_a_shipped_file_is_shown(said):
    source = load_description("prototype_p1").source
    assert said("grippers show prototype_p1") == " ".join(source.read_text("utf-8").split())


def test_a_check_says_which_radii_contact_holds(recorded, monkeypatch):
    for asked in cases("grippers.txt"):
        ranges = ((0.005, 0.01), (0.02, 0.03)) if "p1" in asked else ()
        monkeypatch.setattr(places, "held_radii", lambda *_, ranges=ranges: ranges)
        recorded("grippers.txt", asked)
