# SPDX-License-Identifier: Apache-2.0
"""The interface of a device to the adapter, for any connection."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from spiral_core.errors import SpiralError


class LinkError(SpiralError):
    """A device was not reached, or has not answered in its form; says what is wrong, and where."""


@dataclass(frozen=True, slots=True)
class Reading:
    """A device's answer.

    Args:
        number: what it measures, in its own unit; any float; None: it does not measure.
        problem: what it says is wrong with itself; empty: nothing.
        has_vented: whether it says that it has vented by itself, and waits for a vent.
    """

    number: float | None = None
    problem: str = ""
    has_vented: bool = False


class PressureDevice(Protocol):
    """A regulator, in its own numbers."""

    def exchange(self, number: float) -> Reading:
        """Send a set-point and return the answer; connect first where that is necessary.

        Takes a bounded time, and may be called again after an error.

        Raises:
            LinkError: it was not reached or has not answered.
        """
        ...

    def close(self) -> None:
        """End the connection."""
        ...
