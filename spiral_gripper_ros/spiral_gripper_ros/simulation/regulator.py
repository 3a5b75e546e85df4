# SPDX-License-Identifier: Apache-2.0
r"""A simulated proportional pressure regulator: it follows commands and reports its pressure.

The gauge pressure :math:`p` in the gripper follows the target :math:`p_t` with a lag :math:`T`:

.. math:: \dot p = \frac{p_t - p}{T} - \frac{p}{T_\mathrm{leak}}

The last term is a leak, laminar: proportional to the gauge pressure. The regulator has no integral
action, so that it makes a leak up only in part and settles at :math:`p_t / (1 + T /
T_\mathrm{leak})`. The target is the last command, or 0 once no command has come for
``watchdog_timeout``: the regulator's own watchdog, which vents whatever has happened to the sender.
The report is the pressure with noise, rounded to the transmitter's resolution and within its range,
from 0 to the supply pressure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from spiral_core.validation import require_non_negative
from spiral_gripper_ros.control.timing import WATCHDOG_TIMEOUT
from spiral_gripper_ros.parameters.spec import Parameters, choice, parameter

REGULATOR_NODE = "simulated_regulator"


class Fault(Enum):
    """Faults of a regulator or its lines."""

    NONE = "none"
    LEAK = "leak"  # gripper or line leaks: the pressure settles below the command
    STUCK_VALVE = "stuck_valve"  # both valves stay shut: the pressure stays where it is
    LOST_LINK = "lost_link"  # neither hears commands nor reports: the watchdog vents


def injection_service(fault: Fault) -> str:
    """Return the name, below the node's, of the service that injects a fault."""
    return "clear_fault" if fault is Fault.NONE else f"inject_{fault.value}"


@dataclass(frozen=True, slots=True)
class SimulatedRegulatorParameters(Parameters):
    """Parameters of the simulated regulator and gripper."""

    gripper: str = parameter(
        "paper_design_70",
        "Gripper description of the simulated gripper: a shipped one's name, or a file's path.",
        read_only=True,
    )
    frame_id: str = parameter("gripper_base", "Frame of every stamped message.", read_only=True)
    stiffness_factor: float = parameter(
        1.0,
        "Real stiffness of the gripper's material, as a multiple of the described one.",
        0.2,
        5.0,
        read_only=True,
    )
    fault: str = choice(Fault.NONE, "Fault of the regulator.")
    time_constant: float = parameter(0.1, "Lag of the regulator's loop [s].", 0.001, 10.0)
    supply_pressure: float = parameter(
        3.0e5,
        "Gauge pressure of the supply [Pa]; a command above it is refused.",
        1.0e4,
        1.0e6,
        read_only=True,
    )
    watchdog_timeout: float = parameter(
        WATCHDOG_TIMEOUT,
        "Silence of pressure_command after which the regulator vents by itself [s].",
        0.02,
        60.0,
    )
    leak_time: float = parameter(
        0.2,
        "Time in which a leak empties a closed gripper to 1/e [s]; acts at fault leak.",
        0.01,
        100.0,
    )
    pressure_noise: float = parameter(
        50.0, "Standard deviation of the measured pressure [Pa].", 0.0, 1.0e5
    )
    pressure_resolution: float = parameter(
        10.0, "Step of the measured pressure [Pa]; 0: none.", 0.0, 1.0e5
    )
    measured_rate: float = parameter(50.0, "Rate of measured_pressure [Hz].", 1.0, 100.0)
    truth_rate: float = parameter(20.0, "Rate of the topics below simulated/ [Hz].", 1.0, 50.0)
    publish_clock: bool = parameter(
        False,
        "Publish /clock, for nodes with use_sim_time; the simulation is then as fast as "
        "real_time_factor says, whatever the machine does.",
        read_only=True,
    )
    real_time_factor: float = parameter(
        1.0, "Speed of /clock; acts when publish_clock is true.", 0.01, 10.0
    )
    seed: int = parameter(0, "Seed of all noise.", 0, 1_000_000, read_only=True)


class SimulatedRegulator:
    """A regulator with time, faults and a watchdog.

    Args:
        model: what it is like.

    Attributes:
        model: may be replaced at any time by one with the same supply pressure.
        fault: may be changed at any time.
        pressure: gauge pressure in the gripper, as it really is [Pa].
        refused: commands that it could not take.
        watchdog_vented: whether it vents because commands have stopped, and none of 0 Pa has come
            since.

    Example:
        >>> regulator = SimulatedRegulator(SimulatedRegulatorParameters())
        >>> regulator.command(4e4)
        True
        >>> regulator.step(0.5)
        >>> round(regulator.report(), -2)
        39700.0
        >>> regulator.step(1.0)  # nobody speaks to it any more
        >>> round(regulator.report(), -2), regulator.watchdog_vented
        (0.0, True)
    """

    def __init__(self, model: SimulatedRegulatorParameters) -> None:
        self.model = model
        self.fault = Fault.NONE
        self._random = np.random.default_rng(model.seed)
        self.pressure = 0.0
        self._command: float | None = None
        self._silence = 0.0
        self.watchdog_vented = False
        self.refused = 0

    @property
    def target(self) -> float:
        """What it aims for [Pa]."""
        return 0.0 if self._command is None or self.watchdog_vented else self._command

    def command(self, pressure: float) -> bool:
        """Hear a command [Pa]; return whether it is taken.

        One that is not a finite number from 0 to the supply pressure is counted and is as good as
        none: the last one stands, and the watchdog goes on waiting. Once that has vented, only 0 Pa
        is taken.
        """
        if self.fault is Fault.LOST_LINK:
            return False
        if not 0.0 <= pressure <= self.model.supply_pressure:  # NaN neither
            self.refused += 1
            return False
        self.watchdog_vented = self.watchdog_vented and pressure != 0.0
        self._command, self._silence = pressure, 0.0
        return not self.watchdog_vented

    def step(self, duration: float) -> None:
        """Let a time [s] >= 0 pass; how it is cut into steps makes no difference.

        Raises:
            InvalidInputError: the time is negative or not finite.
        """
        remaining = require_non_negative("duration", duration)
        if self._command is not None and not self.watchdog_vented:
            left = max(self.model.watchdog_timeout - self._silence, 0.0)
            heard = min(remaining, left)
            self._flow(heard)
            self._silence += heard
            remaining -= heard
            self.watchdog_vented = heard == left
        self._flow(remaining)

    def report(self) -> float | None:
        """Return the pressure [Pa] that its transmitter reports now; None: the link is lost."""
        if self.fault is Fault.LOST_LINK:
            return None
        reported = self.pressure + self.model.pressure_noise * float(self._random.standard_normal())
        resolution = self.model.pressure_resolution
        if resolution > 0.0:
            reported = round(reported / resolution) * resolution
        return min(max(reported, 0.0), self.model.supply_pressure)

    def _flow(self, duration: float) -> None:
        if self.fault is Fault.STUCK_VALVE:
            return
        lag = self.model.time_constant
        rate = 1.0 / lag + (1.0 / self.model.leak_time if self.fault is Fault.LEAK else 0.0)
        settled = self.target / (lag * rate)
        after = settled + (self.pressure - settled) * math.exp(-rate * duration)
        # The exact solution stays within these ends; its rounding need not.
        self.pressure = min(max(after, 0.0), self.model.supply_pressure)
