# SPDX-License-Identifier: Apache-2.0
"""What the studio says of a shape and of a wrap, in the units of the bench."""

from __future__ import annotations

from spiral_core import RodState
from spiral_gripper.studio.session import Answer
from spiral_gripper.studio.settings import Settings


def answer_text(answer: Answer | None, settings: Settings, state: RodState) -> str:
    """Return a few lines of Markdown; an answer that is not there yet is said to be computed."""
    x, y, z = 1e3 * state.tip_position
    lines = [f"tip at **{x:.1f}, {y:.1f}, {z:.1f} mm**, stable"]
    if answer is None:
        return "\n\n".join(["**computing ...**", *lines])
    radius = 1e3 * settings.object_radius
    if answer.wrap is None or answer.placement is None:
        lines.insert(0, f"**{radius:.1f} mm cannot be wrapped:** {answer.refusal}")
        return "\n\n".join(lines)
    regime = answer.regime(settings.pressure)
    held = regime.value if regime else "no coil"
    lines.insert(0, f"**{held}** at {settings.pressure / 1e3:.1f} kPa")
    pressure, turns = answer.wrap.pressure / 1e3, answer.wrap.turns
    lines.append(f"perfect wrap of {radius:.1f} mm: **{pressure:.1f} kPa**, {turns:.2f} turns")
    gap = 1e3 * answer.placement.largest_gap
    lines.append(f"the free coil misses the object by up to {gap:.1f} mm (contact is not drawn)")
    return "\n\n".join(lines)
