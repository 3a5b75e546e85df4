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
RUNNING, SUCCEEDED = GraspOutcome.RUNNING, GraspOutcome.SUCCEEDED
FAILED, CANCELED = GraspOutcome.FAILED, GraspOutcome.CANCELED
NOT_CERTIFIED = SolverError(RodStatus.UNSTABLE, 1.0, 7)
# What can be wrong with a regulator, the pressure at which it is stuck, and what that is called.
FAULTS = [
    ("leak", 0.0, Reason.PRESSURE_LOW),
    ("stuck", 0.0, Reason.PRESSURE_LOW),
    ("stuck", 9.0e4, Reason.PRESSURE_HIGH),
    ("lost", 0.0, Reason.PRESSURE_LOST),
    ("unplugged", 0.0, Reason.PRESSURE_INVALID),
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

    def follow(self, course):
        """Take the steps of a course; return what the last one answers."""
        return play(self, course)

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


# --- steps, as words: "wait 1 0.02", "goal radius=none timeout=0.3", "call release" ---------------


def wait(bench, duration, radius=None):
    return bench.run(duration, radius)


def goal(bench, radius=0.02, **fields):
    return bench.grasp(radius, **fields)


def given(bench, **values):
    """Set attributes of the bench; the regime that it sees is one, or what is honest."""
    regime = values.pop("sees", "honest")
    if regime != "honest":
        values["sees"] = lambda pressure, perfect: regime
    vars(bench).update(values)


def limit(bench, **limits):
    bench.limits = replace(bench.limits, **limits)
    bench.control.reconfigure(bench.limits)


def gravity(bench, **planner):
    """Change what the planner answers: its product, error, recommended and highest_good."""
    vars(bench.planner).update(planner)
    bench.control.replan(bench.planner)


def fails(bench):
    """Let the planner certify nothing from now on."""
    bench.planner.error = NOT_CERTIFIED


def breaks(bench, fault, pressure=None):
    bench.regulator.fault = fault
    if pressure is not None:
        bench.regulator.pressure = pressure


def call(bench, name, *arguments):
    """Call a method of the control logic."""
    return getattr(bench.control, name)(*arguments)


def refused(bench):
    bench.control.refuse(Refusal(Reason.GRAVITY_INVALID, "gravity must be finite"))


def leap(bench, duration):
    bench.now += duration


def cancel(bench):
    bench.control.cancel(bench.now, bench.grasped)


def hang(bench):
    """Let the node hang, and the regulator's watchdog vent meanwhile."""
    bench.now += 1.0
    bench.regulator.pressure, bench.regulator.latched = 0.0, True


def offer(bench, radius):
    return bench.radius(radius)


def measure(bench, pressure):
    """Start again, and measure the same pressure for long enough."""
    bench.control.activate(take_over=True)
    bench.regulator.pressure = pressure
    for _ in range(14):
        bench.now += TICK
        bench.control.offer_measured(bench.now, pressure)
        bench.control.command(bench.now)


def notice(bench):
    """Wait for a fault of the pressure."""
    while not bench.seen.pressure_fault.text:
        bench.tick()


STEPS = {
    step.__name__: step
    for step in (
        wait,
        goal,
        given,
        limit,
        gravity,
        fails,
        breaks,
        call,
        refused,
        leap,
        cancel,
        hang,
        offer,
        measure,
        notice,
    )
}
SHORT = {
    "track": "wait 1.5 0.02",
    "hold": "goal; wait 2",
    "keeps": "goal abort_policy=hold",
    "unmeasured": "given is_measured=no",
    "cut": "limit pressure_cap=3e4",
    "raised": "limit pressure_cap=9e4",
    "unknown": "limit grip_ratio=none",
    "uncertified": "gravity error=uncertified",
    "certified": "gravity error=none",
    "heavy": "gravity product=1.2e3",
    "vents": "limit pressure_fault_policy=vent_at",
    "leaks": "breaks leak",
}
VALUES = {
    "none": None,
    "no": False,
    "yes": True,
    "reconfigured": RECONFIGURED,
    "uncertified": NOT_CERTIFIED,
    "hold": AbortPolicy.HOLD,
    "vent": AbortPolicy.VENT,
    "vent_at": FaultPolicy.VENT,
    "report": FaultPolicy.REPORT,
    "stale_hold": TimeoutPolicy.HOLD,
    "stale_vent": TimeoutPolicy.VENT,
    "stale_ramp": TimeoutPolicy.RAMP_DOWN,
    "curling": WrapRegime.CURLING,
    "overhang": WrapRegime.OVERHANG,
    **{fault.value: fault for fault in RegulatorFault},
}


def rows(table):
    """Return the rows of a table; a line that is indented goes on with the one before."""
    return table.strip().replace("\n  ", " ").splitlines()


def value(word):
    try:
        return float(word)
    except ValueError:
        return VALUES.get(word, word)


def play(bench, course):
    """Take the steps of a course; return what the last one answers."""
    answer = None
    for text in filter(None, map(str.strip, course.split(";"))):
        if text in SHORT:
            answer = play(bench, SHORT[text])
            continue
        name, *words = text.split()
        named = dict(word.split("=") for word in words if "=" in word)
        positional = [value(word) for word in words if "=" not in word]
        answer = STEPS[name](bench, *positional, **{k: value(v) for k, v in named.items()})
    return answer
