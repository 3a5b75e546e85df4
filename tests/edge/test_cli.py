# SPDX-License-Identifier: Apache-2.0
"""The command line: help, what it says to who waits, Ctrl-C, the doctor."""

import io
import json
import os
import signal
import subprocess
import sys
import time
from importlib.util import find_spec

import pytest

from spiral_core import FittedQuantity
from spiral_core.calibration.regression import DEFAULT_LEVEL
from spiral_core.calibration.uncertainty import DRAWS_MIN
from spiral_core.wrap.gripper import DEFAULT_TURNS, FRICTION_MAX
from spiral_gripper.cli import calibrate, doctor, types
from spiral_gripper.cli import main as main_module
from spiral_gripper.cli.main import COMMANDS
from spiral_gripper.cli.output import waiting
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper.files.description import GRAVITY_MAX
from spiral_gripper.files.fields import LAWS


def started(*command):
    """Return a running program of Python, in a group of its own."""
    return subprocess.Popen(
        [sys.executable, *command],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip


def test_help_loads_nothing_heavy():
    helps = [["--help"], *([name, "--help"] for name in COMMANDS)]
    code = (
        "import sys; from spiral_gripper.cli.main import run\n"
        f"for arguments in {helps}: run(arguments)\n"
        "print(*sys.modules, file=sys.stderr)"
    )
    printed, modules = started("-c", code).communicate()
    assert printed.count("Usage: spiral-gripper") == len(helps)
    assert all(
        f"  {name} " in printed and entry.help in printed for name, entry in COMMANDS.items()
    )
    assert not set(modules.split()) & {"numpy", "scipy", "numba", "matplotlib", "rich"}
    light = {"spiral_core.lazy", "spiral_core.notice"}
    assert {name for name in modules.split() if name.startswith("spiral_core.")} == light


def test_groups_have_help_in_full(said):
    for group in ("sweep", "chart", "grippers"):
        assert "..." not in said(group, "--help").partition("Commands:")[2]
    for group in ([], ["sweep"]):
        usage, commands, _ = said(*group, code=2).partition(" Commands: ")
        assert usage.startswith(" ".join(["Usage: spiral-gripper", *group]))
        assert commands
    assert said("--version").startswith("spiral-gripper 0.")


def test_options_have_the_cores_defaults_and_limits():
    """They are stated twice, so that help loads nothing."""
    assert types.DEFAULT_TURNS == DEFAULT_TURNS
    assert types.FRICTION.convert("10", None, None) == FRICTION_MAX == float(types.FRICTION.most)
    assert types.ACCELERATION.most == f"{GRAVITY_MAX:g} m/s^2"
    assert tuple(LAWS) == calibrate.LAWS
    assert tuple(quantity.value for quantity in FittedQuantity) == calibrate.QUANTITIES
    assert (calibrate.DEFAULT_LEVEL, calibrate.DRAWS_MIN) == (DEFAULT_LEVEL, DRAWS_MIN)


class Terminal(io.StringIO):
    """Standard error as a person at a terminal has it."""

    def isatty(self):
        return True


def test_who_waits_for_a_compilation_is_told_once():
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
    before, after = started("-c", code).communicate()[0].splitlines()
    assert (before, after.count("compiling the solver, once")) == ("''", 1)


@pytest.mark.parametrize(("command", "patience"), [("wrap", 240.0), ("watch", 0.2)])
def test_who_waits_at_a_terminal_is_told_what_for(monkeypatch, command, patience):
    screen = Terminal()

    def wait(_):
        end = time.monotonic() + patience
        while not screen.getvalue() and time.monotonic() < end:
            time.sleep(0.01)

    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(sys, "argv", ["spiral-gripper", command])
    monkeypatch.setattr(main_module, "PATIENCE", 0.0)
    monkeypatch.setattr(main_module, "run", wait)
    monkeypatch.setattr(signal, "getsignal", lambda _: None)  # else Ctrl-C would end this process
    with pytest.raises(SystemExit):
        main_module.main()
    assert ("computing" in screen.getvalue()) is (command == "wrap")


@pytest.mark.parametrize(("quiet", "said"), [(True, ""), (False, "closing ...\n")])
def test_a_quiet_wait_prints_nothing(capsys, quiet, said):
    with waiting("closing", quiet=quiet):
        pass
    assert capsys.readouterr().err == said


def test_an_interrupt_ends_a_sweep_in_one_line():
    wait = "import time; from spiral_gripper.cli import workers\n"
    wait += "with workers.process_pool(2) as pool: list(pool.map(time.sleep, [60.0] * 4))"
    process = started(
        "-c",
        "import sys, click; from spiral_gripper.cli import main\n"
        f"main.spiral_gripper.main = lambda **_: exec({wait!r})\n"
        "print('begin', flush=True); sys.exit(main.run([]))",
    )
    assert process.stdout.readline() == "begin\n"
    time.sleep(0.5)  # the workers start: the most delicate moment
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to all of them
    _, said = process.communicate(timeout=120.0)
    assert said == "spiral-gripper: interrupted\n"


@pytest.mark.slow
def test_an_interrupted_sweep_prints_the_grips_that_are_done():
    radii = [part for mm in range(20, 40) for part in ("--radius", f"{mm} mm")]
    sweep = ["sweep", "grips", "paper_design_70", *radii, "--jobs", "1"]
    process = started("-m", "spiral_gripper.cli.main", *sweep)
    assert process.stderr.readline() == "solving ...\n"  # the first grip is done
    process.send_signal(signal.SIGINT)
    answer, said = process.communicate(timeout=300.0)
    assert process.returncode == 1
    assert " of 20 grips are done" in said
    assert ("20 mm" in answer, "39 mm" in answer) == (True, False)


@pytest.mark.slow
def test_a_command_with_workers_ends_them_too(tmp_path):
    mine = tmp_path / "mine.yaml"
    mine.write_text((GRIPPERS.path / "prototype_p1.yaml").read_text())
    process = started("-m", "spiral_gripper.cli.main", "grip", str(mine), "--table")
    assert "pulling" in process.stderr.readline()  # the first grip is done
    process.send_signal(signal.SIGINT)
    # Its standard error is closed once no worker holds it.
    answer, said = process.communicate(timeout=60.0)
    assert (answer, said.strip()) == ("", "spiral-gripper: interrupted")
    assert [each.name for each in tmp_path.iterdir()] == ["mine.yaml"]


def test_a_command_that_holds_nothing_ends_at_once():
    grip = ["grip", "paper_design_70", "--radius", "20 mm"]
    process = started("-m", "spiral_gripper.cli.main", *grip)
    assert "pulling" in process.stderr.readline()
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=10.0) == ("", "")
    assert process.returncode == -signal.SIGINT


@pytest.mark.long
def test_the_doctor_finds_a_working_installation_well():
    process = started("-m", "spiral_gripper.cli.main", "doctor", "prototype_p1", "--json")
    document = json.loads(process.communicate()[0])
    assert document["problems"] == process.returncode == 0
    found = {each["name"]: each["text"] for each in document["checks"]}
    assert list(found) == ["versions", "kernels", "prototype_p1", "grip", "node"]
    assert "tip criterion for radii from 2.59" in found["prototype_p1"]
    assert "an object of 9.604 mm" in found["grip"]
    node = "an object of 9.604 mm" if find_spec("rclpy") else "not installed"
    assert node in found["node"]


@pytest.mark.long
def test_the_doctor_names_what_fails_and_ends_there(answer, monkeypatch, tmp_path):
    def fail(*_):
        raise SystemExit(3)

    path = tmp_path / "mine.yaml"
    path.write_text("name: mine\n")
    monkeypatch.setattr(doctor, "check_kernels", fail)
    document = answer("doctor", str(path), code=1)
    _, kernels, file = (each["text"] for each in document["checks"])
    assert document["problems"] == 2
    assert "SystemExit: 3" in kernels
    assert "tube.length" in file
