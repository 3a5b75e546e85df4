# SPDX-License-Identifier: Apache-2.0
"""The simulator's nodes, ticked by hand: what they hear, publish and serve."""

import math

import pytest
from rclpy.time import ClockType, Time
from ros.control_bench import Steps, rows
from ros.harness import deliver, serve
from ros.local_nodes import change, overhear, parameters
from ros.records import agrees, told
from std_msgs.msg import Float64

from spiral_gripper_ros.simulation.simulated_gripper import SimulatedGripper
from spiral_gripper_ros.simulation.simulator import Simulator

WRAP, RADIUS = 57.0e3, 0.02


class Bench(Steps):
    """A simulator in this process whose steps of 10 ms are the test's, and all that it tells."""

    def __init__(self, namespace, **values):
        values.update(radius=RADIUS, pressure_noise=0.0, estimate_noise=0.0, measured_rate=100.0)
        given = parameters(**values)
        self.simulator = Simulator(namespace=namespace, parameter_overrides=given)
        self.regulator, self.radii = self.simulator.nodes
        self.told = overhear(*self.simulator.nodes)

    def run(self, duration):
        """Let a time pass, with a command before each step."""
        for _ in range(round(100 * duration)):
            deliver(self.regulator, "pressure_command", Float64(data=WRAP))
            (timer,) = self.regulator.timers
            timer.callback()

    def set(self, node, **values):
        change(getattr(self, node), **{name: value or "none" for name, value in values.items()})

    def call(self, name):
        assert serve(self.regulator, name, None).success


@pytest.fixture(params=[True])
def bench(namespace, request):
    clock = request.param
    bench = Bench(namespace, publish_clock=clock, use_sim_time=not clock)
    yield bench
    for node in bench.simulator.nodes:
        node.destroy_node()


# The last of each topic after each row is on record: parameters and faults act at once.
SESSION = """
run 0.1
run 2.9
set regulator real_time_factor=4; set radii radius=0.01 estimate_bias=0.005; run 2
set radii profile=none; run 0.2
set radii profile=constant estimate_noise=1e-4; set regulator pressure_noise=200; run 0.5
call inject_leak; run 1
call inject_stuck_valve; run 1
call inject_lost_link; run 1
call clear_fault; run 0.5
set regulator measured_rate=30; run 2
"""


def test_what_a_simulator_tells_in_a_session_is_that_on_record(bench):
    found = []
    del bench.told["simulated/backbone"]
    for row in rows(SESSION):
        bench.follow(row)
        found += [f"# {row}", f"period {next(bench.regulator.timers).timer_period_ns}"]
        for topic, messages in sorted(bench.told.items()):
            found += [f"{topic}: {len(messages)}", *map(told, messages[-1:])]
            messages.clear()
    agrees("simulator", "\n".join(found).replace(bench.regulator.get_namespace(), ""))


def test_the_shape_that_is_told_is_that_at_the_pressure(bench, gripper):
    bench.run(3.0)
    tip = bench.told["simulated/backbone"][-1].poses[-1].position
    expected = SimulatedGripper(gripper).shape(WRAP).tip_position
    # What is left of the way changes it by micrometers.
    assert (tip.x, tip.y, tip.z) == pytest.approx(expected, abs=1e-5)


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
