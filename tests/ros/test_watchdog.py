# SPDX-License-Identifier: Apache-2.0
"""A node that is killed cannot vent; the regulator's watchdog does."""

import os
import signal

from ros.simulation_harness import Observer, closed_loop

from spiral_gripper_ros.control.states import Reason


def test_a_killed_node_is_survived_by_the_regulators_watchdog(namespace):
    observer = Observer(namespace)
    node, simulator = closed_loop(namespace, {"radius_timeout": 600.0})
    with node, simulator:
        observer.wait_until_active()
        observer.wait_for_simulator()
        observer.wait_until(
            lambda: observer.grip == "perfect wrap" and observer.true_pressure > 3.0e4,
            "the object to be held",
        )
        os.kill(node.process_id, signal.SIGKILL)
        observer.wait_until(lambda: not node.running, "the node's end")
        assert node.exit_code == -signal.SIGKILL
        # Nobody has said that it should vent: the last command was the wrap's.
        observer.wait_until(lambda: observer.true_pressure < 10.0, "the watchdog's vent")
        assert observer.pressures[-1] > 3.0e4
        assert simulator.stop() == 0, simulator.log()
    observer.close()


def test_a_node_that_hangs_is_survived_too_and_may_come_back(namespace):
    observer = Observer(namespace)
    node, simulator = closed_loop(namespace, {"radius_timeout": 600.0})
    with node, simulator:
        observer.wait_until_active()
        observer.wait_for_simulator()
        observer.wait_until(lambda: observer.grip == "perfect wrap", "the object to be held")
        os.kill(node.process_id, signal.SIGSTOP)
        observer.wait_until(lambda: observer.true_pressure < 10.0, "the watchdog's vent")
        os.kill(node.process_id, signal.SIGCONT)
        observer.wait_until(
            lambda: (
                observer.grip == "perfect wrap" and observer.status.pressure_fault == Reason.NONE
            ),
            "the object to be held again",
        )
    observer.close()
