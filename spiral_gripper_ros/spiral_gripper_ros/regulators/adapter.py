# SPDX-License-Identifier: Apache-2.0
"""The adapter's logic: set-points sent to a device, and reports of its state. No ROS."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

from spiral_gripper_ros.control.pressure_monitor import impossible_pressure
from spiral_gripper_ros.regulators.command_watch import CommandWatch
from spiral_gripper_ros.regulators.device import LinkError, PressureDevice
from spiral_gripper_ros.regulators.parameters import RegulatorParameters
from spiral_gripper_ros.regulators.pressure_scale import PressureScale

# How often a vent is sent at the end, if it fails.
VENT_ATTEMPTS = 5


class Link(Enum):
    """Whether a device answers."""

    WAITING = "waiting for the device"
    UP = "connected"
    LOST = "link lost"


class RegulatorAdapter:
    """Passes commands on to a device, and its measurements back.

    Args:
        values: how the regulator states pressures, and how long it may be silent.
        device: the regulator.

    Attributes:
        watch: which command is passed on.
        link: whether the device answers.
        problem: problem of the link or the device; empty: none.
        link_errors, invalid_readings: counters.
    """

    def __init__(self, values: RegulatorParameters, device: PressureDevice) -> None:
        self._device, self._timeout = device, values.watchdog_timeout
        self.watch = CommandWatch(values.pressure_limit, self._timeout)
        self._command_scale = PressureScale(values, "command")
        self._measured_scale = PressureScale(values, "measured")
        self._answered: float | None = None
        self.link = Link.WAITING
        self.problem = ""
        self.link_errors = 0
        self.invalid_readings = 0

    def step(self, now: float) -> float | None:
        """Send what is demanded at a time [s].

        Returns:
            The measured gauge pressure [Pa], always finite and possible, or None if it is not
            known.
        """
        try:
            reading = self._device.exchange(self._command_scale.to_device(self.watch.demand(now)))
        except LinkError as error:
            self.link_errors += 1
            is_lost = self._answered is not None and now - self._answered >= self._timeout
            if is_lost:
                self.link = Link.LOST
            if is_lost or self._answered is None:
                self.problem = str(error)
                self.watch.is_latched = True
            return None
        self._answered, self.link, self.problem = now, Link.UP, reading.problem
        if reading.has_vented:
            self.watch.is_latched = True
        if reading.number is None:
            return None
        pressure = self._measured_scale.to_gauge(reading.number)
        refusal = impossible_pressure(pressure)
        if refusal:
            self.invalid_readings += 1
            self.problem = reading.problem or refusal.text
            return None
        return pressure

    def vent(self, pause: Callable[[], None]) -> bool:
        """Send 0 Pa as the last command and close the link; return whether it was answered.

        Args:
            pause: waits a while before the next attempt.
        """
        try:
            for attempt in range(VENT_ATTEMPTS):
                if attempt:
                    pause()
                try:
                    self._device.exchange(self._command_scale.to_device(0.0))
                except LinkError as error:
                    self.problem = str(error)
                else:
                    return True
            return False
        finally:
            self._device.close()
