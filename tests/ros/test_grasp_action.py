# SPDX-License-Identifier: Apache-2.0
"""The actions `grasp` and `release`, and the measured pressure: a real node, asked from outside."""

import math

import pytest
from action_msgs.msg import GoalStatus
from ros.grasp_goals import Goals, refused, started
from ros.harness import all_finite

from spiral_gripper_msgs.action import Grasp, Release
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.states import Reason, State

RADIUS = 0.02
SUCCEEDED, CANCELED = GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED
FOLLOWED, PRESSURE = Grasp.Goal.MODE_FOLLOWED, Grasp.Goal.MODE_PRESSURE


@pytest.fixture(scope="module")
def goals(shared):
    goals = Goals(shared)
    yield goals
    goals.close()


@pytest.fixture(scope="module")
def releases(shared):
    goals = Goals(shared, Release, "release")
    yield goals
    goals.close()


@pytest.fixture
def quick(active):
    """A node that takes a wrap for reached soon after its command is."""
    active.change("pressure.settle_time", 0.1)
    return active


def measure(client, factor, offset=0.0):
    """Answer each command with a measured pressure from now on; wait until the node knows one."""
    client.regulator = lambda pressure: factor * pressure + offset
    client.wait_until(lambda: client.status.measured_pressure, "a measured pressure")


def wait_for_fault(client, reason):
    client.wait_until(lambda: client.status.fault == reason, f"the pressure fault {reason.name}")
    return client.status


def vented(client, state, reason=None):
    """Wait for a state in which nothing is commanded."""
    assert client.wait_for_state(state, reason).pressure_command == 0.0
    client.wait_for_vent()


# --- grasps ------------------------------------------------------------------------------------


def test_a_goal_wraps_the_object_tells_the_way_and_says_so(goals, active, curve):
    for name, value in (("pressure.rate_up", 5.0e4), ("pressure.settle_time", 1.0)):
        active.change(name, value)
    wrap = curve.wrap_for_radius(RADIUS)
    goal = goals.grasp(RADIUS)
    status, result = goal.end()
    assert (status, result.success, result.reason) == (SUCCEEDED, True, Reason.NONE)
    assert result.pressure_command == pytest.approx(wrap.pressure, rel=1e-9)
    assert "as commanded" in result.message
    (figures,) = result.figures
    assert figures.turns == pytest.approx(wrap.turns, rel=1e-6)
    progress = [feedback.progress for feedback in goal.feedback]
    assert progress == sorted(progress)
    assert progress[0] < 0.1 < progress[-1] <= 1.0
    assert {feedback.state for feedback in goal.feedback} == {State.GRASPING}
    assert {feedback.pressure_target for feedback in goal.feedback} == {result.pressure_command}
    assert goal.feedback[0].regime == GripStatus.REGIME_OVERHANG
    assert goal.feedback[-1].regime == GripStatus.REGIME_PERFECT_WRAP
    assert 3 <= len(goal.feedback) <= 2 + result.elapsed / 0.1
    assert all_finite(result, *goal.feedback)


def test_what_is_wrapped_is_held_and_no_radius_is_followed(goals, quick):
    target = quick.wrap(RADIUS).pressure_target
    goal = goals.send(Grasp.Goal(mode=FOLLOWED, overpressure=[1.0e3]))
    status, result = goal.end()
    assert (status, result.figures[0].object_radius) == (SUCCEEDED, RADIUS)
    assert result.pressure_command == pytest.approx(target + 1.0e3)
    assert not goal.cancel()
    for _ in range(5):
        quick.send_radius(0.03)
        quick.hear_more(1)
    status = quick.status
    assert (status.state, list(status.object_radius)) == (State.GRASPING, [RADIUS])
    assert status.pressure_command == status.pressure_target == result.pressure_command
    assert status.wrapped


def test_a_pressure_is_reached_whatever_it_wraps(goals, quick):
    quick.release()  # a goal ends it
    status, result = goals.send(Grasp.Goal(mode=PRESSURE, pressure=3.0e4)).end()
    assert (status, result.pressure_command, list(result.figures)) == (SUCCEEDED, 3.0e4, [])
    quick.change("pressure.cap", 2.0e4)
    quick.wait_for_state(State.GRASPING, Reason.PRESSURE_CAP)


# What ends a goal, if its own time does not; why, and the state then.
ENDS = [
    ({}, lambda goal: goal.cancel(), Reason.GRASP_CANCELED, State.RELEASED),
    ({"abort_policy": 2}, lambda goal: goal.cancel(), Reason.GRASP_CANCELED, State.GRASPING),
    ({"timeout": [2.0]}, lambda goal: None, Reason.GRASP_TIMEOUT, State.RELEASED),
    ({}, lambda goal: Goals(goal.client).grasp(0.025), Reason.GRASP_REPLACED, State.GRASPING),
    ({}, lambda goal: measure(goal.client, 1.0, 6.0e4), Reason.PRESSURE_HIGH, State.RELEASED),
    ({}, lambda goal: goal.client.release(), Reason.RELEASED, State.RELEASED),
    ({}, lambda goal: goal.client.transition("deactivate"), Reason.NOT_ACTIVE, State.INACTIVE),
    (
        {},
        lambda goal: goal.client.set_parameter("gripper", "prototype_p1"),
        Reason.RECONFIGURED,
        State.RELEASED,
    ),
]


@pytest.mark.parametrize(("fields", "act", "reason", "state"), ENDS)
def test_what_ends_a_goal_is_its_reason_and_vents_or_holds(
    goals, releases, quick, fields, act, reason, state
):
    quick.change("pressure.rate_up", 500.0)
    goal = started(goals.grasp(RADIUS, **fields))
    refused(goals.grasp(0.2), Reason.RADIUS_TOO_LARGE)  # another that cannot be
    act(goal)
    status, result = goal.end()
    outcome = CANCELED if reason is Reason.GRASP_CANCELED else GoalStatus.STATUS_ABORTED
    assert (status, result.success, result.reason) == (outcome, False, reason)
    if state is State.GRASPING:
        quick.statuses.clear()
        assert quick.wait_for_state(state).pressure_command > 0.0
    else:
        assert result.pressure_command == 0.0
        vented(quick, state)
    if state is State.INACTIVE:
        assert "activate" in refused(goals.grasp(RADIUS), reason)
        refused(releases.send(Release.Goal()), reason)
        assert quick.transition("cleanup")
        assert "configure" in refused(goals.grasp(RADIUS), reason)


def test_a_goal_that_cannot_be_done_says_why_and_changes_nothing(goals, active):
    for fields, reason in (
        ({"object_radius": math.nan}, Reason.RADIUS_NOT_FINITE),
        ({"object_radius": RADIUS, "overpressure": [1.0e6]}, Reason.PRESSURE_CAP),
        ({"object_radius": RADIUS, "payload": [-1.0]}, Reason.INVALID_REQUEST),
        ({"object_radius": RADIUS, "timeout": [math.inf]}, Reason.INVALID_REQUEST),
        ({"object_radius": RADIUS, "abort_policy": 3}, Reason.INVALID_REQUEST),
        ({"object_radius": RADIUS, "mode": 3}, Reason.INVALID_REQUEST),
        ({"mode": FOLLOWED}, Reason.NO_RADIUS),
        ({"mode": PRESSURE, "pressure": math.nan}, Reason.INVALID_REQUEST),
        ({"mode": PRESSURE, "pressure": 1.0e4, "overpressure": [1.0]}, Reason.INVALID_REQUEST),
    ):
        refused(goals.send(Grasp.Goal(**fields)), reason)
    active.hear_more()
    assert (active.status.state, active.status.reason) == (State.WAITING, Reason.NO_RADIUS)
    assert set(active.pressures) == {0.0}


# --- the measured pressure ---------------------------------------------------------------------


def test_a_measured_pressure_decides_when_it_is_known(goals, releases, active):
    # What is measured here comes as late as this process is held up.
    active.change("pressure.settle_time", 2.0)
    measure(active, 1.0)
    status, result = goals.grasp(RADIUS).end()
    assert status == SUCCEEDED, result.message
    assert list(result.measured_pressure) == pytest.approx([result.pressure_command], abs=1.0e3)
    assert "as measured" in result.message
    assert (active.status.wrapped, active.status.fault) == (True, Reason.NONE)
    active.regulator = lambda pressure: 4.0e4
    goal = releases.send(Release.Goal())
    active.wait_for_state(State.RELEASED)
    active.hear_more(10)
    assert not goal.is_done
    active.regulator = lambda pressure: 0.0
    status, result = goal.end()
    assert (status, result.success) == (SUCCEEDED, True)
    assert "vented, as measured" in result.message


def test_the_measured_shape_is_that_at_the_measured_pressure(goals, active, curve):
    def tip():
        point = active.measured_backbones[-1].poses[-1].position
        return point.x, point.y, point.z

    assert not active.measured_backbones
    for name, value in (("pressure.tolerance", 5.0e4), ("grasp.timeout", 4.0)):
        active.change(name, value)
    measure(active, 0.8)
    expected = curve.state_at_pressure(0.8 * active.wrap(RADIUS).pressure_command).tip_position
    active.wait_until(
        # Changes up to 50 Pa keep the shape, which move the tip by 0.35 mm.
        lambda: active.measured_backbones and tip() == pytest.approx(expected, abs=5e-4),
        "the measured shape",
    )
    assert active.status.regime == GripStatus.REGIME_OVERHANG
    assert not active.status.wrapped
    refused(goals.grasp(RADIUS), Reason.WRAP_FAILED)
    vented(active, State.RELEASED, Reason.WRAP_FAILED)


def test_a_leak_is_reported_and_vents_if_that_is_the_policy(active):
    active.change("pressure.fault_policy", "vent")
    measure(active, 1.0)
    active.wrap(RADIUS)
    active.regulator = lambda pressure: 0.8 * pressure
    assert "leak" in wait_for_fault(active, Reason.PRESSURE_LOW).fault_text
    vented(active, State.FAULT, Reason.PRESSURE_LOW)
    wait_for_fault(active, Reason.NONE)
    assert active.status.state == State.FAULT
    active.regulator = lambda pressure: pressure
    assert active.rearm().success
    active.wrap(RADIUS)


@pytest.mark.parametrize(
    ("reading", "reason", "regime"),
    [
        (math.nan, Reason.PRESSURE_INVALID, GripStatus.REGIME_PERFECT_WRAP),
        (None, Reason.PRESSURE_LOST, GripStatus.REGIME_PERFECT_WRAP),
        (1.6e5, Reason.PRESSURE_HIGH, GripStatus.REGIME_UNKNOWN),  # no shape there is described
    ],
)
def test_a_measured_pressure_that_cannot_be_is_reported_and_never_passed_on(
    active, reading, reason, regime
):
    active.change("measured_pressure.timeout", 0.3)
    measure(active, 1.0)
    held = active.wrap(RADIUS).pressure_command
    active.regulator = None if reading is None else lambda pressure: reading
    wait_for_fault(active, reason)
    # Without a measured pressure the command counts again.
    active.wait_until(lambda: active.status.regime == regime, "the regime")
    assert (active.status.state, active.pressures[-1]) == (State.TRACKING, held)
    assert bool(active.status.measured_pressure) == (reason is Reason.PRESSURE_HIGH)
    assert all_finite(*active.statuses, *active.measured_backbones)


# --- releases ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("reading", "timeout", "reason", "words"),
    [
        (None, 20.0, Reason.PRESSURE_LOST, "nothing shows that the gripper is vented"),
        (4.0e4, 0.5, Reason.PRESSURE_HIGH, "still "),
        (4.0e4, math.nan, Reason.INVALID_REQUEST, "vented all the same"),
        (4.0e4, None, None, ""),  # canceled
    ],
)
def test_a_release_whose_sensor_or_link_has_failed_is_vented_but_no_success(
    releases, quick, reading, timeout, reason, words
):
    quick.change("measured_pressure.timeout", 0.5)
    measure(quick, 1.0)
    quick.wrap(RADIUS)
    quick.regulator = None if reading is None else lambda pressure: reading
    goal = releases.send(Release.Goal(timeout=[] if timeout is None else [timeout]))
    if reason is None:
        assert goal.cancel()
        assert goal.end()[0] == CANCELED
    else:
        assert words in refused(goal, reason)
    vented(quick, State.RELEASED)
