# SPDX-License-Identifier: Apache-2.0
"""The grip on one object: pressures, holding forces, recommended pressure; many grips at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise, product

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError, NoCoilError, NotGrippableError, SolverError
from spiral_core.grip.holding import HoldingForce, Pull, holding_force, holding_forces
from spiral_core.grip.places import not_held
from spiral_core.grip.setup import Closing, GripSetup, friction_of, lay_into_coil
from spiral_core.grip.window import (
    LOSS_MARGIN,
    GripPoint,
    GripWindow,
    WindowEnd,
    grip_window,
)
from spiral_core.message import Message, Quantity
from spiral_core.numerics.tasks import Progress, resume
from spiral_core.rod.types import Array, Vector
from spiral_core.rounding import rounded_down
from spiral_core.validation import require_positive
from spiral_core.wrap.gripper import Gripper

# Pressures at which forces are looked for, from a little below the wrap to the last that holds.
FORCE_PRESSURES = 10
BELOW_WRAP = 0.95
# Payload is carried with this much force to spare, where nothing else is asked for.
PAYLOAD_SAFETY = 2.0
# Curling bounds the recommended pressures where they would then reach over this fraction of the
# wrap's onset: a coil that curls from the onset on would leave no margin to it.
LEAST_RANGE = 0.04
# So often the pressure for a payload is corrected by a force computed there.
CARRY_TRIES = 6


class RangeEnd(Enum):
    """What bounds the recommended pressures from above; the value says it in words."""

    CURLING = "the end curls from there on"
    LOSS = "a tenth below the loss"
    LIFT_OFF = "the tip lifts off there"
    NOT_FOLLOWED = "a tenth below where the tube could not be followed on"
    SELF_CONTACT = "turns of the tube touch each other above it"
    LIMIT = "the gripper's pressure limit"
    LOOKED_AT = "the last pressure looked at"


@dataclass(frozen=True, slots=True, eq=False)
class Grip:
    """A gripper around an object: at which pressures it holds, and how much.

    Args:
        window: what the rising pressure does.
        points: the grip at each pressure looked at (m).
        forces: for each way of moving the object, what holds it at each pressure (m).
    """

    __repr__ = brief_repr

    window: GripWindow
    points: tuple[GripPoint, ...]
    forces: Mapping[Pull, tuple[HoldingForce, ...]]

    @property
    def setup(self) -> GripSetup:
        """The gripper and its object."""
        return self.window.setup

    @property
    def pressures(self) -> Array:
        """Pressures looked at (m,) [Pa]."""
        return np.array([point.pressure for point in self.points])

    @property
    def contact_length(self) -> Array:
        """Length of tube that touches the object (m,) [m]."""
        return np.array([point.contact_length for point in self.points])

    @property
    def normal_force(self) -> Array:
        """Sum of the normal forces (m,) [N]."""
        return np.array([point.normal_force for point in self.points])

    @property
    def contact_pressure(self) -> Array:
        """Largest pressure of the tube on the object (m,) [Pa], an estimate."""
        return np.array([point.contact_pressure for point in self.points])

    def force(self, pull: Pull) -> Array:
        """Return the peak force [N] or torque [N m] against a pull at each pressure (m,).

        Raises:
            InvalidInputError: this pull was not looked at.
        """
        if not self.forces.get(pull):
            names = ", ".join(each.name for each, found in self.forces.items() if found)
            raise InvalidInputError("pull", pull.name, f"one that was computed: {names or 'none'}")
        return np.array([held.force for held in self.forces[pull]])

    @property
    def onset_wrap(self) -> float:
        """Lowest pressure at which the tip and more than a tenth of the tube touch [Pa]."""
        if self.window.onset_wrap is None:
            raise not_held(self.window)
        return self.window.onset_wrap

    @property
    def recommended_range(self) -> tuple[float, float]:
        """Pressures that hold with the whole length and stay clear of the loss (low, high) [Pa].

        From the onset of the wrap to what :attr:`range_end` says: the onset of curling, unless the
        end curls all but from the wrap on; a tenth below the loss; where the tip lifts off; or the
        last pressure that was looked at.
        """
        return self.onset_wrap, self._upper_end[0]

    @property
    def range_end(self) -> RangeEnd:
        """What bounds :attr:`recommended_range` from above."""
        return self._upper_end[1]

    @property
    def carrying_range(self) -> tuple[float, float]:
        """Pressures at which a payload may be carried (low, high) [Pa], beyond curling too."""
        return self.onset_wrap, self._safe_end[0]

    @property
    def _upper_end(self) -> tuple[float, RangeEnd]:
        """End of the recommended range [Pa], and what it is."""
        curling, safe = self.window.onset_curling, self._safe_end
        if curling is not None and (1.0 + LEAST_RANGE) * self.onset_wrap < curling < safe[0]:
            return curling, RangeEnd.CURLING
        return safe

    @property
    def _safe_end(self) -> tuple[float, RangeEnd]:
        """Last pressure that holds, clear of the loss and with the tip on the object [Pa]."""
        window = self.window
        top = window.top
        ends = {
            WindowEnd.LIMIT: (top, RangeEnd.LIMIT),
            WindowEnd.SELF_CONTACT: (top, RangeEnd.SELF_CONTACT),
            WindowEnd.NOT_FOLLOWED: ((1.0 - LOSS_MARGIN) * top, RangeEnd.NOT_FOLLOWED),
        }
        bounds = [ends.get(window.end, (top, RangeEnd.LOOKED_AT))]
        if window.is_cut_short:
            bounds = [(top, RangeEnd.LOOKED_AT)]
        loss = window.loss or window.loss_above
        if loss is not None:
            bounds.append(((1.0 - LOSS_MARGIN) * loss, RangeEnd.LOSS))
        if window.lift_off is not None:
            bounds.append((window.lift_off, RangeEnd.LIFT_OFF))
        end, why = min(bounds, key=lambda bound: bound[0])
        return max(self.onset_wrap, end), why

    def recommended_pressure(
        self, payload: float | None = None, *, force_max: float | None = None
    ) -> float:
        """Return the pressure to command [Pa].

        Without conditions the middle of :attr:`recommended_range`. With a payload the pressure next
        to the middle that carries it, with a greatest force the one that stays under it. Both may
        lie beyond the onset of curling, but not within a tenth of the loss or where the tip hangs
        free. A payload is judged within the pressures that were looked at.

        Args:
            payload: mass of the object [kg]; needs ``Pull.DOWN`` among the forces.
            force_max: greatest sum of normal forces on the object [N].

        Raises:
            InvalidInputError: a value is out of its range.
            NotGrippableError: no pressure of the window meets both.
        """
        best = 0.5 * sum(self.recommended_range)
        low, end = self.carrying_range
        computed = self.pressures[(low <= self.pressures) & (self.pressures <= end)]
        grid = np.unique(np.concatenate((np.linspace(low, end, 401), computed, [best])))
        if force_max is not None:
            require_positive("force_max", force_max)
            normal = np.interp(grid, self.window.pressures, self.window.normal_forces)
            if not (normal <= force_max).any():
                least = float(normal.min())
                reason = Message(
                    "the wrapped coil presses with {} or more, above {}",
                    Quantity(least, "N"),
                    Quantity(force_max, "N"),
                )
                raise NotGrippableError(self._radius, reason, force_max - least, None)
            grid = grid[normal <= force_max]
        if payload is None:
            return float(grid[np.argmin(np.abs(grid - best))])
        return self._carrying(payload, grid, best, force_max)

    def _carrying(self, payload: float, grid: Array, best: float, force_max: float | None) -> float:
        """Return the pressure of a grid next to the best that carries a payload [Pa].

        The force is computed at the best; between the pressures looked at it is interpolated, then
        computed.
        """
        at, ratio, tries = self.pressures, self.payload_ratio(payload), 0
        held = np.zeros(0)
        low, end = float(grid[0]), float(grid[-1])
        possible = grid = grid[(at[0] <= grid) & (grid <= at[-1])]
        if not grid.size:
            reason = Message(
                "no pressure looked at is between {} and {}, where a payload may be carried",
                Quantity(low, "Pa"),
                Quantity(end, "Pa"),
            )
            gap = float(min(at[-1] - low, end - at[0]))
            raise NotGrippableError(self._radius, reason, gap, None)
        while possible.size:
            chosen = float(possible[np.argmin(np.abs(possible - best))])
            place = int(np.searchsorted(at, chosen))
            if at[place] != chosen:
                force = holding_force(self.window.at(chosen), Pull.DOWN).force
                at = np.insert(at, place, chosen)
                ratio = np.insert(ratio, place, force / self.setup.weight_of(payload))
                tries += 1
            if ratio[place] >= PAYLOAD_SAFETY:
                return chosen
            if tries == CARRY_TRIES:
                grid = grid[np.isin(grid, at)]
            held = np.nan_to_num(np.interp(grid, at, ratio))
            possible = grid[held >= PAYLOAD_SAFETY]
        raise self._carries_less(payload, float(held.max(initial=0.0)), force_max)

    def payload_ratio(self, payload: float) -> Array:
        """Return holding force along gravity over the object's weight at each pressure (m,).

        Args:
            payload: mass of the object [kg], > 0.

        Raises:
            InvalidInputError: it is not positive, or ``Pull.DOWN`` was not looked at.
        """
        ratio: Array = self.force(Pull.DOWN) / self.setup.weight_of(payload)
        return ratio

    def _carries_less(
        self, payload: float, most: float, force_max: float | None
    ) -> NotGrippableError:
        """Return the refusal of a payload; ``most`` is the largest ratio of force to weight."""
        within = ""
        if force_max is not None:
            within = Message(" without pressing with more than {}", Quantity(force_max, "N"))
        largest = Quantity(most / PAYLOAD_SAFETY * payload, "kg", rounded_down)
        reason = Message(
            "no pressure holds {} {:.3g} times over{}; at most {}",
            Quantity(payload, "kg"),
            PAYLOAD_SAFETY,
            within,
            largest,
        )
        missing = (most - PAYLOAD_SAFETY) * self.setup.weight_of(payload)
        return NotGrippableError(self._radius, reason, missing, None)

    @property
    def _radius(self) -> float:
        """Of the object [m]."""
        return float(self.setup.obstacle.shape.feature_radius)


def solve_grip(
    setup: GripSetup,
    pulls: Sequence[Pull] = (Pull.AWAY, Pull.TOWARDS),
    *,
    pressures: Sequence[float] | None = None,
    window: GripWindow | None = None,
    progress: Progress | None = None,
) -> Grip:
    """Return the pressures at which a gripper holds an object, and with what force.

    Args:
        setup: the gripper and its object, of :func:`lay_into_coil` or with a pose of your own.
        pulls: ways of moving the object whose holding force is wanted.
        pressures: at which forces are looked for [Pa], increasing; None takes ten from a little
            below the perfect wrap to the last that holds.
        window: of this setup, where it is known already.
        progress: called with the number of steps done and the number there are, after each.

    Raises:
        InvalidInputError: pressures do not increase, or one is outside of those that hold; a pull
            is no Pull.
        NotGrippableError: no pressure wraps the object; carries why and, for a cylinder laid into
            the coil, the nearest radius that is held.
        SolverError: a state could not be certified.
    """
    for pull in pulls:
        if not isinstance(pull, Pull):
            raise InvalidInputError("pulls", pull, "members of Pull")
    if window is None:
        window = grip_window(setup, progress=progress)
    if window.onset_wrap is None:
        raise not_held(window, progress)
    if pressures is not None and not all(b > a for a, b in pairwise(pressures)):
        raise InvalidInputError("pressures", tuple(pressures), "increasing", "Pa")
    if pressures is None:
        pressures = _force_pressures(window.onset_wrap, window.top)
    points: list[GripPoint] = []
    forces: dict[Pull, list[HoldingForce]] = {pull: [] for pull in pulls}
    for number, pressure in enumerate(pressures):
        points.append(window.at(pressure))
        for pull, held in holding_forces(points[-1], pulls).items():
            forces[pull].append(held)
        if progress is not None:
            progress(number + 1, len(pressures))
    return Grip(window, tuple(points), {pull: tuple(found) for pull, found in forces.items()})


def recommended_grip(
    setup: GripSetup, payload: float | None = None, progress: Progress | None = None
) -> GripPoint:
    """Return the grip at its recommended pressure, see :meth:`Grip.recommended_pressure`.

    Holding forces are computed only with a payload [kg]: at the middle of the recommended ones, and
    from there outwards up to the first that carries it.

    Raises:
        InvalidInputError: the payload is not positive.
        NotGrippableError: no pressure wraps the object, or carries the payload.
        SolverError: a state could not be certified.
    """
    window = solve_grip(setup, (), pressures=(), progress=progress).window
    unasked = Grip(window, (), {})
    middle = window.at(unasked.recommended_pressure())
    if payload is None:
        return middle
    weight = PAYLOAD_SAFETY * setup.weight_of(payload)
    held = holding_force(middle, Pull.DOWN, weight)
    if held.force >= weight:
        return middle
    low, end = unasked.carrying_range
    found = [(middle, held)]
    others = {*_force_pressures(low, window.top)} - {middle.pressure}
    outwards = sorted(others, key=lambda each: abs(each - middle.pressure))
    for number, pressure in enumerate(outwards, start=1):
        point = window.at(pressure)
        held = holding_force(point, Pull.DOWN)
        found.append((point, held))
        if progress is not None:
            progress(number, len(outwards))
        if held.force >= weight and low <= pressure <= end:
            break
    points, forces = zip(*sorted(found, key=lambda each: each[0].pressure), strict=True)
    return window.at(Grip(window, points, {Pull.DOWN: forces}).recommended_pressure(payload))


def _force_pressures(onset: float, top: float) -> list[float]:
    """Return the pressures at which forces are looked for, if no others are given (n,) [Pa]."""
    pressures: list[float] = np.linspace(BELOW_WRAP * onset, top, FORCE_PRESSURES).tolist()
    return pressures


@dataclass(frozen=True, slots=True)
class Refinement:
    """What twice the elements change, and how far the contact lets the tube sink in.

    Contact is hard, without a stiffness to choose: its sharpness is the penetration that is left.

    Args:
        elements: of the grip.
        window: largest change of an onset or the loss, as a fraction; infinite where only one of
            the two has it.
        force: the same of the holding force away from the base at the recommended pressure.
        penetration: largest of a node into the object, as a fraction of the tube's outer radius.
    """

    elements: int
    window: float
    force: float
    penetration: float

    def __str__(self) -> str:
        differs = f"differs by {100.0 * self.window:.1f} %"
        window = differs if math.isfinite(self.window) else "has other ends"
        return (
            f"{self.elements} and {2 * self.elements} elements: window {window}, "
            f"force by {100.0 * self.force:.1f} %; "
            f"contact sinks in by {self.penetration:.0e} r_o"
        )


def refine(grip: Grip) -> Refinement:
    """Return what twice the elements change of a grip.

    Takes some three times as long as the window itself.

    Raises:
        NotGrippableError: the grip has no window, or none on twice the elements.
        SolverError: a state could not be certified.
    """
    window = grip.window
    count = window.setup.element_count
    stations = None if window.end is WindowEnd.LOST else window.pressures[1:]
    finer = grip_window(replace(window.setup, elements=2 * count), stations)
    pressure = min(grip.recommended_pressure(), finer.top)
    coarse, fine = (holding_force(each.at(pressure), Pull.AWAY).force for each in (window, finer))
    sunk = min(float(point.state.gaps.min()) for each in (window, finer) for point in each.points)
    return Refinement(
        elements=count,
        window=max(
            _change(getattr(window, mark), getattr(finer, mark))
            for mark in ("onset_wrap", "onset_curling", "loss")
        ),
        force=_change(coarse, fine),
        penetration=max(0.0, -sunk) / window.setup.gripper.tube.outer_radius,
    )


def _change(coarse: float | None, fine: float | None) -> float:
    """Return how far two values differ, as a fraction of the finer."""
    if coarse == fine:
        return 0.0
    return abs(coarse - fine) / abs(fine) if fine and coarse is not None else math.inf


@dataclass(frozen=True, slots=True)
class GripCase:
    """One grip of a study.

    Args:
        gripper: as it is mounted.
        radius: of the cylinder [m].
        friction: Coulomb's coefficient.
        closing: how it closes.
    """

    __repr__ = brief_repr

    gripper: Gripper
    radius: float
    friction: float
    closing: Closing = Closing.SLOW


@dataclass(frozen=True, slots=True)
class GripOutcome:
    """The result of one grip of a study, as plain numbers.

    Args:
        refusal: why it is not held; empty if it is.
        tip_criterion: pressure of the perfect wrap by the free coil's tip [Pa].
        onset_wrap, onset_curling, loss: the window [Pa]; None where there is none.
        pressure: recommended [Pa], at which the other figures are.
        contact_length: [m].
        normal_force: sum [N].
        away, towards: holding forces [N]; None where not even the first step could be followed.
        away_is_lower_bound, towards_is_lower_bound: whether the force was still rising where the
            pull ended.
    """

    refusal: str
    tip_criterion: float | None = None
    onset_wrap: float | None = None
    onset_curling: float | None = None
    loss: float | None = None
    pressure: float | None = None
    contact_length: float | None = None
    normal_force: float | None = None
    away: float | None = None
    towards: float | None = None
    away_is_lower_bound: bool = False
    towards_is_lower_bound: bool = False


def grip_cases(
    grippers: Iterable[Gripper],
    radii: Sequence[float],
    frictions: Sequence[float] | None = None,
    gravities: Sequence[Vector] | None = None,
    closing: Closing = Closing.SLOW,
) -> tuple[GripCase, ...]:
    """Return every combination of designs, objects, friction and mounts.

    Args:
        grippers: designs, as they are mounted.
        radii: of the objects [m].
        frictions: Coulomb's coefficients; None takes each gripper's own or the default.
        gravities: accelerations in the base frame [m/s^2], a mount each; None keeps the grippers'.
        closing: how they close.
    """
    mounts: Sequence[Vector | None] = [None] if gravities is None else list(gravities)
    return tuple(
        GripCase(
            gripper if gravity is None else replace(gripper, gravity=gravity),
            radius,
            friction,
            closing,
        )
        for gripper in grippers
        for radius, friction, gravity in product(
            radii, (friction_of(gripper, None),) if frictions is None else frictions, mounts
        )
    )


def solve_case(case: GripCase) -> GripOutcome:
    """Return one grip of a study; plain values in and out, so that it runs anywhere.

    Forces are those at the recommended pressure.
    """
    try:
        setup = lay_into_coil(
            case.gripper, case.radius, friction=case.friction, closing=case.closing
        )
        window = solve_grip(setup, (), pressures=()).window
        middle = Grip(window, (), {}).recommended_pressure()
        grip = solve_grip(setup, pressures=[middle], window=window)
    except (NotGrippableError, NoCoilError, SolverError) as error:
        return GripOutcome(str(error))
    point = grip.points[0]
    (away,), (towards,) = grip.forces[Pull.AWAY], grip.forces[Pull.TOWARDS]
    return GripOutcome(
        refusal="",
        tip_criterion=setup.tip_pressure,
        onset_wrap=window.onset_wrap,
        onset_curling=window.onset_curling,
        loss=window.loss,
        pressure=middle,
        contact_length=point.contact_length,
        normal_force=point.normal_force,
        away=_known(away.force),
        towards=_known(towards.force),
        away_is_lower_bound=away.is_lower_bound,
        towards_is_lower_bound=towards.is_lower_bound,
    )


def _known(force: float) -> float | None:
    return None if math.isnan(force) else force


def solve_cases(
    cases: Sequence[GripCase],
    executor: Executor | None = None,
    progress: Progress | None = None,
    *,
    known: Mapping[int, GripOutcome] | None = None,
    keep: Callable[[int, GripOutcome], None] | None = None,
) -> tuple[GripOutcome, ...]:
    """Return every grip of a study, in the order of its cases.

    Args:
        cases: what to solve.
        executor: where; None solves one after the other, here.
        progress: called with the number done and the number there are, after each.
        known: outcomes of an interrupted study by their case's number; they are not solved again.
        keep: called with each new outcome and its case's number, in their order, so that an
            interruption costs only what is under way.
    """
    done = dict(known or {})
    resume(solve_case, dict(enumerate(cases)), done, keep, executor, progress, len(done))
    return tuple(done[number] for number in range(len(cases)))
