# SPDX-License-Identifier: Apache-2.0
r"""Settling time of a gripper after a ramp of its pressure, or after a stop of its base.

A tube that moves along with a ramp or an arm has velocities v when that stops. Mode i then begins
with the amplitude

.. math:: A_i = \frac{\xi_i^T M v}{\omega_i\, \xi_i^T M \xi_i}

and decays as :class:`~spiral_core.rod.motion.swing.Swing` has it. These are small vibrations; what
touches an object stays where it is.
"""

from __future__ import annotations

import math

import numpy as np

from spiral_core.closing.close import SETTLED, inertia_of
from spiral_core.grip.point import GripPoint
from spiral_core.grip.setup import FREE_ELEMENTS, free_problem
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.rod.motion.frequencies import Modes, vibration_modes
from spiral_core.rod.motion.inertia import Damping
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Array
from spiral_core.validation import require_non_negative, require_positive
from spiral_core.wrap.gripper import Gripper

# Modes that are looked at: both planes of the three slowest vibrations.
MODES = 6
# Pressures on a ramp between which the tube's velocities are taken.
STATIONS = 5
TINY = 1e-300


def vibrations(gripper: Gripper, pressure: float, count: int = MODES) -> Modes:
    """Return the slowest vibrations of a free gripper at a pressure [Pa].

    Raises:
        InvalidInputError: the pressure is out of range, or the weight not known.
        SolverError: the tube has no certified shape there.
    """
    return vibration_modes(_free(gripper, pressure), inertia_of(gripper), count)


def settling_after_ramp(
    gripper: Gripper,
    pressure: float,
    rate: float,
    *,
    grip: GripPoint | None = None,
    damping: Damping | None = None,
) -> float:
    """Return how long a tube swings on after its pressure has risen from zero at a rate.

    The swing is as large as the fastest quarter of the ramp leaves it.

    Args:
        gripper: as it is mounted.
        pressure: where the ramp ends [Pa].
        rate: of the ramp [Pa/s], > 0.
        grip: at this pressure, on an object; None is the free tube.
        damping: None is that of a silicone tube in air.

    Returns:
        Until no node is faster than 2 % of the length per second [s]; 0 where none is; infinite
        where nothing damps it.

    Raises:
        InvalidInputError: a value is out of range, or the weight not known.
        SolverError: the tube has no certified shape at this pressure.
    """
    require_positive("rate", rate)
    count = FREE_ELEMENTS if grip is None else len(grip.state.positions) - 1
    states = [_free(gripper, 0.0, count)]
    for station in np.linspace(0.0, pressure, STATIONS)[1:]:
        states.append(_free(gripper, float(station), count, states[-1]))
    positions = np.array([state.positions for state in states])
    # a ramp from 0 to 0 has no parts that move
    parts = np.diff(positions, axis=0) * (rate * (STATIONS - 1) / max(pressure, TINY))
    closed = states[-1] if grip is None else grip.state
    return _settled(gripper, closed, parts, math.inf, damping)


def settling_after_move(
    gripper: Gripper, pressure: float, speed: float, *, damping: Damping | None = None
) -> float:
    """Return how long a tube swings on after its base has stopped from a speed.

    Args:
        gripper: as it is mounted.
        pressure: in the tube [Pa].
        speed: of the base before it stopped at once [m/s], >= 0, in whatever direction makes it
            longest.
        damping: None is that of a silicone tube in air.

    Returns:
        As :func:`settling_after_ramp`.

    Raises:
        InvalidInputError: a value is out of range, or the weight not known.
        SolverError: the tube has no certified shape at this pressure.
    """
    require_non_negative("speed", speed)
    state = _free(gripper, pressure)
    velocities = speed * np.repeat(np.eye(3)[:, None, :], len(state.positions), axis=1)
    return _settled(gripper, state, velocities, 2.0, damping)


def _free(
    gripper: Gripper,
    pressure: float,
    elements: int = FREE_ELEMENTS,
    start: RodState | None = None,
) -> RodState:
    """Return the tube's state at a pressure, without an object."""
    return solve_contact(free_problem(gripper, pressure), elements=elements, start=start)


def _settled(
    gripper: Gripper, state: RodState, velocities: Array, order: float, damping: Damping | None
) -> float:
    """Return the longest time of all modes.

    Args:
        gripper: as it is mounted.
        state: about which it swings.
        velocities: that it may have (k, n, 3) [m/s].
        order: of the norm over them: 2 where they may add up, infinite where they do not.
        damping: of the tube.
    """
    inertia = inertia_of(gripper)
    modes = vibration_modes(state, inertia, MODES)
    weights = inertia.mass * state.node_lengths[:, None]
    slow = SETTLED * float(state.arc_lengths[-1])
    longest = 0.0
    for shape, swing in zip(modes.shapes, modes.swings, strict=True):
        omega = 2.0 * math.pi * swing.frequency
        parts = np.sum(weights * shape * velocities, axis=(1, 2))
        speed = float(np.linalg.norm(parts, order) / np.sum(weights * shape * shape))
        if speed > slow:
            time = swing.settling_time(damping or Damping(), speed / omega, slow / omega)
            longest = max(longest, time)
    return longest
