"""Which pressure coils a gripper exactly onto which cylinder, over the whole grippable range."""

from __future__ import annotations

import math
from bisect import bisect_left

from spiral_core.actuator.interface import RestShape
from spiral_core.errors import NotGrippableError, SolverError
from spiral_core.rod._continuation import Settled
from spiral_core.rod._mesh import element_count
from spiral_core.rod._newton import CONVERGED
from spiral_core.rod._profiles import floats
from spiral_core.rod.path import follow_path
from spiral_core.rod.solve import STATUSES, even_arc_lengths, solve_rod, state_from_settled
from spiral_core.rod.types import Array, RodState, RodStatus, Vector
from spiral_core.validation import require_in_range, require_positive
from spiral_core.wrap._coil_kernels import FITTED
from spiral_core.wrap._wrap_kernel import settle_on_object
from spiral_core.wrap.branch import BranchFinder, sample_pressures
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.table import WrapTable
from spiral_core.wrap.wrap import PERFECT_BAND, Wrap, WrapRegime, wrapped_radius

# Largest angle that an element turns by, at the tightest coil [rad]: the wrapped radius is then
# right to about 1e-6 of itself.
ELEMENT_ANGLE = 0.4
# Relative error of the radius at which the search for its pressure ends.
RADIUS_TOLERANCE = 1e-9
SEARCH_LIMIT = 60


class WrapCurve:
    """Pressure against object radius for one gripper as it is mounted.

    The whole range is solved once; every question after that is a short warm start from the solved
    pressures next to it, so that answers do not depend on the order of the questions.

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
        self._pressures: list[float] = sample_pressures(gripper).tolist()
        top = gripper.rest_shape(self._pressures[-1])
        self._elements = element_count(gripper.rod(top), gripper.load(top), ELEMENT_ANGLE)
        self._states = self._sweep()
        samples = [self._wrap(p, s) for p, s in zip(self._pressures, self._states, strict=True)]
        branch = BranchFinder(gripper, samples, self.wrap_at_pressure).branch()
        low, high = branch[0], branch[-1]
        self.pressure_min, self.pressure_max = low.pressure, high.pressure
        self.radius_min, self.radius_max = high.object_radius, low.object_radius
        self._table = WrapTable(branch, gripper.tube.outer_radius)

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
        self._require_grippable(radius)
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

    def regime(self, pressure: float, radius: float, state: RodState | None = None) -> WrapRegime:
        """Return how a pressure [Pa] holds an object of a grippable radius [m].

        Args:
            pressure: gauge pressure [Pa].
            radius: of the object [m].
            state: :meth:`state_at_pressure`, where it is known already.

        Raises:
            InvalidInputError: the pressure is not in [0, the gripper's ``pressure_max``], or the
                radius not positive and finite.
            NotGrippableError: the radius is outside the grippable range.
            SolverError: the shape could not be certified.
        """
        require_in_range("pressure", pressure, 0.0, self.gripper.pressure_max)
        self._require_grippable(radius)
        if pressure < self.pressure_min:
            return WrapRegime.OVERHANG
        shape = self.gripper.rest_shape(pressure)
        if state is None:
            state = self._solve(shape, self._nearest_state(pressure))
        fits, _ = wrapped_radius(self.gripper, shape, state)
        if abs(fits - radius) <= PERFECT_BAND * radius:
            return WrapRegime.PERFECT_WRAP
        # The radius falls with pressure: a coil that is too wide has too little of it.
        return WrapRegime.OVERHANG if fits > radius else WrapRegime.CURLING

    def _require_grippable(self, radius: float) -> None:
        """Raise if no pressure wraps a radius [m]."""
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

    def _solve(self, shape: RestShape, start: RodState) -> RodState:
        """Return the certified state of one unloaded shape."""
        return solve_rod(
            self.gripper.rod(shape),
            self.gripper.load(shape),
            elements=self._elements,
            start=start,
            estimate_error=False,
        )

    def _sweep(self) -> list[RodState]:
        """Return the states at the sampled pressures, along one path."""
        shapes = [self.gripper.rest_shape(pressure) for pressure in self._pressures]
        rods = [self.gripper.rod(shape) for shape in shapes]
        loads = [self.gripper.load(shape) for shape in shapes]
        return list(follow_path(rods, loads, elements=self._elements).states)

    def _wrap(self, pressure: float, state: RodState) -> Wrap:
        """Return what the gripper wraps in the state at a pressure [Pa]."""
        shape = self.gripper.rest_shape(pressure)
        radius, axis = wrapped_radius(self.gripper, shape, state)
        return Wrap(float(pressure), radius, shape, state, axis, self.gripper.turns_required)

    def _search(self, radius: float) -> Wrap:
        """Return the wrap of a radius in range: a secant search that never leaves its bracket."""
        target = self._table.contact_curvature(radius)
        low, high, pressure, slope = self._table.bracket_and_guess(target)
        q = self._table.orientations(target)
        last, miss = pressure, math.inf
        for _ in range(SEARCH_LIMIT):
            shape = self.gripper.rest_shape(pressure)
            settled, fits, axis = self._settle(shape, q)
            previous, miss = miss, self._table.contact_curvature(fits) - target
            if abs(fits - radius) <= RADIUS_TOLERANCE * radius:
                arcs = even_arc_lengths(shape.backbone_length, self._elements)
                state = state_from_settled(arcs, q, settled)
                return Wrap(pressure, fits, shape, state, axis, self.gripper.turns_required)
            low, high = (pressure, high) if miss < 0.0 else (low, pressure)
            if math.isfinite(previous) and miss != previous:
                slope = (miss - previous) / (pressure - last)
            last, proposal = pressure, pressure - miss / slope
            pressure = proposal if low < proposal < high else 0.5 * (low + high)
        raise SolverError(RodStatus.ITERATION_LIMIT, abs(miss) / target, SEARCH_LIMIT)

    def _settle(self, shape: RestShape, q: Array) -> tuple[Settled, float, Vector]:
        """Settle q, in place, into the certified state of an unloaded shape, and what it fits."""
        gripper = self.gripper
        settled, fits, axis = settle_on_object(
            q,
            float(shape.backbone_length),
            float(gripper.stiffness.torsional),
            float(gripper.stiffness.bending),
            floats((shape.torsion, 0.0, shape.curvature)),
            gripper.weight(shape),
            FITTED if gripper.object_axis is None else floats(gripper.object_axis),
            float(gripper.tube.outer_radius),
        )
        found = settled.solution
        if found.outcome != CONVERGED:
            raise SolverError(STATUSES[found.outcome], found.residual, found.iterations)
        return settled, fits, axis

    def _nearest_state(self, pressure: float) -> RodState:
        """Return the solved state at the pressure nearest to this one."""
        pressures = self._pressures
        above = bisect_left(pressures, pressure)
        if above == 0:
            return self._states[0]
        if above == len(pressures):
            return self._states[-1]
        nearer = pressures[above] - pressure < pressure - pressures[above - 1]
        return self._states[above if nearer else above - 1]
