# SPDX-License-Identifier: Apache-2.0
"""A running node with use_sim_time: ramp, time-outs and ticks follow /clock, whatever its pace."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from lifecycle_msgs.msg import State as LifecycleState
from rclpy.qos import QoSProfile, ReliabilityPolicy
from ros.harness import START_DEADLINE, Client, RunningNode, all_finite
from rosgraph_msgs.msg import Clock

from spiral_gripper_ros.control.states import Reason, State

RADIUS = 0.02
RATE = 4.0e4
# A little more than the node's period, so that each step of the clock lets it tick.
STEP = 25_000_000
SIMULATED = {"use_sim_time": "true", "pressure.rate_up": RATE, "radius.timeout": 3600.0}


class SimulatedTime:
    """Publishes /clock, one step at a time, and waits until the node has lived through it."""

    def __init__(self, client):
        self.client = client
        self.now = 0
        self._clock = client.create_publisher(
            Clock, "/clock", QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
        )

    def advance(self, step=STEP, pace=0.0):
        """Let ``step`` ns pass in at least ``pace`` s of real time; return the status then."""
        self.now += step
        # Nodes listen to /clock with best effort: the same time again is no other.
        self.client.wait_until(
            lambda: (self.set(self.now), self.stamp() == self.now)[1], f"a status at {self.now} ns"
        )
        if pace > 0.0:
            self.client.spin(pace)
        return self.client.status

    def set(self, now):
        self.now = now
        seconds, nanoseconds = divmod(now, 1_000_000_000)
        self._clock.publish(Clock(clock=Time(sec=seconds, nanosec=nanoseconds)))

    def stamp(self):
        status = self.client.status
        if status is None:
            return None
        return status.header.stamp.sec * 1_000_000_000 + status.header.stamp.nanosec

    def start(self):
        """Let the clock run until the node is active and ticks, and hears us."""
        client = self.client
        client.wait_until(
            lambda: client.lifecycle_state() == LifecycleState.PRIMARY_STATE_ACTIVE,
            "the node to become active",
            START_DEADLINE,
        )

        def goes_on():
            self.set(self.now + STEP)
            client.spin(0.01)
            return self.stamp() is not None and client.pressures and client.is_heard

        client.wait_until(goes_on, "a status")
        client.spin(0.1)
        self.advance()

    def ramp(self, pace=0.0):
        """Send a radius and advance until it is wrapped; return the commands by the way."""
        self.client.send_radius(RADIUS)
        self.client.wait_until(
            lambda: list(self.client.status.object_radius) == [RADIUS], "the radius"
        )
        commands = []
        while True:
            status = self.advance(pace=pace)
            commands.append(status.pressure_command)
            if status.pressure_command == status.pressure_target:
                return commands
            assert len(commands) < 1000


@pytest.fixture(scope="module")
def node():
    client = Client("/simulated")
    simulated = SimulatedTime(client)
    with RunningNode("/simulated", SIMULATED) as process:
        simulated.start()
        yield simulated
        assert process.stop() == 0, process.log()
    client.close()


@pytest.fixture
def simulated(node):
    """The node, freshly activated, at a time that it has never seen before."""
    client = node.client
    if client.lifecycle_state() == LifecycleState.PRIMARY_STATE_ACTIVE:
        assert client.transition("deactivate")
    for name, value in (("radius.timeout", 3600.0), ("radius.timeout_policy", "hold")):
        assert client.set_parameter(name, value).successful
    node.set(node.now + 1_000_000_000)
    client.spin(0.1)
    assert client.transition("activate")
    client.wait_for_state(State.WAITING)
    client.forget()
    node.advance()
    return node


def test_before_the_clock_runs_nothing_is_commanded():
    client = Client("/stopped")
    with RunningNode("/stopped", SIMULATED) as process:
        client.wait_until(
            lambda: client.lifecycle_state() == LifecycleState.PRIMARY_STATE_ACTIVE,
            "the node to become active",
            START_DEADLINE,
        )
        client.wait_until(lambda: client.is_heard, "the node to listen")
        client.send_radius(RADIUS)
        client.wait_for_state(State.TRACKING)
        client.wait_until(
            lambda: client.diagnostics and "clock stands still" in client.diagnostics[-1].message,
            "a warning",
        )
        assert client.diagnostics[-1].level == b"\x01"
        assert "/clock has stopped" in process.log()
        assert not any(client.pressures)
        assert process.stop() == 0, process.log()
    client.close()


def test_the_ramp_is_the_same_whatever_the_pace_of_the_clock(simulated):
    fast = simulated.ramp()
    assert simulated.client.release().success
    assert simulated.client.rearm().success
    slow = simulated.ramp(pace=0.05)
    # Each step of 25 ms adds 1 kPa; the first may be cut short by the message that starts it.
    assert slow == pytest.approx(fast, abs=RATE * STEP * 1e-9)
    steps = np.diff(fast)
    assert steps.max() <= RATE * STEP * 1e-9 * (1.0 + 1e-9)
    assert len(fast) == pytest.approx(fast[-1] / (RATE * STEP * 1e-9), abs=2)
    assert all_finite(*simulated.client.statuses)


def test_a_clock_that_pauses_freezes_the_command_and_goes_on_without_a_jump(simulated):
    client = simulated.client
    client.send_radius(RADIUS)
    client.wait_until(lambda: list(client.status.object_radius) == [RADIUS], "the radius")
    before = [simulated.advance().pressure_command for _ in range(10)][-1]
    client.spin(0.1)
    client.pressures.clear()
    client.spin(1.0)
    assert client.pressures == []
    client.send_radius(RADIUS + 0.001)
    client.wait_until(lambda: client.pressures, "an answer to the radius")
    assert set(client.pressures) == {before}
    after = simulated.advance().pressure_command
    assert 0.0 < after - before <= RATE * STEP * 1e-9 * (1.0 + 1e-9)


def test_a_radius_grows_old_in_simulated_time_only(simulated):
    client = simulated.client
    assert client.set_parameter("radius.timeout", 0.2).successful
    client.send_radius(RADIUS)
    client.wait_for_state(State.TRACKING)
    client.spin(0.5)
    assert simulated.advance().state == State.TRACKING
    for _ in range(10):
        status = simulated.advance()
    assert (status.state, status.reason) == (State.HOLDING, Reason.RADIUS_STALE)


def test_a_pause_does_not_hold_up_a_vent(simulated):
    client = simulated.client
    simulated.ramp()
    assert client.release().success
    client.wait_until(lambda: client.pressures[-1] == 0.0, "the vent")
    client.wait_for_state(State.RELEASED)


def test_a_simulation_that_is_reset_goes_on(simulated):
    held = simulated.ramp()[-1]
    simulated.set(1_000_000_000)
    simulated.client.spin(0.1)
    for _ in range(5):
        assert simulated.advance().pressure_command == held


def test_a_leap_of_the_clock_is_no_leap_of_the_command(simulated):
    client = simulated.client
    client.send_radius(RADIUS)
    client.wait_until(lambda: list(client.status.object_radius) == [RADIUS], "the radius")
    before = simulated.advance().pressure_command
    after = simulated.advance(3_600_000_000_000).pressure_command
    # The ramp's longest step is 0.1 s.
    assert after - before <= RATE * 0.1 * (1.0 + 1e-9)


def test_a_stop_while_the_clock_pauses_vents(client, namespace):
    simulated = SimulatedTime(client)
    with RunningNode(namespace, SIMULATED) as process:
        simulated.start()
        simulated.ramp()
        client.wait_until(lambda: client.pressures[-1] > 0.0, "the ramp")
        assert process.stop() == 0, process.log()
        client.wait_until(lambda: client.pressures[-1] == 0.0, "the vent")
        client.spin(0.2)
        assert client.pressures[-1] == 0.0
