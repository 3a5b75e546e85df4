# SPDX-License-Identifier: Apache-2.0
"""The simulator's nodes, ticked by hand: what they hear, publish and serve."""

import math

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy
from rclpy.time import ClockType, Time
from ros.harness import deliver, serve
from ros.local_nodes import change, overhear, parameters
from std_msgs.msg import Float64

from spiral_gripper_ros.simulation.simulated_gripper import SimulatedGripper
from spiral_gripper_ros.simulation.simulator import Simulator

WRAP, RADIUS = 57.0e3, 0.02


class Bench:
    """A simulator in this process whose steps of 10 ms are the test's, and all that it tells."""

    def __init__(self, namespace, **values):
        values.update(radius=RADIUS, pressure_noise=0.0, estimate_noise=0.0, measured_rate=100.0)
        given = parameters(**values)
        self.simulator = Simulator(
            SingleThreadedExecutor(), namespace=namespace, parameter_overrides=given
        )
        self.regulator, self.radii = self.simulator.nodes
        self.told = overhear(*self.simulator.nodes)

    def run(self, duration):
        """Let a time pass, with a command before each step."""
        for _ in range(round(100 * duration)):
            deliver(self.regulator, "pressure_command", Float64(data=WRAP))
            (timer,) = self.regulator.timers
            timer.callback()

    def last(self, topic):
        return self.told[topic][-1].data


@pytest.fixture(params=[True])
def bench(namespace, request):
    clock = request.param
    bench = Bench(namespace, publish_clock=clock, use_sim_time=not clock)
    yield bench
    bench.simulator.executor.shutdown()
    for node in bench.simulator.nodes:
        node.destroy_node()


def test_the_truth_is_told_in_even_steps_of_its_clock(bench, gripper):
    bench.run(3.0)
    assert bench.last("simulated/grip") == "perfect wrap"
    assert bench.last("simulated/pressure") == pytest.approx(WRAP, abs=1.0)
    shape = bench.told["simulated/backbone"][-1]
    tip = shape.poses[-1].position
    expected = SimulatedGripper(gripper).shape(WRAP).tip_position
    # What is left of the way changes it by micrometers.
    assert (tip.x, tip.y, tip.z) == pytest.approx(expected, abs=1e-5)
    stamps = [message.clock for message in bench.told["/clock"]]
    times = [stamp.sec + 1e-9 * stamp.nanosec for stamp in stamps]
    assert times == pytest.approx([0.01 * step for step in range(1, 301)])
    assert shape.header.stamp in stamps
    (commands,) = [s for s in bench.regulator.subscriptions if "pressure" in s.topic_name]
    assert commands.qos_profile.durability is DurabilityPolicy.VOLATILE  # nothing latched


def test_parameters_and_faults_act_at_once(bench):
    change(bench.regulator, real_time_factor=4.0)
    change(bench.radii, radius=0.01, estimate_bias=0.005)
    bench.run(2.0)
    assert [timer.timer_period_ns for timer in bench.regulator.timers] == [2_500_000]
    assert bench.last("object_radius") == pytest.approx(0.015)
    assert bench.last("simulated/object_radius") == 0.01
    change(bench.radii, profile="none")
    bench.told["object_radius"].clear()
    bench.run(0.2)
    assert bench.told["object_radius"] == []
    assert bench.last("simulated/grip") == "no object"
    assert serve(bench.regulator, "inject_leak", None).success
    bench.run(2.0)
    assert bench.last("measured_pressure") < 0.7 * WRAP
    assert bench.told["/diagnostics"][-1].status[0].level == DiagnosticStatus.ERROR


@pytest.mark.parametrize("bench", [False], indirect=True)
def test_it_lives_in_the_time_of_somebody_elses_clock(bench):
    clock = bench.regulator.get_clock()
    for reading in range(0, 200_000_000, 50_000_000):
        clock.set_ros_time_override(Time(nanoseconds=reading, clock_type=ClockType.ROS_TIME))
        bench.run(0.01)
    passed = bench.regulator.regulator.pressure
    assert passed == pytest.approx(WRAP * -math.expm1(-0.15 / 0.1))
    bench.run(1.0)  # the clock stands still
    assert bench.regulator.regulator.pressure == passed
