# SPDX-License-Identifier: Apache-2.0
"""``spiral_gripper_demo``: the node as a real process, fed with a recorded stream of radii.

Ends by itself after about 25 s; the exit code is 0 only if everything that should have happened
did. Ctrl-C stops node and demo.
"""

from __future__ import annotations

import os
import sys
import time
from typing import Any

import rclpy
from rclpy.signals import SignalHandlerOptions
from rich.console import Console

from spiral_gripper import load_gripper
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.messages.conversions import REGIME_NAMES
from spiral_gripper_ros.process.node_process import NodeProcess
from spiral_gripper_ros.process.program import HELP_OPTIONS
from spiral_gripper_ros.process.stop_signals import StopSignals
from spiral_gripper_ros.simulation.replay import RadiusSample, shipped_recording
from spiral_gripper_ros.tools.demo_client import DemoClient
from spiral_gripper_ros.tools.demo_report import DemoReport
from spiral_gripper_ros.tools.demo_table import DemoTable, Row

GRIPPER = "paper_design_70"
OBJECTS = {"tube light": 0.011, "PVC pipe": 0.030}
# A first start compiles the solver: some ten seconds, a minute on a slow machine.
START_TIMEOUT = 180.0
SERVICE_TIMEOUT = 10.0
# How long to listen for the vent of a node that has ended [s].
LAST_WORDS = 1.0
# Between two looks at what comes back [s].
LOOK_PERIOD = 0.02
# A sample that is later than this [s] finds the next ones due too.
STALL = 0.1
INTERRUPTED = 130
BAD_USAGE = 2
USAGE = """\
usage: spiral_gripper_demo [-h]

Starts the node as a process and plays a recorded stream of radii to it, good and bad ones, in about
25 s. Keeps to this machine and a namespace of its own, and ends vented; Ctrl-C stops it.
Exit code: 0 all was as expected, 1 something was not, 2 an unknown argument, 130 interrupted.
"""
LOCAL = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def private_namespace() -> str:
    """Return a namespace that no other demo and no real gripper on this domain has."""
    return f"/spiral_gripper_demo_{os.getpid()}"


def main(args: list[str] | None = None) -> int:
    """Run the demo, or show its help; return the process's exit code.

    Args:
        args: the command line's arguments; None: those of this process.
    """
    given = sys.argv[1:] if args is None else args
    if not HELP_OPTIONS.isdisjoint(given):
        sys.stdout.write(USAGE)
        return 0
    if given:
        sys.stderr.write(f"spiral_gripper_demo: it takes no arguments, got {given[0]!r}\n")
        return BAD_USAGE
    for name, value in LOCAL.items():
        os.environ.setdefault(name, value)
    console = Console()
    StopSignals()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    try:
        return _run(console)
    except KeyboardInterrupt:
        console.print("interrupted: the node has vented and stopped")
        return INTERRUPTED
    finally:
        rclpy.try_shutdown()


def _run(console: Console) -> int:
    namespace = private_namespace()
    client = DemoClient(namespace)
    console.print("starting the node (the very first start compiles the solver: 10 to 60 s) ...")
    console.print(f"its topics are below {namespace}", highlight=False)
    try:
        with NodeProcess(namespace, {"gripper": GRIPPER}) as process:
            if not client.spin(START_TIMEOUT, lambda: client.ready or not process.running):
                console.print("the node did not become ready", style="red")
                return 1
            if not process.running:
                console.print("the node ended before it was ready", style="red")
                return 1
            report = DemoReport(OBJECTS, load_gripper(GRIPPER).pressure_max)
            client.report = report
            with DemoTable(console) as table:
                _play(client, process, shipped_recording(), table)
            report.released = client.release(SERVICE_TIMEOUT)
            report.node_exit_code = process.stop()
            client.spin(LAST_WORDS)
    finally:
        client.destroy_node()
    return _judge(console, report)


def _play(
    client: DemoClient,
    process: NodeProcess,
    recording: tuple[RadiusSample, ...],
    table: DemoTable,
) -> None:
    """Publish the recording in its own time and show what comes back."""
    start, shown = time.monotonic(), client.status
    for sample in recording:
        while (wait := start + sample.time - time.monotonic()) > 0.0 and process.running:
            client.spin(min(wait, LOOK_PERIOD))
            if client.status is not None and client.status is not shown:
                shown = client.status
                table.show(_row(time.monotonic() - start, client.label, shown))
        if not process.running:
            return
        # After a stall the recording goes on from there: of many at once the node hears the newest.
        start += -wait if -wait > STALL else 0.0
        client.send(sample)


def _row(elapsed: float, label: str, status: Any) -> Row:  # noqa: ANN401
    tip = status.tip
    reason = Reason(status.reason)
    return Row(
        time=elapsed,
        label=label,
        radius_mm=status.object_radius * 1e3,
        pressure_kpa=status.pressure_command * 1e-3,
        turns=status.turns,
        regime=REGIME_NAMES[status.regime],
        tip_mm=(tip.x * 1e3, tip.y * 1e3, tip.z * 1e3),
        state=State(status.state).name.lower().replace("_", " "),
        reason="" if reason is Reason.NONE else reason.name.lower().replace("_", " "),
    )


def _judge(console: Console, report: DemoReport) -> int:
    for line in report.summary():
        console.print(line, highlight=False, markup=False, soft_wrap=True)
    problems = report.problems()
    for problem in problems:
        console.print(f"NOT AS EXPECTED: {problem}", style="red", markup=False)
    if not problems:
        console.print("all as expected; the gripper is vented", style="green")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
