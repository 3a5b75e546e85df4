# SPDX-License-Identifier: Apache-2.0
"""Scenarios, played on a live node, end as courses of the control logic do (test_control.py)."""

import math

import pytest
import yaml
from action_msgs.msg import GoalStatus
from ros.control_bench import rows
from ros.grasp_goals import Goals
from ros.harness import all_finite

from spiral_gripper_msgs.action import Grasp, Release
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.states import Reason, State

# What a step of a scenario is: parameters, a regulator, a goal, or a method of Live.
CHANGES = """
patiently: {radius.timeout: 600.0, measured_pressure.timeout: 600.0, pressure.settle_time: 0.3,
  radius.rate_limit: 1.0e-4}  # a jump remains one however long it takes
impatiently: {measured_pressure.timeout: 0.5}
slowly: {pressure.rate_up: 500.0}
fast: {pressure.rate_up: 2.0e+6}
faults vent: {pressure.fault_policy: vent}
another gripper: {gripper: prototype_p1}
"""
REGULATORS = {
    "measured": lambda command: command,
    "a leak": lambda command: 0.7 * command,
    "a burst": lambda command: command + 1.0e5,
    "no number": lambda command: math.nan,
    "stuck": lambda command: 4.0e4,
    "silence": None,
}
GOALS = """
grasp: {object_radius: 0.02}
grasp another: {object_radius: 0.025}
grasp what is followed: {mode: 2, overpressure: [1.0e+3]}
press: {mode: 1, pressure: 3.0e+4}
grasp for 2 s: {object_radius: 0.02, timeout: [2.0]}
grasp to hold: {object_radius: 0.02, abort_policy: 2}
grasp too much: {object_radius: 0.02, overpressure: [1.0e+6]}
grasp no radius: {object_radius: .nan}
grasp without end: {object_radius: 0.02, timeout: [.inf]}
press no number: {mode: 1, pressure: .nan}
press more: {mode: 1, pressure: 1.0e+4, overpressure: [1.0]}
grasp no payload: {object_radius: 0.02, payload: [-1.0]}
grasp no mode: {mode: 3}
grasp no policy: {object_radius: 0.02, abort_policy: 3}
"""
CHANGES, GOALS = map(yaml.safe_load, (CHANGES, GOALS))
# The steps -> state, reason, what is gripped (the fault that differs); how each goal ends.
SCENARIOS = """
wrap -> TRACKING NONE wrapped
wrap, radius nan -> HOLDING RADIUS_NOT_FINITE wrapped
wrap, radius 0.2 -> HOLDING RADIUS_TOO_LARGE wrapped
wrap, radius 0.03 -> HOLDING RADIUS_JUMP wrapped
wrap, release, radius 0.02 -> RELEASED RELEASED vented
wrap, release, rearm, wrap -> TRACKING NONE wrapped
wrap, deactivate, radius 0.02 -> INACTIVE NOT_ACTIVE vented
wrap, measured, a leak -> TRACKING NONE held PRESSURE_LOW
faults vent, measured, wrap, a leak, until FAULT -> FAULT PRESSURE_LOW vented
faults vent, measured, wrap, a leak, until FAULT, measured, rearm, wrap -> TRACKING NONE wrapped
wrap, measured, a burst -> TRACKING NONE held PRESSURE_HIGH
wrap, measured, no number -> TRACKING NONE wrapped PRESSURE_INVALID
impatiently, wrap, measured, silence -> TRACKING NONE held PRESSURE_LOST
grasp, radius 0.03 -> GRASPING NONE wrapped; SUCCEEDED
measured, grasp -> GRASPING NONE wrapped; SUCCEEDED
wrap, grasp what is followed -> GRASPING NONE wrapped; SUCCEEDED
release, press -> GRASPING NONE held; SUCCEEDED
slowly, grasp, cancel -> RELEASED GRASP_CANCELED vented; canceled: GRASP_CANCELED
slowly, grasp, cancel, grasp what is followed -> RELEASED GRASP_CANCELED vented;
  canceled: GRASP_CANCELED; GRASP_CANCELED
slowly, grasp to hold, cancel -> GRASPING GRASP_CANCELED held; canceled: GRASP_CANCELED
slowly, grasp for 2 s -> RELEASED GRASP_TIMEOUT vented; GRASP_TIMEOUT
slowly, grasp, grasp another, fast -> GRASPING NONE wrapped; GRASP_REPLACED; SUCCEEDED
slowly, grasp, a burst -> RELEASED PRESSURE_HIGH vented PRESSURE_HIGH; PRESSURE_HIGH
slowly, grasp, release -> RELEASED RELEASED vented; RELEASED
slowly, grasp, another gripper -> RELEASED RECONFIGURED vented; RECONFIGURED
slowly, grasp, deactivate -> INACTIVE NOT_ACTIVE vented; NOT_ACTIVE
wrap, measured, open -> RELEASED RELEASED vented; SUCCEEDED
wrap, stuck, open -> RELEASED RELEASED vented PRESSURE_HIGH; PRESSURE_HIGH
impatiently, wrap, measured, silence, open -> RELEASED RELEASED vented PRESSURE_LOST;
  PRESSURE_LOST
faults vent, wrap, stuck, until FAULT, measured, open -> FAULT PRESSURE_LOW vented; SUCCEEDED
grasp too much -> WAITING NO_RADIUS vented; PRESSURE_CAP
grasp no radius -> WAITING NO_RADIUS vented; RADIUS_NOT_FINITE
grasp without end -> WAITING NO_RADIUS vented; INVALID_REQUEST
grasp what is followed -> WAITING NO_RADIUS vented; NO_RADIUS
press no number -> WAITING NO_RADIUS vented; INVALID_REQUEST
press more -> WAITING NO_RADIUS vented; INVALID_REQUEST
grasp no payload -> WAITING NO_RADIUS vented; INVALID_REQUEST
grasp no mode -> WAITING NO_RADIUS vented; INVALID_REQUEST
grasp no policy -> WAITING NO_RADIUS vented; INVALID_REQUEST
"""


class Live:
    """A node in a process of its own, and its clients."""

    def __init__(self, client, grasps, releases):
        self.client, self.grasps, self.releases, self.goals = client, grasps, releases, []

    def take(self, step):
        client = self.client
        if step in CHANGES:
            for item in CHANGES[step].items():
                client.change(*item)
        elif step in REGULATORS:
            client.regulator = REGULATORS[step]
            client.hear_more(20)
        elif step in GOALS:
            goal = self.grasps.send(Grasp.Goal(**GOALS[step]))
            self.goals.append(goal)
            client.wait_until(lambda: goal.is_done or goal.is_started, "its command")
        elif step == "open":
            self.goals.append(self.releases.send(Release.Goal(timeout=[2.0])))
        elif step.startswith("radius"):
            client.send_radius(float(step.split()[1]))
        elif step == "wrap":
            client.wrap(0.02)
        elif step == "cancel":
            assert self.goals[0].cancel()
        else:
            assert (
                client.transition(step) if step == "deactivate" else getattr(client, step)().success
            )

    def wait_until(self, condition):
        self.client.wait_until(condition, "the end")
        self.client.spin(0.1)

    def ending(self, goal):
        if not goal.is_done:
            return "RUNNING"
        status, result = goal.end()
        assert all_finite(result)
        assert result.message
        assert result.success is (status == GoalStatus.STATUS_SUCCEEDED)
        end = "SUCCEEDED" if result.success else Reason(result.reason).name
        return "canceled: " * (status == GoalStatus.STATUS_CANCELED) + end

    @property
    def told(self):
        """State, reason, grip, fault and the ends of the goals, in the words of a scenario."""
        seen = self.client.status
        grip = "vented" if seen.pressure_command == 0.0 else "wrapped" if seen.wrapped else "held"
        grip = grip if seen.pressure_command == seen.pressure_target else "on its way"
        fault = [Reason(seen.fault).name] if seen.fault else []
        words = State(seen.state).name, Reason(seen.reason).name, grip, *fault
        return "; ".join([" ".join(words), *map(self.ending, self.goals)])


@pytest.fixture(scope="module")
def actions(shared):
    actions = Goals(shared), Goals(shared, Release, "release")
    yield actions
    for goals in actions:
        goals.close()


@pytest.mark.parametrize("scenario", rows(SCENARIOS))
def test_a_live_node_ends_as_the_scenario_says(active, actions, scenario):
    steps, expected = scenario.split(" -> ")
    player = Live(active, *actions)
    for step in ("patiently", *steps.split(", ")):
        if step.startswith("until "):
            player.wait_until(lambda state=step[6:]: player.told.startswith(state))
        else:
            player.take(step)
    player.wait_until(lambda: player.told == expected)
    assert player.told == expected


def test_a_goal_tells_its_way(active, actions):
    active.change("pressure.rate_up", 5.0e4)
    goal = actions[0].grasp(0.02)
    result, feedback = goal.end()[1], goal.feedback
    progress = [one.progress for one in feedback]
    assert progress == sorted(progress)
    assert progress[0] < 0.1 < progress[-1] <= 1.0
    assert {one.pressure_target for one in feedback} == {result.pressure_command}
    assert feedback[0].regime == GripStatus.REGIME_OVERHANG
    assert feedback[-1].regime == GripStatus.REGIME_PERFECT_WRAP
    assert 3 <= len(feedback) <= 2 + result.elapsed / 0.1
    assert all_finite(*feedback)
    assert not goal.cancel()
