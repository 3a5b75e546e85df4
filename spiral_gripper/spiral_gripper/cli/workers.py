# SPDX-License-Identifier: Apache-2.0
"""Long computations: worker processes, progress on standard error, and Ctrl-C between two steps."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager, nullcontext

import click

from spiral_gripper.cli.types import wanted

_interrupted = threading.Event()


def interrupt_between_steps() -> None:
    """Let the first Ctrl-C end the computation after its present step, the second at once."""

    def note(*_: object) -> None:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        _interrupted.set()

    signal.signal(signal.SIGINT, note)


def interrupt_once(*_: object) -> None:
    """Raise KeyboardInterrupt at the first Ctrl-C; more must not spoil what it cancels and ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    raise KeyboardInterrupt


def core_count() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def process_pool(workers: int) -> Iterator[Executor]:
    """Yield a pool of spawned processes: forked ones would copy the locks of threads.

    Ctrl-C reaches this process alone; the workers are then ended at once. Where it would end this
    process without a word to them, they would wait for ever.

    Args:
        workers: number of processes.
    """
    pool = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # the workers inherit it
    for _ in range(workers):
        pool.submit(os.getpid)
    stops = signal.default_int_handler if before is signal.SIG_DFL else before
    signal.signal(signal.SIGINT, stops)
    try:
        yield pool
    except BaseException:
        threading.excepthook = lambda _: None  # the pool's thread fails without its workers
        for worker in multiprocessing.active_children():
            worker.terminate()
        pool.shutdown(cancel_futures=True)
        raise
    finally:
        signal.signal(signal.SIGINT, before)
    pool.shutdown()


@contextmanager
def progress_bar(title: str, *, quiet: bool = False) -> Iterator[Callable[[int, int | None], None]]:
    """Show a bar on standard error while the block runs; yield its update (done, total or None).

    If standard error is no terminal, the first update prints one line with the title, unless it is
    ``quiet``. Nothing is shown beside output for programs. The update raises KeyboardInterrupt
    after a Ctrl-C (see :func:`interrupt_between_steps`).
    """
    from rich.console import Console
    from rich.progress import Progress

    console, quiet = Console(stderr=True), quiet or wanted("json")
    silent = quiet or not console.is_terminal
    with Progress(console=console, transient=True, disable=silent) as bar:
        task = bar.add_task(title, total=None)

        def move(done: int, total: int | None) -> None:
            if _interrupted.is_set():
                _interrupted.clear()
                raise KeyboardInterrupt
            if silent and not quiet and bar.tasks[task].total is None:
                click.echo(f"{title} ...", err=True)
            bar.update(task, completed=done, total=total)

        yield move


@contextmanager
def computing(title: str) -> Iterator[tuple[Executor | None, Callable[[int, int | None], None]]]:
    """Show a bar as :func:`progress_bar`; yield a pool of processes, and the bar's update.

    There are as many processes as ``--jobs`` states, else as cores; None: one is enough.
    """
    count = wanted("jobs") or core_count()
    pool = nullcontext() if count == 1 else process_pool(count)
    with pool as executor, progress_bar(title) as progress:
        yield executor, progress
