# SPDX-License-Identifier: Apache-2.0
"""A regulator with Modbus TCP: set-point, measured pressure and heartbeat in registers."""

from __future__ import annotations

import inspect
import logging
import struct
from dataclasses import dataclass
from typing import Any

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
HEARTBEAT_END = 65536


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

    Args:
        host: name or address.
        port: TCP port.
        unit: the device's unit identifier.
        timeout: longest time for an answer [s].
        registers: where things stand.

    Raises:
        InvalidInputError: pymodbus is not installed.
    """

    def __init__(
        self, host: str, port: int, unit: int, timeout: float, registers: RegisterMap
    ) -> None:
        try:
            from pymodbus.client import ModbusTcpClient
            from pymodbus.exceptions import ModbusException
        except ModuleNotFoundError:
            requirement = (
                "another one: modbus needs pymodbus (pip install 'spiral-gripper[regulators]')"
            )
            raise InvalidInputError("device", "modbus", requirement) from None
        # Its failures are raised here; without a handler Python writes each of them to stderr too.
        logging.getLogger("pymodbus").addHandler(logging.NullHandler())
        self._errors = (ModbusException, OSError)
        self._address = f"{host}:{port}"
        self._map = registers
        self._client = ModbusTcpClient(host, port=port, timeout=timeout, retries=0)
        # What names the unit was called "slave" before pymodbus 3.10.
        accepted = inspect.signature(self._client.write_registers).parameters
        self._unit = {"device_id" if "device_id" in accepted else "slave": unit}
        self._beat = 0

    def exchange(self, number: float) -> Reading:
        """Write the set-point and the heartbeat, and read the measured pressure."""
        layout = self._map
        words = registers_from_number(
            number, layout.command_format, low_word_first=layout.low_word_first
        )
        try:
            if not self._client.connected and not self._client.connect():
                raise LinkError(f"{self._address}: no connection")
            self._write(layout.command, words)
            if layout.heartbeat != NO_REGISTER:
                self._beat = (self._beat + 1) % HEARTBEAT_END
                self._write(layout.heartbeat, [self._beat])
            return self._reading()
        except self._errors as error:
            self.close()
            raise LinkError(f"{self._address}: {error}") from error

    def close(self) -> None:
        """End the connection."""
        self._client.close()

    def _write(self, register: int, words: list[int]) -> None:
        self._require(self._client.write_registers(register, words, **self._unit), register)

    def _reading(self) -> Reading:
        layout = self._map
        if layout.measured == NO_REGISTER:
            return Reading()
        client, count = self._client, register_count(layout.measured_format)
        read = (
            client.read_input_registers
            if layout.measured_is_input
            else (client.read_holding_registers)
        )
        answer = self._require(read(layout.measured, count=count, **self._unit), layout.measured)
        words = list(answer.registers)
        if len(words) != count:
            raise LinkError(f"{self._address}: {len(words)} registers instead of {count}")
        return Reading(
            number_from_registers(
                words, layout.measured_format, low_word_first=layout.low_word_first
            )
        )

    def _require(self, answer: Any, register: int) -> Any:  # noqa: ANN401
        """Return an answer that is no exception of the device's."""
        if answer.isError():
            raise LinkError(f"{self._address}: register {register}: {answer}")
        return answer
