# SPDX-License-Identifier: Apache-2.0
"""The sub-branches of a gripper's coiled range, and why each begins and ends where it does.

The coiled range are all pressures at which the gripper makes the required turns with room for an
object inside. Along it the wrapped radius may rise and fall: a sub-branch is a part of the range on
which it changes one way only, without a snap.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property, partial
from itertools import groupby, pairwise

import numpy as np

from spiral_core.numerics.roots import minimum
from spiral_core.rod.types import Array
from spiral_core.wrap._kernels import lagrange_weights
from spiral_core.wrap.scan import PressureScan
from spiral_core.wrap.wrap import Wrap

# Ends are located to this many turns or outer radii, or to this fraction of the pressure limit.
END_TOLERANCE = 1e-10
# A sample is added at this fraction of the way from an end to the next one.
END_PROBE = 0.01
# Of this many steps towards an end one halves the bracket, whatever the secant suggests.
HALVING = 3
# Between samples that miss the range (or leave it) by less than this, in turns or outer radii, and
# come nearest there, a short part of the range is looked for in so many steps.
NEAR_MISS = 0.3
NEAR_MISS_STEPS = 12
# With fewer turns than this to spare, they may fall short between two samples.
SCARCE_TURNS = 0.5
# Turns change in a leap where the tangent's sine, at a place where it turns back, passes the least
# that counts. The pressures between two samples are halved so many times: where it may pass it (it
# is as near as it changes from one sample to the next, or as this, halved along), and where the
# axis turns by more than this angle [rad].
HALVINGS = 7
GRAZE = 0.05
AXIS_TURN = 0.4
# Steps of the search for an extreme radius: it is then right to 1e-9 of its change between samples.
EXTREME_STEPS = 20
# Solved wraps that one interpolation goes through.
TABLE_NODES = 8
# The slope between them is that of this part of the way from one to the next.
NEXT = 1e-3
# Where a coil closes on itself, the range ends at this fraction of the tube's outer radius.
LEAST_RADIUS = 1e-3


class BranchEnd(Enum):
    """Reasons for the end of a sub-branch.

    The value says of what is beyond it why it is too thick or too thin: a template of the pressure
    there, the pressure limit and the turns that are required.
    """

    PRESSURE_LIMIT = "for the pressure limit of {1}"
    TURNS = "for {2:g} turns of this length"
    CLOSED = "for the tube: the coil closes on itself at {0}"
    EXTREME = "for the coil: its radius turns back at {0}"
    SNAP = "for this shape: the tube snaps into another one near {0}"


@dataclass(frozen=True)
class SubBranch:
    """Wraps whose radius rises or falls steadily with pressure.

    Args:
        wraps: at rising pressures, at least two; the first and the last are its ends.
        low_end: why there is nothing at lower pressure.
        high_end: why there is nothing at higher pressure.
    """

    wraps: tuple[Wrap, ...]
    low_end: BranchEnd
    high_end: BranchEnd

    @cached_property
    def ends(self) -> tuple[tuple[Wrap, BranchEnd], tuple[Wrap, BranchEnd]]:
        """The wraps of the smallest and of the largest radius, and what ends the branch there."""
        low, high = (self.wraps[0], self.low_end), (self.wraps[-1], self.high_end)
        return (high, low) if low[0].object_radius > high[0].object_radius else (low, high)

    @cached_property
    def radius_range(self) -> tuple[float, float]:
        """Smallest and largest radius [m]."""
        (smallest, _), (largest, _) = self.ends
        return smallest.object_radius, largest.object_radius

    @cached_property
    def few_turns_up_to(self) -> float:
        """Pressure up to which turns are scarce, so that they are checked for each answer [Pa]."""
        scarce = [
            above.pressure
            for wrap, above in pairwise([*self.wraps, self.wraps[-1]])
            if wrap.turns < wrap.turns_required + SCARCE_TURNS
        ]
        return max(scarce, default=0.0)

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """Contact curvatures 1/(r_w + r_o), rising [1/m], and the pressures of the wraps [Pa]."""
        wraps = self.wraps if self.ends[0][0] is self.wraps[-1] else self.wraps[::-1]
        radii = np.array([wrap.object_radius + wrap.outer_radius for wrap in wraps])
        return 1.0 / radii, np.array([wrap.pressure for wrap in wraps])

    def _pressure(self, curvature: float) -> float:
        """Return the pressure [Pa] of a contact curvature [1/m], by a polynomial through wraps."""
        curvatures, pressures = self._table
        first, weights = lagrange_weights(curvatures, curvature, TABLE_NODES)
        return float(weights @ pressures[first : first + len(weights)])

    def bracket_and_guess(self, target: float) -> tuple[float, float, float, float]:
        """Return what a search for a contact curvature [1/m] on the branch starts from.

        In it the pressure is almost linear.

        Returns:
            The pressures of the wraps next below and next above it in contact curvature [Pa], the
            pressure between them that is guessed [Pa], and the slope of the contact curvature
            there [1/(m Pa)].
        """
        curvatures, pressures = self._table
        above = min(max(int(np.searchsorted(curvatures, target)), 1), len(curvatures) - 1)
        (low, high), (before, after) = (
            each[above - 1 : above + 1].tolist() for each in (pressures, curvatures)
        )
        slope = (after - before) / (high - low)
        step = NEXT * (after - before)
        guess, beside = map(self._pressure, (target, target + step))
        if min(low, high) <= guess <= max(low, high) and (beside - guess) * slope > 0.0:
            return low, high, guess, step / (beside - guess)
        return low, high, low + (target - before) / slope, slope


class CoiledRange:
    """The coiled range of a scanned gripper.

    Args:
        scan: of the gripper.

    Attributes:
        branches: its sub-branches, by rising pressure.
        samples: what was looked at to find them.
    """

    def __init__(self, scan: PressureScan) -> None:
        self._scan = scan
        self._required = scan.gripper.turns_required
        self._least = LEAST_RADIUS * scan.gripper.tube.outer_radius
        tracks = [self._refined(self._dense(scan.samples(track))) for track in scan.tracks]
        self.samples: list[Wrap] = [wrap for track in tracks for wrap in track]
        self.branches: list[SubBranch] = []
        for track in tracks:
            held = [self.room(wrap)[0] >= 0.0 for wrap in track]
            for inside, run in groupby(range(len(track)), held.__getitem__):
                if inside:
                    places = list(run)
                    self.branches += self._stretch(track, places[0], places[-1])

    def room(self, wrap: Wrap) -> tuple[float, BranchEnd]:
        """Return how far a wrap is from leaving the range, and what would end it; < 0: outside."""
        turns = wrap.turns - self._required
        radius = (wrap.object_radius - self._least) / wrap.outer_radius
        if not math.isfinite(radius):  # a straight tube
            return -1.0, BranchEnd.TURNS
        return (turns, BranchEnd.TURNS) if turns < radius else (radius, BranchEnd.CLOSED)

    def has_room(self, wrap: Wrap) -> bool:
        """Return whether an object fits inside a wrap's coil."""
        return wrap.object_radius >= self._least

    def _dense(self, track: list[Wrap]) -> list[Wrap]:
        """Return the samples of a track, more of them where scarce turns may leap."""
        dense = track[:1]
        for below, above in pairwise(track):
            dense += [*self._between(below, above, 0), above]
        return dense

    def _between(self, below: Wrap, above: Wrap, halvings: int) -> list[Wrap]:
        """Return the samples between two that show how turns change there."""
        spare = below.turns - self._required, above.turns - self._required
        if halvings == HALVINGS or (
            spare[0] * spare[1] > 0.0 and min(abs(spare[0]), abs(spare[1])) > SCARCE_TURNS
        ):
            return []
        turn_count_margin = min(abs(below.turn_count_margin), abs(above.turn_count_margin))
        near = max(GRAZE * 0.5**halvings, abs(above.turn_count_margin - below.turn_count_margin))
        along = math.fsum(a * b for a, b in zip(below.axis, above.axis, strict=True))
        if not turn_count_margin <= near and abs(along) > math.cos(AXIS_TURN):
            return []
        middle = self._scan.wrap_at(0.5 * (below.pressure + above.pressure))
        return [
            *self._between(below, middle, halvings + 1),
            middle,
            *self._between(middle, above, halvings + 1),
        ]

    def _refined(self, track: list[Wrap]) -> list[Wrap]:
        """Return the samples of a track with those between that show a short part in or out."""
        rooms = [self.room(wrap)[0] for wrap in track]
        found = list(track)
        for i in range(1, len(track) - 1):
            side = math.copysign(1.0, rooms[i])
            nearest = side * rooms[i] <= min(side * rooms[i - 1], side * rooms[i + 1])
            if not nearest or abs(rooms[i]) > NEAR_MISS:
                continue
            room = partial(self._room_of, side)
            wrap = self._lowest(room, track[i - 1], track[i + 1], NEAR_MISS_STEPS)
            if room(wrap) < 0.0:
                found.append(wrap)
        return sorted(found, key=lambda wrap: wrap.pressure)

    def _room_of(self, side: float, wrap: Wrap) -> float:
        return side * self.room(wrap)[0]

    def _lowest(
        self,
        figure: Callable[[Wrap], float],
        below: Wrap,
        above: Wrap,
        steps: int = EXTREME_STEPS,
    ) -> Wrap:
        """Return the wrap between two of which a figure is lowest."""
        wrap_at = self._scan.wrap_at
        ends = below.pressure, above.pressure
        return wrap_at(minimum(lambda pressure: figure(wrap_at(pressure)), *ends, steps))

    def most_turns(self) -> Wrap:
        """Return the wrap with the most turns of those with room for an object inside."""

        def shortage(wrap: Wrap) -> float:
            return -wrap.turns if self.has_room(wrap) else math.inf

        samples = self.samples
        most = min(range(len(samples)), key=lambda i: shortage(samples[i]))
        below, above = samples[max(most - 1, 0)], samples[min(most + 1, len(samples) - 1)]
        return min(samples[most], self._lowest(shortage, below, above), key=shortage)

    def _stretch(self, track: Sequence[Wrap], begin: int, end: int) -> list[SubBranch]:
        """Return the sub-branches of a part of a track, with its ends located."""
        wraps = list(track[begin : end + 1])
        low, low_end = self._end(track, begin, -1)
        high, high_end = self._end(track, end, 1)
        if not low.pressure < high.pressure:
            return []
        inner = [wrap for wrap in wraps if low.pressure < wrap.pressure < high.pressure]
        first, last = (inner[0], inner[-1]) if inner else (high, low)
        # Next to the ends, so that an extreme radius between them and a sample shows.
        probes = [
            self._scan.wrap_at(at.pressure + END_PROBE * (near.pressure - at.pressure))
            for at, near in ((low, first), (high, last))
        ]
        return self._monotone([low, probes[0], *inner, probes[1], high], low_end, high_end)

    def _end(self, track: Sequence[Wrap], at: int, step: int) -> tuple[Wrap, BranchEnd]:
        """Return the end of the range beyond a sample of a track, downwards or upwards."""
        on, first, last = track[at], self.samples[0], self.samples[-1]
        if 0 <= at + step < len(track):
            return self._edge(on, track[at + step].pressure)
        if step < 0 and on is first:
            return self._edge(on, END_TOLERANCE * on.pressure)
        return on, BranchEnd.PRESSURE_LIMIT if step > 0 and on is last else BranchEnd.SNAP

    def _edge(self, on: Wrap, outside: float) -> tuple[Wrap, BranchEnd]:
        """Return the last wrap of the range between ``on`` and a pressure outside of it."""
        off = self._scan.wrap_at(outside)
        room, (missing, end) = self.room(on)[0], self.room(off)
        if missing >= 0.0:
            return off, end
        tolerance = END_TOLERANCE * self._scan.gripper.pressure_max
        step = 0
        while room > END_TOLERANCE and abs(on.pressure - off.pressure) > tolerance:
            step += 1
            share = 0.5 if step % HALVING == 0 else min(max(room / (room - missing), 0.01), 0.99)
            wrap = self._scan.wrap_at(on.pressure + share * (off.pressure - on.pressure))
            here, why = self.room(wrap)
            if here >= 0.0:
                on, room = wrap, here
            else:
                off, missing, end = wrap, here, why
        return on, end

    def _monotone(
        self, wraps: list[Wrap], low_end: BranchEnd, high_end: BranchEnd
    ) -> list[SubBranch]:
        """Return a stretch of the range cut where the radius is extreme."""
        branches, begin = [], [wraps[0]]
        for at, above in pairwise(wraps[1:]):
            rise = at.object_radius - begin[-1].object_radius
            if rise * (above.object_radius - at.object_radius) >= 0.0:
                if at is not begin[-1]:
                    begin.append(at)
                continue
            extreme = self._extreme(begin[-1], at, above, math.copysign(1.0, rise))
            before = [at] if at.pressure < extreme.pressure else []
            after = [at] if at.pressure > extreme.pressure else []
            branches.append(SubBranch((*begin, *before, extreme), low_end, BranchEnd.EXTREME))
            begin, low_end = [extreme, *after], BranchEnd.EXTREME
        branches.append(SubBranch((*begin, wraps[-1]), low_end, high_end))
        return branches

    def _extreme(self, below: Wrap, at: Wrap, above: Wrap, sign: float) -> Wrap:
        """Return the wrap of the largest (sign 1) or smallest (-1) radius next to a sample."""
        found = self._lowest(lambda wrap: -sign * wrap.object_radius, below, above)
        return found if sign * (found.object_radius - at.object_radius) > 0.0 else at
