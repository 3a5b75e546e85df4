# SPDX-License-Identifier: Apache-2.0
"""Processes that run the doctor's checks: start, read their answers, survive their crashes."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from queue import Empty, Queue
from threading import Thread
from time import monotonic
from types import TracebackType
from typing import Any

from spiral_gripper.doctor.checks import TIME_LIMIT, Answer, Finding, Mark, first_line
from spiral_gripper.doctor.package import has_ros_part
from spiral_gripper.doctor.worker import finding_as_dict, finding_from_dict

TABLES = ("spiral_gripper.doctor.install", "spiral_gripper.doctor.gripper")
# Is there only where the node is installed.
ROS_TABLE = "spiral_gripper_ros.doctor.checks"
# How long a worker that is done may take to end [s]; it has nothing more to say.
END_TIMEOUT = 3.0
# Color codes in the log of Fast DDS.
_ESCAPES = re.compile(r"\x1b\[[\d;]*m")


def tables() -> tuple[str, ...]:
    """Return the tables of checks that are installed."""
    return (*TABLES, ROS_TABLE) if has_ros_part() else TABLES


def examine(
    table: str,
    gripper: str | None,
    announce: Callable[[str], None],
    start_limit: float = TIME_LIMIT,
) -> Iterator[Answer]:
    """Run a table of checks; yield an answer for each, whatever happens to its process.

    Args:
        table: name of the table's module.
        gripper: the gripper that is asked about, name or path; None: all shipped ones.
        announce: gets the title of each check when it begins.
        start_limit: how long a worker may take until its first check begins [s].
    """
    marks: dict[str, str] = {}
    start = _Running("", table, table.rpartition(".")[2], start_limit, monotonic())
    while not (yield from _run_worker(table, gripper, marks, announce, start)):
        pass


@dataclass(frozen=True, slots=True)
class _Running:
    """The check that a worker is busy with."""

    section: str
    name: str
    title: str
    time_limit: float
    since: float

    def answer(self, finding: Finding) -> Answer:
        return Answer(self.section, self.name, self.title, finding, monotonic() - self.since)


def _run_worker(
    table: str,
    gripper: str | None,
    marks: dict[str, str],
    announce: Callable[[str], None],
    start: _Running,
) -> Generator[Answer, None, bool]:
    """Yield the answers of one worker and note them; return whether the table is done."""
    request = json.dumps({"table": table, "gripper": gripper, "marks": marks})
    running = start
    with _Worker(request) as worker:
        while True:
            event = worker.event(running.time_limit)
            if "end" in event:
                return True
            if "title" in event:
                running = _Running(**event, since=monotonic())
                announce(running.title)
                continue
            answer = running.answer(finding_from_dict(event["finding"]))
            marks[answer.name] = answer.finding.mark.name
            yield answer
            if "lost" in event:
                # One that has not come to its checks would not the next time either.
                return running is start
            running = start


class _Worker:
    """A running :mod:`spiral_gripper.doctor.worker`; as a context manager it ends with the block.

    Args:
        request: its argument.
    """

    def __init__(self, request: str) -> None:
        self._stderr = tempfile.TemporaryFile("w+", errors="replace")  # noqa: SIM115
        self._process = subprocess.Popen(
            [sys.executable, "-m", "spiral_gripper.doctor.worker", request],
            # What lies in the present folder is not what a node would import.
            env={**os.environ, "PYTHONSAFEPATH": "1"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=self._stderr,
            encoding="utf-8",
        )
        assert self._process.stdout is not None  # noqa: S101 - it was asked for
        self._output = self._process.stdout
        self._events: Queue[dict[str, Any] | None] = Queue()
        self._reader = Thread(target=self._read, daemon=True)
        self._reader.start()

    def event(self, timeout: float) -> dict[str, Any]:
        """Return the next event; of a worker that is lost, what happened to it.

        Args:
            timeout: how long the check that is running may take [s].
        """
        try:
            event = self._events.get(timeout=timeout)
        except Empty:
            self._process.kill()
            return _lost(f"no answer within {timeout:g} s; this check was stopped")
        return event or _lost(f"this check crashed: {self._last_words()}")

    def _last_words(self) -> str:
        """Return how the worker ended, and the last line it wrote."""
        code = self._process.wait()
        how = f"exit code {code}" if code >= 0 else signal.Signals(-code).name
        self._stderr.seek(0)
        lines = _ESCAPES.sub("", self._stderr.read()).splitlines()
        said = first_line("\n".join(reversed(lines)))
        return f"{how}, {said}" if said else how

    def _read(self) -> None:
        for line in self._output:
            self._events.put(json.loads(line))
        self._events.put(None)

    def __enter__(self) -> _Worker:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            self._process.wait(END_TIMEOUT if kind is None else 0.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join(END_TIMEOUT)
        self._output.close()
        self._stderr.close()


def _lost(text: str) -> dict[str, Any]:
    """Return the event that stands for a worker which can give none."""
    return {"finding": finding_as_dict(Finding(Mark.PROBLEM, text)), "lost": True}
