# SPDX-License-Identifier: Apache-2.0
"""The subscriptions of ``spiral-gripper simulate`` to node and simulator."""

from __future__ import annotations

from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Float64, String

from spiral_gripper.files.shown import in_units, reworded
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.client.listener import Listener
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.messages.conversions import REGIME_NAMES
from spiral_gripper_ros.messages.qos import LATEST
from spiral_gripper_ros.tools.live_view import View

# What is older than this [s] is no longer shown.
FRESH = 1.0
# What is a state rather than trouble: the state says it already.
_NO_TROUBLE = (Reason.NONE, Reason.NOT_ACTIVE)


class Watcher(Listener):
    """Subscribes to node and simulator, and returns their newest state as a :class:`View`.

    Args:
        namespace: of the gripper's node and of the simulator.
    """

    def __init__(self, namespace: str) -> None:
        super().__init__("spiral_gripper_simulation", namespace)
        self.keep(Float64, "pressure_command", qos_profile_sensor_data)
        self.keep(GripStatus, "status", LATEST)
        self.keep(FluidPressure, "measured_pressure", qos_profile_sensor_data)
        self.keep(Float64, "simulated/object_radius", qos_profile_sensor_data)
        self.keep(String, "simulated/grip", qos_profile_sensor_data)

    @property
    def command(self) -> float | None:
        """The newest command [Pa]."""
        message = self.newest("pressure_command")
        return None if message is None else float(message.data)

    @property
    def ready(self) -> bool:
        """Whether the node is active and the simulator runs."""
        status = self.newest("status", FRESH)
        active = status is not None and status.state != State.INACTIVE
        return active and self.newest("simulated/grip", FRESH) is not None

    def view(self, elapsed: float) -> View:
        """Return what there is to show, a time [s] after the node became active."""
        status = self.newest("status", FRESH) or GripStatus()
        measured = self.newest("measured_pressure", FRESH)
        troubles = troubles_of(status)
        radius, grip = (
            self.newest("simulated/object_radius", FRESH),
            self.newest("simulated/grip", FRESH),
        )
        return View(
            elapsed=elapsed,
            radius=(_in("m", radius and radius.data), _in("m", status.object_radius)),
            command=None if self.command is None else float(in_units(self.command, "Pa")),
            measured=None if measured is None else float(in_units(measured.fluid_pressure, "Pa")),
            regime=REGIME_NAMES[status.measured_regime if status.measured else status.regime],
            wrapped=bool(status.wrapped),
            grip="-" if grip is None else grip.data,
            state=State(status.state).name.lower().replace("_", " "),
            trouble=reworded("; ".join(troubles.values())),
            reasons=tuple(troubles),
        )


def _in(unit: str, value: float | None) -> float | None:
    """Return a value of an SI unit as it is shown; what is 0 or None is not known."""
    return float(in_units(value, unit)) if value else None


def troubles_of(status: GripStatus) -> dict[int, str]:
    """Return the reasons for what is wrong, each with its text for people."""
    troubles = {}
    if status.pressure_fault != Reason.NONE:
        troubles[status.pressure_fault] = status.pressure_fault_text
    if status.reason not in (*_NO_TROUBLE, status.pressure_fault):
        troubles[status.reason] = status.reason_text
    return troubles
