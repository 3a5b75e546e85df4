# SPDX-License-Identifier: Apache-2.0
"""The adapter's logic: set-points sent to a device, and reports of its state. No ROS."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

from spiral_gripper_ros.control.pressure_monitor import impossible_pressure
from spiral_gripper_ros.regulators.command_watch import CommandWatch
from spiral_gripper_ros.regulators.device import LinkError, PressureDevice
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
        watch: which command is passed on.
        device: the regulator.
        command_scale: how it states a set-point.
        measured_scale: how it states what it measures.
        link_timeout: time without an answer after which the link counts as lost [s].

    Attributes:
        link: whether the device answers.
        problem: problem of the link or the device; empty: none.
        link_errors, invalid_readings: counters.
    """

    def __init__(
        self,
        watch: CommandWatch,
        device: PressureDevice,
        command_scale: PressureScale,
        measured_scale: PressureScale,
        link_timeout: float,
    ) -> None:
        self.watch = watch
        self._device = device
        self._command_scale, self._measured_scale = command_scale, measured_scale
        self._link_timeout = link_timeout
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
            self._note_error(now, error)
            return None
        self._answered, self.link, self.problem = now, Link.UP, reading.problem
        if reading.number is None:
            return None
        pressure = self._measured_scale.to_gauge(reading.number)
        refusal = impossible_pressure(pressure)
        if refusal is not None:
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
                if self._sent_vent():
                    return True
            return False
        finally:
            self._device.close()

    def _sent_vent(self) -> bool:
        try:
            self._device.exchange(self._command_scale.to_device(0.0))
        except LinkError as error:
            self.link_errors += 1
            self.problem = str(error)
            return False
        return True

    def _note_error(self, now: float, error: LinkError) -> None:
        self.link_errors += 1
        if self._answered is None:
            self.problem = str(error)
        elif not now - self._answered < self._link_timeout:
            self.link, self.problem = Link.LOST, str(error)
