# SPDX-License-Identifier: Apache-2.0
"""The studio's page of a running node: its command, measured pressure, shape and grip."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser

from spiral_core.rod.types import Array
from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper.files.shown import axis_label, in_units, shown
from spiral_gripper.studio.charts import DARK, RED, add_chart
from spiral_gripper.studio.scene import FAINT, OPAQUE, Scene
from spiral_gripper.studio.words import plain

# The chart shows so much of the past [s].
PAST = 60.0
# A node that is silent for longer is said to be [s]; its status comes every 0.1 s by default.
SILENCE = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class NodeState:
    """The state of a node, from its messages; None is not known.

    Args:
        age: since its newest status [s].
        state: of the node, for people.
        command: pressure [Pa], on its way to ``target`` [Pa].
        target: pressure of the wrap and what is held above it [Pa].
        measured: pressure [Pa].
        object_radius: that the command is for [m].
        regime: how the object is held, for people.
        held: by what: a message ``spiral_gripper_msgs/Grip``.
        troubles: what is wrong, a sentence each.
        tube: centerline (n, 3) [m], at the measured pressure if that is known.
        outer_radius: of the tube [m].
        placement: where the object is.
    """

    age: float
    state: str
    command: float
    target: float
    measured: float | None
    object_radius: float | None
    regime: str
    held: Any
    troubles: tuple[str, ...]
    tube: Array | None
    outer_radius: float
    placement: ObjectPlacement | None


class LivePage:
    """Draws a running gripper for everybody who opens the page.

    Args:
        server: serves the page.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = Scene(server)
        self._begin = time.monotonic()
        self._past: list[tuple[float, float, float]] = []
        self._length = 0.0
        gui = server.gui
        gui.configure_theme(dark_mode=False, show_logo=False, show_share_button=False)
        self._words = gui.add_markdown("**waiting for the node ...**")
        labels = "time [s]", axis_label("pressure", "Pa")
        self._chart = add_chart(gui, *labels, {"commanded": RED, "measured": DARK}, now=False)

    def show(self, heard: NodeState | None) -> None:
        """Show what was heard last; where that is old, its age too."""
        self._words.content = live_text(heard)
        if heard is None:
            return
        if heard.age < SILENCE:
            self._note(heard)
        if heard.tube is not None:
            length = float(np.linalg.norm(np.diff(heard.tube, axis=0), axis=1).sum())
            if abs(length - self._length) > 0.5 * self._length:  # another gripper, or the first
                self._scene.look_at_gripper(length)
                self._length = length
        self._scene.show_gripper(heard.tube, heard.outer_radius, None)
        opacity = FAINT if heard.held is None else OPAQUE
        self._scene.show_object(heard.placement, opacity=opacity)

    def _note(self, heard: NodeState) -> None:
        """Continue the chart of the pressure."""
        now = time.monotonic() - self._begin
        measured = np.nan if heard.measured is None else heard.measured
        self._past.append((now, heard.command, measured))
        self._past = [one for one in self._past if one[0] > now - PAST]
        times, commands, pressures = np.array(self._past).T
        self._chart.data = (times, in_units(commands, "Pa"), in_units(pressures, "Pa"))


def live_text(heard: NodeState | None) -> str:
    """Return the state of a node, in lines of Markdown.

    Example:
        >>> print(live_text(None))
        **waiting for the node ...**
    """
    if heard is None:
        return "**waiting for the node ...**"
    lines = [f"**{heard.state}**, {heard.regime}"]
    if heard.age > SILENCE:
        lines.insert(0, f"**The node is silent.** What follows is {heard.age:.0f} s old.")
    lines.append(f"command **{shown(heard.command, 'Pa')}** of {shown(heard.target, 'Pa')}")
    measured = "not measured" if heard.measured is None else f"**{shown(heard.measured, 'Pa')}**"
    lines.append(f"measured {measured}")
    radius = "none" if heard.object_radius is None else f"**{shown(heard.object_radius, 'm')}**"
    lines.append(f"object radius {radius}")
    if heard.held is None:
        lines.append("contact and holding force: not known (yet); the free coil is drawn")
    else:
        held = heard.held
        touching, normal = shown(held.contact_length, "m", 3), shown(held.normal_force, "N", 3)
        lines.append(f"{touching} in contact, presses with {normal}")
        away, towards = (
            shown(force, "N", 3) for force in (held.holding_force_away, held.holding_force_towards)
        )
        lines.append(f"holds **{away}** away from the base, {towards} towards it")
    return "\n\n".join([*lines, *(f"**{plain(trouble)}**" for trouble in heard.troubles)])
