# SPDX-License-Identifier: Apache-2.0
"""Start and stop of the node, or the simulator, as a separate process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import IO

NODE = "spiral_gripper_ros.node.main"
SIMULATOR = "spiral_gripper_ros.simulation.main"
# How long a node may take from a stop signal to its end [s]: the vent's acknowledgment takes at
# most 0.5 s, tearing DDS down about as long; slow machines get four times that.
STOP_TIMEOUT = 5.0


class NodeProcess:
    """A running node process; as a context manager it is stopped at the end.

    Args:
        namespace: of the node, such as "/demo".
        parameters: parameters to set at start.
        environment: variables to add to this process's.
        output: where its log goes; None: to the terminal.
        module: what is started: ``NODE`` or ``SIMULATOR``.
        arguments: more ROS arguments.
    """

    def __init__(
        self,
        namespace: str,
        parameters: Mapping[str, object] | None = None,
        environment: Mapping[str, str] | None = None,
        output: IO[str] | None = None,
        module: str = NODE,
        arguments: Sequence[str] = (),
    ) -> None:
        given = ["--ros-args", "-r", f"__ns:={namespace}", *arguments]
        for name, value in (parameters or {}).items():
            given += ["-p", f"{name}:={value}"]
        self._process = subprocess.Popen(
            [*_command(module), *given],
            env={**os.environ, **(environment or {})},
            stdout=output,
            stderr=subprocess.STDOUT if output is not None else None,
        )

    @property
    def running(self) -> bool:
        """Whether the process still runs."""
        return self._process.poll() is None

    @property
    def process_id(self) -> int:
        """The id of the process."""
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """The exit code, or None while it runs."""
        return self._process.poll()

    def wait(self, timeout: float) -> bool:
        """Return whether it ends by itself within a time [s]."""
        try:
            self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            return False
        return True

    def stop(self, number: int = signal.SIGINT) -> int:
        """Send a signal, wait, and return the exit code; kill as a last resort."""
        if self.running:
            self._process.send_signal(number)
        try:
            return self._process.wait(STOP_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return self._process.wait()

    def __enter__(self) -> NodeProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


@contextmanager
def simulated(
    namespace: str, gripper: str, settings: Mapping[str, object], log: IO[str]
) -> Iterator[dict[str, NodeProcess]]:
    """Yield the processes ``simulator`` and ``node`` of a gripper; they end with the block.

    Args:
        namespace: of both.
        gripper: a shipped gripper's name, or a description file's path.
        settings: parameters of the simulator.
        log: where their logs go.
    """
    known = {"gripper": gripper}
    with (
        NodeProcess(namespace, {**known, **settings}, output=log, module=SIMULATOR) as simulator,
        NodeProcess(namespace, known, output=log) as node,
    ):
        yield {"simulator": simulator, "node": node}


def _command(module: str) -> Sequence[str]:
    """Return the command that starts a node with this interpreter, however it was installed."""
    return (sys.executable, "-m", module)
