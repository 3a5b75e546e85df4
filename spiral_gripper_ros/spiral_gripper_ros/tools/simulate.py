# SPDX-License-Identifier: Apache-2.0
"""``spiral-gripper simulate``: node and simulator as processes, watched until they are stopped."""

from __future__ import annotations

import math
import os
import shlex
import shutil
import sys
import tempfile
import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import rclpy
from rclpy.signals import SignalHandlerOptions
from rich.console import Console

from spiral_gripper_ros.process.node_process import NODE, SIMULATOR, NodeProcess
from spiral_gripper_ros.process.stop_signals import STOP_SIGNALS, StopSignals
from spiral_gripper_ros.simulation.parameters import recording_samples
from spiral_gripper_ros.simulation.regulator import Fault
from spiral_gripper_ros.tools.injection import injection_name, local_discovery
from spiral_gripper_ros.tools.live_view import LiveView
from spiral_gripper_ros.tools.watcher import Watcher

# A first start compiles the solver: some ten seconds, a minute on a slow machine.
START_TIMEOUT = 180.0
SHOW_PERIOD = 0.1
# How long to listen for the vent of a node that has ended [s].
LAST_WORDS = 0.5
# How long both may take to end by themselves after Ctrl-C, which a terminal sends to them too [s];
# a second signal would hit them at their end.
GRACE = 2.0
FAILED = 1


@dataclass(frozen=True, slots=True)
class Plan:
    """What is to be simulated.

    Args:
        gripper: a shipped gripper's name, or a description file's path.
        settings: parameters of the simulator.
        duration: from when the node is active [s]; inf: until SIGINT or SIGTERM.
        namespace: of all topics; None: one that nobody else has.
    """

    gripper: str
    settings: Mapping[str, object] = field(default_factory=dict)
    duration: float = math.inf
    namespace: str | None = None

    @property
    def space(self) -> str:
        """The namespace, with its slash."""
        return "/" + (self.namespace or f"spiral_gripper_simulation_{os.getpid()}").strip("/")


def simulate(plan: Plan) -> int:
    """Run node and simulator as planned; return the process's exit code.

    Raises:
        InvalidInputError: the recording cannot be used.
    """
    if "recording" in plan.settings:
        recording_samples(str(plan.settings["recording"]))
    local_discovery()
    signals = StopSignals()
    signals.defer()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    try:
        return _Session(plan, signals, Console()).run()
    finally:
        rclpy.try_shutdown()


def program() -> str:
    """Return the program that runs, as a shell anywhere on this machine finds it."""
    own = Path(sys.argv[0]).absolute()
    return shlex.quote(str(own)) if own.is_file() and os.access(own, os.X_OK) else "spiral-gripper"


class _Session:
    """One run of the command."""

    def __init__(self, plan: Plan, signals: StopSignals, console: Console) -> None:
        self._plan = plan
        self._signals = signals
        self._console = console
        self._watcher = Watcher(plan.space)
        self._processes: dict[str, NodeProcess] = {}
        self._started = False

    def run(self) -> int:
        """Start both, watch them, stop them; return the process's exit code."""
        with ExitStack() as stack:
            stack.callback(self._watcher.destroy_node)
            log = stack.enter_context(tempfile.TemporaryFile("w+"))
            for name, module, parameters in (
                ("simulator", SIMULATOR, self._plan.settings),
                ("node", NODE, {}),
            ):
                self._processes[name] = stack.enter_context(
                    NodeProcess(
                        self._plan.space,
                        {"gripper": self._plan.gripper, **parameters},
                        output=log,
                        module=module,
                    )
                )
            self._introduce()
            problems = [*self._watch(), *self._stop()]
            for problem in problems:
                self._say(problem, "red")
            if problems:
                log.seek(0)
                self._say(log.read().rstrip())
        return FAILED if problems else 0

    def _watch(self) -> list[str]:
        """Show what happens until the end that was planned; return what came between."""
        begin = time.monotonic()
        while not (self._watcher.ready or self._is_over()):
            self._watcher.spin(SHOW_PERIOD)
            if time.monotonic() - begin > START_TIMEOUT:
                return [f"node and simulator were not ready within {START_TIMEOUT:g} s"]
        self._started = self._watcher.ready
        begin = time.monotonic()
        with LiveView(self._console) as view:
            while not self._is_over() and time.monotonic() - begin < self._plan.duration:
                self._watcher.spin(SHOW_PERIOD)
                view.show(self._watcher.view(time.monotonic() - begin))
        # Ctrl-C reaches all processes of a terminal: that they end is then as it should be.
        if self._signals.requested:
            return []
        return [
            f"the {name} has ended by itself, with exit code {process.exit_code}"
            for name, process in self._processes.items()
            if not process.running
        ]

    def _is_over(self) -> bool:
        """Return whether a stop was asked for, or one of the processes has ended."""
        if any(not process.running for process in self._processes.values()):
            self._watcher.spin(SHOW_PERIOD)  # the signal that ended it may be on its way to us
            return True
        return self._signals.requested

    def _stop(self) -> list[str]:
        """Stop the node, hear its vent, stop the simulator; return what went wrong."""
        problems = []
        if self._signals.requested:
            for process in self._processes.values():
                process.wait(GRACE)
        for name in ("node", "simulator"):
            code = self._processes[name].stop()
            if not self._is_good_end(code):
                problems.append(f"the {name} ended with exit code {code}")
            self._watcher.spin(LAST_WORDS)
        if self._watcher.command not in (None, 0.0):
            problems.append(f"the last command was {self._watcher.command:g} Pa, not a vent")
        if not problems:
            self._say("vented; node and simulator have ended")
        return problems

    def _is_good_end(self, code: int) -> bool:
        """Return whether a process ended as it should.

        Ctrl-C reaches it too, and where it has not installed its handlers yet it is killed, or
        Python gives up its own start with 1. What was last commanded is checked in any case.
        """
        if code == 0 or not self._signals.requested:
            return code == 0
        return -code in STOP_SIGNALS or (code == FAILED and not self._started)

    def _introduce(self) -> None:
        """Say what is started, and what may be done with it."""
        space = self._plan.space
        faults = ", ".join(fault.value for fault in Fault)
        lines = [
            "starting node and simulator (the very first start compiles the solver: 10 to 60 s)",
            f"topics: below {space}; stop: Ctrl-C",
            f"faults ({faults}), from another terminal:",
            f"  {program()} inject {Fault.LEAK.value} --namespace {space}",
        ]
        if shutil.which("ros2") is not None:
            service = injection_name(space, Fault.LEAK)
            lines.append(f"  ros2 service call {service} std_srvs/srv/Trigger")
        for line in lines:
            self._say(line)

    def _say(self, text: str, style: str | None = None) -> None:
        self._console.print(text, style=style, highlight=False, markup=False, soft_wrap=True)
