# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C while a compiled kernel computes.

Python sees the signal when it runs next: where numba packs the kernel's result. An exception there
ends the process with a segmentation fault or is lost, so it is raised in the line after the call.
"""

from __future__ import annotations

import sys
from pathlib import Path
from types import FrameType
from typing import NoReturn

# Where numba packs a result: its own unpickling, and the constructor of a named tuple.
PACKING = (str(Path("numba", "core", "serialize.py")), "<string>")


def interrupt(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, once no result is being packed: a handler for SIGINT."""
    del number
    caller = frame
    while caller is not None and caller.f_code.co_filename.endswith(PACKING):
        caller = caller.f_back
    if caller is None or caller is frame:
        raise KeyboardInterrupt
    caller.f_trace = _raise
    sys.settrace(_ignore)  # lets the caller be traced; new calls are not


def _ignore(frame: FrameType, event: str, argument: object) -> None:
    """Trace nothing in a new call."""


def _raise(frame: FrameType, event: str, argument: object) -> NoReturn:
    """Raise in the line after the call."""
    del frame, event, argument
    sys.settrace(None)
    raise KeyboardInterrupt
