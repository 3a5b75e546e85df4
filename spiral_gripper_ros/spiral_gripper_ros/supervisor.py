"""The control logic of the node: a state machine without ROS, without a clock, without files.

It is told what happened and when; it answers with the pressure to command and why. The node only
unpacks messages, calls it, and packs what it says. ``docs/node.md`` draws the transitions.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from spiral_core.errors import SpiralError
from spiral_core.validation import require_finite
from spiral_gripper_ros.limits import Limits, TimeoutPolicy
from spiral_gripper_ros.pressure_ramp import capped_pressure, ramped_pressure
from spiral_gripper_ros.radius_gate import RadiusGate
from spiral_gripper_ros.states import Reason, Refusal, State, refusal_from_error


class Plan(Protocol):
    """What the supervisor needs to know of a planned wrap."""

    @property
    def pressure(self) -> float:
        """Gauge pressure of the perfect wrap [Pa]."""
        ...


PlanT = TypeVar("PlanT", bound=Plan)
PlanT_co = TypeVar("PlanT_co", bound=Plan, covariant=True)


class Planner(Protocol[PlanT_co]):
    """Turns a radius into a plan, for one gripper and one gravity."""

    @property
    def radius_range(self) -> tuple[float, float]:
        """Smallest and largest radius that can be gripped [m]."""
        ...

    def plan(self, radius: float) -> PlanT_co:
        """Return the perfect wrap for a radius [m]; raise a ``SpiralError`` if there is none."""
        ...


@dataclass(frozen=True, slots=True)
class Snapshot(Generic[PlanT]):
    """What the supervisor commands and why, at one moment.

    Args:
        state: what it does.
        refusal: why the newest input is not followed (``Reason.NONE`` if it is).
        radius: radius in use [m], or None.
        plan: the wrap that belongs to ``radius``, or None.
        radius_age: time since the last usable radius [s], or None before the first.
        pressure_target: where the command is heading [Pa].
        pressure_command: the command [Pa].
        accepted: radii accepted since activation.
        refused: refusals since activation, by reason.
    """

    state: State
    refusal: Refusal
    radius: float | None
    plan: PlanT | None
    radius_age: float | None
    pressure_target: float
    pressure_command: float
    accepted: int
    refused: Counter[Reason]


_FOLLOWED = Refusal(Reason.NONE, "")
_NO_RADIUS = Refusal(Reason.NO_RADIUS, "no object_radius has been received yet")
_NOT_ACTIVE = Refusal(Reason.NOT_ACTIVE, "the node is not active: configure and activate it")
_RELEASED = Refusal(Reason.RELEASED, "released: call rearm, or deactivate and activate, to grip")
# States that end only with rearm or the next activation.
_LATCHED = (State.INACTIVE, State.RELEASED, State.FAULT)


class Supervisor(Generic[PlanT]):
    """Decides the pressure command; see :class:`State` for what it can be doing.

    Times are seconds of any clock. Should that clock run backwards, no time passes until it runs
    forward again.

    Args:
        limits: what no command may exceed and how radii are judged.

    Example:
        >>> supervisor = Supervisor(Limits(pressure_cap=1.0e5))
        >>> supervisor.command(now=0.0), supervisor.snapshot().state.name
        (0.0, 'INACTIVE')
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._gate = RadiusGate()
        self._last_reading: float | None = None
        self._now = 0.0
        self._ramped_until = 0.0
        self._pressure = 0.0
        self._radius: float | None = None
        self._plan: PlanT | None = None
        self._must_plan = True
        self._accepted = 0
        self._accepted_at: float | None = None
        self._refused: Counter[Reason] = Counter()
        self._state = State.INACTIVE
        self._refusal = _NOT_ACTIVE
        self._last_refused = _FOLLOWED

    # --- life cycle --------------------------------------------------------------------------

    def activate(self) -> None:
        """Start waiting for radii; nothing of an earlier activation is remembered."""
        self._forget()

    def deactivate(self) -> None:
        """Vent, and stay vented until activated."""
        self._vent(State.INACTIVE, _NOT_ACTIVE)

    def release(self) -> None:
        """Vent, and stay vented until re-armed or activated anew. Safe in any state."""
        if self._state in (State.INACTIVE, State.FAULT):
            self._pressure = 0.0
        else:
            self._vent(State.RELEASED, _RELEASED)

    def rearm(self) -> Refusal | None:
        """Follow radii again after a release or a fault; return why not if that cannot be."""
        if self._state is State.INACTIVE:
            return _NOT_ACTIVE
        if self._state in (State.RELEASED, State.FAULT):
            self._vent(State.WAITING, _NO_RADIUS)
        return None

    def fail(self, text: str) -> None:
        """Vent because of an internal error, and stay vented until re-armed or activated anew."""
        state = State.INACTIVE if self._state is State.INACTIVE else State.FAULT
        self._vent(state, Refusal(Reason.INTERNAL_ERROR, text))

    # --- inputs ------------------------------------------------------------------------------

    def offer_radius(self, now: float, radius: float, planner: Planner[PlanT]) -> bool:
        """Judge a radius estimate [m], any float, and aim for its wrap if it is good.

        Returns:
            Whether that changed the state, the reason or the target.
        """
        before = (self._state, self._refusal.reason, self._plan)
        self._advance(now)
        if self._state in _LATCHED:
            self._refused[self._refusal.reason] += 1
            return False
        refusal = self._gate.refusal(self._now, radius, planner.radius_range, self._limits)
        if refusal is None and self._is_news(radius):
            refusal = self._aim(radius, planner)
        if refusal is not None:
            self.refuse(refusal)
        else:
            self._accepted += 1
            self._accepted_at = self._now
            self._refusal = self._last_refused = _FOLLOWED
            self._state = State.TRACKING
        return before != (self._state, self._refusal.reason, self._plan)

    def replan(self, planner: Planner[PlanT]) -> None:
        """Aim anew for the radius in use, because gravity has changed.

        If it can no longer be gripped the present target stands and the reason is kept until a
        radius is accepted.
        """
        self._must_plan = True
        if self._radius is None or self._state in _LATCHED:
            return
        refusal = self._aim(self._radius, planner)
        if refusal is not None:
            self.refuse(refusal)

    def refuse(self, refusal: Refusal) -> None:
        """Record that an input is not followed; a target that is being tracked is held."""
        self._refused[refusal.reason] += 1
        if self._state in _LATCHED:
            return
        self._refusal = refusal
        self._last_refused = refusal
        if self._state is State.TRACKING:
            self._state = State.HOLDING

    def reconfigure(self, limits: Limits) -> None:
        """Use other limits from now on; a lower cap cuts the command with the next step."""
        self._limits = limits
        self._must_plan = True
        if self._plan is not None and self._plan.pressure > limits.pressure_cap:
            self.refuse(_above_cap(self._plan.pressure, limits))

    # --- output ------------------------------------------------------------------------------

    def command(self, now: float) -> float:
        """Let time pass until ``now`` [s] and return the gauge pressure to command [Pa]."""
        self._advance(now)
        elapsed, self._ramped_until = self._now - self._ramped_until, self._now
        self._act_on_timeout()
        if self._state in (State.TRACKING, State.HOLDING, State.RAMPING_DOWN):
            self._pressure = ramped_pressure(self._pressure, self._goal(), elapsed, self._limits)
        else:
            self._pressure = 0.0
        if self._state is State.RAMPING_DOWN and not self._pressure > 0.0:
            self._vent(State.VENTED, self._refusal)
        return self._pressure

    def snapshot(self) -> Snapshot[PlanT]:
        """Return what is commanded and why, as of the last call."""
        age = None if self._accepted_at is None else self._now - self._accepted_at
        return Snapshot(
            state=self._state,
            refusal=self._refusal,
            radius=self._radius,
            plan=self._plan,
            radius_age=age,
            pressure_target=self._goal(),
            pressure_command=self._pressure,
            accepted=self._accepted,
            refused=self._refused.copy(),
        )

    # --- inside ------------------------------------------------------------------------------

    def _forget(self) -> None:
        self._accepted = 0
        self._refused = Counter()
        self._vent(State.WAITING, _NO_RADIUS)

    def _vent(self, state: State, refusal: Refusal) -> None:
        """Command 0 Pa at once and forget the target."""
        self._state = state
        self._refusal = refusal
        self._pressure = 0.0
        self._radius = None
        self._plan = None
        self._must_plan = True
        self._accepted_at = None
        self._last_refused = _FOLLOWED
        self._gate.reset()

    def _advance(self, now: float) -> None:
        """Move the inner clock on to ``now`` [s]; it never runs backwards."""
        reading = require_finite("now", now)
        if self._last_reading is not None:
            self._now += max(reading - self._last_reading, 0.0)
        self._last_reading = reading

    def _is_news(self, radius: float) -> bool:
        """Has the radius left the hysteresis band around the one in use?"""
        if self._must_plan or self._radius is None:
            return True
        return not abs(radius - self._radius) <= self._limits.radius_hysteresis

    def _aim(self, radius: float, planner: Planner[PlanT]) -> Refusal | None:
        """Plan for ``radius`` and make it the target, or return why not and change nothing."""
        try:
            plan = planner.plan(radius)
            require_finite("pressure", plan.pressure)
        except SpiralError as error:
            return refusal_from_error(error)
        if not plan.pressure <= self._limits.pressure_cap:
            return _above_cap(plan.pressure, self._limits)
        self._radius, self._plan, self._must_plan = radius, plan, False
        return None

    def _act_on_timeout(self) -> None:
        if self._state not in (State.TRACKING, State.HOLDING) or self._accepted_at is None:
            return
        age = self._now - self._accepted_at
        if age <= self._limits.radius_timeout:
            return
        if self._refusal.reason is not Reason.RADIUS_STALE:
            self._refused[Reason.RADIUS_STALE] += 1
        refusal = _stale(age, self._limits, self._last_refused)
        policy = self._limits.timeout_policy
        if policy is TimeoutPolicy.VENT:
            self._vent(State.VENTED, refusal)
            return
        hold = policy is TimeoutPolicy.HOLD
        self._state = State.HOLDING if hold else State.RAMPING_DOWN
        self._refusal = refusal

    def _goal(self) -> float:
        """Return the pressure the command is heading for [Pa]."""
        if self._plan is None or self._state not in (State.TRACKING, State.HOLDING):
            return 0.0
        return capped_pressure(self._plan.pressure, self._limits.pressure_cap)


def _above_cap(pressure: float, limits: Limits) -> Refusal:
    return Refusal(
        Reason.PRESSURE_CAP,
        f"the wrap needs {pressure:.6g} Pa, above pressure_cap = {limits.pressure_cap:.6g} Pa",
    )


def _stale(age: float, limits: Limits, last: Refusal) -> Refusal:
    cause = "" if last.reason is Reason.NONE else f"; last refused: {last.text}"
    return Refusal(
        Reason.RADIUS_STALE,
        f"no usable object_radius for {age:.2f} s (radius_timeout {limits.radius_timeout:.3g} s, "
        f"policy {limits.timeout_policy.value}){cause}",
    )
