# SPDX-License-Identifier: Apache-2.0
"""Start and stop of the node, or the simulator, as a separate process."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from typing import IO

from spiral_gripper_ros.process.stop_signals import STARTED_BY

NODE = "spiral_gripper_ros.node.main"
SIMULATOR = "spiral_gripper_ros.simulation.main"
# How long a node may take from a stop signal to its end [s]: the vent's acknowledgment takes at
# most 0.5 s, tearing DDS down about as long; slow machines get four times that.
STOP_TIMEOUT = 5.0


class NodeProcess(subprocess.Popen[bytes]):
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
        # With this interpreter, however it was installed.
        given = [sys.executable, "-m", module, "--ros-args", "-r", f"__ns:={namespace}", *arguments]
        for name, value in (parameters or {}).items():
            # Texts of any letters; YAML knows no escape for those beyond 16 bits.
            text = json.dumps(value, ensure_ascii=False) if isinstance(value, str) else value
            given += ["-p", f"{name}:={text}"]
        super().__init__(
            given,
            env={**os.environ, STARTED_BY: str(os.getpid()), **(environment or {})},
            stdout=output,
            stderr=None if output is None else subprocess.STDOUT,
        )

    @property
    def running(self) -> bool:
        """Whether the process still runs."""
        return self.poll() is None

    def stop(self, number: int = signal.SIGINT) -> int:
        """Send a signal, wait, and return the exit code; kill as a last resort."""
        self.send_signal(number)
        try:
            return self.wait(STOP_TIMEOUT)
        except subprocess.TimeoutExpired:
            self.kill()
            return self.wait()

    def __exit__(self, *_: object) -> None:
        self.stop()
