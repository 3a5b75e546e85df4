# SPDX-License-Identifier: Apache-2.0
"""The simulator as a process, and a client that hears what it and the node publish."""

import time

from geometry_msgs.msg import PoseArray
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from ros.harness import FAST_RAMP, START_DEADLINE, Client, RunningNode
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.messages.qos import LATEST
from spiral_gripper_ros.process.node_process import SIMULATOR

REGULATOR = "simulated_regulator"
# No noise, so that figures can be compared; fast estimates, so that the tests are.
QUIET = {"pressure_noise": 0.0, "pressure_resolution": 0.0, "estimate_noise": 0.0}
RADIUS = 0.02
COMMAND_PERIOD = 0.02
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
        self.measured, self.radii, self.truths, self.true_radii = [], [], [], []
        self.grips, self.shapes, self.clocks = [], [], []
        self._commands = self.create_publisher(Float64, "pressure_command", LATEST)
        for kind, topic, received in (
            (Float64, "measured_pressure", self.measured),
            (Float64, "object_radius", self.radii),
            (Float64, "simulated/pressure", self.truths),
            (Float64, "simulated/object_radius", self.true_radii),
            (String, "simulated/grip", self.grips),
            (PoseArray, "simulated/backbone", self.shapes),
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

    def command(self, pressure):
        """Command a pressure as a node would."""
        self._commands.publish(Float64(data=pressure))

    def command_until(self, pressure, condition, what):
        """Keep commanding a pressure, as often as a node does, until a condition holds."""
        due = time.monotonic()

        def commanded():
            nonlocal due
            if time.monotonic() >= due:
                due = time.monotonic() + COMMAND_PERIOD
                self.command(pressure)
            return condition()

        self.wait_until(commanded, what)

    def wait_for_simulator(self):
        """Wait until the simulator is heard on each topic that never falls silent, and hears us."""
        heard = (self.grips, self.measured, self.truths, self.true_radii, self.shapes)
        self.wait_until(
            # Who listens to our commands besides ourselves is the regulator.
            lambda: all(heard) and self._commands.get_subscription_count() >= 2,
            "the simulator",
            START_DEADLINE,
        )

    def wait_for_silence(self, silent, steady, what):
        """Wait until nothing comes of one topic while 20 messages of another do."""

        def is_silent():
            if silent:
                silent.clear()
                steady.clear()
            return len(steady) >= 20

        steady.clear()
        self.wait_until(is_silent, what)

    @property
    def pressure(self):
        """The pressure that is measured [Pa]."""
        return self.measured[-1].data if self.measured else None

    @property
    def true_pressure(self):
        """The pressure that is really there [Pa]."""
        return self.truths[-1].data if self.truths else None

    def next_true_pressure(self):
        """Wait for what is told from now on, and return the pressure that is there then [Pa]."""
        self.spin()
        self.truths.clear()
        self.wait_until(lambda: len(self.truths) >= 3, "the truth")
        return self.true_pressure

    @property
    def grip(self):
        return self.grips[-1].data if self.grips else None

    def inject(self, fault):
        """Inject a fault by its service; "none" clears it."""
        name = "clear_fault" if fault == "none" else f"inject_{fault}"
        answer = self.call(Trigger, f"{REGULATOR}/{name}")
        assert answer.success, answer.message

    def set_simulated(self, node, **values):
        """Set parameters of one of the simulator's nodes; return the results."""
        parameters = [
            Parameter(name, value=value).to_parameter_msg() for name, value in values.items()
        ]
        request = SetParameters.Request(parameters=parameters)
        return self.call(SetParameters, f"{node}/set_parameters", request).results


def closed_loop(namespace, node=None, simulator=None):
    """The processes of a node and of a simulator in one namespace, without noise."""
    return (
        RunningNode(namespace, {**FAST_RAMP, **(node or {})}),
        RunningSimulator(namespace, {"radius": RADIUS, **QUIET, **(simulator or {})}),
    )


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec
