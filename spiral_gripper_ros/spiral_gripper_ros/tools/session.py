# SPDX-License-Identifier: Apache-2.0
"""Node and simulator as processes, watched until they are stopped: simulation and demo."""

from __future__ import annotations

import math
import os
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field

from spiral_gripper_ros.process.node_process import NodeProcess, simulated
from spiral_gripper_ros.process.stop_signals import STOP_SIGNALS, StopSignals
from spiral_gripper_ros.tools.injection import local_discovery
from spiral_gripper_ros.tools.watcher import Watcher, say

# A first start compiles the solver: some ten seconds, a minute on a slow machine.
START_TIMEOUT = 180.0
STARTING = "starting node and simulator (the very first start compiles the solver: 10 to 60 s)"
SHOW_PERIOD = 0.1
# How long to listen for the vent of a node that has ended [s].
LAST_WORDS = 0.5
# How long both may take to end by themselves after Ctrl-C, which a terminal sends to them too [s];
# a second signal would hit them at their end.
GRACE = 2.0


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


def run_session(
    plan: Plan, lines: Sequence[str], listen: Callable[[str], Watcher] = Watcher
) -> tuple[list[str], bool]:
    """Start node and simulator, show what they do, stop them.

    Args:
        plan: what is to be simulated.
        lines: to say once both are being started.
        listen: makes what listens in a namespace.

    Returns:
        What went wrong, and whether a signal ended it.
    """
    local_discovery()
    signals = StopSignals()
    signals.defer()
    with (
        closing(listen(plan.space)) as watcher,
        tempfile.TemporaryFile("w+") as log,
        simulated(plan.space, plan.gripper, plan.settings, log) as processes,
    ):
        for line in lines:
            say(line)
        session = _Session(signals, watcher, processes)
        problems = [*session.watch(plan.duration), *session.stop()]
        for problem in problems:
            say(problem, "red")
        if problems:
            log.seek(0)
            say(log.read().rstrip())
    return problems, signals.requested


class _Session:
    """One run of both processes."""

    def __init__(
        self, signals: StopSignals, watcher: Watcher, processes: Mapping[str, NodeProcess]
    ) -> None:
        self._signals, self._watcher, self._processes = signals, watcher, processes
        self._started = False

    def watch(self, duration: float) -> list[str]:
        """Show what happens for a time [s] from when both run; return what came between."""
        begin = time.monotonic()
        while not (self._watcher.ready or self._is_over()):
            self._watcher.spin(SHOW_PERIOD)
            if time.monotonic() - begin > START_TIMEOUT:
                return [f"node and simulator were not ready within {START_TIMEOUT:g} s"]
        self._started = self._watcher.ready
        begin = time.monotonic()
        while not self._is_over() and time.monotonic() - begin < duration:
            self._watcher.spin(SHOW_PERIOD)
            self._watcher.show(time.monotonic() - begin)
        # Ctrl-C reaches all processes of a terminal: that they end is then as it should be.
        return [
            f"the {name} has ended by itself, with exit code {process.exit_code}"
            for name, process in self._processes.items()
            if not (process.running or self._signals.requested)
        ]

    def _is_over(self) -> bool:
        """Return whether a stop was asked for, or one of the processes has ended."""
        if any(not process.running for process in self._processes.values()):
            self._watcher.spin(SHOW_PERIOD)  # the signal that ended it may be on its way to us
            return True
        return self._signals.requested

    def stop(self) -> list[str]:
        """Stop the node, hear its vent, stop the simulator; return what went wrong."""
        problems = []
        if self._signals.requested:
            for process in self._processes.values():
                process.wait(GRACE)
        for name in ("node", "simulator"):
            code = self._processes[name].stop()
            # Ctrl-C reaches it too, and where it has not installed its handlers yet it is killed,
            # or Python gives up its own start with 1. The last command is checked in any case.
            is_interrupted = -code in STOP_SIGNALS or (code == 1 and not self._started)
            if code != 0 and not (self._signals.requested and is_interrupted):
                problems.append(f"the {name} ended with exit code {code}")
            self._watcher.spin(LAST_WORDS)
        if self._watcher.command not in (None, 0.0):
            problems.append(f"the last command was {self._watcher.command:g} Pa, not a vent")
        if not problems:
            say("vented; node and simulator have ended")
        return problems
