# SPDX-License-Identifier: Apache-2.0
"""Count the source files that a computation enters."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import FrameType

from repo.source_tree import ROOT


def files_entered(run: Callable[[], object], package: str = "spiral") -> set[str]:
    """Return the source files, of packages that begin so, whose functions ``run`` calls."""
    entered = set()

    def note(frame: FrameType, event: str, argument: object) -> None:
        del argument
        file = frame.f_code.co_filename
        if event == "call" and file.startswith(f"{ROOT}/{package}"):
            entered.add(file)

    run()  # compiled and imported
    sys.setprofile(note)
    try:
        run()
    finally:
        sys.setprofile(None)
    return entered
