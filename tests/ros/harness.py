# SPDX-License-Identifier: Apache-2.0
"""A client process's side of the tests: what a user's node would do, with deadlines."""

import math
import re
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress

from geometry_msgs.msg import PoseArray, Vector3, Vector3Stamped
from lifecycle_msgs.msg import State as LifecycleState
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import ListParameters, SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter as PythonParameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float64, Header
from std_srvs.srv import Trigger

from spiral_gripper_msgs.msg import GripStatus, ObjectToWrap, Wrap
from spiral_gripper_msgs.srv import DesignGripper, PlanWrap
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.parameters.table import PARAMETERS
from spiral_gripper_ros.process.node_process import NODE as NODE_MODULE
from spiral_gripper_ros.process.node_process import NodeProcess

# Only a failure waits so long: a machine with many workers on few cores takes its time.
DEADLINE = 240.0
# The first start may have to compile, a design its process that gives way to all others.
START_DEADLINE = DESIGN_DEADLINE = 600.0
# The middleware drops an answer where the server has not discovered the client yet, which takes its
# time under load: what may be asked twice is asked again after so long.
ASK_AGAIN = 5.0
ASKED_AGAIN = (Trigger, GetState, ListParameters)
NODE = "spiral_gripper"
# The node's rate in these tests: fast, so that they are.
FAST_RAMP = {"pressure.rate_up": 2.0e6, "pressure.rate_down": 2.0e6}
# Nor does a message grow old because the machine is slow; tests of the time-outs set their own.
PATIENT = {
    "radius.timeout": 600.0,
    "measured_pressure.timeout": 600.0,
    "grasp.timeout": 600.0,
}
# The pressure is that of the bare wrap, which the core answers, and no grip is computed beside the
# tests; those of the grip set their own.
BARE = {"grip.ratio": 1.0, "grip.contact": False}
ALL = QoSProfile(depth=1000)
ALL_AND_LATCHED = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)

LATCHED = {
    "backbone": PoseArray,
    "measured_backbone": PoseArray,
    "status": GripStatus,
    "wrap": Wrap,
}
SENT = {"object_radius": Float64, "gravity": Vector3Stamped, "measured_pressure": Float64}


class RunningNode(NodeProcess):
    """A process of ours whose log can be read while it is written: each line goes to its end."""

    def __init__(self, namespace, parameters=None, **options):
        self.namespace = namespace
        self._output = tempfile.TemporaryFile("a+")  # noqa: SIM115
        if options.get("module", NODE_MODULE) == NODE_MODULE:
            parameters = BARE | dict(parameters or {})
        super().__init__(namespace, parameters, output=self._output, **options)

    def log(self):
        self._output.seek(0)
        return self._output.read()

    def stop(self, number=signal.SIGINT):
        """Stop as a user does, but with patience: a busy machine is slow in tearing DDS down."""
        self.send_signal(number)
        with suppress(subprocess.TimeoutExpired):
            self.wait(DEADLINE)
        return super().stop(number)

    def __exit__(self, kind, *details):
        super().__exit__(kind, *details)
        if kind is not None:
            sys.stdout.write(self.log())
        self._output.close()


class Spinner(SingleThreadedExecutor):
    """An executor that knows whether it has found something to do.

    Attributes:
        idle: whether nothing was waiting when it last looked.
    """

    idle = found = False

    def wait_for_ready_callbacks(self, *arguments, **options):
        # A look ends with a time-out too after it has found one message of each topic.
        self.idle, self.found = not self.found, False
        callback = super().wait_for_ready_callbacks(*arguments, **options)
        self.idle, self.found = False, True
        return callback


class Client(Node):
    """Publishes radii, gravity and measured pressures, calls every service, remembers all answers.

    The newest of what the node latches is heard however late DDS discovers it, and so can be waited
    for. Every command and every status is heard only from ``wait_until_active`` on.

    While ``regulator`` is set it answers each command with the measured pressure that it returns.
    ``spinner`` spins it, and what else is added to that.
    """

    def __init__(self, namespace):
        super().__init__("test_client", namespace=namespace)
        self.pressures, self.regulator = [], None
        self.heard = {topic: [] for topic in LATCHED}
        self.statuses = self.heard["status"]
        for topic, kind in LATCHED.items():
            self.create_subscription(kind, topic, self.heard[topic].append, ALL_AND_LATCHED)
        self.create_subscription(Float64, "pressure_command", self._on_pressure, ALL)
        self._senders = {
            topic: self.create_publisher(kind, topic, 1) for topic, kind in SENT.items()
        }
        self._calls, self.spinner = {}, Spinner()
        self.spinner.add_node(self)

    def close(self):
        self.spinner.shutdown()
        self.destroy_node()

    # --- waiting -------------------------------------------------------------------------------

    def spin(self, duration=0.0):
        """Handle what arrives within a time, and all that has arrived by then."""
        end = time.monotonic() + duration
        while True:
            self.spinner.spin_once(timeout_sec=max(0.0, min(0.02, end - time.monotonic())))
            if time.monotonic() >= end and self.spinner.idle:
                return

    def wait_until(self, condition, what, deadline=DEADLINE):
        end = time.monotonic() + deadline
        while not condition():
            assert time.monotonic() < end, f"not within {deadline} s: {what}; last: {self.status}"
            self.spinner.spin_once(timeout_sec=0.02)

    def wait_until_active(self, deadline=START_DEADLINE):
        """Wait for a status and a command of the active node, and until it hears us."""
        self.statuses.clear()

        def is_active():
            # All that is sent here arrives: DDS discovers each topic in a time of its own.
            is_heard = self.pressures and all(self._listeners())
            return self.statuses and self.status.state != State.INACTIVE and is_heard

        self.wait_until(is_active, "the node to become active", deadline)

    def _listeners(self):
        return [sender.get_subscription_count() for sender in self._senders.values()]

    def hear_more(self, count=5):
        """Wait until the node has said so many times more what it commands, and why."""
        expected = [(heard, len(heard) + count) for heard in (self.pressures, self.statuses)]
        self.wait_until(lambda: all(len(heard) >= length for heard, length in expected), "more")

    def wait_for_state(self, state, reason=None):
        def is_there():
            seen = self.status
            return seen and seen.state == state and reason in (None, seen.reason)

        self.wait_until(is_there, f"{state!r}, {reason!r}")
        return self.status

    def wait_for_vent(self):
        self.wait_until(lambda: self.pressures[-1:] == [0.0], "the vent")

    # --- messages ------------------------------------------------------------------------------

    @property
    def status(self):
        return self.statuses[-1] if self.statuses else None

    def _on_pressure(self, message):
        self.pressures.append(message.data)
        if self.regulator is not None:
            self.send_measured(self.regulator(message.data))

    def send_radius(self, radius):
        self._senders["object_radius"].publish(Float64(data=radius))

    def send_gravity(self, gravity, frame_id=""):
        vector = Vector3(**dict(zip("xyz", gravity, strict=True)))
        message = Vector3Stamped(header=Header(frame_id=frame_id), vector=vector)
        self._senders["gravity"].publish(message)

    def send_measured(self, pressure):
        self._senders["measured_pressure"].publish(Float64(data=pressure))

    def wrap(self, radius):
        """Offer a radius until its wrap pressure is commanded and heard; return the status then."""

        def is_wrapped():
            self.send_radius(radius)
            self.spin(0.02)
            seen = self.status
            if seen is None or list(seen.object_radius) != [radius]:
                return False
            commands = {seen.pressure_target, seen.pressure_command, *self.pressures[-1:]}
            return len(commands) == 1 and seen.pressure_target > 0.0

        self.wait_until(is_wrapped, f"{radius} to be wrapped")
        return self.status

    # --- services ------------------------------------------------------------------------------

    def call(self, kind, name, request=None, deadline=DEADLINE):
        if name not in self._calls:
            self._calls[name] = self.create_client(kind, name)
        service = self._calls[name]
        assert service.wait_for_service(deadline), f"no service {name}"
        futures, due = [], time.monotonic()

        def answered():
            nonlocal due
            if time.monotonic() >= due:
                futures.append(service.call_async(request or kind.Request()))
                due = time.monotonic() + (ASK_AGAIN if kind in ASKED_AGAIN else math.inf)
            return any(future.done() for future in futures)

        self.wait_until(answered, f"an answer of {name}", deadline)
        return next(future.result() for future in futures if future.done())

    def release(self):
        return self.call(Trigger, "vent")

    def rearm(self):
        return self.call(Trigger, "rearm")

    def plan_wrap(self, radius, deadline=DEADLINE, **fields):
        """Return the answer about one object; those of the message ObjectToWrap are its own."""
        request = plan_request([radius], **fields)
        return self.call(PlanWrap, "plan_wrap", request, deadline).plans[0]

    def transition(self, name):
        """Ask for a lifecycle transition by its name; return whether it succeeded."""
        number = getattr(Transition, f"TRANSITION_{name.upper()}")
        request = ChangeState.Request(transition=Transition(id=number))
        return self.call(ChangeState, f"{NODE}/change_state", request).success

    def lifecycle_state(self):
        return self.call(GetState, f"{NODE}/get_state").current_state.id

    def change(self, name, value):
        """Set one parameter, which must not be refused."""
        (result,) = self.set_parameters({name: value})
        assert result.successful, (name, result.reason)

    def set_parameters(self, values):
        """Set parameters one after the other, in one call; return the results."""
        messages = [PythonParameter(n, value=v).to_parameter_msg() for n, v in values.items()]
        request = SetParameters.Request(parameters=messages)
        return self.call(SetParameters, f"{NODE}/set_parameters", request).results

    def restore(self):
        """Bring the node to a fresh activation with known parameters; forget what was before."""
        self.regulator = None
        if self.lifecycle_state() == LifecycleState.PRIMARY_STATE_ACTIVE:
            assert self.transition("deactivate")
        if self.lifecycle_state() == LifecycleState.PRIMARY_STATE_INACTIVE:
            assert self.transition("cleanup")
        # What listens afterwards is not what listened before.
        self.wait_until(lambda: not any(self._listeners()), "the end of what listens")
        values = {spec.name: spec.default for spec in PARAMETERS if not spec.read_only}
        values |= FAST_RAMP | PATIENT | BARE | {"gravity.vector": [9.80665, 0.0, 0.0]}
        assert all(result.successful for result in self.set_parameters(values))
        assert self.transition("configure")
        assert self.transition("activate")
        self.wait_until_active()
        self.spin(0.05)
        self.forget()
        self.hear_more(1)

    def forget(self):
        """Forget everything that was received."""
        for received in (self.pressures, *self.heard.values()):
            received.clear()


def wait_until(condition):
    """Poll a condition until it holds."""
    deadline = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def _lists(fields):
    """Return fields of a request; single numbers stand for lists of one."""
    return {n: [v] if isinstance(v, float) else v for n, v in fields.items()}


def design_request(smallest, largest, **fields):
    """Return a request of `design_gripper`."""
    return DesignGripper.Request(
        object_radius_min=smallest, object_radius_max=largest, **_lists(fields)
    )


def plan_request(radii, **fields):
    """Return a request of `plan_wrap` about objects that have all but the radius in common."""
    rest = {"backbone": True} | _lists(fields)
    own = {n: rest.pop(n) for n in ObjectToWrap.get_fields_and_field_types() if n in rest}
    objects = [ObjectToWrap(radius=radius, **own) for radius in radii]
    return PlanWrap.Request(objects=objects, **rest)


def deliver(node, topic, message):
    """Call what a node in this process has subscribed with, as its executor would."""
    heard = [s for s in node.subscriptions if s.topic_name.rpartition("/")[2] == topic]
    heard[0].callback(message)


def tick(node):
    """Call all timers of a node in this process, as if the time of each had come."""
    for timer in list(node.timers):
        timer.callback()


def tick_until(node, condition):
    """Call them until a condition holds."""
    wait_until(lambda: condition() or tick(node))


def serve(node, name, request):
    """Have a service of a node in this process answer, as its executor would."""
    (service,) = [one for one in node.services if one.srv_name.rpartition("/")[2] == name]
    answer = service.callback(request, service.srv_type.Response())
    try:
        while hasattr(answer, "send"):
            answer.send(None)
    except StopIteration as ended:
        return ended.value
    return answer


def all_finite(*messages):
    """Return whether no number of messages is NaN or infinite; what is quoted is no number."""
    quoted = r"""'(\\.|[^'])*'|"(\\.|[^"])*\""""
    return not re.search(r"\b(nan|inf)\b", re.sub(quoted, "", repr(messages)))
