# SPDX-License-Identifier: Apache-2.0
"""A node with use_sim_time: ramp, time-outs and ticks follow /clock, whatever its pace."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from rclpy.parameter import Parameter
from ros.harness import deliver, serve
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.messages.diagnostics import CLOCK_STANDS_STILL

RATE = 4.0e4
# A little more than the node's period, so that each step of the clock lets it tick.
STEP = 25_000_000
RISE = RATE * 1e-9 * STEP * (1.0 + 1e-9)


class SimulatedTime:
    """A node in this process, and the /clock that it hears; it spins, so that its timers decide."""

    def __init__(self, node, client):
        self.node, self.client, self.now = node, client, 0
        self.commands = node.published
        self.set(use_sim_time=True)
        self.set(**{"pressure.rate_up": RATE, "radius.timeout": 3600.0})
        client.spinner.add_node(node)

    def set(self, **values):
        given = [Parameter(name, value=value) for name, value in values.items()]
        assert all(result.successful for result in self.node.set_parameters(given))

    def advance(self, step=STEP):
        """Let a time pass [ns] and return the command then."""
        self.now += step
        time = Time(sec=self.now // 10**9, nanosec=self.now % 10**9)
        deliver(self.node, "clock", Clock(clock=time))
        before = len(self.commands)
        self.client.wait_until(lambda: step <= 0 or len(self.commands) > before, "a tick")
        return self.commands[-1]

    def follow(self, radius=0.02):
        deliver(self.node, "object_radius", Float64(data=radius))

    def ramp(self):
        """Follow a radius until it is wrapped; return the commands by the way."""
        self.follow()
        commands = [0.0, self.advance()]
        while commands[-1] != commands[-2]:
            commands.append(self.advance())
        return commands

    @property
    def seen(self):
        return self.node.runtime.control.snapshot()


@pytest.fixture
def simulated(node, client):
    assert node.trigger_deactivate()
    simulated = SimulatedTime(node, client)
    assert node.trigger_activate()
    yield simulated
    client.spinner.remove_node(node)


def test_before_the_clock_runs_nothing_is_commanded(simulated):
    told, wait_until = [], simulated.client.wait_until
    simulated.node.runtime.outputs.publish_diagnostics = told.append
    simulated.follow()
    wait_until(lambda: told and CLOCK_STANDS_STILL in told[-1].status[0].message, "a warning")
    assert not any(simulated.commands)

    def runs():
        simulated.advance()
        return CLOCK_STANDS_STILL not in told[-1].status[0].message

    wait_until(runs, "the end of the warning")


def test_the_ramp_follows_the_clock_and_a_pause_holds_up_no_vent(simulated):
    simulated.advance()
    commands = simulated.ramp()
    assert np.diff(commands).max() <= RISE
    assert len(commands) == pytest.approx(commands[-1] / RISE, abs=4)
    assert serve(simulated.node, "vent", None).success
    assert simulated.commands[-1] == 0.0


def test_a_clock_that_pauses_freezes_the_command_and_goes_on_without_a_jump(simulated):
    simulated.advance()
    simulated.follow()
    before = [simulated.advance() for _ in range(10)][-1]
    count = len(simulated.commands)
    simulated.client.spin(0.5)
    assert len(simulated.commands) == count
    simulated.follow(0.021)
    assert simulated.commands[-1] == before
    after = simulated.advance()
    assert 0.0 < after - before <= RISE
    # Nor is an hour's leap one of the command: the ramp's longest step is 0.1 s.
    assert simulated.advance(3600 * 10**9) - after <= RATE * 0.1 * (1.0 + 1e-9)


def test_a_radius_grows_old_in_simulated_time_only(simulated):
    simulated.set(**{"radius.timeout": 0.2})
    simulated.advance()
    simulated.follow()
    simulated.client.spin(0.5)
    simulated.advance()
    assert simulated.seen.state is State.TRACKING
    for _ in range(10):
        simulated.advance()
    assert (simulated.seen.state, simulated.seen.refusal.reason) == (
        State.HOLDING,
        Reason.RADIUS_STALE,
    )


def test_a_simulation_that_is_reset_goes_on(simulated):
    simulated.advance()
    held = simulated.ramp()[-1]
    simulated.advance(10**9 - simulated.now)
    assert {simulated.advance() for _ in range(5)} == {held}


def test_a_stop_while_the_clock_pauses_vents(simulated):
    simulated.advance()
    assert simulated.ramp()[-1] > 0.0
    simulated.node.vent()
    assert simulated.commands[-1] == 0.0
