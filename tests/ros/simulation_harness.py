# SPDX-License-Identifier: Apache-2.0
"""The simulator as a process, and a client that hears what it and the node publish."""

from rclpy.qos import QoSProfile, ReliabilityPolicy
from ros.harness import FAST_RAMP, START_DEADLINE, Client, RunningNode
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.process.node_process import SIMULATOR

REGULATOR = "simulated_regulator"
# No noise, so that figures can be compared; fast estimates, so that the tests are.
QUIET = {"pressure_noise": 0.0, "pressure_resolution": 0.0, "estimate_noise": 0.0}
RADIUS = 0.02
# Of a sensor's topic every message: a listener that is held up for a while hears all of it later.
ALL = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)


class RunningSimulator(RunningNode):
    """The same, of the simulator."""

    def __init__(self, namespace, parameters=None):
        super().__init__(namespace, parameters, module=SIMULATOR)


class Observer(Client):
    """A client that remembers, besides, what the simulator publishes."""

    def __init__(self, namespace):
        super().__init__(namespace)
        self.radii, self.truths, self.grips, self.clocks = [], [], [], []
        for kind, topic, received in (
            (Float64, "object_radius", self.radii),
            (Float64, "simulated/pressure", self.truths),
            (String, "simulated/grip", self.grips),
            (Clock, "/clock", self.clocks),
        ):
            self.create_subscription(kind, topic, received.append, ALL)

    def wait_until_active(self, deadline=START_DEADLINE):
        """Wait for a status and a command of the active node, which hears the simulator's radii."""
        self.statuses.clear()
        self.wait_until(
            lambda: (
                self.status is not None and self.status.state != State.INACTIVE and self.pressures
            ),
            "the node to become active",
            deadline,
        )

    def wait_for_simulator(self):
        """Wait until the simulator is heard on each topic that never falls silent."""
        self.wait_until(lambda: self.grips and self.truths, "the simulator", START_DEADLINE)

    @property
    def true_pressure(self):
        """The pressure that is really there [Pa]."""
        return self.truths[-1].data if self.truths else None

    def next_true_pressures(self, count=3):
        """Wait for what is told from now on, and return the pressures that are there then [Pa]."""
        self.spin()
        self.truths.clear()
        self.wait_until(lambda: len(self.truths) >= count, "the truth")
        return {message.data for message in self.truths}

    @property
    def grip(self):
        return self.grips[-1].data if self.grips else None

    def inject(self, fault):
        """Inject a fault by its service; "none" clears it."""
        name = "clear_fault" if fault == "none" else f"inject_{fault}"
        assert self.call(Trigger, f"{REGULATOR}/{name}").success


def closed_loop(namespace, node=None, simulator=None):
    """The processes of a node and of a simulator in one namespace, without noise."""
    return (
        RunningNode(namespace, {**FAST_RAMP, **(node or {})}),
        RunningSimulator(namespace, {"radius": RADIUS, **QUIET, **(simulator or {})}),
    )


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec
