# SPDX-License-Identifier: Apache-2.0
"""Commands as programs and as people have them, each test in a folder of its own."""

import json
import re
import shlex
import shutil
from pathlib import Path

import pytest
from edge.recorded import check, document, picture
from matplotlib.figure import Figure
from repo.source_tree import ROOT

from spiral_gripper.cli.main import run
from spiral_gripper.files.catalog import GRIPPERS


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def answer(capsys):
    """Return a function that gives the JSON that a command prints; its words follow each other."""

    def answer(*words, code=0):
        assert run([*shlex.split(" ".join(words)), "--json"]) == code
        printed, said = capsys.readouterr()
        assert " ...\n" not in said
        return json.loads(printed)

    return answer


@pytest.fixture
def said(capsys):
    """Return a function that gives what a command prints for people, in one line."""

    def said(*words, code=0):
        assert run(shlex.split(" ".join(words))) == code
        return " ".join("".join(capsys.readouterr()).split())

    return said


@pytest.fixture
def mine():
    """Return a description file of our own."""
    return Path(shutil.copy(GRIPPERS.path / "paper_design_70.yaml", "mine.yaml"))


@pytest.fixture
def recorded(capsys, monkeypatch):
    """Return a function that compares what a command prints, writes and draws with a record."""
    drawn, savefig = [], Figure.savefig

    def saved(figure, file, **options):
        if options["format"] == "rgba":  # of an animation
            drawn.append(f"frame {figure.get_suptitle()}")
            return savefig(figure, file, **options)
        drawn.extend((f"{options['format']}, {options.get('dpi')} dpi", *picture(figure)))
        return file.write(b"a picture")

    monkeypatch.setattr(Figure, "savefig", saved)
    monkeypatch.setenv("COLUMNS", "400")
    shutil.copytree(ROOT / "examples" / "data", "data")

    def recorded(name, case, asked=""):
        before = set(Path().iterdir())
        code = run(shlex.split(asked or case))
        printed, said = capsys.readouterr()
        is_json = printed.startswith(("{", "["))
        lines = [*document(json.loads(printed))] if is_json else plain(printed)
        lines += [f"exit code {code}"] * bool(code) + plain(said)
        for path in sorted(set(Path().iterdir()) - before):
            lines.append(f"file {path}")
            if path.suffix in (".md", ".yaml"):
                lines += plain(path.read_text("utf-8"))
        found = [line.replace(str(ROOT), "") for line in (*lines, *drawn)]
        check(name, case, found)
        drawn.clear()
        return found

    return recorded


def plain(text):
    """Return lines without frames and with one space between columns."""
    lines = (" ".join(re.split(r"[\s\u2500-\u257f]+", line)).strip() for line in text.splitlines())
    return [line for line in lines if line]
