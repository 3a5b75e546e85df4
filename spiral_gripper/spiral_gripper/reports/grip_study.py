# SPDX-License-Identifier: Apache-2.0
"""Studies of grips: a table, and a file from which an interrupted study can be resumed."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from spiral_core.errors import InvalidInputError
from spiral_core.grip.study import GripCase, GripOutcome
from spiral_gripper.files.shown import number, reworded, scale_of, shown
from spiral_gripper.files.storage import FileError, read_text, reason_of, write_file


class StudyFile:
    """The outcomes of a study, a JSON line each, beside what they are of.

    Args:
        path: a .jsonl file, begun or not; None keeps nothing.
        cases: of the study.

    Raises:
        FileError: the file cannot be read.
        InvalidInputError: a line of it is no outcome of a study.

    Attributes:
        known: outcomes that the file has already, by the number of their case.
    """

    def __init__(self, path: Path | None, cases: Sequence[GripCase]) -> None:
        self._path = path
        self._cases = cases
        self.known: dict[int, GripOutcome] = {}
        if path is None or not path.exists():
            return
        keys = {_key(case): number for number, case in enumerate(cases)}
        text = read_text(path)
        if text and not text.endswith("\n"):  # the line that an interruption cut off
            text = text[: text.rfind("\n") + 1]
            write_file(path, text)
        for count, line in enumerate(text.splitlines(), start=1):
            try:
                entry = json.loads(line)
                key, outcome = entry["case"], GripOutcome(**entry["outcome"])
            except (ValueError, KeyError, TypeError):
                requirement = "an outcome of a study, in JSON"
                raise InvalidInputError(f"{path}: line {count}", line, requirement) from None
            number = keys.get(json.dumps(key))
            if number is not None:
                self.known[number] = outcome

    def keep(self, number: int, outcome: GripOutcome) -> None:
        """Append an outcome at once.

        Raises:
            FileError: the file cannot be written.
        """
        if self._path is None:
            return
        entry = {"case": json.loads(_key(self._cases[number])), "outcome": asdict(outcome)}
        try:
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(entry) + "\n")
        except OSError as error:
            raise FileError(str(self._path), "written", reason_of(error)) from None


def case_as_dict(case: GripCase, outcome: GripOutcome) -> dict[str, Any]:
    """Return a grip of a study for programs, in SI."""
    return {
        "gripper": case.gripper.name,
        "radius": case.radius,
        "friction": case.friction,
        "gravity": list(case.gripper.gravity),
        **asdict(outcome),
    }


def print_outcomes(
    cases: Sequence[GripCase], outcomes: Sequence[GripOutcome], console: Console
) -> None:
    """Print a line for each grip; refusals with their reason below."""
    units = ", ".join(scale_of(unit).unit for unit in ("Pa", "N"))
    title = f"{len(cases)} grips, forces at the recommended pressure [{units}]"
    table = Table(title=escape(title))
    columns = ("gripper", "radius", "friction", "gravity", "wrapped", "curls", "lost", "at")
    for column in (*columns, "away", "towards"):
        table.add_column(column, justify="left" if column == "gripper" else "right")
    for case, outcome in zip(cases, outcomes, strict=True):
        pressures = (outcome.onset_wrap, outcome.onset_curling, outcome.loss, outcome.pressure)
        forces = (outcome.away, outcome.towards)
        table.add_row(
            case.gripper.name,
            shown(case.radius, "m"),
            f"{case.friction:.3g}",
            " ".join(f"{g:.3g}" for g in case.gripper.gravity),
            *("-" if p is None else number(p, "Pa") for p in pressures),
            *("-" if force is None else number(force, "N", 3) for force in forces),
        )
    console.print(table)
    for case, outcome in zip(cases, outcomes, strict=True):
        if outcome.refusal:
            name, radius = case.gripper.name, shown(case.radius, "m")
            console.print(f"{name}, {radius}: {reworded(outcome.refusal)}")


def _key(case: GripCase) -> str:
    """Return what tells a case from all others."""
    gripper = case.gripper
    rod = (gripper.tube.length, gripper.stiffness.bending, gripper.pressure_max)
    key = [gripper.name, *rod, *gripper.gravity, case.radius, case.friction, case.closing.name]
    return json.dumps(key)
