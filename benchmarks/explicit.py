# SPDX-License-Identifier: Apache-2.0
"""An independent method for friction: explicit, heavily damped motion of a coil on a cylinder.

Nothing of ``spiral_core`` is used, and nothing is discretized as there: places at nodes, frames at
elements, springs for stretch, shear, bending and contact, and Coulomb friction by springs that
slide (Cundall and Strack, 1979) at the points where the surface touches, whose velocity includes
the spin of the section and whose force has a couple about its axis. Masses are arbitrary where the
pull is so slow that the drag is a thousandth of what is measured; with those of a tube it is the
tube in time. Errors: 1.5 % of the stiffness of contact, 1 % of the elements.
"""

# ruff: noqa: ANN001, ANN202 (compiled kernels)
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
# Of stretch and shear [N], and of a node's contact [N/m]; friction's springs have half of it.
AXIAL, CONTACT = 400.0, 4e4
DAMPING_RATIO = 60.0  # of the lowest frequency of the free rod
CONTACT_DAMPING = 0.5
STEP = 0.5  # of the shortest period, over 2 pi


@dataclass
class Coil:
    """A coil clamped at the origin along x, lying on a cylinder that moves along its axis.

    Args:
        length: [m].
        stiffness: GJ, EI, EI [N m^2].
        radius: of the tube [m].
        cylinder: the cylinder's radius [m].
        fits: strain at which the helix just fits the cylinder, where it starts [1/m].
        lever: distance from the tube's axis at which friction acts [m].
        elements: how many.
        mass: per length [kg/m]; None is 1 kg for each node, heavily damped.
        rotary: per length, about every axis [kg m]; with a mass only.
        damping: rate at which speeds and spins decay [1/s]; with a mass only.
    """

    length: float
    stiffness: Array
    radius: float
    cylinder: float
    fits: Array
    lever: float
    elements: int = 60
    friction: float = 0.0
    mass: float | None = None
    rotary: float = 0.0
    damping: float = 0.0
    strain: Array = field(init=False)

    def __post_init__(self) -> None:
        count, h = self.elements, self.length / self.elements
        self.strain = self.fits
        middles = (np.arange(count) + 0.5)[:, None] * h * self.fits
        self.frames = Rotation.from_rotvec(middles).as_matrix()
        self.places = np.vstack((np.zeros(3), np.cumsum(h * self.frames[:, :, 0], axis=0)))
        self.slips, self.speeds = np.zeros((count + 1, 3)), np.zeros((count + 1, 3))
        self.spins = np.zeros((count, 3))
        self.axis = self.fits / np.linalg.norm(self.fits)
        self.center = np.array((0.0, self.cylinder + self.radius, 0.0))
        self.node, self.inertia = 1.0, h**2 / 4.0
        if self.mass is None:
            slowest = 3.52 * math.sqrt(self.stiffness[1] * h) / self.length**2
            self.damping = DAMPING_RATIO * slowest
        else:
            self.node, self.inertia = self.mass * h, self.rotary * h
        turning = (AXIAL * h + 4.0 * self.stiffness[1] / h) / self.inertia
        fastest = max(4.0 * AXIAL / h / self.node, turning, 4.0 * CONTACT / self.node)
        self.step = STEP / math.sqrt(fastest)

    def straighten(self) -> None:
        """Lay the rod straight along x, at rest and without rest strain."""
        count = self.elements
        self.frames = np.tile(np.eye(3), (count, 1, 1))
        self.places = np.zeros((count + 1, 3))
        self.places[:, 0] = np.linspace(0.0, self.length, count + 1)
        self.strain = np.zeros(3)

    def touching(self) -> float:
        """Return the part of the nodes, without the base, that touch the cylinder."""
        away = self.places[1:] - self.center
        away -= np.outer(away @ self.axis, self.axis)
        reach = self.cylinder + self.radius
        return float(np.mean(np.linalg.norm(away, axis=1) < reach))

    def go(self, steps: int, strain: Array | None = None, move: float = 0.0) -> tuple[float, float]:
        """Advance while the strain and the cylinder change; return axial and normal force [N].

        The axial force is the cylinder's part, along the axis; a mean over the last steps.
        """
        target = self.strain if strain is None else strain
        speed = self.axis * (move / (steps * self.step))
        forces = np.zeros(2)
        self.center = _advance(
            steps, self.step, self.length / self.elements, self.damping, self.node, self.inertia,
            self.stiffness, self.strain, target, self.places, self.speeds, self.frames,
            self.spins, self.slips, self.center, speed, self.axis, self.cylinder + self.radius,
            self.lever, self.friction, forces,
        )  # fmt: skip
        self.strain = target
        return float(forces[0]), float(forces[1])


@njit(cache=True)
def _cross(a: Array, b: Array, out: Array) -> None:
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@njit(cache=True)
def _dot(a: Array, b: Array) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def _column_product(a: Array, p: int, b: Array, q: int) -> float:
    return a[0, p] * b[0, q] + a[1, p] * b[1, q] + a[2, p] * b[2, q]


@njit(cache=True)
def _turned(frame: Array, v: Array, out: Array) -> None:
    for k in range(3):
        out[k] = frame[k, 0] * v[0] + frame[k, 1] * v[1] + frame[k, 2] * v[2]


@njit(cache=True)
def _add(out: Array, factor: float, v: Array) -> None:
    for k in range(3):
        out[k] += factor * v[k]


@njit(cache=True)
def _scale(out: Array, factor: float) -> None:
    for k in range(3):
        out[k] *= factor


@njit(cache=True)
def _bend(frames, j, h, stiffness, strain, room, moment):
    """Write the moment (base frame) between elements j - 1 and j: from the energy's derivative."""
    turn, w, m, a, b = room[:3], room[3], room[4], room[5], room[6]
    for p in range(3):
        for q in range(3):
            turn[p, q] = frames[0, p, q]
            if j > 0:
                turn[p, q] = _column_product(frames[j - 1], p, frames[j], q)
    cos = min(1.0, max(-1.0, 0.5 * (turn[0, 0] + turn[1, 1] + turn[2, 2] - 1.0)))
    w[0] = 0.5 * (turn[2, 1] - turn[1, 2])
    w[1] = 0.5 * (turn[0, 2] - turn[2, 0])
    w[2] = 0.5 * (turn[1, 0] - turn[0, 1])
    sin = math.sqrt(w[0] ** 2 + w[1] ** 2 + w[2] ** 2)
    angle = math.atan2(sin, cos)
    if sin > 1e-9:
        for k in range(3):
            w[k] *= angle / sin
    piece = h if j > 0 else 0.5 * h
    for k in range(3):
        m[k] = stiffness[k] * (w[k] / piece - strain[k])
    second = 1.0 / 12.0
    if angle > 1e-3:
        second = 1.0 / angle**2 - (1.0 + cos) / (2.0 * angle * math.sin(angle))
    _cross(w, m, a)
    _cross(w, a, b)
    for k in range(3):
        m[k] += second * b[k] - 0.5 * a[k]
    _turned(frames[j], m, moment)


@njit(cache=True)
def _elastic(places, frames, h, stiffness, strain, room, forces, torques, moments):
    """Write what stretch, shear, bending and twist do to nodes and elements."""
    count = len(frames)
    forces[:], torques[:] = 0.0, 0.0
    for j in range(count):
        _bend(frames, j, h, stiffness, strain, room, moments[j])
    chord, local, pull, couple = room[3], room[4], room[5], room[6]
    for j in range(count):
        frame = frames[j]
        for k in range(3):
            chord[k] = places[j + 1, k] - places[j, k]
        for k in range(3):
            along = frame[0, k] * chord[0] + frame[1, k] * chord[1] + frame[2, k] * chord[2]
            local[k] = AXIAL * (along / h - (1.0 if k == 0 else 0.0))
        _turned(frame, local, pull)
        _cross(chord, pull, couple)
        for k in range(3):
            forces[j, k] += pull[k]
            forces[j + 1, k] -= pull[k]
            torques[j, k] += couple[k] - moments[j, k]
            if j > 0:
                torques[j - 1, k] += moments[j, k]


@njit(cache=True)
def _touch(
    i,
    step,
    mass,
    places,
    speeds,
    spins,
    slips,
    center,
    speed,
    axis,
    reach,
    lever,
    friction,
    room,
    forces,
    torques,
):
    """Add contact and friction at node i; return axial force on the cylinder and normal force."""
    count = len(torques)
    low, high = i - 1, min(i, count - 1)
    normal, spin, moved, push, couple = room[0], room[1], room[2], room[3], room[4]
    for k in range(3):
        normal[k] = places[i, k] - center[k]
    _add(normal, -_dot(normal, axis), axis)
    distance = math.sqrt(_dot(normal, normal))
    if distance >= reach:
        slips[i] = 0.0
        return 0.0, 0.0
    _scale(normal, 1.0 / distance)
    share = 1.0 if i < count else 0.5
    for k in range(3):
        spin[k] = 0.5 * (spins[low, k] + spins[high, k])
    _cross(spin, normal, couple)
    for k in range(3):
        moved[k] = speeds[i, k] - lever * couple[k] - speed[k]
    inward = _dot(moved, normal)
    resisted = CONTACT_DAMPING * math.sqrt(CONTACT * mass)
    pressed = CONTACT * share * (reach - distance) - resisted * inward
    pressed = max(0.0, pressed)
    slip = slips[i]
    _add(moved, -inward, normal)
    _add(slip, step, moved)
    _add(slip, -_dot(slip, normal), normal)
    spring = 0.5 * CONTACT * share
    size = math.sqrt(_dot(slip, slip))
    if spring * size > friction * pressed:
        _scale(slip, friction * pressed / (spring * size))
    for k in range(3):
        push[k] = -spring * slip[k] - math.sqrt(0.5) * resisted * moved[k]
    size = math.sqrt(_dot(push, push))
    if size > friction * pressed:
        _scale(push, friction * pressed / size)
    _cross(normal, push, couple)
    _add(torques[low], -0.5 * lever, couple)
    _add(torques[high], -0.5 * lever, couple)
    _add(push, pressed, normal)
    _add(forces[i], 1.0, push)
    return -_dot(push, axis), pressed


@njit(cache=True)
def _move(step, kept, node, inertia, places, speeds, frames, spins, forces, torques, room):
    """Move nodes and turn elements by a step; the first node is held."""
    count = len(frames)
    for i in range(1, count + 1):
        mass = node if i < count else 0.5 * node
        for k in range(3):
            speeds[i, k] = (speeds[i, k] + step * forces[i, k] / mass) * kept
            places[i, k] += step * speeds[i, k]
    turn, axis, once, twice = room[3], room[4], room[5], room[6]
    for j in range(count):
        for k in range(3):
            spins[j, k] = (spins[j, k] + step * torques[j, k] / inertia) * kept
            turn[k] = step * spins[j, k]
        square = _dot(turn, turn)
        first, second = 1.0 - square / 6.0, 0.5 - square / 24.0
        for column in range(3):
            for k in range(3):
                axis[k] = frames[j, k, column]
            _cross(turn, axis, once)
            _cross(turn, once, twice)
            for k in range(3):
                frames[j, k, column] += first * once[k] + second * twice[k]


@njit(cache=True)
def _advance(
    steps,
    step,
    h,
    damping,
    node,
    inertia,
    stiffness,
    first,
    last,
    places,
    speeds,
    frames,
    spins,
    slips,
    center,
    speed,
    axis,
    reach,
    lever,
    friction,
    found,
):
    """Advance by explicit steps; write the mean forces of the last of them, return the center."""
    count = len(frames)
    forces, torques = np.zeros((count + 1, 3)), np.zeros((count, 3))
    moments, room = np.zeros((count, 3)), np.zeros((7, 3))
    kept = math.exp(-damping * step)
    measured = min(steps, 2000)
    strain, place = first.copy(), center.copy()
    for k in range(steps):
        for i in range(3):
            strain[i] = first[i] + (last[i] - first[i]) * ((k + 1.0) / steps)
            place[i] = center[i] + speed[i] * (step * (k + 1.0))
        _elastic(places, frames, h, stiffness, strain, room, forces, torques, moments)
        for i in range(1, count + 1):
            along, pressed = _touch(
                i, step, node, places, speeds, spins, slips, place, speed, axis, reach, lever,
                friction, room, forces, torques,
            )  # fmt: skip
            if k >= steps - measured:
                found[0] += along / measured
                found[1] += pressed / measured
        _move(step, kept, node, inertia, places, speeds, frames, spins, forces, torques, room)
        if k % 200 == 0:
            for j in range(count):  # rounding
                x, y = frames[j, :, 0].copy(), frames[j, :, 1].copy()
                x /= math.sqrt(_dot(x, x))
                y -= _dot(x, y) * x
                y /= math.sqrt(_dot(y, y))
                frames[j, :, 0], frames[j, :, 1] = x, y
                _cross(x, y, room[0])
                frames[j, :, 2] = room[0]
    return center + speed * (step * steps)
