# SPDX-License-Identifier: Apache-2.0
"""The operator's log: one line for each change, at a bounded rate."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

from spiral_gripper.files.storage import FileError
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import Reason, State

# This many changes are logged at once, then one each period [s]; of more, only the last state.
BURST = 5
PERIOD = 1.0

_WORDS = {
    State.INACTIVE: "inactive, vented",
    State.WAITING: "waiting for an object_radius",
    State.TRACKING: "following object_radius",
    State.HOLDING: "holding",
    State.RAMPING_DOWN: "ramping down",
    State.VENTED: "vented",
    State.RELEASED: "released, vented",
    State.FAULT: "fault, vented",
    State.GRASPING: "grasping",
    State.TAKEN_OVER: "holding the measured pressure",
}
# Reasons that a user caused, or that belong to normal operation.
_EXPECTED = {
    Reason.NONE,
    Reason.NO_RADIUS,
    Reason.NOT_ACTIVE,
    Reason.RELEASED,
    Reason.RECONFIGURED,
    Reason.GRASP_CANCELED,
    Reason.GRASP_REPLACED,
    Reason.TAKEN_OVER,
}


class EventLog:
    """Logs changes of state, reason, pressure fault, hold and clock.

    Args:
        logger: of the node.
    """

    def __init__(self, logger: Any) -> None:  # noqa: ANN401
        self._logger = logger
        self._grip = _Channel((State.INACTIVE, Reason.NOT_ACTIVE, None))
        self._fault, self._gravity = _Channel(Reason.NONE), _Channel(Reason.NONE)
        self._wrapped = _Channel(False)
        self._clock_stands_still, self._commanders = False, 1

    def tell(self, now: float, snapshot: Snapshot) -> None:
        """Log what has changed since the last call, at a time [s] that never decreases."""
        logger, fault, gravity = self._logger, snapshot.pressure_fault, snapshot.gravity_fault
        pinned = snapshot.radius if snapshot.state is State.GRASPING else None
        grip = (snapshot.state, snapshot.refusal.reason, pinned)
        # A latched state cannot chatter, and the next line may come late. Each level of a line has
        # a place of its own, as rclpy demands.
        if self._grip.is_due(now, grip, at_once=snapshot.state.is_latched):
            line = _grip_line(snapshot)
            if snapshot.state is State.FAULT:
                logger.error(line)
            elif snapshot.refusal.reason in _EXPECTED:
                logger.info(line)
            else:
                logger.warning(line)
        if self._fault.is_due(now, fault.reason):
            if fault:
                logger.error(fault.text)
            else:
                logger.info("measured_pressure is as commanded again")
        if self._gravity.is_due(now, gravity.reason):
            logger.warning(gravity.text or "gravity is heard again")
        if self._wrapped.is_due(now, snapshot.wrapped):
            held = f"the object is wrapped at {_kilopascal(snapshot.pressure_command)}"
            logger.info(held if snapshot.wrapped else "no object is wrapped any more")

    def tell_clock(self, stands_still: bool) -> None:
        """Log that the simulated clock has stopped, or runs again."""
        stops = "/clock has stopped: the command stays constant (use_sim_time is set)"
        if stands_still is self._clock_stands_still:
            return
        if stands_still:
            self._logger.warning(stops)
        else:
            self._logger.info("/clock runs again")
        self._clock_stands_still = stands_still

    def tell_range(self, name: str, radius_range: tuple[float, float], cap: float) -> None:
        """Log which radii [m] a loaded gripper can grip, and the cap in force [Pa]."""
        low, high = radius_range
        self._logger.info(
            f"{name}: grips radii from {1e3 * low:.4g} to {1e3 * high:.4g} mm, "
            f"with at most {_kilopascal(cap)}"
        )

    def tell_nothing_beside(self, error: FileError) -> None:
        """Log why there is no answer beside a description: no file, or one that is not used."""
        if error.action == "read":
            self._logger.info(str(error))
        else:
            self._logger.warning(str(error))

    def tell_others(self, publishers: int) -> None:
        """Warn if more than one node commands the regulator, once for each number of them."""
        if publishers > max(self._commanders, 1):
            self._logger.warning(
                f"{publishers} nodes publish pressure_command: the regulator follows all of them"
            )
        self._commanders = publishers

    def tell_limits(self, limits: Limits) -> None:
        """Log what bounds the commands from now on, and what happens when inputs stop."""
        ratio = limits.grip_ratio
        grip = "recommended pressure" if ratio is None else f"grip.ratio {ratio:.4g}"
        self._logger.info(
            f"active: at most {_kilopascal(limits.pressure_cap)}, "
            f"{_kilopascal(limits.pressure_rate_up)}/s up, "
            f"{_kilopascal(limits.pressure_rate_down)}/s down, {grip}; when radii stop: "
            f"{limits.radius_timeout_policy.value}, at a pressure fault: "
            f"{limits.pressure_fault_policy.value}, when a grasp fails: "
            f"{limits.grasp_abort_policy.value}"
        )


class _Channel:
    """One quantity: whether its change is logged now."""

    def __init__(self, first: Hashable) -> None:
        self._told = first
        self._credit = float(BURST)
        self._now = 0.0

    def is_due(self, now: float, state: Hashable, *, at_once: bool = False) -> bool:
        """Return whether ``state`` is logged at ``now`` [s]: it is new, and the rate allows it.

        ``at_once``: whatever the rate.
        """
        self._credit = min(self._credit + max(now - self._now, 0.0) / PERIOD, float(BURST))
        self._now = now
        if state == self._told or not (at_once or self._credit >= 1.0):
            return False
        self._told = state
        self._credit = max(self._credit - 1.0, 0.0)
        return True


def _grip_line(snapshot: Snapshot) -> str:
    text = _WORDS[snapshot.state]
    if snapshot.state in (State.TRACKING, State.GRASPING):
        if snapshot.radius is not None:
            text += f", radius {1000.0 * snapshot.radius:.4g} mm"
        text += f", target {_kilopascal(snapshot.pressure_target)}"
    if snapshot.state in (State.HOLDING, State.RAMPING_DOWN):
        text += f" at {_kilopascal(snapshot.pressure_command)}"
    return f"{text}: {snapshot.refusal.text}" if snapshot.refusal.text else text


def _kilopascal(pressure: float) -> str:
    return f"{1e-3 * pressure:.4g} kPa"
