# SPDX-License-Identifier: Apache-2.0
"""Whom to tell that a process has to compile kernels, for which a person waits some seconds.

The core prints nothing: who talks to people appends a function here, without loading the compiler.
"""

from collections.abc import Callable

# Called once each, before the first compilation of a process.
TOLD: list[Callable[[], None]] = []
