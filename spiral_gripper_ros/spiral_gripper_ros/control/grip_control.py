# SPDX-License-Identifier: Apache-2.0
"""The control logic of the node, without ROS: inputs, their absence, and the pressure command.

:class:`GripControl` decides: it judges the measured pressure, silence and the end of each grasp,
and tells its state machine to track, hold, vent or fail. The state machine answers with the
command.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Generic

from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper_ros.control.grasp import AbortPolicy, GraspGoal, GraspOutcome
from spiral_gripper_ros.control.grasp_attempt import GraspAttempt, impossible_goal
from spiral_gripper_ros.control.limits import FaultPolicy, Limits
from spiral_gripper_ros.control.pressure_monitor import PressureMonitor, impossible_pressure
from spiral_gripper_ros.control.refusals import (
    GRASP_CANCELED,
    GRASP_REPLACED,
    RECONFIGURED,
    RELEASED,
    late_grasp,
    lost_client,
    stale_gravity,
)
from spiral_gripper_ros.control.snapshot import Planner, PlanT, Snapshot
from spiral_gripper_ros.control.state_machine import StateMachine
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal, State
from spiral_gripper_ros.control.timing import Silence, TakeOver

# A gap between two commands in which a regulator's watchdog may vent [s], and how long afterwards a
# pressure that is found too low is its doing [s].
LONGEST_GAP = 0.25
DOUBT_TIME = 2.0


class GripControl(Generic[PlanT]):
    """Decides the pressure command, monitors the measured pressure, and executes grasps.

    Times are seconds of any clock. If that clock runs backwards, no time passes until it runs
    forward again.

    Args:
        limits: what no command may exceed and how inputs are judged.

    Example:
        >>> control = GripControl(Limits(pressure_cap=1.0e5))
        >>> control.activate()
        >>> control.command(now=0.0), control.snapshot().state.name
        (0.0, 'WAITING')
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._machine: StateMachine[PlanT] = StateMachine(limits)
        self._monitor = PressureMonitor()
        self._time = 0.0
        self._commanded_at: float | None = None
        self._doubted_until = 0.0
        self._regime: WrapRegime | None = None
        self._attempt: GraspAttempt[PlanT] | None = None  # that has not ended yet
        self._client, self._gravity = Silence(), Silence()
        self._gravity_at: float | None = None
        self._take_over = TakeOver()

    # --- life cycle --------------------------------------------------------------------------

    def activate(self, *, take_over: bool = False) -> None:
        """Start waiting for radii and goals; nothing of an earlier activation is remembered.

        Args:
            take_over: whether the first measured pressure is taken over as the command. Until then
                nothing is to be commanded; without one the command is 0 Pa after
                ``measured_pressure_timeout``.
        """
        self.deactivate()
        self._machine.activate()
        self._monitor.forget()
        self._commanded_at = None
        if take_over:
            self._take_over.start()

    @property
    def is_silent(self) -> bool:
        """Whether nothing is to be commanded: a pressure to be taken over may be held."""
        return self._take_over.waits

    def deactivate(self) -> None:
        """Vent, and stay vented until activated."""
        self._take_over.end()
        self._machine.deactivate()
        self._follow()

    def release(self) -> None:
        """Vent, and stay vented until re-armed, a grasp or the next activation."""
        self._take_over.end()
        self._machine.release(RELEASED)
        self._follow()

    def reload(self) -> None:
        """Vent because another gripper is being loaded, and stay vented as after a release."""
        self._take_over.end()
        self._machine.release(RECONFIGURED)
        self._follow()

    def rearm(self) -> Refusal | None:
        """Follow radii again after a release or a fault; return why not if that cannot be."""
        fault = self._monitor.fault
        if fault.reason is not Reason.NONE and self._vents_at_faults() and self._is(State.FAULT):
            return Refusal(fault.reason, f"the fault is still there: {fault.text}")
        return self._machine.rearm()

    def fail(self, text: str, reason: Reason = Reason.INTERNAL_ERROR) -> None:
        """Vent because of a fault, and stay vented until re-armed or activated anew."""
        self._take_over.end()
        self._machine.fault(Refusal(reason, text))
        self._follow()

    # --- inputs ------------------------------------------------------------------------------

    def offer_radius(self, now: float, radius: float, planner: Planner[PlanT]) -> bool:
        """Judge a radius estimate [m], any float, and follow it if it is accepted.

        Returns:
            Whether that changed the state, the reason or the target.
        """
        self._time = self._machine.advance(now)
        return not self._take_over.waits and self._machine.offer_radius(now, radius, planner)

    def keep_alive(self, now: float) -> None:
        """Note a keep-alive of the client."""
        self._time = self._machine.advance(now)
        self._client.hear(self._time)

    def hear_gravity(self, now: float, age: float = 0.0) -> None:
        """Note that a usable gravity was heard, as old as its stamp says [s]."""
        self._time = self._machine.advance(now)
        self._gravity.hear(self._time, age)
        self._gravity_at = self._time - age

    def forget_gravity(self) -> None:
        """Expect no gravity: it is that of the parameter."""
        self._gravity.forget()
        self._gravity_at = None

    def offer_measured(self, now: float, pressure: float) -> Refusal | None:
        """Judge a measured gauge pressure [Pa], any float; return why it is dropped, if it is."""
        self._time = self._machine.advance(now)
        if self._take_over.waits and impossible_pressure(pressure) is None:
            # What is commanded is what the regulator holds: that is no fault.
            self._monitor.commanded(self._time, pressure, self._limits)
        refusal = self._monitor.offer(self._time, pressure, self._limits)
        if refusal is not None:
            self._machine.count(refusal.reason)
            return refusal
        if self._take_over.waits:
            held = self._take_over.hear(self._time, pressure, self._limits)
            if held is not None and held > self._limits.pressure_tolerance:
                self._machine.take_over(held)
        measured, attempt = self._monitor.measured(self._time), self._attempt
        if attempt is not None and measured is not None:
            target = self._machine.pressure_target
            attempt.measured(self._time, measured.pressure, target, self._limits)
        return None

    def observe(self, now: float, regime: WrapRegime | None, force: float | None = None) -> None:
        """Note how the object in use is held: as measured, else as commanded; None: not known.

        A regime without a force on the object [N/m] holds nothing.
        """
        self._time = self._machine.advance(now)
        self._regime = None if force is not None and not force > 0.0 else regime

    def replan(self, planner: Planner[PlanT]) -> None:
        """Aim anew for the radius in use: gravity has changed, or more is known of its grip."""
        self._machine.replan(planner)
        self._follow()

    def refuse(self, refusal: Refusal) -> None:
        """Record that an input is not followed; a target that is being tracked is held."""
        self._machine.refuse(refusal)

    def reconfigure(self, limits: Limits) -> None:
        """Use other limits from now on; a lower cap cuts the command with the next step."""
        self._limits = limits
        self._machine.reconfigure(limits)
        self._follow()

    # --- grasps ------------------------------------------------------------------------------

    def start_grasp(
        self, now: float, goal: GraspGoal, planner: Planner[PlanT]
    ) -> GraspAttempt[PlanT] | Refusal:
        """Make the wrap or the pressure of a goal the target, from any active state but FAULT.

        Returns:
            The grasp, or why not; then nothing has changed.
        """
        self._time = self._machine.advance(now)
        refusal = impossible_goal(goal) or self._fault_in_the_way()
        if self._take_over.waits:
            refusal = self._take_over.refusal
        if refusal is None:
            refusal = (
                self._machine.grasp(now, goal.radius, goal.overpressure, planner)
                if goal.pressure is None
                else self._machine.press(now, goal.pressure)
            )
        if refusal is not None:
            return refusal
        self._end(GraspOutcome.FAILED, GRASP_REPLACED)
        self._regime = None
        snapshot = self._machine.snapshot()
        self._attempt = GraspAttempt(goal, self._time, snapshot, self._limits)
        return self._attempt

    def cancel_grasp(self, now: float, grasp: GraspAttempt[PlanT] | None) -> None:
        """End a grasp and let its policy act; one that has ended already stays as it ended."""
        self._time = self._machine.advance(now)
        if grasp is self._attempt:
            self._abort(GraspOutcome.CANCELED, GRASP_CANCELED)

    # --- output ------------------------------------------------------------------------------

    def command(self, now: float) -> float:
        """Let time pass until ``now`` [s] and return the gauge pressure to command [Pa]."""
        self._time = self._machine.advance(now)
        self._monitor.check(self._time, self._limits)
        self._note_interruption()
        self._act_on_fault()
        self._act_on_lateness()
        self._act_on_silence()
        pressure = self._machine.command(now)
        if not self._take_over.waits:
            self._monitor.commanded(self._time, pressure, self._limits)
        self._follow()
        attempt = self._attempt
        if attempt is not None:
            attempt.commanded(self._time, pressure, self._machine.pressure_target)
            self._act_on_success(attempt)
        return pressure

    def snapshot(self) -> Snapshot[PlanT]:
        """Return what is commanded and why, and what is measured, as of the last call."""
        snapshot, fault = self._machine.snapshot(), self._monitor.fault
        # A regulator that is not heard any more may have vented by its own watchdog.
        is_heard = fault.reason is not Reason.PRESSURE_LOST
        return replace(
            snapshot,
            refusal=self._take_over.refusal if self._take_over.waits else snapshot.refusal,
            measured=self._monitor.measured(self._time),
            is_measured=self._monitor.is_expected,
            pressure_fault=fault,
            wrapped=snapshot.radius is not None and is_heard and self._is_held(),
            gravity_age=self._gravity_age,
            gravity_fault=self._gravity_fault(),
        )

    # --- inside ------------------------------------------------------------------------------

    def _is(self, *states: State) -> bool:
        return self._machine.state in states

    def _vents_at_faults(self) -> bool:
        return self._limits.pressure_fault_policy is FaultPolicy.VENT

    def _is_held(self) -> bool:
        """Return whether the regime seen last holds the object."""
        curls = self._regime is WrapRegime.CURLING and self._machine.overpressure > 0.0
        return curls or self._regime is WrapRegime.PERFECT_WRAP

    def _is_settled(self, attempt: GraspAttempt[PlanT]) -> bool:
        is_measured = self._monitor.measured(self._time) is not None
        return attempt.is_settled(self._time, is_measured, self._limits)

    def _fault_in_the_way(self) -> Refusal | None:
        """Return the fault of the measured pressure that lets any grasp fail, or None."""
        fault = self._monitor.fault
        stays = fault.reason is Reason.NONE or self._is(State.INACTIVE, State.FAULT)
        return None if stays else fault

    def _act_on_fault(self) -> None:
        fault = self._monitor.fault
        if fault.reason is Reason.NONE or self._take_over.waits:
            return
        is_low = fault.reason is Reason.PRESSURE_LOW
        if not self._vents_at_faults():
            if is_low and self._time < self._doubted_until and self._machine.state.is_gripping:
                self._start_again(fault)
            else:
                self._abort(GraspOutcome.FAILED, fault)
        elif not self._is(State.INACTIVE, State.FAULT):
            self._machine.fault(fault)
            self._follow()

    def _note_interruption(self) -> None:
        """Doubt the pressure for a while after a gap between commands, or a lost measurement."""
        if self._commanded_at is None:  # just activated: gravity may have been heard long before
            if self._gravity_age is not None:
                self._gravity.hear(self._time, self._gravity_age)
        elif (
            self._time - self._commanded_at > LONGEST_GAP
            or self._monitor.fault.reason is Reason.PRESSURE_LOST
        ):
            self._doubted_until = self._time + DOUBT_TIME
        self._commanded_at = self._time

    def _start_again(self, fault: Refusal) -> None:
        """Vent, as the regulator's watchdog has: the ramp starts from nothing again."""
        text = f"the regulator has vented by itself, for lack of commands or link: {fault.text}"
        refusal = Refusal(fault.reason, text)
        self._doubted_until = self._time
        self._end(GraspOutcome.FAILED, refusal)
        self._machine.start_again(refusal)
        self._follow()

    def _act_on_silence(self) -> None:
        """Act on silence: of the client, of gravity, of a pressure to be taken over."""
        limits = self._limits
        self._take_over.check(self._time, limits)
        gravity = self._gravity_fault()
        vents = limits.gravity_timeout_policy is FaultPolicy.VENT
        if self._machine.state.is_vented or not limits.keep_alive_timeout > 0.0:
            self._client.hear(self._time)  # none is needed
        if self._machine.state.is_vented:
            return
        if self._client.exceeds(self._time, limits.keep_alive_timeout):
            self._machine.release(lost_client(limits))
            self._follow()
        elif gravity.reason is not Reason.NONE and vents:
            self._machine.fault(gravity)
            self._follow()

    @property
    def _gravity_age(self) -> float | None:
        """Time since the newest gravity was true [s], or None if it is the parameter's."""
        return None if self._gravity_at is None else self._time - self._gravity_at

    def _gravity_fault(self) -> Refusal:
        """Return that gravity is stale; ``Reason.NONE`` if it is not."""
        longest, age = self._limits.gravity_timeout, self._gravity_age
        if age is None or not longest > 0.0 or not self._gravity.exceeds(self._time, longest):
            return NOT_REFUSED
        return stale_gravity(age, self._limits)

    def _act_on_lateness(self) -> None:
        attempt = self._attempt
        if attempt is not None and attempt.is_late(self._time):
            settled = self._is_settled(attempt)
            refusal = late_grasp(self.snapshot(), attempt.timeout, self._regime, settled)
            self._abort(GraspOutcome.FAILED, refusal)

    def _act_on_success(self, attempt: GraspAttempt[PlanT]) -> None:
        seen = self.snapshot()
        holds = seen.wrapped or not attempt.wraps
        if self._is_settled(attempt) and seen.refusal.reason is Reason.NONE and holds:
            self._end(GraspOutcome.SUCCEEDED, NOT_REFUSED)

    def _abort(self, outcome: GraspOutcome, refusal: Refusal) -> None:
        """End the running grasp, if there is one, and let its policy act."""
        attempt = self._attempt
        if attempt is None:
            return
        self._end(outcome, refusal)
        if attempt.abort_policy is AbortPolicy.HOLD:
            self._machine.hold(refusal)
        else:
            self._machine.release(refusal)
            self._follow()

    def _end(self, outcome: GraspOutcome, refusal: Refusal) -> None:
        """End the running grasp, if there is one."""
        if self._attempt is not None:
            self._attempt.end(self._time, outcome, refusal)
            self._attempt = None

    def _follow(self) -> None:
        """End the grasp if its target is gone: any vent ends a grasp."""
        snapshot = self._machine.snapshot()
        if snapshot.radius is None:
            self._regime = None
        if snapshot.state is not State.GRASPING:
            self._end(GraspOutcome.FAILED, snapshot.refusal)
        elif self._attempt is not None:
            self._attempt.update(self._time, snapshot)
