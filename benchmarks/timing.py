# SPDX-License-Identifier: Apache-2.0
"""Take the time of short calls."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np


def median_time(call: Callable[[], object], repeats: int, warmup: int = 3) -> float:
    """Return the median wall time [s] of ``repeats`` calls, after ``warmup`` untimed ones."""
    for _ in range(warmup):
        call()
    times = np.empty(repeats)
    for i in range(repeats):
        begin = time.perf_counter()
        call()
        times[i] = time.perf_counter() - begin
    return float(np.median(times))


def timed(call: Callable[[], object]) -> float:
    """Return the wall time [s] of one call."""
    return median_time(call, repeats=1, warmup=0)
