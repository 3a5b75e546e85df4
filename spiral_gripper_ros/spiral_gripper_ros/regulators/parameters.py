# SPDX-License-Identifier: Apache-2.0
"""The adapter's parameters, and the objects that they describe."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.parameters.pressure_scale import UNITS, PressureScale, Reference
from spiral_gripper_ros.parameters.spec import ParameterSpec, ParameterValue, number_spec
from spiral_gripper_ros.parameters.table import number
from spiral_gripper_ros.regulators.adapter import require_representable
from spiral_gripper_ros.regulators.line_protocol import require_line_number
from spiral_gripper_ros.regulators.modbus_device import (
    FORMATS,
    NO_REGISTER,
    ModbusDevice,
    RegisterMap,
)
from spiral_gripper_ros.regulators.serial_device import SerialDevice

TOPIC, SERIAL, MODBUS = "topic", "serial", "modbus"
NONE = "none"


def _text(
    name: str, default: str, description: str, choices: tuple[str, ...] = ()
) -> ParameterSpec:
    return ParameterSpec(name, default, description, choices=choices, read_only=True)


def _number(name: str, default: float, low: float, high: float, text: str) -> ParameterSpec:
    return number_spec(name, default, low, high, text, read_only=True)


def _scale(side: str, what: str) -> tuple[ParameterSpec, ...]:
    references = tuple(reference.value for reference in Reference)
    return (
        _text(f"{side}_unit", "Pa", f"Unit of {what}.", tuple(UNITS)),
        _text(f"{side}_reference", "gauge", f"Reference of {what}: gauge or absolute.", references),
        _number(f"{side}_scale", 1.0, -1.0e9, 1.0e9, f"Device's number per unit of {what}; not 0."),
        _number(f"{side}_offset", 0.0, -1.0e9, 1.0e9, f"Device's number at zero of {what}."),
    )


def _register(name: str, default: int, text: str) -> ParameterSpec:
    return _number(name, default, NO_REGISTER, 65535, text)


REGULATOR_PARAMETERS: Final[tuple[ParameterSpec, ...]] = (
    _text("device", TOPIC, "How the regulator is connected.", (TOPIC, SERIAL, MODBUS)),
    _text("frame_id", "gripper_base", "Frame of measured_pressure."),
    _number(
        "pressure_limit",
        3.0e5,
        1.0,
        1.0e6,
        "Largest gauge pressure passed on [Pa]; a command above it is refused.",
    ),
    _number(
        "watchdog_timeout",
        0.5,
        0.02,
        60.0,
        "Silence of pressure_command after which the device is vented, and of the device after "
        "which its link counts as lost [s].",
    ),
    _number("rate", 20.0, 1.0, 200.0, "Exchanges with the device [Hz]; each is a heartbeat."),
    _number(
        "device_timeout",
        0.1,
        0.005,
        10.0,
        "Longest time for a device's answer, with Modbus for a whole exchange [s].",
    ),
    _number(
        "ambient_pressure",
        101325.0,
        5.0e4,
        1.2e5,
        "Absolute pressure of the air around [Pa]; for a reference that is absolute.",
    ),
    *_scale("command", "the set-point"),
    *_scale("measured", "the measured pressure"),
    _text("command_topic", "regulator/set_point", "topic: name of the driver's set-point."),
    _text("command_type", "std_msgs/msg/Float64", "topic: type of the driver's set-point."),
    _text("command_field", "data", "topic: path of its number, such as data[0]."),
    _number("command_length", 0, 0, 999, "topic: elements of its array; 0: up to the index."),
    _text("measured_topic", NONE, "topic: name of what the driver measures, or none."),
    _text("measured_type", "std_msgs/msg/Float64", "topic: type of what the driver measures."),
    _text("measured_field", "data", "topic: path of its number."),
    _text("port", "/dev/ttyACM0", "serial: the port."),
    _number("baud_rate", 115200, 300, 4000000, "serial: bits per second."),
    _text("host", "192.168.1.1", "modbus: name or address."),
    _number("tcp_port", 502, 1, 65535, "modbus: TCP port."),
    _number("unit_id", 1, 0, 255, "modbus: the device's unit identifier."),
    _number("command_register", 0, 0, 65535, "modbus: first register of the set-point, from 0."),
    _text("command_format", "uint16", "modbus: number format of the set-point.", tuple(FORMATS)),
    _register(
        "measured_register", NO_REGISTER, "modbus: first register of the pressure; -1: none."
    ),
    _text("measured_format", "uint16", "modbus: number format of the pressure.", tuple(FORMATS)),
    _text("measured_table", "holding", "modbus: registers of the pressure.", ("holding", "input")),
    _text("word_order", "big", "modbus: order of the words of 32 bits.", ("big", "little")),
    _register("heartbeat_register", NO_REGISTER, "modbus: counts up with each exchange; -1: none."),
)


def pressure_scale(values: Mapping[str, ParameterValue], side: str) -> PressureScale:
    """Return how the device states a pressure.

    Args:
        values: checked values.
        side: "command" or "measured".
    """
    scale = number(values, f"{side}_scale")
    if scale == 0.0:
        raise InvalidInputError(f"{side}_scale", scale, "a number that is not 0")
    return PressureScale(
        unit=str(values[f"{side}_unit"]),
        reference=Reference(values[f"{side}_reference"]),
        ambient_pressure=number(values, "ambient_pressure"),
        scale=scale,
        offset=number(values, f"{side}_offset"),
    )


def require_timely(values: Mapping[str, ParameterValue]) -> None:
    """Refuse times with which the device's watchdog would vent between two exchanges.

    Raises:
        InvalidInputError: ``rate`` or ``device_timeout`` does not fit ``watchdog_timeout``.
    """
    watchdog = number(values, "watchdog_timeout")
    rate, timeout = number(values, "rate"), number(values, "device_timeout")
    if rate * watchdog < 2.0:
        requirement = f"at least {2.0 / watchdog:g} Hz, two exchanges per watchdog_timeout"
        raise InvalidInputError("rate", rate, requirement)
    if timeout > 0.5 * watchdog:
        requirement = f"at most {0.5 * watchdog:g} s, half of watchdog_timeout"
        raise InvalidInputError("device_timeout", timeout, requirement)


def serial_device(values: Mapping[str, ParameterValue]) -> SerialDevice:
    """Return the device on a serial line that checked values describe."""
    scale, limit = pressure_scale(values, "command"), number(values, "pressure_limit")
    for pressure in (0.0, limit):
        require_line_number("command_scale", scale.to_device(pressure))
    return SerialDevice(
        port=str(values["port"]),
        baud_rate=int(number(values, "baud_rate")),
        timeout=number(values, "device_timeout"),
        watchdog=number(values, "watchdog_timeout"),
    )


def modbus_device(values: Mapping[str, ParameterValue]) -> ModbusDevice:
    """Return the Modbus device that checked values describe."""
    kind = str(values["command_format"])
    limit, (_, span) = number(values, "pressure_limit"), FORMATS[kind]
    require_representable("command_format", pressure_scale(values, "command"), limit, span)
    return ModbusDevice(
        host=str(values["host"]),
        port=int(number(values, "tcp_port")),
        unit=int(number(values, "unit_id")),
        timeout=number(values, "device_timeout"),
        registers=RegisterMap(
            command=int(number(values, "command_register")),
            command_format=kind,
            measured=int(number(values, "measured_register")),
            measured_format=str(values["measured_format"]),
            measured_is_input=values["measured_table"] == "input",
            heartbeat=int(number(values, "heartbeat_register")),
            low_word_first=values["word_order"] == "little",
        ),
    )
