# SPDX-License-Identifier: Apache-2.0
"""A regulator on a serial line that speaks :mod:`spiral_gripper_ros.regulators.line_protocol`."""

from __future__ import annotations

import time
from typing import Any

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.regulators.device import LinkError, Reading
from spiral_gripper_ros.regulators.line_protocol import (
    LINE_LENGTH_MAX,
    NUMBERS,
    SEQUENCE_END,
    STATES,
    VENTED,
    LineBuffer,
    Measurement,
    measurement_from_line,
    set_point_line,
)
from spiral_gripper_ros.regulators.parameters import RegulatorParameters
from spiral_gripper_ros.regulators.pressure_scale import require_representable

# A port that could not be opened is tried again after this time [s].
RECONNECT_PERIOD = 0.5


class SerialDevice:
    """A serial port, opened when it is needed, and again after it has failed.

    Args:
        values: port, times and scale; the watchdog's time is sent with each set-point.

    Raises:
        InvalidInputError: pyserial is not installed, or a line does not hold every set-point.
    """

    def __init__(self, values: RegulatorParameters) -> None:
        require_representable("command_scale", values, NUMBERS)
        try:
            import serial
        except ModuleNotFoundError:
            requirement = "topic or modbus where pyserial is missing; serial needs it: "
            requirement += "pip install 'spiral-gripper[regulators]'"
            raise InvalidInputError("device", "serial", requirement) from None
        self._serial = serial
        self._address, self._baud_rate = values.port, values.baud_rate
        self._timeout = values.device_timeout
        self._watchdog_ms = max(1, round(1.0e3 * values.watchdog_timeout))
        self._port: Any = None
        self._tried, self._problem = -RECONNECT_PERIOD, ""
        self._sequence, self._buffer = 0, LineBuffer()

    def exchange(self, number: float) -> Reading:
        """Send a set-point and wait for its answer."""
        try:
            port = self._opened()
            self._sequence = (self._sequence + 1) % SEQUENCE_END
            port.write(set_point_line(self._sequence, number, self._watchdog_ms))
            answer = self._answer(port)
        except (OSError, ValueError) as error:  # SerialException is an OSError
            self.close()
            self._problem = f"{self._address}: {error}"
            raise LinkError(self._problem) from error
        if answer is None:
            raise LinkError(f"{self._address}: no answer within {self._timeout:g} s")
        has_vented = answer.state == VENTED
        return Reading(answer.number, STATES[answer.state], has_vented)

    def close(self) -> None:
        """Close the port."""
        port, self._port = self._port, None
        self._buffer.clear()
        if port is not None:
            port.close()

    def _opened(self) -> Any:  # noqa: ANN401
        if self._port is not None:
            return self._port
        now = time.monotonic()
        if now - self._tried < RECONNECT_PERIOD:
            raise LinkError(self._problem)
        self._tried = now
        self._port = self._serial.Serial(
            self._address,
            self._baud_rate,
            timeout=0.0,
            write_timeout=self._timeout,
            exclusive=True,  # two adapters on one valve must not be
        )
        return self._port

    def _answer(self, port: Any) -> Measurement | None:  # noqa: ANN401
        """Return the answer to the last set-point; older ones and garbage are dropped."""
        deadline = time.monotonic() + self._timeout
        while (remaining := deadline - time.monotonic()) > 0.0:
            port.timeout = remaining
            received = port.read(min(max(port.in_waiting, 1), LINE_LENGTH_MAX))
            for line in self._buffer.lines(received):
                answer = measurement_from_line(line)
                if answer is not None and answer.sequence == self._sequence:
                    return answer
        return None
