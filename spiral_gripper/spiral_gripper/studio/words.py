# SPDX-License-Identifier: Apache-2.0
"""The studio's text about a shape, a wrap and a grip, in the units shown."""

from __future__ import annotations

import math
from html import escape

import numpy as np

from spiral_core import Gripper, Pull, RodState
from spiral_core.grip.closing import TimedClosing
from spiral_core.grip.curve import regime_at
from spiral_core.rod.motion.motion import Frame, contact_fraction
from spiral_core.rounding import rounded_down, rounded_up
from spiral_gripper.files.shown import scale_of, shown, shown_message
from spiral_gripper.studio.session import Answer
from spiral_gripper.studio.settings import Settings


def answer_text(
    answer: Answer | None,
    settings: Settings,
    gripper: Gripper,
    state: RodState,
    waited: float | None = None,
) -> str:
    """Return a few lines of Markdown; what is still being computed is said to be.

    Args:
        answer: what is known for these settings; None where nothing is yet.
        settings: of the controls.
        gripper: under these settings.
        state: the free shape at the pressure that is set.
        waited: time since these settings were asked about [s], where something is computed still.
    """
    since = "" if waited is None else f", {waited:.0f} s"
    lines = [f"tip of the free coil at **{_place(state)}**, stable"]
    if answer is None:
        return "\n\n".join([f"**computing ...{since}**", *lines])
    radius = shown(settings.object_radius, "m")
    if answer.wrap is None or answer.placement is None:
        lines.insert(0, f"**{radius} cannot be wrapped:** {plain(answer.refusal)}")
        return "\n\n".join([*lines, *margin_lines(answer, settings, gripper)])
    lines.insert(0, f"{regime_text(answer, settings)} at {shown(settings.pressure, 'Pa')}")
    pressure, turns = shown(answer.wrap.pressure, "Pa"), answer.wrap.turns
    lines.append(f"tip criterion of {radius}: **{pressure}**, {turns:.2f} turns")
    lines += margin_lines(answer, settings, gripper)
    return "\n\n".join([*lines, *grip_lines(answer, settings, since)])


def regime_text(answer: Answer, settings: Settings) -> str:
    """Return how the pressure holds the object: by contact where that is solved."""
    window, pressure = answer.window, settings.pressure
    if window is not None and window.onset_wrap is not None:
        ends = (window.onset_curling or math.inf, window.loss or math.inf)
        if pressure >= ends[1]:
            return "**lost:** the wrapped coil has lost its stability"
        if pressure > window.top and window.loss is None:
            return f"**not known:** {plain(window.end.value)}"
        point = answer.contact_at(pressure)
        if window.lift_off is not None and pressure >= window.lift_off and point is not None:
            return f"**{point.regime.value}** (in contact)"  # the tip may touch again
        return f"**{regime_at(pressure, window.onset_wrap, *ends).value}** (in contact)"
    if window is not None or answer.refusal:
        return "**not wrapped** (in contact)"
    regime = answer.regime(settings.pressure)
    return f"**{regime.value if regime else 'no coil'}** (by the tip criterion)"


def margin_lines(answer: Answer, settings: Settings, gripper: Gripper) -> list[str]:
    """Return how far the pressure is from its limit and from the loss, and the strain."""
    limit, pressure = gripper.pressure_max, settings.pressure
    margins = [f"{_room(pressure, limit)} the pressure limit ({shown(limit, 'Pa')})"]
    loss = None if answer.window is None else answer.window.loss
    if loss is not None:
        margins.append(f"{_room(pressure, loss)} the loss ({shown(loss, 'Pa')})")
    lines = [f"margins: {', '.join(margins)}"]
    now, most = (gripper.unloaded_shape(each).stretch for each in (pressure, limit))
    if now is not None and most is not None:
        ends = f"{100.0 * (now - 1.0):.1f} %", f"{100.0 * (most - 1.0):.1f} %"
        lines.append(f"strain {ends[0]}, at the pressure limit {ends[1]}")
    return lines


def plain(said: object) -> str:
    """Return what was said as Markdown, which would draw the tags that a text has."""
    return escape(shown_message(said), quote=False)


def _place(state: RodState) -> str:
    """Return where the tip is, to about a tenth of a millimeter."""
    factor, unit = scale_of("m")
    decimals = max(0, round(-math.log10(1e-4 * factor)))
    return ", ".join(f"{factor * x:.{decimals}f}" for x in state.tip_position) + f" {unit}"


def _room(pressure: float, bound: float) -> str:
    """Return how far a pressure is below a bound, or above it, rounded to the bad side."""
    share = 100.0 * (1.0 - pressure / bound)
    if share < 0.0:
        return f"**{rounded_up(-share, 2):g} % above**"
    return f"{rounded_down(share, 2):g} % below"


def closing_line(closing: TimedClosing, rate: float) -> str:
    """Return what closing at a rate [Pa/s] gives, in real time."""
    touching = f"{100.0 * closing.contact_fractions[-1]:.0f} % of the tube in contact"
    wrapped, end = closing.time_to_wrap, closing.frames[-1].time
    after = "" if wrapped is None else f"wrapped after {wrapped:.2f} s, "
    return f"closed at {shown(rate, 'Pa/s')}: {after}{touching} after {end:.2f} s"


def frame_text(frame: Frame, pressure: float) -> str:
    """Return what a moment of a closing is like, at a pressure [Pa]."""
    touching = 100.0 * contact_fraction(frame.state)
    return (
        f"**{frame.time:.1f} s: {shown(pressure, 'Pa', 3)}**, {touching:.0f} % of the tube touches"
    )


def grip_lines(answer: Answer, settings: Settings, since: str = "") -> list[str]:
    """Return what is known of contact and holding force, and since when the rest is computed."""
    if answer.refusal:
        return [f"**not held:** {plain(answer.refusal)}"]
    if answer.window is None or answer.placement is None:
        gap = answer.placement.largest_gap if answer.placement else 0.0
        return [
            f"the free coil misses the object by up to {shown(gap, 'm', 3)}",
            f"contact: computing ...{since}",
        ]
    window, lines = answer.window, []
    if window.onset_wrap is not None:
        end = window.onset_curling or window.loss or window.top
        lines.append(f"holds from {shown(window.onset_wrap, 'Pa')} to {shown(end, 'Pa')}")
    point = answer.contact_at(settings.pressure)
    if point is not None:
        length, force = shown(point.contact_length, "m", 3), shown(point.normal_force, "N", 3)
        solved = shown(point.pressure, "Pa")
        lines.append(f"{length} in contact, presses with {force} (solved at {solved})")
    if answer.grip is None:
        return [*lines, f"holding force: computing ...{since}"]
    wanted = shown(answer.grip.recommended_pressure(), "Pa")
    if holds(answer, settings.pressure):
        away, solved_at = answer.grip.force(Pull.AWAY), answer.grip.pressures
        force = shown(float(np.interp(settings.pressure, solved_at, away)), "N", 3)
        lines.append(f"holds **{force}** away from the base")
    return [*lines, f"recommended {wanted}"]


def holds(answer: Answer, pressure: float) -> bool:
    """Return whether the object is wrapped at a pressure [Pa], of those that were followed."""
    window = answer.window
    if window is None or window.onset_wrap is None:
        return False
    point = answer.contact_at(pressure)
    lifted = window.lift_off is not None and pressure >= window.lift_off
    if lifted and point is not None and not point.is_wrapped:
        return False
    return window.onset_wrap <= pressure <= window.top
