# SPDX-License-Identifier: Apache-2.0
"""The adapter's parameters."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from struct import Struct
from typing import Any, Final

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.control.timing import WATCHDOG_TIMEOUT
from spiral_gripper_ros.parameters.spec import Parameters, parameter

TOPIC, SERIAL, MODBUS = "topic", "serial", "modbus"
NONE = "none"
NO_REGISTER = -1
# Pascals in each unit that regulators use.
UNITS = {
    "Pa": 1.0,
    "hPa": 1.0e2,
    "mbar": 1.0e2,
    "kPa": 1.0e3,
    "bar": 1.0e5,
    "MPa": 1.0e6,
    "psi": 6894.757293168361,
}
# What a pressure is counted from: the air around, or vacuum, as sensor_msgs/FluidPressure has it.
GAUGE, ABSOLUTE = REFERENCES = ("gauge", "absolute")
# Formats of a number in registers: its bytes, and the range.
FORMATS: dict[str, tuple[Struct, tuple[float, float]]] = {
    "int16": (Struct(">h"), (-(2.0**15), 2.0**15 - 1.0)),
    "uint16": (Struct(">H"), (0.0, 2.0**16 - 1.0)),
    "int32": (Struct(">i"), (-(2.0**31), 2.0**31 - 1.0)),
    "uint32": (Struct(">I"), (0.0, 2.0**32 - 1.0)),
    "float32": (Struct(">f"), (-3.4e38, 3.4e38)),
}


_fixed = partial(parameter, read_only=True)


def _unit(what: str) -> Any:  # noqa: ANN401
    return _fixed("Pa", f"Unit of {what}.", choices=tuple(UNITS))


def _reference(what: str) -> Any:  # noqa: ANN401
    return _fixed(GAUGE, f"Reference of {what}: gauge or absolute.", choices=REFERENCES)


def _scale(what: str) -> Any:  # noqa: ANN401
    return _fixed(1.0, f"Device's number per unit of {what}; not 0.", -1.0e9, 1.0e9)


def _offset(what: str) -> Any:  # noqa: ANN401
    return _fixed(0.0, f"Device's number at zero of {what}.", -1.0e9, 1.0e9)


@dataclass(frozen=True, slots=True)
class RegulatorParameters(Parameters):
    """Parameters of the adapter; all are fixed at start."""

    device: str = _fixed(TOPIC, "How the regulator is connected.", choices=(TOPIC, SERIAL, MODBUS))
    pressure_limit: float = _fixed(
        3.0e5, "Largest gauge pressure passed on [Pa]; a command above it is refused.", 1.0, 1.0e6
    )
    watchdog_timeout: float = _fixed(
        WATCHDOG_TIMEOUT,
        "Silence of pressure_command after which the device is vented, and of the device after"
        " which its link counts as lost; oldest stamp of a measurement [s].",
        0.3,
        60.0,
    )
    rate: float = _fixed(20.0, "Exchanges with the device [Hz]; each is a heartbeat.", 1.0, 200.0)
    device_timeout: float = _fixed(
        0.1,
        "Longest time for a device's answer, with Modbus for a whole exchange [s].",
        0.005,
        10.0,
    )
    ambient_pressure: float = _fixed(
        101325.0,
        "Absolute pressure of the air around [Pa]; for a reference that is absolute.",
        5.0e4,
        1.2e5,
    )
    command_unit: str = _unit("the set-point")
    command_reference: str = _reference("the set-point")
    command_scale: float = _scale("the set-point")
    command_offset: float = _offset("the set-point")
    measured_unit: str = _unit("the measured pressure")
    measured_reference: str = _reference("the measured pressure")
    measured_scale: float = _scale("the measured pressure")
    measured_offset: float = _offset("the measured pressure")
    command_topic: str = _fixed("regulator/set_point", "topic: name of the driver's set-point.")
    command_type: str = _fixed("std_msgs/msg/Float64", "topic: type of the driver's set-point.")
    command_field: str = _fixed("data", "topic: path of its number, such as data[0].")
    command_length: int = _fixed(0, "topic: elements of its array; 0: up to the index.", 0, 999)
    measured_topic: str = _fixed(NONE, "topic: name of what the driver measures, or none.")
    measured_type: str = _fixed("std_msgs/msg/Float64", "topic: type of what the driver measures.")
    measured_field: str = _fixed("data", "topic: path of its number.")
    port: str = _fixed("/dev/ttyACM0", "serial: the port.")
    baud_rate: int = _fixed(115200, "serial: bits per second.", 300, 4000000)
    host: str = _fixed("192.168.1.1", "modbus: name or address.")
    tcp_port: int = _fixed(502, "modbus: TCP port.", 1, 65535)
    unit_id: int = _fixed(1, "modbus: the device's unit identifier.", 0, 255)
    command_register: int = _fixed(0, "modbus: first register of the set-point, from 0.", 0, 65535)
    command_format: str = _fixed(
        "uint16", "modbus: number format of the set-point.", choices=tuple(FORMATS)
    )
    measured_register: int = _fixed(
        NO_REGISTER, "modbus: first register of the pressure; -1: none.", NO_REGISTER, 65535
    )
    measured_format: str = _fixed(
        "uint16", "modbus: number format of the pressure.", choices=tuple(FORMATS)
    )
    measured_table: str = _fixed(
        "holding", "modbus: registers of the pressure.", choices=("holding", "input")
    )
    word_order: str = _fixed(
        "big", "modbus: order of the words of 32 bits.", choices=("big", "little")
    )
    heartbeat_register: int = _fixed(
        NO_REGISTER, "modbus: counts up with each exchange; -1: none.", NO_REGISTER, 65535
    )


REGULATOR_PARAMETERS: Final = RegulatorParameters.specs()


# What names the source of a measured pressure, and its value where there is none.
MEASURED_BY: Final = {TOPIC: ("measured_topic", NONE), MODBUS: ("measured_register", NO_REGISTER)}


def require_measured(values: RegulatorParameters) -> None:
    """Refuse a measured pressure that is described, but comes from nowhere.

    Raises:
        InvalidInputError: neither topic nor register of it is named.
    """
    source, nowhere = MEASURED_BY.get(values.device, ("device", ""))
    if getattr(values, source) != nowhere:
        return
    unused = RegulatorParameters()
    for spec in REGULATOR_PARAMETERS:
        described = getattr(values, spec.name) != getattr(unused, spec.name)
        if described and spec.name.startswith("measured_"):
            raise InvalidInputError(
                source, nowhere, f"named: {spec.name} describes what is measured"
            )


def require_timely(values: RegulatorParameters) -> None:
    """Refuse times with which the device's watchdog would vent between two exchanges.

    Raises:
        InvalidInputError: ``rate`` or ``device_timeout`` does not fit ``watchdog_timeout``.
    """
    watchdog = values.watchdog_timeout
    rate, timeout = values.rate, values.device_timeout
    if rate * watchdog < 2.0:
        requirement = f"at least {2.0 / watchdog:g} Hz, two exchanges per watchdog_timeout"
        raise InvalidInputError("rate", rate, requirement)
    if timeout > 0.5 * watchdog:
        requirement = f"at most {0.5 * watchdog:g} s, half of watchdog_timeout"
        raise InvalidInputError("device_timeout", timeout, requirement)
