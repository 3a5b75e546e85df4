# SPDX-License-Identifier: Apache-2.0
"""One question asked everywhere: do all commands call the same objects wrapped?

``python -m benchmarks.verdicts`` asks whether a gripper wraps an object, and from which pressure:
the commands ``wrap`` and ``grip``, the Python API, the studio and what the node computes for
``plan_wrap``. Grippers are those shipped and 50 random designs, mounted in any direction, some of
them exactly along an axis; the object lies where the free coil fits best, or in a direction that is
known. A verdict that differs, or a pressure by more than 0.5 %, is a contradiction. Answers are
kept in ``benchmarks/results/verdicts.jsonl`` as they come: a run that was interrupted goes on;
delete the file to begin anew.
"""

from __future__ import annotations

import argparse
import io
import json
import math
import shlex
import threading
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, replace

import numpy as np
from rich.progress import track

from benchmarks.cases import SEED, random_direction
from benchmarks.command import wide_console
from benchmarks.report import RESULTS, show
from benchmarks.results import Table
from benchmarks.rounding import AGREE, GRAVITY, MOUNTS
from spiral_core import Gripper, SpiralError, WrapCurve, grip_window, lay_into_coil
from spiral_core.grip.curve import GripQuestion
from spiral_core.grip.setup import friction_of
from spiral_core.grip.tabulate import solve_curve
from spiral_gripper import available_grippers, load_gripper
from spiral_gripper.cli.main import run
from spiral_gripper.files.description import load_description
from spiral_gripper.studio.session import Answer, Session
from spiral_gripper.studio.settings import settings_of

KEPT = RESULTS / "verdicts.jsonl"
DESIGNS = RESULTS / "designs"
QUESTIONS, DESIGNED = 500, 50
# Of the questions: on an exact mount, and with a known direction of the object.
EXACT, KNOWN = 0.2, 0.4
# Random designs: bore, wall and smallest object [mm], and the ratio of largest to smallest.
BORES, WALLS, SMALLEST, RATIO = (6.0, 12.0), (0.7, 1.2), (10.0, 20.0), (1.3, 2.2)
# A radius lies between these multiples of the least and the largest that the tip criterion has.
RADII = (0.9, 1.05)


@dataclass(frozen=True, slots=True)
class Question:
    """Whether a gripper wraps an object.

    Args:
        gripper: name, or path of a file.
        gravity: direction in the base frame.
        axis: direction of the object; None: as the free coil lies.
        radius: [m].
    """

    gripper: str
    gravity: tuple[float, float, float]
    axis: tuple[float, float, float] | None
    radius: float

    @property
    def options(self) -> list[str]:
        """The question on the command line."""
        given = [self.gripper, "--radius", f"{self.radius} m", "--gravity-direction"]
        given += [repr(each) for each in self.gravity]
        if self.axis is not None:
            given += ["--object-axis", *(repr(each) for each in self.axis)]
        return given


# The pressure from which the object is wrapped [Pa]; None where it never is.
Verdict = float | None


def designs() -> list[str]:
    """Return paths of random designs, computed once by the command line."""
    DESIGNS.mkdir(exist_ok=True)
    for index in track(range(DESIGNED), "designing"):
        path = DESIGNS / f"design_{index}.yaml"
        seed = 0
        while not path.exists():
            rng = np.random.default_rng((SEED, index, seed))
            bore, wall, least = (rng.uniform(*each) for each in (BORES, WALLS, SMALLEST))
            asked = ["design", "--tube", f"{bore:.1f} mm x {wall:.1f} mm"]
            asked += ["--radius-min", f"{least:.1f} mm", "--save", str(path)]
            said([*asked, "--radius-max", f"{least * rng.uniform(*RATIO):.1f} mm"])
            seed += 1
    return [str(DESIGNS / f"design_{index}.yaml") for index in range(DESIGNED)]


def said(arguments: list[str]) -> tuple[int, str]:
    """Return the exit code of a command and what it printed."""
    out = io.StringIO()
    with redirect_stdout(out), redirect_stderr(io.StringIO()):
        code = run(arguments)
    return code, out.getvalue()


def question(index: int, grippers: list[str]) -> Question:
    """Return one of the random questions."""
    rng = np.random.default_rng((SEED, index))
    name = grippers[int(rng.integers(len(grippers)))]
    gravity = random_direction(rng)
    if rng.uniform() < EXACT:
        x, y, z = np.sign(MOUNTS[int(rng.integers(len(MOUNTS)))]).tolist()
        gravity = (x, y, z)
    axis = random_direction(rng) if rng.uniform() < KNOWN else None
    gripper = replace(load_gripper(name), gravity=gravity)
    try:
        curve = WrapCurve(gripper)
        least, most = max(curve.radius_min, 5e-3), curve.radius_max
    except SpiralError:
        least, most = 0.01, 0.02
    return Question(name, gravity, axis, float(rng.uniform(RADII[0] * least, RADII[1] * most)))


def asked(question: Question) -> dict[str, Verdict]:
    """Return what each says: from which pressure the object is wrapped [Pa]; None where never."""
    return {
        "wrap": by_command("wrap", question),
        "grip": by_command("grip", question),
        "python": by_python(question),
        "studio": by_studio(question),
        "node": by_node(question),
    }


def by_command(command: str, question: Question) -> Verdict:
    """Return what a command says."""
    code, text = said([command, *question.options, "--json"])
    if not text:
        return None
    document = json.loads(text)
    return document["onset_wrap"] if code == 0 else None


def by_python(question: Question) -> Verdict:
    """Return what the Python API says."""
    gripper = mounted(question)
    try:
        return grip_window(lay_into_coil(gripper, question.radius)).onset_wrap
    except SpiralError:
        return None


def by_node(question: Question) -> Verdict:
    """Return what the node's process computes."""
    try:
        return solve_curve(GripQuestion(mounted(question), question.radius)).onset_wrap
    except SpiralError:
        return None


def by_studio(question: Question) -> Verdict:
    """Return what the studio shows."""
    done = threading.Event()
    answers: list[Answer] = []

    def take(answer: Answer) -> None:
        answers.append(answer)
        if answer.is_complete:
            done.set()

    description = load_description(question.gripper)
    gripper = replace(description.gripper, object_axis=question.axis)
    x, y, z = question.gravity
    settings = replace(
        settings_of(description, question.radius),
        tilt=math.acos(x / math.hypot(x, y, z)),
        roll=math.atan2(z, y),
        friction=friction_of(description.gripper, None),
    )
    description = replace(description, gripper=gripper)
    session = Session(description, settings, take)
    done.wait()
    session.close()
    window = answers[-1].window
    return None if window is None else window.onset_wrap


def mounted(question: Question) -> Gripper:
    """Return the gripper of a question."""
    x, y, z = (GRAVITY / math.hypot(*question.gravity) * each for each in question.gravity)
    return replace(load_gripper(question.gripper), gravity=(x, y, z), object_axis=question.axis)


def tables(found: dict[int, dict[str, Verdict]], questions: dict[int, Question]) -> list[Table]:
    """Return how many objects are wrapped, and the contradictions."""
    wrapped = Counter(name for each in found.values() for name, said in each.items() if said)
    rows = [(name, f"{len(found):,}", f"{count:,}") for name, count in wrapped.items()]
    apart = [
        (shlex.join(questions[index].options), *(_shown(said) for said in each.values()))
        for index, each in found.items()
        if not _agree(list(each.values()))
    ]
    names = list(wrapped)
    return [
        Table("One question, asked everywhere", ("of", "asked", "wrapped"), tuple(rows)),
        Table(f"{len(apart)} contradictions", ("question", *names), tuple(apart)),
    ]


def _agree(said: list[Verdict]) -> bool:
    """Return whether verdicts are the same, and pressures within the fraction."""
    known = [each for each in said if each is not None]
    same = len(known) in (0, len(said))
    return same and (not known or max(known) <= (1.0 + AGREE) * min(known))


def _shown(said: Verdict) -> str:
    """Return a verdict as text."""
    return "not wrapped" if said is None else f"{1e-3 * said:.4g} kPa"


def main() -> None:
    """Ask what is missing and show what differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--questions", type=int, default=QUESTIONS, help="how many of them")
    count = parser.parse_args().questions
    grippers = [*available_grippers(), *designs()]
    questions = {index: question(index, grippers) for index in range(count)}
    lines = KEPT.read_text(encoding="utf-8").splitlines() if KEPT.exists() else []
    found = {each["question"]: each["said"] for each in map(json.loads, lines)}
    with KEPT.open("a", encoding="utf-8") as kept:
        for index in track(range(count), "asking"):
            if index not in found:
                found[index] = asked(questions[index])
                kept.write(json.dumps({"question": index, "said": found[index]}) + "\n")
                kept.flush()
    for table in tables({index: found[index] for index in range(count)}, questions):
        show(table, wide_console())


if __name__ == "__main__":
    main()
