# SPDX-License-Identifier: Apache-2.0
"""What the studio says of a shape, a wrap and a grip, in the units of the bench."""

from __future__ import annotations

from spiral_core import Pull, RodState
from spiral_gripper.studio.session import Answer
from spiral_gripper.studio.settings import Settings


def answer_text(
    answer: Answer | None, settings: Settings, state: RodState, waited: float | None = None
) -> str:
    """Return a few lines of Markdown; what is still being computed is said to be.

    Args:
        answer: what is known for these settings; None where nothing is yet.
        settings: of the controls.
        state: the free shape at the pressure that is set.
        waited: time since these settings were asked about [s], where something is computed still.
    """
    since = "" if waited is None else f", {waited:.0f} s"
    x, y, z = 1e3 * state.tip_position
    lines = [f"tip of the free coil at **{x:.1f}, {y:.1f}, {z:.1f} mm**, stable"]
    if answer is None:
        return "\n\n".join([f"**computing ...{since}**", *lines])
    radius = 1e3 * settings.object_radius
    if answer.wrap is None or answer.placement is None:
        lines.insert(0, f"**{radius:.1f} mm cannot be wrapped:** {answer.refusal}")
        return "\n\n".join(lines)
    lines.insert(0, f"{regime_text(answer, settings)} at {settings.pressure / 1e3:.1f} kPa")
    pressure, turns = answer.wrap.pressure / 1e3, answer.wrap.turns
    lines.append(f"perfect wrap of {radius:.1f} mm: **{pressure:.1f} kPa**, {turns:.2f} turns")
    strain = 100.0 * ((answer.wrap.unloaded_shape.stretch or 1.0) - 1.0)
    if answer.wrap.unloaded_shape.stretch is not None:
        lines.append(f"strain at the wrap {strain:.1f} %")
    return "\n\n".join([*lines, *grip_lines(answer, settings, since)])


def regime_text(answer: Answer, settings: Settings) -> str:
    """Return how the pressure holds the object: by contact where that is solved."""
    point = answer.contact_at(settings.pressure)
    if point is not None:
        return f"**{point.regime.value}** (in contact)"
    if answer.window is not None:
        return "**lost:** the end of the coil has let go"
    regime = answer.regime(settings.pressure)
    return f"**{regime.value if regime else 'no coil'}** (free coil)"


def grip_lines(answer: Answer, settings: Settings, since: str = "") -> list[str]:
    """Return what is known of contact and holding force, and since when the rest is computed."""
    if answer.no_grip:
        return [f"**not held:** {answer.no_grip}"]
    if answer.window is None or answer.placement is None:
        gap = 1e3 * answer.placement.largest_gap if answer.placement else 0.0
        return [
            f"the free coil misses the object by up to {gap:.1f} mm",
            f"contact: computing ...{since}",
        ]
    window, lines = answer.window, []
    if window.onset_wrap is not None:
        end = window.onset_curling or window.loss or window.top
        lines.append(f"holds from {1e-3 * window.onset_wrap:.1f} to {1e-3 * end:.1f} kPa")
    point = answer.contact_at(settings.pressure)
    if point is not None:
        length, force = 1e3 * point.contact_length, point.normal_force
        lines.append(
            f"{length:.0f} mm in contact, presses with {force:.3f} N "
            f"(solved at {1e-3 * point.pressure:.1f} kPa)"
        )
    if answer.grip is None:
        return [*lines, f"holding force: computing ...{since}"]
    wanted = answer.grip.recommended_pressure()
    away = dict(zip(answer.grip.pressures.tolist(), answer.grip.force(Pull.AWAY), strict=True))
    nearest = min(away, key=lambda pressure: abs(pressure - settings.pressure))
    held = f"holds **{away[nearest]:.2f} N** away from the base at {1e-3 * nearest:.1f} kPa"
    return [*lines, f"{held}; recommended {1e-3 * wanted:.1f} kPa"]
