# SPDX-License-Identifier: Apache-2.0
"""The action `release`: it vents at once, and ends when the pressure is gone."""

import math
import re

import pytest
from action_msgs.msg import GoalStatus
from ros.grasp_goals import Goals, refused
from ros.harness import all_finite

from spiral_gripper_msgs.action import Release
from spiral_gripper_ros.control.states import Reason, State

RADIUS = 0.02
SUCCEEDED, CANCELED = GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED


@pytest.fixture(scope="module")
def releases(shared):
    goals = Goals(shared, Release, "release")
    yield goals
    goals.close()


@pytest.fixture
def holding(active, releases):
    """A node that holds an object, measured; what it then releases to is a `Release` client."""
    assert active.set_parameter("pressure.settle_time", 0.1).successful
    active.regulator = lambda pressure: pressure
    active.wrap(RADIUS)
    active.wait_until(lambda: active.status.measured_pressure and active.status.wrapped, "the wrap")
    return releases


def test_a_release_ends_when_the_measured_pressure_is_gone(holding):
    client, answer = holding.client, [4.0e4]
    client.regulator = lambda pressure: answer[0]
    goal = holding.send(Release.Goal())
    client.wait_for_state(State.RELEASED)
    client.wait_until(lambda: goal.feedback, "feedback")
    client.hear_more(10)
    assert not goal.is_done
    assert client.pressures[-1] == 0.0
    answer[0] = 0.0
    status, result = goal.end()
    assert (status, result.success) == (SUCCEEDED, True)
    assert result.measured_pressure[0] <= 1000.0
    assert "vented, as measured" in result.message
    assert all_finite(result, *goal.feedback)


def test_without_a_measured_pressure_it_is_gone_after_a_while(active, releases):
    assert active.set_parameter("pressure.settle_time", 0.3).successful
    active.wrap(RADIUS)
    status, result = releases.send(Release.Goal()).end()
    assert (status, len(result.measured_pressure)) == (SUCCEEDED, 0)
    assert result.elapsed >= 0.3
    assert "as commanded" in result.message


def test_a_pressure_that_stays_fails_the_release_in_its_time(holding):
    client = holding.client
    client.regulator = lambda pressure: 4.0e4
    goal = holding.send(Release.Goal(timeout=[0.5]))
    message = refused(goal, Reason.PRESSURE_HIGH)
    still = re.search(r"still ([\d.]+) Pa", message)
    # The readings are smoothed: a node that has heard few of them is on its way to 40 kPa.
    assert still is not None
    assert 4.0e4 <= float(still[1]) < 5.7e4
    client.wait_for_state(State.RELEASED)


@pytest.mark.parametrize(
    ("reading", "reason"),
    [
        (None, Reason.PRESSURE_LOST),  # the link is cut
        (math.nan, Reason.PRESSURE_INVALID),
        (-101325.0, Reason.PRESSURE_LOW),  # the sensor has failed
    ],
)
def test_a_release_whose_sensor_or_link_has_failed_is_vented_but_no_success(
    holding, reading, reason
):
    client = holding.client
    limits = {"measured_pressure.timeout": 0.5, "pressure.settle_time": 0.1}
    assert all(result.successful for result in client.set_parameters(limits))
    client.regulator = None if reading is None else lambda pressure: reading
    message = refused(holding.send(Release.Goal(timeout=[20.0])), reason)
    assert "nothing shows that the gripper is vented" in message
    client.wait_for_state(State.RELEASED)
    client.wait_until(lambda: client.pressures[-1] == 0.0, "the vent")


@pytest.mark.parametrize("timeout", [math.nan, math.inf, -1.0])
def test_an_impossible_timeout_is_refused_and_vents_all_the_same(holding, timeout):
    message = refused(holding.send(Release.Goal(timeout=[timeout])), Reason.INVALID_REQUEST)
    assert "vented all the same" in message
    holding.client.wait_for_state(State.RELEASED)
    holding.client.wait_until(lambda: holding.client.pressures[-1] == 0.0, "the vent")


def test_a_canceled_release_stays_vented(holding):
    client = holding.client
    client.regulator = lambda pressure: 4.0e4
    goal = holding.send(Release.Goal())
    client.wait_for_state(State.RELEASED)
    assert goal.cancel()
    assert goal.end()[0] == CANCELED
    assert client.status.state == State.RELEASED


def test_an_inactive_node_says_so(holding):
    assert holding.client.transition("deactivate")
    refused(holding.send(Release.Goal()), Reason.NOT_ACTIVE)
