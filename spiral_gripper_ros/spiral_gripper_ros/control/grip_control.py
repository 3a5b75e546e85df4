# SPDX-License-Identifier: Apache-2.0
"""The control logic of the node, without ROS: the state, its reason, the target and the command.

:data:`~spiral_gripper_ros.control.states.TRANSITIONS` has the states that each event leads to.
"""

from __future__ import annotations

import math
from collections import Counter

from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper_ros.control.grasp import Grasp, GraspGoal, impossible_goal
from spiral_gripper_ros.control.limits import AbortPolicy, FaultPolicy, Limits, TimeoutPolicy
from spiral_gripper_ros.control.plan import Planner
from spiral_gripper_ros.control.pressure_monitor import PressureMonitor, impossible_pressure
from spiral_gripper_ros.control.radius_gate import RadiusGate, impossible_radius
from spiral_gripper_ros.control.refusals import (
    GRASP_CANCELED,
    GRASP_REPLACED,
    NO_RADIUS,
    NOT_ACTIVE,
    NOT_FOLLOWING,
    NOT_RELEASED,
    RELEASED,
    TAKEN_OVER,
    late_grasp,
    lost_client,
    stale_gravity,
    stale_radius,
)
from spiral_gripper_ros.control.release import CANCELED, Release, ReleaseGoal
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import (
    NOT_REFUSED,
    TRANSITIONS,
    CommandRule,
    Event,
    Reason,
    Refusal,
    State,
)
from spiral_gripper_ros.control.target import (
    Target,
    asks_above_cap,
    capped_pressure,
    ramped_pressure,
)
from spiral_gripper_ros.control.timing import (
    LONGEST_DISCOVERY,
    WATCHDOG_TIMEOUT,
    MonotonicClock,
    Silence,
    TakeOver,
)

# A gap between two commands or measured pressures in which a regulator's watchdog may vent [s], if
# their rate allows a shorter one, and how long afterwards a pressure that is found too low is its
# doing [s]: a watchdog waits for 0.3 s or longer.
LONGEST_GAP = 0.25
DOUBT_TIME = 2.0
# A gap between two commands after which a regulator has vented where nothing is measured [s]: for
# the adapter it may last 0.15 s longer, while it waits for its device. A vent that stays unnoticed
# is worse than one in vain: a grasp would succeed without pressure.
UNMEASURED_GAP = WATCHDOG_TIMEOUT - 0.15
# How long 0 Pa is commanded before a start from nothing [s]: a watchdog that has vented waits for
# it, and in a queue of one a single message can be overtaken by the next.
REST_TIME = 0.5

_STALE = {
    TimeoutPolicy.HOLD: Event.STALE_HOLD,
    TimeoutPolicy.VENT: Event.STALE_VENT,
    TimeoutPolicy.RAMP_DOWN: Event.STALE_RAMP_DOWN,
}


class GripControl:
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
        self._clock = MonotonicClock()
        self._state, self._rule = State.INACTIVE, CommandRule.VENT
        self._refusal = NOT_ACTIVE
        self._target = Target()
        self._pressure = 0.0
        self._ramped_until = self._rests_until = 0.0
        self._gate = RadiusGate()
        self._accepted = 0
        self._refused: Counter[Reason] = Counter()
        self._last_refused = NOT_REFUSED
        self._stale: Refusal | None = None  # the newest that no usable radius has come
        self._monitor = PressureMonitor()
        self._commanded_at: float | None = None
        self._real_at = self._period = self._doubted_until = 0.0
        self._low = math.inf  # measured where it was too low before there was any doubt [Pa]
        self._regime: WrapRegime | None = None
        self._grasp: Grasp | None = None  # that has not ended yet
        self._releases: list[Release] = []  # likewise
        self._radius, self._client, self._gravity = Silence(), Silence(), Silence()
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
        self._accepted, self._refused = 0, Counter()
        self._enter(Event.ACTIVATE, NO_RADIUS)
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
        self._enter(Event.DEACTIVATE, NOT_ACTIVE)
        self._fail_releases(NOT_ACTIVE)

    def release(self, refusal: Refusal = RELEASED) -> None:
        """Vent for a reason, and stay vented until re-armed, a grasp or the next activation."""
        self._enter(Event.RELEASE, refusal)

    def rearm(self) -> Refusal | None:
        """Follow radii again after a release or a fault; return why not if that cannot be."""
        fault, vents = self._monitor.fault, self._limits.pressure_fault_policy is FaultPolicy.VENT
        if fault and vents and self._state is State.FAULT:
            return Refusal(fault.reason, f"the fault is still there: {fault.text}")
        if self._state is State.INACTIVE:
            return NOT_ACTIVE
        if self._take_over.waits:
            return self._take_over.refusal
        if self._rule is not CommandRule.VENT:
            return NOT_RELEASED
        self._enter(Event.REARM, NO_RADIUS)
        return None

    def fail(self, text: str) -> None:
        """Vent because of an internal error, and stay vented until re-armed or activated anew."""
        refusal = Refusal(Reason.INTERNAL_ERROR, text)
        self._enter(Event.FAULT, refusal)
        self._fail_releases(refusal)

    # --- inputs ------------------------------------------------------------------------------

    def offer_radius(self, now: float, radius: float, planner: Planner) -> bool:
        """Judge a radius estimate [m], any float, and follow it if it is accepted.

        Returns:
            Whether that changed the state, the reason or the target.
        """
        before = (self._state, self._refusal.reason, self._target.plan)
        time = self._clock.advance(now)
        if self._take_over.waits or self._state is State.GRASPING:
            return False
        if self._state.is_latched:
            self._refused[self._refusal.reason] += 1
            return False
        refusal = self._gate.refusal(time, radius, planner.radius_range, self._limits)
        if not refusal and self._target.needs_plan(radius, self._limits.radius_hysteresis):
            refusal = self._target.set_radius(radius, planner, self._limits)
        if refusal:
            self._refuse(refusal)
        else:
            self._target.resume()
            self._accepted += 1
            self._radius.hear(time)
            self._last_refused = NOT_REFUSED
            self._enter(Event.RADIUS, NOT_REFUSED)
        return before != (self._state, self._refusal.reason, self._target.plan)

    def keep_alive(self, now: float) -> None:
        """Note a keep-alive of the client."""
        self._client.hear(self._clock.advance(now))

    def hear_gravity(self, now: float, age: float = 0.0) -> None:
        """Note that a usable gravity was heard, as old as its stamp says [s]."""
        self._gravity.hear(self._clock.advance(now), age)

    def expect_gravity(self, now: float) -> None:
        """Expect gravity from now on: it is a fault if none is heard."""
        self._gravity.expect(self._clock.advance(now))

    def forget_gravity(self) -> None:
        """Expect no gravity: it is that of the parameter."""
        self._gravity.forget()

    def offer_measured(self, now: float, pressure: float) -> Refusal | None:
        """Judge a measured gauge pressure [Pa], any float; return why it is dropped, if it is."""
        time = self._clock.advance(now)
        if self._take_over.waits and impossible_pressure(pressure) is None:
            # What is commanded is what the regulator holds: that is no fault.
            self._monitor.commanded(time, pressure, self._limits)
        refusal = self._monitor.offer(time, pressure, self._limits)
        if refusal:
            self._refused[refusal.reason] += 1
            return refusal
        if self._take_over.waits:
            self._take_over.hear(time, pressure, self._limits)
        measured = self._monitor.measured
        if self._grasp is not None and measured is not None:
            self._grasp.measured(time, measured, self._pressure_target, self._limits)
        return None

    def observe(self, regime: WrapRegime | None, force: float | None = None) -> None:
        """Note how the object in use is held: as measured, else as commanded; None: not known.

        A regime without a force on the object [N/m] holds nothing.
        """
        self._regime = None if force is not None and not force > 0.0 else regime

    def refuse(self, refusal: Refusal) -> None:
        """Record that an input is not followed; a target that is being tracked is held.

        A grasp goes on: it follows no inputs.
        """
        if self._state is State.GRASPING:
            self._refused[refusal.reason] += 1
        else:
            self._refuse(refusal)

    def replan(self, planner: Planner) -> None:
        """Aim anew for the radius in use: gravity has changed, or more is known of its grip.

        If it can no longer be gripped, the present target stays. The reason is kept until a radius
        is accepted, or a plan for the radius of a grasp.
        """
        self._target.outdate(planner)
        self._replan()

    def reconfigure(self, limits: Limits) -> None:
        """Use other limits from now on; a lower cap cuts the command with the next step.

        A cap that is raised again raises no command: that takes a new radius or goal.
        """
        self._target.lower(min(self._limits.pressure_cap, limits.pressure_cap))
        self._limits = limits
        self._target.outdate()
        refusal = self._target.beyond_cap(limits)
        if self._state is not State.GRASPING or self._target.plan is None:
            if refusal:
                self._refuse(refusal)
        elif refusal or self._refusal:
            self._replan()

    # --- goals -------------------------------------------------------------------------------

    def start_grasp(self, now: float, goal: GraspGoal, planner: Planner) -> Grasp | Refusal:
        """Make the wrap or the pressure of a goal the target; radii are ignored from then on.

        Returns:
            The grasp, or why not; then nothing has changed.
        """
        time = self._clock.advance(now)
        refusal = self._take_over.refusal if self._take_over.waits else impossible_goal(goal)
        refusal = refusal or self._no_goal() or self._aim(goal, planner)
        if refusal:
            return refusal
        self._end(GRASP_REPLACED)
        self._enter(Event.GOAL, NOT_REFUSED)
        self._forget_radii()
        self._regime = None
        self._grasp = Grasp(goal, time, self.snapshot(), self._limits)
        return self._grasp

    def _no_goal(self) -> Refusal | None:
        """Return why no goal can be started now, whatever it is, or None."""
        if self._state is State.INACTIVE:
            return NOT_ACTIVE
        if self._state is State.FAULT:
            return Refusal(self._refusal.reason, f"rearm first: {self._refusal.text}")
        return self._monitor.fault or None  # it would let any grasp fail

    def _aim(self, goal: GraspGoal, planner: Planner) -> Refusal | None:
        """Make a goal the target, or return why not and change nothing."""
        if goal.pressure is not None:
            refusal = asks_above_cap(goal.pressure, self._limits)
            if not refusal:
                self._target.clear()
                self._target.freeze(goal.pressure)
            return refusal
        radius = goal.radius
        if radius is None:  # the one that is followed
            radius = self._target.radius
            if radius is None or self._state is not State.TRACKING:
                return self._refusal or NOT_FOLLOWING
        refusal = impossible_radius(radius, planner.radius_range) or self._target.set_radius(
            radius, planner, self._limits, goal.overpressure
        )
        if not refusal:
            self._target.resume()
        return refusal

    def start_release(self, now: float, goal: ReleaseGoal) -> Release | Refusal:
        """Vent, and report when the pressure is gone.

        Returns:
            The release, or why not; then nothing has changed.
        """
        time = self._clock.advance(now)
        if self._state is State.INACTIVE:
            return self._refusal
        self.release()
        release = Release(goal, time, self._limits)
        self._releases.append(release)
        return release

    def cancel(self, now: float, goal: Grasp | Release) -> None:
        """Cancel a goal; a grasp's policy acts. One that has ended stays as it ended."""
        time = self._clock.advance(now)
        if isinstance(goal, Release):
            goal.end(time, CANCELED)
        elif goal is self._grasp:
            self._abort(GRASP_CANCELED)

    def _abort(self, refusal: Refusal) -> None:
        """End the running grasp, if there is one, and let its policy act."""
        grasp = self._grasp
        if grasp is not None:
            self._end(refusal)
            holds = grasp.abort_policy is AbortPolicy.HOLD
            self._enter(Event.ABORT_HOLD if holds else Event.RELEASE, refusal)

    def _end(self, refusal: Refusal) -> None:
        """End the running grasp, if there is one."""
        if self._grasp is not None:
            self._grasp.end(self._clock.now, refusal)
            self._grasp = None

    def _replan(self) -> None:
        """Plan again for the radius in use; the pressure kept by an aborted grasp stays."""
        if self._target.frozen is None:
            refusal = self._target.replan(self._limits)
            if refusal:
                self._refuse(refusal)
            elif self._state is State.GRASPING:
                self._refusal = NOT_REFUSED

    def _fail_releases(self, refusal: Refusal) -> None:
        for release in self._releases:
            release.end(self._clock.now, refusal)
        self._releases = []

    # --- output ------------------------------------------------------------------------------

    def command(self, now: float, real_time: float | None = None) -> float:
        """Let time pass until ``now`` [s] and return the gauge pressure to command [Pa].

        Args:
            now: time [s].
            real_time: that of a watchdog, where ``now`` is simulated [s].
        """
        time, limits = self._clock.advance(now), self._limits
        self._monitor.check(time, limits)
        self._note_interruption(now if real_time is None else real_time)
        self._act_on_fault()
        self._act_on_lateness()
        self._act_on_silence()
        self._act_on_stale_radius()
        elapsed, self._ramped_until = time - self._ramped_until, time
        if self._rule is CommandRule.VENT or time < self._rests_until:
            self._pressure = 0.0
        else:
            self._pressure = ramped_pressure(self._pressure, self._pressure_target, elapsed, limits)
        if not self._pressure > 0.0:
            self._enter(Event.EMPTY, self._refusal)
        if not self._take_over.waits:
            self._monitor.commanded(time, self._pressure, limits)
        if self._target.radius is None:
            self._regime = None
        grasp = self._grasp
        if grasp is not None:
            grasp.update(time, self.snapshot())
            grasp.commanded(time, self._pressure, self._pressure_target)
            holds = self._is_wrapped or not grasp.wraps
            if self._is_settled(grasp) and holds and not self._refusal:
                self._end(NOT_REFUSED)
        for release in self._releases:
            release.update(time, self.snapshot())
        self._releases = [one for one in self._releases if one.report.end is None]
        return self._pressure

    def stand_still(self, real_time: float) -> None:
        """Let real time [s] pass for releases, while the clock of all else stands still."""
        for release in self._releases:
            release.stand_still(self._clock.now, self.snapshot(), real_time)

    def snapshot(self) -> Snapshot:
        """Return what is commanded and why, and what is measured, as of the last call."""
        time, target = self._clock.now, self._target
        return Snapshot(
            state=self._state,
            refusal=self._take_over.refusal if self._take_over.waits else self._refusal,
            radius=target.radius,
            plan=target.plan,
            pressure_target=self._pressure_target,
            pressure_command=self._pressure,
            accepted=self._accepted,
            refused=self._refused.copy(),
            measured_pressure=self._monitor.measured,
            measured_age=self._monitor.age(time),
            is_measured=self._monitor.is_expected,
            pressure_fault=self._monitor.fault,
            wrapped=self._is_wrapped,
            overpressure=target.overpressure,
            gravity_age=self._gravity.age(time),
            gravity_fault=self._gravity_fault(),
        )

    # --- inside ------------------------------------------------------------------------------

    def _enter(self, event: Event, refusal: Refusal) -> None:
        """Make the transition of an event for a reason, if the state has one.

        Whatever ends GRASPING ends the running grasp for that reason.
        """
        if (self._state, event) not in TRANSITIONS:
            return
        self._state, self._rule = TRANSITIONS[self._state, event]
        self._refusal = refusal
        if self._rule is CommandRule.VENT:
            self._take_over.waits = False
            self._pressure = 0.0
            self._target.clear()
            self._forget_radii()
            self._regime = None
        elif self._rule is CommandRule.KEEP:
            self._target.freeze(self._pressure)
        if self._state is not State.GRASPING:
            self._end(refusal)

    def _forget_radii(self) -> None:
        """Forget which radii came, and what was wrong with them."""
        self._radius.forget()
        self._last_refused = NOT_REFUSED
        self._gate.reset()

    def _refuse(self, refusal: Refusal) -> None:
        self._refused[refusal.reason] += 1
        if self._state.is_latched:
            return
        self._last_refused = refusal
        # A stream of bad radii counts as no stream: the reason must not change with each of them.
        if self._refusal is not self._stale and self._state is not State.TAKEN_OVER:
            self._refusal = refusal
        self._enter(Event.REFUSED, self._refusal)

    @property
    def _pressure_target(self) -> float:
        """The pressure that the command is heading for [Pa]."""
        heads_for_it = self._rule in (CommandRule.TARGET, CommandRule.KEEP)
        return self._target.pressure(self._limits.pressure_cap) if heads_for_it else 0.0

    @property
    def _is_wrapped(self) -> bool:
        """Whether the regime seen last holds the object in use."""
        # A regulator that is not heard any more may have vented by its own watchdog.
        is_heard = self._monitor.fault.reason is not Reason.PRESSURE_LOST
        curls = self._regime is WrapRegime.CURLING and self._target.overpressure > 0.0
        holds = curls or self._regime is WrapRegime.PERFECT_WRAP
        return self._target.radius is not None and is_heard and holds

    def _is_settled(self, grasp: Grasp) -> bool:
        is_measured = self._monitor.measured is not None
        return grasp.is_settled(self._clock.now, is_measured, self._limits)

    def _note_interruption(self, real_time: float) -> None:
        """Doubt the pressure for a while after a gap of commands or measurements.

        Where nothing is measured, a long gap of commands in real time [s] counts as a vent.
        """
        time, last, period = self._clock.now, self._commanded_at, self._limits.period
        stall, usual = real_time - self._real_at, 1.5 * max(period, self._period)
        self._commanded_at, self._real_at, self._period = time, real_time, period
        if last is None:  # just activated: gravity may have been heard long before
            age = self._gravity.age(time)
            if age is not None:
                self._gravity.hear(time, age)
            return
        gap, measured, fault = time - last, self._monitor.measured, self._monitor.fault.reason
        is_lost = fault is Reason.PRESSURE_LOST or self._monitor.misses(time, LONGEST_GAP)
        if is_lost or gap > max(LONGEST_GAP, usual):
            self._doubted_until = time + DOUBT_TIME
        elif time >= self._doubted_until:
            is_low = fault is Reason.PRESSURE_LOW
            self._low = measured if is_low and measured is not None else math.inf
        stall = min(stall, gap)
        if measured is not None or self._take_over.waits or stall <= max(UNMEASURED_GAP, usual):
            return
        text = f"nothing was commanded for {stall:.2f} s: the regulator may have vented by itself"
        self._restart(Refusal(Reason.PRESSURE_LOW, text))

    def _act_on_fault(self) -> None:
        fault = self._monitor.fault
        if self._take_over.waits or not fault:
            return
        if self._limits.pressure_fault_policy is FaultPolicy.VENT:
            if self._state not in (State.INACTIVE, State.FAULT):
                self._enter(Event.FAULT, fault)
        elif (
            fault.reason is Reason.PRESSURE_LOW
            and self._clock.now < self._doubted_until
            and (self._monitor.measured or 0.0) < self._low - self._limits.pressure_tolerance
            and (self._state, Event.WATCHDOG) in TRANSITIONS
        ):
            text = f"the regulator has vented by itself, for lack of commands or link: {fault.text}"
            self._restart(Refusal(fault.reason, text))
        else:
            self._abort(fault)

    def _restart(self, refusal: Refusal) -> None:
        """Start from nothing: the regulator has vented. A radius is followed anew, no goal."""
        self._doubted_until = self._clock.now
        self._rests_until = self._clock.now + REST_TIME
        if self._pressure > 0.0:  # else nothing was held: what has just been started goes on
            if self._limits.pressure_fault_policy is FaultPolicy.VENT:
                self._enter(Event.FAULT, self._monitor.fault or refusal)
            else:
                self._enter(Event.WATCHDOG, refusal)

    def _act_on_lateness(self) -> None:
        grasp = self._grasp
        if grasp is not None and grasp.elapsed(self._clock.now) > grasp.timeout:
            settled = self._is_settled(grasp)
            refusal = late_grasp(self.snapshot(), grasp.timeout, self._regime, settled)
            self._abort(refusal)

    def _act_on_silence(self) -> None:
        """Act on silence: of the client, of gravity, of a pressure to be taken over."""
        time, limits = self._clock.now, self._limits
        held = self._take_over.check(time, limits)
        if held > limits.pressure_tolerance:
            self._target.clear()
            self._pressure = capped_pressure(held, limits.pressure_cap)
            self._enter(Event.AGREED, TAKEN_OVER)
        gravity, is_vented = self._gravity_fault(), self._rule is CommandRule.VENT
        if is_vented or not limits.keep_alive_timeout > 0.0:
            self._client.hear(time)  # none is needed
        if self._client.exceeds(time, limits.keep_alive_timeout, limits.period):
            self.release(lost_client(limits))
        elif gravity and not is_vented and limits.gravity_timeout_policy is FaultPolicy.VENT:
            self._enter(Event.FAULT, gravity)

    def _act_on_stale_radius(self) -> None:
        time, limits = self._clock.now, self._limits
        event = _STALE[limits.radius_timeout_policy]
        age = self._radius.age(time)
        if age is None or (self._state, event) not in TRANSITIONS:
            return
        if self._radius.exceeds(time, limits.radius_timeout, limits.period):
            if self._refusal is not self._stale:
                self._refused[Reason.RADIUS_STALE] += 1
            self._stale = stale_radius(age, limits, self._last_refused)
            self._enter(event, self._stale)

    def _gravity_fault(self) -> Refusal:
        """Return that gravity is stale; ``Reason.NONE`` if it is not."""
        time, limits = self._clock.now, self._limits
        longest, age = limits.gravity_timeout, self._gravity.age(time)
        if not longest > 0.0:
            return NOT_REFUSED
        if age is None:  # the first may come late
            longest = max(longest, LONGEST_DISCOVERY)
        is_late = self._gravity.exceeds(time, longest, limits.period)
        return stale_gravity(age, limits) if is_late else NOT_REFUSED
