# SPDX-License-Identifier: Apache-2.0
"""``spiral-gripper smoke``: one whole grasp of the node and the simulator, as real processes."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import IO

from spiral_core.errors import SpiralError
from spiral_gripper import load_gripper
from spiral_gripper.doctor.checks import Answer
from spiral_gripper.files.shown import shown
from spiral_gripper_ros.client import NoAnswerError, SpiralGripper, WrapOutcome
from spiral_gripper_ros.client.listener import listening
from spiral_gripper_ros.process.node_process import NodeProcess, simulated
from spiral_gripper_ros.process.stop_signals import StopSignals
from spiral_gripper_ros.simulation.regulator import Fault
from spiral_gripper_ros.smoke.listener import SmokeListener
from spiral_gripper_ros.smoke.verdict import VENTED, SmokeRecord, verdicts
from spiral_gripper_ros.tools.injection import local_discovery

# A first start compiles the solver: some 15 s, some minutes on a slow machine.
START_TIMEOUT = 300.0
# The wrap is reached in about five seconds, a release in half of one; slow machines get ten times
# that.
GRASP_TIMEOUT = 50.0
RELEASE_TIMEOUT = 5.0
ANSWER_TIMEOUT = 10.0
# What was published before something ended is heard this much later, at most [s].
LATE = 0.5
# How long the grip stands before it is looked at [s]: a leak or a lost wrap shows by then.
HOLD_TIME = 1.0
PROGRESS_PERIOD = 0.25
LOG_LINES = 12

Say = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class SmokeResult:
    """The result of the smoke test.

    Attributes:
        answers: what was expected and what came.
        log: the last lines that the processes have written.
    """

    answers: tuple[Answer, ...]
    log: tuple[str, ...]


def smoke(gripper: str, fault: str, say: Say) -> SmokeResult:
    """Start node and simulator, grasp, release, stop; return how each of that went.

    Args:
        gripper: a shipped gripper's name, or a description file's path.
        fault: of the simulated regulator; "none": it works.
        say: gets a line of progress now and then.

    Raises:
        KeyboardInterrupt: SIGINT or SIGTERM; both processes have ended by then.
    """
    record = SmokeRecord(load_gripper(gripper).pressure_max)
    namespace = f"/spiral_gripper_smoke_{os.getpid()}"
    local_discovery()
    StopSignals()
    with (
        tempfile.TemporaryFile("w+", errors="replace") as log,
        listening(lambda: SmokeListener(namespace)) as listener,
    ):
        _Smoke(record, namespace, say).run(gripper, fault, log, listener)
        log.seek(0)
        lines = log.read().splitlines()
    return SmokeResult(tuple(verdicts(record)), tuple(lines[-LOG_LINES:]))


class _Smoke:
    """One run; what it sees goes into the record."""

    def __init__(self, record: SmokeRecord, namespace: str, say: Say) -> None:
        self._is_measured = True
        self._record = record
        self._namespace = namespace
        self._say = say

    def run(self, gripper: str, fault: str, log: IO[str], listener: SmokeListener) -> None:
        """Start both processes, grasp and release, and stop them."""
        self._is_measured = fault != Fault.LOST_LINK.value
        self._say(f"starting node and simulator of {gripper}, below {self._namespace}")
        # There is an object, but no estimate of its radius: only the goal says what to wrap.
        settings = {"fault": fault, "dropout_probability": 1.0}
        with simulated(self._namespace, gripper, settings, log) as processes:
            with SpiralGripper(self._namespace, ANSWER_TIMEOUT) as client:
                if self._wait_until_active(client, listener, processes):
                    self._grasp(client, listener)
                    self._release(client, listener)
            for name in ("node", "simulator"):
                self._record.exit_codes[name] = processes[name].stop()
                listener.spin(LATE)
            self._record.commands = listener.commands

    def _wait_until_active(
        self, client: SpiralGripper, listener: SmokeListener, processes: dict[str, NodeProcess]
    ) -> bool:
        """Wait for the node and the simulator; return whether they came."""
        start = time.monotonic()
        while time.monotonic() < start + START_TIMEOUT:
            ended = [name for name, process in processes.items() if not process.running]
            if ended:
                self._record.answer = f"the {ended[0]} has ended by itself"
                return False
            try:
                client.wait_until_active(PROGRESS_PERIOD)
            except NoAnswerError as error:
                self._record.answer = str(error.missing)
                continue
            missing = self._missing(client, listener)
            if missing is None:
                self._record.active_after = time.monotonic() - start
                self._record.answer = ""
                self._say(f"node active after {self._record.active_after:.1f} s")
                return True
            self._record.answer = missing
        return False

    def _missing(self, client: SpiralGripper, listener: SmokeListener) -> str | None:
        """Return what is not heard yet, of what a grasp is judged by."""
        if not listener.spin(PROGRESS_PERIOD, lambda: listener.radius is not None):
            return "nothing is heard of the simulated object"
        status = client.status
        if self._is_measured and (status is None or not status.measured):
            return "the node hears no measured_pressure"
        return None

    def _grasp(self, client: SpiralGripper, listener: SmokeListener) -> None:
        """Wrap the simulated object, hold it for a while, and look at everything."""
        record = self._record
        record.radius = listener.radius
        start = time.monotonic()
        try:
            if not client.wrap(record.radius, timeout=GRASP_TIMEOUT):
                result = client.result()
                record.answer = "the goal is refused" if result is None else result.message
                return
            while not client.is_done():
                listener.spin(PROGRESS_PERIOD)
                self._say(_progress(record.radius, client, listener))
            result = client.wait(ANSWER_TIMEOUT)
        except SpiralError as error:
            record.answer = str(error)
            return
        if result.outcome is WrapOutcome.SUCCEEDED:
            record.wrapped_after = time.monotonic() - start
        record.answer = result.message
        self._say(result.message)
        listener.spin(HOLD_TIME)
        status = client.status
        record.says_wrapped = status is not None and bool(status.wrapped)
        record.grip, record.poses = listener.grip, listener.poses
        record.measured = listener.measured
        record.command = listener.commands[-1] if listener.commands else None

    def _release(self, client: SpiralGripper, listener: SmokeListener) -> None:
        """Vent, and wait until the measured pressure says so."""
        start = time.monotonic()
        try:
            client.release()
        except SpiralError as error:
            self._record.release_answer = str(error)
            return
        if listener.spin(
            RELEASE_TIMEOUT, lambda: listener.measured is not None and listener.measured < VENTED
        ):
            self._record.vented_after = time.monotonic() - start
            self._say(f"vented after {self._record.vented_after:.1f} s")
        self._record.measured_at_end = listener.measured


def _progress(radius: float | None, client: SpiralGripper, listener: SmokeListener) -> str:
    """Return a line of how far the grasp is."""
    target, command = 0.0, listener.commands[-1] if listener.commands else 0.0
    feedback = client.feedback()
    if feedback is not None:
        target = feedback.pressure_target
    measured = "nothing" if listener.measured is None else shown(listener.measured, "Pa")
    return (
        f"grasping {shown(radius or 0.0, 'm')}: {shown(command, 'Pa')} of {shown(target, 'Pa')} "
        f"commanded, {measured} measured"
    )
