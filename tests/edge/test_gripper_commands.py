# SPDX-License-Identifier: Apache-2.0
"""The commands ``shape``, ``wrap``, ``chart`` and ``grippers``: answers, profiles, pictures."""

import json
import re

import numpy as np
import pytest

from spiral_core import WrapCurve
from spiral_core.design import charts
from spiral_core.grip import places
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
    assert shape["positions"][0] == [0.0, 0.0, 0.0]
    assert len(shape["positions"]) == len(shape["orientations"]) == len(shape["arc_lengths"])
    assert shape["pressure"] == pytest.approx(55158.058, rel=1e-7)  # eight digits as written


def test_mount_options_turn_gravity(answer):
    asked = ["shape", "prototype_p1", "--pressure", "0 kPa"]
    assert answer(*asked)["positions"][-1] == pytest.approx([0.5, 0.0, 0.0], abs=1e-9)
    sideways = answer(*asked, "--gravity-direction", "0", "0", "-2")
    assert sideways["gravity"] == [0.0, 0.0, -9.80665]
    assert sideways["positions"][-1][2] < -0.4
    free = answer(*asked, "--gravity-direction", "0", "0", "-1", "--gravity-magnitude", "0 m/s^2")
    assert free["positions"][-1] == pytest.approx([0.5, 0.0, 0.0], abs=1e-9)


ALONG_THE_TUBE = "--gravity-direction -0.719 0.678 0.152 --object-axis 1 0 0"
TILTED = "--gravity-direction 0.866 0.5 0 --object-axis 0.866 0.5 0"
# Gripper, radius [mm], options, and what both commands say: a regime, or why not.
QUESTIONS = [
    ("prototype_p1", "16.5", ALONG_THE_TUBE, "mm from the surface"),
    ("prototype_p1", "16.5", "--pressure 50kPa", "perfect_wrap"),
    ("prototype_p1", "20", "", "never with more than a tenth"),
    ("prototype_p1", "90", "", "too thick"),
    ("paper_design_70", "20", "--pressure 50kPa", "overhang"),
    ("paper_design_70", "20", "--pressure 70kPa", "curling"),
    ("paper_design_70", "20", "--pressure 95kPa", "95kPa is too much"),
    ("designed", "8", "--pressure 213.9kPa", "curling"),
    ("designed", "8", f"--pressure 175kPa {TILTED}", "does not touch up to the pressure limit"),
]


@pytest.fixture(scope="module")
def designed(tmp_path_factory):
    """Return the file of a gripper of silicone for radii from 6 to 12.5 mm."""
    folder = tmp_path_factory.mktemp("designed")
    tubing, saved = folder / "tubing.yaml", folder / "designed.yaml"
    material = "{law: neo_hookean, c1: 150 kPa, density: 1.1 g/cm^3}"
    tubing.write_text(f"name: x\nmaterial: {material}\nsizes: [8 mm x 1 mm]\n", encoding="utf-8")
    radii = ("--radius-min", "6 mm", "--radius-max", "12.5 mm")
    assert run(["design", "--tubing", str(tubing), *radii, "--save", str(saved)]) == 0
    return saved


@pytest.fixture
def agreed(capsys):
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


@pytest.mark.parametrize(("gripper", "radius", "options", "said"), QUESTIONS)
def test_wrap_says_what_grip_finds(agreed, designed, gripper, radius, options, said):
    file = str(designed) if gripper == "designed" else gripper
    wrapped = agreed([file, "--radius", f"{radius} mm", *options.split()])
    if isinstance(wrapped, str):
        assert said in wrapped
    else:
        assert wrapped["regime"] == said
        assert wrapped["gripped"] is True
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
    wrapped = answer("wrap", "prototype_p1", "--radius", "12.5 mm")
    # A process that compiles kernels rounds otherwise than one that loads them.
    for end in ("onset_wrap", "onset_curling"):
        assert drawn[end][1] == pytest.approx(wrapped[end], rel=1e-9)
    assert drawn["onset_wrap"][0] is None
    picture = path.read_text(encoding="utf-8")
    for label in ("prototype_p1", "perfect wrap,", "curling", "not held", "pressure limit,"):
        assert f">{label}<" in picture


@pytest.mark.parametrize(
    ("arguments", "title"),
    [
        ("shape prototype_p1 --pressure 8psi", "prototype_p1 at 8psi"),
        ("wrap prototype_p1 --radius 9mm", r"prototype_p1 around 9mm, at \d\d\.\d+ kPa"),
        ("chart gravity prototype_p1", "prototype_p1"),
        ("chart design-space prototype_p1", "tube of prototype_p1, helix model"),
    ],
)
def test_pictures_in_every_format_have_a_title_and_letters(arguments, title, tmp_path):
    drawn = tmp_path / "plot.svg"
    assert run([*arguments.split(), "--plot", str(drawn)]) == 0
    assert re.search(rf"<text[^>]*>{title}</text>", drawn.read_text(encoding="utf-8"))
    printed = tmp_path / "plot.pdf"
    assert run([*arguments.split(), "--plot", str(printed)]) == 0
    assert printed.read_bytes().startswith(b"%PDF")
    assert b"/Type3" not in printed.read_bytes()
    assert b"/TrueType" in printed.read_bytes() or b"/CIDFontType2" in printed.read_bytes()


def test_grippers_are_listed_shown_and_checked(answer, said, capsys, tmp_path):
    listed = said("grippers", "list")
    assert "prototype_p1 Prototype P1 of" in listed
    assert [one["name"] for one in answer("grippers", "list")] == [*available_grippers()]
    assert run(["grippers", "show", "prototype_p1"]) == 0
    path = tmp_path / "mine.yaml"
    text = capsys.readouterr().out
    path.write_text(text, encoding="utf-8")
    assert load_description(path).gripper == load_description("prototype_p1").gripper
    shown = answer("grippers", "show", str(path))
    assert shown["tube"]["length"] == 0.5
    assert shown["pressure_max"] == pytest.approx(110316.117)
    # A name is printed as it is.
    name = "grip [/x] [red] $frac{$"
    path.write_text(re.sub("^name:.*", f'name: "{name}"', text, flags=re.MULTILINE))
    assert said("winding-sheet", str(path)).startswith(name)
    for command in (["shape", str(path), "--pressure=8 psi"], ["chart", "gravity", str(path)]):
        assert run([*command, f"--plot={tmp_path}/picture.png"]) == 0


def test_a_check_says_which_radii_contact_holds(answer, said, tmp_path, monkeypatch):
    path = tmp_path / "mine.yaml"
    written = load_description("paper_design_70").source.read_text(encoding="utf-8")
    path.write_text(written.replace("pressure_max: 16 psi", "pressure_max: 38.5 kPa"))
    found = answer("grippers", "check", str(path))
    curve = WrapCurve(load_gripper(path))
    low, high = found["radius_range"]
    assert low == found["radius_ranges"][0][0] == curve.radius_min
    assert 0.99 * curve.radius_max < high == found["radius_ranges"][-1][1] <= curve.radius_max
    assert found["friction"] == 0.3
    for ranges, code, text in (
        (((0.005, 0.01), (0.02, 0.03)), 0, "grips radii from 5 mm to 10 mm, from 20 mm to 30 mm"),
        ((), 1, "grips no radius where its free coil lies"),
    ):
        monkeypatch.setattr(places, "held_radii", lambda *_, ranges=ranges: ranges)
        expected = f"paper_design_70: valid; {text}, up to 38.5 kPa, friction 0.3"
        assert said("grippers", "check", str(path), code=code) == expected
