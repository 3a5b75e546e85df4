# SPDX-License-Identifier: Apache-2.0
"""Commands as programs and as people have them, each test in a folder of its own."""

import json
import shlex
import shutil
from pathlib import Path

import pytest

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
