# SPDX-License-Identifier: Apache-2.0
"""`spiral-gripper plan | grasp | release | status | watch`, to a node in a process of its own."""

import re
import shlex
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from unittest.mock import MagicMock

import pytest
import yaml
from rclpy.action import ActionServer
from rclpy.task import Future
from ros.control_bench import rows
from ros.harness import wait_until
from ros.programs import PROGRAM, rest_of, start
from ros.records import agrees
from std_msgs.msg import Float64, String

from spiral_gripper.cli.main import run
from spiral_gripper_msgs.action import Release
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.client.answers import NoAnswerError
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.messages.qos import LATEST
from spiral_gripper_ros.tools import commands
from spiral_gripper_ros.tools.watcher import Watcher


@pytest.fixture
def ask(active, capsys):
    """Run a command for the node, whose client goes on meanwhile; return exit code and output."""

    def asked(line):
        given = [*shlex.split(line), "--namespace", active.get_namespace()]
        with ThreadPoolExecutor() as pool:
            code = pool.submit(run, given)
            active.wait_until(code.done, "the end")
        return code.result(), capsys.readouterr().out

    active.change("pressure.settle_time", 0.1)
    return asked


# Command, exit code, what is said.
ANSWERS = r"""
plan -> 0 57\.0[\s\S]+1\.96
plan --json -> 0 "pressure": 57\d\d\d\.
plan --radius '60 mm' -> 1 cannot be gripped
grasp --radius '60 mm' --json -> 1 "reason": "RADIUS_TOO_LARGE"
"""
HELD = r"""
plan --overpressure '3 kPa' --friction 0.4 --payload '5 g' -> 0 0\.005 kg held with 0\.\d+ N
plan --overpressure '3 kPa' --friction 0.4 --payload '2 kg' -> 1 payload          2 kg NOT held
"""
SLOW = [pytest.param(row, marks=pytest.mark.slow) for row in rows(HELD)]


@pytest.mark.parametrize("row", [*rows(ANSWERS), *SLOW])
def test_an_answer_says_whether_and_with_what_and_moves_nothing(active, ask, row):
    line, expected = row.split(" -> ")
    code, said = ask(line.replace("plan", "plan --radius '20 mm'"))
    assert (str(code), bool(re.search(expected[2:], said))) == (expected[0], True), said
    assert active.pressures[-1] == 0.0


def test_grasp_holds_when_it_has_ended_and_release_lets_go(active, ask):
    for line, words, state in (
        ("grasp --radius '20 mm' --overpressure '1 kPa'", "wraps 20 mm at ", State.GRASPING),
        ("status", "wrapped          yes", State.GRASPING),
        ("release", "vented, as commanded", State.RELEASED),
        ("status", "RELEASED", State.RELEASED),  # on purpose: no trouble
    ):
        code, said = ask(line)
        assert (code, words in said) == (0, True), said
        active.wait_for_state(state)
        active.wait_until(
            lambda held=state is State.GRASPING: (active.pressures[-1] > 5.0e4) is held, line
        )


def test_a_release_whose_pressure_stays_is_exit_code_1(active, ask):
    active.regulator = lambda pressure: 4.0e4
    active.wait_until(lambda: active.status.measured_pressure, "the measured pressure")
    for line, words in (("release --timeout 0.5", "still 40 kPa"), ("status", "PRESSURE_HIGH")):
        code, said = ask(line)
        assert (code, words in said) == (1, True), said


def test_ctrl_c_cancels_the_grasp(active):
    active.change("pressure.rate_up", 500.0)
    space = active.get_namespace()
    with start(PROGRAM, "grasp", "--radius", "20 mm", "--namespace", space) as process:
        active.wait_until(
            lambda: active.status.state == State.GRASPING and active.pressures[-1] > 0.0, "it"
        )
        for _ in range(20):  # a key that is held down
            process.send_signal(signal.SIGINT)
            time.sleep(1e-3)
        code, said = rest_of(process)
    assert (code, "interrupted" in said) == (2, True), said
    active.wait_for_state(State.RELEASED)
    active.wait_for_vent()


def test_watch_shows_the_node_and_ends_in_time(active, ask):
    active.wrap(0.02)
    for duration in (2, 10, 60):  # within which it finds the node, however busy the machine
        code, said = ask(f"watch --duration {duration}")
        assert code == 0
        if "57.0" in said:
            break
    assert "57.0" in said
    assert "tracking" in said


# What is heard, as far as it is: nothing at first.
HEARD = """
- {}
- status: {state: 2, object_radius: [0.02], wrapped: true, regime: 2}
  pressure_command: {data: 5.7e+4}
- pressure_command: {data: 5.8e+4}
- {simulated/object_radius: {data: 0.021}, simulated/grip: {data: curling}}
- {measured_pressure: {data: 4.0e+4}, status: {state: 3, reason: 5, reason_text: needs 61000 Pa}}
- status: {state: 0, reason: 100, reason_text: not active, fault: 201, fault_text: a leak}
- status: {state: 7, reason: 201, reason_text: a leak, fault: 201, fault_text: a leak}
"""
KINDS = {"status": GripStatus, "simulated/grip": String}


def test_what_a_watcher_shows_is_that_on_record(namespace, monkeypatch, capsys):
    with closing(Watcher(namespace)) as watcher:
        heard, found = {}, []
        monkeypatch.setattr(watcher, "newest", lambda topic, *_: heard.get(topic))
        for number, messages in enumerate(yaml.safe_load(HEARD)):
            heard |= {name: KINDS.get(name, Float64)(**of) for name, of in messages.items()}
            watcher.show(number)
            found.append(f"{capsys.readouterr().out}{watcher.ready}")
        del heard["status"]
        watcher.node.create_publisher(GripStatus, "status", LATEST)
        wait_until(lambda: watcher.is_there)
        watcher.show(9.0)  # a node that is not active says nothing
        found.append(capsys.readouterr().out)
    agrees("watched", "\n".join(found))


@pytest.mark.parametrize(
    "command", ["plan --radius 20mm", "grasp", "release", "status", "watch --duration 0.3"]
)
def test_no_node_is_exit_code_2_and_says_how_to_start_one(monkeypatch, capsys, command):
    monkeypatch.setattr(commands, "DISCOVERY_TIMEOUT", 0.3)
    assert run([*command.split(), "--namespace", "/nobody"]) == 2
    assert "spiral_gripper_node --ros-args -r __ns:=/nobody" in capsys.readouterr().err


def test_a_release_is_waited_for_while_it_goes_on_but_not_for_ever(
    client, namespace, monkeypatch, capsys
):
    monkeypatch.setattr(commands, "RELEASE_PATIENCE", 1.5)
    monkeypatch.setattr(commands, "ASK_AGAIN", 0.1)
    handles, end, begin = [], Future(), time.monotonic()

    async def hang(handle):
        handles.append(handle)
        await end
        handle.abort()
        return Release.Result()

    def go_on():
        if handles and time.monotonic() - begin < 4.0:
            handles[0].publish_feedback(Release.Feedback())

    server = ActionServer(client, Release, "release", hang)
    client.create_timer(0.1, go_on)
    with ThreadPoolExecutor() as pool:
        code = pool.submit(run, ["release", "--timeout", "0.5", "--namespace", namespace])
        client.wait_until(code.done, "the end")
    assert code.result() == 2
    assert time.monotonic() - begin > 4.0
    said = "does not say whether it has vented; it hangs, or its clock stands still (waited 2 s)"
    assert said in capsys.readouterr().err
    end.set_result(None)
    client.spin()
    server.destroy()


def test_an_interrupted_grasp_that_may_go_on_is_told(monkeypatch, capsys):
    """Nothing answers the cancel."""
    node = MagicMock()
    node.__enter__.return_value = node
    node.wrap.side_effect = KeyboardInterrupt
    node.cancel.side_effect = NoAnswerError("grasp does not answer", 10.0)
    monkeypatch.setattr(commands, "SpiralGripper", lambda *_: node)
    assert run(["grasp"]) == 2
    said = capsys.readouterr().err
    assert "may go on: spiral-gripper release vents; grasp does not answer (waited 10 s)" in said


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
