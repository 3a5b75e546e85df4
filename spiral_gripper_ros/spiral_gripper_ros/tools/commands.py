# SPDX-License-Identifier: Apache-2.0
"""The commands to a running node: ``spiral-gripper plan``, ``grasp``, ``release``, ..."""

from __future__ import annotations

import math
import time
from contextlib import closing, suppress
from dataclasses import asdict, dataclass
from typing import Any

from rclpy.action import ActionClient

from spiral_gripper.files.shown import shown, shown_range
from spiral_gripper_msgs.action import Release
from spiral_gripper_msgs.msg import Grip, GripStatus
from spiral_gripper_ros.client.answers import NoAnswerError, WrapOutcome, no_node_in
from spiral_gripper_ros.client.connection import Connection
from spiral_gripper_ros.client.goals import UNKNOWN_GOAL
from spiral_gripper_ros.client.spiral_gripper import SpiralGripper
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.messages.conversions import REGIME_NAMES, known
from spiral_gripper_ros.tools.node_text import node_text
from spiral_gripper_ros.tools.watcher import Watcher

# How long a command looks for the node: DDS may take seconds to discover it [s].
DISCOVERY_TIMEOUT = 10.0
# Between two looks at what the node does [s].
SHOW_PERIOD = 0.1
# After so long a result is asked for again: a node that was started again knows no goal [s].
ASK_AGAIN = 2.0
# A node whose release neither ends nor goes on for its timeout and this time [s] hangs: longer than
# the default timeout, and than it takes to see that a simulated clock stands still.
RELEASE_PATIENCE = 15.0
# Reasons that a user caused on purpose.
_NO_TROUBLE = (Reason.NONE, Reason.NO_RADIUS, Reason.RELEASED)


@dataclass(frozen=True, slots=True)
class Answer:
    """The output of a command.

    Args:
        good: whether the command succeeded.
        lines: for people, quantities in the units shown.
        document: for programs, SI units.
    """

    good: bool
    lines: list[str]
    document: dict[str, object]


def plan(
    namespace: str,
    radius: float,
    overpressure: float | None = None,
    payload: float | None = None,
    friction: float | None = None,
) -> Answer:
    """Ask `plan_wrap`; with a payload [kg] or a friction for the grip on exactly this object.

    A payload that is not held, or of which that is not known, is no good answer.

    Raises:
        NoAnswerError: no node answers.
    """
    exact = payload is not None or friction is not None
    with SpiralGripper(namespace, DISCOVERY_TIMEOUT) as gripper:
        answer = gripper.plan(radius, overpressure, payload, friction, compute_grip=exact)
    lines, good = [node_text(answer.message)], bool(answer.success)
    grip = answer.grip[0] if answer.grip else None
    document = _document(answer, without=("backbone", "figures"))
    for figures in answer.figures:
        lines += [
            f"pressure         {shown(figures.pressure, 'Pa')}",
            f"turns            {figures.turns:.2f}",
            f"object length    {_shown(figures.object_length_needed, 'm', 'not known')} needed",
            f"line force       {shown(figures.line_force, 'N/m')}",
        ]
        lines += grip_lines(grip)
        document |= _document(figures)
    if answer.success and payload is not None:
        margin = None if grip is None else known(grip.payload_margin)
        good, said = False, "not known whether it is held"
        if margin is not None:
            good, size = margin >= 0.0, shown(abs(margin), "N", 3)
            said = f"held with {size} to spare" if good else f"NOT held: {size} too little"
        lines.append(f"payload          {shown(payload, 'kg', 3)} {said}")
    if answer.radius_range:
        lines.append(f"grips radii      {shown_range(*answer.radius_range)}")
    return Answer(good, lines, document)


def grip_lines(grip: Grip | None) -> list[str]:
    """Return what holds an object, for people."""
    if grip is None:
        return ["holding force    not known (yet)"]
    down, touching = known(grip.holding_force_down), shown(grip.contact_length, "m", 3)
    return [
        f"in contact       {touching} of tube, {shown(grip.normal_force, 'N', 3)} in all",
        f"wrapped          from {shown(grip.onset_wrap, 'Pa')}, by contact",
        f"curling          from {_shown(grip.onset_curling, 'Pa', 'none up to the limit')}",
        f"lost             at {_shown(grip.loss, 'Pa', 'none up to the limit')}",
        f"holding force    {_holding(grip.holding_force_away, grip.holding_force_towards)}",
        f"                 {'-' if down is None else shown(down, 'N', 3)} downwards",
        f"computed         {grip.age:.0f} s ago, for friction {grip.friction_coefficient:.2g}",
    ]


def _holding(away: float, towards: float) -> str:
    return f"{shown(away, 'N', 3)} away from the base, {shown(towards, 'N', 3)} towards it"


def grasp(
    namespace: str,
    radius: float | None,
    overpressure: float | None,
    timeout: float | None,
    abort_policy: str | None,
) -> Answer:
    """Wrap an object and wait for the end; a KeyboardInterrupt cancels it.

    The other arguments are those of :meth:`SpiralGripper.wrap`.

    Raises:
        NoAnswerError: no node answers, or it falls silent.
    """
    with SpiralGripper(namespace, DISCOVERY_TIMEOUT) as gripper:
        gripper.wait_until_active(DISCOVERY_TIMEOUT)
        try:
            gripper.wrap(radius, overpressure, timeout, abort_policy)
            while not gripper.is_done():
                pass  # each look takes a while; the node's own time-out ends it
        except KeyboardInterrupt:
            try:
                gripper.cancel()
            except NoAnswerError as error:
                late = "interrupted, but the wrap may go on: spiral-gripper release vents"
                raise NoAnswerError(f"{late}; {error.missing}", error.timeout) from None
            raise
        result = gripper.result()
    if result is None:
        raise NoAnswerError("the wrap has no result", DISCOVERY_TIMEOUT)
    good = result.outcome is WrapOutcome.SUCCEEDED
    lines = [node_text(result.message)]
    if good:
        lines.append(f"{result.turns:.2f} turns; holds until `spiral-gripper release`")
    away, towards = result.holding_force_away, result.holding_force_towards
    if good and away is not None and towards is not None:
        lines.append(f"holds {_holding(away, towards)}")
    words = {"outcome": result.outcome.value, "reason": result.reason.name}
    return Answer(good, lines, asdict(result) | words)


def release(namespace: str, timeout: float | None) -> Answer:
    """Vent, and wait until the pressure is gone.

    Raises:
        NoAnswerError: no node answers, or it falls silent.
    """
    link = Connection(namespace, DISCOVERY_TIMEOUT, lambda: no_node_in(namespace))
    action = ActionClient(link.node, Release, "release")
    try:
        link.require(action.server_is_ready)
        # One that is no number is sent as it is: the node vents all the same, and says so.
        goal = Release.Goal(timeout=[] if timeout is None else [timeout])
        heard, patience = time.monotonic(), RELEASE_PATIENCE
        if timeout is not None and 0.0 < timeout < math.inf:
            patience += timeout

        def hear(_: object) -> None:
            nonlocal heard
            heard = time.monotonic()

        sent = action.send_goal_async(goal, hear)
        handle = link.answer(sent, "release")
        while not link.spin_until((ended := handle.get_result_async()).done, ASK_AGAIN):
            if not action.server_is_ready():
                raise NoAnswerError("the node has gone before it said that it has vented", 0.0)
            if time.monotonic() - heard > patience:
                late = "does not say whether it has vented; it hangs, or its clock stands still"
                raise NoAnswerError(f"the node {late}", patience)
        result = ended.result().result
    finally:
        action.destroy()
        link.close()
    lines = [node_text(result.message or UNKNOWN_GOAL)]
    return Answer(bool(result.success), lines, _document(result))


def status(namespace: str) -> Answer:
    """Hear one status.

    Raises:
        NoAnswerError: none comes.
    """
    deadline = time.monotonic() + DISCOVERY_TIMEOUT
    with SpiralGripper(namespace, DISCOVERY_TIMEOUT) as gripper:
        while (heard := gripper.status) is None:
            if time.monotonic() > deadline:
                raise NoAnswerError(no_node_in(namespace), DISCOVERY_TIMEOUT)
        while (planned := gripper.planned) is None and time.monotonic() < deadline:
            pass
    told = {heard.fault: heard.fault_text, heard.reason: heard.reason_text}
    troubles = [
        f"{Reason(reason).name}: {node_text(text)}"
        for reason, text in told.items()
        if reason not in _NO_TROUBLE
    ]
    document = _document(heard) | {"wrap": None if planned is None else _document(planned)}
    radii = shown_range(*planned.radius_range) if planned and planned.radius_range else "none"
    lines = [*_status_lines(heard), f"grips radii      {radii}", *troubles]
    return Answer(not troubles, lines, document)


def watch(namespace: str, duration: float) -> int:
    """Show what the node does for a time [s], or until a KeyboardInterrupt; return 0.

    Raises:
        NoAnswerError: no node was heard in that time.
    """
    begin = time.monotonic()
    with suppress(KeyboardInterrupt), closing(Watcher(namespace)) as watcher:
        while (elapsed := time.monotonic() - begin) < duration:
            watcher.spin(min(SHOW_PERIOD, duration - elapsed))
            watcher.show(elapsed)
        if watcher.newest("status") is None and not watcher.is_there:
            raise NoAnswerError(no_node_in(namespace), duration)
    return 0


def _status_lines(heard: GripStatus) -> list[str]:
    """Return a status as people read it."""
    target = shown(heard.pressure_target, "Pa")
    return [
        f"state            {State(heard.state).name}",
        f"object radius    {_shown(heard.object_radius, 'm', 'none')}",
        f"command          {shown(heard.pressure_command, 'Pa')} of {target}",
        f"measured         {_shown(heard.measured_pressure, 'Pa', 'not measured')}",
        f"regime           {REGIME_NAMES[heard.regime]}",
        f"wrapped          {'yes' if heard.wrapped else 'no'}",
    ]


def _shown(values: Any, unit: str, otherwise: str) -> str:  # noqa: ANN401
    """Return the number of a list of at most one as it is shown, or what stands for none."""
    value = known(values)
    return otherwise if value is None else shown(value, unit)


def _document(message: Any, without: tuple[str, ...] = ()) -> dict[str, object]:  # noqa: ANN401
    """Return the fields of a message by name; a list of at most one is its value or None."""
    found: dict[str, object] = {}
    for name, kind in message.get_fields_and_field_types().items():
        if name not in without:
            value = _value(getattr(message, name))
            found[name] = (*value, None)[0] if kind.endswith(", 1>") else value
    return found


def _value(value: Any) -> Any:  # noqa: ANN401
    """Return the value of a field of a message as JSON has it."""
    if hasattr(value, "get_fields_and_field_types"):
        return _document(value)
    return value if isinstance(value, (bool, int, float, str)) else list(map(_value, value))
