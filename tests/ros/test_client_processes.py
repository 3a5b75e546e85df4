# SPDX-License-Identifier: Apache-2.0
"""The Python client among other programs: their ROS, their Ctrl-C, their end."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
import traceback
from subprocess import PIPE

import pytest
import rclpy
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from repo.source_tree import ROOT
from ros.harness import DEADLINE, PATIENT, START_DEADLINE, RunningNode, wait_until

from spiral_gripper_ros.client import (
    NoAnswerError,
    SpiralGripper,
    WrapOutcome,
)
from spiral_gripper_ros.control.states import Reason, State


def test_a_node_that_was_killed_and_started_again_has_forgotten_the_wrap(namespace):
    parameters = {**PATIENT, "pressure.rate_up": 500.0}
    with SpiralGripper(namespace, answer_timeout=DEADLINE) as gripper:
        with RunningNode(namespace, parameters) as first:
            gripper.wait_until_active(START_DEADLINE)
            assert gripper.wrap(0.02, timeout=600.0)
            os.kill(first.pid, signal.SIGSTOP)  # DDS would miss it after 20 s
            stopped = time.monotonic()
            with pytest.raises(NoAnswerError, match="nothing has been heard of it"):
                gripper.wait(DEADLINE)
            assert time.monotonic() - stopped < 2.0
            first.stop(signal.SIGKILL)

        def is_done():
            with contextlib.suppress(NoAnswerError):  # between the two there may be none
                return gripper.is_done()

        with RunningNode(namespace, parameters):
            wait_until(is_done)
            result = gripper.result()
    assert result.outcome is WrapOutcome.FAILED
    assert result.message == "the node no longer knows the goal"


def test_it_works_inside_a_callback_of_another_node_and_leaves_its_context_alone(grip):
    node, seen = Node("someone_else"), []
    node.create_timer(0.01, lambda: seen.append(grip.plan(0.02).success))
    with SpiralGripper("nowhere"):
        wait_until(lambda: rclpy.spin_once(node, timeout_sec=DEADLINE) or seen)
    node.destroy_node()
    assert seen[0] is rclpy.ok() is True


@pytest.mark.parametrize(
    ("kind", "name"), [(SingleThreadedExecutor, "spin_once"), (ActionClient, "send_goal_async")]
)
def test_ctrl_c_never_strikes_in_the_midst_of_rclpy(slow, active, monkeypatch, kind, name):
    """What was sent is known, and canceled."""
    struck, call = [], getattr(kind, name)

    def strike(*arguments, **options):
        answer = call(*arguments, **options)
        if not struck:
            struck.append(True)
            signal.raise_signal(signal.SIGINT)
        return answer

    with monkeypatch.context() as patch:
        patch.setattr(kind, name, strike)
        with pytest.raises(KeyboardInterrupt) as caught:
            slow.wrap(0.02, timeout=600.0)
    assert strike.__name__ not in [frame.name for frame in traceback.extract_tb(caught.tb)]
    assert slow.cancel()
    assert active.wait_for_state(State.RELEASED, Reason.GRASP_CANCELED)


@pytest.mark.usefixtures("grip")
def test_the_example_wraps_and_releases(active):
    command = [sys.executable, ROOT / "examples/grasp_with_python.py", active.get_namespace()]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    assert run.stderr == ""
    wrapped = r"wraps 0.02 m at 62045.\d Pa, as commanded; 1\.\d\d turns, \d\.\d N/m"
    assert re.fullmatch(wrapped, run.stdout.splitlines()[-1])
    assert active.wait_for_state(State.RELEASED)


PROGRAM = """
import atexit
import rclpy
from spiral_gripper_ros.client import SpiralGripper
rclpy.init()
gripper = SpiralGripper({!r})
atexit.register(gripper.release)
try:
    gripper.wrap(0.02, timeout=600.0)
    print(rclpy.ok(), flush=True)
    gripper.wait(600.0)
finally:
    gripper.release()
    assert gripper.is_done() and gripper.cancel() is False
"""


@pytest.mark.usefixtures("slow")
def test_after_ctrl_c_in_a_wait_finally_clauses_and_exit_handlers_can_release(active):
    command = [sys.executable, "-c", PROGRAM.format(active.get_namespace())]
    with subprocess.Popen(command, stdout=PIPE, stderr=PIPE, text=True) as process:
        assert process.stdout.readline() == "True\n"
        assert active.wait_for_state(State.GRASPING)
        process.send_signal(signal.SIGINT)
        errors = process.communicate(timeout=DEADLINE)[1]
    assert errors.splitlines()[-1] == "KeyboardInterrupt"
    assert active.wait_for_state(State.RELEASED, Reason.RELEASED)
