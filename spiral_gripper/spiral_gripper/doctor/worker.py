# SPDX-License-Identifier: Apache-2.0
"""A process that runs one table of the doctor's checks: JSON in, a line of JSON for each event.

``python -m spiral_gripper.doctor.worker '{"table": MODULE, "gripper": null, "marks": {}}'``
runs the checks that ``marks`` does not name yet. Standard output belongs to this protocol alone:
whatever a library prints goes to standard error.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict
from importlib import import_module
from typing import Any

from spiral_gripper.doctor.checks import Facts, Finding, Mark, finding_of


def finding_as_dict(finding: Finding) -> dict[str, Any]:
    """Return a finding as JSON knows it.

    Example:
        >>> finding_as_dict(Finding(Mark.OK, "fine"))
        {'mark': 'ok', 'text': 'fine', 'advice': '', 'commands': []}
    """
    return {**asdict(finding), "mark": finding.mark.name.lower(), "commands": [*finding.commands]}


def finding_from_dict(fields: Mapping[str, Any]) -> Finding:
    """Return the finding that :func:`finding_as_dict` wrote."""
    return Finding(
        Mark[fields["mark"].upper()], fields["text"], fields["advice"], tuple(fields["commands"])
    )


def run_table(request: Mapping[str, Any], send: Callable[[dict[str, Any]], None]) -> None:
    """Run the checks of a table that have no mark yet.

    Args:
        request: ``table``, ``gripper`` and ``marks``, as in this module's description.
        send: gets each event: a check begins, a check has found something.
    """
    marks = {name: Mark[mark.upper()] for name, mark in request["marks"].items()}
    facts = Facts.here(request["gripper"])
    table = import_module(request["table"])
    for check in table.checks(facts):
        if check.name in marks:
            continue
        send(
            {
                "section": table.SECTION,
                "name": check.name,
                "title": check.title,
                "time_limit": check.time_limit,
            }
        )
        finding = finding_of(check, facts, marks)
        marks[check.name] = finding.mark
        send({"finding": finding_as_dict(finding)})


def main() -> None:
    """Run the table that the command line asks for."""
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as channel:
        os.dup2(2, 1)

        def send(event: dict[str, Any]) -> None:
            channel.write(f"{json.dumps(event)}\n")
            channel.flush()

        run_table(json.loads(sys.argv[1]), send)
        send({"end": True})


if __name__ == "__main__":
    main()
