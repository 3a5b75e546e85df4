# SPDX-License-Identifier: Apache-2.0
"""Will it hold? The whole answer for one object: window, forces, and what to recommend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from spiral_core.errors import InvalidInputError, NotGrippableError
from spiral_core.grip.holding import HoldingForce, Pull, holding_force
from spiral_core.grip.point import GripPoint
from spiral_core.grip.refusal import not_held
from spiral_core.grip.setup import GripSetup
from spiral_core.grip.window import GripWindow, Progress, grip_window
from spiral_core.rod.types import Array
from spiral_core.validation import require_positive
from spiral_core.wrap.wrap import WrapRegime

# Pressures at which forces are looked for, from a little below the wrap to the last that holds.
FORCE_PRESSURES = 10
BELOW_WRAP = 0.95
# A recommended pressure keeps this fraction away from the loss of the grip.
LOSS_MARGIN = 0.1
# Payload is carried with this much force to spare, where nothing else is asked for.
PAYLOAD_SAFETY = 2.0


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Grip:
    """A gripper around an object: at which pressures it holds, and how much.

    Args:
        window: what the rising pressure does.
        points: the grip at each pressure looked at (m).
        forces: for each way of moving the object, what holds it at each pressure (m).
    """

    window: GripWindow
    points: tuple[GripPoint, ...]
    forces: Mapping[Pull, tuple[HoldingForce, ...]]

    def __repr__(self) -> str:
        best = ", ".join(f"{pull.name} {self.force(pull).max():.3g}" for pull in self.forces)
        return f"Grip({self.window!r}, largest forces [N, N m]: {best})"

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
        if pull not in self.forces:
            names = ", ".join(each.name for each in self.forces)
            raise InvalidInputError("pull", pull.name, f"one that was computed: {names}")
        return np.array([held.force for held in self.forces[pull]])

    @property
    def onset_wrap(self) -> float:
        """Lowest pressure at which the tip touches [Pa]."""
        if self.window.onset_wrap is None:
            raise not_held(self.window)
        return self.window.onset_wrap

    @property
    def recommended_range(self) -> tuple[float, float]:
        """Pressures that hold with the whole length and stay clear of the loss (low, high) [Pa].

        From the onset of the wrap to the onset of curling, or to a tenth below the loss if that is
        lower, or to where the tip lifts off again.
        """
        window, ends = self.window, [self.window.top]
        wrapped = [point for point in window.points if point.pressure >= self.onset_wrap]
        for before, point in pairwise(wrapped):
            if point.regime is WrapRegime.OVERHANG:
                ends.append(before.pressure)
                break
        if window.onset_curling is not None:
            ends.append(window.onset_curling)
        if window.loss is not None:
            ends.append((1.0 - LOSS_MARGIN) * window.loss)
        return self.onset_wrap, max(self.onset_wrap, min(ends))

    def recommended_pressure(
        self,
        payload: float | None = None,
        *,
        safety: float = PAYLOAD_SAFETY,
        force_max: float | None = None,
    ) -> float:
        """Return the pressure to command [Pa].

        Without conditions the middle of :attr:`recommended_range`. With a payload the lowest
        pressure that carries it, at or above the middle; with a greatest force the highest at or
        below the middle that stays under it.

        Args:
            payload: mass of the object [kg]; needs ``Pull.DOWN`` among the forces.
            safety: holding force over weight that is wanted, >= 1.
            force_max: greatest sum of normal forces on the object [N].

        Raises:
            InvalidInputError: a value is out of its range.
            NotGrippableError: no pressure of the window meets both.
        """
        low, high = self.recommended_range
        best = 0.5 * (low + high)
        end = high
        if self.window.loss is not None:
            end = max(high, (1.0 - LOSS_MARGIN) * self.window.loss)
        grid = np.linspace(low, end, 401)
        allowed = np.ones(grid.size, dtype=bool)
        if force_max is not None:
            require_positive("force_max", force_max)
            normal = np.interp(grid, self.window.pressures, self.window.normal_forces)
            allowed &= normal <= force_max
        if payload is not None:
            if not safety >= 1.0:
                raise InvalidInputError("safety", safety, "at least 1")
            held = np.interp(grid, self.pressures, self.payload_ratio(payload))
            allowed &= held >= safety
        if not allowed.any():
            raise self._refused(payload, safety, force_max)
        possible = grid[allowed]
        return float(possible[np.argmin(np.abs(possible - best))])

    def payload_ratio(self, payload: float) -> Array:
        """Return holding force along gravity over the object's weight at each pressure (m,).

        Args:
            payload: mass of the object [kg], > 0.

        Raises:
            InvalidInputError: it is not positive, or ``Pull.DOWN`` was not looked at.
        """
        gravity = float(np.linalg.norm(self.setup.gripper.gravity))
        ratio: Array = self.force(Pull.DOWN) / (require_positive("payload", payload) * gravity)
        return ratio

    def _refused(
        self, payload: float | None, safety: float, force_max: float | None
    ) -> NotGrippableError:
        """Return why no pressure meets the conditions."""
        radius = float(self.setup.obstacle.shape.feature_radius)
        if payload is None:
            least = float(
                np.interp(self.onset_wrap, self.window.pressures, self.window.normal_forces)
            )
            reason = (
                f"the perfect wrap presses with {least:.3g} N already, more than {force_max:.3g} N"
            )
            return NotGrippableError(radius, reason, float(force_max or 0.0) - least, None)
        gravity = float(np.linalg.norm(self.setup.gripper.gravity))
        most = float(self.force(Pull.DOWN).max())
        needed = safety * payload * gravity
        also = "" if force_max is None else f", or presses with more than {force_max:.3g} N"
        carried = most / (safety * gravity)
        reason = (
            f"no pressure holds {payload:.4g} kg {safety:.3g} times over{also}; at most "
            f"{carried:.3g} kg"
        )
        return NotGrippableError(radius, reason, most - needed, None)


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
        InvalidInputError: a pressure is outside of those that hold, or a pull is no Pull.
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
        raise not_held(window)
    if pressures is None:
        low = BELOW_WRAP * window.onset_wrap
        pressures = np.linspace(low, window.top, FORCE_PRESSURES).tolist()
    points: list[GripPoint] = []
    forces: dict[Pull, list[HoldingForce]] = {pull: [] for pull in pulls}
    total = len(pressures) * max(1, len(pulls))
    for number, pressure in enumerate(pressures):
        points.append(window.at(pressure))
        for count, pull in enumerate(pulls, start=1):
            forces[pull].append(holding_force(points[-1], pull))
            if progress is not None:
                progress(number * len(pulls) + count, total)
    held = {pull: tuple(found) for pull, found in forces.items()}
    return Grip(window, tuple(points), held)
