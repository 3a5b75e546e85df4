# SPDX-License-Identifier: Apache-2.0
"""Misuses of every command: each is answered at once, in a line, with why; defects are not."""

import re
import shlex
import subprocess
import sys
import time
from pathlib import Path

import pytest
from edge.recorded import cases

from spiral_core import WrapCurve
from spiral_gripper import load_gripper
from spiral_gripper.cli.main import COMMANDS, run
from spiral_gripper.files.catalog import GRIPPERS

# Far more than any answer needs on a busy machine [s].
TIME_LIMIT = 10.0
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


@pytest.fixture(scope="module", autouse=True)
def _compiled():
    """Compile first, where that was never done: it takes longer than an answer may."""
    WrapCurve(load_gripper("prototype_p1")).wrap_for_radius(0.01)


def test_there_is_a_misuse_of_every_command():
    assert {asked.split()[0] for asked in cases("misuses.txt")} >= COMMANDS.keys()


@pytest.mark.timeout(60)  # a hang that costs no processor time
@pytest.mark.parametrize("asked", cases("misuses.txt"))
def test_a_misuse_is_answered_at_once_with_the_reason(asked, recorded):
    Path("folder.png").mkdir()
    for name, text in FILES.items():
        Path(name).write_text(text, "utf-8")
    begin = time.process_time()
    lines = recorded("misuses.txt", asked)  # raises defects
    assert time.process_time() - begin < TIME_LIMIT
    said = lines[lines.index("exit code 2") + 1 :]
    assert said[0].startswith(("spiral-gripper: ", "Usage: spiral-gripper "))
    for line in said:
        assert "Errno" not in line
        # The unit is that of the user.
        assert " Pa" in asked or re.search(r"\d Pa\b", line) is None


def test_a_full_disk_is_said_in_one_line():
    for words in ("--help", "wrap prototype_p1 --radius 9mm", "doctor nowhere"):
        with Path("/dev/full").open("w", encoding="utf-8") as full:
            done = subprocess.run(
                [sys.executable, "-m", "spiral_gripper.cli.main", *shlex.split(words)],
                stdout=full, stderr=subprocess.PIPE, text=True, check=False,
            )  # fmt: skip
        said = "spiral-gripper: the answer cannot be printed: the disk is full\n"
        assert (done.returncode, done.stderr.lstrip()) == (2, said)


def test_what_is_not_installed_is_said_with_the_remedy(said, monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    needed = said("studio prototype_p1 --no-browser", code=2)
    assert "the studio needs viser: pip install 'spiral-gripper[studio]'" in needed
    for module in [name for name in sys.modules if name.startswith("matplotlib")]:
        monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.delitem(sys.modules, "spiral_gripper.reports.plots", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    design = "design --radius-min 11mm --radius-max 30mm --tube '3/8 in x 1/32 in' --paper"
    assert "spiral-gripper[plot]" in said(design, "--save mine.yaml --plot mine.png", code=2)
    assert Path("mine.yaml").exists()


def test_defects_are_not_hidden(monkeypatch):
    monkeypatch.setattr("spiral_gripper.reports.wrap_document.solve_shape", None)
    with pytest.raises(TypeError, match="not callable"):
        run(["shape", "prototype_p1", "--pressure", "5 kPa"])
