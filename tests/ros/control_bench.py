# SPDX-License-Identifier: Apache-2.0
"""The control logic with all it needs, and the steps of which courses are made."""

from collections import Counter
from dataclasses import replace

from ros.fakes import FakePlanner, FakeRegulator, RegulatorFault, regime_at

from spiral_core import SolverError, WrapRegime
from spiral_core.rod.state import RodStatus
from spiral_gripper_ros.control.grasp import GraspGoal, GraspOutcome
from spiral_gripper_ros.control.grip_control import GripControl
from spiral_gripper_ros.control.limits import AbortPolicy, FaultPolicy, Limits, TimeoutPolicy
from spiral_gripper_ros.control.refusals import RECONFIGURED
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal

LIMITS = Limits(
    pressure_cap=9.0e4,
    pressure_rate_up=1.0e5,
    pressure_rate_down=2.0e5,
    radius_timeout=0.5,
    grasp_timeout=3.0,
    measured_pressure_timeout=0.4,
    pressure_settle_time=0.3,
    pressure_tolerance=1.0e3,
)
TICK = 0.02
WRAP = 5.0e4  # of the bench's planner at 20 mm [Pa]
SUCCEEDED = GraspOutcome.SUCCEEDED


def rows(table):
    """Return the rows of a table; a line that is indented goes on with the one before."""
    return table.strip().replace("\n  ", " ").splitlines()


SHORT = """
track: run 1.5 0.02
hold: grasp; run 2
keeps: grasp abort_policy=AbortPolicy.HOLD
unmeasured: breaks fault=RegulatorFault.LOST
leaks: breaks fault=RegulatorFault.LEAK
sound: breaks fault=RegulatorFault.NONE
hang: leap 1; breaks pressure=0 latched=yes
cut: limit pressure_cap=3e4
raised: limit pressure_cap=9e4
unknown: limit grip_ratio=none
uncertified: gravity error=uncertified
certified: gravity error=none
heavy: gravity product=1.2e3
vents: limit pressure_fault_policy=FaultPolicy.VENT
restart: call activate take_over=yes
"""
SHORT = dict(row.split(": ") for row in rows(SHORT))
VALUES = {
    "none": None,
    "yes": True,
    "no": False,
    "reconfigured": RECONFIGURED,
    "uncertified": SolverError(RodStatus.UNSTABLE, 1.0, 7),
} | {
    str(one): one
    for kind in (AbortPolicy, FaultPolicy, TimeoutPolicy, WrapRegime, RegulatorFault)
    for one in kind
}


def value(word):
    try:
        return float(word)
    except ValueError:
        return VALUES.get(word, word)


def snapshot(state, refusal=NOT_REFUSED, **fields):
    """A snapshot of which nothing but its state is known, and these fields."""
    unknown = dict.fromkeys(("radius", "plan"))
    figures = dict.fromkeys(("pressure_target", "pressure_command", "accepted"), 0)
    return Snapshot(state, refusal, **unknown | figures | {"refused": Counter()} | fields)


class Steps:
    """What can do the steps of a course: "run 1 0.02; grasp radius=none timeout=0.3"."""

    def follow(self, course):
        """Take the steps of a course; return what the last one answers."""
        answer, steps = None, (SHORT.get(step, step) for step in course.split("; "))
        for step in "; ".join(steps).split("; "):
            name, *words = step.split()
            given = [value(word) for word in words if "=" not in word]
            named = (word.split("=") for word in words if "=" in word)
            answer = getattr(self, name)(*given, **{key: value(word) for key, word in named})
        return answer


class Bench(Steps):
    """The control logic, a regulator that may measure, and a clock that the test winds."""

    def __init__(self, limits=LIMITS):
        super().__init__()
        self.limits, self.control = limits, GripControl(limits)
        self.planner, self.regulator = FakePlanner(), FakeRegulator()
        self.sees, self.force, self.now, self.goals = "honest", None, 100.0, []
        self.control.activate()

    def run(self, duration, radius=None):
        """Tick for a while, with a radius before every tick if given; return the commands."""
        return [self.tick(radius) for _ in range(round(duration / TICK))]

    def tick(self, radius=None, period=TICK):
        """Return the command, or None where nothing is commanded."""
        self.now += period
        if radius is not None:
            self.radius(radius)
        measured = self.regulator.step(self.seen.pressure_command, period)
        if measured is not None:
            self.control.offer_measured(self.now, measured)
        command = self.command()
        self.look()
        return None if self.control.is_silent else command

    def radius(self, radius):
        return self.control.offer_radius(self.now, radius, self.planner)

    def hear(self, age=0.0):
        """Let gravity be heard."""
        self.control.hear_gravity(self.now, age)

    def command(self):
        return self.control.command(self.now)

    def look(self):
        """Observe the regime that it is to see, or what is honest."""
        seen, self.regime = self.seen, self.sees
        if self.sees == "honest":
            self.regime = seen.plan and regime_at(seen.pressure, seen.plan.pressure)
        self.control.observe(self.regime, self.force)

    def measure(self, *pressures):
        """Measure these pressures in turn for longer than all time-outs."""
        self.regulator.fault = RegulatorFault.STUCK
        for step in range(700):
            self.regulator.pressure = pressures[step % len(pressures)]
            self.tick()
        self.regulator.fault = RegulatorFault.NONE

    def grasp(self, radius=0.02, **goal):
        goal = GraspGoal(radius, **goal)
        self.goals.append(self.control.start_grasp(self.now, goal, self.planner))
        return self.goals[-1]

    def open(self, timeout=None):
        self.goals.append(self.control.start_release(self.now, ReleaseGoal(timeout)))

    def cancel(self):
        self.control.cancel(self.now, self.goals[-1])

    def call(self, name, *arguments, **named):
        """Call a method of the control logic."""
        return getattr(self.control, name)(*arguments, **named)

    def refused(self):
        self.control.refuse(Refusal(Reason.GRAVITY_INVALID, "gravity must be finite"))

    def give(self, **values):
        vars(self).update(values)

    def limit(self, **limits):
        self.limits = replace(self.limits, **limits)
        self.control.reconfigure(self.limits)

    def plan(self, **answers):
        """Change what the planner answers: its product, error, recommended, highest_good, loss."""
        vars(self.planner).update(answers)

    def gravity(self, **answers):
        """Change that, and plan anew."""
        self.plan(**answers)
        self.control.replan(self.planner)

    def breaks(self, **values):
        """Change fault and pressure of the regulator."""
        vars(self.regulator).update(values)

    def leap(self, duration):
        self.now += duration

    @property
    def seen(self):
        return self.control.snapshot()

    @property
    def state(self):
        return self.seen.state

    @property
    def reason(self):
        return self.seen.refusal.reason


def ending(goal):
    """Return "SUCCEEDED", "RUNNING", or the reason why a goal was refused, failed or canceled."""
    if isinstance(goal, Refusal):
        return goal.reason.name
    refusal = goal.report.refusal
    return goal.report.outcome.name if refusal is NOT_REFUSED else refusal.reason.name
