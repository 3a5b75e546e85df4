# SPDX-License-Identifier: Apache-2.0
"""The commands ``shape``, ``wrap``, ``chart`` and ``grippers``: answers, profiles, pictures."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from spiral_core import WrapCurve
from spiral_core.design import charts
from spiral_core.grip import grip, places
from spiral_gripper import available_grippers, load_description, load_gripper
from spiral_gripper.cli.main import run

pytestmark = pytest.mark.long


def test_shape_and_wrap_agree_with_python(answer):
    curve = WrapCurve(load_gripper("prototype_p1"))
    wrapped = answer("wrap prototype_p1 --radius 20mm --pressure 60kPa --tip-criterion")
    assert wrapped["pressure"] == curve.pressure_from_radius(0.02)
    assert (wrapped["regime"], wrapped["line_force"] > 0.0) == ("curling", True)
    shape = answer("shape prototype_p1 --pressure 8psi")
    assert len(shape["positions"]) == len(shape["orientations"]) == len(shape["arc_lengths"])
    assert shape["pressure"] == pytest.approx(55158.058, rel=1e-7)  # eight digits as written


def test_mount_options_turn_gravity(answer):
    asked = "shape prototype_p1 --pressure 0kPa --gravity-direction 0 0 -2"
    sideways = answer(asked)
    assert sideways["gravity"] == [0.0, 0.0, -9.80665]
    assert sideways["positions"][-1][2] < -0.4
    free = answer(asked, "--gravity-magnitude 0m/s^2")
    assert free["positions"][-1] == pytest.approx([0.5, 0.0, 0.0], abs=1e-9)


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


@pytest.mark.parametrize("asked", [*QUESTIONS, *map(random_question, range(3))])
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


def test_profile_from_csv(answer, said):
    Path("cone.csv").write_text("position [cm], radius [mm]\n0, 30\n30, 11\n", "utf-8")
    asked = "wrap paper_design_70 --profile cone.csv"
    wrapped = answer(asked)
    assert 0.011 <= wrapped["radius_min"] < wrapped["radius_max"] <= 0.030
    assert wrapped["pressure"] == wrapped["onset_wrap"] != wrapped["tip_criterion"]
    assert "perfect wrap" in said(asked, "--tip-criterion")


def test_charts_as_data(answer, monkeypatch):
    gravity = answer("chart gravity prototype_p1")
    assert gravity["with_gravity"]["radius"][0] > gravity["without_gravity"]["radius"][0]
    # The chart of the pressure has the regimes of contact and the limit.
    monkeypatch.setattr(charts, "CONTACT_POINTS", 3)
    drawn = answer("chart pressure prototype_p1 --radius-max 20mm --plot pressure.svg")
    assert drawn["radius"] == pytest.approx([0.02, 0.0125, 0.005])
    wrapped = answer("wrap prototype_p1 --radius 12.5mm")
    # A process that compiles kernels rounds otherwise than one that loads them.
    for end in ("onset_wrap", "onset_curling"):
        assert drawn[end][1] == pytest.approx(wrapped[end], rel=1e-9)
    picture = Path("pressure.svg").read_text("utf-8")
    for label in ("prototype_p1", "perfect wrap,", "curling", "not held", "pressure limit,"):
        assert f">{label}<" in picture


@pytest.mark.parametrize(
    ("arguments", "title"),
    [
        ("shape prototype_p1 --pressure 8psi", "prototype_p1 at 8psi"),
        (
            "wrap prototype_p1 --radius 9mm --tip-criterion",
            r"prototype_p1 around 9mm, at \d\d\.\d+ kPa",
        ),
        ("chart gravity prototype_p1", "prototype_p1"),
        ("chart section prototype_p1 --pressure 5kPa --pressure 6psi", "5 kPa"),
        ("chart design-space prototype_p1", "tube of prototype_p1, helix model"),
    ],
)
def test_a_picture_has_a_title(arguments, title, said):
    said(arguments, "--plot plot.svg")
    assert re.search(rf"<text[^>]*>{title}</text>", Path("plot.svg").read_text("utf-8"))


def test_a_pdf_has_letters_and_any_name_is_printed_as_it_is(mine, said):
    name = "grip [/x] [red] $frac{$"
    mine.write_text(mine.read_text("utf-8").replace("name: paper_design_70", f'name: "{name}"'))
    assert said("winding-sheet mine.yaml").startswith(name)
    said("chart gravity mine.yaml --plot=plot.pdf")
    content = Path("plot.pdf").read_bytes()
    assert content.startswith(b"%PDF")
    assert b"/Type3" not in content
    assert b"/TrueType" in content or b"/CIDFontType2" in content


def test_grippers_are_listed_and_shown(answer, said):
    assert "prototype_p1 Prototype P1 of" in said("grippers list")
    assert [one["name"] for one in answer("grippers list")] == [*available_grippers()]
    source = load_description("prototype_p1").source
    assert said("grippers show prototype_p1") == " ".join(source.read_text("utf-8").split())
    shown = answer("grippers show", str(source))
    assert (shown["tube"]["length"], round(shown["pressure_max"])) == (0.5, 110316)


def test_a_check_says_which_radii_contact_holds(answer, said, monkeypatch):
    two = "grips radii from 5 mm to 10 mm, from 20 mm to 30 mm"
    none = "grips no radius where its free coil lies"
    asked = "grippers check paper_design_70"
    for ranges, code, text, reach in (
        (((0.005, 0.01), (0.02, 0.03)), 0, two, [0.005, 0.03]),
        ((), 1, none, None),
    ):
        monkeypatch.setattr(places, "held_radii", lambda *_, ranges=ranges: ranges)
        expected = f"paper_design_70: valid; {text}, up to 16 psi, friction 0.3"
        assert said(asked, code=code) == expected
        assert answer(asked, code=code)["radius_range"] == reach
