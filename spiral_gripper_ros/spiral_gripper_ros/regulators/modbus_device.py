# SPDX-License-Identifier: Apache-2.0
"""A regulator with Modbus TCP: set-point, measured pressure and heartbeat in registers."""

from __future__ import annotations

import socket
import struct
import time

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.regulators.device import LinkError, Reading
from spiral_gripper_ros.regulators.parameters import (
    FORMATS,
    NO_REGISTER,
    RegulatorParameters,
)
from spiral_gripper_ros.regulators.pressure_scale import require_representable

HEARTBEAT_END = SEQUENCE_END = 65536
# Functions of the protocol (Modbus application protocol V1.1b3), and what marks an exception.
READ_HOLDING, READ_INPUT, WRITE_MULTIPLE, EXCEPTION = 3, 4, 16, 0x80
# Before each message: sequence number, 0, number of bytes that follow, and the first of them: the
# unit.
HEADER = struct.Struct(">HHHB")
LENGTH_MAX = 254


def registers_from_number(number: float, kind: str, *, low_word_first: bool) -> list[int]:
    """Return the registers of a number; integers are rounded.

    Raises:
        InvalidInputError: the format does not hold it: never wrapped, never clipped.

    Example:
        >>> registers_from_number(1.5, "float32", low_word_first=False)
        [16320, 0]
        >>> registers_from_number(70000.0, "uint16", low_word_first=False)
        Traceback (most recent call last):
        ...
        spiral_core.errors.InvalidInputError: set-point must be a number of uint16, got 70000.0
    """
    layout, (low, high) = FORMATS[kind]
    if not low <= number <= high:
        raise InvalidInputError("set-point", number, f"a number of {kind}")
    packed = layout.pack(number if kind == "float32" else round(number))
    words = list(struct.unpack(f">{len(packed) // 2}H", packed))
    return words[::-1] if low_word_first else words


def number_from_registers(words: list[int], kind: str, *, low_word_first: bool) -> float:
    """Return the number in registers, which may be NaN.

    Example:
        >>> number_from_registers([0, 16320], "float32", low_word_first=True)
        1.5
    """
    ordered = words[::-1] if low_word_first else words
    (number,) = FORMATS[kind][0].unpack(struct.pack(f">{len(ordered)}H", *ordered))
    return float(number)


class ModbusDevice:
    """A Modbus TCP server, connected when it is needed, and again after it has failed.

    An exchange takes up to four round trips (connect, set-point, heartbeat, measurement), which
    share one time-out. A name of a host is resolved until the first connection; its address stays.

    Args:
        values: address, time-out and registers; addresses of registers count from 0.

    Raises:
        InvalidInputError: the format does not hold every set-point.
    """

    def __init__(self, values: RegulatorParameters) -> None:
        require_representable("command_format", values, FORMATS[values.command_format][1])
        self._values, self._timeout = values, values.device_timeout
        self._address = (values.host, values.tcp_port)
        self._name = f"{values.host}:{values.tcp_port}"
        self._low_word_first = values.word_order == "little"
        self._socket: socket.socket | None = None
        self._deadline = 0.0
        self._beat = self._sequence = 0

    def exchange(self, number: float) -> Reading:
        """Write the set-point and the heartbeat, and read the measured pressure."""
        values = self._values
        words = registers_from_number(
            number, values.command_format, low_word_first=self._low_word_first
        )
        self._deadline = time.monotonic() + self._timeout
        try:
            self._write(values.command_register, words)
            if values.heartbeat_register != NO_REGISTER:
                self._beat = (self._beat + 1) % HEARTBEAT_END
                self._write(values.heartbeat_register, [self._beat])
            return self._reading()
        except OSError as error:
            self.close()
            raise LinkError(f"{self._name}: {error}") from error

    def close(self) -> None:
        """End the connection."""
        connection, self._socket = self._socket, None
        if connection is not None:
            connection.close()

    def _write(self, register: int, words: list[int]) -> None:
        self._answer(
            WRITE_MULTIPLE,
            register,
            struct.pack(f">HB{len(words)}H", len(words), 2 * len(words), *words),
        )

    def _reading(self) -> Reading:
        register, kind = self._values.measured_register, self._values.measured_format
        if register == NO_REGISTER:
            return Reading()
        count = FORMATS[kind][0].size // 2
        function = READ_INPUT if self._values.measured_table == "input" else READ_HOLDING
        length, *content = self._answer(function, register, struct.pack(">H", count))
        if not len(content) == length == 2 * count:
            raise OSError(f"register {register}: not {count} registers")
        words = list(struct.unpack(f">{count}H", bytes(content)))
        return Reading(number_from_registers(words, kind, low_word_first=self._low_word_first))

    def _answer(self, function: int, register: int, content: bytes) -> bytes:
        """Send a request; return what follows the function in its answer."""
        if self._socket is None:
            self._socket = socket.create_connection(self._address, self._remaining())
            self._address = self._socket.getpeername()[:2]
        connection, own = self._socket, self._values.unit_id
        self._sequence = (self._sequence + 1) % SEQUENCE_END
        request = struct.pack(">BH", function, register) + content
        header = HEADER.pack(self._sequence, 0, 1 + len(request), own)
        connection.settimeout(self._remaining())
        connection.sendall(header + request)
        sequence, zero, length, unit = HEADER.unpack(self._received(connection, HEADER.size))
        is_answer = (sequence, zero, unit) == (self._sequence, 0, own)
        if is_answer and 3 <= length <= LENGTH_MAX:
            answered, *rest = self._received(connection, length - 1)
            if answered == function:
                return bytes(rest)
            if answered == function | EXCEPTION:
                raise LinkError(f"{self._name}: register {register}: exception {rest[0]}")
        raise OSError(f"register {register}: not an answer to the request")

    def _received(self, connection: socket.socket, size: int) -> bytes:
        """Return so many bytes, before the exchange's time is over."""
        received = b""
        while len(received) < size:
            connection.settimeout(self._remaining())
            part = connection.recv(size - len(received))
            if not part:
                raise ConnectionError("the device has closed the connection")
            received += part
        return received

    def _remaining(self) -> float:
        """Return the time that the exchange has left [s]."""
        remaining = self._deadline - time.monotonic()
        if not remaining > 0.0:
            raise TimeoutError(f"no answer within {self._timeout:g} s")
        return remaining
