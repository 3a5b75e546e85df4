# SPDX-License-Identifier: Apache-2.0
"""The reason why a gripper cannot wrap a radius, from the end of its coiled range."""

from __future__ import annotations

from collections.abc import Sequence

from spiral_core.errors import NoCoilError, NotGrippableError
from spiral_core.wrap.branch import BranchEnd, CoiledRange, SubBranch
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.wrap import Wrap


def no_coil(coiled: CoiledRange, gripper: Gripper) -> NoCoilError:
    """Return why a gripper has no coiled range: too few turns while there is room inside."""
    closed = [s.pressure for s in coiled.samples if not coiled.has_room(s)]
    if len(closed) == len(coiled.samples):
        return NoCoilError(0.0, gripper.turns_required, gripper.pressure_max, closes_at=min(closed))
    most = coiled.most_turns()
    return NoCoilError(
        most.turns,
        gripper.turns_required,
        most.pressure,
        closes_at=min(closed, default=None),
        at_actuator_limit=gripper.pressure_max >= gripper.actuation.pressure_limit,
    )


def not_grippable(
    radius: float, branches: Sequence[SubBranch], gripper: Gripper
) -> NotGrippableError:
    """Return why no pressure wraps a radius [m].

    What ends the coiled range at the nearest radius that can be gripped is the reason.
    """
    ends = [end for branch in branches for end in branch.ends]
    ends.sort(key=lambda end: end[0].object_radius)
    if radius > ends[-1][0].object_radius:
        word, (nearest, kind) = "too thick", ends[-1]
    elif radius < ends[0][0].object_radius:
        word, (nearest, kind) = "too thin", ends[0]
    else:
        word = "between two parts of the grippable range"
        nearest, kind = min(ends, key=lambda end: abs(end[0].object_radius - radius))
    return NotGrippableError(
        radius,
        f"{word} {_reason(kind, nearest, gripper)}",
        -abs(radius - nearest.object_radius),
        nearest.object_radius,
    )


def _reason(end: BranchEnd, nearest: Wrap, gripper: Gripper) -> str:
    if end is BranchEnd.PRESSURE_LIMIT:
        return f"for the pressure limit of {gripper.pressure_max:.6g} Pa"
    if end is BranchEnd.TURNS:
        return f"for {gripper.turns_required:g} turns of this length"
    if end is BranchEnd.CLOSED:
        return f"for the tube: the coil closes on itself at {nearest.pressure:.6g} Pa"
    if end is BranchEnd.SNAP:
        return f"for this shape: the tube snaps into another one near {nearest.pressure:.6g} Pa"
    return f"for the coil: its radius turns back at {nearest.pressure:.6g} Pa"
