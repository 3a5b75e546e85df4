# SPDX-License-Identifier: Apache-2.0
"""The README is true: its Python runs and prints what it says, its commands exist."""

from __future__ import annotations

import contextlib
import io
import re
import shlex

import pytest
from click.testing import CliRunner
from repo.source_tree import ROOT, pyproject

from spiral_gripper.cli.main import spiral_gripper

README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
BLOCKS = [(match[1], match[2]) for match in BLOCK.finditer(README)]
SHELLS = {"bash", "console", "sh", "shell"}
TOOLS = {"cd", "colcon", "git", "make", "pip", "python", "python3", "ros2", "source", "."}


def python_blocks() -> list[tuple[str, str]]:
    """Return each Python block with the text block that follows it: what it should print."""
    following = [*BLOCKS, ("", "")][1:]
    return [
        (code, output if kind == "text" else "")
        for (language, code), (kind, output) in zip(BLOCKS, following, strict=True)
        if language == "python"
    ]


def commands() -> list[str]:
    """Return the lines of the shell blocks, without prompts and comments."""
    lines = "".join(text for language, text in BLOCKS if language in SHELLS).splitlines()
    return [line for raw in lines if (line := raw.removeprefix("$ ").split("#")[0].strip())]


def test_readme_has_python_and_commands() -> None:
    assert python_blocks()
    assert {"make demo", "make test"} <= set(commands())


def test_python_prints_what_the_readme_says() -> None:
    for code, output in python_blocks():
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, "README.md", "exec"), {"__name__": "__main__"})
        assert output.strip(), "a text block with what it prints follows each Python block"
        assert printed.getvalue().strip() == output.strip()


@pytest.mark.slow
def test_the_first_screen_has_what_its_command_prints() -> None:
    line = next(line for line in commands() if " grip paper_design_70" in line)
    printed = CliRunner().invoke(spiral_gripper, shlex.split(line)[1:], obj={}).output
    shown = next(text for kind, text in BLOCKS if kind == "text").splitlines()
    assert len(shown) >= 5
    assert [row for row in shown if row not in printed] == []


def test_make_targets_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([\w-]+):", makefile, re.MULTILINE))
    named = {match for line in commands() for match in re.findall(r"\bmake ([a-z-]+)", line)}
    named |= set(re.findall(r"`make ([a-z-]+)", README))
    assert named <= targets


def test_commands_exist() -> None:
    (stated,) = pyproject()["tool"]["dynamic-metadata"]
    scripts = {*stated["scripts"], *stated["ros-scripts"]}
    programs = {re.sub(r"^(\w+=\S+ )*", "", line).split()[0] for line in commands()}
    assert {program.rpartition("/")[2] or program for program in programs} <= scripts | TOOLS
