# SPDX-License-Identifier: Apache-2.0
"""The pressure range of a gripper, solved once: its shape and its wrap at every pressure.

The states are those that a pressure rising from zero leads to. Where the tube snaps on the way the
range is cut into tracks; along a track the shape changes continuously.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.errors import InvalidInputError, NoCoilError
from spiral_core.message import Message, Quantity
from spiral_core.rod._continuation import solve_uniform
from spiral_core.rod._mesh import element_count
from spiral_core.rod._newton import CONVERGED
from spiral_core.rod._profiles import uniform_rod
from spiral_core.rod.path import follow_path
from spiral_core.rod.solve import even_arc_lengths, state_from_solved
from spiral_core.rod.state import RodPath, RodState
from spiral_core.rod.types import Array
from spiral_core.rounding import rounded_down
from spiral_core.wrap._kernels import lagrange_weights
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.wrap import Wrap, wrapped_radius

# Pressures at which the whole range is solved once: so close that the tip turns by at most this
# angle from one to the next [rad], and every solve between two of them is a short warm start.
FEWEST_SAMPLES = 48
SAMPLE_TURN = 1.2
# About a given axis the wrapped radius rises and falls once per turn of the tip: this many samples
# in place of one show each rise.
GIVEN_AXIS_SAMPLES = 4
# A track ends at this fraction of the distance of two samples before a snap, which is located to
# 1/4096 of it. The next one begins closer to it: the shape that the tube snaps into is a firm one.
SNAP_MARGIN = 0.01
LANDING_MARGIN = 1.0 / 2048.0
# A gripper that turns by more than this [rad], some hundred turns, is not scanned: the work grows
# with the square of it, and such a length is often one in millimeters that was taken for meters.
MOST_TURN = 600.0
# States that one guess of a shape goes through. A cubic is so near that one Newton step settles it.
STATES = 4
# Pressures at which the unloaded shape is looked up to place them.
TABLE = 256
# Largest angle that an element turns by, at the tightest coil [rad]: the contact radius is then
# right to about 1e-6 of itself about a fitted axis, to 5e-5 about a given one.
ELEMENT_ANGLE = 0.4


class Track(NamedTuple):
    """Solved states that follow each other without a snap.

    Args:
        pressures: rising (m,) [Pa].
        states: at them.
    """

    pressures: Array
    states: tuple[RodState, ...]


class PressureScan:
    """The states of a gripper from zero pressure to its limit, or to where no object fits inside.

    Args:
        gripper: the gripper.

    Raises:
        InvalidInputError: it would turn by an absurd angle.
        NoCoilError: no pressure bends it.
        SolverError: a shape could not be certified.

    Attributes:
        gripper: the gripper.
        snaps: pressures at which the tube snaps, rising [Pa]; the last of several between samples.
        tracks: the states between the snaps.
    """

    def __init__(self, gripper: Gripper) -> None:
        self.gripper = gripper
        pressures = sample_pressures(gripper)
        shapes = [gripper.unloaded_shape(pressure) for pressure in pressures]
        tightest = max(shapes, key=strain_of)
        self._elements = element_count(gripper.rod(tightest), gripper.load(tightest), ELEMENT_ANGLE)
        path = self._path(pressures)
        self.snaps: list[float] = []
        self.tracks: list[Track] = []
        solved, first = list(zip(pressures, path.states, strict=True)), 0
        joined: list[tuple[float, RodState]] = []
        for station in sorted({math.floor(fold.position) for fold in path.events}):
            low, high = pressures[station : station + 2]
            last = max(f.position for f in path.events if math.floor(f.position) == station)
            snap = low + (last - station) * (high - low)
            last_held = max(snap - SNAP_MARGIN * (high - low), low)
            first_landed = min(snap + LANDING_MARGIN * (high - low), high)
            before = self._reached(*solved[station], last_held)
            after = self._reached(*solved[station + 1], first_landed)
            self.tracks.append(_track([*joined, *solved[first : station + 1], *before]))
            self.snaps.append(snap)
            joined, first = after, station + 1
        self.tracks.append(_track([*joined, *solved[first:]]))

    def wrap_at(self, pressure: float) -> Wrap:
        """Return what the gripper wraps at a pressure [Pa].

        Args:
            pressure: in [0, the gripper's ``pressure_max``].

        Raises:
            InvalidInputError: the pressure is out of its range.
            SolverError: the shape could not be certified.
        """
        gripper = self.gripper
        shape = gripper.unloaded_shape(pressure)
        track = self._track(pressure)
        q = _orientations_between(track, pressure)
        rod = uniform_rod(gripper.rod(shape), gripper.load(shape))
        solved = solve_uniform(q, rod, 0)
        if solved.folds or solved.solution.outcome != CONVERGED:
            # Followed step by step from the nearest state that was solved.
            nearest = int(np.argmin(np.abs(track.pressures - pressure)))
            stations = (float(track.pressures[nearest]), pressure)
            path = self._path(stations, track.states[nearest])
            return self._wrap(pressure, path.states[-1], shape)
        arcs = even_arc_lengths(shape.backbone_length, self._elements)
        return self._wrap(pressure, state_from_solved(arcs, q, solved, rod), shape)

    def samples(self, track: Track) -> list[Wrap]:
        """Return what the gripper wraps along a track, often enough to show how it changes."""
        solved = zip(track.pressures.tolist(), track.states, strict=True)
        return [self._wrap(pressure, state) for pressure, state in solved]

    def _track(self, pressure: float) -> Track:
        return self.tracks[bisect_left(self.snaps, pressure)]

    def _reached(
        self, pressure: float, state: RodState, target: float
    ) -> list[tuple[float, RodState]]:
        """Return a pressure [Pa] and its state, as reached from another; none past a snap."""
        if pressure == target:
            return []
        path = self._path((pressure, target), state)
        return [] if path.events else [(target, path.states[-1])]

    def _path(self, pressures: Sequence[float], start: RodState | None = None) -> RodPath:
        """Return the states at some pressures [Pa], followed from one to the next."""
        shapes = [self.gripper.unloaded_shape(pressure) for pressure in pressures]
        stations = [(self.gripper.rod(shape), self.gripper.load(shape)) for shape in shapes]
        return follow_path(stations, elements=self._elements, start=start)

    def _wrap(self, pressure: float, state: RodState, shape: UnloadedShape | None = None) -> Wrap:
        gripper = self.gripper
        shape = gripper.unloaded_shape(pressure) if shape is None else shape
        radius, axis = wrapped_radius(gripper, shape, state)
        turns = gripper.turns_required
        return Wrap(float(pressure), radius, shape, state, axis, turns, gripper.tube)


def _track(solved: Sequence[tuple[float, RodState]]) -> Track:
    pressures, states = zip(*solved, strict=True)
    return Track(np.array(pressures), states)


def _orientations_between(track: Track, pressure: float) -> Array:
    """Return orientations (N + 1, 4) at a pressure [Pa], from the states of a track next to it.

    Polynomials of the quaternions: the states must follow each other without a snap.
    """
    inside = min(max(pressure, track.pressures[0]), track.pressures[-1])
    first, weights = lagrange_weights(track.pressures, inside, STATES)
    near = [state.orientations for state in track.states[first : first + len(weights)]]
    mixed: Array = np.einsum("s,snq->nq", weights, near)
    mixed /= np.sqrt(np.einsum("nq,nq->n", mixed, mixed))[:, None]
    return mixed


def strain_of(shape: UnloadedShape) -> float:
    """Return the angle that an unloaded shape turns by per length [rad/m]."""
    return math.hypot(shape.curvature, shape.torsion)


def sample_pressures(gripper: Gripper) -> list[float]:
    """Return the pressures [Pa] to solve once, rising, until no object fits inside the coil.

    In even steps of the distance that curvature and torsion cover; a pressure range that changes
    neither is stepped over. However the tip is held, r_w is at most the radius of its free
    curvature less r_o: past that no pressure is of use.

    Raises:
        InvalidInputError: there would be too many of them.
        NoCoilError: no pressure bends the gripper.
    """
    top = gripper.pressure_max
    while True:
        fine = np.linspace(0.0, top, TABLE + 1)
        shapes = [gripper.unloaded_shape(float(p)) for p in fine]
        curvatures = np.array([s.curvature for s in shapes])
        if not curvatures.max() > 0.0:
            raise NoCoilError(0.0, gripper.turns_required, gripper.pressure_max)
        closed = np.nonzero(curvatures * gripper.tube.outer_radius >= 1.0)[0]
        end = int(closed[0]) if closed.size else TABLE
        if not 0 < end <= TABLE // 8:
            break
        top = float(fine[end])  # a far limit leaves few of the table's pressures below the end
    strains = np.column_stack((curvatures, [s.torsion for s in shapes]))[: end + 1]
    covered = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(strains, axis=0), axis=1))))
    turn = max(float(covered[-1]), strain_of(shapes[end])) * shapes[end].backbone_length
    if not turn <= MOST_TURN:
        requirement = Message(
            "at most {}, so that no pressure turns the tip by more than {:.0f} turns",
            Quantity(gripper.tube.length * MOST_TURN / turn, "m", rounded_down),
            MOST_TURN / (2.0 * math.pi),
        )
        raise InvalidInputError("length", gripper.tube.length, requirement, "m")
    samples = max(FEWEST_SAMPLES, math.ceil(turn / SAMPLE_TURN))
    samples *= 1 if gripper.object_axis is None else GIVEN_AXIS_SAMPLES
    levels = np.linspace(0.0, covered[-1], samples + 1)[1:]
    pressures = np.interp(levels, covered, fine[: end + 1])
    pressures[-1] = fine[end]
    return sorted(set(pressures[pressures > 0.0].tolist()))
