# SPDX-License-Identifier: Apache-2.0
"""A running node with use_sim_time: ramp, time-outs and ticks follow /clock, whatever its pace."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from lifecycle_msgs.msg import State as LifecycleState
from rclpy.qos import QoSProfile, ReliabilityPolicy
from ros.harness import START_DEADLINE, Client, RunningNode
from rosgraph_msgs.msg import Clock

from spiral_gripper_ros.control.states import Reason, State

RADIUS = 0.02
RATE = 4.0e4
SECOND = 1_000_000_000
# A little more than the node's period, so that each step of the clock lets it tick.
STEP = SECOND // 40
RISE = RATE * STEP / SECOND * (1.0 + 1e-9)
SIMULATED = {"use_sim_time": "true", "pressure.rate_up": RATE, "radius.timeout": 3600.0}


class SimulatedTime:
    """Publishes /clock, one step at a time, and waits until the node has lived through it."""

    def __init__(self, client):
        self.client, self.now = client, 0
        reliable = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
        self._clock = client.create_publisher(Clock, "/clock", reliable)

    def set(self, now):
        self.now = now
        self._clock.publish(Clock(clock=Time(sec=now // SECOND, nanosec=now % SECOND)))

    def advance(self, step=STEP, pace=0.0):
        """Let ``step`` ns pass in at least ``pace`` s of real time; return the status then."""
        now = self.now + step
        # Nodes listen to /clock with best effort: the same time again is no other.
        self.client.wait_until(
            lambda: (
                self.set(now),
                self.client.statuses
                and self.client.status.header.stamp
                == Time(sec=now // SECOND, nanosec=now % SECOND),
            )[1],
            f"a status at {now} ns",
        )
        self.client.spin(pace)
        return self.client.status

    def start(self):
        """Let the clock run until the node is active and ticks, and hears us."""
        wait_until_active(self.client)

        def goes_on():
            self.set(self.now + STEP)
            self.client.spin(0.01)
            return self.client.statuses and self.client.pressures and self.client.is_heard

        self.client.wait_until(goes_on, "a status")
        self.client.spin(0.1)
        self.advance()

    def send_radius(self, radius=RADIUS):
        self.client.send_radius(radius)
        self.client.wait_until(lambda: list(self.client.status.object_radius) == [radius], "it")

    def ramp(self, pace=0.0):
        """Send a radius and advance until it is wrapped; return the commands by the way."""
        self.send_radius()
        commands, target = [0.0], 1.0
        while commands[-1] != target:
            status = self.advance(pace=pace)
            commands.append(status.pressure_command)
            target = status.pressure_target
            assert len(commands) < 1000
        return commands


def wait_until_active(client):
    client.wait_until(
        lambda: client.lifecycle_state() == LifecycleState.PRIMARY_STATE_ACTIVE,
        "the node to become active",
        START_DEADLINE,
    )


@pytest.fixture(scope="module")
def node():
    client = Client("/simulated")
    simulated = SimulatedTime(client)
    with RunningNode("/simulated", SIMULATED) as process:
        simulated.start()
        simulated.process = process
        yield simulated
    client.close()


@pytest.fixture
def simulated(node):
    """The node, freshly activated, at a time that it has never seen before."""
    client = node.client
    assert client.transition("deactivate")
    client.change("radius.timeout", 3600.0)
    node.set(node.now + SECOND)
    client.spin(0.1)
    assert client.transition("activate")
    client.wait_for_state(State.WAITING)
    client.forget()
    node.advance()
    return node


def test_before_the_clock_runs_nothing_is_commanded():
    client = Client("/stopped")
    with RunningNode("/stopped", SIMULATED) as process:
        wait_until_active(client)
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
    client.close()


def test_the_ramp_is_the_same_at_any_pace_of_the_clock_and_a_pause_holds_up_no_vent(simulated):
    fast = simulated.ramp()
    # A pause does not hold up a vent.
    assert simulated.client.release().success
    simulated.client.wait_for_vent()
    simulated.client.wait_for_state(State.RELEASED)
    assert simulated.client.rearm().success
    slow = simulated.ramp(pace=0.05)
    # Each step of 25 ms adds 1 kPa; the first may be cut short by the message that starts it.
    assert slow == pytest.approx(fast, abs=RISE)
    assert np.diff(fast).max() <= RISE
    assert len(fast) == pytest.approx(fast[-1] / RISE, abs=3)


def test_a_clock_that_pauses_freezes_the_command_and_goes_on_without_a_jump(simulated):
    client = simulated.client
    simulated.send_radius()
    before = [simulated.advance().pressure_command for _ in range(10)][-1]
    client.spin(0.1)
    client.pressures.clear()
    client.spin(1.0)
    assert client.pressures == []
    client.send_radius(RADIUS + 0.001)
    client.wait_until(lambda: client.pressures, "an answer to the radius")
    assert set(client.pressures) == {before}
    after = simulated.advance().pressure_command
    assert 0.0 < after - before <= RISE
    # Nor is an hour's leap one of the command: the ramp's longest step is 0.1 s.
    assert simulated.advance(3600 * SECOND).pressure_command - after <= RATE * 0.1 * (1.0 + 1e-9)


def test_a_radius_grows_old_in_simulated_time_only(simulated):
    simulated.client.change("radius.timeout", 0.2)
    simulated.send_radius()
    simulated.client.spin(0.5)
    assert simulated.advance().state == State.TRACKING
    status = [simulated.advance() for _ in range(10)][-1]
    assert (status.state, status.reason) == (State.HOLDING, Reason.RADIUS_STALE)


def test_a_simulation_that_is_reset_goes_on(simulated):
    held = simulated.ramp()[-1]
    simulated.set(SECOND)
    simulated.client.spin(0.1)
    for _ in range(5):
        assert simulated.advance().pressure_command == held


def test_a_stop_while_the_clock_pauses_vents(simulated):
    """The last of these tests: there is no node any more."""
    client, process = simulated.client, simulated.process
    simulated.ramp()
    assert process.stop() == 0, process.log()
    client.wait_for_vent()
    client.spin(0.2)
    assert client.pressures[-1] == 0.0
