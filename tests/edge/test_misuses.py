# SPDX-License-Identifier: Apache-2.0
"""Misuses of every command: each is answered at once, in a line, with why; defects are not."""

import re
import shlex
import subprocess
import sys
import time
from pathlib import Path

import pytest
from repo.source_tree import ROOT

from spiral_core import InvalidInputError, NotGrippableError, WrapCurve
from spiral_core.message import Message, Quantity
from spiral_gripper import load_gripper
from spiral_gripper.cli.main import COMMANDS, run
from spiral_gripper.cli.types import TypedValue, error_text
from spiral_gripper.files.catalog import GRIPPERS

# Far more than any answer needs on a busy machine [s].
TIME_LIMIT = 10.0
DATA = ROOT / "examples" / "data"
# Beginnings of what is typed.
BEGINNINGS = {
    "A": "approach prototype_p1 --radius '9 mm' --object-axis 0 0 1",
    "D": "design --radius-min '11 mm' --radius-max '30 mm' --tube '3/8 in x 1/32 in'",
    "P": "sweep pareto --jobs 1 --radius-min '11 mm' --radius-max '30 mm'",
    "M": "sweep map --jobs 1 --radius-min '11 mm' --radius-max '30 mm'",
    "W": "wrap prototype_p1 --radius '9 mm'",
    "C": "calibrate prototype_p1 good.csv --no-save",
    "S": f"calibrate {DATA}/my_gripper.yaml {DATA}/free_swing.csv --free-swing",
    "data": DATA,
}
GOOD = (GRIPPERS.path / "prototype_p1.yaml").read_text("utf-8")
FILES = {
    "good.yaml": GOOD,
    "colon.yaml": GOOD.replace("\ntube:", "\ntube"),
    "psi.yaml": GOOD.replace("length: 500 mm", "length: 60 mm"),
    "short.yaml": GOOD.replace("length: 500 mm", "length: 20 mm"),
    "good.csv": (
        "pressure [kPa],extension [mm],extension_error [mm],section_length [mm]\n"
        "20,4.1,0.1,100\n40,9.2,0.1,100\n60,14.8,0.1,100\n"
    ),
    "falling.csv": "position [mm], radius [mm]\n10, 9\n0, 9\n",
    "comma.csv": "position [mm], radius [mm]\n0, 9\n300, 20,5\n",
    "cone.csv": "position [mm], radius [mm]\n0, 9\n300, 20\n",
    "unitless.csv": "position, radius [mm]\n0, 1\n",
    "blank.csv": "position [mm], radius [mm]\n0,\n",
    "endless.csv": f"position [mm], radius [mm]\n0, {'9' * 200_000}\n",
}

# What is typed -> a part of the answer. {folder} holds the files.
MISUSES = {
    # the command itself
    "frobnicate": "the commands of spiral-gripper are design",
    "wrp prototype_p1": "did you mean spiral-gripper wrap?",
    "prototype_p1": "as in spiral-gripper wrap prototype_p1",
    "--radius '9 mm'": "write the command before it",
    # the single fiber's angle
    "{D} --gamma '2 deg'": "belong to the uniform pressure law, which is for straight fibers",
    "{D} --gamma '-79 deg'": "--gamma must be an angle from -30 to 30 degrees: a steeper fiber",
    "{M} --gamma '1 deg' --gamma '2 deg'": "give --gamma once at most",
    # the object's place
    "{W} --place '0 mm' '0 mm' '0 mm'": "the tube without pressure runs through",
    "{W} --place '0 mm' 'nan mm' '0 mm'": "a length with its unit",
    "{W} --place '9 mm' '9 mm' '9 mm' --find-place": "give either --place or --find-place",
    "{W} --find-place --tip-criterion": "--tip-criterion knows no place but the free coil's",
    # shape
    "shape": "GRIPPER",
    "shape prototype_p1": "'--pressure'",
    "shape " + 300 * "x" + ".yaml --pressure '8 psi'": "its name is too long; the shipped grippers",
    "shape prototype_p1 --pressure '17 psi'": "17 psi is above limits.pressure_max, 16 psi",
    "shape prototype_p1 --pressure '-1 psi'": "-1 psi is below 0",
    "shape {folder}/colon.yaml --pressure '8 psi'": "colon.yaml:11:5: this is not valid YAML",
    "wrap {folder}/psi.yaml --radius '9 mm'": "turns at most (at 16 psi)",
    "shape prototype_p1 --pressure '8 psi' --gravity-direction 0 0 0": "must not all be zero",
    "shape prototype_p1 --pressure '8 psi' --plot x.bmp": ".png, .svg, .pdf",
    "shape prototype_p1 --pressure '8 psi' --plot no/where/x.png": "there is no folder",
    "shape prototype_p1 --pressure '8 psi' --plot /proc/x.png": "no files: write to another folder",
    "shape prototype_p1 --pressure '8 psi' --plot {folder}/folder.png": "not a plain file",
    # grip
    "close prototype_p1 --radius '9 mm'": "Missing option '--rate'",
    "close prototype_p1 --radius '9 mm' --rate '1e-9 kPa/s'": "rate must be at least",
    "close prototype_p1 --radius '9 mm' --rate '9 Pa/s' --animate /nowhere/a.gif": "no folder /now",
    "close prototype_p1 --radius '9 mm' --rate '20 kPa'": "it must be a pressure rate",
    "close prototype_p1 --radius '9 mm' --rate '9 kPa/s' --wait '0 s'": "above 0 and at most 600 s",
    "close prototype_p1 --radius '9 mm' --rate '9 Pa/s' --friction 90": "--friction': it must be",
    "close prototype_p1 --radius '9 mm' --rate '9 kPa/s' --animate a.mp4": "writes .gif files",
    "grip prototype_p1 --radius '9 mm' --profile {folder}/cone.csv": "either --radius or --profile",
    "grip prototype_p1 --radius '9 mm' --friction -1": "at least 0 and at most 10, got '-1'",
    "grip prototype_p1 --radius '9 mm' --payload '-1 g'": "above 0 and at most 1000 kg",
    "grip prototype_p1 --radius '9 mm' --force-max '0 N'": "above 0 and at most 1000 kN",
    "grip prototype_p1 --radius '9 mm' --payload '1 g' --gravity-magnitude '0 m/s^2'": (
        "--payload needs gravity"
    ),
    "grip prototype_p1 --profile {folder}/falling.csv": "[mm] must be increasing, got '10, 0'",
    "grip prototype_p1 --radius '9 mm' --pressure '20 MPa'": "above limits.pressure_max",
    # wrap
    "wrap prototype_p1 --radius 9": 'write "9 mm" or "9 in"',
    "wrap prototype_p1 --radius '0 mm'": "--radius must be a positive finite number, got 0 mm",
    "wrap prototype_p1 --raduis '9 mm'": "--radius",
    "{W} --pressure '20 psi'": "20 psi is above limits.pressure_max, 16 psi",
    "{W} --gravity-magnitude '1e300 m/s^2'": "at least 0 and at most 10000 m/s^2",
    "{W} --object-axis 1 0 inf": "finite",
    "wrap prototype_p1 --profile {folder}/good.csv": "known columns are position, radius",
    "wrap prototype_p1 --profile {folder}/comma.csv": "decimals follow a point",
    "wrap prototype_p1 --profile {folder}/cone.csv --pressure '8 psi' --tip-criterion": (
        "--pressure goes with"
    ),
    "wrap prototype_p1 --profile {folder}/unitless.csv": 'has no unit; write "position [mm]"',
    "wrap prototype_p1 --profile {folder}/blank.csv": "is blank, but a profile requires it",
    "wrap prototype_p1 --profile {folder}/endless.csv": "not a line of comma-separated values",
    "wrap prototype_p1 --diameter '32 mm'": "'--diameter'. Give the radius, half the diameter.",
    # design
    "design --radius-min '30 mm' --radius-max '11 mm'": "the smallest radius, 30 mm, got 11 mm",
    "design --radius-min '-1 mm' --radius-max '11 mm'": "--radius-min must be a positive",
    "{D} --strain-max 30": "0.3 is 30 %",
    "{D} --tube '3/8 x 1/32'": "bore and wall with their units",
    "{D} --tube '0.8 mm x 9.5 mm'": 'did you mean "9.5 mm x 0.8 mm"?',
    "design --radius-min '9 mm' --radius-max '9 mm' --tube '1e300 m x 1 mm'": "at most 1e+09 m",
    "{D} --tubing rubber": "natural_latex",
    "{D} --beta '88 deg'": "families that cross",
    "{D} --alpha '100 deg'": "is -80 deg here",
    "{D} --prefer cheapest": "least-strain",
    "{D} --pressure-max '-1 psi'": "--pressure-max must be",
    "{D} --paper --friction 0.5": "--friction goes with --payload",
    "{D} --paper --tolerance '5 mm'": "needs contact, which --paper leaves out",
    "sweep map --radius-min '11 mm' --radius-max '30 mm' --friction 0.5": "--friction goes with",
    "{D} --end-allowance '-1 mm'": "--end-allowance must be",
    "{D} --save x.yml": ".yaml",
    "{D} --save {folder}/good.yaml": "exists already and is kept",
    "{D} --report x.doc": ".md, .html",
    "{D} --json --json=yes": "does not take a value",
    # grip --table
    "grip prototype_p1 --table": "copy it first: spiral-gripper grippers show prototype_p1 >",
    "grip {folder}/good.yaml --table --radius '9 mm' --friction 0.5": "with --radius, --friction:",
    "grip {folder}/good.yaml --table --gravity-direction 0 0 1": "go with --gravity-direction:",
    "grip {folder}/good.yaml --table --table-radii 1": "2<=x<=50",
    "grip prototype_p1 --radius '9 mm' --table-radii 9": "--table-radii goes with --table",
    # capture
    "capture prototype_p1 --radius '9 mm' --pressure '1 MPa'": "is above limits.pressure_max",
    "capture prototype_p1 --radius '9 mm' --payload '1 g' --gravity-magnitude '0 m/s^2'": "needs",
    "capture prototype_p1 --radius '1 m'": "an object of radius 1 m cannot be gripped",
    "capture prototype_p1 --radius '9 mm' --results a.json": ".jsonl",
    "capture prototype_p1 --radius '9 mm' --table": "copy it first: spiral-gripper grippers show",
    # approach
    "approach prototype_p1 --radius '9 mm'": "'--object-axis'",
    "approach prototype_p1 --radius '9 mm' --object-axis 0 0 0": "must not all be zero",
    "{A} --tilt-max '0 deg'": "above 0",
    "{A} --tilt-max '181 deg'": "at most 180 deg",
    # sweep
    "sweep": "Usage: spiral-gripper sweep",
    "{P} --jobs 0": "1<=x<=1024",
    "{M} --angles 1": "2<=x<=181",
    "{M} --tube '3/8 in x 1/32 in'": "--tube does not go with map",
    "{M} --beta '70 deg'": "give --beta twice",
    "sweep grips prototype_p1 --radius '-5 mm'": "above 0, got '-5 mm'",
    "{M} --tube-radius-min '9 mm'": "--tube-radius-min must be below --tube-radius-max",
    # chart
    "chart": "Usage: spiral-gripper chart",
    "chart prototype_p1 --json": "as in spiral-gripper chart pressure prototype_p1",
    "chart section prototype_p1 --plot a.png" + 4 * " --pressure 5kPa": "up to three times",
    "chart gravity prototype_p1": "--plot FILE, --json, or both",
    "chart design-space prototype_p1 --json --stretch-max 0.5": "must be above 1, got",
    "chart pressure prototype_p1 --json --radius-min 9mm --radius-max 8mm": "9mm is not below",
    "chart pressure prototype_p1 --json --radius-max '1 m'": "cannot be gripped",
    # calibrate
    "calibrate prototype_p1": "FILES",
    "calibrate good.csv {folder}/good.csv": "it holds none of a description",
    "{C} --law ogden": "neo_hookean",
    "{C} --fit everything": "bending_stiffness",
    "{C} --hold c2": "of the form NAME=VALUE",
    "{C} --error 'twist=1 deg'": "a column of the files: extension, pressure, got 'twist'",
    "{C} --error 'extension=-1 mm'": "--error extension must be positive, got '-1 mm'",
    "{C} --error 'extension=two %'": 'a share such as "2 %"',
    "{C} --ignore remark": "no such heading",
    "{C} --section-length '1e300 m'": "at most 10 m",
    "{C} --draws 1": "--draws",
    "{C} --draws 400": "--draws goes with --radius",
    "{C} --free-swing --section-length '90 mm'": "leave --section-length",
    "{C} --seed -1": "--seed",
    "{C} --measured-curve": "bend angles and twists only",
    "{C} --measured-curve --report r.md": "leave --report out",
    "{C} --measured-curve --radius '20 mm'": "--measured-curve fits nothing: leave --radius out",
    "{C} --error '2 mm'": 'of the form NAME=VALUE, such as "extension=0.2 mm", got',
    "{C} --error 'coil=2 mm'": "--error must be for one of pressure, extension, twist, bend",
    "{C} --error 'extension=2 psi'": "--error extension must be a length with its unit",
    "{C} --hold 'c2=1 mm'": "--hold c2",
    "{C} --hold c2=1e9kPa": "--hold c2 must be at most 100 MPa in size",
    "{C} --hold extension_limit=1e-9": "must be from 0.1 to 10000: I1 - 3 at full",
    "{C} --hold 'c2=50 MPa'": "held constants must be such that some c1 makes a law",
    "{C} --unit pressure=psi --unit pressure=kPa": "given once",
    "{C} --unit twist=deg": "--unit must be for a column of the files: extension,",
    "{C} --draws 1000000000 --radius '20 mm'": "'--draws'",
    "{C} --law neo_hookean --hold 'c1=150 kPa'": "",
    "{S} --hold 'c1=100 kPa'": "air: a free swing",
    "{S} --law yeoh": "leave --law out",
    "{S} --measured-curve": "excludes other kinds",
    "{S} --save a.yaml": "writes no gripper file",
    "{S} --error 'extension=1 mm'": "only these can have one: displacement",
    "{S} {data}/free_swing.csv": "one file, one swing",
    "calibrate prototype_p1 {data}/free_swing.csv": "use --free-swing",
    "{C} --radius '1 m'": "an object of radius 1 m cannot be gripped",
    # winding-sheet, model, studio
    "winding-sheet prototype_p1 --save sheet.png": ".pdf, .svg",
    "winding-sheet prototype_p1 --end-allowance '-1 mm'": "--end-allowance -1 mm is below 0",
    "model prototype_p1": "'--radius'",
    "studio prototype_p1 --port two": "--port",
    # grippers, doctor, and what needs ROS 2
    "grippers": "Usage: spiral-gripper grippers",
    "grippers prototype_p1": "as in spiral-gripper grippers show prototype_p1",
    "grippers check {folder}/short.yaml": "turns at most",
    "grippers list prototype_p1": "unexpected extra argument",
    "simulate --radius '2 m'": "at most 1 m",
    "simulate --noise '-1 mm'": "and at most 0.1 m",
    "simulate --namespace bad!name": "letters, digits and _",
    "inject": "Choose from: none, leak",
    "release --timeout -1": "must be above 0",
    "doctor one two": "unexpected extra argument",
    "plan --radius 9": "--radius",
    "grasp --radius": "--radius",
    "status --namespace 1st": "beginning with a digit",
    "watch --duration never": "a plain finite number",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with files to misuse."""
    folder = tmp_path_factory.mktemp("misuse")
    (folder / "folder.png").mkdir()
    for name, text in FILES.items():
        (folder / name).write_text(text, "utf-8")
    # Compile first, where that was never done: it takes longer than an answer may.
    WrapCurve(load_gripper("prototype_p1")).wrap_for_radius(0.01)
    return folder


def test_there_is_a_misuse_of_every_command():
    assert {text.split()[0] for text in MISUSES} >= COMMANDS.keys() - {"calibrate", "design"}


@pytest.mark.timeout(60)  # a hang that costs no processor time
@pytest.mark.parametrize("text", MISUSES)
def test_a_misuse_is_answered_at_once_with_the_reason(text, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    before, begin = set(folder.iterdir()), time.process_time()
    assert run(shlex.split(text.format(folder=folder, **BEGINNINGS))) == 2  # raises defects
    assert time.process_time() - begin < TIME_LIMIT
    said = capsys.readouterr().err
    assert MISUSES[text] in " ".join(said.split())
    assert said.startswith(("spiral-gripper: ", "Usage: spiral-gripper "))
    assert "Errno" not in said
    assert " Pa" in text or re.search(r"\d Pa\b", said) is None  # the unit is that of the user
    assert set(folder.iterdir()) == before


def test_messages_are_in_the_units_that_were_typed():
    givens = {
        "radius_max": [TypedValue("--radius-max", 0.06, "6 cm", "LENGTH")],
        "radius_min": [TypedValue("--radius-min", 0.001, "1 mm", "LENGTH")],
        "pressure_max": [TypedValue("--pressure-max", 89631.0, "13 psi", "PRESSURE")],
    }
    too_thin = Message("too thin for the limit of {}", Quantity(162000.0, "Pa"))
    for error, expected in (
        (
            NotGrippableError(0.001, too_thin, -1.0, 0.00378219),
            (
                "an object of radius 1 mm cannot be gripped: too thin for the limit of 23.5 psi; "
                "the nearest grippable radius is 0.3783 cm"
            ),
        ),
        (NotGrippableError(0.5, "no", -1.0, None), "the object cannot be gripped: no"),
        (
            InvalidInputError("radius_max", 0.06, Message("at least {}", Quantity(0.1, "m"))),
            "--radius-max must be at least 10 cm, got 6 cm",
        ),
        (InvalidInputError("angle", 0.5, "1", "rad"), "angle must be 1, got 28.65 deg"),
    ):
        assert error_text(error, givens) == expected


def test_a_full_disk_is_said_in_one_line():
    for words in ("--help", BEGINNINGS["W"], "doctor nowhere"):
        with Path("/dev/full").open("w", encoding="utf-8") as full:
            done = subprocess.run(
                [sys.executable, "-m", "spiral_gripper.cli.main", *shlex.split(words)],
                stdout=full, stderr=subprocess.PIPE, text=True, check=False,
            )  # fmt: skip
        said = "spiral-gripper: the answer cannot be printed: the disk is full\n"
        assert (done.returncode, done.stderr) == (2, said)


def test_what_is_not_installed_is_said_with_the_remedy(said, monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    needed = said("studio prototype_p1 --no-browser", code=2)
    assert "the studio needs viser: pip install 'spiral-gripper[studio]'" in needed
    for module in [name for name in sys.modules if name.startswith("matplotlib")]:
        monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.delitem(sys.modules, "spiral_gripper.reports.plots", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    drawn = "--paper --save mine.yaml --plot mine.png"
    assert "spiral-gripper[plot]" in said(BEGINNINGS["D"], drawn, code=2)
    assert Path("mine.yaml").exists()


def test_defects_are_not_hidden(monkeypatch):
    monkeypatch.setattr("spiral_gripper.reports.wrap_document.solve_shape", None)
    with pytest.raises(TypeError, match="not callable"):
        run(["shape", "prototype_p1", "--pressure", "5 kPa"])
