# SPDX-License-Identifier: Apache-2.0
"""The command line: answers, JSON, files, and one clear line for whatever is wrong."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

from spiral_core import InvalidInputError, NoCoilError, NotGrippableError, SpiralError
from spiral_gripper import available_grippers, convert_from_si, load_description
from spiral_gripper.cli import main as main_module
from spiral_gripper.cli import types
from spiral_gripper.cli.main import COMMANDS, run
from spiral_gripper.cli.sentences import TypedValue, sentence
from spiral_gripper.files.units import Dimension

EXAMPLE = [
    "design", "--radius-min", "11 mm", "--radius-max", "30 mm", "--tube", "3/8 in x 1/32 in",
    "--turns", "1.5", "--object-length", "250 mm", "--pressure-max", "16 psi",
    "--strain-max", "0.3",
]  # fmt: skip

WRAP = ["wrap", "prototype_p1", "--radius", "9 mm"]


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict:
    """Return the JSON that a command prints."""
    assert run([*arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def error_of(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Return the one line that a command complains with."""
    assert run(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.endswith("\n")
    assert captured.err.count("\n") == 1
    assert captured.err.startswith("spiral-gripper: ")
    return captured.err


def test_help_loads_nothing_heavy() -> None:
    for arguments in (["--help"], *([name, "--help"] for name in COMMANDS)):
        code = (
            "import sys; from spiral_gripper.cli.main import run; run(sys.argv[1:]); "
            "print(*{name.split('.')[0] for name in sys.modules}, file=sys.stderr)"
        )
        done = subprocess.run(
            [sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True
        )
        assert "Usage: spiral-gripper" in done.stdout
        loaded = set(done.stderr.split())
        assert not loaded & {"numpy", "scipy", "numba", "matplotlib", "rich", "pint", "spiral_core"}


def test_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--help"]) == 0
    text = capsys.readouterr().out
    assert all(f"  {name} " in text and entry.help in text for name, entry in COMMANDS.items())


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out.startswith("spiral-gripper 0.")


def test_design_prints_the_steps_and_the_answer(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(EXAMPLE) == 0
    text = capsys.readouterr().out
    for expected in ("1 tube", "7 exact design space", "70 deg", "364 mm", "feasible"):
        assert expected in text


def test_design_in_json_is_the_call_in_python(capsys: pytest.CaptureFixture[str]) -> None:
    from spiral_core import DesignRequirement, design_gripper
    from spiral_gripper import load_tubing, parse_tube_size

    document = answer(capsys, *EXAMPLE)
    report = design_gripper(
        DesignRequirement(
            radius_min=0.011,
            radius_max=0.030,
            tubes=(parse_tube_size("3/8 in x 1/32 in"),),
            elastomers=(load_tubing("natural_latex").elastomer,),
            turns_required=1.5,
            object_length=0.25,
            pressure_max=16.0 / convert_from_si(1.0, "psi", Dimension.PRESSURE),
            strain_max=0.3,
        )
    )
    assert report.design is not None
    assert document["feasible"] is True
    assert document["design"]["length"] == report.design.length
    assert document["design"]["smallest"]["pressure"] == pytest.approx(
        report.design.smallest.pressure, rel=1e-12
    )
    assert [step["number"] for step in document["steps"]] == [1, 2, 3, 4, 5, 6, 7]
    assert document["design"]["windings"][1]["hand"] == "right"
    assert document["binding"]["constraint"] in {"strain", "object_length"}


def test_infeasible_design_exits_with_1_and_says_what_would_do(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run([*EXAMPLE, "--pressure-max", "50 kPa"]) == 1
    text = " ".join(capsys.readouterr().out.split())
    assert "not feasible: pressure limit" in text
    assert "sufficient change: pressure_max = 78.19 kPa instead of 50 kPa" in text


@pytest.mark.parametrize("suffix", [".md", ".html"])
def test_report_holds_steps_figures_and_picture(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"report{suffix}"
    assert run([*EXAMPLE, "--json", "--report", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    assert "Step 7" in text
    assert "364 mm" in text
    assert "data:image/png;base64,iVBOR" in text
    assert "src=" not in text.replace('src="data:', "")


@pytest.mark.parametrize(
    ("suffix", "start"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")]
)
def test_plots_in_every_format(suffix: str, start: bytes, tmp_path: Path) -> None:
    path = tmp_path / f"plot{suffix}"
    assert run(["chart", "design-space", "paper_design_70", "--plot", str(path)]) == 0
    assert path.read_bytes().startswith(start)


def test_saved_description_is_the_design(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "mine.yaml"
    document = answer(capsys, *EXAMPLE, "--save", str(path))
    description = load_description(path)
    assert description.gripper.name == "mine"
    # Twelve digits are written.
    design, written = document["design"], pytest.approx
    assert description.gripper.tube.length == written(design["length"], rel=1e-11)
    assert description.actuator.fibers.beta == written(design["fiber_angle_beta"], rel=1e-11)
    assert description.gripper.pressure_max == written(design["pressure_max"], rel=1e-11)
    assert description.gripper.turns_required == 1.5
    wrapped = answer(capsys, "wrap", str(path), "--radius", "11 mm")
    # The search sampled another pressure range: other elements, 1e-4 of the figures.
    assert wrapped["pressure"] == pytest.approx(
        document["design"]["smallest"]["pressure"], rel=1e-4
    )


def test_a_saved_description_has_the_friction_that_its_payload_was_judged_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("spiral_core.design.payload.carried_mass", lambda *_: 0.02)
    path = tmp_path / "mine.yaml"
    assert run([*EXAMPLE, "--payload", "10 g", "--friction", "0.5", "--save", str(path)]) == 0
    assert load_description(path).gripper.friction_coefficient == 0.5


@pytest.mark.parametrize("name", ["70", "2026-01-01", "null", 'a: "b"'])
def test_a_saved_description_may_have_any_name(name: str, tmp_path: Path) -> None:
    path = tmp_path / f"{name}.yaml"
    assert run([*EXAMPLE, "--save", str(path)]) == 0
    assert load_description(path).gripper.name == name


def test_nothing_is_saved_that_is_not_feasible(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "mine.yaml"
    assert run([*EXAMPLE, "--pressure-max", "50 kPa", "--save", str(path)]) == 2
    assert "nothing is saved: not feasible" in capsys.readouterr().err
    assert not path.exists()


def test_an_existing_file_is_kept(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("mine", encoding="utf-8")
    assert run([*EXAMPLE, "--save", str(path)]) == 2
    assert "exists already and is kept" in capsys.readouterr().err
    assert path.read_text(encoding="utf-8") == "mine"


def test_without_matplotlib_one_line_says_what_to_install(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for module in [name for name in sys.modules if name.split(".")[0] == "matplotlib"]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.delitem(sys.modules, "spiral_gripper.reports.plots", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    saved = tmp_path / "mine.yaml"
    picture = str(tmp_path / "mine.png")
    assert run([*EXAMPLE, "--save", str(saved), "--plot", picture]) == 2
    assert "spiral-gripper[plot]" in capsys.readouterr().err
    assert saved.exists()


def test_shape_and_wrap_agree_with_python(capsys: pytest.CaptureFixture[str]) -> None:
    from spiral_core import WrapCurve
    from spiral_gripper import load_gripper

    curve = WrapCurve(load_gripper("prototype_p1"))
    wrapped = answer(capsys, "wrap", "prototype_p1", "--radius", "20 mm", "--pressure", "60 kPa")
    assert wrapped["pressure"] == curve.pressure_from_radius(0.02)
    assert wrapped["regime"] == "curling"
    assert wrapped["line_force"] > 0.0
    shape = answer(capsys, "shape", "prototype_p1", "--pressure", "8 psi")
    assert shape["stable"] is True
    assert shape["positions"][0] == [0.0, 0.0, 0.0]
    assert len(shape["positions"]) == len(shape["orientations"]) == len(shape["arc_lengths"])
    assert shape["pressure"] == pytest.approx(55158.058, rel=1e-7)  # eight digits as written


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
    assert run(["wrap", "paper_design_70", "--profile", str(path)]) == 0
    assert "perfect wrap" in capsys.readouterr().out


def test_charts_as_data(capsys: pytest.CaptureFixture[str]) -> None:
    curves = answer(capsys, "chart", "design-space", "prototype_p1", "--beta", "50 deg")
    assert len(curves) == 1
    assert len(curves[0]["stretch"]) == len(curves[0]["length_ratio"])
    gravity = answer(capsys, "chart", "gravity", "prototype_p1")
    assert gravity["with_gravity"]["radius"][0] > gravity["without_gravity"]["radius"][0]
    regimes = answer(capsys, "chart", "pressure", "prototype_p1", "--radius-max", "30 mm")
    assert regimes["radius"][0] == pytest.approx(0.03)


def test_sweeps(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    plot = tmp_path / "map.png"
    wanted = [*EXAMPLE[1:], "--jobs", "1"]
    at = wanted.index("--tube")
    room = answer(
        capsys, "sweep", "map", *wanted[:at], *wanted[at + 2 :], "--angles", "2",
        "--tube-radii", "2", "--tube-radius-min", "4 mm", "--tube-radius-max", "5 mm",
        "--plot", str(plot),
    )  # fmt: skip
    assert len(room["room"]) == len(room["binding"]) == 2
    assert plot.stat().st_size > 0
    best = answer(capsys, "sweep", "pareto", *wanted, "--plot", str(plot))
    assert {round(point["fiber_angle_beta"], 4) for point in best} <= {1.2217, 1.3963}
    assert run(["sweep", "pareto", *wanted]) == 0
    assert "feasible designs (4 candidates)" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["shape", "prototype_p1", "--pressure", "55"], 'write "55 kPa" or "55 psi"'),
        (["shape", "prototype_p1", "--pressure", "5 mm"], "is a length"),
        (["shape", "prototype_p1", "--pressure", "-5 kPa"], "--pressure -5 kPa is below 0"),
        (["shape", "prototype_p1", "--pressure", "900 kPa"], "above limits.pressure_max, 16 psi"),
        (["shape", "prototype_p3", "--pressure", "5 kPa"], "did you mean prototype_p"),
        (["shape", "nowhere/mine.yaml", "--pressure", "5 kPa"], "there is no such file"),
        (["shape", "prototype_p1"], "--pressure"),
        (["wrap", "prototype_p1"], "either --radius or --profile"),
        (["wrap", "prototype_p1", "--radius", "90 mm"], "too thick"),
        (["wrap", "prototype_p1", "--radius", "nan mm"], "must be a length"),
        ([*WRAP, "--object-axis", "0", "0", "0"], "all be zero"),
        ([*WRAP, "--object-axis", "0", "0", "inf"], "finite"),
        (["wrap", "prototype_p1", "--profile", "no.csv"], "no.csv"),
        ([*WRAP, "--gravity-magnitude", "-9.81 m/s^2"], "from 0 to 10000 m/s^2"),
        ([*WRAP, "--gravity-magnitude", "1e300 m/s^2"], "from 0 to 10000 m/s^2"),
        (["simulate", "--noise", "-1 mm"], "from 0 to 0.1 m"),
        (["simulate", "--noise", "1e300 m"], "from 0 to 0.1 m"),
        (["simulate", "--radius", "2 m"], "at most 1 m"),
        (["chart", "gravity", "prototype_p1"], "--plot FILE"),
        (["chart", "gravity", "prototype_p1", "--plot", "x.bmp"], ".png, .svg, .pdf"),
        (["chart", "gravity", "prototype_p1", "--plot", "no/where/x.png"], "there is no folder"),
        (["wrp"], "did you mean spiral-gripper wrap?"),
        (["map", "--tube", "a b"], 'did you mean spiral-gripper sweep map --tube "a b"?'),
        (["prototype_p1", "--radius", "9 mm"], "spiral-gripper wrap prototype_p1 --radius"),
        (["chart", "mine.yaml"], "as in spiral-gripper chart pressure mine.yaml; the commands"),
        (["--radius", "9 mm"], "--radius is an option of a command"),
        (["wrap", "prototype_p1", "--radius", "6 cm"], "an object of radius 6 cm cannot be"),
        (["shape", "prototype_p1", "--pressure", "8 psia"], "subtract 14.7 psi"),
        ([*EXAMPLE, "--beta", "165 deg"], "is -15 deg here"),
        (["shape", "/dev/zero", "--pressure", "8 psi"], "a device or a pipe"),
        (["wrap", "prototype_p1", "--profile", "/dev/zero"], "a device or a pipe"),
        (["frobnicate"], "there is no command 'frobnicate'; the commands of"),
        (["design", "--radius-min", "1 mm"], "--radius-max"),
        ([*EXAMPLE, "--radius-max", "5 mm"], "--radius-max must be at least radius_min = 11 mm"),
        ([*EXAMPLE, "--strain-max", "30 %"], "plain finite number"),
        ([*EXAMPLE, "--turns", "nan"], "plain finite number"),
        ([*EXAMPLE, "--tube", "3/8 x 1/32"], "bore and wall"),
        ([*EXAMPLE, "--tubing", "latex"], "natural_latex"),
        ([*EXAMPLE, "--beta", "88 deg"], "cross"),
        ([*EXAMPLE, "--report", "x.doc"], ".md, .html"),
        ([*EXAMPLE[:5], "--tube", "1e300 m x 1 mm"], "at most 1e+09 m"),
        (["sweep", "pareto", *EXAMPLE[1:], "--jobs", "99999999999"], "1<=x<=1024"),
        (["sweep", "map", *EXAMPLE[1:], "--angles", "1"], "2<=x<=181"),
        (["sweep", "map", *EXAMPLE[1:]], "--tube does not go with map"),
        (["sweep", "map", *EXAMPLE[1:5], "--beta", "70 deg"], "give --beta twice"),
        (
            ["sweep", "map", *EXAMPLE[1:5], "--tube-radius-min", "9 mm"],
            "--tube-radius-min must be below --tube-radius-max",
        ),
    ],
)  # fmt: skip
def test_one_line_says_what_is_wrong(
    arguments: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert expected in error_of(capsys, *arguments)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("position, radius\n0, 1\n", "columns with units"),
        ("position [mm], radius [kPa]\n0, 1\n", "not a length"),
        ("position [mm], radius [mm]\n0, a\n", "number"),
        ("position [mm], radius [mm]\n0\n", "two numbers"),
        (f"position [mm], radius [mm]\n0, {'9' * 200_000}\n", "a CSV file"),
        ("", "columns with units"),
    ],
)
def test_a_bad_profile_is_named(
    text: str, expected: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "profile.csv"
    path.write_text(text, encoding="utf-8")
    assert expected in error_of(capsys, "wrap", "prototype_p1", "--profile", str(path))


@pytest.mark.parametrize("group", [[], ["sweep"], ["chart"]])
def test_no_command_shows_the_help(capsys: pytest.CaptureFixture[str], group: list[str]) -> None:
    assert run(group) == 2
    said = capsys.readouterr().err
    assert said.startswith(" ".join(["Usage: spiral-gripper", *group]))
    assert "\nCommands:\n" in said


def test_defects_are_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("a defect")

    monkeypatch.setattr("spiral_gripper.reports.shape_document.solve_shape", broken)
    with pytest.raises(ZeroDivisionError, match="a defect"):
        run(["shape", "prototype_p1", "--pressure", "5 kPa"])


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (
            NotGrippableError(0.06, "too thick for 1.05 turns", -0.0222, 0.0378211),
            (
                "an object of radius 6 cm cannot be gripped: too thick for 1.05 turns; "
                "the nearest grippable radius is 3.782 cm"
            ),
        ),
        (
            NotGrippableError(0.001, "too thin for the limit of 162000 Pa", -1.0, 0.00378219),
            (
                "an object of radius 1 mm cannot be gripped: too thin for the limit of 23.5 psi; "
                "the nearest grippable radius is 0.3783 cm"
            ),
        ),
        (
            NotGrippableError(0.5, "no", -1.0, None),
            "an object of radius 50 cm cannot be gripped: no",
        ),
        (
            InvalidInputError("radius_max", 0.06, "at least radius_min = 0.1 m"),
            "--radius-max must be at least radius_min = 10 cm, got 6 cm",
        ),
        (
            InvalidInputError("gravity", 3.0, "at most 1e+06 m, 9.8 m/s^2 or 2 N m^2 or 0.5 rad"),
            "gravity must be at most 1e+06 m, 9.8 m/s^2 or 2 N m^2 or 28.65 deg, got 3.0",
        ),
        (
            NoCoilError(0.5, 1.05, 82737.0),
            (
                "the gripper makes 0.5 turns at most (at 12 psi) but 1.05 are required; "
                "lengthen it, raise the pressure limit or ask for fewer turns"
            ),
        ),
    ],
)
def test_messages_are_in_the_units_that_were_typed(error: SpiralError, expected: str) -> None:
    givens = {
        "radius_max": [TypedValue(0.06, "6 cm", "LENGTH")],
        "radius_min": [TypedValue(0.001, "1 mm", "LENGTH")],
        "pressure_max": [TypedValue(89631.0, "13 psi", "PRESSURE")],
        "turns": [TypedValue(0.5, "0.5", "")],
    }
    assert sentence(error, givens) == expected


def test_a_full_disk_is_said_in_one_line() -> None:
    for command in (["--help"], WRAP, ["doctor", "nowhere"]):
        with Path("/dev/full").open("w", encoding="utf-8") as full:
            done = subprocess.run(
                [sys.executable, "-m", "spiral_gripper.cli.main", *command],
                stdout=full, stderr=subprocess.PIPE, text=True, check=False,
            )  # fmt: skip
        assert done.returncode == 2
        assert done.stderr == "spiral-gripper: the answer cannot be printed: the disk is full\n"


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
    assert run(["grippers", "check", str(path)]) == 0
    checked = capsys.readouterr().out
    assert checked == "prototype_p1: valid; grips radii from 2.591 mm to 35.59 mm, up to 16 psi\n"
    low, high = answer(capsys, "grippers", "check", str(path))["radius_range"]
    assert low < 0.01 < high


def test_options_have_the_cores_defaults() -> None:
    from spiral_core.wrap.gripper import DEFAULT_TURNS

    assert types.DEFAULT_TURNS == DEFAULT_TURNS


@pytest.mark.parametrize(
    ("arguments", "title"),
    [
        (["shape", "prototype_p1", "--pressure", "8 psi"], "prototype_p1 at 8 psi"),
        (
            ["wrap", "prototype_p1", "--radius", "9 mm"],
            r"prototype_p1 around 9 mm, at \d\d\.\d+ kPa",
        ),
        (["chart", "pressure", "prototype_p1"], "prototype_p1"),
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


def test_without_viser_one_line_says_what_to_install(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    assert "the studio needs viser: pip install 'spiral-gripper[studio]'" in error_of(
        capsys, "studio", "prototype_p1", "--no-browser"
    )


def test_a_diameter_is_told_to_be_halved(capsys):
    said = error_of(capsys, "wrap", "prototype_p1", "--diameter", "32 mm")
    assert said.endswith("No such option '--diameter'. Give --radius, half the diameter.\n")


class Terminal(io.StringIO):
    """Standard error as a person at a terminal has it."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("command", "told"), [("wrap", True), ("watch", False)])
def test_who_waits_at_a_terminal_is_told_what_for(monkeypatch, command, told):
    screen = Terminal()

    def wait(_):
        end = time.monotonic() + (240.0 if told else 0.2)
        while not screen.getvalue() and time.monotonic() < end:
            time.sleep(0.01)
        return 0

    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(sys, "argv", ["spiral-gripper", command])
    monkeypatch.setattr(main_module, "PATIENCE", 0.0)
    monkeypatch.setattr(main_module, "run", wait)
    with pytest.raises(SystemExit):
        main_module.main()
    assert ("compiles the solver" in screen.getvalue()) is told
