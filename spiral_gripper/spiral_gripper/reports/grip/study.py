# SPDX-License-Identifier: Apache-2.0
"""Studies of grips: a table, and a file from which an interrupted study can be resumed."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, fields, is_dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeAlias

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from spiral_core.errors import InvalidInputError
from spiral_core.grip.approach import ApproachTask, Trial
from spiral_core.grip.capture import CaptureOutcome
from spiral_core.grip.grip import GripCase, GripOutcome
from spiral_core.grip.setup import GripSetup
from spiral_core.wrap.gripper import Gripper
from spiral_gripper.files.shown import number, scale_of, shown, shown_message
from spiral_gripper.files.storage import FileError, read_text, reason_of, write_file

# A grip has some 500 bytes.
LARGEST_RESULTS = 100_000_000

Result: TypeAlias = GripOutcome | Trial | CaptureOutcome


class ResultFile:
    """A file of results, a JSON line each, beside what they are of.

    Args:
        path: a .jsonl file, begun or not; None keeps nothing.
        case: what all results are of, as values of JSON.
        kind: of a result that is not the outcome of closing on a misplaced object.

    Raises:
        FileError: the file cannot be read.
        InvalidInputError: a line of it is no outcome of a study.

    Attributes:
        known: results of this case that the file has already, by their key.
    """

    def __init__(self, path: Path | None, case: Sequence[Any], kind: type[Any]) -> None:
        self._path = path
        self._case = json.loads(json.dumps(case))
        self.known: dict[Any, Any] = {}
        if path is None or not path.exists():
            return
        text = read_text(path, LARGEST_RESULTS)
        whole = text
        last = text[text.rfind("\n") + 1 :]
        if '{"case"'.startswith(last[:7]):  # an interruption cut the last line off
            whole = text.removesuffix(last)
        for count, line in enumerate(whole.splitlines(), start=1):
            try:
                entry = json.loads(line)
                [*of, key], outcome = entry["case"], entry["outcome"]
                found = CaptureOutcome[outcome] if isinstance(outcome, str) else kind(**outcome)
                own = {tuple(key): found} if of == self._case else {}
            except (ValueError, KeyError, TypeError):
                requirement = "an outcome of a study by this command, in JSON"
                raise InvalidInputError(f"{path}: line {count}", line, requirement) from None
            self.known |= own
        if whole != text:
            write_file(path, whole)

    def keep(self, key: Sequence[Any], result: Result) -> None:
        """Append the result of a key at once.

        Raises:
            FileError: the file cannot be written.
        """
        if self._path is None:
            return
        if isinstance(result, CaptureOutcome):
            outcome: Any = result.name
        else:  # what is infinite by default has no number in JSON
            values = asdict(result).items()
            outcome = {name: value for name, value in values if value != math.inf}
        try:
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps({"case": [*self._case, key], "outcome": outcome}) + "\n")
        except OSError as error:
            raise FileError(str(self._path), "written", reason_of(error)) from None


def capture_file(
    path: Path | None, setup: GripSetup, pressure: float, payload: float | None
) -> ResultFile:
    """Return the outcomes of closing on misplaced objects, by their misplacement.

    Args:
        path: a .jsonl file, begun or not; None keeps nothing.
        setup: the gripper and its object in its place.
        pressure: up to which it closes [Pa].
        payload: that it has to hold [kg], or None.
    """
    gripper = setup.gripper
    asked = (setup.obstacle, setup.closing, setup.element_count, pressure, payload)
    case = (gripper.name, *gripper.gravity, _digest(gripper), _digest_of(asked))
    return ResultFile(path, case, Trial)


def approach_file(path: Path | None, task: ApproachTask) -> ResultFile:
    """Return the results of a search for approaches, by their key."""
    gripper = task.gripper
    asked = (task.radius, task.object_axis, task.gravity, task.payload, task.tilt_max)
    case = (gripper.name, gripper.friction_coefficient, *asked, _digest(gripper))
    return ResultFile(path, case, Trial)


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
    groups: dict[Gripper, list[tuple[GripCase, GripOutcome]]] = {}
    for pair in pairs:
        groups.setdefault(pair[0].gripper, []).append(pair)
    for group in groups.values():
        console.print(_table(group))
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


def key_of(case: GripCase) -> tuple[Any, ...]:
    """Return what tells a case from all others: figures, and a digest of its gripper."""
    gripper = case.gripper
    names = (gripper.name, case.radius, case.friction, *gripper.gravity, case.closing.name)
    return (*names, _digest(gripper))


def _digest(gripper: Gripper) -> str:
    """Return a digest of what a grip depends on beside mount and friction, with the version."""
    names = "tube actuation stiffness weight_per_length pressure_max object_axis turns_required"
    return _digest_of((version("spiral-gripper"), [getattr(gripper, n) for n in names.split()]))


def _digest_of(content: object) -> str:
    return hashlib.sha256(repr(_plain(content)).encode()).hexdigest()[:16]


def _plain(value: Any) -> object:  # noqa: ANN401
    """Return all that makes two values equal: a dataclass may shorten its own text."""
    if is_dataclass(value):
        compared = [getattr(value, field.name) for field in fields(value) if field.compare]
        return (type(value).__name__, _plain(compared))
    return [_plain(each) for each in value] if isinstance(value, (list, tuple)) else value
