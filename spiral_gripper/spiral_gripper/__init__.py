# SPDX-License-Identifier: Apache-2.0
"""Pneumatic spiral grippers without ROS: quantities with units, files, charts, a command line.

Every public name can be imported from here and is loaded when it is first used, so that the command
line starts at once. Names are added to ``__init__.pyi``, which type checkers read.
"""

import sys

from spiral_core.lazy import public_names
from spiral_core.notice import TOLD

MODULES, __getattr__ = public_names(__name__)
__all__ = sorted(MODULES)  # noqa: PLE0605 - computed, so that no name is stated twice


def __dir__() -> list[str]:
    """Return the public names."""
    return list(__all__)


def _say_that_kernels_compile() -> None:
    """Say at a terminal what a person waits for."""
    if sys.stderr is not None and sys.stderr.isatty():
        sys.stderr.write("compiling the solver, once: some 15 s, longer on a busy machine\n")


TOLD.append(_say_that_kernels_compile)
