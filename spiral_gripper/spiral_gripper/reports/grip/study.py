# SPDX-License-Identifier: Apache-2.0
"""Studies of grips: a table, and a file from which an interrupted study can be resumed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from importlib.metadata import version
from itertools import groupby
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from spiral_core.errors import InvalidInputError
from spiral_core.grip.approach import ApproachTask, Found, Key, Trial
from spiral_core.grip.capture import CaptureOutcome, Misplacement
from spiral_core.grip.grip import GripCase, GripOutcome
from spiral_core.grip.setup import GripSetup
from spiral_core.wrap.gripper import Gripper
from spiral_gripper.files.shown import number, scale_of, shown, shown_message
from spiral_gripper.files.storage import FileError, read_text, reason_of, write_file

# Pressures at which two grippers' rods are compared, to tell whether they are the same.
COMPARED_PRESSURES = 9

Outcome = TypeVar("Outcome")


class LineFile(Generic[Outcome]):
    """A file of outcomes, a JSON line each, beside what they are of.

    Args:
        path: a .jsonl file, begun or not; None keeps nothing.
        outcome_of: makes an outcome from what a line has of it.

    Raises:
        FileError: the file cannot be read.
        InvalidInputError: a line of it is no outcome of a study.

    Attributes:
        kept: outcomes that the file has already, by what they are of, in JSON.
    """

    def __init__(self, path: Path | None, outcome_of: Callable[[Any], Outcome]) -> None:
        self._path = path
        self.kept: dict[str, Outcome] = {}
        if path is None or not path.exists():
            return
        text = read_text(path)
        whole = text
        last = text[text.rfind("\n") + 1 :]
        if '{"case"'.startswith(last[:7]):  # an interruption cut the last line off
            whole = text.removesuffix(last)
        for count, line in enumerate(whole.splitlines(), start=1):
            try:
                entry = json.loads(line)
                [*key], outcome = entry["case"], outcome_of(entry["outcome"])
            except (ValueError, KeyError, TypeError):
                requirement = "an outcome of a study, in JSON"
                raise InvalidInputError(f"{path}: line {count}", line, requirement) from None
            self.kept[json.dumps(key)] = outcome
        if whole != text:
            write_file(path, whole)

    def under(self, case: Sequence[Any]) -> dict[tuple[Any, ...], Outcome]:
        """Return outcomes by the list that ends their case, of those that begin with ``case``."""
        start = json.loads(json.dumps(case))
        found: dict[tuple[Any, ...], Outcome] = {}
        for text, outcome in self.kept.items():
            key = json.loads(text)
            if key[:-1] == start and isinstance(key[-1], list):
                found[tuple(key[-1])] = outcome
        return found

    def append(self, case: Sequence[Any], outcome: object) -> None:
        """Append an outcome at once.

        Args:
            case: what it is of, as values of JSON.
            outcome: likewise.

        Raises:
            FileError: the file cannot be written.
        """
        if self._path is None:
            return
        try:
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps({"case": list(case), "outcome": outcome}) + "\n")
        except OSError as error:
            raise FileError(str(self._path), "written", reason_of(error)) from None


class StudyFile:
    """The outcomes of a study of grips in a :class:`LineFile`.

    Args:
        path: a .jsonl file, begun or not; None keeps nothing.
        cases: of the study.

    Attributes:
        known: outcomes that the file has already, by the number of their case.
    """

    def __init__(self, path: Path | None, cases: Sequence[GripCase]) -> None:
        self._keys = [_key(case) for case in cases]
        self._file = LineFile(path, lambda outcome: GripOutcome(**outcome))
        numbers = {json.dumps(key): number for number, key in enumerate(self._keys)}
        kept = self._file.kept
        self.known = {numbers[key]: kept[key] for key in kept if key in numbers}

    def keep(self, number: int, outcome: GripOutcome) -> None:
        """Append an outcome at once; see :meth:`LineFile.append`."""
        self._file.append(self._keys[number], asdict(outcome))


class CaptureFile:
    """The outcomes of closing on misplaced objects in a :class:`LineFile`.

    Args:
        path: a .jsonl file, begun or not; None keeps nothing.
        setup: the gripper and its object in its place.
        pressure: up to which it closes [Pa].
        payload: that it has to hold [kg], or None.

    Attributes:
        known: outcomes that the file has already, by their misplacement.
    """

    def __init__(
        self, path: Path | None, setup: GripSetup, pressure: float, payload: float | None
    ) -> None:
        asked = (setup.obstacle, setup.closing, setup.element_count, pressure, payload)
        digest = hashlib.sha256(repr(asked).encode()).hexdigest()[:16]
        self._key = [setup.gripper.name, *setup.gripper.gravity, _digest(setup.gripper), digest]
        self._file = LineFile(path, CaptureOutcome.__getitem__)
        self.known: dict[Misplacement, CaptureOutcome] = self._file.under(self._key)

    def keep(self, misplacement: Misplacement, outcome: CaptureOutcome) -> None:
        """Append an outcome at once; see :meth:`LineFile.append`."""
        self._file.append([*self._key, misplacement], outcome.name)


class ApproachFile:
    """Results of a search for approaches in a :class:`LineFile`.

    Args:
        path: a .jsonl file, begun or not; None keeps nothing.
        task: what is searched for.

    Attributes:
        known: results that the file has already, by their key.
    """

    def __init__(self, path: Path | None, task: ApproachTask) -> None:
        gripper = task.gripper
        asked = (task.radius, task.object_axis, task.gravity, task.payload, task.tilt_max)
        self._case = [gripper.name, gripper.friction_coefficient, *asked, _digest(gripper)]
        self._file = LineFile(path, _approach_result)
        self.known: dict[Key, Found] = self._file.under(self._case)

    def keep(self, key: Key, found: Found) -> None:
        """Append a result at once; see :meth:`LineFile.append`."""
        outcome = asdict(found) if isinstance(found, Trial) else found.name
        self._file.append([*self._case, key], outcome)


def _approach_result(value: Any) -> Found:  # noqa: ANN401
    return CaptureOutcome[value] if isinstance(value, str) else Trial(**value)


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


def _key(case: GripCase) -> list[Any]:
    """Return what tells a case from all others: figures, and a digest of its gripper."""
    gripper = case.gripper
    names = (gripper.name, case.radius, case.friction, *gripper.gravity, case.closing.name)
    return [*names, _digest(gripper)]


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
