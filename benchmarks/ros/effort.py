# SPDX-License-Identifier: Apache-2.0
"""How much of the node is measured."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class NodeEffort:
    """How much is measured.

    Args:
        messages: radii of one latency measurement, in all its windows.
        windows: short windows that take turns with those of the echo.
        rates: radii per second of the latency measurements [Hz].
        ladder: rates that are tried to find the highest one [Hz].
        step_seconds: how long each of them is tried [s].
        endurance_rate: radii per second of the endurance run [Hz].
        endurance_seconds: how long it takes [s].
        cycles: through the life cycle.
        grippers: in one process.
        many_messages: radii for each of them.
        starts: of a process, for the median.
        compile_anew: whether to measure the first start ever, which compiles.
    """

    messages: int = 2000
    windows: int = 10
    rates: tuple[float, ...] = (50.0, 200.0)
    ladder: tuple[float, ...] = (100.0, 200.0, 400.0, 600.0, 800.0, 1000.0, 1500.0, 2000.0)
    step_seconds: float = 5.0
    endurance_rate: float = 1000.0
    endurance_seconds: float = 60.0
    cycles: int = 100
    grippers: int = 10
    many_messages: int = 500
    starts: int = 3
    compile_anew: bool = True


SMOKE = NodeEffort(
    messages=10,
    windows=2,
    ladder=(100.0, 200.0),
    step_seconds=0.2,
    endurance_rate=200.0,
    endurance_seconds=0.5,
    cycles=2,
    grippers=2,
    many_messages=10,
    starts=1,
    compile_anew=False,
)
