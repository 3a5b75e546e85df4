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
from pathlib import Path

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from ros.client_harness import EXAMPLE, PATIENCE, RADIUS, ROOT, wait_until
from ros.harness import PATIENT, START_DEADLINE, RunningNode

from spiral_gripper_msgs.action import Grasp
from spiral_gripper_ros.client import (
    NoAnswerError,
    SpiralGripper,
    WrapOutcome,
)
from spiral_gripper_ros.control.states import Reason, State


def test_it_works_inside_a_callback_of_another_node(grip):
    seen = []
    node = Node("someone_else")
    node.create_timer(0.01, lambda: seen.append(grip.plan(RADIUS).success))
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    while not seen:
        executor.spin_once(timeout_sec=PATIENCE)
    executor.shutdown()
    node.destroy_node()
    assert seen == [True]


def test_ctrl_c_never_strikes_in_the_midst_of_rclpy(slow, active, monkeypatch):
    armed = []

    def interrupt_once(_):
        if armed:
            armed.clear()
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(slow, "_on_feedback", interrupt_once)
    slow.wrap(RADIUS)
    armed.append(True)
    with pytest.raises(KeyboardInterrupt) as caught:
        slow.wait(PATIENCE)
    files = [Path(frame.filename).parts for frame in traceback.extract_tb(caught.tb)]
    assert not [file for file in files if "rclpy" in file]
    monkeypatch.undo()
    slow.release()
    assert active.wait_for_state(State.RELEASED)


def test_a_node_that_was_killed_and_started_again_has_forgotten_the_wrap(namespace):
    parameters = {**PATIENT, "pressure.rate_up": 500.0}
    with SpiralGripper(namespace, answer_timeout=PATIENCE) as gripper:
        with RunningNode(namespace, parameters) as first:
            gripper.wait_until_active(START_DEADLINE)
            assert gripper.wrap(RADIUS, timeout=600.0)
            os.kill(first.process_id, signal.SIGSTOP)  # DDS would miss it after 20 s
            stopped = time.monotonic()
            with pytest.raises(NoAnswerError, match="nothing has been heard of it"):
                gripper.wait(PATIENCE)
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


def run(*arguments):
    command = [sys.executable, *arguments]
    process = subprocess.run(
        command, capture_output=True, text=True, timeout=START_DEADLINE, check=False
    )
    assert process.returncode == 0, process.stdout + process.stderr
    assert process.stderr == ""
    return process.stdout


def test_without_rclpy_being_initialized_it_brings_a_context_of_its_own(grip):
    namespace = grip._link.node.get_namespace()
    lines = [
        "import rclpy",
        "from spiral_gripper_ros.client import SpiralGripper",
        f"with SpiralGripper({namespace!r}) as gripper:",
        "    print(rclpy.ok(), gripper.plan(0.02).success)",
        "rclpy.init()",
        f"with SpiralGripper({namespace!r}) as gripper:",
        "    print(rclpy.ok(), gripper.plan(0.02).success)",
        "print(rclpy.ok())",
        "rclpy.shutdown()",
    ]
    assert run("-c", "\n".join(lines)).split() == ["False", "True", "True", "True", "True"]


def test_the_example_wraps_and_releases(grip, active):
    printed = run(str(EXAMPLE), grip._link.node.get_namespace())
    lines = printed.splitlines()
    assert lines[0].startswith("wraps 0.02 m with ")
    assert re.fullmatch(
        r"wraps 0.02 m at 62045.\d Pa, as commanded; 1\.\d\d turns, \d\.\d N/m",
        lines[-1],
    )
    assert active.wait_for_state(State.RELEASED)


@pytest.mark.parametrize(
    "before", ["", "rclpy.init()"], ids=["its own context", "shut down by rclpy"]
)
def test_after_ctrl_c_in_a_wait_the_finally_clause_can_release(slow, active, before):
    lines = [
        "import rclpy",
        "from spiral_gripper_ros.client import SpiralGripper",
        before,
        f"with SpiralGripper({slow._link.node.get_namespace()!r}) as gripper:",
        "    try:",
        "        gripper.wrap(0.02, timeout=600.0)",
        "        print('wrapping', flush=True)",
        "        gripper.wait(600.0)",
        "    finally:",
        "        gripper.release()",
    ]
    command = [sys.executable, "-c", "\n".join(lines)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "wrapping\n"
        assert active.wait_for_state(State.GRASPING)
        process.send_signal(signal.SIGINT)
        errors = process.communicate(timeout=PATIENCE)[1]
    assert errors.splitlines()[-1] == "KeyboardInterrupt"
    assert active.wait_for_state(State.RELEASED, Reason.RELEASED)


def test_the_page_shows_the_example():
    page = (ROOT / "docs" / "grasping.md").read_text(encoding="utf-8")
    block = re.search(r"```python\n(.*?)```", page, re.DOTALL)[1]
    assert block in EXAMPLE.read_text(encoding="utf-8")


def test_the_pages_command_lines_name_fields_that_exist():
    page = (ROOT / "docs" / "grasping.md").read_text(encoding="utf-8")
    goals = re.findall(r"spiral_gripper_msgs/action/Grasp \"\{(.*?)\}\"", page)
    assert len(goals) == 3
    fields = Grasp.Goal.get_fields_and_field_types()
    assert {name for goal in goals for name in re.findall(r"(\w+):", goal)} <= fields.keys()


def test_the_context_of_others_is_used_and_left_alone(shared):
    with SpiralGripper(shared.get_namespace()) as gripper:
        assert gripper._link.node.context is rclpy.get_default_context()
    assert rclpy.ok()
