# SPDX-License-Identifier: Apache-2.0
"""The doctor's checks of the middleware: it loads, and messages arrive.

``python -m spiral_gripper_ros.doctor.transport TOPIC`` is the other process of the second check: it
answers each message until its standard input is closed.
"""

from __future__ import annotations

import atexit
import os
import select
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from functools import cache
from statistics import median
from typing import Any

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.utilities import get_rmw_implementation_identifier
from std_msgs.msg import UInt64

from spiral_gripper.doctor.checks import Facts, Finding, Mark

# How long the first answer may take [s]: two processes have to find each other for it.
DEADLINE = 10.0
# Time between two attempts [s]: the first messages may be lost.
PERIOD = 0.05
ROUND_TRIPS = 20
END_TIMEOUT = 3.0


class Listener:
    """A node of the doctor's own, in a context of its own.

    Args:
        name: of the node; the process's id is added.
    """

    def __init__(self, name: str) -> None:
        self._context = Context()
        self._context.init()
        self.since = time.monotonic()
        self.node = Node(f"{name}_{os.getpid()}", context=self._context, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)

    def handle(self, duration: float) -> None:
        """Handle the next message that arrives within ``duration`` [s]."""
        self._executor.spin_once(timeout_sec=duration)

    def close(self) -> None:
        """End the node."""
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()


@cache
def listener() -> Listener:
    """Return the node that all checks of a process share.

    Other nodes may take seconds to find one that comes soon after another has gone.
    """
    made = Listener("spiral_gripper_doctor")
    atexit.register(made.close)
    return made


def check_middleware(facts: Facts) -> Finding:
    """Check whether the middleware loads and makes a node."""
    del facts
    listener()
    return Finding(Mark.OK, f"{get_rmw_implementation_identifier()} loads and makes a node")


def check_two_processes(facts: Facts) -> Finding:
    """Check whether messages travel to another process and back."""
    topic = f"/spiral_gripper_doctor/p{os.getpid()}"
    echo = subprocess.Popen(
        [sys.executable, "-m", "spiral_gripper_ros.doctor.transport", topic],
        stdin=subprocess.PIPE,
        stdout=sys.stderr,
    )
    try:
        times = round_trips(topic, answers_of(topic))
    finally:
        if echo.stdin is not None:
            echo.stdin.close()
        try:
            echo.wait(END_TIMEOUT)
        except subprocess.TimeoutExpired:
            echo.kill()
            echo.wait()
    return two_processes_finding(times, facts)


def two_processes_finding(times: Sequence[float], facts: Facts) -> Finding:
    """Judge messages to another process and back.

    Args:
        times: what :func:`round_trips` returned.
        facts: the settings of discovery.
    """
    if times:
        text = f"a message is there and back in {median(times) * 1e3:.1f} ms"
        return Finding(Mark.OK, text)
    if facts.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == "OFF":
        text = "no message, because of ROS_AUTOMATIC_DISCOVERY_RANGE=OFF"
        return Finding(Mark.PROBLEM, text, "", ("unset ROS_AUTOMATIC_DISCOVERY_RANGE",))
    return Finding(
        Mark.PROBLEM,
        f"another process of this machine did not answer within {DEADLINE:g} s",
        "Shared memory, a firewall, a network without multicast or a file of settings can be the "
        "reason. If the first line helps it is shared memory; the second, the network; the third, "
        "the file:",
        (
            "FASTDDS_BUILTIN_TRANSPORTS=UDPv4 spiral-gripper doctor",
            "ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST spiral-gripper doctor",
            "env -u FASTRTPS_DEFAULT_PROFILES_FILE spiral-gripper doctor",
        ),
    )


def answers_of(topic: str) -> str:
    """Return the topic on which the other process answers."""
    return f"{topic}/answer"


def round_trips(there: str, back: str, deadline: float = DEADLINE) -> list[float]:
    """Return how long messages took from one topic to the other [s]; none if nothing came back.

    Args:
        there: topic to publish on.
        back: topic to listen to.
        deadline: how long the first answer may take [s]; each later one as well.
    """
    heard: set[int] = set()
    times: list[float] = []
    node = listener().node
    ear = node.create_subscription(UInt64, back, lambda message: heard.add(message.data), 10)
    publisher = node.create_publisher(UInt64, there, 10)
    number, end = 0, time.monotonic() + deadline
    while len(times) < ROUND_TRIPS and time.monotonic() < end:
        number += 1
        sent = time.monotonic()
        publisher.publish(UInt64(data=number))
        while number not in heard and time.monotonic() < sent + PERIOD:
            listener().handle(PERIOD)
        if number in heard:
            times.append(time.monotonic() - sent)
    node.destroy_publisher(publisher)
    node.destroy_subscription(ear)
    return times


def echo(topic: str, stop: Callable[[], bool]) -> None:
    """Answer every message until it is time to stop."""
    own = Listener("spiral_gripper_doctor_echo")
    publisher = own.node.create_publisher(UInt64, answers_of(topic), 10)
    own.node.create_subscription(UInt64, topic, publisher.publish, 10)
    while not stop():
        own.handle(PERIOD)
    own.close()


def _input_is_closed() -> bool:
    readable: tuple[list[Any], ...] = select.select([sys.stdin], [], [], 0.0)
    return bool(readable[0])


if __name__ == "__main__":
    echo(sys.argv[1], _input_is_closed)
