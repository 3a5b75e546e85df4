# SPDX-License-Identifier: Apache-2.0
"""Node and simulator as processes, watched until they are stopped."""

from __future__ import annotations

import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing, suppress

from spiral_gripper_ros.process.node_process import SIMULATOR, NodeProcess
from spiral_gripper_ros.process.stop_signals import STOP_SIGNALS, StopSignals
from spiral_gripper_ros.tools.injection import local_discovery
from spiral_gripper_ros.tools.watcher import Watcher, say

# A first start compiles the solver: 15 seconds, a minute on a slow machine.
START_TIMEOUT = 180.0
STARTING = "starting node and simulator (the very first start compiles the solver: 15 to 60 s)"
SHOW_PERIOD = 0.1
# How long to listen for the vent of a node that has ended [s].
LAST_WORDS = 0.5
# How long both may take to end by themselves after Ctrl-C, which a terminal sends to them too [s];
# a second signal would hit them at their end.
GRACE = 2.0


def run_session(
    space: str,
    gripper: str,
    settings: dict[str, object],
    duration: float,
    lines: Sequence[str],
    watched: Callable[[str], Watcher] = Watcher,
) -> int:
    """Start node and simulator, show what they do, stop them.

    Args:
        space: namespace of all topics.
        gripper: a shipped gripper's name, or a description file's path.
        settings: parameters of the simulator.
        duration: from when the node is active [s]; inf: until SIGINT or SIGTERM.
        lines: to say once both are being started.
        watched: makes what watches a namespace.

    Returns:
        The exit code of what did so: 1 if anything went wrong.
    """
    local_discovery()
    signals = StopSignals()
    signals.defer()
    given = {"gripper": gripper}
    with (
        closing(watched(space)) as watcher,
        tempfile.TemporaryFile("w+") as log,
        NodeProcess(space, given | settings, output=log, module=SIMULATOR) as simulator,
        NodeProcess(space, given | {"exit_with_parent": True}, output=log) as node,
    ):
        for line in lines:
            say(line)
        processes = {"node": node, "simulator": simulator}
        problems = _watch(duration, signals, watcher, processes)
        problems += _stop(signals, watcher, processes)
        if not signals.requested:
            problems += watcher.verdict()
        for problem in problems:
            say(problem, "red")
        if problems:
            log.seek(0)
            say(log.read().rstrip())
        else:
            say("vented; node and simulator have ended")
    return 1 if problems else 0


def _watch(
    duration: float,
    signals: StopSignals,
    watcher: Watcher,
    processes: Mapping[str, NodeProcess],
) -> list[str]:
    """Show what happens for a time [s] from when both run; return what came between."""

    def goes_on() -> bool:
        """Return whether no stop was asked for, and none of the processes has ended."""
        watcher.spin(SHOW_PERIOD)  # the signal that ended one may be on its way to us
        return all(one.running for one in processes.values()) and not signals.requested

    begin = time.monotonic()
    while not watcher.ready and goes_on():
        if time.monotonic() - begin > START_TIMEOUT:
            return [f"node and simulator were not ready within {START_TIMEOUT:g} s"]
    begin = time.monotonic()
    while goes_on() and (elapsed := time.monotonic() - begin) < duration:
        watcher.show(elapsed)
    watcher.spin(SHOW_PERIOD)
    # Ctrl-C reaches all processes of a terminal: that they end is then as it should be.
    return [
        f"the {name} has ended by itself, with exit code {process.poll()}"
        for name, process in processes.items()
        if not (process.running or signals.requested)
    ]


def _stop(
    signals: StopSignals, watcher: Watcher, processes: Mapping[str, NodeProcess]
) -> list[str]:
    """Stop the node, hear its vent, stop the simulator; return what went wrong."""
    problems = []
    if signals.requested:
        for process in processes.values():
            with suppress(subprocess.TimeoutExpired):
                process.wait(GRACE)
    for name, process in processes.items():
        code = process.stop()
        # Ctrl-C reaches it too, and where it has not installed its handlers yet it is killed, or
        # Python gives up its own start with 1. The last command is checked in any case.
        is_interrupted = -code in STOP_SIGNALS or (code == 1 and watcher.command is None)
        if code != 0 and not (signals.requested and is_interrupted):
            problems.append(f"the {name} ended with exit code {code}")
        watcher.spin(LAST_WORDS)
    if watcher.command not in (None, 0.0):
        problems.append(f"the last command was {watcher.command:g} Pa, not a vent")
    return problems
