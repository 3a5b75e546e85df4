# SPDX-License-Identifier: Apache-2.0
"""Studies of grips: a table, and a file from which an interrupted study can be resumed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import version
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from spiral_core.errors import InvalidInputError
from spiral_core.grip.grip import GripCase, GripOutcome
from spiral_core.wrap.gripper import Gripper
from spiral_gripper.files.shown import number, scale_of, shown, shown_message
from spiral_gripper.files.storage import FileError, read_text, reason_of, write_file

# Pressures at which two grippers' rods are compared, to tell whether they are the same.
COMPARED_PRESSURES = 9


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
        whole = text
        last = text[text.rfind("\n") + 1 :]
        if '{"case"'.startswith(last[:7]):  # an interruption cut the last line off
            whole = text.removesuffix(last)
        for count, line in enumerate(whole.splitlines(), start=1):
            try:
                entry = json.loads(line)
                key, outcome = entry["case"], GripOutcome(**entry["outcome"])
            except (ValueError, KeyError, TypeError):
                requirement = "an outcome of a study, in JSON"
                raise InvalidInputError(f"{path}: line {count}", line, requirement) from None
            number = keys.get(json.dumps(key))
            if number is not None:
                self.known[number] = outcome
        if whole != text:
            write_file(path, whole)

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
    """Print a table for each gripper and mount; refusals with their reason below."""
    pairs = list(zip(cases, outcomes, strict=True))
    for _, group in groupby(
        pairs, key=lambda pair: (pair[0].gripper.name, pair[0].gripper.gravity)
    ):
        console.print(_table(list(group)))
    for case, outcome in pairs:
        if outcome.refusal:
            name, radius = case.gripper.name, shown(case.radius, "m")
            console.print(escape(f"{name}, {radius}: {shown_message(outcome.refusal)}"))


def _table(grips: list[tuple[GripCase, GripOutcome]]) -> Table:
    """Return the grips of one gripper on one mount."""
    gripper = grips[0][0].gripper
    units = ", ".join(scale_of(unit).unit for unit in ("Pa", "N"))
    gravity = " ".join(f"{component:.3g}" for component in gripper.gravity)
    table = Table(
        title=escape(f"{gripper.name}, gravity ({gravity}), {len(grips)} grips"),
        caption=escape(f"forces at the recommended pressure [{units}]; > at least, ? not known"),
    )
    columns = ("radius", "friction", "wrapped", "curls", "lost", "at", "away", "towards")
    for column in columns:
        table.add_column(column, justify="right")
    for case, outcome in grips:
        unknown = "-" if outcome.refusal else "?"
        pressures = (outcome.onset_wrap, outcome.onset_curling, outcome.loss, outcome.pressure)
        table.add_row(
            shown(case.radius, "m"),
            f"{case.friction:.3g}",
            *("-" if p is None else number(p, "Pa") for p in pressures),
            _force(outcome.away, outcome.away_is_lower_bound, unknown),
            _force(outcome.towards, outcome.towards_is_lower_bound, unknown),
        )
    return table


def _force(force: float | None, is_lower_bound: bool, unknown: str) -> str:
    if force is None:
        return unknown
    return ("> " if is_lower_bound else "") + number(force, "N", 3)


def _key(case: GripCase) -> str:
    """Return what tells a case from all others: figures, and a digest of its gripper."""
    gripper = case.gripper
    names = (gripper.name, case.radius, case.friction, *gripper.gravity, case.closing.name)
    return json.dumps([*names, _digest(gripper)])


def _digest(gripper: Gripper) -> str:
    """Return a digest of what a grip depends on: rod and weight over pressure, the version."""
    shapes = [
        gripper.unloaded_shape(float(pressure))
        for pressure in np.linspace(0.0, gripper.pressure_max, COMPARED_PRESSURES)
    ]
    rods = [(asdict(gripper.rod(shape)), gripper.weight(shape)) for shape in shapes]
    limits = (gripper.pressure_max, gripper.object_axis, gripper.turns_required)
    content = (version("spiral-gripper"), asdict(gripper.tube), shapes, rods, limits)
    return hashlib.sha256(repr(content).encode()).hexdigest()[:16]
