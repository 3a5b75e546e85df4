# SPDX-License-Identifier: Apache-2.0
"""Every kind of device and what can be wrong with it, below the adapter's node in this process."""

import math
import struct
import time
from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from ros.control_bench import rows
from ros.enclaves import rights_by_enclave, used_rights
from ros.harness import DEADLINE, deliver
from ros.regulator_devices import LineDevice, ModbusServer
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray

from spiral_gripper_ros.regulators import regulator_node
from spiral_gripper_ros.regulators.main import RegulatorProgram
from spiral_gripper_ros.regulators.regulator_node import REGULATOR_NODE, RegulatorNode

AIR = 101325.0
OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
# A busy machine is no silent device, where silence is not what is tested.
PATIENT = {"watchdog_timeout": 60.0, "device_timeout": 10.0}
WRONG = {"nan": math.nan, "high": 2.0e7}


def named(text):
    pairs = (pair.split("=") for pair in text.split())
    return {name: int(value) if value.isdigit() else value for name, value in pairs}


class Serial:
    """A device at a port, from which it may be unplugged."""

    def __init__(self, folder, namespace):
        self.port = folder / "port"
        self.parameters = {"device": "serial", "port": str(self.port)}
        self.plug()

    def plug(self):
        self.device = LineDevice()
        self.port.unlink(missing_ok=True)
        self.port.symlink_to(self.device.port)

    def spoil(self, fault):
        if self.device.mode == "gone":
            self.plug()
        self.device.mode = fault
        if fault == "gone":
            self.device.close()

    def tell(self, bench, pressure):
        """It answers by itself."""

    def set_point(self, bench):
        return self.device.set_points[-1]

    def close(self):
        self.device.close()


class Modbus:
    """A server whose set-point is absolute, in hPa, and whose measurement has 32 bits."""

    def __init__(self, folder, namespace):
        self.server, self.fault = ModbusServer(), ""
        self.parameters = named(
            "device=modbus host=127.0.0.1 command_register=3 command_unit=hPa "
            "command_reference=absolute measured_register=10 measured_format=float32 "
            f"word_order=little heartbeat_register=20 tcp_port={self.server.port}"
        )

    def spoil(self, fault):
        if self.fault == "gone":
            self.server = ModbusServer(self.server.port)
        self.server.mode, self.fault = fault, fault
        self.server.delay = 0.06 if fault == "slow" else 0.0  # each is in time, three are not
        if fault == "gone":
            self.server.close()

    def tell(self, bench, pressure):
        packed = struct.pack(">f", WRONG.get(self.fault, pressure))
        self.server.registers[11], self.server.registers[10] = struct.unpack(">HH", packed)

    def set_point(self, bench):
        return 100.0 * self.server.registers[3] - AIR

    def close(self):
        self.server.close()


class Driver:
    """A node with topics, whose regulator is the second of three valves, absolute, in kPa."""

    def __init__(self, folder, namespace):
        self.parameters = named(
            "command_topic=valve/set command_type=std_msgs/msg/Float64MultiArray "
            "command_field=data[1] command_length=3 command_unit=kPa command_reference=absolute "
            "measured_topic=valve/state measured_type=sensor_msgs/msg/JointState "
            "measured_field=effort[1]"
        )
        self.node, self.fault = Node("driver", namespace=namespace), ""
        self.listen()

    def listen(self):
        self.heard = self.node.create_subscription(Float64MultiArray, "valve/set", [].append, 10)

    def spoil(self, fault):
        if self.fault == "gone":
            self.listen()
        self.fault = fault
        if fault == "gone":
            self.node.destroy_subscription(self.heard)

    def tell(self, bench, pressure):
        efforts = [0.0, WRONG.get(self.fault, pressure)]
        message = JointState(effort=efforts[: 1 if self.fault == "short" else 2])
        age = Duration(seconds=100.0 if self.fault == "stale" else 0.0)
        message.header.stamp = (self.node.get_clock().now() - age).to_msg()
        deliver(bench.node, "state", message)

    def set_point(self, bench):
        other, number, another = bench.told["set"][-1].data
        assert other == another == 1e-3 * AIR
        return 1e3 * number - AIR

    def close(self):
        self.node.destroy_node()


class Bench:
    """The adapter's node in this process; the test has its clock, its timers and its topics."""

    def __init__(self, monkeypatch, namespace, rig, parameters):
        self.now, self.rig = 100.0, rig
        clock = SimpleNamespace(monotonic=lambda: self.now)
        monkeypatch.setattr(regulator_node, "time", clock)
        given = {**PATIENT, **rig.parameters, **parameters}
        overrides = [Parameter(name, value=value) for name, value in given.items()]
        self.node = RegulatorNode(namespace=namespace, parameter_overrides=overrides)
        self.told = {}
        for publisher in self.node.publishers:
            name = publisher.topic.rpartition("/")[2]
            self.told[name] = []
            publisher.publish = self.told[name].append

    @property
    def measured(self):
        return [message.data for message in self.told["measured_pressure"]]

    @property
    def state(self):
        (status,) = self.told["diagnostics"][-1].status
        return status.level, status.message

    def tick(self, *commands):
        for command in commands:
            deliver(self.node, "pressure_command", Float64(data=command))
        for timer in self.node.timers:
            timer.callback()

    def until(self, level, words, pressure):
        """Command and measure a pressure until the state is this one; time goes on."""
        end = time.monotonic() + DEADLINE
        while True:
            self.rig.tell(self, pressure)
            self.tick(pressure)
            if self.state[0] == level and words in self.state[1]:
                return
            assert time.monotonic() < end, self.state
            self.now += 0.1

    def stop(self, *, requested=True):
        """Spin until the end, which may have been asked for; return the exit code."""
        node, self.node = self.node, None
        signals = SimpleNamespace(defer=list, requested=requested)
        return RegulatorProgram().spin(node, signals)


@pytest.fixture
def made(monkeypatch, namespace, tmp_path):
    """Makes a bench with a rig, both of which it ends."""
    benches = []

    def make(kind, **parameters):
        benches.append(Bench(monkeypatch, namespace, kind(tmp_path, namespace), parameters))
        return benches[-1]

    yield make
    for bench in benches:
        if bench.node is not None:
            bench.stop()
        bench.rig.close()


FAULTS = """
Serial mute: no answer within
Serial garbage: no answer within
Serial old: link lost
Serial gone: port
Serial refused: refuses the
Serial high: got 2e+07 Pa
Modbus refuses: register 3: exception 4
Modbus gone: link lost: 127.0.0.1:
Modbus slow: link lost
Modbus high: got 2e+07 Pa
Modbus nan: got nan
Driver gone: nobody subscribes
Driver short: measured_field:
Driver stale: more than watchdog_timeout
Driver nan: got nan
"""
KINDS = {kind.__name__: kind for kind in (Serial, Modbus, Driver)}


@pytest.mark.parametrize("row", rows(FAULTS))
def test_a_fault_is_told_nothing_is_measured_and_it_ends_vented(made, row):
    kind, fault, words = row.replace(": ", " ", 1).split(" ", 2)
    kind = KINDS[kind]
    bench = made(kind, watchdog_timeout=0.5, device_timeout=0.1)
    near = {"abs": 60.0}  # what registers of whole hPa hold
    bench.until(OK, "passes commands on", 4.0e4)
    assert bench.rig.set_point(bench) == pytest.approx(4.0e4, **near)
    bench.rig.spoil(fault)
    bench.told["measured_pressure"].clear()
    bench.until(ERROR, words, 4.0e4)
    assert (bench.measured == []) is (fault != "refused")
    bench.rig.spoil("")
    bench.told["measured_pressure"].clear()
    bench.until(OK, "passes commands on", 3.0e4)
    assert bench.measured[0] == pytest.approx(3.0e4, **near)  # no late answer
    assert bench.stop() == 0
    assert bench.rig.set_point(bench) == pytest.approx(0.0, **near)


def test_a_device_that_is_gone_at_the_end_makes_the_exit_code_1(made):
    bench = made(Serial, watchdog_timeout=0.5, device_timeout=0.1)
    bench.until(OK, "passes commands on", 4.0e4)
    bench.rig.spoil("mute")
    bench.until(ERROR, "", 4.0e4)
    assert bench.stop() == 1


def test_an_exception_makes_a_vent_the_last_set_point(made):
    bench = made(Serial)
    bench.until(OK, "passes commands on", 4.0e4)
    bench.node.adapter.step = lambda now: 1 / 0
    with pytest.raises(ZeroDivisionError):
        bench.stop(requested=False)
    assert bench.rig.set_point(bench) == 0.0


# Time, command, level, set-point, what is said.
COMMANDS = """
0 - OK 0 waiting for the first pressure_command
0 4e4 OK 4e4 passes commands on
59 - OK 4e4 passes commands on
1 - WARN 0 no pressure_command: vented
1 4e4 WARN 0 vented by the watchdog
1 0 OK 0 passes commands on
1 4e4 OK 4e4 passes commands on
59 nan WARN 4e4 pressure_command must be
1 nan WARN 0 pressure_command must be
"""


def test_commands_that_stop_or_cannot_be_vent(made):
    bench = made(Serial)
    assert bench.rig.device.set_points == []
    for row in rows(COMMANDS):
        elapsed, command, level, set_point, *words = row.split()
        bench.now += float(elapsed)
        bench.tick(*[] if command == "-" else [float(command)])
        found = (bench.state[0], bench.rig.set_point(bench))
        assert found == ({"OK": OK, "WARN": WARN}[level], float(set_point)), row
        assert " ".join(words) in bench.state[1]
    # An adapter that is killed is survived by the device's own watchdog.
    assert {message.watchdog_ms for message in bench.rig.device.heard} == {60000}


def test_a_driver_that_is_slower_than_the_exchanges_stays_wrong_until_it_is_right(made):
    bench = made(Driver)
    bench.until(OK, "passes commands on", 0.0)
    for fault, level in (("stale", ERROR), ("", OK)):
        bench.rig.spoil(fault)
        bench.rig.tell(bench, 4.0e4)
        for _ in range(3):
            bench.tick()
            assert bench.state[0] == level


def test_a_measurement_that_is_stale_or_has_lost_its_driver_is_dropped(made):
    bench = made(Driver)
    bench.rig.spoil("gone")
    bench.until(ERROR, "nobody subscribes", 0.0)
    bench.rig.spoil("")
    bench.rig.tell = lambda *_: None  # the next driver has measured nothing yet
    bench.until(OK, "passes commands on", 0.0)
    assert bench.measured == []


def test_nothing_latched_is_taken_for_new_and_best_effort_is_heard(made):
    bench = made(Driver)
    qos = {s.topic_name.rpartition("/")[2]: s.qos_profile for s in bench.node.subscriptions}
    assert qos["pressure_command"].durability is DurabilityPolicy.VOLATILE
    assert qos["state"].reliability is ReliabilityPolicy.BEST_EFFORT


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"device": "modbus"}, "command_format must be"),
        ({"rate": 1.0, "watchdog_timeout": 0.5, "device_timeout": 0.1}, "rate must be at least"),
        ({"measured_topic": "x", "measured_field": "nothing"}, "measured_field must be"),
        ({"command_topic": "pressure_command"}, "command_topic must be"),
    ],
)
def test_a_bad_parameter_is_refused_with_its_name(namespace, parameters, words):
    given = [Parameter(name, value=value) for name, value in parameters.items()]
    with pytest.raises(ValueError, match=words):
        RegulatorNode(namespace=namespace, parameter_overrides=given)


def test_the_adapter_may_do_what_it_does_and_nothing_else(client, namespace):
    granted = rights_by_enclave(namespace)["regulator"]
    own = {("publish", f"{namespace}/regulator/set_point")}
    node = RegulatorNode(namespace=namespace)
    client.wait_until(lambda: used_rights(client, REGULATOR_NODE) >= own, "the driver's topic")
    used = used_rights(client, REGULATOR_NODE)
    node.destroy_node()
    assert used <= granted


def test_the_whole_exchange_has_one_time_limit(made):
    bench = made(Modbus, watchdog_timeout=0.5, device_timeout=0.1)
    bench.until(OK, "passes commands on", 4.0e4)
    bench.tick(4.0e4)
    written = bench.rig.server.written
    assert (3, [1413]) in written  # 1413.25 hPa
    # The set-point goes before the heartbeat, which counts.
    assert [register for register, _ in written][:2] == [3, 20]
    beats = [values[0] for register, values in written if register == 20]
    assert beats == list(range(1, len(beats) + 1))
    bench.rig.spoil("slow")
    bench.tick()
    assert bench.node.adapter.link_errors == 1
