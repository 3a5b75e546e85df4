# SPDX-License-Identifier: Apache-2.0
"""The state machine of the control logic: the state, its reason, the target and the command.

Its inputs are radii, plans and limits. Its only caller,
:class:`~spiral_gripper_ros.control.grip_control.GripControl`, handles measured pressures, missing
messages and the end of grasps. ``docs/node.md`` draws the transitions.
"""

from __future__ import annotations

from collections import Counter
from typing import Generic

from spiral_gripper_ros.control.limits import Limits, TimeoutPolicy
from spiral_gripper_ros.control.pressure_ramp import capped_pressure, ramped_pressure
from spiral_gripper_ros.control.radius_gate import RadiusGate, impossible_radius
from spiral_gripper_ros.control.refusals import (
    GRASP_HOLDS,
    NO_RADIUS,
    NOT_ACTIVE,
    NOT_FOLLOWING,
    TAKEN_OVER,
    stale_radius,
)
from spiral_gripper_ros.control.snapshot import Planner, PlanT, Snapshot
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal, State
from spiral_gripper_ros.control.target import Target, asks_above_cap
from spiral_gripper_ros.control.timing import MonotonicClock, Silence

# How long 0 Pa is commanded before a start from nothing [s]: a watchdog that has vented waits for
# it, and in a queue of one a single message can be overtaken by the next.
REST_TIME = 0.5


class StateMachine(Generic[PlanT]):
    """Moves between the states of :class:`State` and ramps the command to the target of each.

    Times are seconds of any clock. Should that clock run backwards, no time passes until it runs
    forward again.

    Args:
        limits: what no command may exceed and how radii are judged.

    Example:
        >>> machine = StateMachine(Limits(pressure_cap=1.0e5))
        >>> machine.command(now=0.0), machine.state.name
        (0.0, 'INACTIVE')
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._clock = MonotonicClock()
        self._gate = RadiusGate()
        self._target: Target[PlanT] = Target()
        self._ramped_until = 0.0
        self._rests_until = 0.0
        self._pressure = 0.0
        self._accepted = 0
        self._accepted_at: float | None = None
        self._silence = Silence()
        self._refused: Counter[Reason] = Counter()
        self._state = State.INACTIVE
        self._refusal = NOT_ACTIVE
        self._last_refused = NOT_REFUSED

    @property
    def state(self) -> State:
        """What it does now."""
        return self._state

    @property
    def overpressure(self) -> float:
        """What the target has above the pressure of the perfect wrap [Pa]."""
        return self._target.overpressure

    @property
    def pressure_target(self) -> float:
        """The pressure that the command is heading for [Pa]."""
        return self._target.pressure(self._limits.pressure_cap) if self._state.is_gripping else 0.0

    # --- life cycle --------------------------------------------------------------------------

    def activate(self) -> None:
        """Start waiting for radii; nothing of an earlier activation is remembered."""
        self._accepted = 0
        self._refused = Counter()
        self._vent(State.WAITING, NO_RADIUS)

    def take_over(self, pressure: float) -> None:
        """Keep the pressure [Pa] found at activation, until a radius or a goal."""
        self._vent(State.TAKEN_OVER, TAKEN_OVER)
        self._pressure = capped_pressure(pressure, self._limits.pressure_cap)
        self._target.freeze(self._pressure)

    def deactivate(self) -> None:
        """Vent, and stay vented until activated."""
        self._vent(State.INACTIVE, NOT_ACTIVE)

    def release(self, refusal: Refusal) -> None:
        """Vent for a reason, and stay vented until re-armed, a grasp or the next activation."""
        if self._state in (State.INACTIVE, State.FAULT):
            self._pressure = 0.0
        else:
            self._vent(State.RELEASED, refusal)

    def start_again(self, refusal: Refusal) -> None:
        """Vent for a while because the gripper is vented already.

        A radius is followed anew, a goal is not.
        """
        self._rests_until = self._clock.now + REST_TIME
        followed = self._state in (State.TRACKING, State.HOLDING)
        self._vent(State.WAITING if followed else State.RELEASED, refusal)

    def rearm(self) -> Refusal | None:
        """Follow radii again after a release or a fault; return why not if that cannot be."""
        if self._state is State.INACTIVE:
            return NOT_ACTIVE
        if self._state is State.GRASPING:
            return GRASP_HOLDS
        if self._state.is_latched:
            self._vent(State.WAITING, NO_RADIUS)
        return None

    def fault(self, refusal: Refusal) -> None:
        """Vent because of a fault, and stay vented until re-armed or activated anew."""
        state = State.INACTIVE if self._state is State.INACTIVE else State.FAULT
        self._vent(state, refusal)

    # --- inputs ------------------------------------------------------------------------------

    def offer_radius(self, now: float, radius: float, planner: Planner[PlanT]) -> bool:
        """Judge a radius estimate [m], any float, and follow it if it is accepted.

        Returns:
            Whether that changed the state, the reason or the target.
        """
        before = (self._state, self._refusal.reason, self._target.plan)
        self.advance(now)
        if self._state is State.GRASPING:
            return False
        if self._state.is_latched:
            self._refused[self._refusal.reason] += 1
            return False
        refusal = self._gate.refusal(self._clock.now, radius, planner.radius_range, self._limits)
        if refusal is None and self._target.needs_plan(radius, self._limits.radius_hysteresis):
            refusal = self._target.set_radius(radius, planner, self._limits)
        if refusal is not None:
            self._refuse(refusal)
        else:
            self._target.resume()
            self._accepted += 1
            self._accepted_at = self._clock.now
            self._silence.hear(self._clock.now)
            self._refusal = self._last_refused = NOT_REFUSED
            self._state = State.TRACKING
        return before != (self._state, self._refusal.reason, self._target.plan)

    def grasp(
        self,
        now: float,
        radius: float | None,
        overpressure: float | None,
        planner: Planner[PlanT],
    ) -> Refusal | None:
        """Wrap one radius and ignore the radii that are offered meanwhile.

        Args:
            now: time [s].
            radius: of the object [m], any float; None: the one that is being followed.
            overpressure: above the pressure of the perfect wrap [Pa], >= 0; None: of grip_ratio.
            planner: makes the plan.

        Returns:
            Why not, if that cannot be; then nothing has changed.
        """
        self.advance(now)
        if self._state in (State.INACTIVE, State.FAULT):
            return self._no_goal()
        if radius is None:
            radius = self._target.radius
            if radius is None or self._state is not State.TRACKING:
                goes_on = self._refusal.reason is Reason.NONE
                return NOT_FOLLOWING if goes_on else self._refusal
        refusal = impossible_radius(radius, planner.radius_range) or self._target.set_radius(
            radius, planner, self._limits, overpressure
        )
        if refusal is None:
            self._target.resume()
            self._begin_goal()
        return refusal

    def press(self, now: float, pressure: float) -> Refusal | None:
        """Go to a pressure [Pa], whatever it wraps, and ignore radii meanwhile.

        Returns:
            Why not, if that cannot be; then nothing has changed.
        """
        self.advance(now)
        if self._state in (State.INACTIVE, State.FAULT):
            return self._no_goal()
        refusal = asks_above_cap(pressure, self._limits)
        if refusal is None:
            self._target.clear()
            self._target.freeze(pressure)
            self._begin_goal()
        return refusal

    def hold(self, refusal: Refusal) -> None:
        """Keep the present command of a grasp, for a reason, until the next input."""
        if self._state is State.GRASPING:
            self._target.freeze(self._pressure)
            self._refusal = refusal

    def replan(self, planner: Planner[PlanT]) -> None:
        """Plan again for the radius in use, because gravity has changed.

        If it can no longer be gripped, the present target stays. The reason is kept until a radius
        is accepted, or a plan for the radius of a grasp.
        """
        self._target.outdate(planner)
        if self._state is State.GRASPING:
            self._replan_grasp()
        else:
            refusal = self._target.replan(self._limits)
            if refusal is not None:
                self._refuse(refusal)

    def refuse(self, refusal: Refusal) -> None:
        """Record that an input is not followed; a target that is being tracked is held.

        A grasp goes on: it follows no inputs.
        """
        if self._state is State.GRASPING:
            self._refused[refusal.reason] += 1
        else:
            self._refuse(refusal)

    def count(self, reason: Reason) -> None:
        """Count a refusal that has no other consequence."""
        self._refused[reason] += 1

    def reconfigure(self, limits: Limits) -> None:
        """Use other limits from now on; a lower cap cuts the command with the next step.

        A cap that is raised again raises no command: that takes a new radius or goal.
        """
        self._target.lower(min(self._limits.pressure_cap, limits.pressure_cap))
        self._limits = limits
        self._target.outdate()
        refusal = self._target.beyond_cap(limits)
        if self._state is not State.GRASPING:
            if refusal is not None:
                self._refuse(refusal)
        elif refusal is not None and self._target.plan is None:
            self._refuse(refusal)
        elif refusal is not None or self._refusal.reason is not Reason.NONE:
            self._replan_grasp()

    # --- output ------------------------------------------------------------------------------

    def advance(self, now: float) -> float:
        """Let time pass until ``now`` [s] and return the monotonic time [s]."""
        return self._clock.advance(now)

    def command(self, now: float) -> float:
        """Let time pass until ``now`` [s] and return the gauge pressure to command [Pa]."""
        time = self.advance(now)
        elapsed, self._ramped_until = time - self._ramped_until, time
        self._act_on_timeout()
        if self._state.is_vented or time < self._rests_until:
            self._pressure = 0.0
        else:
            goal = self.pressure_target
            self._pressure = ramped_pressure(self._pressure, goal, elapsed, self._limits)
        if self._state is State.RAMPING_DOWN and not self._pressure > 0.0:
            self._vent(State.VENTED, self._refusal)
        return self._pressure

    def snapshot(self) -> Snapshot[PlanT]:
        """Return what is commanded and why, as of the last call."""
        age = None if self._accepted_at is None else self._clock.now - self._accepted_at
        return Snapshot(
            state=self._state,
            refusal=self._refusal,
            radius=self._target.radius,
            plan=self._target.plan,
            radius_age=age,
            pressure_target=self.pressure_target,
            pressure_command=self._pressure,
            accepted=self._accepted,
            refused=self._refused.copy(),
            overpressure=self._target.overpressure,
        )

    # --- inside ------------------------------------------------------------------------------

    def _vent(self, state: State, refusal: Refusal) -> None:
        """Command 0 Pa at once and forget the target."""
        self._state = state
        self._refusal = refusal
        self._pressure = 0.0
        self._target.clear()
        self._accepted_at = None
        self._last_refused = NOT_REFUSED
        self._gate.reset()

    def _refuse(self, refusal: Refusal) -> None:
        self._refused[refusal.reason] += 1
        if self._state.is_latched:
            return
        self._last_refused = refusal
        # A stream of bad radii counts as no stream: the reason must not change with each of them.
        if self._refusal.reason is not Reason.RADIUS_STALE and self._state is not State.TAKEN_OVER:
            self._refusal = refusal
        if self._state is State.TRACKING:
            self._state = State.HOLDING

    def _no_goal(self) -> Refusal:
        """Return why INACTIVE and FAULT take no goal."""
        if self._state is State.INACTIVE:
            return NOT_ACTIVE
        return Refusal(self._refusal.reason, f"rearm first: {self._refusal.text}")

    def _begin_goal(self) -> None:
        self._state = State.GRASPING
        self._refusal = self._last_refused = NOT_REFUSED
        self._accepted_at = None
        self._gate.reset()

    def _replan_grasp(self) -> None:
        """Plan again for the radius of a grasp; the pressure kept by an aborted one stays."""
        if self._target.is_frozen:
            return
        refusal = self._target.replan(self._limits)
        if refusal is not None:
            self._refuse(refusal)
        else:
            self._refusal = NOT_REFUSED

    def _act_on_timeout(self) -> None:
        if self._state not in (State.TRACKING, State.HOLDING) or self._accepted_at is None:
            return
        age = self._clock.now - self._accepted_at
        if not self._silence.exceeds(self._clock.now, self._limits.radius_timeout):
            return
        if self._refusal.reason is not Reason.RADIUS_STALE:
            self._refused[Reason.RADIUS_STALE] += 1
        refusal = stale_radius(age, self._limits, self._last_refused)
        policy = self._limits.radius_timeout_policy
        if policy is TimeoutPolicy.VENT:
            self._vent(State.VENTED, refusal)
            return
        hold = policy is TimeoutPolicy.HOLD
        self._state = State.HOLDING if hold else State.RAMPING_DOWN
        self._refusal = refusal
