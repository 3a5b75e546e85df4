# SPDX-License-Identifier: Apache-2.0
"""Many answers of one kind: here or on an executor, in order, each computed once."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping
from concurrent.futures import Executor
from contextlib import closing
from typing import Any

Progress = Callable[[int, int], None]


def in_turn(
    task: Callable[[Any], Any],
    items: Iterable[Any],
    executor: Executor | None = None,
    progress: Progress | None = None,
    before: int = 0,
) -> Generator[Any, None, None]:
    """Yield a task's answer for each item, in their order.

    What has not begun when the generator is closed, or fails, is canceled.

    Args:
        task: picklable, where the executor has processes.
        items: what it is asked.
        executor: where; None: one after the other, here.
        progress: called with the number of answers and the number there will be, after each.
        before: answers that both numbers count too.

    Example:
        >>> list(in_turn(abs, [1, -2]))
        [1, 2]
    """
    asked = list(items)
    jobs = [] if executor is None else [executor.submit(task, item) for item in asked]
    answers = (job.result() for job in jobs) if jobs else map(task, asked)
    try:
        for count, answer in enumerate(answers, start=before + 1):
            yield answer
            if progress is not None:
                progress(count, before + len(asked))
    finally:
        for job in jobs:
            job.cancel()


def resume(
    task: Callable[[Any], Any],
    items: Mapping[Any, Any],
    known: dict[Any, Any],
    keep: Callable[[Any, Any], None] | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
    before: int = 0,
) -> None:
    """Add to known answers those that are missing, by their key.

    Args:
        task: see :func:`in_turn`.
        items: what it is asked, by key.
        known: answers by key, of an interrupted computation too.
        keep: called with each new key and answer, in the order of the items.
        executor: see :func:`in_turn`.
        progress: see :func:`in_turn`; of the new answers.
        before: see :func:`in_turn`.

    Example:
        >>> known = {"a": 1}
        >>> resume(abs, {"a": 1, "b": -2}, known)
        >>> known
        {'a': 1, 'b': 2}
    """
    missing = {key: item for key, item in items.items() if key not in known}
    with closing(in_turn(task, missing.values(), executor, progress, before)) as answers:
        for key, answer in zip(missing, answers, strict=True):
            known[key] = answer
            if keep is not None:
                keep(key, answer)
