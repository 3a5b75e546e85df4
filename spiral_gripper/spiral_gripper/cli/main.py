# SPDX-License-Identifier: Apache-2.0
"""The command line ``spiral-gripper``: its commands are loaded when they are called.

Exit codes: 0, done; 1, the answer is no (such as: no design is feasible); 2, no answer, with a line
on standard error for each reason.
"""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from io import TextIOWrapper
from types import MappingProxyType
from typing import Any

import click

from spiral_gripper.cli.group import Group, NoCommandError
from spiral_gripper.cli.workers import interrupt_between_steps, interrupt_once

NO_ANSWER = 2
# Commands that print what they have computed when they are interrupted.
STEPWISE = ("approach", "capture", "close", "sweep")
# Garbage is collected after so many new objects: most come with the libraries, and stay.
NEW_OBJECTS = 200_000
# Libraries that are not always installed: what needs them, and the extra that brings them.
EXTRAS = MappingProxyType(
    {
        "matplotlib": ("pictures need matplotlib", "plot"),
        "viser": ("the studio needs viser", "studio"),
        "trimesh": ("the studio needs trimesh", "studio"),
    }
)


# The module of each command.
COMMANDS = MappingProxyType(
    {
        "design": "design",
        **dict.fromkeys(("shape", "wrap", "grip"), "gripper"),
        "capture": "capture",
        "approach": "approach",
        "close": "closing.close",
        "calibrate": "calibrate",
        "grippers": "grippers",
        **dict.fromkeys(("winding-sheet", "model"), "model"),
        "sweep": "sweep",
        "chart": "chart",
        **dict.fromkeys(("plan", "grasp", "release", "status", "watch"), "ros.running"),
        **dict.fromkeys(("simulate", "inject"), "ros.simulate"),
        "studio": "ros.studio",
        "doctor": "doctor",
    }
)


class LazyGroup(Group):
    """A group that imports a command's module to run that command, or to list all of them."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command, its module loaded; None if there is none of this name."""
        if cmd_name not in COMMANDS:
            return None
        module = import_module(f"spiral_gripper.cli.{COMMANDS[cmd_name]}")
        command: click.Command = getattr(module, cmd_name.replace("-", "_"))
        return command


@click.command(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="spiral-gripper", message="%(prog)s %(version)s")
def spiral_gripper() -> None:
    """Mechanics of pneumatic spiral grippers.

    Every dimensional argument needs its unit: "30 mm", "3/16 in", "55 kPa", "8 psi", "70 deg".
    """


def run(arguments: Sequence[str]) -> int:
    """Run the command line and return its exit code; only programming errors are raised.

    Args:
        arguments: without the program's name.
    """
    givens: dict[str, list[Any]] = {}  # what was typed: filled by the types of the options
    try:
        result = spiral_gripper.main(
            args=list(arguments), prog_name="spiral-gripper", standalone_mode=False, obj=givens
        )
        if sys.stdout is not None:
            sys.stdout.flush()  # while a failure can still be reported
    except NoCommandError as error:
        click.echo(error.format_message(), err=True)
        return NO_ANSWER
    except click.UsageError as error:  # click puts choices on lines of their own
        message = " ".join(error.format_message().split())
        if isinstance(error, click.NoSuchOption) and error.option_name == "--diameter":
            message += " Give the radius, half the diameter."
        return _complain(message)
    except click.ClickException as error:
        return _complain(error.format_message())
    except (click.Abort, KeyboardInterrupt):
        return _complain("interrupted")
    except BrokenPipeError:  # the reader of our output has gone: "spiral-gripper ... | head"
        _drop_output()
        return NO_ANSWER
    except OSError as error:  # without a file's name it is standard output's
        from spiral_core import SpiralError

        if isinstance(error, SpiralError):  # a node that does not answer is a TimeoutError too
            return _complain(str(error))
        from spiral_gripper.files.storage import reason_of

        if error.filename is not None:  # such as a name that is too long to look up
            return _complain(f"{error.filename}: {reason_of(error)}")
        _drop_output()
        return _complain(f"the answer cannot be printed: {reason_of(error)}")
    except Exception as error:
        return _complain_or_raise(error, givens)
    return result if isinstance(result, int) else 0


def main() -> None:
    """Run the command line of this process."""
    if isinstance(sys.stdout, TextIOWrapper):  # whose encoding may lack letters of a name
        sys.stdout.reconfigure(errors="replace")
    command = sys.argv[1] if sys.argv[1:] else ""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        # Ctrl-C ends a command that holds nothing at once, and one of many steps between two. An
        # exception while numba packs the result of a kernel would end in a segmentation fault.
        if command in STEPWISE:
            interrupt_between_steps()
        elif command != "studio":  # which computes for a while at its end
            of_ros = COMMANDS.get(command, "").startswith("ros.")
            signal.signal(signal.SIGINT, interrupt_once if of_ros else signal.SIG_DFL)
    gc.set_threshold(NEW_OBJECTS)
    atexit.register(gc.freeze)  # else Python looks through all objects once more before it ends
    sys.exit(run(sys.argv[1:]))


def _drop_output() -> None:
    """Discard the rest of the output, so that Python's own flush at exit does not fail again."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _complain_or_raise(error: Exception, givens: dict[str, list[Any]]) -> int:
    """Report an error of the library, an overflow, or a missing extra; raise anything else."""
    from spiral_core import SpiralError

    if isinstance(error, SpiralError):
        from spiral_gripper.cli.types import error_text

        return _complain(error_text(error, givens))
    if isinstance(error, OverflowError):
        return _complain("the numbers given are too large to compute with; check the units")
    missing = (error.name or "").partition(".")[0] if isinstance(error, ImportError) else ""
    if missing in EXTRAS:
        need, extra = EXTRAS[missing]
        return _complain(f"{need}: pip install 'spiral-gripper[{extra}]'")
    raise error


def _complain(message: str) -> int:
    """Write what is wrong on standard error, a line each, and return the exit code."""
    lines = [part.strip() for part in message.splitlines() if part.strip()]
    if len(lines) > 1:
        lines = [f"{len(lines)} problems", *lines]
    with suppress(OSError):  # standard error may be full or closed
        click.echo("spiral-gripper: " + "\n  ".join(lines), err=True)
    return NO_ANSWER


if __name__ == "__main__":
    main()
