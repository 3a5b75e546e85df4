# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C: at once, between two steps, and with worker processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest


def test_an_interrupt_ends_a_sweep_in_one_line() -> None:
    wait = "import time; from spiral_gripper.cli import workers\n"
    wait += "with workers.process_pool(2) as pool: list(pool.map(time.sleep, [60.0] * 4))"
    code = (
        "import sys, click; from spiral_gripper.cli import main\n"
        f"main.spiral_gripper.main = lambda **_: exec({wait!r})\n"
        "print('begin', flush=True); sys.exit(main.run([]))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "begin\n"
    time.sleep(0.5)  # the workers start: the most delicate moment
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to all of them
    _, said = process.communicate(timeout=120.0)
    assert said == "spiral-gripper: interrupted\n"


@pytest.mark.slow
def test_an_interrupted_sweep_prints_the_grips_that_are_done() -> None:
    radii = [part for mm in range(20, 40) for part in ("--radius", f"{mm} mm")]
    sweep = ["sweep", "grips", "paper_design_70", *radii, "--jobs", "1"]
    process = started(*sweep)
    assert process.stderr is not None
    assert process.stderr.readline() == "solving ...\n"  # the first grip is done
    process.send_signal(signal.SIGINT)
    answer, said = process.communicate(timeout=300.0)
    assert process.returncode == 1
    assert " of 20 grips are done" in said
    assert "20 mm" in answer
    assert "39 mm" not in answer


def test_a_command_that_holds_nothing_ends_at_once() -> None:
    process = started("grip", "paper_design_70", "--radius", "20 mm")
    assert process.stderr is not None
    assert "pulling" in process.stderr.readline()
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=10.0) == ("", "")
    assert process.returncode == -signal.SIGINT


def started(*command: str) -> subprocess.Popen[str]:
    """Return a running command."""
    return subprocess.Popen(
        [sys.executable, "-m", "spiral_gripper.cli.main", *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
