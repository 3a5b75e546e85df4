# SPDX-License-Identifier: Apache-2.0
"""What tests of the command line share."""

from __future__ import annotations

import json

import pytest

from spiral_gripper.cli.main import run

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
