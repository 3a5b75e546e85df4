# SPDX-License-Identifier: Apache-2.0
"""Region of capture: how far off an object may be for closing to end wrapped and holding.

A misplacement has five components (5,): shifts of the object across its axis, away from the base
and across both [m]; tilts about these two directions, which :attr:`GripSetup.frame` has [rad]; and
the error of its radius [m]. Its axis stays where it is if its radius is another one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from itertools import product, takewhile
from typing import Any

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError, NotGrippableError, SolverError
from spiral_core.grip.holding import ROUNDING, HoldingForce, Pull, holding_force
from spiral_core.grip.places import FARTHEST_SHIFT
from spiral_core.grip.setup import GripSetup, hanging_tube
from spiral_core.grip.window import GripPoint, raised
from spiral_core.numerics.tasks import Progress
from spiral_core.rod.contact.shapes import Cylinder
from spiral_core.rod.state import RodStatus
from spiral_core.rod.types import Array
from spiral_core.validation import require_in_range, require_kind, require_positive, require_vector

Misplacement = tuple[float, ...]

# Boundaries are located to this much of a misplacement.
RESOLUTION = np.array((2e-4, 2e-4, math.radians(0.5), math.radians(0.5), 2e-4))
# They are looked for up to the same shifts as places are, to these tilts, and up to this fraction
# of the radius: in so many steps outwards.
LARGEST_TILT = math.radians(40.0)
LARGEST_RADIUS_ERROR = 0.5
OUTWARD_STEPS = 10
# Directions of a plane in which they are looked for in this way; between two of them the boundary
# is followed from the straight line that joins theirs: once, then up to so many times where it was
# farther from that line than this many resolutions.
DIRECTIONS = 8
FOLLOWED, BENT = 3, 2.5
# The middle of what is safe is looked for so often, along one shift after the other, up to so many
# times the shift that is wanted; what is safe from there in these parts of it, up to twice as far.
CENTERED, CENTERED_REACH, SHIFT_PART = 3, 3.0, 0.25
# The ball is located to one part in so many of the smaller limits.
BALL_STEPS = 32
# An ellipsoid is not thinner than this [m, rad].
SMALLEST = 1e-9
SHIFTS, TILTS = PLANES = (0, 1), (2, 3)


class CaptureOutcome(Enum):
    """What closing on a misplaced object ends in; the value says it in words."""

    HOLDS = "wraps and holds"
    TOO_WEAK = "wraps, but is too weak"
    PASSES_BY = "the tip passes it by"
    IN_THE_WAY = "cannot begin: the object lies in the way"
    NOT_ANSWERED = "no certified answer"


@dataclass(frozen=True, slots=True, eq=False)
class MisplacedGrip:
    """A gripper closed on a misplaced object.

    Args:
        outcome: what it ends in.
        pressure: at which closing ends [Pa].
        status: of the last state that was looked for, a RodStatus.
        point: the grip there; None where closing did not begin or could not be followed.
        held: along gravity with a payload, else away from the base, no further than to what is
            enough; None where nothing is wrapped.
    """

    outcome: CaptureOutcome
    pressure: float
    status: Enum
    point: GripPoint | None = None
    held: HoldingForce | None = None


def close_misplaced(
    setup: GripSetup,
    pressure: float,
    misplacement: Sequence[float] | Array,
    payload: float | None = None,
    elements: int | None = None,
) -> MisplacedGrip:
    """Return what slow closing up to a pressure does with an object that is misplaced.

    The tube is followed from the hanging one, also where it snaps onto the object; what counts is
    where it rests at the pressure. It holds if it is wrapped (:attr:`GripPoint.is_wrapped`) and its
    holding force along gravity is at least the payload's weight, once: the twofold force of
    :meth:`Grip.recommended_pressure` is the margin that a misplacement may use up. Without payload
    any force away from the base is enough.

    Args:
        setup: the gripper and its object, a cylinder, in its place.
        pressure: gauge pressure [Pa], in (0, limit].
        misplacement: (5,), see the module.
        payload: mass of the object [kg].
        elements: of the rod; None takes the setup's.

    Raises:
        InvalidInputError: a value is out of its range; a payload without gravity; no cylinder.
    """
    weight = _weight(setup, pressure, payload)
    off = require_vector("misplacement", misplacement, 5)
    radius = require_positive("radius", setup.obstacle.shape.feature_radius + off[4])
    count = setup.element_count if elements is None else elements
    there = replace(setup, elements=count).moved(np.array((0.0, *off[:4])))
    there = replace(there, obstacle=replace(there.obstacle, shape=Cylinder(radius)))
    try:
        point, path = raised(GripPoint(0.0, there, hanging_tube(there)), pressure)
    except NotGrippableError:
        return MisplacedGrip(CaptureOutcome.IN_THE_WAY, pressure, RodStatus.INSIDE_OBSTACLE)
    except SolverError as error:
        return MisplacedGrip(CaptureOutcome.NOT_ANSWERED, pressure, error.status)
    if point is None:
        touches = path.self_contact is not None
        status = RodStatus.SELF_CONTACT if touches else path.events[-1].last.status
        return MisplacedGrip(CaptureOutcome.NOT_ANSWERED, pressure, status)
    if not point.is_wrapped:
        return MisplacedGrip(CaptureOutcome.PASSES_BY, pressure, point.state.status, point)
    held = holding_force(point, Pull.AWAY if payload is None else Pull.DOWN, weight)
    enough = held.force >= weight
    outcome = CaptureOutcome.HOLDS if enough else CaptureOutcome.TOO_WEAK
    if not enough and (held.is_lower_bound or math.isnan(held.force)):
        outcome = CaptureOutcome.NOT_ANSWERED
    return MisplacedGrip(outcome, pressure, point.state.status, point, held)


def _weight(setup: GripSetup, pressure: float, payload: float | None) -> float:
    """Return the force that is enough [N]; check what a misplaced object is closed on with."""
    require_kind("obstacle", setup.obstacle.shape, Cylinder)
    limit = setup.gripper.pressure_max
    require_in_range("pressure", require_positive("pressure", pressure), 0.0, limit, "Pa")
    if payload is None:
        return ROUNDING
    weight = setup.weight_of(payload)
    if not weight > 0.0:
        raise InvalidInputError("payload", payload, "none without gravity", "kg")
    return weight


@dataclass(frozen=True, slots=True)
class Boundary:
    """Where the region of capture ends in one direction from its center.

    Args:
        direction: (5,) as fractions of :attr:`CaptureRegion.reach`, a unit vector.
        fraction: of the reach at which the object was last held on the way out.
        beyond: what closing ends in a little further out; HOLDS if the object is held up to the
            reach.
    """

    direction: Misplacement
    fraction: float
    beyond: CaptureOutcome


@dataclass(frozen=True, slots=True, eq=False)
class CaptureRegion:
    """Misplacements from which closing at one pressure ends wrapped and holding.

    Each boundary is the first one on a straight way from the center; the region may begin again
    beyond it. Where nothing is held even at the center, there are no boundaries.

    Args:
        setup: the gripper and its object in its place.
        pressure: up to which it closes [Pa].
        payload: that it has to hold [kg]; None: only itself.
        center: what it ends in without misplacement.
        reach: largest misplacement looked at in each direction (5,).
        shifts: in the plane of the two shifts, by rising angle; that of ``direction``.
        tilts: likewise of the two tilts.
        radius: the lower and the upper one with an error of the radius alone.
        ball: largest s for which an ellipsoid with semi-axes s times :attr:`smaller_limits` is
            safe, of what both outlines and 72 directions between the axes tell.
        ball_beyond: what is met first outside of it; HOLDS if nothing.
        closings: that it took.
    """

    __repr__ = brief_repr

    setup: GripSetup
    pressure: float
    payload: float | None
    center: CaptureOutcome
    reach: Misplacement
    shifts: tuple[Boundary, ...] = ()
    tilts: tuple[Boundary, ...] = ()
    radius: tuple[Boundary, ...] = ()
    ball: float = 0.0
    ball_beyond: CaptureOutcome = CaptureOutcome.NOT_ANSWERED
    closings: int = 1

    @property
    def axes(self) -> tuple[tuple[Boundary, Boundary], ...]:
        """Boundaries with one component alone, the lower and the upper one of each; or none."""
        ends = {each.direction: each for each in (*self.shifts, *self.tilts, *self.radius)}
        ways = [tuple(way) for way in np.eye(5).tolist()] if ends else []
        return tuple((ends[tuple(-one for one in way)], ends[way]) for way in ways)

    @property
    def limits(self) -> Array:
        """Largest safe error in each direction with the others at zero (5, 2): lower, upper."""
        signs = (-1.0, 1.0)
        ends = [
            [s * each.fraction for s, each in zip(signs, pair, strict=True)] for pair in self.axes
        ]
        limits: Array = np.array(ends or np.zeros((5, 2))) * np.array(self.reach)[:, None]
        return limits

    @property
    def smaller_limits(self) -> Array:
        """The smaller of the two limits in each direction (5,)."""
        smaller: Array = np.abs(self.limits).min(axis=1)
        return smaller

    @property
    def semi_axes(self) -> Array:
        """Semi-axes of the ellipsoid in which all misplacements are safe (5,)."""
        semi_axes: Array = self.ball * self.smaller_limits
        return semi_axes

    def outline(self, boundaries: Sequence[Boundary]) -> Array:
        """Return the misplacements (n, 5) at boundaries."""
        places = [each.fraction * np.array(each.direction) for each in boundaries]
        at: Array = np.array(places).reshape(-1, 5) * np.array(self.reach)
        return at

    def margin(self, misplacement: Sequence[float] | Array) -> float:
        r"""Return which part of the way to the boundary of the ellipsoid is left.

        .. math:: 1 - \sqrt{\sum_i (x_i / a_i)^2}

        with the :attr:`semi_axes` a. Below 0 the object may still be held: the ellipsoid lies
        inside of the region. Minus infinity where nothing is held at the center.

        Raises:
            InvalidInputError: not five finite numbers.
        """
        off = np.array(require_vector("misplacement", misplacement, 5))
        if self.center is not CaptureOutcome.HOLDS:
            return -math.inf
        return 1.0 - float(np.linalg.norm(off / np.maximum(self.semi_axes, SMALLEST)))


# Yields misplacements (5,), receives what closing on them ends in; yields its answer at last.
Answer = Boundary | CaptureOutcome
Search = Generator[Misplacement | Answer, CaptureOutcome, None]


def capture_region(
    setup: GripSetup,
    pressure: float,
    payload: float | None = None,
    *,
    outlines: bool = True,
    executor: Executor | None = None,
    progress: Progress | None = None,
    known: Mapping[Misplacement, CaptureOutcome] | None = None,
    keep: Callable[[Misplacement, CaptureOutcome], None] | None = None,
) -> CaptureRegion:
    """Return the misplacements from which closing up to a pressure ends wrapped and holding.

    From the center outwards a boundary is looked for in ten steps of the reach, then between the
    last two: along the axes and the diagonals of two planes. Strips thinner than a step that are
    not held can be missed. Between these directions the boundary is followed from the straight line
    between its neighbors. 300 to 500 closings.

    Args:
        setup: the gripper and its object, a cylinder, in its place.
        pressure: up to which it closes [Pa], as a rule the recommended one.
        payload: mass of the object [kg]; see :func:`close_misplaced`.
        outlines: whether the boundary is followed between the directions above. Without it there
            are some 270 closings; the limits are the same, the ball is hardly another.
        executor: where; None closes one after the other, here.
        progress: called with the number of directions done and the number there are, after each
            closing.
        known: outcomes of an interrupted search; they are not computed again.
        keep: called with each new outcome as soon as it is known.

    Raises:
        InvalidInputError: see :func:`close_misplaced`.
    """
    _weight(setup, pressure, payload)
    setup = replace(setup, elements=setup.element_count)
    radius = float(setup.obstacle.shape.feature_radius)
    shift = FARTHEST_SHIFT * (radius + setup.gripper.tube.outer_radius)
    reach = np.array((shift, shift, LARGEST_TILT, LARGEST_TILT, LARGEST_RADIUS_ERROR * radius))
    closings = _Closings(
        partial(_outcome, setup, pressure, payload), executor, progress, keep, known
    )
    (center,) = closings.solve([_once(np.zeros(5))])
    empty = CaptureRegion(setup, pressure, payload, center, tuple(reach.tolist()))
    if center is not CaptureOutcome.HOLDS:
        return empty
    turns = [number / DIRECTIONS for number in range(DIRECTIONS)]
    ways = [_in_plane(plane, turn) for plane in PLANES for turn in turns]
    closings.total += 2 * len(ways) + 2
    last = np.eye(5)[4]
    found = closings.solve([_outwards(reach, way) for way in (*ways, -last, last)])
    first = [dict(zip(turns, found[n * DIRECTIONS :], strict=False)) for n in range(len(PLANES))]
    times = FOLLOWED if outlines else 0
    shifts, tilts = map(partial(_followed, closings, reach, times), PLANES, first)
    region = replace(empty, shifts=shifts, tilts=tilts, radius=tuple(found[-2:]))
    ball, beyond = _ball(closings, region)
    return replace(region, ball=ball, ball_beyond=beyond, closings=len(closings.used))


def safe_shift(
    setup: GripSetup, pressure: float, payload: float | None, wanted: float
) -> tuple[float, tuple[float, float]]:
    """Return how far an object may be shifted across its axis, from the middle of what is safe.

    The middle is looked for from the object's place along one shift, along the other, and along the
    first again. From there the object is shifted in eight directions, by a quarter more of the
    shift that is wanted each time, up to the first that is not held. Up to 120 closings; strips
    thinner than these steps can be missed.

    Args:
        setup: the gripper and its object, a cylinder, in its place.
        pressure: up to which it closes [Pa].
        payload: see :func:`close_misplaced`.
        wanted: shift that is wanted [m].

    Returns:
        The largest shift that was found to be held, at most twice the wanted one [m], and that
        middle: shifts of the object from its place, away from the base and across [m].

    Raises:
        InvalidInputError: see :func:`close_misplaced`.
    """
    require_positive("wanted", wanted)

    def holds(off: Array) -> bool:
        outcome = close_misplaced(setup, pressure, off, payload).outcome
        return outcome is CaptureOutcome.HOLDS

    if not holds(np.zeros(5)):
        return 0.0, (0.0, 0.0)
    chords = [0.5 * wanted * np.eye(5)[SHIFTS[number % 2]] for number in range(CENTERED)]
    aim = middle_of(holds, chords, int(2.0 * CENTERED_REACH))
    ways = [_in_plane(SHIFTS, number / DIRECTIONS) for number in range(DIRECTIONS)]
    sizes = SHIFT_PART * wanted * np.arange(0.0, 2.0 / SHIFT_PART + 1.0)
    held = takewhile(lambda size: all(holds(aim + size * way) for way in ways), sizes.tolist())
    return max(held, default=0.0), (float(aim[0]), float(aim[1]))


def middle_of(holds: Callable[[Array], bool], steps: Sequence[Array], count: int) -> Array:
    """Return the middle of what holds (5,), looked for along one way after the other.

    Args:
        holds: whether a misplacement (5,) is held.
        steps: along each way (5,), outwards in both senses up to the first that is not held.
        count: of steps at most.
    """
    aim = np.zeros(5)
    for step in steps:
        up, down = (
            sum(1 for _ in takewhile(holds, (aim + n * way for n in range(1, count + 1))))
            for way in (step, -step)
        )
        aim = aim + 0.5 * (up - down) * step
    return aim


def _in_plane(plane: tuple[int, int], turn: float) -> Array:
    """Return the unit vector (5,) at an angle in a plane, as a fraction of a turn."""
    direction = np.zeros(5)
    angle = 2.0 * math.pi * turn
    direction[list(plane)] = np.round((math.cos(angle), math.sin(angle)), 15)
    return direction


def _between_axes() -> list[Array]:
    """Return the unit vectors (72, 5) in the middle between two axes, and between all five."""
    ways = [way for way in product((-1.0, 0.0, 1.0), repeat=5) if way.count(0.0) in (0, 3)]
    return [np.array(way) / np.linalg.norm(way) for way in ways]


def _resolutions(reach: Array, way: Array) -> float:
    """Return how many resolutions the reach is in a direction."""
    return float(np.max(np.abs(way) * reach / RESOLUTION))


def _outwards(reach: Array, way: Array, guess: float | None = None) -> Search:
    """Look for a boundary: outwards from the center, or around a guess of its fraction."""
    resolution = 1.0 / _resolutions(reach, way)
    low, high, beyond = 0.0, math.inf, CaptureOutcome.HOLDS
    at = step = 1.0 / OUTWARD_STEPS
    if guess is not None:
        at, step = max(guess, resolution) - 0.5 * resolution, resolution
        if not guess < 1.0:
            at = 1.0
    while low < 1.0 and (math.isinf(high) or high - low > resolution):
        outcome = yield _tuple(at * way * reach)
        if outcome is CaptureOutcome.HOLDS:
            low = at
        else:
            high, beyond = at, outcome
        if math.isinf(high):
            at = min(round(low + step, 12), 1.0)
        elif guess is not None and not low > 0.0:
            at = max(high - step, 0.5 * high)
        else:
            at = 0.5 * (low + high)
        if guess is not None:
            step *= 2.0
    yield Boundary(tuple(way.tolist()), low, beyond)


def _followed(
    closings: _Closings,
    reach: Array,
    times: int,
    plane: tuple[int, int],
    outline: dict[float, Boundary],
) -> tuple[Boundary, ...]:
    """Return an outline with boundaries between its own: once, then up to so many times where bent.

    It is given by the direction, as a fraction of a turn, and its directions are even.
    """
    found = dict(outline)
    half = 0.5 / len(outline)
    turns = [turn + half for turn in outline]
    for _ in range(times):
        guesses = [
            _between(found[turn - half].fraction, found[(turn + half) % 1.0].fraction, half)
            for turn in turns
        ]
        searches = [
            _outwards(reach, _in_plane(plane, turn), guess)
            for turn, guess in zip(turns, guesses, strict=True)
        ]
        found |= zip(turns, closings.solve(searches), strict=True)
        half *= 0.5
        turns = [
            turn + side
            for turn, guess in zip(turns, guesses, strict=True)
            if abs(found[turn].fraction - guess) * _resolutions(reach, _in_plane(plane, turn))
            > BENT
            for side in (-half, half)
        ]
        closings.total += len(turns)
    return tuple(found[turn] for turn in sorted(found))


def _between(first: float, second: float, turn: float) -> float:
    """Return how far the line between two points of an outline is in the middle between them.

    At the reach where both are. ``turn`` is half of the angle between them, in turns.
    """
    if first + second in (0.0, 2.0):
        return first
    return 2.0 * first * second * math.cos(2.0 * math.pi * turn) / (first + second)


def _ball(closings: _Closings, region: CaptureRegion) -> tuple[float, CaptureOutcome]:
    """Return by how much the smaller limits have to be scaled to be safe, and what limits it.

    At most by what lies within both outlines. A way that is safe is taken to be safe at smaller
    sizes too.
    """
    boundaries = (*region.shifts, *region.tilts)
    places = [way * region.smaller_limits for way in _between_axes()]
    shares = region.outline(boundaries) / np.maximum(region.smaller_limits, SMALLEST)
    sizes = [1.0, *np.linalg.norm(shares, axis=1).tolist()]
    nearest = int(np.argmin(sizes))
    # What limits the axes themselves, where the ball is no smaller than they are.
    nearer = [min(ends, key=lambda end: end.fraction).beyond for ends in region.axes]
    limited = [each for each in nearer if each is not CaptureOutcome.HOLDS]
    along = (*limited, CaptureOutcome.HOLDS)[0]
    beyond = [along, *(each.beyond for each in boundaries)][nearest]
    low, high = 0.0, sizes[nearest]
    at = high
    while high - low > 1.0 / BALL_STEPS:
        closings.total += len(places)
        outcomes = closings.solve([_once(at * place) for place in places])
        failing = [n for n, each in enumerate(outcomes) if each is not CaptureOutcome.HOLDS]
        if failing:
            high, beyond = at, outcomes[failing[0]]
            places = [places[number] for number in failing]
        else:
            low = at
        at = 0.5 * (low + high)
    return low, beyond


def _tuple(place: Array) -> Misplacement:
    """Return a misplacement, without zeros of a negative sign."""
    return tuple((place + 0.0).tolist())


def _once(place: Array) -> Search:
    """Close on one misplaced object."""
    yield (yield _tuple(place))


class _Closings:
    """Closings for searches that go on side by side, here or on an executor.

    Attributes:
        total: searches that there are, for the progress.
        used: misplacements whose outcome was used.
    """

    def __init__(
        self,
        task: Callable[[Misplacement], CaptureOutcome],
        executor: Executor | None,
        progress: Progress | None,
        keep: Callable[[Misplacement, CaptureOutcome], None] | None,
        known: Mapping[Misplacement, CaptureOutcome] | None,
    ) -> None:
        self._task, self._executor = task, executor
        self._progress = progress or (lambda *_: None)
        self._keep = keep or (lambda *_: None)
        self._known = dict(known or {})
        self._done, self.total = 0, 1
        self.used: set[Misplacement] = set()

    def solve(self, searches: Sequence[Search]) -> list[Any]:
        """Return the answers of searches, in their order; none waits for another."""
        said: list[Any] = [next(search) for search in searches]
        running: dict[Future[CaptureOutcome], Misplacement] = {}
        try:
            while waiting := self._go_on(searches, said):
                new = [place for place in waiting if place not in running.values()]
                for place in new[: None if self._executor else 1]:
                    running[self._closing(place)] = place
                for job in wait(running, return_when=FIRST_COMPLETED).done:
                    place = running.pop(job)
                    self._known[place] = outcome = job.result()
                    self._keep(place, outcome)
                    open_ones = sum(isinstance(each, tuple) for each in said)
                    self._progress(self._done + len(said) - open_ones, self.total)
        finally:
            for job in running:
                job.cancel()
        self._done += len(said)
        return said

    def _go_on(self, searches: Sequence[Search], said: list[Any]) -> list[Misplacement]:
        """Go on with searches as far as outcomes are known; return the places they wait for."""
        for number, search in enumerate(searches):
            while isinstance(said[number], tuple):
                self.used.add(said[number])
                if said[number] not in self._known:
                    break
                said[number] = search.send(self._known[said[number]])
        return list(dict.fromkeys(place for place in said if isinstance(place, tuple)))

    def _closing(self, place: Misplacement) -> Future[CaptureOutcome]:
        """Close on a misplaced object, on the executor or here."""
        if self._executor is not None:
            return self._executor.submit(self._task, place)
        here = Future[CaptureOutcome]()
        here.set_result(self._task(place))
        return here


def _outcome(
    setup: GripSetup, pressure: float, payload: float | None, misplacement: Misplacement
) -> CaptureOutcome:
    """Return what closing on a misplaced object ends in."""
    return close_misplaced(setup, pressure, misplacement, payload).outcome
