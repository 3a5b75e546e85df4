# SPDX-License-Identifier: Apache-2.0
"""A rod's shape as a coil: axis, turns about the axis, length along it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Array, Vector
from spiral_core.validation import require_unit_vector

# Parts of a rod count as coiled where their tangent's sine to the axis is at least this fraction of
# the tip's.
LEAST_SINE = 0.5
# Nearer to the axis than this a tangent is on it: its azimuth is rounding.
STRAIGHT_SINE = 1e-9
# Turns that are fewer by less than this fraction are as many: at the end of a grippable range a
# coil has just as many as are required.
SAME_TURNS = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Coil:
    """A shape seen along an axis.

    Args:
        axis: unit vector in the base frame, pointing the way the coil advances from base to tip.
        helix_angle: angle between the tip's tangent and the axis [rad].
        turns: turns of the tangent about the axis, up to each node (n,); grows whichever way the
        coil winds.
        advances: length covered along the axis, up to each node (n,) [m].
        arc_lengths: of the nodes (n,) [m].
    """

    __repr__ = brief_repr

    axis: Vector
    helix_angle: float
    turns: Array
    advances: Array
    arc_lengths: Array

    @property
    def total_turns(self) -> float:
        """Turns of the whole length."""
        return float(self.turns[-1])

    def length_for_turns(self, turns: float) -> float | None:
        """Return the length from the tip that makes so many turns [m]; None if there are fewer."""
        start = self._start_of_last(turns)
        return None if start is None else float(self.arc_lengths[-1]) - start

    def advance_for_turns(self, turns: float) -> float | None:
        """Return the object length that the last turns cover [m]; None if there are fewer."""
        start = self._start_of_last(turns)
        if start is None:
            return None
        return abs(
            float(self.advances[-1]) - float(np.interp(start, self.arc_lengths, self.advances))
        )

    def _start_of_last(self, turns: float) -> float | None:
        """Return the arc length where the last ``turns`` turns begin [m]."""
        left = self.total_turns - turns
        if not left >= -SAME_TURNS * self.total_turns:
            return None
        left = max(left, 0.0)
        last = int(np.nonzero(self.turns <= left)[0][-1])
        around = slice(last, last + 2)
        return float(np.interp(left, self.turns[around], self.arc_lengths[around]))


def coil_from_state(state: RodState, axis: Vector) -> Coil:
    r"""Return the coil that a shape makes about an axis.

    The turns are the tangent's azimuth about the axis, unwrapped, over :math:`2\pi`. A part that
    still hangs along the axis, its sine to it less than half the tip's, wraps nothing and is not
    counted; it would add or lose a whole turn as the tangent passes the axis on one side or the
    other.

    Args:
        state: the shape.
        axis: unit vector in the base frame, pointing the way the coil advances.

    Raises:
        InvalidInputError: the axis is no unit vector.
    """
    # Compile only when a coil is asked for.
    from spiral_core.wrap._kernels import angle_at_tip, turns_about

    x, y, z = require_unit_vector("axis", axis)
    orientations, step = np.array(state.orientations), float(state.arc_lengths[1])
    angle = angle_at_tip(orientations, (x, y, z))
    least = max(LEAST_SINE * math.sin(angle), STRAIGHT_SINE)
    turns = turns_about(orientations, np.array(state.strains), step, axis, least)
    return Coil(
        axis=axis,
        helix_angle=angle,
        turns=turns if turns[-1] >= 0.0 else -turns,
        advances=state.positions @ np.asarray(axis),
        arc_lengths=state.arc_lengths,
    )
