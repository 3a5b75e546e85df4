# SPDX-License-Identifier: Apache-2.0
"""Every process that runs tests is alone on its ROS domain and on this machine."""

import os
from contextlib import suppress

from ros.programs import PROGRAM, start

from spiral_gripper_ros.planning.planner import GripperPlanner

# Domain 101 is the last whose ports lie outside Linux' range for outgoing connections. Parallel
# workers of one run (gw0, gw1, ...) take neighboring domains.
os.environ["ROS_DOMAIN_ID"] = str(
    1
    + (8 * os.getppid() + int(os.environ.get("PYTEST_XDIST_WORKER", "gw7").removeprefix("gw")))
    % 101
)
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"

import itertools
import signal
import warnings

with warnings.catch_warnings():  # its parser imports a module that Python deprecates
    warnings.simplefilter("ignore", DeprecationWarning)
    import rosidl_generator_py  # noqa: F401

import hypothesis
import pytest
import rclpy
from rclpy.signals import SignalHandlerOptions
from ros.control_bench import Bench
from ros.harness import (
    BARE,
    DEADLINE,
    FAST_RAMP,
    PATIENT,
    START_DEADLINE,
    Client,
    RunningNode,
    tick_until,
)
from ros.local_nodes import change, offer, parameters

from spiral_core import WrapCurve
from spiral_gripper import load_gripper
from spiral_gripper_ros.client import SpiralGripper
from spiral_gripper_ros.control import grip_control
from spiral_gripper_ros.node.gripper_node import GripperNode
from spiral_gripper_ros.runtime.runtime import Outputs

# For a long run of test_control_machine.py: pytest --hypothesis-profile=fuzz.
hypothesis.settings.register_profile("fuzz", max_examples=1500, stateful_step_count=100)

_numbers = itertools.count(1)


@pytest.fixture(scope="session")
def gripper():
    return load_gripper("paper_design_70")


@pytest.fixture(scope="session")
def curve(gripper):
    return WrapCurve(gripper)


@pytest.fixture(scope="session")
def planner(gripper):
    return GripperPlanner(gripper)


@pytest.fixture(scope="session", autouse=True)
def ros():
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    yield
    rclpy.try_shutdown()


@pytest.fixture
def namespace():
    return f"/test_{next(_numbers)}"


@pytest.fixture
def client(namespace):
    client = Client(namespace)
    yield client
    client.close()


@pytest.fixture(scope="module")
def shared_node():
    """A node process that the tests of one module share."""
    with RunningNode(f"/shared_{next(_numbers)}") as node:
        yield node
        assert node.stop() == 0


@pytest.fixture(scope="module")
def shared(shared_node):
    """A client of the shared node, for one module as well."""
    client = Client(shared_node.namespace)
    client.wait_until_active()
    yield client
    client.close()


@pytest.fixture
def active(shared):
    """The shared node, freshly configured and activated, with known parameters."""
    shared.restore()
    return shared


@pytest.fixture
def node(namespace):
    """A node in this process, whose commands are noted instead of published.

    It commands when a test lets it, however slow the machine is: that is no stall.
    """
    node = GripperNode(namespace=namespace, parameter_overrides=parameters(**BARE))
    node.published = []
    node.runtime.outputs.publish_pressure = node.published.append
    assert node.start()
    with pytest.MonkeyPatch.context() as patient:
        patient.setattr(grip_control, "UNMEASURED_GAP", 600.0)
        yield node
        node.vent()
    node.destroy_node()


@pytest.fixture
def wrapped(node, monkeypatch):
    """That node wraps an object of 20 mm, and is drawn."""
    monkeypatch.setattr(Outputs, "markers_are_wanted", True)
    change(node, **FAST_RAMP, **PATIENT)
    offer(node)
    tick_until(node, lambda: node.runtime.control.snapshot().wrapped)


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture(scope="module")
def connection(shared):
    with SpiralGripper(shared.get_namespace(), answer_timeout=DEADLINE) as gripper:
        gripper.wait_until_active(START_DEADLINE)
        yield gripper


@pytest.fixture
def grip(active, connection):
    active.change("pressure.settle_time", 0.1)
    connection.wait_until_active(DEADLINE)
    return connection


@pytest.fixture
def slow(active, grip):
    active.change("pressure.rate_up", 500.0)
    return grip


@pytest.fixture
def nowhere(namespace):
    """A client of a node that does not exist, and does not wait for it long."""
    with SpiralGripper(namespace, answer_timeout=0.2) as gripper:
        yield gripper


@pytest.fixture
def simulation(namespace):
    """`spiral-gripper simulate` in a process group of its own, as a shell starts it."""
    with start(PROGRAM, "simulate", "--radius", "20 mm", "--namespace", namespace) as process:
        yield process
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
