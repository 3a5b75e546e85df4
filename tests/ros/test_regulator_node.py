# SPDX-License-Identifier: Apache-2.0
"""The adapter's process between the gripper's topics and a device."""

import signal
import subprocess
import sys
import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from ros.enclaves import rights_by_enclave, used_rights
from ros.harness import DEADLINE, RunningNode, Spinner, deliver
from ros.regulator_devices import LineDevice, ModbusServer
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Float32, Float64

from spiral_gripper_ros.messages.qos import COMMAND, LATEST
from spiral_gripper_ros.regulators.adapter import Link
from spiral_gripper_ros.regulators.parameters import REGULATOR_PARAMETERS
from spiral_gripper_ros.regulators.regulator_node import REGULATOR_NODE, RegulatorNode

ADAPTER = "spiral_gripper_ros.regulators.main"
AIR = 101325.0
# A busy machine is no silent node.
PATIENT = {"watchdog_timeout": 5.0, "device_timeout": 1.0}


class Gripper(Node):
    """Commands pressures as the gripper's node does, and hears what comes back."""

    def __init__(self, namespace):
        super().__init__("gripper", namespace=namespace)
        self.measured, self.states = [], []
        self._commands = self.create_publisher(Float64, "pressure_command", COMMAND)
        self.create_subscription(Float64, "measured_pressure", self.measured.append, 10)
        self.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 10)
        self._spinner = Spinner()
        self._spinner.add_node(self)

    def close(self):
        self._spinner.shutdown()
        self.destroy_node()

    def _on_diagnostics(self, message):
        name = f"{self.get_namespace()}/{REGULATOR_NODE}: adapter"
        self.states += [(s.level, s.message) for s in message.status if s.name == name]

    def wait_until(self, condition, what):
        end = time.monotonic() + DEADLINE
        while not condition():
            assert time.monotonic() < end, f"{what}; {self.states[-1:]}"
            self._spinner.spin_once(timeout_sec=0.02)

    def command_until(self, pressure, condition, what):
        def commanded():
            self._commands.publish(Float64(data=pressure))
            return condition()

        self.wait_until(commanded, what)

    def wait_for_state(self, level, text):
        self.states.clear()
        self.wait_until(
            lambda: any(state[0] == level and text in state[1] for state in self.states), text
        )


@pytest.fixture
def gripper(namespace):
    gripper = Gripper(namespace)
    yield gripper
    gripper.close()


@pytest.fixture
def line():
    device = LineDevice()
    yield device
    device.close()


def adapter(namespace, **parameters):
    return RunningNode(namespace, {**PATIENT, **parameters}, module=ADAPTER)


def on_line(namespace, line, **parameters):
    return adapter(namespace, device="serial", port=line.port, **parameters)


def test_a_command_reaches_the_device_and_its_pressure_comes_back(namespace, gripper, line):
    with on_line(namespace, line) as process:
        gripper.wait_until(lambda: line.set_points, "the first set-point")
        gripper.wait_for_state(DiagnosticStatus.OK, "waiting for the first pressure_command")
        gripper.command_until(
            4.0e4,
            lambda: gripper.measured and gripper.measured[-1].data == 4.0e4,
            "the measured pressure",
        )
        assert line.set_points[0] == 0.0  # vented until somebody commands
        gripper.wait_for_state(DiagnosticStatus.OK, "passes commands on")
        assert process.stop() == 0, process.log()


@pytest.mark.usefixtures("hangups")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_stop_signal_makes_a_vent_the_last_set_point(namespace, gripper, line, number):
    with on_line(namespace, line) as process:
        gripper.command_until(4.0e4, lambda: line.pressure == 4.0e4, "the pressure")
        assert process.stop(number) == 0, process.log()
    assert line.set_points[-1] == 0.0


def test_an_exception_makes_a_vent_the_last_set_point(namespace, line):
    broken = "import spiral_gripper_ros.regulators.regulator_node as n\n"
    broken += "def tell(self): raise RuntimeError('a defect')\n"
    broken += "n.RegulatorNode._tell = tell\nfrom spiral_gripper_ros.regulators.main import main\n"
    command = [sys.executable, "-c", broken + "raise SystemExit(main())", "--ros-args"]
    command += ["-r", f"__ns:={namespace}", "-p", "device:=serial", "-p", f"port:={line.port}"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE, check=False)
    assert ended.returncode != 0
    assert "a defect" in ended.stderr
    assert len(line.set_points) >= 2
    assert line.set_points[-1] == 0.0


def test_an_adapter_that_is_killed_is_survived_by_the_devices_watchdog(namespace, gripper, line):
    with on_line(namespace, line, watchdog_timeout=3.0, device_timeout=0.2) as process:
        gripper.command_until(4.0e4, lambda: line.pressure == 4.0e4, "the pressure")
        process.stop(signal.SIGKILL)
        gripper.wait_until(lambda: line.pressure == 0.0, "the vent of the device")
    assert line.set_points[-1] == 4.0e4


def test_commands_that_stop_or_cannot_be_vent(namespace, gripper, line):
    with on_line(namespace, line, watchdog_timeout=3.0, device_timeout=0.2):
        gripper.command_until(4.0e4, lambda: line.pressure == 4.0e4, "the pressure")
        gripper.wait_until(lambda: line.set_points[-1] == 0.0, "the vent after silence")
        gripper.wait_for_state(DiagnosticStatus.WARN, "no pressure_command: vented")
        gripper.states.clear()
        gripper.command_until(
            0.0,
            lambda: gripper.states and gripper.states[-1][0] == DiagnosticStatus.OK,
            "the watchdog, which waits for 0 Pa, to hear it",
        )
        gripper.command_until(4.0e4, lambda: line.pressure == 4.0e4, "the pressure again")
        gripper.command_until(
            float("nan"), lambda: line.set_points[-1] == 0.0, "the vent in a stream of NaN"
        )
        gripper.wait_for_state(DiagnosticStatus.WARN, "pressure_command must be")


def test_a_vent_does_not_wait_for_the_next_exchange(namespace, line):
    values = {"device": "serial", "port": line.port, "watchdog_timeout": 60.0}
    values["device_timeout"] = 10.0
    given = [Parameter(name, value=value) for name, value in values.items()]
    node = RegulatorNode(namespace=namespace, parameter_overrides=given)
    # Nothing spins the node: no timer exchanges anything.
    deliver(node, "pressure_command", Float64(data=4.0e4))
    assert line.set_points == []
    deliver(node, "pressure_command", Float64(data=0.0))
    assert line.set_points == [0.0]
    node.destroy_node()


def test_a_link_that_is_lost_is_told_and_nothing_is_measured_until_it_is_back(
    namespace, gripper, line
):
    with on_line(namespace, line, watchdog_timeout=3.0, device_timeout=0.2):
        gripper.command_until(
            4.0e4, lambda: gripper.measured and line.pressure == 4.0e4, "the pressure"
        )
        line.mode = "mute"
        gripper.command_until(
            4.0e4, lambda: any("link lost" in text for _, text in gripper.states), "the lost link"
        )
        assert line.pressure == 0.0  # its own watchdog
        gripper.measured.clear()
        line.mode = "good"
        gripper.command_until(4.0e4, lambda: line.pressure == 4.0e4, "the pressure again")
        gripper.command_until(4.0e4, lambda: gripper.measured, "measurements again")


def test_a_device_that_is_gone_at_the_end_makes_the_exit_code_1(namespace, gripper, line):
    with on_line(namespace, line) as process:
        gripper.command_until(4.0e4, lambda: line.pressure == 4.0e4, "the pressure")
        line.close()
        assert process.stop() == 1
        assert "the last vent was not answered" in process.log()


def test_a_modbus_device_is_commanded_and_vented_at_the_end(namespace, gripper):
    server = ModbusServer()
    try:
        layout = {"command_register": 3, "command_unit": "hPa", "command_reference": "absolute"}
        with adapter(
            namespace, device="modbus", host="127.0.0.1", tcp_port=server.port, **layout
        ) as process:
            gripper.command_until(
                4.0e4, lambda: server.registers.get(3) == 1413, "the set-point in hPa"
            )
            assert process.stop() == 0, process.log()
        assert server.registers[3] == 1013
    finally:
        server.close()


def test_a_modbus_device_that_answers_too_slowly_to_keep_its_watchdog_is_a_lost_link(
    namespace, gripper
):
    server = ModbusServer()
    try:
        layout = {"command_register": 3, "measured_register": 10, "heartbeat_register": 20}
        layout |= {"command_unit": "hPa", "watchdog_timeout": 2.0, "device_timeout": 1.0}
        with adapter(
            namespace, device="modbus", host="127.0.0.1", tcp_port=server.port, **layout
        ) as process:
            gripper.command_until(4.0e4, lambda: server.registers.get(3) == 400, "the set-point")
            server.delay = 0.7  # three answers take longer than the watchdog waits
            gripper.command_until(
                3.0e4,
                lambda: any("link lost" in text for _, text in gripper.states),
                "the lost link",
            )
            first, second, *_ = (register for register, _ in server.written)
            assert (first, second) == (3, 20)  # the set-point goes before the heartbeat
            server.delay = 0.0
            assert process.stop() == 0, process.log()
    finally:
        server.close()


def test_a_drivers_topics_are_served_in_its_type_unit_and_reference(namespace, gripper):
    set_points = []
    driver = Node("driver", namespace=namespace)
    measured = driver.create_publisher(Float32, "valve/pressure", 1)
    driver.create_subscription(Float32, "valve/set", lambda m: set_points.append(m.data), 10)
    gripper._spinner.add_node(driver)
    topics = {
        "command_topic": "valve/set",
        "measured_topic": "valve/pressure",
        **{f"{side}_type": "std_msgs/msg/Float32" for side in ("command", "measured")},
        **{f"{side}_unit": "kPa" for side in ("command", "measured")},
        "command_reference": "absolute",
        "measured_reference": "absolute",
    }
    with adapter(namespace, **topics) as process:

        def answered():
            measured.publish(Float32(data=121.325))
            return set_points and set_points[-1] > 140.0 and gripper.measured

        gripper.wait_until(lambda: set_points, "the first set-point")
        gripper.command_until(4.0e4, answered, "the set-point in kPa, and the measured pressure")
        assert set_points[0] == pytest.approx(1e-3 * AIR)
        assert set_points[-1] == pytest.approx(1e-3 * (AIR + 4.0e4))
        assert gripper.measured[-1].data == pytest.approx(2.0e4, abs=0.1)
        assert process.stop() == 0, process.log()
        gripper.wait_until(lambda: set_points[-1] < 101.4, "the vent")
    driver.destroy_node()


def test_a_measurement_that_is_stale_or_has_lost_its_driver_is_dropped(namespace, gripper):
    driver = Node("driver", namespace=namespace)
    measured = driver.create_publisher(FluidPressure, "valve/pressure", 1)
    gripper._spinner.add_node(driver)
    message = FluidPressure(fluid_pressure=4.0e4)
    age = Duration(seconds=0.0)

    def publish():
        message.header.stamp = (driver.get_clock().now() - age).to_msg()
        measured.publish(message)
        return bool(gripper.measured)

    def listen():
        return driver.create_subscription(Float64, "valve/set", set_points.append, 10)

    topics = {"command_topic": "valve/set", "measured_topic": "valve/pressure"}
    topics["measured_type"] = "sensor_msgs/msg/FluidPressure"
    topics["measured_field"] = "fluid_pressure"
    set_points = []
    first = listen()
    with adapter(namespace, watchdog_timeout=1.0, device_timeout=0.2, **topics) as process:
        gripper.wait_until(publish, "the measured pressure")
        age = Duration(seconds=60.0)
        gripper.wait_until(
            lambda: (
                publish()
                and any("more than watchdog_timeout" in text for _, text in gripper.states)
            ),
            "the refusal of stale measurements",
        )
        gripper.measured.clear()
        quiet = time.monotonic() + 0.5
        gripper.wait_until(lambda: publish() or time.monotonic() > quiet, "half a second")
        assert gripper.measured == []
        age = Duration(seconds=0.0)
        gripper.wait_until(publish, "a young measurement")
        driver.destroy_subscription(first)
        gripper.wait_until(
            lambda: publish() and any("nobody subscribes" in text for _, text in gripper.states),
            "the lost driver",
        )
        quiet = time.monotonic() + 0.5  # what is under way arrives, and the driver starts anew
        gripper.wait_until(lambda: time.monotonic() > quiet, "half a second")
        gripper.measured.clear()
        set_points.clear()
        listen()
        gripper.wait_until(lambda: len(set_points) >= 20, "set-points for the next driver")
        assert gripper.measured == []
        assert process.stop() == 0, process.log()
    driver.destroy_node()


def test_a_driver_that_is_slower_than_the_exchanges_stays_wrong_until_it_is_right(
    namespace, gripper
):
    values = {"measured_topic": "valve/pressure", "watchdog_timeout": 60.0}
    values |= {"measured_type": "sensor_msgs/msg/FluidPressure", "device_timeout": 10.0}
    values["measured_field"] = "fluid_pressure"
    given = [Parameter(name, value=value) for name, value in values.items()]
    node = RegulatorNode(namespace=namespace, parameter_overrides=given)
    gripper.create_subscription(Float64, "regulator/set_point", lambda message: None, 10)

    def is_connected():
        node._exchange()
        return node.adapter.link is Link.UP

    gripper.wait_until(is_connected, "the driver")
    message = FluidPressure(fluid_pressure=4.0e4)
    for age, level in ((100.0, DiagnosticStatus.ERROR), (0.0, DiagnosticStatus.OK)):
        message.header.stamp = (node.get_clock().now() - Duration(seconds=age)).to_msg()
        deliver(node, "pressure", message)
        levels = []
        for _ in range(3):
            node._exchange()
            levels.append(node._state()[0])
        assert levels == [level] * 3
    node.destroy_node()


def test_a_latched_command_is_not_taken_for_a_new_one(namespace, gripper, line):
    gripper.create_publisher(Float64, "pressure_command", LATEST).publish(Float64(data=4.0e4))
    with on_line(namespace, line):
        gripper.wait_until(lambda: len(gripper.measured) >= 20, "a second's measurements")
        assert set(line.set_points) == {0.0}


@pytest.mark.parametrize(
    ("parameters", "kind"),
    [
        ({"device": "pneumatic"}, "device must be one of topic, serial, modbus"),
        ({"device": "modbus"}, "command_format must be"),
        ({"rate": 1.0, "watchdog_timeout": 0.5, "device_timeout": 0.1}, "rate must be at least"),
        ({"command_type": "std_msgs/msg/Nothing"}, "command_type must be"),
        ({"command_field": "nothing"}, "command_field must be"),
        ({"command_topic": "pressure_command"}, "command_topic must be"),
        ({"pressure_limit": "nan"}, "pressure_limit"),
        ({"prot": "/dev/ttyACM0"}, "did you mean port?"),
    ],
)
def test_a_bad_parameter_ends_the_start_with_its_name(namespace, parameters, kind):
    with adapter(namespace, **parameters) as process:
        assert process.wait(DEADLINE)
        assert process.exit_code == 1
        assert kind in process.log()


def test_the_adapter_may_do_what_it_does_and_nothing_else(namespace, gripper):
    granted = rights_by_enclave(namespace)["regulator"]
    own = {("publish", f"{namespace}/regulator/set_point")}
    with RunningNode(namespace, {"use_sim_time": True}, module=ADAPTER):
        gripper.wait_until(
            lambda: used_rights(gripper, REGULATOR_NODE) >= own, "the driver's topic"
        )
        used = used_rights(gripper, REGULATOR_NODE)
    assert used <= granted


def test_help_names_every_parameter():
    command = [sys.executable, "-m", ADAPTER, "--help"]
    shown = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert all(f"  {spec.name} (" in shown for spec in REGULATOR_PARAMETERS)
