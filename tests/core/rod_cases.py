# SPDX-License-Identifier: Apache-2.0
"""The free rods of the tests, and their images: mirrored, rolled about the tube, scaled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from spiral_core import Rod, RodLoad, RodProblem, Section

Array = np.ndarray
INNER_RADIUS = 4.7625e-3
OUTER_RADIUS = INNER_RADIUS + 0.794e-3
AREA = math.pi * (OUTER_RADIUS**2 - INNER_RADIUS**2)
SECOND_MOMENT = math.pi / 4.0 * (OUTER_RADIUS**4 - INNER_RADIUS**4)
WEIGHT = 950.0 * 9.80665 * AREA  # [N/m], of the paper's tube: 0.24


def gripper_rod(
    length=0.36,
    modulus=0.78e6,
    curvature=21.0,
    torsion=-13.5,
    gravity=(1.0, 0.0, 0.0),
    tip_force=(0.0, 0.0, 0.0),
    tip_moment=(0.0, 0.0, 0.0),
):
    """Return a rod of the paper's tube; ``gravity`` is in units of standard gravity."""
    rod = Rod(
        length,
        Section.inextensible(modulus * SECOND_MOMENT, modulus / 3.0 * 2.0 * SECOND_MOMENT),
        rest_strain=(torsion, 0.0, curvature),
    )
    x, y, z = (WEIGHT * g for g in gravity)
    return RodProblem(rod, RodLoad((x, y, z), tip_force, tip_moment))


def random_direction(rng):
    """Return a unit vector, all directions alike."""
    v = rng.normal(size=3)
    x, y, z = (v / np.linalg.norm(v)).tolist()
    return (x, y, z)


STRAIGHT = Rod(0.5, Section.inextensible(2.0e-4, 1.3e-4))
# A full stiffness: of a rod as soft in stretch as coils and bellows are.
BENDING = np.array(((3e-4, 2e-5, -1e-5), (2e-5, 2e-4, 3e-5), (-1e-5, 3e-5, 4e-4)))
STRETCH = np.array(((1.0, 0.05, -0.1), (0.05, 0.5, 0.04), (-0.1, 0.04, 0.8)))
BETWEEN = np.array(((8, 2, -3), (2, -3, 4), (-5, 2, 3))) * 1e-3
SIX = Section(np.block([[BENDING, BETWEEN], [BETWEEN.T, STRETCH]]))
# Twist and bending coupled as much as they may be, and two unlike bendings.
COUPLED = Section.inextensible(bending=6.0e-4, torsional=5.0e-4, sideways=2.0e-4, coupling=4.0e-4)
HELICAL = Rod(0.36, COUPLED, rest_strain=(-9.0, 0.0, 18.0))
VARIED_LOAD = RodLoad(
    lambda s: np.column_stack((0.2 + 0.3 * np.cos(8.0 * s), 0.3 * s, -0.2 + s * s)),
    tip_force=(0.01, -0.02, 0.015),
    tip_moment=(3e-4, 2e-4, -5e-4),
)
VARIED = Rod(
    0.36,
    Section.varying(
        lambda s: 0.0006 * (1.0 - 0.8 * s),
        lambda s: 0.0005 * (1.0 + s),
        sideways=lambda s: 0.0002 * (1.0 + 2.0 * s),
        coupling=lambda s: 0.0004 * np.cos(9.0 * s),
    ),
    rest_strain=lambda s: np.column_stack(
        (-9.0 + 12.0 * s, 4.0 * np.sin(7.0 * s), 18.0 - 20.0 * s)
    ),
)


# Two tubes, of other stiffness and rest strain.
TUBES = Rod(
    0.36,
    lambda s: np.where(s[:, None] < 0.131, (1.7e-4, 2.5e-4, 2.5e-4), (3.3e-3, 5e-3, 5e-3)),
    rest_strain=lambda s: np.where(s[:, None] < 0.131, (-13.5, 0.0, 21.0), (4.0, 0.0, -10.0)),
    breaks=(0.131,),
)


def round_rod(ratio):
    """Return a helix that resists torsion so many times as much as bending."""
    section = Section.inextensible(2.5e-4, ratio * 2.5e-4)
    return Rod(0.36, section, rest_strain=(-5.0, 0.0, 11.0))


RODS = {
    "upright": gripper_rod(gravity=(-1.0, 0.0, 0.0)),
    "straight": RodProblem(STRAIGHT, RodLoad((0.0, 0.02, -0.01), (1e-3, 2e-3, 0.0))),
    "soft in torsion": RodProblem(round_rod(0.1), RodLoad((0.1, 0.1, 0.0))),
    "tip force": gripper_rod(gravity=(0.0, 0.0, 0.0), tip_force=(0.03, -0.04, 0.05)),
    "tip moment": gripper_rod(tip_moment=(5e-4, 1e-3, -2.5e-4)),
    "weight and force": gripper_rod(
        length=0.5, gravity=(0.3, -0.8, 0.52), tip_force=(0.02, 0.01, 0.0)
    ),
    "coupled": RodProblem(HELICAL, RodLoad((0.07, 0.19, -0.12), (0.004, -0.006, 0.003))),
    "coupled, straight": RodProblem(
        Rod(0.36, COUPLED), RodLoad((0.24, 0.0, 0.0), (0.004, -0.006, 0.003))
    ),
    "varied": RodProblem(VARIED, VARIED_LOAD),
    "varied, evenly loaded": RodProblem(VARIED, RodLoad((0.1, 0.15, -0.1))),
    "two tubes": RodProblem(TUBES, RodLoad((0.24, 0.05, 0.0), (0.01, 0.0, 0.02))),
    "stretching": RodProblem(
        Rod(0.5, SIX, rest_strain=(2.0, 1.0, -4.0)),
        RodLoad((2e-3, 1e-3, -8e-3), (2e-3, 3e-3, -1e-3), (2e-4, -1e-4, 3e-4)),
    ),
}


def vectors_at(given, sites):
    """Return a profile's vectors (n, 3) at sites."""
    return given(sites) if callable(given) else np.tile(given, (len(sites), 1))


def profile(given):
    """Return a function of one place for what is constant or a function of places."""
    constant = None if callable(given) else np.array(given)
    return lambda s: given(np.array([s]))[0] if constant is None else constant


def cross_matrix(v):
    """Return the matrix of a -> v x a."""
    x, y, z = v
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


def stiffness_at(section, sites):
    """Return a section's matrices at sites, (n, 3, 3) or (n, 6, 6)."""
    given = section(sites) if callable(section) else np.tile(section.stiffness, (len(sites), 1, 1))
    if not callable(section) and np.ndim(section.stiffness) == 1:
        given = given[:, 0]
    return given[:, :, None] * np.eye(3) if given.ndim == 2 else given


@dataclass(frozen=True)
class Image:
    """Other base axes and units: places become ``scale`` times ``turn`` times places."""

    turn: Array
    scale: float = 1.0
    stiffer: float = 1.0
    varied: bool = False  # whether constants are functions

    @property
    def axial(self):
        """What strains and moments are turned by."""
        return np.linalg.det(self.turn) * self.turn

    def of(self, case):
        """Return the image of a rod, its stiffness times ``stiffer``, under the image of a load."""
        rod, load, a = case.rod, case.load, self.scale
        rest, weight = rod.rest_strain, load.distributed
        if self.varied:
            rest, weight = (partial(vectors_at, given) for given in (rest, weight))
        force = self.stiffer / a**2 * self.turn

        def vectors(given, by):
            if callable(given):
                return lambda s: vectors_at(given, s / a) @ by.T
            return tuple((by @ given).tolist())

        def section(sites):
            full = stiffness_at(rod.section, sites / a)
            both = np.zeros((6, 6))
            both[:3, :3], both[3:, 3:] = self.axial, self.turn / a
            both = both[: full.shape[1], : full.shape[1]]
            turned = self.stiffer * both @ full @ both.T
            return np.where(np.abs(turned) < 1e-14 * np.abs(full).max(), 0.0, turned)

        return RodProblem(
            Rod(
                a * rod.length,
                section
                if callable(rod.section) or self.varied
                else Section(section(np.zeros(1))[0]),
                rest_strain=vectors(rest, self.axial / a),
                breaks=tuple(a * at for at in rod.breaks),
            ),
            RodLoad(
                vectors(weight, force / a),
                vectors(load.tip_force, force),
                vectors(load.tip_moment, self.stiffer / a * self.axial),
            ),
        )


IMAGES = {
    "as functions": Image(np.eye(3), varied=True),
    "mirrored": Image(np.diag((1.0, 1.0, -1.0))),
    "rolled": Image(Rotation.from_rotvec((0.4, 0.0, 0.0)).as_matrix()),
    "rolled far": Image(Rotation.from_rotvec((2.9, 0.0, 0.0)).as_matrix()),
    "larger": Image(np.eye(3), scale=2.5, stiffer=12.0),
}
