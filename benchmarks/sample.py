# SPDX-License-Identifier: Apache-2.0
"""A random sample on all cores, and what is told of its figures."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from benchmarks.cases import Array

IntArray: TypeAlias = NDArray[np.int64]
OutcomeT = TypeVar("OutcomeT")
WORKERS = 2


def solve_all(solve_one: Callable[[int], OutcomeT], count: int, chunk: int = 25) -> list[OutcomeT]:
    """Solve the first cases of a sample on all cores, so many at a time, which loads kernels once.

    Args:
        solve_one: solves the case of an index.
        count: of the cases.
        chunk: cases that a process takes together.
    """
    chunks = [range(i, min(i + chunk, count)) for i in range(0, count, chunk)]
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(WORKERS, mp_context=context) as pool:
        solved = pool.map(partial(_solve_some, solve_one), chunks)
        return [outcome for some in solved for outcome in some]


def _solve_some(solve_one: Callable[[int], OutcomeT], indices: range) -> list[OutcomeT]:
    """Solve some cases, after a first one that loads the kernels."""
    solve_one(indices[0])
    return [solve_one(index) for index in indices]


def spread(values: Array | IntArray, show: Callable[[float], str]) -> str:
    """Return median, 99th percentile and maximum as text."""
    figures = (np.median(values), np.quantile(values, 0.99), values.max())
    return " / ".join(show(float(figure)) for figure in figures)
