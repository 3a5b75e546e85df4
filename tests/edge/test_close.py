# SPDX-License-Identifier: Apache-2.0
"""The command ``close``: what it prints, draws and keeps after Ctrl-C."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

from spiral_core import (
    Damping,
    PressureCourse,
    RodStatus,
    SolverError,
    close_on,
    lay_into_coil,
)
from spiral_core.grip.setup import hanging_tube
from spiral_core.grip.window import GripPoint
from spiral_gripper.files.description import load_description
from spiral_gripper.reports.closing import document
from spiral_gripper.reports.closing.document import CLOSE, CloseQuestion, solve_close
from spiral_gripper.reports.fields import document_of, rows_of
from spiral_gripper.reports.grip.plots import object_surface

pytestmark = pytest.mark.long

GRIPPER = load_description("paper_design_70").gripper
FAST = CloseQuestion(GRIPPER, 0.02, 5e5, None, 0.2, None, Damping(), advise=False)


def told(solved):
    """Return what people and what programs are told."""
    return dict(rows_of(CLOSE, solved)), document_of(CLOSE, solved)


def test_an_interrupt_keeps_what_was_computed_and_a_hanging_state_may_be_unknown(monkeypatch):
    def interrupted(done, _):
        if done == 5:
            raise KeyboardInterrupt

    lost = Mock(side_effect=SolverError(RodStatus.NOT_HELD, 1.0, 1))
    monkeypatch.setattr(document, "settling_after_move", lost)
    solved = solve_close(FAST, interrupted)
    rows, data = told(solved)
    assert (len(solved.closing.frames), solved.forces, data["complete"]) == (5, (), False)
    assert "NOT COMPLETE" in rows
    assert data["hanging_frequency"] is None


def test_what_an_interrupt_leaves_out_is_not_told(monkeypatch):
    monkeypatch.setattr(document, "slow_closing", Mock(side_effect=KeyboardInterrupt))
    rows, data = told(solve_close(FAST))
    assert "INTERRUPTED" in rows
    assert "closed slowly" not in rows
    assert (data["complete"], data["wraps_slowly"]) == (False, None)


def test_an_interrupted_advice_keeps_the_closing_and_the_rates_that_are_done(monkeypatch):
    monkeypatch.setattr(document, "closing_spread", lambda *_, **__: None)
    monkeypatch.setattr(document, "RISES", (0.1, 0.2))

    def interrupted(done, of):
        if (done, of) == (document.FRAMES + 5, 2 * document.FRAMES):
            raise KeyboardInterrupt

    solved = solve_close(replace(FAST, advise=True), interrupted)
    rows, data = told(solved)
    assert (solved.closing.is_complete, len(solved.forces), data["complete"]) == (True, 2, False)
    assert solved.advice.rates == (solved.pressure / 0.2,)
    assert {"INTERRUPTED", "NOT COMPLETE"} & rows.keys() == {"INTERRUPTED"}


@pytest.mark.parametrize(
    ("asked", "slowly"),
    [
        ({"pressure": 3e4}, "too low, or too high"),
        ({"pressure": 1e5}, "too low, or too high"),
        ({"friction": 0.0}, None),
    ],
)
def test_what_does_not_hold_when_closed_slowly_gets_no_advice(monkeypatch, asked, slowly):
    monkeypatch.setattr(document, "closing_spread", lambda *_, **__: None)
    rows, data = told(solve_close(replace(FAST, advise=True, **asked)))
    assert ("closed slowly" in rows) == (slowly is not None) == (not data["wraps_slowly"])
    assert slowly is None or rows["closed slowly"].endswith(slowly)
    assert (rows["closed slowly it holds"] == "0 N") == (asked == {"friction": 0.0})
    assert rows["fastest that keeps 90 %"].startswith("no advice")
    assert (data["advice"]["rates"], data["advice"]["fastest_rate"]) == ([], None)


def test_an_upright_tube_closes_though_it_swings_freely():
    rows, data = told(
        solve_close(replace(FAST, gripper=replace(GRIPPER, gravity=(-9.8, 0.0, 0.0))))
    )
    assert rows["upright, without pressure"].startswith("may fall to any side")
    assert rows["hanging tube swings at"] == "not known"
    assert data["complete"]
    assert data["hanging_frequency"] is data["hanging_settling_time"] is None


def test_the_object_of_an_animation_has_one_length():
    setup = lay_into_coil(GRIPPER, 0.02)
    hanging = GripPoint(0.0, setup, hanging_tube(setup))
    length = np.ptp(object_surface(hanging, (-0.3, 0.1)).triangles @ setup.axis)
    assert length == pytest.approx(0.4 + 8.0 * hanging.outer_radius, rel=1e-6)


def test_a_whip_that_no_step_resolves_is_damped_and_does_not_grow():
    """Closed within 0.06 s, of the random closings; the tip's speed used to grow without end."""
    mounted = replace(GRIPPER, gravity=(-3.6647440504628714, 9.08108194442507, 0.5234367065213805))
    setup = lay_into_coil(mounted, 0.01064857027254252, friction=0.327075422011259)
    pressure = 103495.56108724188
    closing = close_on(setup, PressureCourse.ramp(pressure / 0.057511869201622226, pressure, 0.5))
    assert closing.is_complete
    assert max(np.abs(frame.velocities).max() for frame in closing.frames) < 10.0
