# SPDX-License-Identifier: Apache-2.0
"""The adapter's decisions, with devices that are lists: what is sent, what is told, how it ends."""

import math
from dataclasses import asdict, replace

import pytest
from geometry_msgs.msg import PoseArray
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float32, Float32MultiArray, Float64, Float64MultiArray, String

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.regulators.adapter import (
    VENT_ATTEMPTS,
    Link,
    RegulatorAdapter,
)
from spiral_gripper_ros.regulators.command_watch import CommandWatch
from spiral_gripper_ros.regulators.device import LinkError, Reading
from spiral_gripper_ros.regulators.message_field import MessageField, message_type
from spiral_gripper_ros.regulators.modbus_device import ModbusDevice
from spiral_gripper_ros.regulators.parameters import (
    RegulatorParameters,
    pressure_scale,
    require_timely,
)
from spiral_gripper_ros.regulators.pressure_scale import (
    UNITS,
    PressureScale,
    Reference,
    require_representable,
)
from spiral_gripper_ros.regulators.serial_device import SerialDevice

NAN, INF = math.nan, math.inf
AIR = 101325.0
DEFAULTS = RegulatorParameters()


class Device:
    """Remembers what it is sent, and answers it; an exception in its place is raised."""

    def __init__(self):
        self.sent, self.answer, self.closed = [], None, False

    def exchange(self, number):
        if isinstance(self.answer, Exception):
            raise self.answer
        self.sent.append(number)
        return Reading(number) if self.answer is None else self.answer

    def close(self):
        self.closed = True


def adapter(device, command=None, measured=None):
    return RegulatorAdapter(
        CommandWatch(pressure_limit=1.0e5, timeout=0.5),
        device,
        command or PressureScale(),
        measured or PressureScale(),
        link_timeout=0.5,
    )


# --- commands ----------------------------------------------------------------------------------


@pytest.mark.parametrize("pressure", [NAN, INF, -INF, -1.0, -1e-300, 1.0e5 + 1e-6, 1e300])
def test_a_command_that_cannot_be_is_not_passed_on_and_feeds_no_watchdog(pressure):
    device = Device()
    subject = adapter(device)
    assert subject.watch.offer(0.0, 4.0e4)
    assert not subject.watch.offer(0.3, pressure)
    assert "0 to 100000 Pa" in subject.watch.problem
    subject.step(0.4)
    subject.step(0.5)  # half a second after the good one, not after the bad one
    assert device.sent == [4.0e4, 0.0]
    assert subject.watch.refused == 1


@pytest.mark.parametrize("pressure", [0.0, 1.0e5, 5e-324])
def test_commands_at_the_ends_are_passed_on(pressure):
    device = Device()
    subject = adapter(device)
    assert subject.watch.offer(0.0, pressure)
    subject.step(0.0)
    assert device.sent == [pressure]


def test_before_the_first_command_and_after_the_last_one_the_device_is_vented():
    device = Device()
    subject = adapter(device)
    subject.step(0.0)
    subject.watch.offer(1.0, 3.0e4)
    for now in (1.0, 1.49, 1.5, 9.0):
        subject.step(now)
    assert device.sent == [0.0, 3.0e4, 3.0e4, 0.0, 0.0]
    assert subject.watch.is_silent(1.5)


def test_a_stream_that_comes_back_is_followed_again_once_it_has_commanded_nothing():
    device = Device()
    subject = adapter(device)
    subject.watch.offer(0.0, 3.0e4)
    subject.step(1.0)
    for now, command in ((1.1, 3.0e4), (1.2, 3.0e4), (1.3, 0.0), (1.4, 300.0)):
        assert subject.watch.offer(now, command) is (command < 3.0e4)
        assert ("vented by the watchdog" in subject.watch.problem) is (command == 3.0e4)
        subject.step(now)
    assert device.sent == [0.0, 0.0, 0.0, 0.0, 300.0]


# --- measurements ------------------------------------------------------------------------------


@pytest.mark.parametrize("number", [NAN, INF, -INF, -1.1e5, 1.1e7])
def test_a_reading_that_cannot_be_is_not_told(number):
    device = Device()
    subject = adapter(device)
    device.answer = Reading(number)
    assert subject.step(0.0) is None
    assert subject.invalid_readings == 1
    assert subject.problem
    device.answer = Reading(5.0e4)
    assert subject.step(0.1) == 5.0e4
    assert subject.problem == ""


def test_what_a_device_says_is_wrong_with_it_is_told():
    device = Device()
    subject = adapter(device)
    device.answer = Reading(1.0, "the device reports a fault")
    assert subject.step(0.0) == 1.0
    assert subject.problem == "the device reports a fault"


# --- the link ----------------------------------------------------------------------------------


def test_a_link_is_lost_once_no_answer_has_come_for_the_timeout_and_found_again():
    device = Device()
    subject = adapter(device)
    assert subject.link is Link.WAITING
    subject.step(0.0)
    assert subject.link is Link.UP
    device.answer = LinkError("unplugged")
    assert subject.step(0.49) is None
    assert subject.link is Link.UP
    subject.step(0.5)
    assert (subject.link, subject.problem, subject.link_errors) == (Link.LOST, "unplugged", 2)
    device.answer = None
    assert subject.step(0.6) == 0.0
    assert (subject.link, subject.problem) == (Link.UP, "")


def test_a_device_that_never_answered_says_why():
    device = Device()
    subject = adapter(device)
    device.answer = LinkError("no such port")
    subject.step(100.0)
    assert (subject.link, subject.problem) == (Link.WAITING, "no such port")


# --- the end -----------------------------------------------------------------------------------


def test_the_last_thing_that_is_sent_is_a_vent():
    device = Device()
    subject = adapter(device, PressureScale("mbar", Reference.ABSOLUTE, AIR))
    subject.watch.offer(0.0, 5.0e4)
    subject.step(0.0)
    assert subject.vent(lambda: None)
    assert device.sent == [1513.25, 1013.25]
    assert device.closed


def test_a_vent_is_tried_again_and_its_failure_told():
    device, pauses = Device(), []
    subject = adapter(device)
    device.answer = LinkError("busy")

    def pause():
        pauses.append(1)
        if len(pauses) == 2:
            device.answer = None

    assert subject.vent(pause)
    assert (device.sent, len(pauses)) == ([0.0], 2)
    device.answer, device.closed = LinkError("gone"), False
    assert not subject.vent(lambda: pauses.append(1))
    assert (len(pauses), subject.problem, device.closed) == (1 + VENT_ATTEMPTS, "gone", True)


def test_the_link_is_closed_even_if_the_vent_raises_what_nobody_expected():
    device = Device()
    device.answer = RuntimeError("a defect")
    with pytest.raises(RuntimeError, match="a defect"):
        adapter(device).vent(lambda: None)
    assert device.closed


# --- scales ------------------------------------------------------------------------------------


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("reference", list(Reference))
@pytest.mark.parametrize(("factor", "offset"), [(1.0, 0.0), (-2.0, 5.0), (1000.0, 4.0)])
@pytest.mark.parametrize("pressure", [0.0, 1.0, 57000.0])
def test_a_pressure_comes_back_as_it_went(unit, reference, factor, offset, pressure):
    scale = PressureScale(unit, reference, AIR, factor, offset)
    assert scale.to_gauge(scale.to_device(pressure)) == pytest.approx(pressure, abs=1e-6)


def test_units_are_what_they_are_called():
    at_one_bar = {unit: PressureScale(unit).to_device(1.0e5) for unit in UNITS}
    assert at_one_bar == pytest.approx(
        {"Pa": 1e5, "hPa": 1e3, "mbar": 1e3, "kPa": 100, "bar": 1, "MPa": 0.1, "psi": 14.503774}
    )


def test_vented_in_absolute_terms_is_the_air_and_not_vacuum():
    assert PressureScale("Pa", Reference.ABSOLUTE, AIR).to_device(0.0) == AIR
    assert PressureScale("kPa", Reference.ABSOLUTE, AIR).to_gauge(101.325) == pytest.approx(0.0)


@pytest.mark.parametrize("bad", [{"unit": "torr"}, {"scale": 0.0}, {"scale": NAN}, {"offset": INF}])
def test_an_impossible_scale_is_refused(bad):
    (name,) = bad
    with pytest.raises(InvalidInputError, match=name):
        PressureScale(**bad)


@pytest.mark.parametrize("span", [(1.0, 1e9), (0.0, 99999.0)])
def test_a_format_that_holds_no_vent_or_not_the_limit_is_refused(span):
    require_representable("command_format", PressureScale(), 1.0e5, (0.0, 1.0e5))
    with pytest.raises(InvalidInputError, match="command_format"):
        require_representable("command_format", PressureScale(), 1.0e5, span)


# --- parameters --------------------------------------------------------------------------------


def test_the_defaults_are_within_their_ranges():
    assert RegulatorParameters.refusal(asdict(DEFAULTS)) is None
    require_timely(DEFAULTS)


@pytest.mark.parametrize(
    ("name", "value"), [("rate", 3.9), ("watchdog_timeout", 0.09), ("device_timeout", 0.26)]
)
def test_times_that_would_let_the_watchdog_vent_between_exchanges_are_refused(name, value):
    with pytest.raises(InvalidInputError, match="watchdog_timeout"):
        require_timely(replace(DEFAULTS, **{name: value}))


def test_a_set_point_that_its_format_cannot_hold_is_refused_at_start():
    with pytest.raises(InvalidInputError, match="command_format"):
        ModbusDevice(DEFAULTS)  # 3e5 Pa in 16 bits
    ModbusDevice(replace(DEFAULTS, command_unit="hPa")).close()
    with pytest.raises(InvalidInputError, match="command_scale"):
        SerialDevice(replace(DEFAULTS, command_scale=1.0e9))
    with pytest.raises(InvalidInputError, match="measured_scale"):
        pressure_scale(replace(DEFAULTS, measured_scale=0.0), "measured")


# --- messages ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "path", "expected"),
    [
        (Float64, "data", lambda m: m.data),
        (Float32, "data", lambda m: m.data),
        (FluidPressure, "fluid_pressure", lambda m: m.fluid_pressure),
        (Float64MultiArray, "data[2]", lambda m: m.data[2]),
        (Float32MultiArray, "data[0]", lambda m: m.data[0]),
        (JointState, "effort[1]", lambda m: m.effort[1]),
        (PoseArray, "poses[1].position.z", lambda m: m.poses[1].position.z),
    ],
)
def test_a_number_is_written_where_it_is_read(kind, path, expected):
    field = MessageField("command_field", kind, path)
    message = field.message(1.5, others=7.0)
    assert expected(message) == field.number(message) == 1.5


def test_the_other_valves_of_an_array_are_vented():
    field = MessageField("command_field", Float64MultiArray, "data[1]", length=4)
    assert list(field.message(1.5, others=AIR).data) == [AIR, 1.5, AIR, AIR]
    field = MessageField("command_field", PoseArray, "poses[1].position.x")
    assert [pose.position.x for pose in field.message(1.5, others=AIR).poses] == [AIR, 1.5]


@pytest.mark.parametrize(
    ("kind", "path"),
    [
        (Float64, "value"),
        (Float64, "data[0]"),
        (Float64, ""),
        (Float64, "data.x"),
        (Float64, "__class__"),
        (String, "data"),
        (FluidPressure, "header"),
        (FluidPressure, "header.stamp.sec"),
        (Float64MultiArray, "data"),
        (Float64MultiArray, "data[-1]"),
        (Float64MultiArray, "layout.data_offset"),
        (PoseArray, "poses[0].position"),
    ],
)
def test_what_is_no_floating_point_number_is_refused(kind, path):
    with pytest.raises(InvalidInputError, match="command_field"):
        MessageField("command_field", kind, path)


def test_an_array_that_is_too_short_has_no_number():
    field = MessageField("measured_field", Float64MultiArray, "data[2]")
    with pytest.raises(IndexError):
        field.number(Float64MultiArray(data=[1.0]))


@pytest.mark.parametrize(
    "name", ["", "Float64", "std_msgs/msg/Float65", "no_msgs/msg/X", "os/path"]
)
def test_a_type_that_is_not_there_is_refused(name):
    with pytest.raises(InvalidInputError, match="command_type"):
        message_type("command_type", name)
    assert message_type("command_type", "std_msgs/Float64") is Float64
