# SPDX-License-Identifier: Apache-2.0
"""The commands ``shape``, ``wrap``, ``chart`` and ``grippers``: answers, profiles, pictures."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from edge.cli_cases import answer

from spiral_core import (
    WrapCurve,
)
from spiral_core.design import charts
from spiral_core.grip import places
from spiral_gripper import (
    available_grippers,
    load_description,
    load_gripper,
)
from spiral_gripper.cli.main import run

pytestmark = pytest.mark.long


def test_shape_and_wrap_agree_with_python(capsys: pytest.CaptureFixture[str]) -> None:
    curve = WrapCurve(load_gripper("prototype_p1"))
    asked = ["wrap", "prototype_p1", "--radius", "20 mm", "--pressure", "60 kPa"]
    wrapped = answer(capsys, *asked, "--tip-criterion")
    assert wrapped["pressure"] == curve.pressure_from_radius(0.02)
    assert wrapped["regime"] == "curling"
    assert wrapped["line_force"] > 0.0
    shape = answer(capsys, "shape", "prototype_p1", "--pressure", "8 psi")
    assert shape["stable"] is True
    assert shape["positions"][0] == [0.0, 0.0, 0.0]
    assert len(shape["positions"]) == len(shape["orientations"]) == len(shape["arc_lengths"])
    assert shape["pressure"] == pytest.approx(55158.058, rel=1e-7)  # eight digits as written


ALONG_THE_TUBE = ("--gravity-direction", "-0.719", "0.678", "0.152", "--object-axis", "1", "0", "0")
TILTED = ("--gravity-direction", "0.866", "0.5", "0", "--object-axis", "0.866", "0.5", "0")
# Gripper, radius, pressure and mount, and what both commands say: a regime, or why not.
QUESTIONS = [
    ("prototype_p1", "16.5 mm", None, ALONG_THE_TUBE, "mm from the surface"),
    ("prototype_p1", "16.5 mm", "50 kPa", (), "perfect_wrap"),
    ("prototype_p1", "20 mm", None, (), "never with more than a tenth"),
    ("prototype_p1", "90 mm", None, (), "too thick"),
    ("paper_design_70", "20 mm", "59.1 kPa", (), "perfect_wrap"),
    ("paper_design_70", "20 mm", "50 kPa", (), "overhang"),
    ("paper_design_70", "20 mm", "70 kPa", (), "curling"),
    ("paper_design_70", "20 mm", "95 kPa", (), "95 kPa is too much"),
    ("designed", "8 mm", "175 kPa", (), "perfect_wrap"),
    ("designed", "8 mm", "213.9 kPa", (), "curling"),
    ("designed", "8 mm", "175 kPa", TILTED, "does not touch up to the pressure limit"),
]


@pytest.fixture(scope="module")
def designed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of a gripper of silicone for radii from 6 to 12.5 mm."""
    folder = tmp_path_factory.mktemp("designed")
    tubing, saved = folder / "tubing.yaml", folder / "designed.yaml"
    material = "{law: neo_hookean, c1: 150 kPa, density: 1.1 g/cm^3}"
    tubing.write_text(f"name: x\nmaterial: {material}\nsizes: [8 mm x 1 mm]\n", encoding="utf-8")
    radii = ("--radius-min", "6 mm", "--radius-max", "12.5 mm")
    assert run(["design", "--tubing", str(tubing), *radii, "--save", str(saved)]) == 0
    return saved


def test_a_name_is_printed_as_it_is(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert run(["grippers", "show", "prototype_p1"]) == 0
    named = tmp_path / "named.yaml"
    text = re.sub("^name:.*", 'name: "grip [/x] [red]"', capsys.readouterr().out, flags=re.M)
    named.write_text(text, encoding="utf-8")
    assert run(["winding-sheet", str(named)]) == 0
    assert capsys.readouterr().out.startswith("grip [/x] [red]")


@pytest.mark.parametrize(("gripper", "radius", "pressure", "mount", "said"), QUESTIONS)
def test_wrap_says_what_grip_finds(
    capsys: pytest.CaptureFixture[str],
    designed: Path,
    gripper: str,
    radius: str,
    pressure: str | None,
    mount: tuple[str, ...],
    said: str,
) -> None:
    capsys.readouterr()
    asked = [str(designed) if gripper == "designed" else gripper, "--radius", radius, *mount]
    wrapped = agreed(capsys, [*asked, *(("--pressure", pressure) if pressure else ())])
    if isinstance(wrapped, dict):
        assert wrapped["regime"] == said
        assert wrapped["gripped"] is True
        assert wrapped["pressure"] == wrapped["onset_wrap"]
    else:
        assert said in wrapped


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_wrap_and_grip_agree_on_random_questions(
    capsys: pytest.CaptureFixture[str], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    gripper = str(rng.choice(available_grippers()))
    mount = ["--gravity-direction", *(f"{each:.4f}" for each in rng.normal(size=3))]
    if rng.random() < 0.5:
        mount += ["--object-axis", *(f"{each:.4f}" for each in rng.normal(size=3))]
    agreed(capsys, [gripper, "--radius", f"{rng.uniform(8.0, 30.0):.3f} mm", *mount])


def agreed(capsys: pytest.CaptureFixture[str], asked: list[str]) -> dict | str:
    """Return what ``wrap`` answers, or its refusal, which are those of ``grip``."""
    answers = []
    for command in ("wrap", "grip"):
        code = run([command, *asked, "--json"])
        printed = capsys.readouterr()
        answers.append(printed.err if code else json.loads(printed.out))
    wrapped, held = answers
    if isinstance(wrapped, dict):
        shared = wrapped.keys() & held.keys() - {"at_pressure", "turns"}
        assert len(shared) > 10
        assert {key: wrapped[key] for key in shared} == {key: held[key] for key in shared}
        assert wrapped["at_pressure"] == held["at_pressure"]["pressure"]
    else:
        assert wrapped == held
    return wrapped


def test_mount_options_turn_gravity(capsys: pytest.CaptureFixture[str]) -> None:
    hanging = answer(capsys, "shape", "prototype_p1", "--pressure", "0 kPa")
    assert hanging["positions"][-1] == pytest.approx([0.5, 0.0, 0.0], abs=1e-9)
    sideways = answer(
        capsys,
        "shape",
        "prototype_p1",
        "--pressure",
        "0 kPa",
        "--gravity-direction",
        "0",
        "0",
        "-2",
    )
    assert sideways["gravity"] == [0.0, 0.0, -9.80665]
    assert sideways["positions"][-1][2] < -0.4
    free = answer(
        capsys, "shape", "prototype_p1", "--pressure", "0 kPa",
        "--gravity-direction", "0", "0", "-1", "--gravity-magnitude", "0 m/s^2",
    )  # fmt: skip
    assert free["positions"][-1] == pytest.approx([0.5, 0.0, 0.0], abs=1e-9)


def test_profile_from_csv(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "cone.csv"
    path.write_text("position [cm], radius [mm]\n0, 30\n30, 11\n", encoding="utf-8")
    wrapped = answer(capsys, "wrap", "paper_design_70", "--profile", str(path))
    assert 0.011 <= wrapped["radius_min"] < wrapped["radius_max"] <= 0.030
    assert wrapped["stations"][-1]["regime"] == "perfect_wrap"
    assert wrapped["pressure"] == wrapped["onset_wrap"] != wrapped["tip_criterion"]
    asked = ["wrap", "paper_design_70", "--profile", str(path)]
    assert run([*asked, "--tip-criterion"]) == 0
    assert "perfect wrap" in capsys.readouterr().out


def test_charts_as_data(capsys: pytest.CaptureFixture[str]) -> None:
    curves = answer(capsys, "chart", "design-space", "prototype_p1", "--beta", "50 deg")
    assert len(curves) == 1
    assert len(curves[0]["stretch"]) == len(curves[0]["length_ratio"])
    gravity = answer(capsys, "chart", "gravity", "prototype_p1")
    assert gravity["with_gravity"]["radius"][0] > gravity["without_gravity"]["radius"][0]


def test_a_chart_of_the_pressure_has_the_regimes_of_contact_and_the_limit(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(charts, "CONTACT_POINTS", 3)
    path = tmp_path / "pressure.svg"
    asked = ["chart", "pressure", "prototype_p1", "--radius-max", "20 mm", "--plot", str(path)]
    said = answer(capsys, *asked)
    assert said["radius"] == pytest.approx([0.02, 0.0125, 0.005])
    assert said["pressure_max"] == load_gripper("prototype_p1").pressure_max
    wrapped = answer(capsys, "wrap", "prototype_p1", "--radius", "12.5 mm")
    # A process that compiles kernels rounds otherwise than one that loads them.
    for end in ("onset_wrap", "onset_curling"):
        assert said[end][1] == pytest.approx(wrapped[end], rel=1e-9)
    assert said["onset_wrap"][0] is None
    drawn = path.read_text(encoding="utf-8")
    for label in ("prototype_p1", "perfect wrap,", "curling", "not held", "pressure limit,"):
        assert f">{label}<" in drawn


@pytest.mark.parametrize(
    ("suffix", "start"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")]
)
def test_plots_in_every_format(suffix: str, start: bytes, tmp_path: Path) -> None:
    path = tmp_path / f"plot{suffix}"
    assert run(["chart", "design-space", "paper_design_70", "--plot", str(path)]) == 0
    assert path.read_bytes().startswith(start)


@pytest.mark.parametrize(
    ("arguments", "title"),
    [
        (["shape", "prototype_p1", "--pressure", "8 psi"], "prototype_p1 at 8 psi"),
        (
            ["wrap", "prototype_p1", "--radius", "9 mm"],
            r"prototype_p1 around 9 mm, at \d\d\.\d+ kPa",
        ),
        (["chart", "gravity", "prototype_p1"], "prototype_p1"),
        (["chart", "design-space", "prototype_p1"], "tube of prototype_p1, helix model"),
    ],
)
def test_pictures_have_a_title_and_letters(
    arguments: list[str], title: str, tmp_path: Path
) -> None:
    drawn = tmp_path / "plot.svg"
    assert run([*arguments, "--plot", str(drawn)]) == 0
    assert re.search(rf"<text[^>]*>{title}</text>", drawn.read_text(encoding="utf-8"))
    printed = tmp_path / "plot.pdf"
    assert run([*arguments, "--plot", str(printed)]) == 0
    assert b"/Type3" not in printed.read_bytes()
    assert b"/TrueType" in printed.read_bytes() or b"/CIDFontType2" in printed.read_bytes()


def test_grippers_are_listed_shown_and_checked(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert run(["grippers", "list"]) == 0
    assert capsys.readouterr().out.splitlines()[1].startswith("prototype_p1  Prototype P1 of")
    assert [one["name"] for one in answer(capsys, "grippers", "list")] == [*available_grippers()]
    assert run(["grippers", "show", "prototype_p1"]) == 0
    path = tmp_path / "mine.yaml"
    path.write_text(capsys.readouterr().out, encoding="utf-8")
    assert load_description(path).gripper == load_description("prototype_p1").gripper
    shown = answer(capsys, "grippers", "show", str(path))
    assert shown["tube"]["length"] == 0.5
    assert shown["pressure_max"] == pytest.approx(110316.117)


def test_a_check_says_which_radii_contact_holds(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "mine.yaml"
    written = load_description("paper_design_70").source.read_text(encoding="utf-8")
    path.write_text(written.replace("pressure_max: 16 psi", "pressure_max: 38.5 kPa"))
    found = answer(capsys, "grippers", "check", str(path))
    curve = WrapCurve(load_gripper(path))
    low, high = found["radius_range"]
    assert low == found["radius_ranges"][0][0] == curve.radius_min
    assert 0.99 * curve.radius_max < high == found["radius_ranges"][-1][1] <= curve.radius_max
    assert found["friction"] == 0.3
    for ranges, code, said in [
        (((0.005, 0.01), (0.02, 0.03)), 0, "grips radii from 5 mm to 10 mm, from 20 mm to 30 mm"),
        ((), 1, "grips no radius where its free coil lies"),
    ]:
        monkeypatch.setattr(places, "held_radii", lambda *_, ranges=ranges: ranges)
        assert run(["grippers", "check", str(path)]) == code
        assert capsys.readouterr().out == (
            f"paper_design_70: valid; {said}, up to 38.5 kPa, friction 0.3\n"
        )
