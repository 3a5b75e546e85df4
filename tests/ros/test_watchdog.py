# SPDX-License-Identifier: Apache-2.0
"""A node that is killed cannot vent; the regulator's watchdog does."""

import os
import signal

from ros.simulation_harness import Observer, closed_loop

from spiral_gripper_ros.control.states import Reason


def test_a_node_that_hangs_and_then_is_killed_is_survived_by_the_regulators_watchdog(namespace):
    observer = Observer(namespace)
    node, simulator = closed_loop(namespace, {"radius.timeout": 600.0, "pressure.rate_up": 2.0e5})

    def wait_for_the_wrap(what):
        observer.wait_until(
            lambda: (
                observer.grip == "perfect wrap"
                and observer.true_pressure > 3.0e4
                and observer.status.fault == Reason.NONE
            ),
            what,
        )

    with node, simulator:
        observer.wait_until_active()
        observer.wait_for_simulator()
        wait_for_the_wrap("the object to be held")
        os.kill(node.process_id, signal.SIGSTOP)
        observer.wait_until(lambda: observer.true_pressure < 10.0, "the watchdog's vent")
        observer.pressures.clear()
        os.kill(node.process_id, signal.SIGCONT)
        wait_for_the_wrap("the object to be held again")
        # The regulator does not follow the old command, and the ramp starts from nothing.
        start = observer.pressures.index(0.0)
        assert observer.pressures[start + 1] < 3.0e4 < observer.pressures[-1]
        os.kill(node.process_id, signal.SIGKILL)
        observer.wait_until(lambda: not node.running, "the node's end")
        assert node.exit_code == -signal.SIGKILL
        # Nobody has said that it should vent: the last command was the wrap's.
        observer.wait_until(lambda: observer.true_pressure < 10.0, "the watchdog's vent")
        assert observer.pressures[-1] > 3.0e4
        assert simulator.stop() == 0, simulator.log()
    observer.close()
