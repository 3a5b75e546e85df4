# SPDX-License-Identifier: Apache-2.0
"""The command line: help, version, and what it says to who waits."""

from __future__ import annotations

import io
import subprocess
import sys
import time

import pytest

from spiral_gripper.cli import main as main_module
from spiral_gripper.cli import types
from spiral_gripper.cli.main import COMMANDS, run


def test_help_loads_nothing_heavy() -> None:
    helps = [["--help"], *([name, "--help"] for name in COMMANDS)]
    code = (
        "import sys; from spiral_gripper.cli.main import run\n"
        f"for arguments in {helps}: run(arguments)\n"
        "print(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.count("Usage: spiral-gripper") == len(helps)
    loaded = set(done.stderr.split())
    assert not loaded & {"numpy", "scipy", "numba", "matplotlib", "rich"}
    light = {"spiral_core.lazy", "spiral_core.notice"}
    assert {name for name in loaded if name.startswith("spiral_core.")} == light


@pytest.mark.parametrize("group", ["sweep", "chart", "grippers"])
def test_help_of_a_group_tells_every_command_in_full(
    capsys: pytest.CaptureFixture[str], group: str
) -> None:
    assert run([group, "--help"]) == 0
    assert "..." not in capsys.readouterr().out.partition("Commands:")[2]


def test_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--help"]) == 0
    text = capsys.readouterr().out
    assert all(f"  {name} " in text and entry.help in text for name, entry in COMMANDS.items())


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out.startswith("spiral-gripper 0.")


@pytest.mark.parametrize("group", [[], ["sweep"], ["chart"]])
def test_no_command_shows_the_help(capsys: pytest.CaptureFixture[str], group: list[str]) -> None:
    assert run(group) == 2
    said = capsys.readouterr().err
    assert said.startswith(" ".join(["Usage: spiral-gripper", *group]))
    assert "\nCommands:\n" in said


def test_options_have_the_cores_defaults_and_limits() -> None:
    from spiral_core.wrap.gripper import DEFAULT_TURNS, FRICTION_MAX
    from spiral_gripper.files.description import GRAVITY_MAX

    assert types.DEFAULT_TURNS == DEFAULT_TURNS
    assert types.FRICTION.convert("10", None, None) == FRICTION_MAX
    assert types.FRICTION.most == "10"
    assert types.ACCELERATION.most == f"{GRAVITY_MAX:g} m/s^2"


class Terminal(io.StringIO):
    """Standard error as a person at a terminal has it."""

    def isatty(self) -> bool:
        return True


def test_who_waits_for_a_compilation_is_told_once() -> None:
    """By what imports the edge, command or script: the core prints nothing."""
    code = """
import io, sys
class Terminal(io.StringIO):
    def isatty(self): return True
sys.stderr = Terminal()
import spiral_gripper
assert "numba" not in sys.modules
import spiral_core.numerics.kernel
from numba import njit
@njit
def twice(x): return x + x
print(repr(sys.stderr.getvalue()))
twice(1), twice(1.0)
print(repr(sys.stderr.getvalue()))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    before, after = done.stdout.splitlines()
    assert before == "''"
    assert after.count("compiling the solver, once") == 1


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
    assert ("computing" in screen.getvalue()) is told
