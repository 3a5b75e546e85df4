# SPDX-License-Identifier: Apache-2.0
"""Every kind of device and what can be wrong with it, below the adapter's node in this process."""

import math
import struct
from types import SimpleNamespace

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from ros.control_bench import rows
from ros.harness import deliver, wait_until
from ros.local_nodes import overhear, parameters
from ros.records import agrees
from ros.regulator_devices import LineDevice, ModbusServer
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray

from spiral_gripper_ros.process.guards import GuardedLoop
from spiral_gripper_ros.regulators import regulator_node
from spiral_gripper_ros.regulators.adapter import Link
from spiral_gripper_ros.regulators.main import RegulatorProgram
from spiral_gripper_ros.regulators.regulator_node import RegulatorNode

AIR = 101325.0
OK, ERROR = DiagnosticStatus.OK, DiagnosticStatus.ERROR
PASSES = "passes commands on"
WRONG = {"nan": math.nan, "high": 2.0e7}


def named(text):
    return {name: yaml.safe_load(v) for name, v in (pair.split("=") for pair in text.split())}


class Serial(LineDevice):
    """A device at a port, from which it may be unplugged."""

    def __init__(self, folder, _):
        self.link = folder / "port"
        self.parameters = {"device": "serial", "port": str(self.link)}
        self.plug()

    def plug(self):
        super().__init__()
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(self.port)

    def spoil(self, fault):
        if not self.running:
            self.plug()
        self.mode = fault
        if fault == "gone":
            self.close()

    def tell(self, *_):
        """It answers by itself."""

    def set_point(self, _):
        return self.heard[-1].number


class Modbus(ModbusServer):
    """A server whose set-point is absolute, in hPa, and whose measurement has 32 bits."""

    def __init__(self, *_):
        super().__init__()
        self.parameters = named(
            "device=modbus host=127.0.0.1 command_register=3 command_unit=hPa "
            "command_reference=absolute measured_register=10 measured_format=float32 "
            f"word_order=little heartbeat_register=20 tcp_port={self.port}"
        )

    def spoil(self, fault):
        if self.fault == "gone":
            super().__init__(self.port)
        self.fault = fault
        self.delay = 0.06 if fault == "slow" else 0.0  # each is in time, three are not
        if fault == "gone":
            self.close()

    def tell(self, _, pressure):
        packed = struct.pack(">f", WRONG.get(self.fault, pressure))
        self.registers[11], self.registers[10] = struct.unpack(">HH", packed)

    def set_point(self, _):
        return 100.0 * self.registers[3] - AIR


class Driver:
    """A node with topics, whose regulator is the second of three valves, absolute, in kPa."""

    def __init__(self, _, namespace):
        self.parameters = named(
            "command_topic=valve/set command_type=std_msgs/msg/Float64MultiArray "
            "command_field=data[1] command_length=3 command_unit=kPa command_reference=absolute "
            "measured_topic=valve/state measured_type=sensor_msgs/msg/JointState "
            "measured_field=effort[1]"
        )
        self.node = Node("driver", namespace=namespace)
        self.spoil("")

    def spoil(self, fault):
        self.fault = fault
        if fault == "gone":
            self.node.destroy_subscription(self.heard)
        else:
            self.heard = self.node.create_subscription(Float64MultiArray, "valve/set", print, 10)

    def tell(self, bench, pressure):
        efforts = [0.0, WRONG.get(self.fault, pressure)]
        message = JointState(effort=efforts[: 1 if self.fault == "short" else 2])
        age = Duration(seconds=100.0 if self.fault == "stale" else 0.0)
        message.header.stamp = (self.node.get_clock().now() - age).to_msg()
        deliver(bench.node, "state", message)

    def set_point(self, bench):
        other, number, another = bench.told["valve/set"][-1].data
        assert other == another == 1e-3 * AIR
        return 1e3 * number - AIR

    def close(self):
        self.node.destroy_node()


class Bench:
    """The adapter's node in this process; the test has its clock, its timers and its topics."""

    def __init__(self, monkeypatch, namespace, rig, **given):
        self.now, self.rig = 100.0, rig
        clock = SimpleNamespace(monotonic=lambda: self.now)
        monkeypatch.setattr(regulator_node, "time", clock)
        overrides = parameters(**rig.parameters, **given)
        self.node = RegulatorNode(namespace=namespace, parameter_overrides=overrides)
        self.told = overhear(self.node)
        self.measured = self.told["measured_pressure"]

    def tick(self, *commands):
        """Hear commands and tick; return level and text of the state then."""
        for command in commands:
            deliver(self.node, "pressure_command", Float64(data=command))
        for timer in self.node.timers:
            timer.callback()
        (status,) = self.told["/diagnostics"][-1].status
        return status.level, status.message

    def until(self, level, words, pressure=4.0e4):
        """Command and measure a pressure until the state is this one; time goes on."""

        def is_there():
            self.now += 0.1
            if self.node.adapter.link is not Link.UP:
                self.tick(0.0)
            self.rig.tell(self, pressure)
            state = self.tick(pressure)
            return state[0] == level and words in state[1]

        wait_until(is_there)

    def stop(self, *, requested=True):
        """Spin until the end, which may have been asked for; return the exit code."""
        node, self.node = self.node, None
        signals = SimpleNamespace(defer=list, requested=requested)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        try:
            return RegulatorProgram().spin(node, GuardedLoop(node.errors, executor), signals)
        finally:
            executor.shutdown()
            node.destroy_node()


@pytest.fixture
def made(monkeypatch, namespace, tmp_path):
    """Makes a bench with a rig, both of which it ends; a device is silent after 0.1 s."""
    benches = []

    def make(kind, **given):
        # A busy machine is no silent device, where silence is not what is tested.
        given = given or {"watchdog_timeout": 60.0, "device_timeout": 10.0}
        benches.append(Bench(monkeypatch, namespace, kind(tmp_path, namespace), **given))
        return benches[0]

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
NEAR = {"abs": 60.0}  # what registers of whole hPa hold


@pytest.mark.parametrize("row", rows(FAULTS))
def test_a_fault_is_told_nothing_is_measured_and_it_ends_vented(made, row):
    kind, fault, words = row.replace(": ", " ", 1).split(" ", 2)
    bench = made(KINDS[kind], watchdog_timeout=0.5)
    bench.until(OK, PASSES)
    assert bench.rig.set_point(bench) == pytest.approx(4.0e4, **NEAR)
    bench.rig.spoil(fault)
    bench.measured.clear()
    bench.until(ERROR, words)
    assert (bench.measured == []) is (fault != "refused")
    adapter = bench.node.adapter
    assert adapter.watch.is_latched is (adapter.link is Link.LOST)
    bench.rig.spoil("")
    bench.until(OK, PASSES, 0.0)
    bench.measured.clear()
    wait_until(lambda: bench.until(OK, PASSES, 3.0e4) or bench.measured)
    assert bench.measured[0].data == pytest.approx(3.0e4, **NEAR)  # no late answer
    assert bench.stop() == 0
    assert bench.rig.set_point(bench) == pytest.approx(0.0, **NEAR)


def test_an_exception_makes_a_vent_the_last_set_point(made):
    bench = made(Serial)
    bench.until(OK, PASSES)
    bench.node.adapter.step = lambda now: 1 / 0
    with pytest.raises(ZeroDivisionError):
        bench.stop(requested=False)
    assert bench.rig.set_point(bench) == 0.0


# Time, command, level, set-point, what is said; the time-out is 60 s.
COMMANDS = """
0 - 0 0 waiting for the first pressure_command
0 3e5 1 0 vented after a start
0 0 0 0 passes commands on
0 3e5 0 3e5 passes commands on
0 4e4 0 4e4 passes commands on
59 - 0 4e4 passes commands on
1 - 1 0 no pressure_command: vented
1 4e4 1 0 vented after a start, a lost link or a silence
1 0 0 0 passes commands on
1 4e4 0 4e4 passes commands on
1 3.01e5 1 4e4 pressure_command must be from 0 to 300000 Pa
1 -1e-9 1 4e4 pressure_command must be
1 inf 1 4e4 pressure_command must be
56 nan 1 4e4 pressure_command must be
1 nan 1 0 pressure_command must be
"""


def test_a_stream_that_comes_back_is_followed_again_once_it_has_commanded_nothing(made):
    bench = made(Serial)
    assert bench.rig.heard == []
    for row in rows(COMMANDS):
        elapsed, command, level, set_point, words = row.split(" ", 4)
        bench.now += float(elapsed)
        state = bench.tick(*([] if command == "-" else [float(command)]))
        assert (state[0][0], bench.rig.set_point(bench)) == (int(level), float(set_point)), row
        assert words in state[1]
    # An adapter that is killed is survived by the device's own watchdog.
    assert {message.watchdog_ms for message in bench.rig.heard} == {60000}


def test_a_device_that_has_vented_by_itself_gets_nothing_before_a_command_of_0_pa(made):
    bench = made(Serial)
    bench.until(OK, PASSES)
    bench.rig.has_vented = True  # it restarts faster than any time-out
    level, text = bench.tick(4.0e4)
    assert (level, "has just started" in text) == (ERROR, True)
    heard = len(bench.rig.heard)
    for _ in range(3):
        level, text = bench.tick(4.0e4)
        assert (level, "waiting for a pressure_command of 0 Pa" in text) == (
            DiagnosticStatus.WARN,
            True,
        )
        assert bench.rig.pressure == 0.0
    assert {message.number for message in bench.rig.heard[heard:]} == {0.0}
    bench.tick(0.0)
    assert bench.tick(4.0e4)[0] == OK
    assert bench.rig.pressure == 4.0e4


def test_a_driver_that_is_slower_than_the_exchanges_stays_wrong_until_it_is_right(made):
    bench = made(Driver)
    bench.until(OK, PASSES, 0.0)
    for fault, level in (("stale", ERROR), ("", OK)):
        bench.rig.spoil(fault)
        bench.rig.tell(bench, 4.0e4)
        assert {bench.tick()[0] for _ in range(3)} == {level}


def test_a_measurement_that_is_stale_or_has_lost_its_driver_is_dropped(made):
    bench = made(Driver)
    bench.rig.spoil("gone")
    bench.until(ERROR, "nobody subscribes", 0.0)
    bench.rig.spoil("")
    bench.rig.tell = lambda *_: None  # the next driver has measured nothing yet
    bench.until(OK, PASSES, 0.0)
    assert bench.measured == []


REFUSED = """
device=modbus
device=modbus command_unit=hPa command_offset=-1.0
device=serial command_scale=1.0e+9
measured_topic=x measured_scale=0.0
rate=3.9
rate=6.6 watchdog_timeout=0.3
device_timeout=0.26
measured_topic=x measured_field=nothing
command_topic=pressure_command
measured_topic=measured_pressure
measured_type=sensor_msgs/msg/FluidPressure measured_field=fluid_pressure
measured_offset=1.0
device=modbus command_unit=kPa measured_table=input
"""


def test_what_does_not_fit_is_refused_as_on_record(namespace):
    found = []
    for row in rows(REFUSED):
        with pytest.raises(ValueError, match="must be") as refusal:
            RegulatorNode(namespace=namespace, parameter_overrides=parameters(**named(row)))
        found.append(f"{row}: {refusal.value}")
    agrees("devices", "\n".join(found).replace(namespace, ""))


def test_the_whole_exchange_has_one_time_limit(made):
    bench = made(Modbus, watchdog_timeout=0.5)
    bench.until(OK, PASSES)
    bench.tick(4.0e4)
    written = bench.rig.written
    assert (3, [1413]) in written  # 1413.25 hPa
    # The set-point goes before the heartbeat, which counts.
    assert [register for register, _ in written][:2] == [3, 20]
    beats = [values[0] for register, values in written if register == 20]
    assert beats == list(range(1, len(beats) + 1))
    bench.rig.spoil("slow")
    # One error is no lost link before the time-out.
    for elapsed, level in ((0.49, OK), (0.02, ERROR)):
        bench.now += elapsed
        assert bench.tick()[0] == level
    assert bench.node.adapter.link_errors == 2
    assert bench.stop() == 1  # not vented
