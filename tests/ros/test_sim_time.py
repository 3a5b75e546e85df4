# SPDX-License-Identifier: Apache-2.0
"""A node with use_sim_time: ramp, time-outs and ticks follow /clock, whatever its pace."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from ros.grasp_goals import Goals, refused
from ros.harness import deliver, serve
from ros.local_nodes import change, offer, state_of
from rosgraph_msgs.msg import Clock

from spiral_gripper_msgs.action import Release
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
        client.spinner.add_node(node)

    def hear(self, nanoseconds):
        time = Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
        deliver(self.node, "clock", Clock(clock=time))

    def advance(self, step=STEP, count=1):
        """Let a time pass [ns], again and again, and return the command then."""
        for _ in range(count):
            self.now += step
            self.hear(self.now)
            self.wait_for_tick(len(self.commands) + (step > 0))
        return self.commands[-1]

    def wait_for_tick(self, count):
        self.client.wait_until(lambda: len(self.commands) >= count, "a tick")

    def ramp(self):
        """Follow a radius until it is wrapped; return the commands by the way."""
        self.advance()
        offer(self.node)
        commands = [0.0, self.advance()]
        while commands[-1] != commands[-2]:
            commands.append(self.advance())
        return commands


@pytest.fixture
def simulated(node, client):
    assert node.trigger_deactivate()
    change(node, use_sim_time=True, pressure__rate_up=RATE, radius__timeout=3600.0)
    simulated = SimulatedTime(node, client)
    assert node.trigger_activate()
    yield simulated
    client.spinner.remove_node(node)


def test_before_the_clock_runs_nothing_is_commanded(simulated):
    told, wait_until = [], simulated.client.wait_until
    simulated.node.runtime.outputs.publish_diagnostics = told.append

    def is_told():
        return told and CLOCK_STANDS_STILL in told[-1].status[0].message

    offer(simulated.node)
    wait_until(is_told, "a warning")
    assert not any(simulated.commands)
    wait_until(lambda: simulated.advance() is not None and not is_told(), "the warning's end")


def test_the_ramp_follows_the_clock_through_a_reset_and_a_stop_while_it_pauses_vents(simulated):
    commands = simulated.ramp()
    assert np.diff(commands).max() <= RISE
    assert len(commands) == pytest.approx(commands[-1] / RISE, abs=4)
    simulated.advance(10**9 - simulated.now)
    change(simulated.node, radius__timeout=0.2)
    offer(simulated.node)
    simulated.client.spin(0.5)  # a radius grows old in simulated time only
    for count, seen in (
        (5, (State.TRACKING, Reason.NONE)),
        (5, (State.HOLDING, Reason.RADIUS_STALE)),
    ):
        assert simulated.advance(count=count) == commands[-1]
        assert state_of(simulated.node) == seen
    simulated.node.vent()
    assert simulated.commands[-1] == 0.0


def test_a_clock_that_pauses_freezes_the_command_and_goes_on_without_a_jump(simulated):
    simulated.advance()
    offer(simulated.node)
    before = simulated.advance(count=10)
    count = len(simulated.commands)
    simulated.client.spin(0.5)
    assert len(simulated.commands) == count
    offer(simulated.node, 0.021)
    assert len(simulated.commands) == count
    assert simulated.node.runtime.control.snapshot().radius == 0.021
    after = simulated.advance()
    assert 0.0 < after - before <= RISE
    # Nor is an hour's leap one of the command, or a stall: the ramp's longest step is 0.1 s.
    leapt = simulated.advance(3600 * 10**9)
    assert leapt - after == pytest.approx(RATE * 0.1)
    assert serve(simulated.node, "vent", None).success
    assert simulated.commands[-1] == 0.0


def test_a_bad_sample_of_the_clock_does_not_let_go(simulated, capfd):
    simulated.advance()
    before = simulated.node.runtime.now()
    offer(simulated.node)
    simulated.hear(-7 * 10**9)
    assert "Seconds value must not be negative" in capfd.readouterr().err
    assert state_of(simulated.node) == (State.TRACKING, Reason.NONE)
    simulated.advance(10**9)
    assert simulated.node.runtime.now() == pytest.approx(before + 1.0)


def test_a_goal_and_its_cancel_are_commanded_at_once_not_at_the_next_tick(simulated):
    """The clock stands still: no tick comes."""
    simulated.advance()
    goals, before = Goals(simulated.client), len(simulated.commands)
    goal = goals.grasp(0.02)
    simulated.wait_for_tick(before + 1)
    assert state_of(simulated.node)[0] is State.GRASPING
    assert goal.cancel()
    assert len(simulated.commands) == before + 2
    assert goal.end()[1].reason == Reason.GRASP_CANCELED
    goals.close()


def test_a_release_ends_although_the_clock_stands_still(simulated):
    simulated.advance()
    goals = Goals(simulated.client, Release, "release")
    goal = goals.send(Release.Goal(timeout=[1.0]))
    assert "the clock stands still" in refused(goal, Reason.PRESSURE_LOST)
    assert simulated.commands[-1] == 0.0
    goals.close()
