# SPDX-License-Identifier: Apache-2.0
"""The control logic with all it needs, and the steps of which courses are made."""

from collections import Counter
from dataclasses import replace

from ros.fakes import FakePlanner, FakeRegulator, RegulatorFault, regime_at

from spiral_core import SolverError
from spiral_core.rod.state import RodStatus
from spiral_gripper_ros.control.grasp import GraspGoal, GraspOutcome
from spiral_gripper_ros.control.grip_control import GripControl
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason

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
RUNNING, SUCCEEDED = GraspOutcome.RUNNING, GraspOutcome.SUCCEEDED
FAILED, CANCELED = GraspOutcome.FAILED, GraspOutcome.CANCELED
NOT_CERTIFIED = SolverError(RodStatus.UNSTABLE, 1.0, 7)
# What can be wrong with a regulator, the pressure at which it is stuck, and what that is called.
FAULTS = [
    (RegulatorFault.LEAK, 0.0, Reason.PRESSURE_LOW),
    (RegulatorFault.STUCK, 0.0, Reason.PRESSURE_LOW),
    (RegulatorFault.STUCK, 9.0e4, Reason.PRESSURE_HIGH),
    (RegulatorFault.LOST, 0.0, Reason.PRESSURE_LOST),
    (RegulatorFault.NAN, 0.0, Reason.PRESSURE_INVALID),
]


class Bench:
    """The control logic, a regulator that may measure, and a clock that the test winds."""

    def __init__(self, **limits):
        self.limits = replace(LIMITS, **limits)
        self.control = GripControl(self.limits)
        self.planner = FakePlanner()
        self.regulator = FakeRegulator()
        self.is_measured = True
        self.sees = regime_at
        self.now = 100.0
        self.grasped = None
        self.control.activate()

    def follow(self, *course):
        """Take steps; return what the last one answers."""
        answer = None
        for step in course:
            answer = step(self)
        return answer

    def run(self, duration, radius=None):
        """Tick for a while, with a radius before every tick if given; return the commands."""
        return [self.tick(radius) for _ in range(round(duration / TICK))]

    def tick(self, radius=None):
        self.now += TICK
        if radius is not None:
            self.radius(radius)
        measured = self.regulator.step(self.seen.pressure_command, TICK)
        if self.is_measured and measured is not None:
            self.control.offer_measured(self.now, measured)
        command = self.control.command(self.now)
        self.look()
        return command

    def radius(self, radius):
        return self.control.offer_radius(self.now, radius, self.planner)

    def look(self):
        seen, regime = self.seen, None
        if seen.plan is not None:
            regime = self.sees(seen.pressure, seen.plan.pressure)
        self.control.observe(self.now, regime)

    def grasp(self, radius=0.02, **goal):
        self.grasped = self.control.start_grasp(self.now, GraspGoal(radius, **goal), self.planner)
        return self.grasped

    def end(self, grasp):
        """Tick until a grasp ends; return how and why."""
        start = self.now
        while grasp.report.outcome is RUNNING:
            assert self.now - start <= 5.0, "it does not end"
            self.tick()
        return grasp.report.outcome, grasp.report.refusal.reason

    @property
    def seen(self):
        return self.control.snapshot()

    @property
    def state(self):
        return self.seen.state

    @property
    def reason(self):
        return self.seen.refusal.reason


def snapshot(state, refusal=NOT_REFUSED, **fields):
    """A snapshot of which nothing but its state is known, and these fields."""
    unknown = dict.fromkeys(("radius", "plan", "radius_age"))
    figures = {"pressure_target": 0.0, "pressure_command": 0.0, "accepted": 0, "refused": Counter()}
    return Snapshot(**{"state": state, "refusal": refusal} | unknown | figures | fields)


# --- steps ---------------------------------------------------------------------------------------


def wait(duration, radius=None):
    return lambda bench: bench.run(duration, radius)


def goal(radius=0.02, **fields):
    return lambda bench: bench.grasp(radius, **fields)


def given(**values):
    """Set attributes of the bench."""
    return lambda bench: vars(bench).update(values)


def limit(**limits):
    def reconfigure(bench):
        bench.limits = replace(bench.limits, **limits)
        bench.control.reconfigure(bench.limits)

    return reconfigure


def gravity(**planner):
    """Change what the planner answers: its product, error, recommended and highest_good."""

    def turn(bench):
        vars(bench.planner).update(planner)
        bench.control.replan(bench.planner)

    return turn


def breaks(fault, pressure=None):
    def change(bench):
        bench.regulator.fault = fault
        if pressure is not None:
            bench.regulator.pressure = pressure

    return change


def call(name, *arguments, **named):
    """Call a method of the control logic."""
    return lambda bench: getattr(bench.control, name)(*arguments, **named)


def leap(duration):
    return lambda bench: vars(bench).update(now=bench.now + duration)


def cancel(bench):
    bench.control.cancel(bench.now, bench.grasped)


def hang(bench):
    """Let the node hang, and the regulator's watchdog vent meanwhile."""
    bench.now += 1.0
    bench.regulator.pressure, bench.regulator.latched = 0.0, True


track = wait(1.5, 0.02)
hold = (goal(), wait(2.0))
