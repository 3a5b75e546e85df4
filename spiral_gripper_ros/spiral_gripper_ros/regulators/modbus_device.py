# SPDX-License-Identifier: Apache-2.0
"""A regulator with Modbus TCP: set-point, measured pressure and heartbeat in registers."""

from __future__ import annotations

import socket
import struct
import time
from dataclasses import dataclass

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.regulators.device import LinkError, Reading

# Formats of a number in registers: the struct code, and the range.
FORMATS: dict[str, tuple[str, tuple[float, float]]] = {
    "int16": ("h", (-(2.0**15), 2.0**15 - 1.0)),
    "uint16": ("H", (0.0, 2.0**16 - 1.0)),
    "int32": ("i", (-(2.0**31), 2.0**31 - 1.0)),
    "uint32": ("I", (0.0, 2.0**32 - 1.0)),
    "float32": ("f", (-3.4e38, 3.4e38)),
}
NO_REGISTER = -1
HEARTBEAT_END = SEQUENCE_END = 65536
# Functions of the protocol (Modbus application protocol V1.1b3), and what marks an exception.
READ_HOLDING, READ_INPUT, WRITE_MULTIPLE, EXCEPTION = 3, 4, 16, 0x80
# Before each message: sequence number, 0, number of bytes that follow, and the first of them: the
# unit.
HEADER = struct.Struct(">HHHB")
LENGTH_MAX = 254


@dataclass(frozen=True, slots=True)
class RegisterMap:
    """The register addresses of a device, counted from 0; -1 is none.

    Args:
        command: first register of the set-point.
        command_format, measured_format: a key of ``FORMATS``.
        measured: first register of the measured pressure.
        measured_is_input: whether that is an input register (function 4) or a holding one (3).
        heartbeat: holding register that counts up with each exchange.
        low_word_first: order of the words of 32-bit numbers.
    """

    command: int
    command_format: str
    measured: int = NO_REGISTER
    measured_format: str = "float32"
    measured_is_input: bool = False
    heartbeat: int = NO_REGISTER
    low_word_first: bool = False


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
    code, (low, high) = FORMATS[kind]
    if not low <= number <= high:
        raise InvalidInputError("set-point", number, f"a number of {kind}")
    packed = struct.pack(f">{code}", number if code == "f" else round(number))
    words = list(struct.unpack(f">{len(packed) // 2}H", packed))
    return words[::-1] if low_word_first else words


def number_from_registers(words: list[int], kind: str, *, low_word_first: bool) -> float:
    """Return the number in registers, which may be NaN.

    Example:
        >>> number_from_registers([0, 16320], "float32", low_word_first=True)
        1.5
    """
    ordered = words[::-1] if low_word_first else words
    packed = struct.pack(f">{len(ordered)}H", *ordered)
    (number,) = struct.unpack(f">{FORMATS[kind][0]}", packed)
    return float(number)


def register_count(kind: str) -> int:
    """Return how many registers a number takes."""
    return struct.calcsize(f">{FORMATS[kind][0]}") // 2


class ModbusDevice:
    """A Modbus TCP server, connected when it is needed, and again after it has failed.

    An exchange takes up to four round trips (connect, set-point, heartbeat, measurement), which
    share one time-out. A name of a host is resolved until the first connection; its address stays.

    Args:
        host: name or address.
        port: TCP port.
        unit: the device's unit identifier.
        timeout: longest time for an exchange [s].
        registers: where things stand.
    """

    def __init__(
        self, host: str, port: int, unit: int, timeout: float, registers: RegisterMap
    ) -> None:
        self._name, self._address = f"{host}:{port}", (host, port)
        self._unit, self._timeout, self._map = unit, timeout, registers
        self._socket: socket.socket | None = None
        self._deadline = 0.0
        self._beat = self._sequence = 0

    def exchange(self, number: float) -> Reading:
        """Write the set-point and the heartbeat, and read the measured pressure."""
        layout = self._map
        words = registers_from_number(
            number, layout.command_format, low_word_first=layout.low_word_first
        )
        self._deadline = time.monotonic() + self._timeout
        try:
            self._write(layout.command, words)
            if layout.heartbeat != NO_REGISTER:
                self._beat = (self._beat + 1) % HEARTBEAT_END
                self._write(layout.heartbeat, [self._beat])
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
        layout = self._map
        if layout.measured == NO_REGISTER:
            return Reading()
        count = register_count(layout.measured_format)
        function = READ_INPUT if layout.measured_is_input else READ_HOLDING
        answer = self._answer(function, layout.measured, struct.pack(">H", count))
        if len(answer) != 1 + 2 * count or answer[0] != 2 * count:
            raise OSError(f"register {layout.measured}: not {count} registers")
        words = list(struct.unpack(f">{count}H", answer[1:]))
        return Reading(
            number_from_registers(
                words, layout.measured_format, low_word_first=layout.low_word_first
            )
        )

    def _answer(self, function: int, register: int, content: bytes) -> bytes:
        """Send a request; return what follows the function in its answer."""
        connection = self._connected()
        self._sequence = (self._sequence + 1) % SEQUENCE_END
        request = struct.pack(">BH", function, register) + content
        header = HEADER.pack(self._sequence, 0, 1 + len(request), self._unit)
        connection.settimeout(self._remaining())
        connection.sendall(header + request)
        sequence, zero, length, unit = HEADER.unpack(self._received(connection, HEADER.size))
        if (sequence, zero, unit) != (
            self._sequence,
            0,
            self._unit,
        ) or not 3 <= length <= LENGTH_MAX:
            raise OSError(f"register {register}: not an answer to the request")
        answered, *rest = self._received(connection, length - 1)
        if answered == function | EXCEPTION:
            raise LinkError(f"{self._name}: register {register}: exception {rest[0]}")
        if answered != function:
            raise OSError(f"register {register}: not an answer to the request")
        return bytes(rest)

    def _connected(self) -> socket.socket:
        if self._socket is None:
            self._socket = socket.create_connection(self._address, self._remaining())
            self._address = self._socket.getpeername()[:2]
        return self._socket

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
