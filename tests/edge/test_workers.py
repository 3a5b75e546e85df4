# SPDX-License-Identifier: Apache-2.0
"""Where sweeps run: Ctrl-C ends the workers quietly, a Dask cluster answers alike."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from spiral_gripper.cli.main import run

SWEEP = [
    "sweep", "pareto", "--radius-min", "11 mm", "--radius-max", "30 mm",
    "--tube", "3/8 in x 1/32 in", "--beta", "70 deg", "--beta", "80 deg",
]  # fmt: skip


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


def test_a_dask_cluster_gives_the_same_answers(capsys: pytest.CaptureFixture[str]) -> None:
    from distributed import LocalCluster

    assert run([*SWEEP, "--json", "--jobs", "1"]) == 0
    here = json.loads(capsys.readouterr().out)
    with LocalCluster(n_workers=1, processes=False, dashboard_address=None) as cluster:
        assert run([*SWEEP, "--json", "--scheduler", cluster.scheduler_address]) == 0
    assert json.loads(capsys.readouterr().out) == here


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense", "tcp://:x"])
def test_a_scheduler_that_does_not_answer_is_named(
    address: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("spiral_gripper.cli.workers.SCHEDULER_TIMEOUT", "0.5s")
    assert run([*SWEEP, "--scheduler", address]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert said == f"spiral-gripper: no Dask scheduler answers at --scheduler {address}"


def test_one_place_to_work_is_enough(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*SWEEP, "--scheduler", "tcp://127.0.0.1:1", "--jobs", "2"]) == 2
    assert "--jobs and --scheduler exclude each other" in capsys.readouterr().err
