# SPDX-License-Identifier: Apache-2.0
"""Programs that start processes of their own, run as a shell runs them: in a process group."""

import os
import subprocess
import sys
import time
from pathlib import Path

from ros.harness import DEADLINE

SIMULATE = [str(Path(sys.executable).with_name("spiral-gripper")), "simulate"]


def start(command):
    """Start a program in a process group of its own, with its output and errors in one pipe."""
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )


def group_exists(group):
    """Return whether any process of a group is left."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def wait_for_the_end_of(group):
    """Wait until no process of a group is left."""
    deadline = time.monotonic() + DEADLINE
    while group_exists(group):
        assert time.monotonic() < deadline, "a process is left"
        time.sleep(0.05)
