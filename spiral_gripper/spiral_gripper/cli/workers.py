# SPDX-License-Identifier: Apache-2.0
"""Worker processes and Dask clusters for long sweeps, and their progress bar."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from importlib import import_module

import click

# How long a Dask scheduler may take to answer.
SCHEDULER_TIMEOUT = "5s"


def core_count() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def process_pool(workers: int) -> Iterator[Executor]:
    """Yield a pool of spawned processes: forked ones would copy the locks of threads.

    Ctrl-C reaches this process alone; the workers are then ended at once.

    Args:
        workers: number of processes.
    """
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))
    with _ignored_interrupts():  # the workers inherit it
        for _ in range(workers):
            pool.submit(os.getpid)
    try:
        yield pool
    except BaseException:
        for worker in set(multiprocessing.active_children()) - others:
            worker.terminate()
        with _mute_threads():
            pool.shutdown(cancel_futures=True)
        raise
    pool.shutdown()


@contextmanager
def dask_cluster(address: str) -> Iterator[Executor]:
    """Yield an executor on the workers of a Dask cluster, where spiral_core must be installed.

    Args:
        address: of its scheduler, such as ``"tcp://10.0.0.5:8786"``.

    Raises:
        click.ClickException: Dask is not installed here, or no scheduler answers.
    """
    try:
        distributed = import_module("distributed")  # the extra "dask"
    except ModuleNotFoundError:
        needed = "--scheduler needs Dask: pip install 'spiral-gripper[dask]'"
        raise click.ClickException(needed) from None
    try:
        client = distributed.Client(address, timeout=SCHEDULER_TIMEOUT, set_as_default=False)
    except (OSError, ValueError):
        raise click.ClickException(f"no Dask scheduler answers at --scheduler {address}") from None
    with client:
        yield client.get_executor()


@contextmanager
def progress_bar(title: str, *, quiet: bool = False) -> Iterator[Callable[[int, int], None] | None]:
    """Show a bar on standard error while the block runs; yield its update (done, total).

    If standard error is no terminal, the first update prints one line with the title. Nothing is
    shown, and None yielded, beside output for programs: ``quiet``.
    """
    if quiet:
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(title, total=None)

        def move(done: int, total: int) -> None:
            if not console.is_terminal and bar.tasks[task].total is None:
                click.echo(f"{title} ...", err=True)
            bar.update(task, completed=done, total=total)

        yield move


@contextmanager
def _mute_threads() -> Iterator[None]:
    """Let no thread print that it has failed: the pool's does where its workers are gone."""
    before = threading.excepthook
    threading.excepthook = lambda _: None
    try:
        yield
    finally:
        threading.excepthook = before


@contextmanager
def _ignored_interrupts() -> Iterator[None]:
    """Ignore Ctrl-C for a moment, as processes that are started meanwhile will do."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
