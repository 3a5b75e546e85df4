# SPDX-License-Identifier: Apache-2.0
"""`spiral-gripper plan | grasp | release | status | watch`, to a node in a process of its own."""

import json
import re
import shlex
import signal
import subprocess
import sys
from types import SimpleNamespace

import pytest
from ros.control_bench import rows
from ros.harness import DEADLINE

from spiral_gripper.cli.main import run
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.tools import commands

COMMAND = "import sys; from spiral_gripper.cli.main import run; sys.exit(run(sys.argv[1:]))"


@pytest.fixture
def ask(active, capsys):
    """Run a command for the node; return exit code, output and kind."""

    def asked(*arguments):
        code = run([*arguments, "--namespace", active.get_namespace()])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    assert active.set_parameter("pressure.settle_time", 0.1).successful
    return asked


def started(*arguments):
    return subprocess.Popen(
        [sys.executable, "-c", COMMAND, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


PLAN = ("plan", "--radius", "20 mm")
HELD = (*PLAN, "--overpressure", "3 kPa", "--friction", "0.4", "--payload")
SLOW = pytest.mark.slow


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (PLAN, 0, r"57\.0[\s\S]+1\.96"),
        ((*PLAN, "--json"), 0, r'"pressure": 57\d\d\d\.'),
        (("plan", "--radius", "60 mm"), 1, "cannot be gripped"),
        (("grasp", "--radius", "60 mm", "--json"), 1, '"reason": "RADIUS_TOO_LARGE"'),
        pytest.param((*HELD, "5 g"), 0, r"0\.005 kg held with 0\.\d+ N", marks=SLOW),
        pytest.param((*HELD, "2 kg"), 1, "payload          2 kg NOT held", marks=SLOW),
    ],
)
def test_an_answer_says_whether_and_with_what_and_moves_nothing(
    active, ask, arguments, code, words
):
    got, out, _ = ask(*arguments)
    assert got == code
    assert re.search(words, out), out
    assert active.pressures[-1] == 0.0


def test_grasp_holds_when_it_has_ended_and_release_lets_go(active, ask):
    code, out, _ = ask("grasp", "--radius", "20 mm", "--overpressure", "1 kPa")
    assert (code, "wraps 20 mm at " in out) == (0, True)
    active.wait_for_state(State.GRASPING)
    active.wait_until(lambda: active.pressures[-1] > 5.0e4, "its pressure")
    code, out, _ = ask("status")
    assert (code, "wrapped          yes" in out) == (0, True)
    code, out, _ = ask("release")
    assert (code, "vented, as commanded" in out) == (0, True)
    active.wait_until(lambda: active.pressures[-1] == 0.0, "the vent")
    assert ask("status")[0] == 0  # released on purpose: no trouble


def test_a_release_whose_pressure_stays_is_exit_code_1(active):
    active.regulator = lambda pressure: 4.0e4
    active.wait_until(lambda: active.status.measured_pressure, "the measured pressure")
    for arguments, words in ((("release", "--timeout", "0.5"), "still 40 kPa"), (("status",), "")):
        with started(*arguments, "--namespace", active.get_namespace()) as end:
            active.wait_until(lambda end=end: end.poll() is not None, "the end")
            assert end.returncode == 1  # PRESSURE_HIGH
            assert words in end.stdout.read()


def test_ctrl_c_cancels_the_grasp(active):
    assert active.set_parameter("pressure.rate_up", 500.0).successful
    with started("grasp", "--radius", "20 mm", "--namespace", active.get_namespace()) as grasp:
        active.wait_until(
            lambda: active.status.state == State.GRASPING and active.pressures[-1] > 0.0,
            "the grasp",
        )
        grasp.send_signal(signal.SIGINT)
        active.wait_for_state(State.RELEASED)
        assert grasp.wait(DEADLINE) == 2
        assert "interrupted" in grasp.stdout.read()
    active.wait_until(lambda: active.pressures[-1] == 0.0, "the vent")


def test_watch_shows_the_node_and_ends_in_time(active):
    active.wrap(0.02)
    for duration in ("2", "10", "60"):  # within which it finds the node, however busy the machine
        with started(
            "watch", "--duration", duration, "--namespace", active.get_namespace()
        ) as watch:
            active.wait_until(lambda watch=watch: watch.poll() is not None, "the end")
            shown = watch.stdout.read()
        assert watch.returncode == 0, shown
        if "57.0" in shown:
            break
    assert "57.0" in shown
    assert "tracking" in shown


@pytest.mark.parametrize(
    "arguments", [["plan", "--radius", "20 mm"], ["grasp"], ["release"], ["status"]]
)
def test_no_node_is_exit_code_2_and_says_how_to_start_one(monkeypatch, capsys, arguments):
    monkeypatch.setattr(commands, "DISCOVERY_TIMEOUT", 0.3)
    assert run([*arguments, "--namespace", "/nobody"]) == 2
    assert "spiral_gripper_node --ros-args -r __ns:=/nobody" in capsys.readouterr().err


REFUSED = """
plan -> --radius
plan --radius '-20 mm' -> must be above 0, got '-20 mm'
grasp --overpressure '-1 kPa' -> must be at least 0, got '-1 kPa'
grasp --timeout nan -> --timeout
watch --duration 0 -> must be above 0
simulate --radius '0 mm' -> above 0 and at most 1 m
simulate --namespace a//b -> single /
simulate --namespace '' -> --namespace
simulate --fault typhoon -> stuck_valve
"""


@pytest.mark.parametrize("row", rows(REFUSED))
def test_what_cannot_be_is_refused_in_one_line_before_anything_is_sent(capsys, row):
    arguments, words = row.split(" -> ")
    assert run(shlex.split(arguments)) == 2
    captured = capsys.readouterr()
    assert words in captured.err
    assert (captured.out, captured.err.count("\n")) == ("", 1)


def test_json_has_null_for_what_is_no_number(monkeypatch, capsys):
    document = {"pressure": float("nan"), "forces": [1.0, float("inf")]}
    answer = SimpleNamespace(document=document, lines=[], good=True)
    monkeypatch.setattr(commands, "status", lambda namespace: answer)
    assert run(["status", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"pressure": None, "forces": [1.0, None]}
