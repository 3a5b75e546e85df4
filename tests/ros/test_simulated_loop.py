# SPDX-License-Identifier: Apache-2.0
"""Node and simulator together, as two processes: the loop that a real gripper closes."""

import os
import signal

import pytest
from ros.harness import ALL, FAST_RAMP, START_DEADLINE, Client, RunningNode
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.process.node_process import SIMULATOR


class Loop(Client):
    """The two processes, and a client that hears what is really there besides."""

    def __init__(self, namespace, clock, watchdog, **node):
        super().__init__(namespace)
        self.truths, self.grips = [], []
        self.create_subscription(Float64, "simulated/pressure", self.truths.append, ALL)
        self.create_subscription(String, "simulated/grip", self.grips.append, ALL)
        node = {**FAST_RAMP, "radius.timeout": 600.0, "use_sim_time": clock, **node}
        simulator = {"radius": 0.02, "pressure_noise": 0.0, "estimate_noise": 0.0}
        simulator.update(watchdog_timeout=watchdog, publish_clock=clock)
        self.node = RunningNode(namespace, node)
        self.simulator = RunningNode(namespace, simulator, module=SIMULATOR)

    def inject(self, name):
        assert self.call(Trigger, f"simulated_regulator/{name}", None, START_DEADLINE).success

    def hold(self):
        """Wait until the object is wrapped, and the node knows it from what is measured."""

        def is_held():
            status = self.status
            return (
                self.grips
                and self.grips[-1].data == "perfect wrap"
                and status is not None
                and status.wrapped
                and status.fault == Reason.NONE
                and status.measured_pressure
                and abs(self.truths[-1].data - status.pressure_command) < 10.0
            )

        self.wait_until(is_held, "the object to be held", START_DEADLINE)

    def vent(self):
        self.wait_until(lambda: self.truths[-1].data < 10.0, "the vent")


@pytest.fixture
def closed(namespace):
    """Closes a loop, which ends with the test."""
    loops = []

    def close(*given, **node):
        loops.append(Loop(namespace, *given, **node))
        loops[0].hold()
        return loops[0]

    yield close
    for loop in loops:
        with loop.node, loop.simulator:
            assert not loop.node.running or loop.node.stop() == 0
            assert loop.simulator.stop() == 0
        loop.close()


# A node that a busy machine holds up for a moment is not taken for a dead one.
@pytest.mark.parametrize("clock", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_link_that_comes_back_inflates_nothing_before_somebody_has_looked(closed, clock):
    loop = closed(clock, 2.0, **{"pressure.fault_policy": "vent"})
    # A machine's clock is decades ahead of the simulator's.
    assert (loop.status.header.stamp.sec < 1e6) is clock
    loop.inject("inject_lost_link")
    loop.wait_for_state(State.FAULT, Reason.PRESSURE_LOST)
    loop.vent()
    loop.inject("clear_fault")
    loop.wait_until(lambda: loop.status.fault == Reason.NONE, "the end of the fault")
    loop.truths.clear()
    loop.wait_until(lambda: len(loop.truths) >= 10, "the truth")
    assert max(message.data for message in loop.truths) < 10.0
    assert loop.rearm().success
    loop.hold()


def test_a_node_that_hangs_and_then_is_killed_is_survived_by_the_regulators_watchdog(closed):
    loop = closed(False, 0.5, **{"pressure.rate_up": 2.0e5})
    os.kill(loop.node.pid, signal.SIGSTOP)
    loop.vent()
    loop.pressures.clear()
    os.kill(loop.node.pid, signal.SIGCONT)
    loop.hold()
    # The regulator does not follow the old command, and the ramp starts from nothing.
    start = loop.pressures.index(0.0)
    assert loop.pressures[start + 1] < 3.0e4 < loop.pressures[-1]
    os.kill(loop.node.pid, signal.SIGKILL)
    loop.vent()
    # Nobody has said that it should vent: the last command was the wrap's.
    assert loop.pressures[-1] > 3.0e4
