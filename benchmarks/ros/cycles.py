# SPDX-License-Identifier: Apache-2.0
"""Wrap, lift, release, again and again, with faults at random: ``python -m benchmarks.ros.cycles``.

The real node in this process, the simulator's regulator, and a time that runs as fast as they
compute. The window of good grips is known (``--grip-radii``), from grips that are solved first.
Every command that the node publishes is judged. Unsafe is a command that is not finite, below 0 or
above the cap; that rises faster than its rate; that inflates what is vented; or that lets go of an
object although nothing has happened that may. Untrue is a grasp or release that succeeds while the
regulator's real pressure is another.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from random import Random
from typing import Any

import rclpy
from geometry_msgs.msg import Vector3Stamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Empty, Float64
from std_srvs.srv import Trigger

from benchmarks.ros.grip_bank import GripBank
from spiral_gripper import load_gripper
from spiral_gripper_ros.control.grasp import Grasp, GraspGoal, GraspOutcome
from spiral_gripper_ros.control.limits import AbortPolicy
from spiral_gripper_ros.control.release import Release, ReleaseGoal
from spiral_gripper_ros.control.states import Reason, Refusal, State
from spiral_gripper_ros.control.target import LONGEST_STEP
from spiral_gripper_ros.node.gripper_node import GripperNode
from spiral_gripper_ros.simulation.regulator import (
    Fault,
    SimulatedRegulator,
    SimulatedRegulatorParameters,
)

TICK = 0.02
NOISE = 1.0e3  # of the measured pressure, at most [Pa]
WRAP_TIME, LIFT_TIME, RELEASE_TIME = 1.4, 0.8, 0.5
# What may let go of an object, by its reason; the first are wishes, the rest need their faults.
WISHES = {Reason.NO_RADIUS, Reason.NOT_ACTIVE, Reason.RELEASED, Reason.GRASP_CANCELED}
# First readings of a sensor that cannot be taken over [Pa].
DISAGREEING = ((2.5e5,), (101325.0,), (0.0, 6.275e4))
GRAVITIES = ((9.80665, 0.0, 0.0), (0.0, 0.0, -9.80665), (6.9, 6.9, 0.0))


class UnsafeCommandError(Exception):
    """A command, or a success, that must not be."""


class Rig:
    """One node, one regulator, one clock.

    Args:
        seed: of everything that is random.
        grip_radii: whose grips answer questions; 0: no grip is known, not even of the table.
    """

    def __init__(self, seed: int, grip_radii: int = 0) -> None:
        self.random = Random(seed)
        self.time = 100.0
        self.commands = self.cycles = self.wrapped = 0
        self.happened: Counter[str] = Counter()
        self.allowed: set[Reason] = set(WISHES)
        self._last = (self.time, 0.0)
        self._takes_over = False
        self._goals: list[Grasp | Release] = []  # that run
        self.succeeded = 0
        self.node = GripperNode(
            namespace=f"/cycles_{seed}",
            parameter_overrides=[
                Parameter("pressure.fault_policy", value="vent"),
                Parameter("keep_alive.timeout", value=1.0),
                Parameter("gravity.timeout", value=5.0),
                Parameter("activation", value="take_over"),
                Parameter("publish.marker_rate", value=0.0),
                Parameter("pressure.rate_up", value=1.0e5),  # a wrap within WRAP_TIME
                Parameter("grip.contact", value=grip_radii > 0),
            ],
        )
        if grip_radii:
            gripper = load_gripper(self.node.runtime.values.gripper)
            self.grips = GripBank(gripper, grip_radii, self.random)
            self.node.runtime.background.grips = self.grips  # type: ignore[assignment]
        self.node.runtime.outputs.publish_pressure = self._judge  # type: ignore[method-assign]
        self.node.runtime.now = lambda: self.time  # type: ignore[method-assign]
        self.model = SimulatedRegulatorParameters(seed=seed)
        self.regulator = SimulatedRegulator(self.model)
        self.radius: float | None = None
        self.is_client_alive = True
        self.sends_radii = True
        if not self.node.start():
            raise RuntimeError("the node does not start")

    def _judge(self, pressure: float) -> None:
        """Look at one command, as the regulator gets it."""
        self.commands += 1
        seen, cap = self.node.runtime.control.snapshot(), self.node.runtime.limits.pressure_cap
        then, before = self._last
        self._last = (self.time, pressure)
        step = min(max(self.time - then, 0.0), LONGEST_STEP)
        rise = self.node.runtime.limits.pressure_rate_up * step * (1.0 + 1e-9)
        if not (math.isfinite(pressure) and 0.0 <= pressure <= cap):
            self._complain(f"{pressure} Pa is outside 0 to {cap} Pa")
        if self._takes_over:  # from what is measured, as far as noise lets it be known
            before = max(before, self.regulator.pressure + NOISE)
            self._takes_over = False
        if pressure - before > rise:
            self._complain(f"{before} to {pressure} Pa within {step} s")
        if seen.state in (State.INACTIVE, State.RELEASED, State.FAULT, State.WAITING) and pressure:
            self._complain(f"{pressure} Pa in {seen.state.name}")
        if before > 0.0 and pressure == 0.0 and seen.refusal.reason not in self.allowed:
            self._complain(f"let go because of {seen.refusal.reason.name}: {seen.refusal.text}")
        self._judge_successes(seen.pressure_target)
        self.regulator.command(pressure)

    def _complain(self, text: str) -> None:
        raise UnsafeCommandError(f"cycle {self.cycles}, {self.time:.2f} s: {text}")

    def tick(self) -> None:
        """Let one period pass: regulator, sensors, client, control loop."""
        self.time += TICK
        self.regulator.step(TICK)
        measured = self.regulator.report()
        if measured is not None:
            self.hear("measured_pressure", Float64(data=measured))
        if self.is_client_alive:
            self.hear("keep_alive", Empty())
        if self.radius is not None and self.sends_radii:
            noise = self.random.gauss(0.0, 2.0e-5)
            self.hear("object_radius", Float64(data=self.radius + noise))
        self.call_timers()
        if self.node.runtime.errors.count:
            self._complain("an exception: see the log")

    def _judge_successes(self, target: float) -> None:
        """Compare what has succeeded at a target [Pa] with the pressure that is really there."""
        running = []
        for goal in self._goals:
            outcome, is_release = goal.report.outcome, isinstance(goal, Release)
            if outcome is GraspOutcome.RUNNING:
                running.append(goal)
            elif outcome is GraspOutcome.SUCCEEDED:
                self.succeeded += 1
                wanted, real = 0.0 if is_release else target, self.regulator.pressure
                if abs(real - wanted) > self.node.runtime.limits.pressure_tolerance + NOISE:
                    name = "release" if is_release else "grasp"
                    self._complain(f"untrue: a {name} to {wanted} Pa succeeded at {real} Pa")
        self._goals = running

    def run(self, duration: float) -> None:
        """Let some time pass [s]."""
        for _ in range(round(duration / TICK)):
            self.tick()

    def hear(self, topic: str, message: object) -> None:
        """Deliver a message as the executor would."""
        for subscription in self.node.subscriptions:
            if subscription.topic_name.rpartition("/")[2] == topic:
                subscription.callback(message)
                return

    def call(self, name: str, request: Any = None) -> Any:  # noqa: ANN401
        """Call a service, as a rule a trigger; return its answer."""
        for service in self.node.services:
            if service.srv_name.rpartition("/")[2] == name:
                return service.callback(request or Trigger.Request(), service.srv_type.Response())
        raise LookupError(name)

    def call_timers(self) -> None:
        """Let the control loop have its turn."""
        period = round(TICK * 1e9)
        for timer in list(self.node.timers):
            if timer.timer_period_ns == period:
                timer.callback()

    def cycle(self) -> None:
        """Wrap an object, lift it, release it; with a fault at a random moment, mostly."""
        self.cycles += 1
        self.allowed = set(WISHES)
        loaded = self.node.runtime.loaded
        low, high = loaded.planner.radius_range if loaded else (0.01, 0.03)
        radius = self.random.uniform(1.3 * low, 0.9 * high)
        fault = self.random.choice([None, *FAULTS])
        at = self.random.uniform(0.0, WRAP_TIME + LIFT_TIME)
        self.call("rearm")
        if self.random.random() < 0.5:
            self.radius = radius
        else:
            policy = self.random.choice([None, *AbortPolicy])
            self._grasp(GraspGoal(radius, abort_policy=policy))
        start, end = self.time, self.time + WRAP_TIME + LIFT_TIME
        while self.time < end:
            if fault is not None and self.time - start >= at:
                self.happened[fault.__name__] += 1
                fault(self)
                fault = None
            self.tick()
        self.wrapped += self.node.runtime.control.snapshot().wrapped
        self.release()

    def _grasp(self, goal: GraspGoal) -> None:
        runtime = self.node.runtime
        if runtime.loaded is not None:
            grasp = runtime.control.start_grasp(self.time, goal, runtime.loaded.planner)
            if not isinstance(grasp, Refusal):
                self._goals.append(grasp)
            runtime.publish()

    def _start_release(self) -> None:
        """Release as the action does."""
        runtime = self.node.runtime
        release = runtime.control.start_release(self.time, ReleaseGoal())
        if not isinstance(release, Refusal):
            self._goals.append(release)
            runtime.publish()

    def release(self) -> None:
        """Mend every fault and vent; complain if that does not take the pressure away."""
        self.radius, self.is_client_alive, self.sends_radii = None, True, True
        self.regulator.fault, self.regulator.model = Fault.NONE, self.model
        self._start_release()
        if not self.call("vent").success:
            self._complain("a vent was refused")
        self.run(RELEASE_TIME)
        if self._last[1] != 0.0:
            self._complain("inflated after a release")
        self.node.set_parameters([Parameter("pressure.cap", value=math.nan)])

    # --- what goes wrong -------------------------------------------------------------------------

    def leak(self) -> None:
        """Let the gripper leak; the node vents at such a fault."""
        self._break(Fault.LEAK)

    def stuck_valve(self) -> None:
        """Let the valve stick."""
        self._break(Fault.STUCK_VALVE)

    def lost_link(self) -> None:
        """Lose the regulator's link."""
        self._break(Fault.LOST_LINK)

    def _break(self, fault: Fault) -> None:
        self.allowed |= {Reason.PRESSURE_LOW, Reason.PRESSURE_HIGH, Reason.PRESSURE_LOST}
        self.regulator.fault = fault

    def bad_radii(self) -> None:
        """Send numbers that are none, and outliers."""
        for bad in (math.nan, math.inf, -0.02, 0.0, 5.0, 1e300, 1e-300):
            self.hear("object_radius", Float64(data=bad))

    def radii_stop(self) -> None:
        """Hide the object from the camera; the policy is to hold."""
        self.sends_radii = False

    def bad_pressures(self) -> None:
        """Send impossible measured pressures."""
        for bad in (math.nan, -math.inf, 1e12):
            self.hear("measured_pressure", Float64(data=bad))

    def tilt(self) -> None:
        """Turn the arm, in steps of a trembling one."""
        for component in self.random.choice(GRAVITIES):
            message = Vector3Stamped()
            message.vector.x = component
            self.hear("gravity", message)
        message = Vector3Stamped()
        vector = message.vector
        vector.x, vector.y, vector.z = self.random.choice(GRAVITIES)
        self.hear("gravity", message)

    def bad_gravity(self) -> None:
        """Send a gravity that cannot be."""
        message = Vector3Stamped()
        message.vector.z = self.random.choice((math.nan, 1e9))
        self.hear("gravity", message)

    def client_vanishes(self) -> None:
        """Let the client give no sign of life any more."""
        self.allowed.add(Reason.CLIENT_LOST)
        self.is_client_alive = False

    def cap_is_lowered(self) -> None:
        """Lower the cap, maybe below what the wrap needs."""
        cap = self.random.uniform(1.0e4, 9.0e4)
        self.node.set_parameters([Parameter("pressure.cap", value=cap)])

    def clock_leaps(self) -> None:
        """Let the clock leap forward or back."""
        self.allowed |= {Reason.PRESSURE_LOST, Reason.CLIENT_LOST}
        self.allowed |= {Reason.GRASP_TIMEOUT, Reason.WRAP_FAILED}  # a goal's time is over at once
        self.allowed |= {Reason.PRESSURE_LOW, Reason.PRESSURE_HIGH}
        self.time += self.random.choice((-50.0, -0.5, 0.5, 30.0))

    def release_early(self) -> None:
        """Release in the midst."""
        self._start_release()

    def release_with_a_cut_link(self) -> None:
        """Release after the link was cut, from a device that keeps its pressure."""
        self.regulator.model = replace(self.model, watchdog_timeout=60.0)
        self.lost_link()
        self.run(self.random.uniform(0.0, 0.8))
        self._start_release()

    def node_is_stopped(self) -> None:
        """Stop the node as SIGSTOP does; what was sent meanwhile is heard afterwards."""
        self._may_find_it_vented()
        duration = self.random.uniform(0.1, 3.0)
        self.time += duration
        self.regulator.step(duration)
        timers_first = self.random.random() < 0.5
        if timers_first:
            self.call_timers()
        for pressure in (self.regulator.report() for _ in range(5)):
            self.hear("measured_pressure", Float64(data=pressure or 0.0))
        self.tick()

    def adapter_is_stopped(self) -> None:
        """Stop the adapter as SIGSTOP does: nothing passes, and the device's watchdog may vent."""
        self._may_find_it_vented()
        self.lost_link()
        self.run(self.random.uniform(0.1, 1.0))
        self.regulator.fault = Fault.NONE

    def _may_find_it_vented(self) -> None:
        self.allowed |= {Reason.PRESSURE_LOW, Reason.PRESSURE_HIGH, Reason.PRESSURE_LOST}

    def malformed_requests(self) -> None:
        """Call the services of rclpy with what they cannot read, and with bad values."""
        values = (
            ParameterValue(type=99),
            ParameterValue(type=0),
            ParameterValue(type=4, string_value="1e5"),
            ParameterValue(type=3, double_value=math.nan),
        )
        for value in values:
            bad = ParameterMessage(name="grasp.timeout", value=value)
            request = SetParameters.Request(parameters=[bad, bad])
            answers = self.call("set_parameters", request).results
            if len(answers) != len(request.parameters) or any(a.successful for a in answers):
                self._complain(f"a malformed parameter is taken: {value}")
        change = ChangeState.Request(transition=Transition(id=255))
        if self.call("change_state", change).success:
            self._complain("an unknown transition is taken")

    def standby_stops(self) -> None:
        """Let a standby that was never active stop in one of the ways: it commands nothing."""
        standby = GripperNode(namespace=self.node.get_namespace())
        standby.runtime.outputs.publish_pressure = (  # type: ignore[method-assign]
            lambda pressure: self._complain(f"a standby commands {pressure} Pa")
        )
        try:
            standby.trigger_configure()
            self.random.choice((standby.trigger_cleanup, standby.trigger_shutdown, standby.vent))()
            standby.vent()
        finally:
            standby.destroy_node()

    def restart(self) -> None:
        """Deactivate and activate, which vents, then takes over what is measured."""
        self.node.trigger_deactivate()
        self._takes_over = True
        self.node.trigger_activate()

    def restart_with_disagreeing_sensors(self) -> None:
        """Restart while the sensor shows now one pressure, now another: nothing is commanded."""
        self.restart()
        commands = self.commands
        for _ in range(self.random.randrange(1, 40)):
            self.time += TICK
            self.regulator.step(TICK)
            for pressure in self.random.choice(((0.0, 6.0e4), (2.5e5,) * 2, (101325.0,) * 2)):
                self.hear("measured_pressure", Float64(data=pressure))
            self.call_timers()
        if self.commands != commands:
            self._complain("took over what disagreed")

    def kill_and_take_over(self) -> None:
        """Kill the node and start it anew; its first readings disagree, then they are true."""
        self._may_find_it_vented()  # the device's watchdog may be faster than the agreement
        cap = self.node.runtime.limits.pressure_cap
        self.node.runtime.has_commanded = False  # nobody vents
        self.node.trigger_deactivate()
        self._takes_over = True
        self.node.trigger_activate()
        commands, held = self.commands, self.regulator.target
        first = self.random.choice(DISAGREEING)
        for step in range(self.random.randrange(1, 8)):  # the device's watchdog waits meanwhile
            self.time += TICK
            self.regulator.step(TICK)
            pressure = first[step % len(first)]
            self.hear("measured_pressure", Float64(data=pressure))
            self.call_timers()
        if self.commands != commands:
            self._complain("took over what disagreed")
        fault, self.radius = self.regulator.fault, None
        self.run(0.3)
        commanded, tolerance = self._last[1], self.node.runtime.limits.pressure_tolerance
        is_known = fault is Fault.NONE and tolerance < held <= cap
        # What agrees to a tolerance may still be on its way, by as much again.
        if is_known and abs(commanded - held) > 2.0 * tolerance + NOISE:
            self._complain(f"{held} Pa were held, {commanded} Pa are commanded")

    def newer_goal(self) -> None:
        """Send a goal for another object."""
        self._grasp(GraspGoal(self.random.uniform(0.006, 0.035)))

    def impossible_goal(self) -> None:
        """Send goals that cannot be."""
        for goal in (GraspGoal(math.nan), GraspGoal(0.02, overpressure=1e9), GraspGoal(9.0)):
            self._grasp(goal)


FAULTS: tuple[Callable[[Rig], None], ...] = (
    Rig.leak, Rig.stuck_valve, Rig.lost_link, Rig.bad_radii, Rig.radii_stop, Rig.bad_pressures,
    Rig.tilt, Rig.bad_gravity, Rig.client_vanishes, Rig.cap_is_lowered, Rig.clock_leaps,
    Rig.release_early, Rig.restart, Rig.restart_with_disagreeing_sensors, Rig.newer_goal,
    Rig.impossible_goal, Rig.release_with_a_cut_link, Rig.node_is_stopped, Rig.adapter_is_stopped,
    Rig.malformed_requests, Rig.standby_stops, Rig.kill_and_take_over,
)  # fmt: skip


def run_cycles(count: int, seed: int, grip_radii: int = 0) -> Rig:
    """Run some cycles and return what happened; arguments as of :class:`Rig`.

    Raises:
        UnsafeCommandError: the first command that must not be.
    """
    rig = Rig(seed, grip_radii)
    try:
        for _ in range(count):
            rig.cycle()
    finally:
        rig.node.destroy_node()
    return rig


def main() -> None:
    """Run the cycles and print what happened."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", nargs="?", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--grip-radii", type=int, default=6, help="of the grips solved; 0: none")
    given = parser.parse_args()
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    rclpy.logging.set_logger_level("", rclpy.logging.LoggingSeverity.FATAL)
    rig = run_cycles(given.count, given.seed, given.grip_radii)
    rclpy.try_shutdown()
    print(f"{rig.cycles} cycles, {rig.commands} commands, none of them unsafe")
    print(f"goals that succeeded: {rig.succeeded}, none of them untrue")
    print(f"wrapped at the end of the lift: {rig.wrapped}")
    if given.grip_radii:
        print(f"grips answered: {rig.grips.answered}, refused: {rig.grips.refused}")
    print("injected: " + ", ".join(f"{name} {n}" for name, n in sorted(rig.happened.items())))


if __name__ == "__main__":
    main()
