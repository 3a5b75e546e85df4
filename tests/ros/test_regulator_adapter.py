# SPDX-License-Identifier: Apache-2.0
"""The adapter's decisions and its devices' languages, without a device."""

import math
import re
from dataclasses import replace

import pytest
from geometry_msgs.msg import PoseArray
from hypothesis import given
from hypothesis import strategies as st
from repo.source_tree import ROOT
from ros.control_bench import rows
from ros.regulator_devices import SetPoint, measurement_line, set_point_from_line
from std_msgs.msg import Float32

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.regulators import line_protocol
from spiral_gripper_ros.regulators.adapter import VENT_ATTEMPTS, Link, RegulatorAdapter
from spiral_gripper_ros.regulators.command_watch import CommandWatch
from spiral_gripper_ros.regulators.device import LinkError, Reading
from spiral_gripper_ros.regulators.line_protocol import (
    LINE_LENGTH_MAX,
    LineBuffer,
    Measurement,
    check_sum,
    measurement_from_line,
    set_point_line,
)
from spiral_gripper_ros.regulators.message_field import MessageField, message_type
from spiral_gripper_ros.regulators.modbus_device import (
    number_from_registers,
    registers_from_number,
)
from spiral_gripper_ros.regulators.parameters import (
    FORMATS,
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

AIR = 101325.0
DEFAULTS = RegulatorParameters()
PAGE = (ROOT / "docs/regulators.md").read_text(encoding="utf-8")


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


@pytest.fixture
def device():
    return Device()


@pytest.fixture
def adapter(device):
    watch, absolute = (
        CommandWatch(1.0e5, timeout=0.5),
        PressureScale("hPa", Reference.ABSOLUTE, AIR),
    )
    return RegulatorAdapter(watch, device, absolute, absolute, link_timeout=0.5)


def commanded(adapter, device, *events):
    """Offer commands and step, at times; return which were taken, and the gauge pressures sent."""
    taken = []
    for now, *commands in events:
        taken += [adapter.watch.offer(now, command) for command in commands]
        adapter.step(now)
    return taken, [round(100.0 * number - AIR, 9) for number in device.sent]


@pytest.mark.parametrize("pressure", [math.nan, math.inf, -1e-300, 1.0e5 + 1e-6])
def test_a_command_that_cannot_be_is_not_passed_on_and_feeds_no_watchdog(adapter, device, pressure):
    events = [(0.0, 4.0e4), (0.3, pressure), (0.49,), (0.5,)]  # half a second after the good one
    assert commanded(adapter, device, *events) == ([True, False], [4.0e4, 4.0e4, 4.0e4, 0.0])
    assert "0 to 100000 Pa" in adapter.watch.problem
    assert adapter.watch.refused == 1


def test_commands_at_the_ends_are_passed_on_and_before_the_first_it_is_vented(adapter, device):
    assert commanded(adapter, device, (0.0,), (0.1, 1.0e5)) == ([True], [0.0, 1.0e5])


def test_a_stream_that_comes_back_is_followed_again_once_it_has_commanded_nothing(adapter, device):
    taken, sent = commanded(adapter, device, (0.0, 3.0e4), (1.0, 3.0e4), (1.1, 3.0e4))
    assert (taken, sent) == ([True, False, False], [3.0e4, 0.0, 0.0])
    assert "vented by the watchdog" in adapter.watch.problem
    assert commanded(adapter, device, (1.2, 0.0), (1.3, 300.0))[1][3:] == [0.0, 300.0]
    assert adapter.watch.problem == ""


@pytest.mark.parametrize("number", [math.nan, -1.0e4, 2.0e5])
def test_a_reading_that_cannot_be_is_not_told(adapter, device, number):
    device.answer = Reading(number)
    assert adapter.step(0.0) is None
    assert adapter.invalid_readings == 1
    assert "measured_pressure must be" in adapter.problem
    device.answer = Reading(1.5e3, "the device reports a fault")
    assert adapter.step(0.1) == pytest.approx(1.5e5 - AIR)
    assert adapter.problem == "the device reports a fault"


def test_a_link_is_lost_once_no_answer_has_come_for_the_timeout_and_found_again(adapter, device):
    error, seen = LinkError("unplugged"), []
    for now, device.answer in ((0, error), (9, None), (9.49, error), (9.5, error), (9.6, None)):
        assert (adapter.step(now) is None) is (device.answer is error)
        seen.append((adapter.link, adapter.problem))
    told = [(Link.WAITING, "unplugged"), (Link.UP, ""), (Link.UP, ""), (Link.LOST, "unplugged")]
    assert seen == [*told, (Link.UP, "")]
    assert adapter.link_errors == 3


@pytest.mark.parametrize("failures", [0, VENT_ATTEMPTS - 1, VENT_ATTEMPTS])
def test_the_last_thing_that_is_sent_is_a_vent_tried_again_and_its_failure_told(
    adapter, device, failures
):
    commanded(adapter, device, (0.0, 5.0e4))
    device.answer, pauses = LinkError("busy") if failures else None, []

    def pause():
        pauses.append(1)
        device.answer = device.answer if len(pauses) < failures else None

    assert adapter.vent(pause) is (failures < VENT_ATTEMPTS)
    assert device.sent == [1513.25, 1013.25][: 2 - failures // VENT_ATTEMPTS]
    assert len(pauses) == min(failures, VENT_ATTEMPTS - 1)
    assert device.closed


# --- scales ------------------------------------------------------------------------------------

BAR = {"Pa": 1e5, "hPa": 1e3, "mbar": 1e3, "kPa": 100, "bar": 1, "MPa": 0.1, "psi": 14.503773773}


@pytest.mark.parametrize(
    ("scale", "pressure", "number"),
    [(PressureScale(unit), 1.0e5, BAR[unit]) for unit in UNITS]
    + [
        (PressureScale("kPa", Reference.ABSOLUTE, AIR), 0.0, 101.325),  # air, not vacuum
        (PressureScale("kPa", Reference.GAUGE, AIR, -200.0, 4.0), 2.0e3, -396.0),
    ],
)
def test_a_pressure_is_the_number_of_its_unit_reference_and_scale(scale, pressure, number):
    assert scale.to_device(pressure) == pytest.approx(number)
    assert scale.to_gauge(number) == pytest.approx(pressure, abs=1e-6)


def with_(**values):
    return replace(DEFAULTS, **values)


@pytest.mark.parametrize(
    ("refused", "name"),
    [
        (lambda: PressureScale("torr"), "unit"),
        (lambda: PressureScale(scale=math.nan), "scale"),
        (lambda: PressureScale(offset=math.inf), "offset"),
        (lambda: pressure_scale(with_(measured_scale=0.0), "measured"), "measured_scale"),
        # A format that holds no vent, or not the limit: 3e5 Pa in 16 bits, or in a line.
        (lambda: require_representable("it", PressureScale(), 1.0e5, (1.0, 1e9)), "it"),
        (lambda: require_representable("it", PressureScale(), 1.0e5, (0.0, 99999.0)), "it"),
        (lambda: SerialDevice(with_(command_scale=1.0e9)), "command_scale"),
        # Times with which the watchdog would vent between two exchanges.
        (lambda: require_timely(with_(rate=3.9)), "watchdog_timeout"),
        (lambda: require_timely(with_(watchdog_timeout=0.09)), "watchdog_timeout"),
        (lambda: require_timely(with_(device_timeout=0.26)), "watchdog_timeout"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_name(refused, name):
    with pytest.raises(InvalidInputError, match=name):
        refused()


# --- messages ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "path"), [(Float32, "data"), (PoseArray, "poses[1].position.z")])
def test_a_number_is_written_where_it_is_read_and_other_valves_are_vented(kind, path):
    field = MessageField("command_field", kind, path)
    message = field.message(1.5, others=AIR)
    assert field.number(message) == 1.5
    if kind is PoseArray:
        assert [pose.position.z for pose in message.poses] == [AIR, 1.5]


WRONG = """
std_msgs/Float64 value
std_msgs/Float64 data[0]
std_msgs/Float64 __class__
std_msgs/String data
sensor_msgs/FluidPressure header.stamp.sec
std_msgs/Float64MultiArray data
std_msgs/Float64MultiArray data[-1]
geometry_msgs/PoseArray poses[0].position
Float64 data
std_msgs/msg/Float65 data
no_msgs/msg/X data
os/path data
"""


@pytest.mark.parametrize("row", rows(WRONG))
def test_what_is_no_type_or_no_floating_point_number_is_refused(row):
    name, path = row.split()
    with pytest.raises(InvalidInputError, match=r"command_(type|field)"):
        MessageField("command_field", message_type("command_type", name), path)


# --- the line protocol -------------------------------------------------------------------------


@given(
    st.sampled_from([0, 1, 65535]),
    st.integers(-(10**12), 10**12).map(lambda thousandths: thousandths / 1000.0),
    st.sampled_from(line_protocol.STATES),
)
def test_a_line_says_what_was_written(sequence, number, state):
    message, answer = SetPoint(sequence, number, 500), Measurement(sequence, number, state)
    assert set_point_from_line(set_point_line(*message).rstrip()) == message
    assert measurement_from_line(measurement_line(answer).rstrip()) == answer
    assert len(set_point_line(*message)) <= LINE_LENGTH_MAX


def test_every_single_flipped_bit_is_noticed():
    line = measurement_line(Measurement(7, 50000.0, "ok")).rstrip()
    for bit in range(8 * len(line)):
        broken = bytearray(line)
        broken[bit // 8] ^= 1 << bit % 8
        # Hexadecimal digits in small letters are none of the protocol's.
        assert measurement_from_line(bytes(broken)) is None


@pytest.mark.parametrize("body", ["M 7 nan ok", "M 7 1e5 ok", "M 65536 1.0 ok", "M 7 1.0 fine"])
@pytest.mark.parametrize("has_check", [True, False])
def test_what_is_no_measurement_is_none_even_with_a_right_check_sum(body, has_check):
    line = f"{body}*{check_sum(body)}" if has_check else body
    assert measurement_from_line(line.encode()) is None
    assert measurement_from_line(b"\xff\xfe*1234") is None


def test_a_line_that_never_ends_takes_no_memory():
    buffer = LineBuffer()
    assert not any(buffer.lines(b"x" * 50) for _ in range(999))
    (kept,) = buffer.lines(b"\n")
    assert len(kept) <= LINE_LENGTH_MAX
    assert buffer.lines(b"abc\n") == [b"abc"]


def test_the_page_shows_good_lines():
    sent, answered = re.findall(r"^([SM] .*\*[0-9A-F]{4}) ", PAGE, re.MULTILINE)
    assert set_point_from_line(sent.encode()) is not None
    assert measurement_from_line(answered.encode()) is not None
    assert f"gives {check_sum('123456789')}" in PAGE
    assert f"at most {LINE_LENGTH_MAX} characters" in PAGE


# --- registers ---------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("low_word_first", [False, True])
def test_registers_hold_what_was_written_and_never_wrap_it_around(kind, low_word_first):
    for number in (0.0, 258.0, 32767.0):
        words = registers_from_number(number, kind, low_word_first=low_word_first)
        assert len(words) == (2 if "32" in kind else 1)
        assert number_from_registers(words, kind, low_word_first=low_word_first) == number
    low, high = FORMATS[kind][1]
    for bad in (math.nan, math.inf, 1.001 * low - 1.0, 1.001 * high + 1.0):
        with pytest.raises(InvalidInputError, match="set-point"):
            registers_from_number(bad, kind, low_word_first=low_word_first)
