# SPDX-License-Identifier: Apache-2.0
"""Signals that end a process as a request to stop, so that the last command can still be sent.

rclpy's own handlers shut the context down at once; after that nothing can be published any more.
"""

from __future__ import annotations

import os
import signal
from pathlib import Path
from types import FrameType

# Ctrl-C, a manager's stop, a terminal or ssh session that is closed, Ctrl-\\.
STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


# Variable in which a launch file or a command states the id of its process: if that process ends
# before this one can look for it, nothing else shows it.
STARTED_BY = "SPIRAL_GRIPPER_STARTED_BY"


class Parent:
    """The process that started this one: `ros2 run`, `ros2 launch`, a shell, a service manager.

    To be made as early as possible: who has ended before is noticed only by ``STARTED_BY``.
    """

    def __init__(self) -> None:
        self._id = os.getppid()
        self._came_too_late = False
        try:
            stated = int(os.environ.get(STARTED_BY, ""))
            # What has ended and is not yet waited for still has its id.
            self._came_too_late = _is_zombie(stated)
            os.kill(stated, 0)
        except ProcessLookupError:
            self._came_too_late = True
        except (ValueError, OverflowError, PermissionError):
            pass  # none is stated; no process of this machine; one of another user

    @property
    def has_gone(self) -> bool:
        """Whether it has ended, and left this process to another."""
        return self._came_too_late or os.getppid() != self._id


def _is_zombie(process: int) -> bool:
    """Return whether a process has ended and nobody has waited for it."""
    try:
        status = Path(f"/proc/{process}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:  # there is none, or /proc hides it as another user's
        return False
    return status.rpartition(")")[2].split()[0] == "Z"


class StopSignals:
    """Collects stop requests from the moment it is made.

    Until :meth:`defer` is called a signal raises KeyboardInterrupt, so that a long start can be
    interrupted; from then on it only sets ``requested``, for a loop to see. From :meth:`ignore` on
    nothing happens.
    """

    def __init__(self) -> None:
        self.requested = False
        self._deferred = False
        for number in STOP_SIGNALS:
            if number != signal.SIGHUP or signal.getsignal(number) is not signal.SIG_IGN:  # nohup
                signal.signal(number, self._on_signal)

    def defer(self) -> None:
        """Only note signals from now on."""
        self._deferred = True

    def ignore(self) -> None:
        """Take no more signals: the process ends, and a second Ctrl-C must not spoil its end.

        While Python finalizes, the system's own handlers are back, which kill.
        """
        for number in STOP_SIGNALS:
            signal.signal(number, signal.SIG_IGN)

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self.requested = True
        if not self._deferred:
            raise KeyboardInterrupt
