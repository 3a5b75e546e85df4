# SPDX-License-Identifier: Apache-2.0
"""Programs that start processes of their own, run as a shell runs them: in a process group."""

import os
import re
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

from ros.harness import DEADLINE, wait_until

PROGRAM = str(Path(sys.executable).with_name("spiral-gripper"))


def start(*command):
    """Start a program in a process group of its own, with its output and errors in one pipe."""
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )


def line_with(process, pattern):
    """Return the next line of a program that has a part like a pattern."""
    return next(line for line in process.stdout if re.search(pattern, line))


def rest_of(process, number=0):
    """Wait for the end of a program and of its children, after a signal to all of them.

    Returns:
        Its exit code, and what it still said.
    """
    if number:
        os.killpg(process.pid, number)
    said = process.stdout.read()
    assert "Traceback" not in said
    code = process.wait(DEADLINE)
    with suppress(ProcessLookupError):
        wait_until(lambda: os.killpg(process.pid, 0))
    return code, said
