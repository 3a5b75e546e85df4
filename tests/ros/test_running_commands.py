# SPDX-License-Identifier: Apache-2.0
"""`spiral-gripper plan | grasp | release | status | watch`, to a node in a process of its own."""

import json
import re
import signal
import subprocess
import sys

import pytest
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


def test_plan_says_whether_and_with_what_and_moves_nothing(active, ask):
    code, out, _ = ask("plan", "--radius", "20 mm")
    assert code == 0
    assert "57.0" in out
    assert "1.96" in out
    code, out, _ = ask("plan", "--radius", "60 mm")
    assert code == 1
    assert "cannot be gripped" in out
    code, out, _ = ask("plan", "--radius", "20 mm", "--json")
    document = json.loads(out)
    assert document["success"]
    assert document["pressure"] == pytest.approx(57.0e3, rel=1e-3)
    assert active.pressures[-1] == 0.0


@pytest.mark.slow
def test_plan_computes_whether_a_payload_is_held(active, ask):
    asked = ("plan", "--radius", "20 mm", "--overpressure", "3 kPa", "--friction", "0.4")
    code, out, _ = ask(*asked, "--payload", "5 g")
    assert code == 0, out
    assert "for friction 0.4" in out
    assert re.search(r"payload +0.005 kg held with 0\.\d+ N to spare", out), out
    code, out, _ = ask(*asked, "--payload", "2 kg")
    assert code == 1
    assert "payload          2 kg NOT held" in out
    assert active.pressures[-1] == 0.0


def test_grasp_holds_when_it_has_ended_and_release_lets_go(active, ask):
    code, out, _ = ask("grasp", "--radius", "20 mm", "--overpressure", "1 kPa")
    assert code == 0, out
    assert "wraps 20 mm at " in out
    active.wait_for_state(State.GRASPING)
    active.wait_until(lambda: active.pressures[-1] > 5.0e4, "its pressure")
    code, out, _ = ask("status")
    assert (code, "wrapped          yes" in out) == (0, True)
    code, out, _ = ask("release")
    assert (code, "vented, as commanded" in out) == (0, True)
    active.wait_for_state(State.RELEASED)
    active.wait_until(lambda: active.pressures[-1] == 0.0, "the vent")
    assert ask("status")[0] == 0  # released on purpose: no trouble


def test_a_grasp_that_cannot_be_is_exit_code_1_with_the_reason(ask):
    code, out, _ = ask("grasp", "--radius", "60 mm", "--json")
    document = json.loads(out)
    assert (code, document["outcome"], document["reason"]) == (1, "failed", "RADIUS_TOO_LARGE")


def test_a_release_whose_pressure_stays_is_exit_code_1(active, ask):
    active.regulator = lambda pressure: 4.0e4
    active.wait_until(lambda: active.status.measured_pressure, "the measured pressure")
    end = started("release", "--timeout", "0.5", "--namespace", active.get_namespace())
    active.wait_until(lambda: end.poll() is not None, "the end")
    assert end.returncode == 1
    assert "still 40 kPa" in end.stdout.read()
    end.stdout.close()
    code, out, _ = ask("status", "--json")
    assert (code, json.loads(out)["measured_pressure"]) == (
        1,
        pytest.approx(4.0e4),
    )  # PRESSURE_HIGH


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


@pytest.mark.parametrize(
    ("arguments", "kind"),
    [
        (["plan"], "--radius"),
        (["plan", "--radius", "-20 mm"], "must be above 0, got '-20 mm'"),
        (["plan", "--radius", "20"], "unit"),
        (["grasp", "--overpressure", "-1 kPa"], "must be at least 0, got '-1 kPa'"),
        (["grasp", "--timeout", "nan"], "--timeout"),
        (["release", "--timeout", "-1"], "must be above 0, got '-1'"),
        (["status", "--namespace", "a b"], "--namespace"),
        (["watch", "--duration", "0"], "must be above 0"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_sent(capsys, arguments, kind):
    assert run(arguments) == 2
    assert kind in capsys.readouterr().err
