# SPDX-License-Identifier: Apache-2.0
"""The newest state of node and simulator in lines, for ``watch``, ``simulate`` and the demo."""

from __future__ import annotations

import time

from rclpy.qos import qos_profile_sensor_data
from rich.console import Console
from std_msgs.msg import Float64, String

from spiral_gripper.files.shown import axis_label, in_units
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.client.listener import Listener
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.messages.conversions import REGIME_NAMES, known
from spiral_gripper_ros.messages.qos import LATEST
from spiral_gripper_ros.tools.node_text import node_text

# What is older than this [s] is no longer shown.
FRESH = 2.5
# Time between two lines while only numbers change [s].
LINE_PERIOD = 1.0
# Widths of the columns in characters.
WIDTHS = (5, 11, 13, 13, 14, 12, 7, 13, 12, 0)
# What is a state rather than trouble: the state says it already.
_NO_TROUBLE = (Reason.NONE, Reason.NOT_ACTIVE)


class Watcher(Listener):
    """Subscribes to node and simulator, and prints their newest state.

    Args:
        namespace: of the gripper's node and of the simulator.
    """

    def __init__(self, namespace: str) -> None:
        super().__init__(namespace)
        self.keep(Float64, "pressure_command", qos_profile_sensor_data)
        self.keep(GripStatus, "status", LATEST)
        self.keep(Float64, "measured_pressure", qos_profile_sensor_data)
        self.keep(Float64, "simulated/object_radius", qos_profile_sensor_data)
        self.keep(String, "simulated/grip", qos_profile_sensor_data)
        self._shown: tuple[object, ...] = ()
        self._due = 0.0

    @property
    def command(self) -> float | None:
        """The newest command [Pa]."""
        message = self.newest("pressure_command")
        return None if message is None else float(message.data)

    @property
    def is_there(self) -> bool:
        """Whether there is a configured node now, active or not."""
        return bool(self.node.count_publishers(self.node.resolve_topic_name("status")))

    @property
    def ready(self) -> bool:
        """Whether the node is active and the simulator runs."""
        status = self.newest("status", FRESH)
        active = status is not None and status.state != State.INACTIVE
        return active and self.newest("simulated/grip", FRESH) is not None

    def verdict(self) -> list[str]:
        """Return what was not as expected, one line each, after a session that was not stopped."""
        return []

    def show(self, elapsed: float) -> None:
        """Print a line with a time [s], if more than numbers has changed or the last is old."""
        heard = self.newest("status", FRESH)
        if heard is None and self.is_there:
            heard = GripStatus()  # inactive
        status = heard or GripStatus()
        command = self.newest("pressure_command", FRESH)
        measured = self.newest("measured_pressure", FRESH)
        radius = self.newest("simulated/object_radius", FRESH)
        grip = self.newest("simulated/grip", FRESH)
        troubles = troubles_of(status)
        shown = (heard and status.state, status.wrapped, grip and grip.data, *troubles)
        if shown == self._shown and time.monotonic() < self._due:
            return
        cells = {
            "t [s]": f"{elapsed:5.1f}",
            axis_label("object", "m"): _number((radius and radius.data) or None, "m"),
            axis_label("believed", "m"): _number(known(status.object_radius), "m"),
            axis_label("command", "Pa"): _number(command and command.data, "Pa"),
            axis_label("measured", "Pa"): _number(measured and measured.data, "Pa"),
            "regime": REGIME_NAMES[status.regime] if heard else "-",
            "wrapped": ("yes" if status.wrapped else "no") if heard else "-",
            "really": "-" if grip is None else grip.data,
            "state": State(status.state).name.lower().replace("_", " ") if heard else "silent",
            "trouble": node_text("; ".join(troubles.values())),
        }
        for line in (cells.values(),) if self._shown else (cells, cells.values()):
            padded = (text.ljust(width) for text, width in zip(line, WIDTHS, strict=True))
            say("  ".join(padded).rstrip())
        self._shown, self._due = shown, time.monotonic() + LINE_PERIOD


def troubles_of(status: GripStatus) -> dict[int, str]:
    """Return the reasons for what is wrong, each with its text for people."""
    troubles = {}
    if status.fault != Reason.NONE:
        troubles[status.fault] = status.fault_text
    if status.reason not in (*_NO_TROUBLE, status.fault):
        troubles[status.reason] = status.reason_text
    return troubles


def say(text: str, style: str | None = None) -> None:
    """Print a line as it is."""
    Console().print(text, style=style, highlight=False, markup=False, soft_wrap=True)


def _number(value: float | None, unit: str) -> str:
    """Return a value of an SI unit as it is shown; None is not known."""
    return "-" if value is None else f"{in_units(value, unit):.2f}"
