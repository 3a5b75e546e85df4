# SPDX-License-Identifier: Apache-2.0
"""The command line: help, what it says to who waits, Ctrl-C, the doctor."""

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
from spiral_gripper.cli.main import COMMANDS
from spiral_gripper.files.description import GRAVITY_MAX
from spiral_gripper.files.fields import LAWS


def started(*command):
    """Return a running program of Python, in a group of its own."""
    return subprocess.Popen(
        [sys.executable, *command],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip


def command(line):
    """Return the running command."""
    return started("-m", "spiral_gripper.cli.main", *line.split())


def test_help_loads_nothing_heavy():
    helps = [["--help"], *([name, "--help"] for name in COMMANDS)]
    code = (
        "import sys; from spiral_gripper.cli.main import run\n"
        f"for arguments in {helps}: run(arguments)\n"
        "print(*sys.modules, file=sys.stderr)"
    )
    printed, modules = started("-c", code).communicate()
    assert printed.count("Usage: spiral-gripper") == len(helps)
    assert all(f"  {name} " in printed for name in COMMANDS)
    assert not set(modules.split()) & {"numpy", "scipy", "numba", "matplotlib", "rich"}


def test_options_have_the_cores_defaults_and_limits():
    """They are stated twice, so that help loads nothing."""
    assert types.DEFAULT_TURNS == DEFAULT_TURNS
    assert types.FRICTION.convert("10", None, None) == FRICTION_MAX == float(types.FRICTION.most)
    assert types.ACCELERATION.most == f"{GRAVITY_MAX:g} m/s^2"
    assert tuple(LAWS) == calibrate.LAWS
    assert tuple(quantity.value for quantity in FittedQuantity) == calibrate.QUANTITIES
    assert (calibrate.DEFAULT_LEVEL, calibrate.DRAWS_MIN) == (DEFAULT_LEVEL, DRAWS_MIN)


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


# A terminal interrupts all of them; some commands end at once where no worker would be left.
@pytest.mark.parametrize(
    ("send", "before"), [(os.kill, "SIG_DFL"), (os.killpg, "default_int_handler")]
)
def test_an_interrupt_ends_a_sweep_and_its_workers_in_one_line(send, before):
    wait = "import time; from spiral_gripper.cli import workers\n"
    wait += "with workers.process_pool(2) as pool: list(pool.map(time.sleep, [60.0] * 4))"
    process = started(
        "-c",
        f"import signal, sys; signal.signal(signal.SIGINT, signal.{before})\n"
        "from spiral_gripper.cli import main\n"
        f"main.spiral_gripper.main = lambda **_: exec({wait!r})\n"
        "print('begin', flush=True); sys.exit(main.run([]))",
    )
    assert process.stdout.readline() == "begin\n"
    time.sleep(0.5)  # the workers start: the most delicate moment
    send(process.pid, signal.SIGINT)
    # Its standard error is closed once no worker holds it.
    assert process.communicate(timeout=120.0) == ("", "spiral-gripper: interrupted\n")


@pytest.mark.slow
def test_an_interrupted_sweep_prints_the_grips_that_are_done():
    radii = " ".join(f"--radius {mm}mm" for mm in range(20, 40))
    process = command(f"sweep grips paper_design_70 --jobs 1 {radii}")
    assert process.stderr.readline() == "solving ...\n"  # the first grip is done
    process.send_signal(signal.SIGINT)
    answer, said = process.communicate(timeout=300.0)
    assert process.returncode == 1
    assert " of 20 grips are done" in said
    assert ("20 mm" in answer, "39 mm" in answer) == (True, False)


def test_a_command_that_holds_nothing_ends_at_once():
    process = command("grip paper_design_70 --radius 20mm")
    assert "pulling" in process.stderr.readline()
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=10.0) == ("", "")
    assert process.returncode == -signal.SIGINT


@pytest.mark.long
def test_the_doctor_finds_a_working_installation_well():
    process = command("doctor prototype_p1 --json")
    document = json.loads(process.communicate()[0])
    assert document["problems"] == process.returncode == 0
    found = {each["name"]: each["text"] for each in document["checks"]}
    assert list(found) == ["versions", "kernels", "prototype_p1", "grip", "node"]
    assert "an object of 9.604 mm" in found["grip"]
    node = "an object of 9.604 mm" if find_spec("rclpy") else "not installed"
    assert node in found["node"]


@pytest.mark.long
def test_the_doctor_names_what_fails_and_ends_there(answer, monkeypatch):
    def fail():
        raise SystemExit(3)

    monkeypatch.setattr(doctor, "check_kernels", fail)
    document = answer("doctor .", code=1)
    _, kernels, file = (each["text"] for each in document["checks"])
    assert document["problems"] == 2
    assert "SystemExit: 3" in kernels
    assert "it is a folder" in file
