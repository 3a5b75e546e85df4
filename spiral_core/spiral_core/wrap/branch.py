"""The coiled branch of a gripper: over which pressures it wraps, and where that begins and ends.

Only pressures count, up to the limit, over which the gripper makes the required turns and the
wrapped radius falls with pressure, without a snap between.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from spiral_core.errors import InvalidInputError, NoCoilError
from spiral_core.numerics.roots import minimum
from spiral_core.rod.types import Array
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.wrap import Wrap

# Pressures at which the whole range is solved once: so close that the tip turns by at most this
# angle from one to the next [rad], and every solve between two of them is a short warm start.
FEWEST_SAMPLES = 48
SAMPLE_TURN = 1.2
# A gripper that turns by more than this [rad] has a length in millimeters, taken for meters.
MOST_TURN = 5.0e3
# Pressures at which the unloaded shape is looked up to place them.
TABLE = 256
# A helix whose centerline is nearer to its axis than this many outer radii holds nothing, with or
# without gravity.
CLOSED_RATIO = 0.8
# Ends of the branch are located to this fraction of the pressure limit.
END_TOLERANCE = 1e-10
# Where a coil closes on itself, the branch ends at this fraction of the tube's outer radius.
LEAST_RADIUS = 1e-3


def sample_pressures(gripper: Gripper) -> Array:
    """Return the pressures [Pa] to solve once: even steps of strain, until no object fits inside.

    The helix decides where that is, with room to spare for what gravity adds.

    Raises:
        InvalidInputError: there would be too many of them.
    """
    fine = np.linspace(0.0, gripper.pressure_max, TABLE + 1)[1:]
    shapes = [gripper.rest_shape(float(p)) for p in fine]
    strains = np.array([math.hypot(s.curvature, s.torsion) for s in shapes])
    radii = np.array([s.curvature for s in shapes]) / strains**2
    closed = np.nonzero(radii < CLOSED_RATIO * gripper.tube.outer_radius)[0]
    end = int(closed[0]) + 1 if closed.size else TABLE
    turn = float(strains[end - 1]) * shapes[end - 1].backbone_length
    if not turn <= MOST_TURN:
        requirement = f"so short that it turns by at most {MOST_TURN:g} rad"
        raise InvalidInputError("length", gripper.tube.length, requirement)
    samples = max(FEWEST_SAMPLES, math.ceil(turn / SAMPLE_TURN))
    levels = np.linspace(0.0, strains[end - 1], samples + 1)[1:]
    table = np.maximum.accumulate(np.concatenate(([0.0], strains[:end])))
    pressures: Array = np.interp(levels, table, np.concatenate(([0.0], fine[:end])))
    return pressures


class BranchFinder:
    """Finds the coiled branch among samples of the whole range.

    Args:
        gripper: the gripper.
        samples: what it wraps at increasing pressures.
        wrap_at: what it wraps at any pressure [Pa] between them.
    """

    def __init__(
        self, gripper: Gripper, samples: Sequence[Wrap], wrap_at: Callable[[float], Wrap]
    ) -> None:
        self._gripper = gripper
        self._samples = samples
        self._wrap_at = wrap_at

    def branch(self) -> list[Wrap]:
        """Return the wraps of the branch: its start, the samples between, its end.

        Raises:
            NoCoilError: the gripper nowhere makes the required turns.
            SolverError: a shape could not be certified.
        """
        last = self._last()
        first = self._first(last)
        low, high = self._start(first), self._end(last)
        inner = self._samples[first : last + 1]
        return [low, *(s for s in inner if low.pressure < s.pressure < high.pressure), high]

    def _last(self) -> int:
        """Return the highest sampled pressure, as an index, that wraps any object at all."""
        samples, required = self._samples, self._gripper.turns_required
        for i in reversed(range(len(samples))):
            if samples[i].turns >= required and samples[i].object_radius > 0.0:
                return i
        most = max(samples, key=lambda s: s.turns)
        raise NoCoilError(most.turns, required, most.pressure)

    def _first(self, last: int) -> int:
        """Return the index of the lowest sampled pressure of the branch that ends at ``last``."""
        samples, first = self._samples, last
        while (
            first > 0
            and samples[first].state.folds == 0
            and self._continues(samples[first - 1], samples[first])
        ):
            first -= 1
        return first

    def _continues(self, below: Wrap, above: Wrap) -> bool:
        """Return whether a branch goes on at a lower pressure: enough turns, a larger object."""
        return (
            below.turns >= self._gripper.turns_required
            and below.object_radius > above.object_radius
        )

    def _start(self, first: int) -> Wrap:
        """Return the wrap where the coiled branch begins, below its first sample.

        It is where the largest object is wrapped or, if that comes later, where the turns suffice.
        """
        samples = self._samples
        on = samples[first]
        if on.state.folds:
            return on
        below = samples[first - 1].pressure if first > 0 else END_TOLERANCE * on.pressure
        if first == 0 or samples[first - 1].object_radius < on.object_radius:
            above = samples[min(first + 1, len(samples) - 1)].pressure
            largest = minimum(lambda pressure: -self._wrap_at(pressure).object_radius, below, above)
            below = min(largest, on.pressure)
            peak = self._wrap_at(largest)
            if self._holds(peak):
                return peak
        return self._bisect(on, below, self._holds)

    def _holds(self, wrap: Wrap) -> bool:
        """Return whether a wrap makes the turns required, without a snap on the way to it."""
        return wrap.state.folds == 0 and wrap.turns >= self._gripper.turns_required

    def _end(self, last: int) -> Wrap:
        """Return the wrap at the branch's end: the limit, or where the coil closes on itself."""
        on = self._samples[last]
        if last == len(self._samples) - 1:
            return on
        least = LEAST_RADIUS * self._gripper.tube.outer_radius
        beyond = self._samples[last + 1].pressure
        return self._bisect(on, beyond, lambda wrap: wrap.object_radius > least)

    def _bisect(self, on: Wrap, off: float, holds: Callable[[Wrap], bool]) -> Wrap:
        """Return the last wrap between ``on`` and pressure ``off`` for which a condition holds."""
        while abs(on.pressure - off) > END_TOLERANCE * self._gripper.pressure_max:
            middle = 0.5 * (on.pressure + off)
            wrap = self._wrap_at(middle)
            if holds(wrap):
                on = wrap
            else:
                off = middle
        return on
