# SPDX-License-Identifier: Apache-2.0
"""Commands as programs and as people have them."""

import json

import pytest

from spiral_gripper.cli.main import run


@pytest.fixture
def answer(capsys):
    """Return a function that gives the JSON that a command prints."""

    def answer(*arguments, code=0):
        assert run([*arguments, "--json"]) == code
        return json.loads(capsys.readouterr().out)

    return answer


@pytest.fixture
def said(capsys):
    """Return a function that gives what a command prints for people, in one line."""

    def said(*arguments, code=0):
        assert run(arguments) == code
        return " ".join("".join(capsys.readouterr()).split())

    return said
