# SPDX-License-Identifier: Apache-2.0
"""The loss of a grip: where it is, what remains of the coil after it, and what that holds."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.held import random_setup
from spiral_core import (
    Actuator,
    Closing,
    FiberAngles,
    GripSetup,
    NeoHookean,
    Pull,
    RodStatus,
    Tube,
    WrapRegime,
    grip_window,
    gripper_from_actuator,
    holding_force,
    lay_into_coil,
    solve_grip,
)
from spiral_core.grip import window as windows
from spiral_core.grip.grip import RangeEnd
from spiral_core.grip.holding import PullEnd, pull_direction
from spiral_core.grip.window import GripPoint, GripWindow, WindowEnd, follow_loss
from spiral_core.rod.state import RodEvent, RodPath
from spiral_gripper import load_description, load_gripper

pytestmark = pytest.mark.long

NOT_HELD = RodStatus.NOT_HELD
# Pressures, as fractions of the tip criterion's, up to beyond the loss.
UP_TO_LOSS = (0.6, 0.9, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8)


def thin_setup(
    name: str = "prototype_p2",
    length: float = 0.45286,
    radius: float = 9.4135e-3,
    friction: float = 0.62303,
    closing: Closing = Closing.SLOW,
) -> GripSetup:
    """Return a gripper on an object; by default on a thin one with much friction."""
    described = load_description(name)
    tube = replace(described.actuator.tube, length=length)
    gripper = gripper_from_actuator(
        name, replace(described.actuator, tube=tube), density=described.density
    )
    return lay_into_coil(gripper, radius, friction=friction, closing=closing)


@cache
def lost(*described: str | float, closing: Closing = Closing.SLOW) -> GripWindow:
    """Return the window of :func:`thin_setup` up to its loss."""
    setup = thin_setup(*described, closing=closing)
    return grip_window(setup, [fraction * setup.tip_pressure for fraction in UP_TO_LOSS])


@cache
def rest() -> GripPoint:
    found = follow_loss(lost())
    assert found is not None
    return found


def test_with_friction_the_end_lets_go_and_most_of_the_contact_stays() -> None:
    """Two of three turns stay: the tip is five object's radii away, friction holds the others."""
    window = lost()
    assert window.end is WindowEnd.LOST
    assert window.loss is not None
    before = window.points[-1]
    assert before.is_wrapped
    assert not rest().is_wrapped
    assert rest().tip_gap > 3.0 * 9.4e-3
    assert 0.5 * before.contact_length < rest().contact_length < 0.8 * before.contact_length
    assert 1.5 < rest().turns < before.turns - 0.5
    assert 0.2 * before.normal_force < rest().normal_force < before.normal_force


def test_what_remains_still_holds_something() -> None:
    assert holding_force(rest(), Pull.AWAY).force > 0.1


def test_without_friction_the_same_coil_loses_most_of_its_contact() -> None:
    window = lost(closing=Closing.FRICTIONLESS)
    fallen = follow_loss(window)
    assert not fallen.is_wrapped
    assert fallen.contact_length < 0.5 * window.points[-1].contact_length


@pytest.mark.slow
def test_a_fall_is_followed_until_the_end_has_let_go() -> None:
    """With friction the end of the branch is found up to a percent early: the coil still clings."""
    window = lost("prototype_p1", 0.40407, 12.4294e-3, 0.63968)
    fallen = follow_loss(window)
    assert not fallen.is_wrapped
    assert window.loss < fallen.pressure <= 1.02 * window.loss


def test_a_part_near_the_base_may_snap_while_the_end_stays_wrapped() -> None:
    """The loss is the first event, also where it leaves the whole length in contact.

    It is a snap of 3 mm, which larger steps of pressure may step over.
    """
    setup = thin_setup("paper_design_70", 0.46329, 7.29616e-3, 0.75005)
    window = grip_window(setup, [90e3, 120e3, *np.arange(150e3, 165e3, 500.0)])
    fallen = follow_loss(window)
    assert window.end is WindowEnd.LOST
    assert fallen.is_wrapped
    moved = np.linalg.norm(fallen.state.positions - window.points[-1].state.positions, axis=1)
    assert 2e-3 < moved.max() < 10e-3
    assert np.argmax(moved) < 0.2 * len(moved)


def test_a_tube_that_is_pulled_taut_is_not_what_holds_a_payload() -> None:
    """Along gravity, 12 degrees off the object's axis, the tube would be taut after two diameters.

    It would then pull with 60 N; the object slides at 0.7 N.
    """
    setup = lay_into_coil(load_gripper("paper_design_70"), 0.01615)
    tip = setup.tip_pressure
    window = grip_window(setup, [fraction * tip for fraction in (0.6, 0.9, 0.98, 1.1)])
    away, down = (holding_force(window.points[-1], pull) for pull in (Pull.AWAY, Pull.DOWN))
    assert away.force == pytest.approx(0.73, rel=0.05)
    assert 0.5 * away.force < down.force < 1.5 * away.force
    assert down.displacement <= 2.0 * 0.01615


@pytest.mark.parametrize(
    ("closing", "tolerance"),
    [
        pytest.param(Closing.SLOW, 0.015, marks=pytest.mark.slow),
        (Closing.FRICTIONLESS, 4e-3),
    ],
)
def test_a_loss_is_the_same_by_other_stations(closing: Closing, tolerance: float) -> None:
    """Located to 0.5 % with friction, along another way to 1 %; to 0.2 % without."""
    window = lost(closing=closing)
    tip = window.setup.tip_pressure
    other = grip_window(window.setup, [f * tip for f in (0.5, 0.8, 1.05, 1.15, 1.45, 1.75)])
    assert other.loss == pytest.approx(window.loss, rel=tolerance)


def test_the_recommended_pressure_stays_below_the_loss() -> None:
    window = lost()
    grip = solve_grip(window.setup, (), pressures=(), window=window)
    assert grip.recommended_range[1] <= 0.9 * window.loss
    assert grip.onset_wrap < grip.recommended_pressure() < 0.9 * window.loss


def test_no_force_is_held_where_the_coil_pushes_that_way_itself() -> None:
    """Close below its loss a coil presses towards the base, and gives way at the first step."""
    window = grip_window(
        lay_into_coil(load_gripper("paper_design_70"), 0.02), [57e3, 75e3, 85.57e3]
    )
    held = holding_force(window.points[-1], Pull.TOWARDS)
    assert held.end is PullEnd.LOST
    assert held.forces.max() < 0.0
    assert held.force == 0.0


@pytest.mark.parametrize("pull", [Pull.AWAY, Pull.TOWARDS])
def test_nothing_is_held_without_friction(pull: Pull) -> None:
    setup = lay_into_coil(load_gripper("paper_design_70"), 0.02, friction=0.0)
    held = holding_force(grip_window(setup, [57e3, 59e3]).points[-1], pull)
    assert held.force == 0.0
    assert abs(held.forces).max() < 1e-12


@cache
def short_grip() -> GripWindow:
    """Return the window of a coil of one turn, which touches with a tenth of its tube."""
    tube = Tube(inner_radius=4.75e-3, wall_thickness=0.8e-3, length=0.300908)
    fibers = FiberAngles(np.radians(88.0), np.radians(50.0))
    gripper = gripper_from_actuator(
        "short", Actuator(tube, fibers, NeoHookean(190e3)), density=1150.0
    )
    stations = [46e3, 58e3, 66e3, 70e3, 71e3, 72e3, 76e3, 79e3, 82e3, 85e3]
    return grip_window(lay_into_coil(gripper, 0.025, friction=0.5), stations)


def test_a_weight_that_would_slide_along_the_object_is_not_carried() -> None:
    """Moved straight along gravity, 7 degrees off its axis, the object cannot slide: 27 N."""
    point = short_grip().at(76.12e3)
    away, down = (holding_force(point, pull) for pull in (Pull.AWAY, Pull.DOWN))
    along = pull_direction(point, Pull.DOWN) @ pull_direction(point, Pull.AWAY)
    assert 0.98 < along < 1.0
    assert away.force == pytest.approx(0.039, rel=0.1)
    assert down.force == pytest.approx(away.force / along)


def test_a_window_between_two_pressures_is_found() -> None:
    """What happens on the way counts, not only what is there where one looks."""
    setup = lay_into_coil(load_gripper("paper_design_70"), 0.015, closing=Closing.FRICTIONLESS)
    looked_at = grip_window(setup, [50e3, 110e3])
    fine = grip_window(setup, list(np.arange(50e3, 110.1e3, 4e3)))
    assert looked_at.end is WindowEnd.LOST
    for found, expected in zip(
        (looked_at.onset_wrap, looked_at.onset_curling, looked_at.loss),
        (fine.onset_wrap, fine.onset_curling, fine.loss),
        strict=True,
    ):
        assert found == pytest.approx(expected, rel=5e-3)


@cache
def lifting_grip() -> GripWindow:
    """Return the window of a thin object whose tip lifts off above the onset."""
    return grip_window(random_setup(8), np.arange(60e3, 88e3, 1e3))


def test_a_curled_touch_before_the_perfect_wrap_is_not_the_window() -> None:
    window = grip_window(random_setup(8))
    curled = lifting_grip()
    assert window.onset_wrap > 1.05 * curled.lift_off
    assert window.at(1.01 * window.onset_wrap).regime is WrapRegime.PERFECT_WRAP
    assert window.lift_off is None


def test_a_lift_off_is_located_and_bounds_the_recommendation() -> None:
    window = lifting_grip()
    assert window.onset_wrap is not None
    assert not window.at(1.004 * window.lift_off).is_wrapped
    assert window.at(0.996 * window.lift_off).is_wrapped
    grip = solve_grip(window.setup, (), pressures=(), window=window)
    assert grip.range_end is RangeEnd.LIFT_OFF
    assert grip.recommended_range == grip.carrying_range == (window.onset_wrap, window.lift_off)
    assert "none looked at" in repr(grip)


def test_a_limit_that_decides_the_recommendation_is_named() -> None:
    """Without curling, loss or lift-off the middle of the range hangs on the gripper's limit."""
    setup = lay_into_coil(load_gripper("paper_design_70"), 0.02)
    for pressure_max in (60e3, 62e3):
        limited = replace(setup, gripper=replace(setup.gripper, pressure_max=pressure_max))
        window = grip_window(limited, [50e3, 56e3, 58e3, pressure_max])
        grip = solve_grip(limited, (), pressures=(), window=window)
        assert grip.range_end is RangeEnd.LIMIT
        assert grip.recommended_range[1] == pressure_max
    looked_at = grip_window(setup, [50e3, 56e3, 60e3])
    grip = solve_grip(setup, (), pressures=(), window=looked_at)
    assert grip.range_end is RangeEnd.LOOKED_AT
    assert grip.recommended_range[1] == 60e3


def test_a_coil_that_curls_from_the_onset_on_keeps_a_margin_to_it() -> None:
    """On a gripper that points upwards wrap and curling begin together, and the loss far above."""
    gripper = replace(load_gripper("paper_design_70"), gravity=(-9.80665, 0.0, 0.0))
    window = grip_window(lay_into_coil(gripper, 0.025))
    assert window.onset_curling == pytest.approx(window.onset_wrap, rel=0.01)
    grip = solve_grip(window.setup, (), pressures=(), window=window)
    assert grip.range_end is RangeEnd.LOSS
    assert grip.recommended_range == (window.onset_wrap, 0.9 * window.loss)
    assert 1.1 * window.onset_wrap < grip.recommended_pressure() < 0.9 * window.loss


def test_a_tube_that_neither_moves_nor_rests_is_not_a_loss(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The path ends there, and the recommended pressures a tenth below."""
    follow = windows.follow_contact

    def given_up(problems, *, start, **options) -> RodPath:
        if options.get("stop_at_event"):
            return RodPath((), (RodEvent(0.5, start, replace(start, status=NOT_HELD)),))
        return follow(problems, start=start, **options)

    monkeypatch.setattr(windows, "follow_contact", given_up)
    setup = lay_into_coil(load_gripper("paper_design_70"), 0.02)
    window = grip_window(setup, [50e3, 57e3, 65e3])
    assert window.end is WindowEnd.NOT_FOLLOWED
    assert window.loss is None
    assert window.top == 57e3
    grip = solve_grip(setup, (), pressures=(), window=window)
    assert grip.range_end is RangeEnd.NOT_FOLLOWED
    assert grip.recommended_range[0] == grip.recommended_range[1] == window.onset_wrap
