"""What every process of ours does around its work: help, signals, exit code. Imports no ROS.

Whatever takes time is imported by the work itself, so that a signal that comes early ends the
process in order.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

from spiral_gripper_ros.node.stop_signals import StopSignals

HELP_OPTIONS = frozenset({"-h", "--help"})


def run_process(
    args: list[str] | None,
    usage: Callable[[], str],
    work: Callable[[StopSignals, list[str] | None], int],
) -> int:
    """Show the help that is asked for, or work until SIGINT or SIGTERM.

    Args:
        args: the command line's arguments; None: those of this process.
        usage: makes the help text.
        work: returns the exit code; what it is given collects the stop signals.

    Returns:
        The process's exit code.
    """
    if not HELP_OPTIONS.isdisjoint(sys.argv[1:] if args is None else args):
        sys.stdout.write(usage())
        return 0
    signals = StopSignals()
    try:
        return work(signals, args)
    except KeyboardInterrupt:
        return 0
    finally:
        signals.ignore()
