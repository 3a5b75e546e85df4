# SPDX-License-Identifier: Apache-2.0
"""The control logic with all it needs, for tests of what it does step by step."""

from ros.fakes import FakePlanner, FakeRegulator, RegulatorFault, regime_at

from spiral_gripper_ros.control.grasp import GraspGoal, GraspOutcome
from spiral_gripper_ros.control.grip_control import GripControl
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.states import Reason

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
RUNNING, SUCCEEDED = GraspOutcome.RUNNING, GraspOutcome.SUCCEEDED
FAILED, CANCELED = GraspOutcome.FAILED, GraspOutcome.CANCELED
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

    def __init__(self, limits=LIMITS, *, measured=True):
        self.control = GripControl(limits)
        self.planner = FakePlanner()
        self.regulator = FakeRegulator()
        self.is_measured = measured
        self.sees = regime_at
        self.now = 100.0
        self.control.activate()

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
            pressure = seen.measured.pressure if seen.measured else seen.pressure_command
            regime = self.sees(pressure, seen.plan.pressure)
        self.control.observe(self.now, regime)

    def grasp(self, radius=0.02, **goal):
        return self.control.start_grasp(self.now, GraspGoal(radius, **goal), self.planner)

    def end(self, grasp, longest=5.0):
        """Tick until a grasp ends; return how and why."""
        start = self.now
        while grasp.report.outcome is RUNNING:
            assert self.now - start <= longest, "it does not end"
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
