# SPDX-License-Identifier: Apache-2.0
"""The refusals of the control logic: constant ones, and those about stale inputs."""

from __future__ import annotations

from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import Reason, Refusal

# Gauge pressures that an absolute sensor of a vented gripper shows at sea level [Pa]. At greater
# heights they are those of a usual wrap, and cannot be told apart.
ATMOSPHERE_AT_SEA = (9.5e4, 1.07e5)
MUST_BE_GAUGE = "measured_pressure must be gauge; spiral_gripper_regulator converts it"

NO_RADIUS = Refusal(Reason.NO_RADIUS, "no object_radius has been received yet")
NOT_FOLLOWING = Refusal(Reason.NO_RADIUS, "no object_radius is being followed: give a radius")
NOT_ACTIVE = Refusal(Reason.NOT_ACTIVE, "the node is not active: configure and activate it")
RELEASED = Refusal(Reason.RELEASED, "released: call rearm, or deactivate and activate, to grip")
RECONFIGURED = Refusal(
    Reason.RECONFIGURED, "another gripper was loaded: call rearm to follow radii with it"
)
NOT_RELEASED = Refusal(Reason.INVALID_REQUEST, "a pressure is commanded: release first")
TAKEN_OVER = Refusal(
    Reason.TAKEN_OVER, "the measured pressure was taken over: it is kept until a radius or a goal"
)
TAKING_OVER = Refusal(
    Reason.TAKEN_OVER, "waiting for measured_pressure to agree before one is taken over"
)
GRASP_CANCELED = Refusal(Reason.GRASP_CANCELED, "the grasp was canceled")
GRASP_REPLACED = Refusal(Reason.GRASP_REPLACED, "a newer grasp goal has taken over")


def stale_radius(age: float, limits: Limits, last: Refusal) -> Refusal:
    """Return that no usable radius has come for ``age`` [s], and what was wrong with the last one.

    Example:
        >>> limits = Limits(pressure_cap=1.0e5)
        >>> stale_radius(1.5, limits, Refusal(Reason.NONE, "")).text
        'no usable object_radius for 1.50 s (radius.timeout 1 s, policy hold)'
    """
    return Refusal(
        Reason.RADIUS_STALE,
        f"no usable object_radius for {age:.2f} s (radius.timeout {limits.radius_timeout:.3g} s, "
        f"policy {limits.radius_timeout_policy.value}){cause(last)}",
    )


def lost_client(limits: Limits) -> Refusal:
    """Return that the client has given no sign of life for too long."""
    return Refusal(
        Reason.CLIENT_LOST,
        f"no keep_alive for {limits.keep_alive_timeout:.3g} s (keep_alive.timeout): vented; call "
        "rearm, or send a goal",
    )


def stale_gravity(age: float | None, limits: Limits) -> Refusal:
    """Return that no usable gravity has come for ``age`` [s], or since the activation."""
    silence = "since the activation" if age is None else f"for {age:.2f} s"
    return Refusal(
        Reason.GRAVITY_STALE,
        f"no usable gravity {silence} (gravity.timeout {limits.gravity_timeout:.3g} s)",
    )


def late_grasp(
    snapshot: Snapshot, timeout: float, regime: WrapRegime | None, is_settled: bool
) -> Refusal:
    """Return why a grasp was not reached in its time.

    Args:
        snapshot: what is commanded and measured.
        timeout: that time [s].
        regime: how the object is held, or None if that is not known.
        is_settled: whether the pressure is at its target to stay.
    """
    pressure = f"command {snapshot.pressure_command:.6g} of {snapshot.pressure_target:.6g} Pa"
    if snapshot.measured_pressure is not None:
        pressure += f", measured {snapshot.measured_pressure:.6g} Pa"
    pressure += cause(snapshot.refusal)
    if is_settled and not snapshot.refusal:
        seen = "unknown" if regime is None else regime.value
        return Refusal(
            Reason.WRAP_FAILED,
            f"the pressure has settled, but it is no perfect wrap: {seen} ({pressure})",
        )
    return Refusal(
        Reason.GRASP_TIMEOUT, f"the target was not reached within {timeout:.3g} s: {pressure}"
    )


def cause(last: Refusal) -> str:
    """Return the end of a text that tells what was refused last, if anything was."""
    return f"; last refused: {last.text}" if last else ""


def impossible_take_over(pressure: float, limits: Limits) -> Refusal | None:
    """Return why a measured gauge pressure [Pa] must not become the command, or None.

    Example:
        >>> impossible_take_over(101325.0, Limits(pressure_cap=2.0e5)).text.partition(":")[0]
        'measured_pressure 101325 Pa looks absolute'
    """
    tolerance, cap = limits.pressure_tolerance, limits.pressure_cap
    if ATMOSPHERE_AT_SEA[0] <= pressure <= ATMOSPHERE_AT_SEA[1]:
        why = f"looks absolute: {MUST_BE_GAUGE}"
    elif pressure > cap + tolerance:
        why = f"is above pressure.cap {cap:.6g} Pa"
    elif pressure < -tolerance:
        why = "is below 0 Pa"
    else:
        return None
    text = f"measured_pressure {pressure:.6g} Pa {why}; it is not taken over, release vents"
    return Refusal(Reason.TAKEN_OVER, text)
