# SPDX-License-Identifier: Apache-2.0
"""The backends against simulated devices: a pseudo-terminal and pymodbus's own server."""

import math
import struct
import time

import pytest
from ros.regulator_devices import LineDevice, ModbusServer

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.regulators.device import LinkError, Reading
from spiral_gripper_ros.regulators.line_protocol import (
    LINE_LENGTH_MAX,
    LineBuffer,
    Measurement,
    SetPoint,
    measurement_from_line,
    measurement_line,
    set_point_from_line,
    set_point_line,
)
from spiral_gripper_ros.regulators.modbus_device import (
    ModbusDevice,
    number_from_registers,
    register_count,
    registers_from_number,
)
from spiral_gripper_ros.regulators.parameters import FORMATS, RegulatorParameters
from spiral_gripper_ros.regulators.serial_device import RECONNECT_PERIOD, SerialDevice

WATCHDOG = 0.3
TIMEOUT = 0.1
TIMES = {"device_timeout": TIMEOUT, "watchdog_timeout": WATCHDOG}
# Long against what a busy machine makes of one exchange; failures are quick all the same.
PATIENCE = 240.0


def on_port(port):
    return SerialDevice(RegulatorParameters(port=port, **TIMES))


@pytest.fixture
def line():
    device = LineDevice()
    yield device
    device.close()


@pytest.fixture
def serial(line):
    device = on_port(line.port)
    yield device
    device.close()


@pytest.fixture
def server():
    server = ModbusServer()
    yield server
    server.close()


def modbus(server, **layout):
    address = {"host": "127.0.0.1", "tcp_port": server.port, "command_register": 3}
    return ModbusDevice(RegulatorParameters(**address, **TIMES, pressure_limit=1.0e3, **layout))


def until_answered(device, number):
    """Exchange until the device answers; a busy machine may miss a time-out."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return device.exchange(number)
        except LinkError:  # noqa: PERF203
            assert time.monotonic() < end
            time.sleep(0.05)


# --- the line protocol -------------------------------------------------------------------------


@pytest.mark.parametrize("number", [0.0, 0.001, -12.5, 57000.125, 1.0e9])
@pytest.mark.parametrize("sequence", [0, 1, 65535])
def test_a_line_says_what_was_written(sequence, number):
    message = SetPoint(sequence, number, 500)
    assert set_point_from_line(set_point_line(message).rstrip()) == message
    answer = Measurement(sequence, number, "ok")
    assert measurement_from_line(measurement_line(answer).rstrip()) == answer
    assert len(set_point_line(message)) <= LINE_LENGTH_MAX


def test_every_single_flipped_bit_is_noticed():
    line = measurement_line(Measurement(7, 50000.0, "ok")).rstrip()
    for place in range(len(line)):
        for bit in range(8):
            broken = bytearray(line)
            broken[place] ^= 1 << bit
            heard = measurement_from_line(bytes(broken))
            # Hexadecimal digits in small letters are none of the protocol's.
            assert heard is None


@pytest.mark.parametrize(
    "body", ["M 7 nan ok", "M 7 inf ok", "M 7 1e5 ok", "M 65536 1.0 ok", "M 7 1.0 fine", "S 7 1 2"]
)
def test_what_is_no_measurement_is_none_even_with_a_right_check_sum(body):
    from spiral_gripper_ros.regulators.line_protocol import check_sum

    assert measurement_from_line(f"{body}*{check_sum(body)}".encode()) is None


@pytest.mark.parametrize(
    "garbage", [b"", b"*", b"M", b"\xff\xfe*1234", b"M 7 1.0 ok", b"M 7 1.0 ok*"]
)
def test_garbage_is_no_line(garbage):
    assert measurement_from_line(garbage) is None
    assert set_point_from_line(garbage) is None


def test_a_line_that_never_ends_takes_no_memory():
    buffer = LineBuffer()
    for _ in range(1000):
        assert buffer.lines(b"x" * 50) == []
    assert len(buffer._rest) <= LINE_LENGTH_MAX + 50
    buffer.lines(b"\n")
    assert buffer.lines(b"abc\n") == [b"abc"]


# --- the serial line ---------------------------------------------------------------------------


def test_a_set_point_arrives_and_is_answered(line, serial):
    assert until_answered(serial, 4.0e4) == Reading(4.0e4)
    assert line.set_points[-1] == 4.0e4
    assert line.pressure == 4.0e4


def test_a_device_vents_when_lines_stop(line, serial):
    until_answered(serial, 4.0e4)
    time.sleep(WATCHDOG + 0.1)
    assert line.pressure == 0.0


def test_a_set_point_that_the_device_does_not_take_is_told(line, serial):
    line.limit = 5.0e4
    assert until_answered(serial, 6.0e4).problem == "the device refuses the set-point"
    assert line.set_points == []


@pytest.mark.parametrize("mode", ["garbage", "nan", "bad_check", "old", "mute"])
def test_no_good_answer_is_a_link_error_in_time_and_the_next_good_one_is_heard(line, serial, mode):
    until_answered(serial, 1.0e4)
    line.mode = mode
    with pytest.raises(LinkError, match="no answer within 0"):
        serial.exchange(2.0e4)
    line.mode = "good"
    assert until_answered(serial, 3.0e4) == Reading(3.0e4)


def test_a_device_that_is_unplugged_is_a_link_error_and_found_again_at_its_port(tmp_path):
    port, first = tmp_path / "port", LineDevice()
    port.symlink_to(first.port)
    device = on_port(str(port))
    until_answered(device, 1.0e4)
    first.close()
    with pytest.raises(LinkError, match="port"):
        device.exchange(2.0e4)
    port.unlink()
    with pytest.raises(LinkError):
        device.exchange(2.0e4)
    second = LineDevice()
    port.symlink_to(second.port)
    time.sleep(RECONNECT_PERIOD)
    try:
        assert until_answered(device, 3.0e4) == Reading(3.0e4)
        assert second.set_points[-1] == 3.0e4
    finally:
        device.close()
        second.close()


def test_a_port_that_is_none_says_so_each_time():
    device = on_port("/dev/no_such_port")
    for _ in range(3):
        with pytest.raises(LinkError, match="no_such_port"):
            device.exchange(0.0)


def test_two_adapters_do_not_share_a_port(line, serial):
    until_answered(serial, 1.0e4)
    second = on_port(line.port)
    with pytest.raises(LinkError, match="exclusively lock"):
        second.exchange(2.0e4)


# --- Modbus ------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("low_word_first", [False, True])
@pytest.mark.parametrize("number", [0.0, 1.0, 258.0, 32767.0])
def test_registers_hold_what_was_written(kind, low_word_first, number):
    words = registers_from_number(number, kind, low_word_first=low_word_first)
    assert len(words) == register_count(kind)
    assert number_from_registers(words, kind, low_word_first=low_word_first) == number


def test_words_stand_in_the_order_that_is_given():
    assert registers_from_number(65538.0, "uint32", low_word_first=False) == [1, 2]
    assert registers_from_number(65538.0, "uint32", low_word_first=True) == [2, 1]


@pytest.mark.parametrize(
    ("kind", "number"),
    [("uint16", -1.0), ("uint16", 65536.0), ("int16", 32768.0), ("uint32", 2.0**32)]
    + [(kind, bad) for kind in FORMATS for bad in (math.nan, math.inf, -math.inf)],
)
def test_a_number_that_its_format_cannot_hold_is_never_wrapped_around(kind, number):
    with pytest.raises(InvalidInputError, match="set-point"):
        registers_from_number(number, kind, low_word_first=False)


def test_a_set_point_is_written_the_heartbeat_counts_and_the_pressure_is_read(server):
    device = modbus(server, measured_register=10, measured_format="float32", heartbeat_register=20)
    server.registers[10], server.registers[11] = struct.unpack(">HH", struct.pack(">f", 1.25))
    assert until_answered(device, 400.4) == Reading(1.25)
    assert server.written[-2:] == [(3, [400]), (20, [1])]
    until_answered(device, 400.6)
    assert server.written[-2:] == [(3, [401]), (20, [2])]
    device.close()


def test_input_registers_are_read_where_they_are(server):
    device = modbus(server, measured_register=10, measured_format="int16", measured_table="input")
    server.registers[10] = 65535
    assert until_answered(device, 1.0) == Reading(-1.0)
    device.close()


def test_a_nan_in_the_registers_is_passed_on_to_who_refuses_it(server):
    device = modbus(server, measured_register=10, measured_format="float32")
    server.registers.update({10: 0x7FC0, 11: 0})
    assert math.isnan(until_answered(device, 1.0).number)
    device.close()


def test_an_exception_of_the_device_is_a_link_error(server):
    device = modbus(server)
    until_answered(device, 1.0)
    server.refuses = True
    with pytest.raises(LinkError, match="register 3"):
        device.exchange(2.0)
    server.refuses = False
    until_answered(device, 3.0)
    assert server.written[-1] == (3, [3])
    device.close()


def test_a_device_that_hangs_is_a_link_error_in_time_and_late_answers_are_dropped(server):
    device = modbus(server, measured_register=10, measured_format="uint16")
    server.registers[10] = 1
    assert until_answered(device, 1.0) == Reading(1.0)
    server.delay = 3.0 * TIMEOUT
    with pytest.raises(LinkError):
        device.exchange(2.0)
    server.delay, server.registers[10] = 0.0, 2
    assert until_answered(device, 3.0) == Reading(2.0)
    device.close()


def test_the_whole_exchange_has_one_time_limit(server):
    device = modbus(server, measured_register=10, measured_format="uint16", heartbeat_register=20)
    until_answered(device, 1.0)
    server.delay = 0.6 * TIMEOUT  # each answer is in time, three are not
    with pytest.raises(LinkError, match=r"no answer within|timed out"):
        device.exchange(2.0)
    device.close()


def test_a_server_that_is_gone_is_a_link_error_and_found_again(server):
    device = modbus(server)
    until_answered(device, 1.0)
    server.close()
    for _ in range(2):
        with pytest.raises(LinkError, match=f"127.0.0.1:{server.port}"):
            device.exchange(2.0)
    again = ModbusServer(server.port)
    try:
        until_answered(device, 3.0)
        assert again.written[-1] == (3, [3])
    finally:
        device.close()
        again.close()
