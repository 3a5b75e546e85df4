# SPDX-License-Identifier: Apache-2.0
"""The command ``close``: what it prints, draws and keeps after Ctrl-C."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from spiral_core import (
    Damping,
    PressureCourse,
    RodStatus,
    SolverError,
    close_on,
    holding_force,
    lay_into_coil,
)
from spiral_core.grip.closing import slow_closing
from spiral_core.grip.setup import hanging_tube
from spiral_core.grip.window import GripPoint
from spiral_gripper.cli.main import run
from spiral_gripper.files.description import load_description
from spiral_gripper.reports.closing import document
from spiral_gripper.reports.closing.document import CLOSE, CloseQuestion, solve_close
from spiral_gripper.reports.fields import document_of, rows_of
from spiral_gripper.reports.grip.plots import object_surface

pytestmark = pytest.mark.long

ASKED = ["close", "paper_design_70", "--radius", "20 mm", "--rate", "500 kPa/s", "--wait", "0.2 s"]


def test_a_fast_closing_is_told_drawn_and_animated(tmp_path, capsys) -> None:
    plot, film = tmp_path / "closing.png", tmp_path / "closing.gif"
    assert run([*ASKED, "--json", "--plot", str(plot), "--animate", str(film)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["complete"]
    assert told["time_to_touch"] is None or told["time_to_touch"] > 0.0
    assert told["frames"][-1]["pressure"] == pytest.approx(told["pressure"])
    assert len(told["frames"][0]["tip"]) == 3
    assert not told["orderly"]
    forces, spread = told["holding_forces"], told["spread"]
    for value, (low, high) in (
        (told["contact_fraction"], spread["contact_fraction"]),
        *((forces[pull], spread["holding_forces"][pull]) for pull in forces),
    ):
        assert low <= value <= high
    assert plot.read_bytes().startswith(b"\x89PNG")
    assert film.read_bytes().startswith(b"GIF89a")


def test_an_orderly_closing_is_repeated_on_request_only() -> None:
    gripper = load_description("paper_design_70").gripper
    question = CloseQuestion(gripper, 0.02, 5e4, 1e4, 0.2, None, Damping(), advise=False)
    plain, repeated = solve_close(question), solve_close(replace(question, spread=True))
    assert plain.orderly
    assert plain.spread is None
    assert " to " not in dict(rows_of(CLOSE, plain))["presses with"]
    assert " to " in dict(rows_of(CLOSE, repeated))["presses with"]
    assert document_of(CLOSE, plain)["spread"] is None


def test_an_interrupt_keeps_what_was_computed() -> None:
    gripper = load_description("paper_design_70").gripper
    question = CloseQuestion(gripper, 0.02, 5e5, None, 0.2, None, Damping(), advise=False)

    def interrupted(done: int, _: int) -> None:
        if done == 5:
            raise KeyboardInterrupt

    solved = solve_close(question, interrupted)
    assert len(solved.closing.frames) == 5
    assert not solved.closing.is_complete
    assert not solved.forces
    assert "NOT COMPLETE" in dict(rows_of(CLOSE, solved))
    assert document_of(CLOSE, solved)["complete"] is False


def test_an_interrupted_advice_keeps_the_closing_and_the_rates_that_are_done(monkeypatch) -> None:
    monkeypatch.setattr(document, "closing_spread", lambda *_, **__: None)
    monkeypatch.setattr(document, "RISES", (0.1, 0.2))
    gripper = load_description("paper_design_70").gripper
    question = CloseQuestion(gripper, 0.02, 5e5, None, 0.2, None, Damping(), advise=True)
    total = 2 * document.FRAMES

    def interrupted(done: int, of: int) -> None:
        if of == total and done == document.FRAMES + 5:
            raise KeyboardInterrupt

    solved = solve_close(question, interrupted)
    rows = dict(rows_of(CLOSE, solved))
    assert solved.closing.is_complete
    assert len(solved.forces) == 2
    assert solved.advice.rates == (solved.pressure / 0.2,)
    assert solved.advice.fastest in (None, solved.pressure / 0.2)
    assert "INTERRUPTED" in rows
    assert "NOT COMPLETE" not in rows
    assert document_of(CLOSE, solved)["complete"] is False


def test_a_tube_whose_hanging_state_is_not_found_is_answered_all_the_same(monkeypatch) -> None:
    monkeypatch.setattr(document, "closing_spread", lambda *_, **__: None)

    def lost(*_: object, **__: object) -> None:
        raise SolverError(RodStatus.NOT_HELD, 1.0, 1)

    monkeypatch.setattr(document, "settling_after_move", lost)
    gripper = load_description("paper_design_70").gripper
    solved = solve_close(CloseQuestion(gripper, 0.02, 5e5, None, 0.2, None, Damping(), False))
    assert dict(rows_of(CLOSE, solved))["hanging tube swings at"] == "not known"
    assert document_of(CLOSE, solved)["hanging_frequency"] is None


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--rate", "1e-9 kPa/s"], "rate must be at least"),
        (["--animate", "/nowhere/closing.gif"], "no folder /nowhere"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_computed(more, said, capsys) -> None:
    assert run([*ASKED, *more]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(("within", "text"), [(0.03, "4.46 s"), (0.1, "4.5 s"), (0.6, "4 s")])
def test_times_are_printed_as_finely_as_they_are_known(within: float, text: str) -> None:
    assert document._seconds(4.456, within) == text


def test_the_object_of_an_animation_has_one_length() -> None:
    setup = lay_into_coil(load_description("paper_design_70").gripper, 0.02)
    hanging = GripPoint(0.0, setup, hanging_tube(setup))
    lengths = []
    for reach in (None, (-0.3, 0.1)):
        surface = object_surface(hanging, reach)
        heights = (
            surface.triangles.reshape(-1, 3) - np.asarray(setup.obstacle.position)
        ) @ setup.axis
        lengths.append(np.ptp(heights))
    assert lengths[1] == pytest.approx(0.4 + 8.0 * hanging.outer_radius, rel=1e-6)
    assert lengths[0] != pytest.approx(lengths[1], rel=0.01)


def test_a_whip_that_no_step_resolves_is_damped_and_does_not_grow() -> None:
    """Closed within 0.06 s, of the random closings; the tip's speed used to grow without end."""
    gripper = load_description("paper_design_70").gripper
    mounted = replace(gripper, gravity=(-3.6647440504628714, 9.08108194442507, 0.5234367065213805))
    setup = lay_into_coil(mounted, 0.01064857027254252, friction=0.327075422011259)
    pressure = 103495.56108724188
    closing = close_on(setup, PressureCourse.ramp(pressure / 0.057511869201622226, pressure, 0.5))
    assert closing.is_complete
    assert max(np.abs(frame.velocities).max() for frame in closing.frames) < 10.0


@pytest.mark.slow
def test_pulses_keep_the_grip_that_one_fast_rise_loses() -> None:
    """The table of courses in docs/closing.md: a valve that always rises at 60 kPa/s."""
    setup = lay_into_coil(load_description("paper_design_70").gripper, 0.02)
    pressure, rate, wait = 1.15 * setup.tip_pressure, 6e4, 3.0
    pulse, pause = pressure / 8.0 / rate, 0.25
    times, pressures = [0.0], [0.0]
    for level in np.arange(1, 9) * pressure / 8.0:
        times += [times[-1] + pulse, times[-1] + pulse + pause]
        pressures += [level, level]
    times[-1] += wait
    rise, change = pressure / rate, np.array((0.1, 0.3)) * pressure / rate
    over, down = rise + change
    courses = {
        "straight": PressureCourse.ramp(rate, pressure, wait),
        "overshoot": PressureCourse(
            (0.0, over, over + 0.5 * wait, over + 0.5 * wait + change[0], over + wait + change[0]),
            (0.0, 1.1 * pressure, 1.1 * pressure, pressure, pressure),
        ),
        "squeezed twice": PressureCourse(
            (
                0.0,
                rise,
                rise + 0.5 * wait,
                down + 0.5 * wait,
                down + change[1] + 0.5 * wait,
                down + change[1] + wait,
            ),
            (0.0, pressure, pressure, 0.7 * pressure, pressure, pressure),
        ),
        "pulses": PressureCourse(tuple(times), tuple(pressures)),
    }
    slow = holding_force(slow_closing(setup, pressure)).force
    kept = {name: close_on(setup, c).holding_force().force / slow for name, c in courses.items()}
    assert slow == pytest.approx(0.465, rel=0.01)
    assert kept["pulses"] == pytest.approx(1.03, abs=0.05)
    for name in ("straight", "overshoot", "squeezed twice"):
        assert kept[name] < 0.25
