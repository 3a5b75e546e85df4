# SPDX-License-Identifier: Apache-2.0
"""What a process uses, as Linux tells it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Usage:
    """What a process uses at one moment.

    Args:
        cpu: time that its threads have been running [s].
        memory: resident memory [bytes].
        threads: how many.
        files: open file descriptors.
    """

    cpu: float
    memory: int
    threads: int
    files: int


def usage(process_id: int) -> Usage:
    """Return what a process uses now."""
    folder = Path("/proc") / str(process_id)
    pages = int((folder / "statm").read_text(encoding="utf-8").split()[1])
    tasks = list((folder / "task").iterdir())
    return Usage(
        cpu=1e-9 * sum(_nanoseconds(task) for task in tasks),
        memory=pages * os.sysconf("SC_PAGE_SIZE"),
        threads=len(tasks),
        files=len(list((folder / "fd").iterdir())),
    )


def _nanoseconds(task: Path) -> int:
    """Return how long a thread has been running; 0 if it has just ended."""
    try:
        return int((task / "schedstat").read_text(encoding="utf-8").split()[0])
    except (FileNotFoundError, ProcessLookupError):
        return 0
