# SPDX-License-Identifier: Apache-2.0
"""The option ``--sensitivity``: what every input changes, against the commands' own answers."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from dataclasses import replace
from io import StringIO
from typing import Any

import pytest
from rich.console import Console

from spiral_core.errors import InvalidInputError
from spiral_core.grip.window import (
    DIFFERENCE_TOLERANCE,
    PRESSURE_TOLERANCE,
    grip_window,
    sharp_onset,
)
from spiral_core.wrap.curve import WrapCurve
from spiral_gripper.cli import workers
from spiral_gripper.cli.main import run
from spiral_gripper.files.description import load_description, parse_description, vary_gripper
from spiral_gripper.reports.grip import sensitivity
from spiral_gripper.reports.grip.document import GripQuestion, setup_of
from spiral_gripper.reports.grip.sensitivity import (
    METHODS,
    Figures,
    Input,
    inputs_of,
    solve_sensitivity,
)

RADIUS = 0.02
DESCRIPTION = load_description("paper_design_70")
QUESTION = GripQuestion(DESCRIPTION.gripper, RADIUS, None)


class Here(Executor):
    """Solves in this process, at once."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def never(done: int, total: int) -> None:
    assert done <= total


@pytest.fixture
def _in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    @contextmanager
    def pool(_: int) -> Iterator[Executor]:
        yield Here()

    monkeypatch.setattr(workers, "process_pool", pool)


@pytest.mark.parametrize(
    ("field", "written", "text"),
    [
        ("tube.wall_thickness", "wall_thickness: 0.794 mm", "wall_thickness: 0.9 mm"),
        ("fibers.beta", "beta: 70 deg", "beta: 69 deg"),
        ("material.c1", "130 kPa", "143 kPa"),
    ],
)
def test_a_varied_gripper_is_that_of_the_edited_file(field: str, written: str, text: str) -> None:
    old = DESCRIPTION.source.read_text(encoding="utf-8")
    assert old.count(written) == 1
    edited = parse_description(old.replace(written, text), DESCRIPTION.source)
    value = edited.values[field]
    assert isinstance(value, float)
    varied = vary_gripper(DESCRIPTION, field, value)
    assert varied == replace(edited.gripper, pressure_max=varied.pressure_max)
    assert varied.pressure_max <= edited.gripper.pressure_max


def test_changes_of_the_tip_criterion_are_the_commands_answers() -> None:
    varied = solve_sensitivity(
        METHODS["tip"], QUESTION, DESCRIPTION, None, 0.0, Here(), progress=never
    )
    found = {each.input.name: each for each in varied.inputs}
    base = WrapCurve(DESCRIPTION.gripper).pressure_from_radius(RADIUS)
    assert varied.base == {"pressure": pytest.approx(base, rel=1e-9)}
    thicker = WrapCurve(DESCRIPTION.gripper).pressure_from_radius(RADIUS + 1e-3)
    assert found["object's radius"].more["pressure"] == pytest.approx(thicker, rel=1e-9)
    thickness = DESCRIPTION.gripper.tube.wall_thickness + 0.1e-3
    wall = vary_gripper(DESCRIPTION, "tube.wall_thickness", thickness)
    assert found["wall"].more["pressure"] == pytest.approx(
        WrapCurve(wall).pressure_from_radius(RADIUS), rel=1e-9
    )
    sizes = [each.size(varied.base, "pressure") for each in varied.inputs]
    assert sizes == sorted(sizes, reverse=True)
    # The energy is linear in the constants and the weight: all of them by a tenth is the pressure.
    factors = [found[name] for name in ("c1", "c2", "gravity or mass")]
    tenths = sum(each.changes(varied.base, "pressure")[1] for each in factors)
    assert tenths == pytest.approx(0.1 * base, rel=2e-3)  # of second order in the changes


def test_an_input_without_such_a_gripper_comes_first() -> None:
    """A family at 89.5 degrees cannot be at 90.5."""
    steep = vary_gripper(DESCRIPTION, "fibers.alpha", math.radians(89.5))
    description = replace(
        DESCRIPTION,
        gripper=steep,
        values=DESCRIPTION.values | {"fibers.alpha": math.radians(89.5)},
    )
    varied = solve_sensitivity(
        METHODS["tip"],
        GripQuestion(steep, RADIUS, None),
        description,
        None,
        0.0,
        Here(),
        progress=never,
    )
    assert varied.inputs[0].input.name == "fiber angle alpha"
    assert varied.inputs[0].more == {}
    assert varied.inputs[0].less["pressure"] is not None
    console = Console(width=80, record=True, file=StringIO())
    console.print(varied.table())
    assert "/ none" in console.export_text()


def test_an_onset_is_sharp_enough_to_be_compared() -> None:
    """To 1e-5: a radius 1e-4 thinner raises it by what one 1e-2 thinner raises it, over 100."""
    onsets = [
        sharp_onset(grip_window(setup_of(replace(QUESTION, radius=radius))[0], until_wrapped=True))
        for radius in (RADIUS, 0.9999 * RADIUS, 0.99 * RADIUS)
    ]
    rise, rise_of_more = onsets[1] - onsets[0], onsets[2] - onsets[0]
    assert rise == pytest.approx(0.01 * rise_of_more, abs=2 * DIFFERENCE_TOLERANCE * onsets[0])
    window = grip_window(setup_of(QUESTION)[0], until_wrapped=True)
    assert window.onset_wrap == pytest.approx(onsets[0], rel=PRESSURE_TOLERANCE)
    empty = replace(window, onset_wrap=None)
    with pytest.raises(InvalidInputError):
        sharp_onset(empty)


@pytest.mark.long
@pytest.mark.usefixtures("_in_this_process")
def test_commands_print_what_inputs_change(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Friction, pressure and radius of a grip; the radius against a wrap of that radius."""
    wanted = ("friction", "pressure", "object's radius")
    every = inputs_of

    def few(*asked: Any) -> Iterator[Input]:
        return (each for each in every(*asked) if each.name in wanted)

    monkeypatch.setattr(sensitivity, "inputs_of", few)
    asked = ["paper_design_70", "--radius", "20 mm", "--sensitivity"]
    assert run(["grip", *asked, "--pressure", "60 kPa", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    base: Figures = answer["sensitivity_at"]
    away = answer["at_pressure"]["holding_force_away"]
    assert base["holding_force_away"] == pytest.approx(away, rel=1e-9)
    found = {each["input"]: each for each in answer["sensitivity"]}
    assert set(found) == set(wanted)
    assert found["friction"]["unit"] == "of its value"
    for name in ("friction", "pressure"):
        less, more = (found[name][side]["holding_force_away"] for side in ("less", "more"))
        assert less < away < more
    assert found["pressure"]["more"]["onset_wrap"] == base["onset_wrap"]
    assert run(["wrap", *asked]) == 0
    said = capsys.readouterr().out
    assert "by so much less / more" in said
    assert "object's radius ±1 mm" in said
    assert run(["wrap", "paper_design_70", "--radius", "21 mm", "--json"]) == 0
    thicker = json.loads(capsys.readouterr().out)["onset_wrap"]
    more = found["object's radius"]["more"]["onset_wrap"]
    assert more == pytest.approx(thicker, rel=PRESSURE_TOLERANCE)
