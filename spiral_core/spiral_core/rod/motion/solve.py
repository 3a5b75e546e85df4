# SPDX-License-Identifier: Apache-2.0
"""Solve a rod in time: steps that adapt to their error, and to what happens in them.

The method is derived in ``docs/derivations/motion.md``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.rod.contact._continuation import Point, unsolved
from spiral_core.rod.contact._mesh import Arrays, discretize, discretize_like
from spiral_core.rod.contact._results import from_shape, point_of_state, shape_of, state_from_point
from spiral_core.rod.contact.problem import RodProblem
from spiral_core.rod.contact.solve import checked_count, solve_contact
from spiral_core.rod.motion._step import Moment, advanced, at_rest
from spiral_core.rod.motion._terms import masses, potential_energy
from spiral_core.rod.motion.inertia import Damping, Inertia
from spiral_core.rod.motion.motion import EventKind, Frame, Motion, MotionEvent, MotionStatus
from spiral_core.rod.state import RodState, RodStatus
from spiral_core.rod.types import Array
from spiral_core.validation import require_finite, require_positive

# Error of a step's positions, as a fraction of the rod's length.
DEFAULT_TOLERANCE = 1e-5
DEFAULT_LONGEST_STEP = 0.01
# The first step after a state of which no accelerations are known [of the longest step].
FIRST_STEP = 0.02
# A step grows and shrinks by at most this factor; the error goes with its cube.
GROWTH, SHRINKING, SAFETY = 1.5, 0.2, 0.85
# Shortest step, as a fraction of the longest one.
SHORTEST = 1e-5
# An event is located to this duration [of the longest step], and not again for as long as this.
EVENT_WIDTH, EVENT_PAUSE = 0.03, 20.0
# Impacts excite vibrations of single elements, which the method damps and no one asks for: once
# the rod has touched, errors shorten steps to this fraction of the longest one only.
AFTER_TOUCH = 0.5
# Beyond so many allowed errors such vibrations would grow: the implicit Euler method ends them.
ROUGH = 100.0
# Steps that differ by this fraction are one.
ROUNDING = 1e-6

Problem = Callable[[float], RodProblem]


def solve_motion(
    problem: Problem,
    inertia: Inertia,
    times: Sequence[float],
    *,
    damping: Damping | None = None,
    start: RodState | Array | None = None,
    elements: int | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    longest_step: float = DEFAULT_LONGEST_STEP,
) -> Motion:
    r"""Return how a rod moves while its loads, rest strain, ends and obstacles change in time.

    .. math:: m \ddot p = n' + w + f_c, \qquad \text{moments likewise, with } d(p) \ge r
        \text{ and Coulomb friction}

    Each step minimizes the energy of :func:`~spiral_core.rod.solve.solve_rod` plus
    inertia and damping. Of second order in time where the rod is free; nodes that touch go by the
    implicit Euler method and meet obstacles without rebound.

    Args:
        problem: rod, ends, loads and obstacles at a time [s]; the same kinds of ends and shapes of
            obstacles at all times.
        inertia: of the rod.
        times: of the frames, increasing; the motion begins at the first [s].
        damping: None is that of a silicone tube in air.
        start: where the rod is at rest at first: a state, or a centerline (n, 3) [m] along the rod,
            from which it is let go; None is the static state of the problem then.
        elements: how many; None takes those of the start, or one for each leg of the centerline.
        tolerance: error of a step, as a fraction of the length.
        longest_step: [s].

    Returns:
        The frames, and whether the last time was reached.

    Raises:
        InvalidInputError: an argument, or a problem at some time, is not valid.
        SolverError: there is no static state to begin with.

    Example:
        A tube let go at the horizontal falls.

        >>> from spiral_core import Rod, RodLoad, Section, solve_rod
        >>> rod = Rod(0.3, Section((2e-4, 3e-4, 3e-4)), radius=5e-3)
        >>> heavy = RodProblem(rod, RodLoad(distributed=(0.0, 0.0, -0.28)))
        >>> weightless = solve_rod(rod, elements=20)
        >>> tube = Inertia(mass=0.0285, rotary=3e-7)
        >>> motion = solve_motion(lambda time: heavy, tube, (0.0, 0.1), start=weightless)
        >>> bool(-0.1 < motion.positions[-1, -1, 2] < -0.02)
        True
    """
    frames = tuple(
        motion_frames(
            problem, inertia, times, damping=damping, start=start, elements=elements,
            tolerance=tolerance, longest_step=longest_step,
        )
    )  # fmt: skip
    complete = len(frames) == len(times)
    return Motion(MotionStatus.COMPLETED if complete else MotionStatus.STALLED, frames)


def motion_frames(
    problem: Problem,
    inertia: Inertia,
    times: Iterable[float],
    *,
    damping: Damping | None = None,
    start: RodState | Array | None = None,
    elements: int | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    longest_step: float = DEFAULT_LONGEST_STEP,
) -> Iterator[Frame]:
    """Yield the frames of :func:`solve_motion` as they are computed; fewer if it stalls.

    Times may come one by one, as from a generator: each is asked for when the frame before it has
    been taken.
    """
    require_positive("tolerance", tolerance)
    require_positive("longest_step", longest_step)
    moments = _increasing(times)
    begin = next(moments)
    first = _problem_at(problem, begin)
    point = _start(first, start, elements)
    _require_uncoupled(point.arrays)
    here = at_rest(begin, replace(point, at=begin))
    run = _Run(
        problem, masses(point.arrays, inertia), damping or Damping(),
        tolerance * point.arrays.length, longest_step, here, first, point.arrays,
        FIRST_STEP * longest_step,
        residual=point.solution.residual, touched=bool(here.touches.any()),
    )  # fmt: skip
    yield run.frame()
    for time in moments:
        if not run.reach(time):
            return
        yield run.frame()


def _increasing(times: Iterable[float]) -> Iterator[float]:
    """Yield times that increase, at least one; refuse others."""
    last = -np.inf
    for time in times:
        if not require_finite("times", time) > last:
            raise InvalidInputError("times", time, f"increasing, here above {last:g}")
        last = time
        yield time
    if last == -np.inf:
        raise InvalidInputError("times", (), "one or more increasing times")


def _start(first: RodProblem, start: RodState | Array | None, elements: int | None) -> Point:
    """Return where the rod begins, under the first problem."""
    if start is None:
        start = solve_contact(first, elements=elements)
    if not isinstance(start, RodState) or start._point is None:
        legs = len(shape_of(start)) - 1
        count = checked_count([first], legs if elements is None else elements)
        arrays = discretize(first, count)
        return unsolved(arrays, from_shape(first, arrays, start))
    point = point_of_state(start)
    if elements not in (None, point.arrays.count):
        requirement = f"those of the start, {point.arrays.count}"
        raise InvalidInputError("elements", elements, requirement)
    return replace(point, arrays=discretize_like(first, point.arrays))


def _problem_at(problem: Problem, time: float) -> RodProblem:
    """Return the problem at a time; refuse what is none."""
    found = problem(time)
    if not isinstance(found, RodProblem):
        raise InvalidInputError("problem", found, "a function from a time to a RodProblem")
    return found


def _require_uncoupled(arrays: Arrays) -> None:
    """Refuse sections that couple bending with stretch: their damping is left out."""
    if arrays.elements.coupling.any():
        requirement = "one that does not couple bending with stretch, while it moves"
        raise InvalidInputError("section", "coupled", requirement)


@dataclass(slots=True, eq=False)
class _Run:
    """A motion while it is computed."""

    problem: Problem
    inertia: Array
    damping: Damping
    allowed: float
    longest: float
    here: Moment
    posed: RodProblem
    arrays: Arrays
    step: float
    steps: int = 0
    error: float = 0.0
    events: list[MotionEvent] = field(default_factory=list)
    residual: float = 0.0
    passes: int = 0
    quiet_until: float = -np.inf
    touched: bool = False

    def reach(self, time: float) -> bool:
        """Step to a time exactly; return whether it was reached."""
        while self.here.time < time:
            left = time - self.here.time
            parts = max(1, int(np.ceil(left / self.step - 1e-9)))
            duration = left / parts  # even steps: uneven ones disturb the accelerations
            at = time if parts == 1 else self.here.time + duration
            if not self._try(at, duration) and self.step < SHORTEST * self.longest:
                return False
        return True

    def _try(self, at: float, duration: float) -> bool:
        """Take a step if it is good enough; choose the next one's length."""
        given = (self._arrays(at), duration, self.inertia, self.damping)
        after, error = advanced(self.here, *given)
        if self.touched and error > ROUGH * self.allowed:
            after, error = advanced(replace(self.here, started=False), *given)
        if after is None:
            self.step = 0.3 * duration
            return False
        ratio = (self.allowed / max(error, 1e-3 * self.allowed)) ** (1.0 / 3.0)
        factor = float(np.clip(SAFETY * ratio, SHRINKING, GROWTH))
        least = self._least(duration)
        if error > 2.0 * self.allowed and duration > (1.0 + ROUNDING) * least:
            self.step = max(duration * factor, least)
            return False
        changes = _changes(self.here, after)
        locating = changes and at > self.quiet_until
        if locating and duration > EVENT_WIDTH * self.longest:
            self.step = max(0.4 * duration, 0.9 * EVENT_WIDTH * self.longest)
            return False
        if locating:
            self.quiet_until = at + EVENT_PAUSE * self.longest
        self.touched = self.touched or bool(changes)
        self.events += [MotionEvent(kind, j, at, duration) for kind, j in changes]
        self.here = replace(after, time=at)
        self.steps, self.error = self.steps + 1, self.error + error
        self.residual = max(self.residual, after.point.solution.residual)
        self.passes += after.point.solution.passes
        self.step = min(self.longest, max(duration * factor, least))
        return True

    def _least(self, duration: float) -> float:
        """Return the length below which errors do not shorten a step [s]."""
        if self.touched:
            return min(GROWTH * duration, AFTER_TOUCH * self.longest)
        return 10.0 * SHORTEST * self.longest

    def _arrays(self, time: float) -> Arrays:
        """Return the problem at a time, on the mesh of the start; as it was while it stays."""
        before = self.arrays
        found = _problem_at(self.problem, time)
        if found is self.posed:
            return before
        arrays = discretize_like(found, before)
        _require_uncoupled(arrays)
        if not np.array_equal(arrays.end_free, before.end_free):
            requirement = "as many breaks, kinds of ends and shapes of obstacles at all times"
            raise InvalidInputError("problem", found, requirement)
        self.posed, self.arrays = found, arrays
        return arrays

    def frame(self) -> Frame:
        """Return the rod where it is, and the events since the last frame."""
        here = self.here
        state = state_from_point(here.point, self.passes, RodStatus.CONVERGED)
        energy = potential_energy(here.point.arrays, here.point.x)
        frame = Frame(
            time=here.time,
            state=replace(state, energy=energy, smallest_pivot=np.nan),  # moving: no certificate
            velocities=here.y.rate[:, :3].copy(),
            kinetic_energy=0.5 * float(np.sum(self.inertia * here.y.rate**2)),
            steps=self.steps,
            error=self.error,
            residual=self.residual,
            events=tuple(self.events),
        )
        self.events, self.residual, self.passes = [], 0.0, 0
        return frame


def _changes(here: Moment, after: Moment) -> list[tuple[EventKind, int]]:
    """Return what happens to the contacts in a step."""
    found = []
    for j in range(len(after.point.arrays.obstacles)):
        before, now = here.point.x.normal[j] > 0.0, after.point.x.normal[j] > 0.0
        if now.any() and not before.any():
            found.append((EventKind.TOUCH, j))
        elif before.any() and not now.any():
            found.append((EventKind.LOSS, j))
        elif now.any() and _sticks(here, j) and not _sticks(after, j):
            found.append((EventKind.SLIP, j))
    return found


def _sticks(moment: Moment, j: int) -> bool:
    """Return whether every node in contact with an obstacle sticks."""
    contacts = moment.point.solution.contacts
    rubs = contacts.friction[j] > 0.0
    return bool(rubs and np.all(contacts.sticks[j, contacts.active[j]]))
