# SPDX-License-Identifier: Apache-2.0
"""The simulator's nodes, ticked by hand: what they hear, publish and serve; and its process."""

import math

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy
from rclpy.time import ClockType, Time
from ros.harness import deliver
from ros.simulation_harness import QUIET, RADIUS, seconds
from std_msgs.msg import Float64

from spiral_gripper_ros.simulation.simulated_gripper import SimulatedGripper
from spiral_gripper_ros.simulation.simulator import Simulator

WRAP = 57.0e3
OWN_TIME = {**QUIET, "radius": RADIUS, "publish_clock": True, "measured_rate": 100.0}


class Bench:
    """A simulator in this process whose steps of 10 ms are the test's, and all that it tells."""

    def __init__(self, namespace, **parameters):
        given = [Parameter(name, value=value) for name, value in parameters.items()]
        self.simulator = Simulator(
            SingleThreadedExecutor(), namespace=namespace, parameter_overrides=given
        )
        self.regulator, self.radii = self.simulator.nodes
        self.told = {}
        for node in self.simulator.nodes:
            for publisher in node.publishers:
                topic = publisher.topic.removeprefix(f"{namespace}/")
                self.told[topic] = []
                publisher.publish = self.told[topic].append

    def run(self, duration, command=None):
        """Let a time pass, with a command before each step if given; return what is measured."""
        for _ in range(round(100 * duration)):
            if command is not None:
                deliver(self.regulator, "pressure_command", Float64(data=command))
            (timer,) = self.regulator.timers
            timer.callback()
        return self.heard("measured_pressure")

    def heard(self, topic):
        """The numbers of a topic that have come since it was last asked for."""
        numbers = [message.data for message in self.told[topic]]
        self.told[topic].clear()
        return numbers

    def set(self, **values):
        """Set parameters of the node that has them; return the reason of a refusal."""
        (name, *_) = values
        node = self.regulator if self.regulator.has_parameter(name) else self.radii
        given = [Parameter(name, value=value) for name, value in values.items()]
        return "".join(result.reason for result in node.set_parameters(given))

    def close(self):
        self.simulator.executor.shutdown()
        for node in self.simulator.nodes:
            node.destroy_node()


@pytest.fixture
def bench(namespace):
    bench = Bench(namespace, **OWN_TIME)
    yield bench
    bench.close()


def test_the_truth_is_told_in_even_steps_of_its_clock(bench, gripper):
    bench.run(3.0, WRAP)
    assert bench.heard("simulated/grip")[-1] == "perfect wrap"
    assert bench.heard("simulated/pressure")[-1] == pytest.approx(WRAP, abs=1.0)
    assert bench.heard("simulated/object_radius")[-1] == RADIUS
    shape = bench.told["simulated/backbone"][-1]
    tip = shape.poses[-1].position
    expected = SimulatedGripper(gripper).shape(WRAP).tip_position
    # What is left of the way changes it by micrometers.
    assert np.allclose((tip.x, tip.y, tip.z), expected, rtol=0.0, atol=1e-5)
    times = [seconds(message.clock) for message in bench.told["/clock"]]
    assert times == pytest.approx([0.01 * step for step in range(1, 301)])
    assert seconds(shape.header.stamp) in times
    bench.set(real_time_factor=4.0)
    bench.run(0.01)
    assert [timer.timer_period_ns for timer in bench.regulator.timers] == [2_500_000]


def test_a_command_that_was_latched_before_it_came_is_not_followed(bench):
    (commands,) = [s for s in bench.regulator.subscriptions if "pressure" in s.topic_name]
    assert commands.qos_profile.durability is DurabilityPolicy.VOLATILE


def test_a_fault_that_is_set_acts_at_once_and_is_diagnosed(bench):
    bench.run(2.0, WRAP)
    for fault, level in (("leak", DiagnosticStatus.ERROR), ("none", DiagnosticStatus.OK)):
        assert bench.set(fault=fault) == ""
        pressure = bench.run(2.0, WRAP)[-1]
        assert (pressure < 0.7 * WRAP) is (fault == "leak")
        assert bench.told["/diagnostics"][-1].status[0].level == level
    assert "one of none, leak, stuck_valve, lost_link" in bench.set(fault="typhoon")


def test_the_radii_are_estimated_with_the_errors_that_are_set_at_once(bench):
    for values, estimate, radius in (
        ({}, RADIUS, RADIUS),
        ({"radius": 0.01, "estimate_bias": 0.005}, pytest.approx(0.015), 0.01),
    ):
        bench.set(**values or {"radius": RADIUS})
        bench.run(0.1)
        assert bench.heard("object_radius")[-1] == estimate
        assert bench.heard("simulated/object_radius")[-1] == radius
    bench.set(profile="none")
    bench.run(0.2)
    assert bench.heard("object_radius") == []
    assert bench.heard("simulated/grip")[-1] == "no object"


def test_it_lives_in_the_time_of_somebody_elses_clock(namespace):
    bench = Bench(namespace, **{**OWN_TIME, "publish_clock": False, "use_sim_time": True})
    clock = bench.regulator.get_clock()
    for reading in range(0, 200_000_000, 50_000_000):
        clock.set_ros_time_override(Time(nanoseconds=reading, clock_type=ClockType.ROS_TIME))
        bench.run(0.01, WRAP)
    passed = bench.regulator.regulator.pressure
    assert passed == pytest.approx(WRAP * -math.expm1(-0.15 / 0.1))
    bench.told["measured_pressure"].clear()
    assert bench.run(1.0, WRAP) == []  # the clock stands still
    assert bench.regulator.regulator.pressure == passed
    bench.close()
