# SPDX-License-Identifier: Apache-2.0
"""The Python client, against a node in a process of its own."""

import contextlib
import math
import re
import signal
import subprocess
import sys
import time
import traceback
import warnings
from pathlib import Path

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from ros.harness import DEADLINE, NODE, PATIENT, START_DEADLINE, RunningNode, all_finite

from spiral_core import InvalidInputError
from spiral_core.errors import SpiralError
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_ros.client import (
    AbortPolicy,
    NoAnswerError,
    RequestRefusedError,
    SpiralGripper,
    WrapOutcome,
    WrapResult,
    spiral_gripper,
)
from spiral_gripper_ros.control.states import Reason, State

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "grasp_with_python.py"
RADIUS = 0.02
# Of everything that these tests wait for [s].
PATIENCE = DEADLINE
QUESTIONS = [
    lambda gripper: gripper.wait_until_active(0.2),
    lambda gripper: gripper.wrap(RADIUS),
    lambda gripper: gripper.plan(RADIUS),
    lambda gripper: gripper.release(),
    lambda gripper: gripper.rearm(),
]


@pytest.fixture(scope="module")
def connection(shared):
    with SpiralGripper(shared.get_namespace(), answer_timeout=PATIENCE) as gripper:
        gripper.wait_until_active(START_DEADLINE)
        yield gripper


@pytest.fixture
def grip(active, connection):
    assert active.set_parameter("pressure_settle_time", 0.1).successful
    connection.wait_until_active(PATIENCE)
    return connection


@pytest.fixture
def slow(active, grip):
    assert active.set_parameter("pressure_rate_up", 500.0).successful
    return grip


@pytest.fixture
def nowhere(namespace):
    """A client of a node that does not exist, and does not wait for it long."""
    with SpiralGripper(namespace, answer_timeout=0.2) as gripper:
        yield gripper


def wait_until(condition):
    """Poll a condition that listens itself until it holds."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline


def wait_for_pressure(gripper):
    """Wait until the wrap that runs has some pressure."""
    wait_until(
        lambda: (
            not gripper.is_done() and gripper.feedback() and gripper.feedback().pressure_command > 0
        )
    )


def test_wrap_wait_release(grip, curve):
    assert grip.wrap(RADIUS)
    result = grip.wait(PATIENCE)
    assert result == grip.result()
    assert result.outcome is WrapOutcome.SUCCEEDED
    assert result.reason is Reason.NONE
    assert result.object_radius == RADIUS
    assert result.pressure_command == pytest.approx(curve.pressure_from_radius(RADIUS))
    assert result.measured_pressure is None
    assert result.turns > 1.0
    assert result.contact_length > 0.1
    assert result.line_force > 0.0
    assert "wraps 0.02 m" in result.message
    wait_until(lambda: grip.status.state == State.GRASPING)
    assert all_finite(grip.feedback(), grip.status)
    grip.release()
    wait_until(lambda: grip.status.state == State.RELEASED)


def test_a_measured_pressure_is_in_the_result(grip, active):
    assert active.set_parameter("pressure_settle_time", 2.0).successful
    active.regulator = lambda pressure: pressure
    active.wait_until(lambda: active.status is not None and active.status.measured, "measurement")
    grip.wrap(RADIUS)
    while not grip.is_done():
        active.spin(0.1)
    result = grip.result()
    assert result.outcome is WrapOutcome.SUCCEEDED
    assert result.measured_pressure == pytest.approx(result.pressure_command, abs=1.0e3)


def test_polling_sees_the_way_to_the_target(slow, active):
    slow.wrap(RADIUS, timeout=600.0)
    progress = []

    def is_done():
        done = slow.is_done()
        if slow.feedback() is not None:
            progress.append(slow.feedback().progress)
        return done

    wait_until(lambda: is_done() or len(set(progress)) >= 3)
    assert slow.result() is None
    assert active.set_parameter("pressure_rate_up", 2.0e6).successful
    wait_until(is_done)
    assert progress == sorted(progress)
    assert slow.result().outcome is WrapOutcome.SUCCEEDED


def test_what_cannot_be_wrapped_is_a_result_with_its_reason(grip):
    assert grip.wrap(0.2)
    result = grip.wait(PATIENCE)
    assert result.outcome is WrapOutcome.FAILED
    assert result.reason is Reason.RADIUS_TOO_LARGE
    assert "above the grippable range" in result.message


def test_a_plan_moves_nothing_and_says_what_would_be(grip, active, curve):
    plan = grip.plan(RADIUS, overpressure=2.0e3)
    assert plan.success
    assert plan.pressure == pytest.approx(curve.pressure_from_radius(RADIUS) + 2.0e3)
    assert not grip.plan(0.2).success
    active.hear_more()
    assert active.status.state == State.WAITING


def test_the_radius_that_is_followed_can_be_pinned(grip, active):
    active.wrap(RADIUS)
    grip.wrap(None)
    assert grip.wait(PATIENCE).object_radius == RADIUS


def test_cancel_vents_or_holds(slow):
    slow.wrap(RADIUS)
    assert slow.cancel()
    result = slow.wait(PATIENCE)
    assert (result.outcome, result.reason) == (WrapOutcome.CANCELED, Reason.GRASP_CANCELED)
    assert result.pressure_command == 0.0
    assert not slow.cancel()
    slow.wrap(RADIUS, abort_policy=AbortPolicy.HOLD)
    wait_for_pressure(slow)
    assert slow.cancel()
    assert slow.wait(PATIENCE).pressure_command > 0.0


def test_a_newer_wrap_takes_over(slow, active):
    slow.wrap(0.03, timeout=600.0)
    assert active.set_parameter("pressure_rate_up", 2.0e6).successful
    slow.wrap(RADIUS)
    result = slow.wait(PATIENCE)
    assert (result.outcome, result.object_radius) == (WrapOutcome.SUCCEEDED, RADIUS)


def test_the_wraps_own_timeout_is_a_result(slow):
    slow.wrap(RADIUS, timeout=0.2)
    assert slow.wait(PATIENCE).reason is Reason.GRASP_TIMEOUT


def test_a_wait_that_is_too_short_says_so_and_the_wrap_goes_on(slow, monkeypatch):
    slow.wrap(RADIUS, timeout=600.0)
    monkeypatch.setattr(spiral_gripper, "SILENCE", PATIENCE)
    with pytest.raises(NoAnswerError, match="it goes on") as caught:
        slow.wait(0.2)
    assert caught.value.timeout == 0.2
    assert slow.result() is None
    wait_until(lambda: slow.status.state == State.GRASPING)
    assert slow.cancel()


def test_a_wait_on_a_silent_node_does_not_say_that_the_wrap_goes_on(slow, monkeypatch):
    slow.wrap(RADIUS, timeout=600.0)
    monkeypatch.setattr(slow, "_heard", time.monotonic() - 5.0)
    monkeypatch.setattr(slow, "is_done", lambda: False)  # which would hear of it
    with pytest.raises(NoAnswerError, match=r"nothing has been heard of the node for 5\.\d s"):
        slow.wait(0.01)
    monkeypatch.undo()
    assert slow.cancel()


@pytest.mark.usefixtures("slow")
def test_a_goal_that_is_accepted_too_late_is_canceled(active, shared, monkeypatch):
    with SpiralGripper(shared.get_namespace(), answer_timeout=0.1) as hasty:
        hasty.wait_until_active(PATIENCE)
        wrap_and_hear_nothing(hasty, monkeypatch)
        assert hasty.is_done()
        active.wait_for_state(State.GRASPING)

        def has_ended():
            assert hasty.status is not None  # a call, within which it hears of the goal
            active.spin(0.05)
            return active.status.state != State.GRASPING

        wait_until(has_ended)
    assert active.wait_for_state(State.RELEASED, Reason.GRASP_CANCELED)


@pytest.mark.usefixtures("slow")
def test_closing_waits_a_moment_for_a_late_answer(active, shared, monkeypatch):
    monkeypatch.setattr(spiral_gripper, "GLANCE", PATIENCE)
    with SpiralGripper(shared.get_namespace(), answer_timeout=0.1) as hasty:
        hasty.wait_until_active(PATIENCE)
        wrap_and_hear_nothing(hasty, monkeypatch)
    assert active.wait_for_state(State.RELEASED, Reason.GRASP_CANCELED)


def wrap_and_hear_nothing(gripper, monkeypatch):
    """Send a goal whose answer is not heard in time."""
    with monkeypatch.context() as patch:
        patch.setattr(gripper._link._executor, "spin_once", time.sleep)
        with pytest.raises(NoAnswerError, match="it may still start; it is canceled as soon as"):
            gripper.wrap(RADIUS, timeout=600.0)


def test_cancel_is_sent_at_once(slow, monkeypatch):
    slow.wrap(RADIUS, timeout=600.0)
    sent = []
    cancel = slow._goal.cancel_goal_async
    spin_once = slow._link._executor.spin_once
    monkeypatch.setattr(slow._goal, "cancel_goal_async", lambda: sent.append("sent") or cancel())
    monkeypatch.setattr(
        slow._link._executor, "spin_once", lambda *args: sent.append("spun") or spin_once(*args)
    )
    assert slow.cancel()
    assert sent[0] == "sent"


@pytest.mark.parametrize("policy", ["hold", AbortPolicy.HOLD])
def test_the_abort_policy_may_be_a_word(slow, policy):
    slow.wrap(RADIUS, abort_policy=policy)
    wait_for_pressure(slow)
    assert slow.cancel()
    assert slow.wait(PATIENCE).pressure_command > 0.0


@pytest.mark.parametrize("policy", ["keep", "", 1, []])
def test_another_abort_policy_is_refused_with_the_choices(nowhere, policy):
    with pytest.raises(InvalidInputError, match='abort_policy must be "vent", "hold" or None'):
        nowhere.wrap(RADIUS, abort_policy=policy)


def test_closing_twice_is_harmless_and_a_closed_one_says_so(namespace):
    gripper = SpiralGripper(namespace)
    gripper.close()
    gripper.close()
    for question in (*QUESTIONS, lambda gripper: gripper.status):
        with pytest.raises(RequestRefusedError, match="this SpiralGripper is closed"):
            question(gripper)


@pytest.mark.parametrize("bad", ["bad name!", "/1", "/a/", "~", "//a", None, 3])
def test_a_bad_namespace_is_refused_without_a_warning(bad):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InvalidInputError, match="namespace must be a ROS namespace"):
            SpiralGripper(bad)


def test_a_node_that_is_gone_is_noticed_while_polling(slow, monkeypatch):
    slow.wrap(RADIUS, timeout=600.0)
    monkeypatch.setattr(slow._grasp, "server_is_ready", lambda: False)
    monkeypatch.setattr(slow._release, "service_is_ready", lambda: False)
    with pytest.raises(NoAnswerError, match="no gripper's node answers"):
        slow.is_done()
    monkeypatch.undo()
    assert slow.cancel()


def test_without_a_wrap_there_is_nothing_to_wait_for(shared):
    with SpiralGripper(shared.get_namespace()) as gripper:
        assert gripper.is_done()
        assert gripper.result() is None
        assert gripper.feedback() is None
        assert not gripper.cancel()
        with pytest.raises(RequestRefusedError, match="no wrap has been started"):
            gripper.wait(1.0)


def test_rearm_follows_radii_again_and_is_refused_while_grasping(grip, active):
    grip.release()
    grip.rearm()
    assert active.wait_for_state(State.WAITING)
    grip.wrap(RADIUS)
    grip.wait(PATIENCE)
    with pytest.raises(RequestRefusedError, match="rearm is refused"):
        grip.rearm()


@pytest.mark.parametrize("bad", [math.nan, math.inf, 0.0, -0.02, "0.02", True])
def test_a_bad_figure_is_refused_before_it_is_sent(nowhere, bad):
    with pytest.raises(InvalidInputError, match="radius"):
        nowhere.wrap(bad)
    with pytest.raises(InvalidInputError, match="radius"):
        nowhere.plan(bad)
    with pytest.raises(InvalidInputError, match="timeout"):
        nowhere.wrap(RADIUS, timeout=bad)
    with pytest.raises(InvalidInputError, match="timeout"):
        nowhere.wait(bad)
    with pytest.raises(InvalidInputError, match="timeout"):
        nowhere.wait_until_active(bad)
    with pytest.raises(InvalidInputError, match="answer_timeout"):
        SpiralGripper(answer_timeout=bad)
    if bad != 0.0:
        with pytest.raises(InvalidInputError, match="overpressure"):
            nowhere.wrap(RADIUS, overpressure=-1.0 if bad == 1.0 else bad)


@pytest.mark.parametrize("question", QUESTIONS)
def test_where_there_is_no_node_the_error_says_where_and_how_to_start_one(nowhere, question):
    with pytest.raises(NoAnswerError) as caught:
        question(nowhere)
    text = str(caught.value)
    namespace = nowhere._link.node.get_namespace()
    assert f"no gripper's node answers in the namespace {namespace}" in text
    assert f"spiral_gripper_node --ros-args -r __ns:={namespace}" in text
    assert isinstance(caught.value, SpiralError)
    assert isinstance(caught.value, TimeoutError)
    assert nowhere.status is None


def test_an_inactive_node_is_told_from_one_that_does_not_exist(active, connection):
    assert active.transition("deactivate")
    with pytest.raises(NoAnswerError, match="not active") as caught:
        connection.wait_until_active(0.5)
    assert f"ros2 lifecycle set {active.get_namespace()}/{NODE} configure" in str(caught.value)


def test_the_context_of_others_is_used_and_left_alone(shared):
    with SpiralGripper(shared.get_namespace()) as gripper:
        assert gripper._link.node.context is rclpy.get_default_context()
    assert rclpy.ok()


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
    parameters = {**PATIENT, "pressure_rate_up": 500.0}
    with SpiralGripper(namespace, answer_timeout=PATIENCE) as gripper:
        with RunningNode(namespace, parameters) as first:
            gripper.wait_until_active(START_DEADLINE)
            assert gripper.wrap(RADIUS, timeout=600.0)
            first.stop(signal.SIGKILL)

        def is_done():
            with contextlib.suppress(NoAnswerError):  # between the two there may be none
                return gripper.is_done()

        with RunningNode(namespace, parameters):
            wait_until(is_done)
            result = gripper.result()
    assert result.outcome is WrapOutcome.FAILED
    assert result.message == "the node no longer knows the goal"


def test_a_result_cannot_be_changed(grip):
    grip.wrap(RADIUS)
    result = grip.wait(PATIENCE)
    assert isinstance(result, WrapResult)
    with pytest.raises(AttributeError):
        result.turns = 5.0


# --- processes of their own ----------------------------------------------------------------------


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
