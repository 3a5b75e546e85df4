# SPDX-License-Identifier: Apache-2.0
"""The control logic under watch: what test_control_machine.py does anything to."""

import math
from collections import Counter
from typing import ClassVar

from hypothesis.stateful import RuleBasedStateMachine
from ros.fakes import FakePlanner, FakeRegulator, regime_at

from spiral_core import WrapRegime
from spiral_gripper_ros.control.grasp import GraspOutcome
from spiral_gripper_ros.control.grip_control import GripControl
from spiral_gripper_ros.control.limits import HIGHEST_GRIP_RATIO, FaultPolicy, Limits
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.control.target import LONGEST_STEP

# Half a second to the pressure of a wrap, so that a run of some ticks ends there.
SANE = Limits(pressure_cap=9.0e4, pressure_rate_up=1.0e5)
GRIPPING = {State.TRACKING, State.HOLDING, State.RAMPING_DOWN, State.GRASPING}
# What is left of a second's digits after a hundred leaps of the inner clock [s].
CLOCK_RESOLUTION = 1.0e-8


class ImmutablePlanner(FakePlanner):
    """Answers the same way forever, so that the machine can tell what it must have answered."""

    def __init__(self, product=1.0e3, error=None, recommended=None, highest_good=math.inf):
        super().__init__(product)
        self.error, self.recommended, self.highest_good = error, recommended, highest_good

    def pressure(self, radius):
        """Return the pressure for a radius; NaN if there is none."""
        try:
            pressure = self.plan(radius).pressure
        except Exception:
            return math.nan
        return pressure if 0.0 < pressure < math.inf else math.nan


class CheckedControl(RuleBasedStateMachine):
    """The control logic and a regulator, called as the node does; every command is checked."""

    tally: ClassVar[Counter] = Counter()  # of states and ends

    def __init__(self):
        super().__init__()
        self.limits = SANE
        self.control = GripControl(SANE)
        self.planner = ImmutablePlanner()
        self.regulator = FakeRegulator()
        self.eyes = "honest"
        self.now = 0.0
        self.read = None  # what the clock said last
        self.elapsed = 0.0  # since the last command, as the control logic may count it
        self.last = 0.0
        self.timeouts = {}  # by grasp
        self.ended = {}  # final reports by grasp
        self.overpressure = 0.0  # of the newest grasp; None: the default one
        self.regime = None  # seen since it began
        self.ceiling = math.inf  # the lowest cap since the newest goal

    # --- calling it as the node does --------------------------------------------------------

    def time(self):
        """Return what the clock says, and count the time as the control logic may."""
        if self.read is not None:
            self.elapsed += max(self.now - self.read, 0.0)
        self.read = self.now
        return self.now

    def guarded(self, call, *arguments):
        """Call as the node's guards do: an exception that is not expected is a fault."""
        try:
            return call(*arguments)
        except ZeroDivisionError:
            self.control.fail("a planner broke")
            return None

    def command(self):
        """Let it command, and check the command."""
        before, running = self.control.snapshot(), self.running()
        command = self.control.command(self.time())
        seen, limits = self.control.snapshot(), self.limits
        step = min(self.elapsed + CLOCK_RESOLUTION, LONGEST_STEP)
        assert 0.0 <= command <= limits.pressure_cap
        assert command - self.last <= limits.pressure_rate_up * step * (1.0 + 1e-9)
        assert command == seen.pressure_command
        if seen.state in GRIPPING:
            lowest = before.pressure_command - limits.pressure_rate_down * step * (1.0 + 1e-9)
            assert command >= min(lowest, limits.pressure_cap)
        for grasp in running:
            self.check_grasp(grasp, seen)
        self.check_fault(before, seen)
        self.last, self.elapsed = command, 0.0

    def check_grasp(self, grasp, seen):
        """Check a grasp that ran before the command."""
        report = grasp.report
        if report.outcome is GraspOutcome.RUNNING:
            assert report.elapsed <= self.timeouts[grasp]
            assert seen.pressure_fault.reason is Reason.NONE
        if report.outcome is GraspOutcome.SUCCEEDED:
            assert (seen.state, seen.refusal.reason) == (State.GRASPING, Reason.NONE)
            assert seen.pressure_command == seen.pressure_target
            assert self.is_held()

    def check_fault(self, before, seen):
        """Check that a fault of the measured pressure vents if the policy says so."""
        is_fault = seen.pressure_fault.reason is not Reason.NONE
        if is_fault and self.limits.pressure_fault_policy is FaultPolicy.VENT:
            assert seen.state in (State.INACTIVE, State.FAULT)
            if before.state not in (State.INACTIVE, State.FAULT):
                assert seen.refusal == seen.pressure_fault

    def is_held(self):
        """Return whether the regime seen last holds the object in use."""
        seen = self.control.snapshot()
        over = seen.overpressure
        if seen.state is State.GRASPING and self.overpressure is not None:
            over = self.overpressure
        curls = self.regime is WrapRegime.CURLING and over > 0.0
        return curls or self.regime is WrapRegime.PERFECT_WRAP

    def tick(self, period=0.02, radius=None):
        """Let one period of the node's timer pass, and look at how the object is held."""
        self.now += period
        if radius is not None:
            self.guarded(self.control.offer_radius, self.time(), radius, self.planner)
        measured = self.regulator.step(self.last, period)
        if measured is not None:
            self.control.offer_measured(self.time(), measured)
        self.command()
        seen, self.regime = self.control.snapshot(), self.eyes
        if self.regime == "honest":
            self.regime = seen.plan and regime_at(seen.pressure, seen.plan.pressure)
        self.control.observe(self.time(), self.regime)
        is_heard = seen.pressure_fault.reason is not Reason.PRESSURE_LOST
        wrapped = seen.radius is not None and is_heard and self.is_held()
        assert self.control.snapshot().wrapped is wrapped

    def running(self):
        """Return the grasps that run."""
        return [grasp for grasp in self.timeouts if grasp.report.outcome is GraspOutcome.RUNNING]

    def is_possible(self, seen):
        """Return whether the wrap of the newest grasp is what the planner says, within the cap."""
        pressure = self.planner.pressure(seen.radius)
        if not pressure + (self.overpressure or 0.0) <= self.ceiling:
            return False
        assert seen.plan.pressure == pressure
        if self.overpressure is None:
            highest = min(self.highest(pressure), self.ceiling)
            assert pressure <= seen.pressure_target <= max(pressure, highest)
        else:
            assert seen.pressure_target == pressure + self.overpressure
        return True

    def highest(self, wrap):
        """Return the largest pressure of a default grip on a wrap, without a cap [Pa]."""
        most = max(HIGHEST_GRIP_RATIO, self.planner.recommended or 0.0)
        return min(most * (1.0 + 1e-9), self.planner.highest_good) * wrap
