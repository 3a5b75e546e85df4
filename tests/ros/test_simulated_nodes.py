# SPDX-License-Identifier: Apache-2.0
"""The simulator's nodes, ticked by hand: what they hear, publish and serve; and its process."""

import math
import signal

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy
from rclpy.time import ClockType, Time
from ros.harness import DEADLINE, all_finite, deliver
from ros.simulation_harness import QUIET, RADIUS, RunningSimulator, seconds
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from spiral_gripper_ros.simulation.main import main
from spiral_gripper_ros.simulation.radius_estimator import RadiusParameters
from spiral_gripper_ros.simulation.regulator import SimulatedRegulatorParameters
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

    def call(self, name):
        (service,) = [s for s in self.regulator.services if s.srv_name.endswith(f"/{name}")]
        return service.callback(Trigger.Request(), Trigger.Response())

    @property
    def diagnosis(self):
        return self.told["/diagnostics"][-1].status[0].level

    def close(self):
        self.simulator.executor.shutdown()
        for node in self.simulator.nodes:
            node.destroy_node()


@pytest.fixture
def bench(namespace):
    bench = Bench(namespace, **OWN_TIME)
    yield bench
    bench.close()


def test_the_measured_pressure_follows_the_command_with_the_lag_that_is_documented(bench):
    bench.set(time_constant=1.0)
    gaps = 4.0e4 - np.array(bench.run(0.5, 4.0e4))
    assert len(gaps) == 50
    assert gaps == pytest.approx(4.0e4 * np.exp(-0.01 * np.arange(1, 51)))


@pytest.mark.parametrize("bad", [None, math.nan, math.inf, -1.0, 1.0e9])
def test_a_command_that_cannot_be_keeps_no_watchdog_quiet(bench, bad):
    assert bench.run(2.0, WRAP)[-1] == pytest.approx(WRAP, abs=1.0)
    assert bench.diagnosis == DiagnosticStatus.OK
    assert bench.run(2.5, bad)[-1] < 1.0
    assert bench.diagnosis == DiagnosticStatus.WARN


@pytest.mark.parametrize("by_service", [True, False])
def test_faults_come_and_go_by_their_services_or_at_once_by_the_parameter(bench, by_service):
    def inject(fault):
        if by_service:
            answer = bench.call("clear_fault" if fault == "none" else f"inject_{fault}")
            assert (answer.success, answer.message) == (True, f"fault: {fault}")
        else:
            assert bench.set(fault=fault) == ""

    bench.run(2.0, WRAP)
    inject("leak")
    leaking = bench.run(2.0, WRAP)[-1]
    assert leaking < 0.7 * WRAP
    assert bench.diagnosis == DiagnosticStatus.ERROR
    inject("stuck_valve")
    assert set(bench.run(1.0, 0.0)) == {leaking}
    inject("lost_link")
    assert bench.run(2.0, WRAP) == []
    assert bench.heard("simulated/pressure")[-1] < 1.0
    inject("none")
    bench.run(0.1, 0.0)
    assert bench.run(2.0, WRAP)[-1] == pytest.approx(WRAP, abs=1.0)


def test_a_bad_parameter_is_refused_with_the_reason(bench):
    assert "one of none, leak, stuck_valve, lost_link" in bench.set(fault="typhoon")
    assert "time_constant out of range" in bench.set(time_constant=-1.0)


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
    assert all_finite(shape)
    assert shape.header.frame_id == "gripper_base"
    times = [seconds(message.clock) for message in bench.told["/clock"]]
    assert times == pytest.approx([0.01 * step for step in range(1, 301)])
    assert seconds(shape.header.stamp) in times
    bench.set(real_time_factor=4.0)
    bench.run(0.01)
    assert [timer.timer_period_ns for timer in bench.regulator.timers] == [2_500_000]


def test_the_radii_are_estimated_with_the_errors_that_are_set_at_once(bench):
    for values, estimate, radius in (
        ({}, RADIUS, RADIUS),
        ({"radius": 0.01, "estimate_bias": 0.005}, pytest.approx(0.015), 0.01),
        ({"nan_probability": 1.0}, pytest.approx(math.nan, nan_ok=True), 0.01),
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


def test_a_command_that_was_latched_before_it_came_is_not_followed(bench):
    (commands,) = [s for s in bench.regulator.subscriptions if "pressure" in s.topic_name]
    assert commands.qos_profile.durability is DurabilityPolicy.VOLATILE


def test_a_misspelled_parameter_ends_the_start_and_a_stop_signal_its_process(client, namespace):
    with (
        RunningSimulator(namespace, {"falt": "leak"}) as wrong,
        RunningSimulator(namespace) as simulator,
    ):
        assert wrong.wait(DEADLINE)
        assert (wrong.exit_code, "did you mean fault?" in wrong.log()) == (1, True)
        told = []
        client.create_subscription(Float64, "simulated/pressure", told.append, 10)
        client.wait_until(lambda: told, "the truth")
        assert simulator.stop(signal.SIGTERM) == 0
        assert "Traceback" not in wrong.log() + simulator.log()


def test_help_tells_every_parameter(capsys):
    assert main(["--help"]) == 0
    text = capsys.readouterr().out
    specs = SimulatedRegulatorParameters.specs() + RadiusParameters.specs()
    assert all(f"  {spec.name} (" in text for spec in specs)
