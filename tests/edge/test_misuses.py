# SPDX-License-Identifier: Apache-2.0
"""More than a hundred misuses of every command: each is answered at once, in a line, with why."""

from __future__ import annotations

import os
import re
import shlex
import time
from pathlib import Path

import pytest

from spiral_core import WrapCurve
from spiral_gripper import load_gripper
from spiral_gripper.cli.main import COMMANDS, run
from spiral_gripper.files.catalog import GRIPPERS

# Far more than any answer needs on a busy machine [s].
TIME_LIMIT = 10.0
D = "design --radius-min '11 mm' --radius-max '30 mm' --tube '3/8 in x 1/32 in' "
P = "sweep pareto --jobs 1 --radius-min '11 mm' --radius-max '30 mm' "
M = "sweep map --jobs 1 --radius-min '11 mm' --radius-max '30 mm' "
W = "wrap prototype_p1 --radius '9 mm' "
C = "calibrate prototype_p1 good.csv --no-save "

# What is typed -> a part of the answer. {folder} holds the files that `files` writes.
MISUSES = {
    # the command itself
    "frobnicate": "the commands of spiral-gripper are design",
    "wrp prototype_p1": "did you mean spiral-gripper wrap?",
    "prototype_p1": "as in spiral-gripper wrap prototype_p1",
    "mine.yaml --pressure '8 psi'": "wrap mine.yaml --pressure",
    "--radius '9 mm'": "write the command before it",
    "map": "did you mean spiral-gripper sweep map?",
    "list": "did you mean spiral-gripper grippers list?",
    "--frob": "--frob",
    "WRAP prototype_p1": "did you mean",
    "map --tube 'a b'": 'did you mean spiral-gripper sweep map --tube "a b"?',
    "chart mine.yaml": "as in spiral-gripper chart pressure mine.yaml; the commands",
    # the single fiber's angle
    D + "--gamma '2 deg'": "belong to the uniform pressure law, which is for straight fibers",
    D + "--gamma '-79 deg'": "--gamma must be an angle from -30 to 30 degrees: a steeper fiber",
    D + "--gamma '20 deg' --beta '20 deg'": "--gamma must be at another angle than the wound",
    D + "--gamma 2": 'write "2 deg" or "2 rad"',
    M + "--gamma '1 deg' --gamma '2 deg'": "give --gamma once at most",
    # the object's place
    W + "--place '0 mm' '0 mm' '0 mm'": "the tube without pressure runs through",
    W + "--place '0 mm' 'nan mm' '0 mm'": "a length with its unit",
    W + "--place 1 2 3": 'write "1 mm"',
    W + "--place '9 mm' '9 mm' '9 mm' --find-place": "give either --place or --find-place",
    W + "--find-place --tip-criterion": "--tip-criterion knows no place but the free coil's",
    # shape
    "shape": "GRIPPER",
    "shape prototype_p1": "'--pressure'",
    "shape prototype_p1 extra --pressure '8 psi'": "unexpected extra argument",
    "shape prototype_p1 --pressure 8": 'write "8 kPa" or "8 psi"',
    "shape prototype_p1 --pressure '8 pzi'": 'did you mean "psi"?',
    "shape prototype_p1 --pressure '8 psia'": "subtract 14.7 psi",
    "shape prototype_p1 --pressure '8 mm'": "is a length",
    "shape prototype_p1 --pressure 'eight psi'": "a pressure with its unit",
    "shape prototype_p1 --pressure ''": "a pressure with its unit",
    "shape prototype_p1 --pressure '8,5 psi'": "a pressure with its unit",
    "shape prototype_p1 --pressure 'nan psi'": "a pressure with its unit",
    "shape prototype_p1 --pressure '1e999 psi'": "finite",
    "shape prototype_p1 --pressure '17 psi'": "17 psi is above limits.pressure_max, 16 psi",
    "shape prototype_p1 --pressure '-1 psi'": "-1 psi is below 0",
    "shape prototype_p3 --pressure '8 psi'": "did you mean prototype_p",
    "shape '' --pressure '8 psi'": "no gripper has this name",
    "shape nowhere.yaml --pressure '8 psi'": "there is no such file",
    "shape {folder} --pressure '8 psi'": "it is a folder",
    "shape /dev/zero --pressure '8 psi'": "a device or a pipe",
    "shape {folder}/pipe.yaml --pressure '8 psi'": "a device or a pipe",
    "shape {folder}/large.yaml --pressure '8 psi'": "more than 2 MB",
    "shape {folder}/binary.yaml --pressure '8 psi'": "not text in UTF-8",
    "shape {folder}/empty.yaml --pressure '8 psi'": "is empty",
    "shape {folder}/list.yaml --pressure '8 psi'": "must hold fields such as name, tube.inner",
    "shape {folder}/colon.yaml --pressure '8 psi'": "colon.yaml:11:5: this is not valid YAML",
    "shape {folder}/diameter.yaml --pressure '8 psi'": "give tube.inner_radius, half of it",
    "wrap {folder}/psi.yaml --radius '9 mm'": "turns at most (at 16 psi)",
    "shape {folder}/tab.yaml --pressure '8 psi'": "not valid YAML",
    "shape {folder}/ogden.yaml --pressure '8 psi'": "did you mean yeoh?",
    "shape {folder}/angle.yaml --pressure '8 psi'": "is -15 deg here",
    "shape {folder}/limit.yaml --pressure '8 psi'": "the actuator's own limit",
    "shape {folder}/good.csv --pressure '8 psi'": "holds none of",
    "shape prototype_p1 --pressure '8 psi' --gravity-direction 0 0 0": "must not all be zero",
    "shape prototype_p1 --pressure '8 psi' --gravity-direction 0 0": "3 arguments",
    "shape prototype_p1 --pressure '8 psi' --gravity-direction a b c": "a plain finite number",
    "shape prototype_p1 --pressure '8 psi' --gravity-magnitude 9.81": "an acceleration with its",
    "shape prototype_p1 --pressure '8 psi' --gravity-magnitude '-9.81 m/s^2'": "m/s^2, got '-9.81",
    "shape prototype_p1 --pressure '8 psi' --plot x.bmp": ".png, .svg, .pdf",
    "shape prototype_p1 --pressure '8 psi' --plot x": ".png, .svg, .pdf",
    "shape prototype_p1 --pressure '8 psi' --plot no/where/x.png": "there is no folder",
    "shape prototype_p1 --pressure '8 psi' --plot /proc/x.png": "no files: write to another folder",
    "shape prototype_p1 --pressure '8 psi' --plot {folder}/folder.png": "not a plain file",
    # grip
    "close prototype_p1 --radius '9 mm'": "Missing option '--rate'",
    "close prototype_p1 --rate '20 kPa/s'": "Missing option '--radius'",
    "close prototype_p1 --radius '9 mm' --rate 20": 'write "20 kPa/s"',
    "close prototype_p1 --radius '9 mm' --rate '20 kPa'": "it must be a pressure rate",
    "close prototype_p1 --radius '9 mm' --rate '-1 kPa/s'": "above 0 and at most 1000 bar/s",
    "close prototype_p1 --radius '9 mm' --rate '9 kPa/s' --wait '0 s'": "above 0 and at most 600 s",
    "close prototype_p1 --radius '9 mm' --rate '9 Pa/s' --friction 90": "--friction': it must be",
    "close prototype_p1 --radius '9 mm' --rate '9 kPa/s' --animate a.mp4": "writes .gif files",
    "close prototype_p1 --radius '9 cm' --rate '9 kPa/s'": "cannot be gripped: too thick",
    "grip prototype_p1": "either --radius or --profile",
    "grip prototype_p1 --radius '9 mm' --profile {folder}/cone.csv": "either --radius or --profile",
    "grip prototype_p1 --radius '0 mm'": "--radius must be a positive finite number, got 0 mm",
    "grip prototype_p1 --radius '9 cm'": "an object of radius 9 cm cannot be gripped: too thick",
    "grip prototype_p1 --radius '9 mm' --friction -1": "at least 0 and at most 10, got '-1'",
    "grip prototype_p1 --radius '9 mm' --friction 30%": "a plain finite number",
    "grip prototype_p1 --radius '9 mm' --payload 200": 'write "200 g"',
    "grip prototype_p1 --radius '9 mm' --payload '2 N'": "it must be a mass",
    "grip prototype_p1 --radius '9 mm' --payload '-1 g'": "above 0 and at most 1000 kg",
    "grip prototype_p1 --radius '9 mm' --force-max '0 N'": "above 0 and at most 1000 kN",
    "grip prototype_p1 --radius '9 mm' --payload '1 g' --gravity-magnitude '0 m/s^2'": (
        "--payload needs gravity"
    ),
    "grip prototype_p1 --radius '9 mm' --object-axis 0 0 0": "must not all be zero",
    "grip prototype_p1 --profile {folder}/falling.csv": "[mm] must be increasing, got '10, 0'",
    # wrap
    "wrap prototype_p1": "either --radius or --profile",
    W + "--profile {folder}/good.csv": "either --radius or --profile",
    "wrap prototype_p1 --radius 9": 'write "9 mm" or "9 in"',
    "wrap prototype_p1 --radius '0 mm'": "--radius must be a positive finite number, got 0 mm",
    "wrap prototype_p1 --radius '-9 mm'": "got -9 mm",
    "wrap prototype_p1 --radius '9 cm'": "an object of radius 9 cm cannot be gripped",
    "wrap prototype_p1 --radius '1e300 m'": "the nearest grippable radius is 0.03559 m",
    "wrap prototype_p1 --radius '1e-300 m'": "cannot be gripped: too thin",
    "wrap prototype_p1 --raduis '9 mm'": "--radius",
    W + "--pressure '20 psi'": "20 psi is above limits.pressure_max, 16 psi",
    W + "--gravity-magnitude '1e300 m/s^2'": "at least 0 and at most 10000 m/s^2",
    W + "--object-axis 0 0 0": "must not all be zero",
    W + "--object-axis 1 0 inf": "finite",
    "wrap prototype_p1 --profile {folder}/none.csv": "none.csv",
    "wrap prototype_p1 --profile {folder}": "is a directory",
    "wrap prototype_p1 --profile /dev/zero": "a device or a pipe",
    "wrap prototype_p1 --profile {folder}/binary.yaml": "not text in UTF-8",
    "wrap prototype_p1 --profile {folder}/empty.yaml": "holds no table",
    "wrap prototype_p1 --profile {folder}/good.csv": "known columns are position, radius",
    "wrap prototype_p1 --profile {folder}/falling.csv": "[mm] must be increasing, got '10, 0'",
    "wrap prototype_p1 --profile {folder}/comma.csv": "decimals follow a point",
    "wrap prototype_p1 --profile {folder}/cone.csv --pressure '8 psi' --tip-criterion": (
        "--pressure goes with"
    ),
    # design
    "design": "--radius-min",
    "design --radius-min '11 mm'": "--radius-max",
    "design --radius-min '30 mm' --radius-max '11 mm'": "the smallest radius, 30 mm, got 11 mm",
    "design --radius-min '-1 mm' --radius-max '11 mm'": "--radius-min must be a positive",
    D + "--strain-max '30 %'": "a plain finite number",
    D + "--strain-max 30": "0.3 is 30 %",
    D + "--strain-max -1": "--strain-max must be",
    D + "--turns 0": "--turns must be a positive finite number, got 0",
    D + "--turns nan": "a plain finite number",
    D + "--tube '3/8 x 1/32'": "bore and wall with their units",
    D + "--tube '3/8 in'": "bore and wall with their units",
    D + "--tube '0.8 mm x 9.5 mm'": 'did you mean "9.5 mm x 0.8 mm"?',
    D + "--tube '0 in x 1/32 in'": "positive",
    "design --radius-min '9 mm' --radius-max '9 mm' --tube '1e300 m x 1 mm'": "at most 1e+09 m",
    D + "--tubing rubber": "natural_latex",
    D + "--tubing prototype_p1": "no tubing has this name",
    D + "--tubing {folder}/good.yaml": "is not a field here",
    D + "--beta '88 deg'": "families that cross",
    D + "--beta '165 deg'": "is -15 deg here",
    D + "--beta '0 deg'": "not 0",
    D + "--alpha '100 deg'": "is -80 deg here",
    D + "--prefer cheapest": "least-strain",
    D + "--pressure-max '-1 psi'": "--pressure-max must be",
    D + "--paper --friction 0.5": "--friction goes with --payload",
    "sweep map --radius-min '11 mm' --radius-max '30 mm' --friction 0.5": "--friction goes with",
    D + "--end-allowance '-1 mm'": "--end-allowance must be",
    D + "--save x.yml": ".yaml",
    D + "--save {folder}/good.yaml": "exists already and is kept",
    D + "--report x.doc": ".md, .html",
    D + "--json --json=yes": "does not take a value",
    # sweep
    "sweep": "Usage: spiral-gripper sweep",
    "sweep prototype_p1": "the commands of spiral-gripper sweep are",
    "sweep design": "there is no command 'design'",
    P + "--jobs 0": "1<=x<=1024",
    P + "--jobs two": "--jobs",
    M + "--angles 1": "2<=x<=181",
    M + "--tube '3/8 in x 1/32 in'": "--tube does not go with map",
    M + "--beta '70 deg'": "give --beta twice",
    M + "--tube-radius-min '9 mm'": "--tube-radius-min must be below --tube-radius-max",
    M + "--tube-radii 1.5": "--tube-radii",
    M + "--wall 1": 'write "1 mm" or "1 in"',
    # chart
    "chart": "Usage: spiral-gripper chart",
    "chart prototype_p1 --json": "as in spiral-gripper chart pressure prototype_p1",
    "chart gravity prototype_p1": "--plot FILE, --json, or both",
    "chart design-space prototype_p1 --json --beta 70": 'write "70 deg" or "70 rad"',
    "chart design-space prototype_p1 --json --stretch-max 0.5": "must be above 1, got",
    "chart design-space prototype_p1 --json --turns -1": "--turns must be",
    "chart pressure prototype_p1 --json --radius-min 9mm --radius-max 8mm": "9mm is not below",
    "chart pressure prototype_p1 --json --radius-min '1 m'": "1 m is not below",
    "chart pressure prototype_p1 --json --radius-max '1 m'": "cannot be gripped",
    "chart pressure nowhere --json": "no gripper has this name",
    # calibrate
    "calibrate": "GRIPPER",
    "calibrate prototype_p1": "FILES",
    "calibrate prototype_p1 none.csv": "there is no such file",
    "calibrate prototype_p1 /dev/zero": "a device or a pipe",
    "calibrate prototype_p1 {folder}/good.yaml": "is not a known column",
    "calibrate prototype_p1 {folder}/empty.yaml": "holds no table",
    "calibrate prototype_p1 pounds.csv": 'no unit "pounds"); usual are kPa, psi, bar',
    "calibrate prototype_p1 remark.csv": 'leave it out by --ignore "remark"',
    "calibrate prototype_p1 negative.csv": "must be a non-negative finite number, got -20 kPa",
    "shape {folder}/kilometers.yaml --pressure '8 psi'": "at most 10 m, got 500000 mm",
    "calibrate good.csv {folder}/good.csv": "it holds none of a description",
    C + "--law ogden": "neo_hookean",
    C + "--fit everything": "bending_stiffness",
    C + "--hold c2": "of the form NAME=VALUE",
    C + "--hold c9=1": "a constant of the law",
    C + "--unit pressure": "of the form NAME=VALUE",
    C + "--unit twist=deg": "--unit must be for a column of the files",
    C + "--error 'twist=1 deg'": "a column of the files: extension, pressure, got 'twist'",
    C + "--error 'extension=-1 mm'": "--error extension must be positive, got '-1 mm'",
    C + "--error 'extension=0 %'": "--error extension must be positive, got '0 %'",
    C + "--error extension=1": 'write "1 mm"',
    C + "--error 'extension=two %'": 'a share such as "2 %"',
    C + "--ignore remark": "no such heading",
    C + "--section-length '1e300 m'": "at most 10 m",
    C + "--section-length 100": 'write "100 mm"',
    C + "--level 95": "--level",
    C + "--level 1": "--level",
    C + "--draws 1": "--draws",
    C + "--draws 400": "--draws goes with --radius",
    C + "--free-swing --section-length '90 mm'": "leave --section-length",
    C + "--seed -1": "--seed",
    C + "--plot residuals.bmp": ".png, .svg, .pdf",
    C + "--save x.yaml": "exclude each other",
    C + "--measured-curve": "bend angles and twists only",
    C + "--measured-curve --law yeoh": "--measured-curve fits nothing",
    C + "--measured-curve --report r.md": "leave --report out",
    C + "--report r.pdf": "must end in .md, .html",
    C + "--radius '1 m'": "an object of radius 1 m cannot be gripped",
    # winding-sheet, model, studio
    "winding-sheet": "GRIPPER",
    "winding-sheet nowhere": "no gripper has this name",
    "winding-sheet prototype_p1 --save sheet.png": ".pdf, .svg",
    "winding-sheet prototype_p1 --end-allowance '-1 mm'": "--end-allowance -1 mm is below 0",
    "winding-sheet prototype_p1 --end-allowance 20": 'write "20 mm"',
    "model": "GRIPPER",
    "model prototype_p1": "'--radius'",
    "model nowhere --radius '9 mm'": "no gripper has this name",
    "model prototype_p1 --radius '9 cm'": "an object of radius 9 cm cannot be gripped",
    "studio prototype_p1 --port two": "--port",
    # grippers, doctor, and what needs ROS 2
    "grippers": "Usage: spiral-gripper grippers",
    "grippers prototype_p1": "as in spiral-gripper grippers show prototype_p1",
    "grippers show": "GRIPPER",
    "grippers show prototype_p3": "did you mean prototype_p",
    "grippers check /dev/zero": "a device or a pipe",
    "grippers check {folder}/short.yaml": "turns at most",
    "grippers list prototype_p1": "unexpected extra argument",
    "doctor one two": "unexpected extra argument",
    "doctor --jsn": "--json",
    "simulate nowhere": "no gripper has this name",
    "simulate --radius '2 m'": "at most 1 m",
    "simulate --noise '-1 mm'": "and at most 0.1 m",
    "simulate --duration 0": "must be above 0",
    "simulate --namespace bad!name": "letters, digits and _",
    "simulate --inject leak": "--inject",
    "inject": "Choose from: none, leak",
    "inject leak": "--namespace",
    "inject typhoon --namespace /left": "stuck_valve",
    "inject leak --namespace bad!name": "letters, digits and _",
    "plan --radius 9": "--radius",
    "grasp --radius": "--radius",
    "release --timeout -1": "must be above 0",
    "status --namespace 1st": "beginning with a digit",
    "watch --duration never": "a plain finite number",
}


@pytest.fixture(scope="module", autouse=True)
def _compiled() -> None:
    """Compile first, where that was never done: it takes longer than an answer may."""
    WrapCurve(load_gripper("prototype_p1")).wrap_for_radius(0.01)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with files to misuse."""
    folder = tmp_path_factory.mktemp("misuse")
    good = (GRIPPERS.path / "prototype_p1.yaml").read_text(encoding="utf-8")
    texts = {
        "good.yaml": good,
        "empty.yaml": "",
        "list.yaml": "- 1\n- 2\n",
        "tab.yaml": "tube:\n\tlength: 1 m\n",
        "ogden.yaml": good.replace("law: mooney_rivlin", "law: ogden"),
        "angle.yaml": good.replace("beta: 50 deg", "beta: 165 deg"),
        "limit.yaml": good.replace("pressure_max: 16 psi", "pressure_max: 16 MPa"),
        "colon.yaml": good.replace("\ntube:", "\ntube"),
        "diameter.yaml": good.replace("inner_radius", "inner_diameter"),
        "psi.yaml": good.replace("length: 500 mm", "length: 60 mm"),
        "short.yaml": good.replace("length: 500 mm", "length: 20 mm"),
        "good.csv": (
            "pressure [kPa],extension [mm],extension_error [mm],section_length [mm]\n"
            "20,4.1,0.1,100\n40,9.2,0.1,100\n60,14.8,0.1,100\n"
        ),
        "pounds.csv": "pressure [pounds],extension [mm]\n20,4\n",
        "remark.csv": "pressure [kPa],extension [mm],remark\n20,4,good\n",
        "negative.csv": "pressure [kPa],extension [mm],extension_error [mm]\n-20,4,0.1\n",
        "kilometers.yaml": good.replace("length: 500 mm", "length: 500000 mm"),
        "falling.csv": "position [mm], radius [mm]\n10, 9\n0, 9\n",
        "comma.csv": "position [mm], radius [mm]\n0, 9\n300, 20,5\n",
        "cone.csv": "position [mm], radius [mm]\n0, 9\n300, 20\n",
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "binary.yaml").write_bytes(b"\xff\xfe")
    (folder / "folder.png").mkdir()
    os.mkfifo(folder / "pipe.yaml")
    with (folder / "large.yaml").open("wb") as large:
        large.truncate(100_000_000)
    return folder


def test_there_are_enough_and_of_every_command() -> None:
    assert len(MISUSES) >= 150
    assert {text.split()[0] for text in MISUSES} >= COMMANDS.keys()


@pytest.mark.timeout(60)  # a hang that costs no processor time
@pytest.mark.parametrize("text", MISUSES)
def test_a_misuse_is_answered_at_once_with_the_reason(
    text: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    before = set(folder.iterdir())
    begin = time.process_time()
    assert run(shlex.split(text.format(folder=folder))) == 2  # raises what is a defect
    assert time.process_time() - begin < TIME_LIMIT
    said = capsys.readouterr().err
    assert MISUSES[text] in " ".join(said.split())
    assert said.startswith(("spiral-gripper: ", "Usage: spiral-gripper "))
    assert "Errno" not in said
    assert " Pa" in text or re.search(r"\d Pa\b", said) is None  # the unit is that of the user
    assert set(folder.iterdir()) == before
