# SPDX-License-Identifier: Apache-2.0
"""The smallest and the largest command of a time window, in bounded memory at any rate."""

from __future__ import annotations

import math
from collections import deque

# The window is kept in so many parts: it reaches back too far by at most one of them and the time
# between two commands.
PARTS = 32


class CommandEnvelope:
    """Remembers which commands were in force during a window that ends now.

    Before the first command anything was in force, so the envelope is unbounded until the window
    is full.
    """

    def __init__(self) -> None:
        self._parts: deque[tuple[float, float, float]] = deque()  # start, lowest, highest
        self._first: float | None = None

    def clear(self) -> None:
        """Forget every command."""
        self._parts.clear()
        self._first = None

    def add(self, now: float, command: float, window: float) -> None:
        """Note a command [Pa] that is in force from ``now`` [s] on, for windows of that length."""
        if self._first is None:
            self._first = now
        if self._parts and now - self._parts[-1][0] <= window / PARTS:
            start, low, high = self._parts[-1]
            self._parts[-1] = (start, min(low, command), max(high, command))
        else:
            self._parts.append((now, command, command))
        self._drop(now - window)

    def bounds(self, now: float, window: float) -> tuple[float, float]:
        """Return the smallest and the largest command in force since ``now - window`` [Pa].

        Example:
            >>> envelope = CommandEnvelope()
            >>> for second, command in enumerate((0.0, 3.0e4, 5.0e4, 5.0e4)):
            ...     envelope.add(float(second), command, window=1.0)
            >>> envelope.bounds(3.0, window=1.0)
            (50000.0, 50000.0)
        """
        if self._first is None or now - self._first < window:
            return -math.inf, math.inf
        self._drop(now - window)
        return min(part[1] for part in self._parts), max(part[2] for part in self._parts)

    def _drop(self, oldest: float) -> None:
        """Drop the parts whose last command was replaced before the time ``oldest`` [s]."""
        while len(self._parts) > 1 and self._parts[1][0] <= oldest:
            self._parts.popleft()
