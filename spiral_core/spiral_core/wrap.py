r"""The perfect wrap: which pressure coils a gripper exactly onto which cylinder.

At the perfect wrap the whole length touches the object and the tip, which carries no moment, has
the curvature of the free shape; its tangent makes the angle :math:`\theta` with the object's axis,
so that

.. math:: r_w(P) = \sin^2\theta_\mathrm{end}(P) / \kappa(P) - r_o

(derived in ``docs/derivations/wrap.md``). Only the coiled branch counts: the pressures, up to the
limit, over which the gripper makes the required turns and :math:`r_w` falls with pressure, without
a snap between.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from spiral_core.actuation import RestShape
from spiral_core.coil import Coil, coil_axis, coil_from_state, tip_angle
from spiral_core.errors import NoCoilError, NotGrippableError, SolverError
from spiral_core.gripper import Gripper
from spiral_core.rod import Array, RodState, RodStatus, RodStiffness, Vector, solve_rod
from spiral_core.rod_discretization import element_count
from spiral_core.rod_path import follow_path
from spiral_core.roots import minimum
from spiral_core.validation import require_in_range, require_positive

# Pressures at which the whole range is solved once: so close that the tip turns by at most this
# angle from one to the next [rad], and every solve between two of them is a short warm start.
FEWEST_SAMPLES = 48
SAMPLE_TURN = 1.2
# Pressures at which the unloaded shape is looked up to place them.
TABLE = 256
# A helix whose centerline is nearer to its axis than this many outer radii holds nothing, with or
# without gravity.
CLOSED_RATIO = 0.8
# Largest angle that an element turns by, at the tightest coil [rad]: the wrapped radius is then
# right to about 1e-6 of itself.
ELEMENT_ANGLE = 0.4
# Relative error of the radius at which the search for its pressure ends.
RADIUS_TOLERANCE = 1e-9
SEARCH_LIMIT = 60
# Ends of the branch are located to this fraction of the pressure limit.
END_TOLERANCE = 1e-10
# Where a coil closes on itself, the branch ends at this fraction of the tube's outer radius.
LEAST_RADIUS = 1e-3
# A radius within this fraction of the perfect one still counts as a perfect wrap: the scatter of
# the paper's prototypes and of an estimated radius is no finer.
PERFECT_BAND = 0.02


class WrapRegime(Enum):
    """How a gripper at some pressure holds an object (the paper's Fig. 4)."""

    OVERHANG = "overhang"
    PERFECT_WRAP = "perfect wrap"
    CURLING = "curling"


@dataclass(frozen=True, slots=True, eq=False)
class Wrap:
    """A gripper coiled by one pressure, and the cylinder it fits.

    Args:
        pressure: gauge pressure [Pa].
        object_radius: radius of the cylinder that it wraps perfectly [m].
        turns: of the whole length about the object's axis.
        tip_angle: between the tip's tangent and that axis [rad].
        free_length_needed: length of gripper that makes the required turns, counted from the tip
            [m]; None if it makes fewer.
        object_length_needed: object length that those turns cover [m]; None likewise.
        contact_length: length of gripper in contact with its cylinder [m]: all of it, which is what
        perfect wrap means.
        rest_shape: the unloaded shape.
        coil: turns and advance along the rod.
        state: the shape, with its certificate.
    """

    pressure: float
    object_radius: float
    turns: float
    tip_angle: float
    free_length_needed: float | None
    object_length_needed: float | None
    contact_length: float
    rest_shape: RestShape
    coil: Coil
    state: RodState


class WrapCurve:
    """Pressure against object radius for one gripper as it is mounted.

    The whole range is solved once; every question after that is a short warm start from the nearest
    solved pressure, so that answers do not depend on the order of the questions.

    Args:
        gripper: the gripper.

    Raises:
        NoCoilError: it nowhere makes the required turns.
        SolverError: a shape could not be certified.

    Attributes:
        gripper: the gripper.
        pressure_min, pressure_max: ends of the coiled branch [Pa].
        radius_min, radius_max: the grippable range [m]; the largest radius belongs to the smallest
            pressure.
    """

    def __init__(self, gripper: Gripper) -> None:
        self.gripper = gripper
        self._pressures = _sample_pressures(gripper)
        top = gripper.rest_shape(float(self._pressures[-1]))
        self._elements = element_count(gripper.rod(top), gripper.load(top), ELEMENT_ANGLE)
        self._states = self._sweep()
        samples = [self._wrap(p, s) for p, s in zip(self._pressures, self._states, strict=True)]
        last = self._last_on_branch(samples)
        first = self._first_on_branch(samples, last)
        low, high = self._branch_start(samples, first), self._branch_end(samples, last)
        self.pressure_min, self.pressure_max = low.pressure, high.pressure
        self.radius_min, self.radius_max = high.object_radius, low.object_radius
        inner = [s for s in samples[first : last + 1] if low.pressure < s.pressure < high.pressure]
        branch = [low, *inner, high]
        self._branch_pressures = np.array([s.pressure for s in branch])
        self._branch_curvatures = np.array(
            [self._contact_curvature(s.object_radius) for s in branch]
        )

    def state_at_pressure(self, pressure: float) -> RodState:
        """Return the shape at any pressure [Pa] within the gripper's limit, coiled or not.

        Raises:
            InvalidInputError: the pressure is not in [0, the gripper's ``pressure_max``].
            SolverError: the shape could not be certified.
        """
        return self._solve(self.gripper.rest_shape(pressure), self._nearest_state(pressure))

    def wrap_at_pressure(self, pressure: float) -> Wrap:
        """Return what the gripper wraps at a pressure [Pa].

        Raises:
            InvalidInputError: the pressure is not positive or above the gripper's ``pressure_max``.
            SolverError: the shape could not be certified.
        """
        require_positive("pressure", pressure)
        return self._wrap(pressure, self.state_at_pressure(pressure))

    def wrap_for_radius(self, radius: float) -> Wrap:
        """Return the perfect wrap of a cylinder of this radius [m].

        Raises:
            InvalidInputError: the radius is not positive and finite.
            NotGrippableError: it is outside [``radius_min``, ``radius_max``]; names the nearest
            that is not.
            SolverError: a shape could not be certified.
        """
        require_positive("radius", radius)
        if radius > self.radius_max:
            raise NotGrippableError(
                radius,
                f"too thick for {self.gripper.turns_required:g} turns of this length",
                self.radius_max - radius,
                self.radius_max,
            )
        if radius < self.radius_min:
            raise NotGrippableError(
                radius,
                f"too thin for the pressure limit of {self.pressure_max:.6g} Pa",
                radius - self.radius_min,
                self.radius_min,
            )
        return self._search(radius)

    def pressure_from_radius(self, radius: float) -> float:
        """Return the pressure [Pa] that wraps a radius [m]; raises as :meth:`wrap_for_radius`."""
        return self.wrap_for_radius(radius).pressure

    def radius_from_pressure(self, pressure: float) -> float:
        """Return the radius [m] that a pressure [Pa] of the coiled branch wraps perfectly.

        Raises:
            InvalidInputError: the pressure is not in [``pressure_min``, ``pressure_max``].
        """
        require_in_range("pressure", pressure, self.pressure_min, self.pressure_max)
        return self.wrap_at_pressure(pressure).object_radius

    def regime(self, pressure: float, radius: float) -> WrapRegime:
        """Return how a pressure [Pa] holds an object of a grippable radius [m].

        Raises:
            InvalidInputError: the pressure is not in [0, the gripper's ``pressure_max``].
            NotGrippableError: the radius is outside the grippable range.
        """
        require_in_range("pressure", pressure, 0.0, self.gripper.pressure_max)
        perfect = self.wrap_for_radius(radius).pressure
        if pressure < self.pressure_min:
            return WrapRegime.OVERHANG
        fits = self.wrap_at_pressure(pressure).object_radius
        if abs(fits - radius) <= PERFECT_BAND * radius:
            return WrapRegime.PERFECT_WRAP
        return WrapRegime.OVERHANG if pressure < perfect else WrapRegime.CURLING

    def _solve(self, shape: RestShape, start: RodState | None) -> RodState:
        """Return the certified state of one unloaded shape."""
        return solve_rod(
            self.gripper.rod(shape),
            self.gripper.load(shape),
            elements=self._elements,
            start=start,
            estimate_error=False,
        )

    def _sweep(self) -> tuple[RodState, ...]:
        """Return the states at the sampled pressures, along one path."""
        shapes = [self.gripper.rest_shape(float(pressure)) for pressure in self._pressures]
        rods = [self.gripper.rod(shape) for shape in shapes]
        loads = [self.gripper.load(shape) for shape in shapes]
        return follow_path(rods, loads, elements=self._elements).states

    def _axis(self, shape: RestShape, state: RodState) -> Vector:
        """Return the object's axis for a state: the gripper's, or the one that fits the coil."""
        turn_length = 2.0 * math.pi / math.hypot(shape.curvature, shape.torsion)
        return coil_axis(state, self.gripper.object_axis, turn_length)

    def _radius(self, shape: RestShape, angle: float) -> float:
        """Return r_w [m] for the angle between the tip's tangent and the axis [rad]."""
        return math.sin(angle) ** 2 / shape.curvature - self.gripper.tube.outer_radius

    def _wrap(self, pressure: float, state: RodState) -> Wrap:
        """Return the coil of a state, and what it wraps."""
        shape = self.gripper.rest_shape(pressure)
        coil = coil_from_state(state, self._axis(shape, state))
        return Wrap(
            pressure=float(pressure),
            object_radius=self._radius(shape, coil.tip_angle),
            turns=coil.total_turns,
            tip_angle=coil.tip_angle,
            free_length_needed=coil.length_for_turns(self.gripper.turns_required),
            object_length_needed=coil.advance_for_turns(self.gripper.turns_required),
            contact_length=shape.backbone_length,
            rest_shape=shape,
            coil=coil,
            state=state,
        )

    def _last_on_branch(self, samples: list[Wrap]) -> int:
        """Return the highest sampled pressure, as an index, that wraps any object at all."""
        most = max(samples, key=lambda s: s.turns)
        for i in reversed(range(len(samples))):
            if samples[i].turns >= self.gripper.turns_required and samples[i].object_radius > 0.0:
                return i
        raise NoCoilError(most.turns, self.gripper.turns_required, most.pressure)

    def _first_on_branch(self, samples: list[Wrap], last: int) -> int:
        """Return the index of the lowest sampled pressure of the branch that ends at ``last``."""
        first = last
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
            below.turns >= self.gripper.turns_required and below.object_radius > above.object_radius
        )

    def _branch_start(self, samples: list[Wrap], first: int) -> Wrap:
        """Return the wrap where the coiled branch begins, below its first sample.

        It is where the largest object is wrapped or, if that comes later, where the turns suffice.
        """
        on = samples[first]
        if on.state.folds:
            return on
        below = samples[first - 1].pressure if first > 0 else END_TOLERANCE * on.pressure
        if first == 0 or samples[first - 1].object_radius < on.object_radius:
            above = samples[min(first + 1, len(samples) - 1)].pressure
            largest = minimum(
                lambda pressure: -self.wrap_at_pressure(pressure).object_radius, below, above
            )
            below = min(largest, on.pressure)
            peak = self.wrap_at_pressure(largest)
            if self._holds(peak):
                return peak
        return self._bisect(on, below, self._holds)

    def _holds(self, wrap: Wrap) -> bool:
        """Return whether a wrap makes the turns required, without a snap on the way to it."""
        return wrap.state.folds == 0 and wrap.turns >= self.gripper.turns_required

    def _branch_end(self, samples: list[Wrap], last: int) -> Wrap:
        """Return the wrap at the branch's end: the limit, or where the coil closes on itself."""
        on = samples[last]
        if last == len(samples) - 1:
            return on
        least = LEAST_RADIUS * self.gripper.tube.outer_radius
        return self._bisect(on, samples[last + 1].pressure, lambda wrap: wrap.object_radius > least)

    def _bisect(self, on: Wrap, off: float, holds: Callable[[Wrap], bool]) -> Wrap:
        """Return the last wrap between ``on`` and pressure ``off`` for which a condition holds."""
        while abs(on.pressure - off) > END_TOLERANCE * self.gripper.pressure_max:
            middle = 0.5 * (on.pressure + off)
            wrap = self._wrap(middle, self.state_at_pressure(middle))
            if holds(wrap):
                on = wrap
            else:
                off = middle
        return on

    def _contact_curvature(self, radius: float) -> float:
        """Return 1/(r_w + r_o) [1/m]: almost linear in the pressure."""
        return 1.0 / (radius + self.gripper.tube.outer_radius)

    def _search(self, radius: float) -> Wrap:
        """Return the wrap of a radius in range: a secant search that never leaves its bracket."""
        target = self._contact_curvature(radius)
        low, high, pressure, slope = self._first_guess(target)
        start = self._nearest_state(pressure)
        last, miss = pressure, math.inf
        for _ in range(SEARCH_LIMIT):
            shape = self.gripper.rest_shape(pressure)
            state = self._solve(shape, start)
            fits = self._radius(shape, tip_angle(state, self._axis(shape, state)))
            previous, miss = miss, self._contact_curvature(fits) - target
            if abs(fits - radius) <= RADIUS_TOLERANCE * radius:
                return self._wrap(pressure, state)
            low, high = (pressure, high) if miss < 0.0 else (low, pressure)
            if math.isfinite(previous) and miss != previous:
                slope = (miss - previous) / (pressure - last)
            last, proposal = pressure, pressure - miss / slope
            pressure = proposal if low < proposal < high else 0.5 * (low + high)
        raise SolverError(RodStatus.ITERATION_LIMIT, abs(miss) / target, SEARCH_LIMIT)

    def _first_guess(self, target: float) -> tuple[float, float, float, float]:
        """Return bracket, pressure and slope for a contact curvature: a cubic through samples."""
        curvatures, pressures = self._branch_curvatures, self._branch_pressures
        i = min(max(int(np.searchsorted(curvatures, target)), 1), len(curvatures) - 1)
        first = min(max(i - 2, 0), max(len(curvatures) - 4, 0))
        low, high = float(pressures[i - 1]), float(pressures[i])
        x = (curvatures[first : first + 4] - target).tolist()
        p = pressures[first : first + 4].tolist()
        # Neville's scheme for p(x) at x = 0 and, alongside, its derivative.
        d = [0.0] * len(p)
        for width in range(1, len(p)):
            for k in range(len(p) - width):
                gap = x[k + width] - x[k]
                d[k] = (p[k + 1] - p[k] + x[k + width] * d[k] - x[k] * d[k + 1]) / gap
                p[k] = (x[k + width] * p[k] - x[k] * p[k + 1]) / gap
        straight = (high - low) / float(curvatures[i] - curvatures[i - 1])
        guess = (
            p[0] if low <= p[0] <= high else low + straight * (target - float(curvatures[i - 1]))
        )
        return low, high, guess, 1.0 / (d[0] if d[0] > 0.0 else straight)

    def _nearest_state(self, pressure: float) -> RodState:
        """Return the solved state at the pressure nearest to this one."""
        return self._states[int(np.argmin(np.abs(self._pressures - pressure)))]


def _sample_pressures(gripper: Gripper) -> Array:
    """Return the pressures to solve once: even steps of strain, until no object fits inside.

    The helix decides where that is, with room to spare for what gravity adds.
    """
    fine = np.linspace(0.0, gripper.pressure_max, TABLE + 1)[1:]
    shapes = [gripper.rest_shape(float(p)) for p in fine]
    strains = np.array([math.hypot(s.curvature, s.torsion) for s in shapes])
    radii = np.array([s.curvature for s in shapes]) / strains**2
    closed = np.nonzero(radii < CLOSED_RATIO * gripper.tube.outer_radius)[0]
    end = int(closed[0]) + 1 if closed.size else TABLE
    turn = float(strains[end - 1]) * shapes[end - 1].backbone_length
    samples = max(FEWEST_SAMPLES, math.ceil(turn / SAMPLE_TURN))
    levels = np.linspace(0.0, strains[end - 1], samples + 1)[1:]
    table = np.maximum.accumulate(np.concatenate(([0.0], strains[:end])))
    pressures: Array = np.interp(levels, table, np.concatenate(([0.0], fine[:end])))
    return pressures


def line_force(
    stiffness: RodStiffness, shape: RestShape, radius: float, tip_angle: float, outer_radius: float
) -> float:
    r"""Return the force per length [N/m] of a uniform coil on a cylinder; negative lifts off.

    .. math:: q = [EI (\kappa - \kappa_c) \sin^2\theta + GJ (\tau - \tau_c) \sin\theta \cos\theta] /
    \rho^2,
        \quad \rho = r_w + r_o

    with :math:`\kappa_c = \sin^2\theta/\rho`, :math:`\tau_c = \pm\sin\theta\cos\theta/\rho` of the
    free shape's hand: the derivative of the energy per length by the radius (our derivation; the
    paper gives no force model). Zero at the perfect wrap of the unloaded helix.

    Args:
        stiffness: of the rod.
        shape: the unloaded shape at the pressure in question.
        radius: of the object [m].
        tip_angle: between tangent and axis on the object [rad].
        outer_radius: of the gripper's tube [m].
    """
    rho = radius + outer_radius
    sine, cosine = math.sin(tip_angle), abs(math.cos(tip_angle))
    torsion = abs(shape.torsion)
    bending = stiffness.bending * (shape.curvature - sine * sine / rho) * sine * sine
    twisting = stiffness.torsional * (torsion - sine * cosine / rho) * sine * cosine
    return (bending + twisting) / (rho * rho)
