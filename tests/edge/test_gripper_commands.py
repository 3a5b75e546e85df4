# SPDX-License-Identifier: Apache-2.0
"""The commands ``shape``, ``wrap``, ``chart`` and ``grippers``: answers, profiles, pictures."""

import json
import re

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
    asked = ["wrap", "prototype_p1", "--radius", "20 mm", "--pressure", "60 kPa"]
    wrapped = answer(*asked, "--tip-criterion")
    assert wrapped["pressure"] == curve.pressure_from_radius(0.02)
    assert wrapped["regime"] == "curling"
    assert wrapped["line_force"] > 0.0
    shape = answer("shape", "prototype_p1", "--pressure", "8 psi")
    assert shape["stable"] is True
    assert len(shape["positions"]) == len(shape["orientations"]) == len(shape["arc_lengths"])
    assert shape["pressure"] == pytest.approx(55158.058, rel=1e-7)  # eight digits as written


def test_mount_options_turn_gravity(answer):
    asked = ["shape", "prototype_p1", "--pressure", "0 kPa", "--gravity-direction", "0", "0", "-2"]
    assert answer(*asked[:4])["positions"][-1] == pytest.approx([0.5, 0.0, 0.0], abs=1e-9)
    sideways = answer(*asked)
    assert sideways["gravity"] == [0.0, 0.0, -9.80665]
    assert sideways["positions"][-1][2] < -0.4
    free = answer(*asked, "--gravity-magnitude", "0 m/s^2")
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
}


@pytest.fixture
def agreed(capsys, monkeypatch):
    monkeypatch.setattr(grip, "FORCE_PRESSURES", 3)  # forces are not compared

    def agreed(asked):
        """Return what ``wrap`` answers, or its refusal, which are those of ``grip``."""
        capsys.readouterr()
        answers = []
        for command in ("wrap", "grip"):
            code = run([command, *asked, "--json"])
            printed = capsys.readouterr()
            answers.append(printed.err if code else json.loads(printed.out))
        wrapped, held = answers
        if isinstance(wrapped, str):
            assert wrapped == held
            return wrapped
        shared = wrapped.keys() & held.keys() - {"at_pressure", "turns"}
        assert len(shared) > 10
        assert {key: wrapped[key] for key in shared} == {key: held[key] for key in shared}
        assert wrapped["at_pressure"] == held["at_pressure"]["pressure"]
        return wrapped

    return agreed


@pytest.mark.parametrize("asked", QUESTIONS)
def test_wrap_says_what_grip_finds(agreed, asked):
    wrapped, said = agreed(asked.split()), QUESTIONS[asked]
    if isinstance(wrapped, str):
        assert said in wrapped
    else:
        assert (wrapped["regime"], wrapped["gripped"]) == (said, True)
        assert wrapped["pressure"] == wrapped["onset_wrap"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_wrap_and_grip_agree_on_random_questions(agreed, seed):
    rng = np.random.default_rng(seed)
    asked = [str(rng.choice(available_grippers())), "--radius", f"{rng.uniform(8.0, 30.0):.3f} mm"]
    for option in ("--gravity-direction", "--object-axis")[: rng.integers(1, 3)]:
        asked += [option, *(f"{each:.4f}" for each in rng.normal(size=3))]
    agreed(asked)


def test_profile_from_csv(answer, said, tmp_path):
    path = tmp_path / "cone.csv"
    path.write_text("position [cm], radius [mm]\n0, 30\n30, 11\n", encoding="utf-8")
    asked = ["wrap", "paper_design_70", "--profile", str(path)]
    wrapped = answer(*asked)
    assert 0.011 <= wrapped["radius_min"] < wrapped["radius_max"] <= 0.030
    assert wrapped["stations"][-1]["regime"] == "perfect_wrap"
    assert wrapped["pressure"] == wrapped["onset_wrap"] != wrapped["tip_criterion"]
    assert "perfect wrap" in said(*asked, "--tip-criterion")


def test_charts_as_data(answer, tmp_path, monkeypatch):
    (curve,) = answer("chart", "design-space", "prototype_p1", "--beta", "50 deg")
    assert len(curve["stretch"]) == len(curve["length_ratio"])
    gravity = answer("chart", "gravity", "prototype_p1")
    assert gravity["with_gravity"]["radius"][0] > gravity["without_gravity"]["radius"][0]
    # The chart of the pressure has the regimes of contact and the limit.
    monkeypatch.setattr(charts, "CONTACT_POINTS", 3)
    path = tmp_path / "pressure.svg"
    asked = ["chart", "pressure", "prototype_p1", "--radius-max", "20 mm", "--plot", str(path)]
    drawn = answer(*asked)
    assert drawn["radius"] == pytest.approx([0.02, 0.0125, 0.005])
    assert drawn["pressure_max"] == load_gripper("prototype_p1").pressure_max
    assert drawn["onset_wrap"][0] is None
    wrapped = answer("wrap", "prototype_p1", "--radius", "12.5 mm")
    # A process that compiles kernels rounds otherwise than one that loads them.
    for end in ("onset_wrap", "onset_curling"):
        assert drawn[end][1] == pytest.approx(wrapped[end], rel=1e-9)
    picture = path.read_text(encoding="utf-8")
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
        ("chart design-space prototype_p1", "tube of prototype_p1, helix model"),
    ],
)
def test_a_picture_has_a_title(arguments, title, tmp_path, said):
    drawn = tmp_path / "plot.svg"
    said(*arguments.split(), "--plot", str(drawn))
    assert re.search(rf"<text[^>]*>{title}</text>", drawn.read_text(encoding="utf-8"))


def test_a_pdf_has_letters_and_any_name_is_printed_as_it_is(tmp_path, said):
    path, printed = tmp_path / "mine.yaml", tmp_path / "plot.pdf"
    name, text = "grip [/x] [red] $frac{$", load_description("prototype_p1").source.read_text()
    path.write_text(re.sub("^name:.*", f'name: "{name}"', text, flags=re.MULTILINE))
    assert said("winding-sheet", str(path)).startswith(name)
    for command in (["shape", str(path), "--pressure=8 psi"], ["chart", "gravity", str(path)]):
        said(*command, f"--plot={printed}")
        content = printed.read_bytes()
        assert content.startswith(b"%PDF")
        assert b"/Type3" not in content
        assert b"/TrueType" in content or b"/CIDFontType2" in content


def test_grippers_are_listed_and_shown(answer, said):
    assert "prototype_p1 Prototype P1 of" in said("grippers", "list")
    assert [one["name"] for one in answer("grippers", "list")] == [*available_grippers()]
    source = load_description("prototype_p1").source
    assert said("grippers", "show", "prototype_p1") == " ".join(source.read_text("utf-8").split())
    shown = answer("grippers", "show", str(source))
    assert shown["tube"]["length"] == 0.5
    assert shown["pressure_max"] == pytest.approx(110316.117)
    assert shown["stiffness"]["sideways"] == shown["stiffness"]["bending"]


def test_a_check_says_which_radii_contact_holds(answer, said, tmp_path, monkeypatch):
    monkeypatch.setattr(places, "RADII_TRIED", 4)
    path = tmp_path / "mine.yaml"
    written = load_description("paper_design_70").source.read_text(encoding="utf-8")
    path.write_text(written.replace("pressure_max: 16 psi", "pressure_max: 38.5 kPa"))
    found = answer("grippers", "check", str(path))
    curve = WrapCurve(load_gripper(path))
    low, high = found["radius_range"]
    assert low == found["radius_ranges"][0][0] == curve.radius_min
    assert 0.99 * curve.radius_max < high == found["radius_ranges"][-1][1] <= curve.radius_max
    assert found["friction"] == 0.3
    two = "grips radii from 5 mm to 10 mm, from 20 mm to 30 mm"
    none = "grips no radius where its free coil lies"
    for ranges, code, text in (((0.005, 0.01), (0.02, 0.03)), 0, two), ((), 1, none):
        monkeypatch.setattr(places, "held_radii", lambda *_, ranges=ranges: ranges)
        expected = f"paper_design_70: valid; {text}, up to 38.5 kPa, friction 0.3"
        assert said("grippers", "check", str(path), code=code) == expected
