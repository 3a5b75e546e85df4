# SPDX-License-Identifier: Apache-2.0
"""One list of scenarios, played on the control logic and on a live node: both end alike."""

import math

import pytest
from action_msgs.msg import GoalStatus
from ros.control_bench import CANCELED, FAILED, SUCCEEDED, Bench, rows, value
from ros.grasp_goals import Goals
from ros.harness import all_finite

from spiral_gripper_msgs.action import Grasp, Release
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.grasp import GraspOutcome
from spiral_gripper_ros.control.limits import AbortPolicy
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.control.states import Reason, Refusal, State

OUTCOMES = {
    GoalStatus.STATUS_SUCCEEDED: SUCCEEDED,
    GoalStatus.STATUS_CANCELED: CANCELED,
    GoalStatus.STATUS_ABORTED: FAILED,
}
POLICIES = [None, AbortPolicy.VENT, AbortPolicy.HOLD]
# What a step of a scenario is for the node (a parameter, a regulator), and for the logic.
CHANGES = {
    "patiently": {
        "radius.timeout": 600.0,
        "measured_pressure.timeout": 600.0,
        "radius.rate_limit": 1.0e-4,  # a jump remains one however long it takes
        "pressure.settle_time": 0.3,
    },
    "impatiently": {"measured_pressure.timeout": 0.5},
    "slowly": {"pressure.rate_up": 500.0},
    "fast": {"pressure.rate_up": 2.0e6},
    "faults vent": {"pressure.fault_policy": "vent"},
    "another gripper": {"gripper": "prototype_p1"},
}
REGULATORS = {
    "measured": lambda command: command,
    "a leak": lambda command: 0.7 * command,
    "a burst": lambda command: command + 1.0e5,
    "no number": lambda command: math.nan,
    "stuck": lambda command: 4.0e4,
    "silence": None,
}
LOGIC = {
    "patiently": (
        "limit radius_timeout=600 measured_pressure_timeout=600 radius_rate_limit=1e-4; unmeasured"
    ),
    "impatiently": "limit measured_pressure_timeout=0.5",
    "slowly": "limit pressure_rate_up=500",
    "fast": "limit pressure_rate_up=2e6",
    "faults vent": "vents",
    "another gripper": "call release reconfigured",
    "measured": "given is_measured=yes; breaks sound; wait 0.5",
    "a leak": "breaks leak",
    "a burst": "given is_measured=yes; breaks absolute",
    "no number": "breaks unplugged; wait 0.5",
    "stuck": "given is_measured=yes; breaks stuck 4e4; wait 0.02",
    "silence": "given is_measured=no",
    "wrap": "wait 1.5 0.02",
}
GOALS = {
    "grasp": "",
    "grasp another": "radius=0.025",
    "grasp what is followed": "radius=none overpressure=1e3",
    "press": "radius=none pressure=3e4",
    "grasp for 2 s": "timeout=2",
    "grasp to hold": "abort_policy=hold",
    "grasp too much": "overpressure=1e6",
    "grasp no radius": "radius=nan",
    "grasp without end": "timeout=inf",
    "press no number": "radius=none pressure=nan",
    "press more": "radius=none pressure=1e4 overpressure=1",
}
# The steps -> state, reason, what is gripped (where that differs, the fault); the goal's end.
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
grasp, radius 0.03 -> GRASPING NONE wrapped; SUCCEEDED NONE
measured, grasp -> GRASPING NONE wrapped; SUCCEEDED NONE
wrap, grasp what is followed -> GRASPING NONE wrapped; SUCCEEDED NONE
release, press -> GRASPING NONE held; SUCCEEDED NONE
slowly, grasp, cancel -> RELEASED GRASP_CANCELED vented; CANCELED GRASP_CANCELED
slowly, grasp to hold, cancel -> GRASPING GRASP_CANCELED held; CANCELED GRASP_CANCELED
slowly, grasp for 2 s -> RELEASED GRASP_TIMEOUT vented; FAILED GRASP_TIMEOUT
slowly, grasp, grasp another, fast -> GRASPING NONE wrapped; FAILED GRASP_REPLACED
slowly, grasp, a burst -> RELEASED PRESSURE_HIGH vented PRESSURE_HIGH; FAILED PRESSURE_HIGH
slowly, grasp, release -> RELEASED RELEASED vented; FAILED RELEASED
slowly, grasp, another gripper -> RELEASED RECONFIGURED vented; FAILED RECONFIGURED
slowly, grasp, deactivate -> INACTIVE NOT_ACTIVE vented; FAILED NOT_ACTIVE
wrap, measured, open -> RELEASED RELEASED vented; SUCCEEDED NONE
wrap, stuck, open -> RELEASED RELEASED vented PRESSURE_HIGH; FAILED PRESSURE_HIGH
impatiently, wrap, measured, silence, open -> RELEASED RELEASED vented PRESSURE_LOST;
  FAILED PRESSURE_LOST
faults vent, wrap, stuck, until FAULT, measured, open -> FAULT PRESSURE_LOW vented; SUCCEEDED NONE
grasp too much -> WAITING NO_RADIUS vented; FAILED PRESSURE_CAP
grasp no radius -> WAITING NO_RADIUS vented; FAILED RADIUS_NOT_FINITE
grasp without end -> WAITING NO_RADIUS vented; FAILED INVALID_REQUEST
grasp what is followed -> WAITING NO_RADIUS vented; FAILED NO_RADIUS
press no number -> WAITING NO_RADIUS vented; FAILED INVALID_REQUEST
press more -> WAITING NO_RADIUS vented; FAILED INVALID_REQUEST
"""


class Logic(Bench):
    """The control logic, whose time passes as fast as it is computed."""

    goal = None

    def take(self, step):
        if step in GOALS:
            answer = self.follow(f"goal {GOALS[step]}")
            self.goal = self.goal or answer
            self.run(0.2)
        elif step == "open":
            self.goal = self.grasped = self.control.start_release(self.now, ReleaseGoal(2.0))
        elif step.startswith("radius"):
            self.tick(float(step.split()[1]))
        else:
            self.follow(step if step == "cancel" else LOGIC.get(step, f"call {step}"))

    def wait_until(self, condition):
        for _ in range(500):
            if condition():
                break
            self.tick()
        self.run(0.2)

    @property
    def why(self):
        return self.seen, self.state, self.reason, self.seen.pressure_fault.reason

    @property
    def ended(self):
        if isinstance(self.goal, Refusal):
            return FAILED, self.goal.reason
        return self.goal and (self.goal.report.outcome, self.goal.report.refusal.reason)


class Live:
    """A node in a process of its own, and its clients."""

    def __init__(self, client, grasps, releases):
        self.client, self.grasps, self.releases, self.goal = client, grasps, releases, None

    def take(self, step):
        client = self.client
        if step in CHANGES:
            for item in CHANGES[step].items():
                client.change(*item)
        elif step in REGULATORS:
            client.regulator = REGULATORS[step]
            client.hear_more(20)
        elif step in GOALS:
            words = (word.split("=") for word in GOALS[step].split())
            self.grasp(**{name: value(word) for name, word in words})
        elif step == "open":
            self.goal = self.releases.send(Release.Goal(timeout=[2.0]))
        elif step.startswith("radius"):
            client.send_radius(float(step.split()[1]))
        elif step == "wrap":
            client.wrap(0.02)
        elif step == "deactivate":
            assert client.transition(step)
        else:
            assert self.goal.cancel() if step == "cancel" else getattr(client, step)().success

    def grasp(self, radius=0.02, pressure=None, abort_policy=None, **numbers):
        mode = Grasp.Goal.MODE_FOLLOWED if radius is None else Grasp.Goal.MODE_RADIUS
        fields = {name: [number] for name, number in numbers.items()}
        goal = self.grasps.send(
            Grasp.Goal(
                mode=mode if pressure is None else Grasp.Goal.MODE_PRESSURE,
                object_radius=radius or 0.0,
                pressure=pressure or 0.0,
                abort_policy=POLICIES.index(abort_policy),
                **fields,
            )
        )
        self.goal = self.goal or goal
        self.client.wait_until(
            lambda: goal.is_done or (goal.feedback and goal.feedback[-1].pressure_command > 0.0),
            "its command",
        )

    def wait_until(self, condition):
        self.client.wait_until(condition, "the end")
        self.client.spin(0.1)

    @property
    def why(self):
        status = self.client.status
        return status, status.state, status.reason, status.fault

    @property
    def ended(self):
        if self.goal is None or not self.goal.is_done:
            return None
        status, result = self.goal.end()
        assert all_finite(result)
        assert result.success is (status == GoalStatus.STATUS_SUCCEEDED)
        assert result.message
        return OUTCOMES[status], result.reason


@pytest.fixture(scope="module")
def actions(shared):
    actions = Goals(shared), Goals(shared, Release, "release")
    yield actions
    for goals in actions:
        goals.close()


@pytest.fixture(params=["logic", "live"])
def player(request):
    if request.param == "logic":
        return Logic()
    return Live(request.getfixturevalue("active"), *request.getfixturevalue("actions"))


@pytest.mark.parametrize("scenario", rows(SCENARIOS))
def test_the_logic_and_a_live_node_end_as_the_scenario_says(player, scenario):
    steps, expected = scenario.split(" -> ")
    for step in ("patiently", *steps.split(", ")):
        if step.startswith("until "):
            player.wait_until(lambda state=State[step[6:]]: player.why[1] == state)
        else:
            player.take(step)
    expected, _, end = expected.partition("; ")
    state, reason, grip, fault = (*expected.split(), "NONE")[:4]
    outcome = end and (GraspOutcome[end.split()[0]], Reason[end.split()[1]])

    def found():
        seen, *why = player.why
        grip = "vented" if seen.pressure_command == 0.0 else "wrapped" if seen.wrapped else "held"
        return *why, seen.pressure_command == seen.pressure_target and grip, player.ended or ""

    wanted = (State[state], Reason[reason], Reason[fault], grip, outcome)
    player.wait_until(lambda: found() == wanted)
    assert found() == wanted


def test_a_goal_tells_its_way_and_its_figures(active, actions, curve):
    active.change("pressure.rate_up", 5.0e4)
    wrap, (grasps, _) = curve.wrap_for_radius(0.02), actions
    goal = grasps.grasp(0.02)
    _, result = goal.end()
    assert result.pressure_command == pytest.approx(wrap.pressure, rel=1e-9)
    assert "as commanded" in result.message
    assert result.figures[0].turns == pytest.approx(wrap.turns, rel=1e-6)
    progress = [feedback.progress for feedback in goal.feedback]
    assert progress == sorted(progress)
    assert progress[0] < 0.1 < progress[-1] <= 1.0
    assert {feedback.pressure_target for feedback in goal.feedback} == {result.pressure_command}
    assert goal.feedback[0].regime == GripStatus.REGIME_OVERHANG
    assert goal.feedback[-1].regime == GripStatus.REGIME_PERFECT_WRAP
    assert 3 <= len(goal.feedback) <= 2 + result.elapsed / 0.1
    assert all_finite(*goal.feedback)
    assert not goal.cancel()


def test_the_measured_shape_is_that_at_the_measured_pressure(active, curve):
    active.change("pressure.tolerance", 5.0e4)
    active.regulator = REGULATORS["a leak"]
    expected = curve.state_at_pressure(0.7 * active.wrap(0.02).pressure_command).tip_position

    def tip():
        point = active.measured_backbones[-1].poses[-1].position
        return point.x, point.y, point.z

    # Changes up to 50 Pa keep the shape, which move the tip by 0.35 mm.
    active.wait_until(
        lambda: active.measured_backbones and tip() == pytest.approx(expected, abs=5e-4), "it"
    )
    measured = pytest.approx([0.7 * active.pressures[-1]], rel=1e-3)  # smoothed
    active.wait_until(lambda: list(active.status.measured_pressure) == measured, "its pressure")
    assert active.status.regime == GripStatus.REGIME_OVERHANG
