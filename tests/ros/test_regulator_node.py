# SPDX-License-Identifier: Apache-2.0
"""The adapter as a process between the gripper's topics and a driver's: a stop ends in a vent."""

import signal

import pytest
from rclpy.qos import qos_profile_sensor_data
from ros.harness import ALL, RunningNode
from std_msgs.msg import Float32, Float64

from spiral_gripper_ros.messages.qos import COMMAND

DRIVER = {
    f"{side}_{what}": value
    for side in ("command", "measured")
    for what, value in (
        ("topic", f"valve/{side}"),
        ("type", "std_msgs/msg/Float32"),
        ("unit", "kPa"),
        ("reference", "absolute"),
    )
}


@pytest.mark.usefixtures("hangups")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_stop_signal_makes_a_vent_the_last_set_point(client, namespace, number):
    set_points, measured = [], []
    client.create_subscription(Float32, "valve/command", set_points.append, ALL)
    client.create_subscription(Float64, "measured_pressure", measured.append, ALL)
    driver = client.create_publisher(Float32, "valve/measured", qos_profile_sensor_data)
    gripper = client.create_publisher(Float64, "pressure_command", COMMAND)

    def is_passed_on():
        gripper.publish(Float64(data=4.0e4))
        driver.publish(Float32(data=121.325))
        return measured and set_points[-1].data == pytest.approx(141.325)

    parameters = {**DRIVER, "watchdog_timeout": 60.0, "use_sim_time": True}  # no clock ticks
    adapter = RunningNode(namespace, parameters, module="spiral_gripper_ros.regulators.main")
    with adapter:
        client.wait_until(lambda: set_points, "the first set-point")
        assert set_points[0].data == pytest.approx(101.325)  # vented until somebody commands
        client.wait_until(is_passed_on, "command and measurement")
        assert adapter.stop(number) == 0, adapter.log()
    client.wait_until(lambda: set_points[-1].data == pytest.approx(101.325), "the vent")
    assert measured[-1].data == pytest.approx(2.0e4, abs=0.1)
