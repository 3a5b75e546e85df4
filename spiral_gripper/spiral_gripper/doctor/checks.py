# SPDX-License-Identifier: Apache-2.0
"""The checks of ``spiral-gripper doctor`` and their results, as plain data.

A table of checks is a module with two names: ``SECTION``, its heading, and ``checks``, which turns
:class:`Facts` into :class:`Check` objects. The tables are run in processes of their own
(:mod:`spiral_gripper.doctor.worker`), so that nothing they load can take the doctor down; nothing
but Python's own library is imported here, because it must run where the rest does not.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from importlib import metadata
from pathlib import Path

# How long a check may take [s] unless it says otherwise: far more than any needs.
TIME_LIMIT = 30.0


class Mark(Enum):
    """Results of a check; the value is the text that is printed."""

    OK = "ok"
    INFO = "info"
    WARNING = "warning"
    PROBLEM = "PROBLEM"
    SKIPPED = "skipped"


@dataclass(frozen=True, slots=True)
class Finding:
    """What one check found.

    Attributes:
        mark: the result.
        text: what was found, in a sentence.
        advice: how to fix it, in a sentence; empty if nothing needs to be fixed.
        commands: commands for that, a line each.
    """

    mark: Mark
    text: str
    advice: str = ""
    commands: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Facts:
    """The facts about the machine that checks use; a test can pass those of another machine.

    Attributes:
        environ: environment variables.
        distributions: versions of the installed Python distributions, by normalized name.
        search_path: where Python looks for modules, in order.
        system: operating system, such as "Linux".
        architecture: of the processor, such as "x86_64".
        python: version of Python.
        prefix: the environment that Python runs in.
        root: root of the file system, for what the kernel shows there.
        gripper: the gripper that is asked about, name or path; None: all shipped ones.
    """

    environ: Mapping[str, str]
    distributions: Mapping[str, str]
    search_path: tuple[Path, ...]
    system: str
    architecture: str
    python: tuple[int, int, int]
    prefix: Path
    root: Path
    gripper: str | None = None

    @classmethod
    def here(cls, gripper: str | None = None) -> Facts:
        """Return the facts of this process."""
        return cls(
            environ=dict(os.environ),
            distributions={
                normalized(found.name): found.version
                for found in metadata.distributions()
                if found.name  # None in what a broken installation leaves behind
            },
            search_path=tuple(Path(entry or ".") for entry in sys.path),
            system=platform.system(),
            architecture=platform.machine(),
            python=sys.version_info[:3],
            prefix=Path(sys.prefix),
            root=Path("/"),
            gripper=gripper,
        )


@dataclass(frozen=True, slots=True)
class Check:
    """One check of a table.

    Attributes:
        name: for programs, such as "ros.domain".
        title: for people.
        run: the function of the check; it may raise anything, see :func:`finding_of`.
        needs: names of earlier checks of the table that must have passed.
        time_limit: it counts as hanging after this [s].
    """

    name: str
    title: str
    run: Callable[[Facts], Finding]
    needs: tuple[str, ...] = ()
    time_limit: float = TIME_LIMIT


@dataclass(frozen=True, slots=True)
class Answer:
    """A check and what it found.

    Attributes:
        section: heading of the check's table.
        name: the check's name, for programs.
        title: the check's title, for people.
        finding: what it found.
        elapsed: how long that took [s].
    """

    section: str
    name: str
    title: str
    finding: Finding
    elapsed: float


def finding_of(check: Check, facts: Facts, marks: Mapping[str, Mark]) -> Finding:
    """Run a check; an exception that it raises becomes a finding.

    Args:
        check: the check.
        facts: what it looks at.
        marks: results of the earlier checks, by name.
    """
    missing = [name for name in check.needs if marks.get(name) in (Mark.PROBLEM, Mark.SKIPPED)]
    if missing:
        cause = missing[0].rpartition(".")[2].replace("_", " ")
        return Finding(Mark.SKIPPED, f"not checked, because of {cause}")
    try:
        return check.run(facts)
    except (Exception, SystemExit) as error:
        return Finding(Mark.PROBLEM, f"this check crashed: {_crash(error)}")


def normalized(name: str) -> str:
    """Return a distribution's name as indexes compare it.

    Example:
        >>> normalized("ruamel.yaml"), normalized("Spiral_Gripper")
        ('ruamel-yaml', 'spiral-gripper')
    """
    return "-".join(name.lower().replace("_", "-").replace(".", "-").split("-"))


def first_line(text: str) -> str:
    r"""Return the first line of a text that is not blank.

    Example:
        >>> first_line("\n  numba needs another numpy\nmore")
        'numba needs another numpy'
    """
    return next((line.strip() for line in text.splitlines() if line.strip()), "")


def _crash(error: BaseException) -> str:
    """Return what was raised and where, on one line."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    place = (
        ""
        if trace is None
        else f" ({Path(trace.tb_frame.f_code.co_filename).name}:{trace.tb_lineno})"
    )
    return f"{type(error).__name__}: {first_line(str(error))}{place}"
