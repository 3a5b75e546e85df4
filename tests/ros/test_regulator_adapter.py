# SPDX-License-Identifier: Apache-2.0
"""The adapter's decisions and its devices' languages, without a device."""

import math
import re
from unittest.mock import Mock, call

import pytest
from geometry_msgs.msg import PoseArray
from hypothesis import given
from hypothesis import strategies as st
from repo.source_tree import ROOT
from ros.control_bench import rows
from ros.regulator_devices import SetPoint, measurement_line, set_point_from_line

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.regulators.adapter import VENT_ATTEMPTS, RegulatorAdapter
from spiral_gripper_ros.regulators.device import LinkError, Reading
from spiral_gripper_ros.regulators.line_protocol import (
    LINE_LENGTH_MAX,
    STATES,
    LineBuffer,
    check_sum,
    measurement_from_line,
    set_point_line,
)
from spiral_gripper_ros.regulators.message_field import MessageField, message_type
from spiral_gripper_ros.regulators.modbus_device import (
    number_from_registers,
    registers_from_number,
)
from spiral_gripper_ros.regulators.parameters import FORMATS, UNITS, RegulatorParameters
from spiral_gripper_ros.regulators.pressure_scale import PressureScale

AIR = 101325.0
ABSOLUTE = {"unit": "hPa", "reference": "absolute"}


def scale_of(**given):
    named = {f"measured_{part}": value for part, value in given.items()}
    return PressureScale(RegulatorParameters(**named), "measured")


@pytest.mark.parametrize("fails", [0, VENT_ATTEMPTS - 1, VENT_ATTEMPTS])
def test_the_last_thing_that_is_sent_is_a_vent_tried_again_and_its_failure_told(fails):
    device, pause = Mock(), Mock()
    device.exchange.side_effect = [*[LinkError("unplugged")] * fails, Reading()]
    values = RegulatorParameters(command_unit="hPa", command_reference="absolute")
    adapter = RegulatorAdapter(values, device)
    assert adapter.vent(pause) is (fails < VENT_ATTEMPTS)
    assert device.mock_calls[-2:] == [call.exchange(1013.25), call.close()]
    assert pause.call_count == min(fails, VENT_ATTEMPTS - 1)


# --- scales and messages -----------------------------------------------------------------------

BAR = {"Pa": 1e5, "hPa": 1e3, "mbar": 1e3, "kPa": 100, "bar": 1, "MPa": 0.1, "psi": 14.503773773}


@pytest.mark.parametrize(
    ("scale", "pressure", "number"),
    [(scale_of(unit=unit), 1.0e5, BAR[unit]) for unit in UNITS]
    + [
        (scale_of(**ABSOLUTE), 0.0, 1013.25),  # air, not vacuum
        (scale_of(unit="kPa", scale=-200.0, offset=4.0), 2.0e3, -396.0),
    ],
)
def test_a_pressure_is_the_number_of_its_unit_reference_and_scale(scale, pressure, number):
    assert scale.to_device(pressure) == pytest.approx(number)
    assert scale.to_gauge(number) == pytest.approx(pressure, abs=1e-6)


def test_a_number_is_written_where_it_is_read_and_other_valves_are_vented():
    field = MessageField("command_field", PoseArray, "poses[1].position.z")
    message = field.message(1.5, others=AIR)
    assert field.number(message) == 1.5
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


# --- the line protocol and registers -----------------------------------------------------------


@given(
    st.sampled_from([0, 1, 65535]),
    st.integers(-(10**12), 10**12).map(lambda thousandths: thousandths / 1000.0),
    st.sampled_from([*STATES]),
    st.integers(0, 100),
)
def test_a_line_says_what_was_written_and_a_flipped_bit_is_noticed(sequence, number, state, bit):
    message, answer = (sequence, number, 500), (sequence, number, state)
    assert set_point_from_line(set_point_line(*message).rstrip()) == SetPoint(*message)
    assert len(set_point_line(*message)) <= LINE_LENGTH_MAX
    line = bytearray(measurement_line(*answer).rstrip())
    assert measurement_from_line(bytes(line)) == answer
    line[bit // 8] ^= 1 << bit % 8
    # Hexadecimal digits in small letters are none of the protocol's.
    assert measurement_from_line(bytes(line)) is None


@pytest.mark.parametrize("body", ["M 7 nan ok", "M 7 1e5 ok", "M 65536 1.0 ok", "M 7 1.0 fine"])
def test_what_is_no_measurement_is_none_even_with_a_right_check_sum(body):
    assert measurement_from_line(f"{body}*{check_sum(body)}".encode()) is None


def test_a_line_that_never_ends_takes_no_memory():
    buffer = LineBuffer()
    assert not any(buffer.lines(b"x" * 50) for _ in range(999))
    (kept,) = buffer.lines(b"\n")
    assert len(kept) <= LINE_LENGTH_MAX
    assert buffer.lines(b"abc\n") == [b"abc"]


def test_the_page_shows_good_lines():
    page = (ROOT / "docs/regulators.md").read_text(encoding="utf-8")
    sent, answered = re.findall(r"^([SM] .*\*[0-9A-F]{4}) ", page, re.MULTILINE)
    assert set_point_from_line(sent.encode())
    assert measurement_from_line(answered.encode())
    assert f"gives {check_sum('123456789')}" in page
    assert f"at most {LINE_LENGTH_MAX} characters" in page


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("order", [{"low_word_first": first} for first in (False, True)])
def test_registers_hold_what_was_written_and_never_wrap_it_around(kind, order):
    low, high = FORMATS[kind][1]
    for number in (0.0, 258.0, 32767.0):
        words = registers_from_number(number, kind, **order)
        assert len(words) == (2 if "32" in kind else 1)
        assert number_from_registers(words, kind, **order) == number
    for bad in (math.nan, 1.001 * low - 1.0, 1.001 * high + 1.0):
        with pytest.raises(InvalidInputError, match="set-point"):
            registers_from_number(bad, kind, **order)
