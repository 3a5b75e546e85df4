# SPDX-License-Identifier: Apache-2.0
"""The free rods of the tests, and their images: mirrored, rolled about the tube, scaled."""

from __future__ import annotations

import numpy as np
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from benchmarks.cases import random_direction, tube_case
from spiral_core import Rod, RodLoad, RodProblem, Section


def gripper_rod(
    length=0.36, modulus=0.78e6, curvature=21.0, torsion=-13.5, gravity=(1.0, 0.0, 0.0), **loads
):
    """Return a rod of the paper's tube; ``gravity`` is in units of standard gravity."""
    case = tube_case(length, modulus, (torsion, 0.0, curvature), gravity)
    return RodProblem(case.rod, RodLoad(np.array(case.load.distributed), **loads))


def drawn(rng, least, most, **given):
    """Return a rod of a curvature, length, modulus and torsion over curvature in these ranges."""
    curvature, length, modulus, ratio = rng.uniform(least, most)
    given = {"gravity": random_direction(rng)} | given
    return gripper_rod(length, modulus, curvature, ratio * curvature, **given)


STRAIGHT = Rod(0.5, Section.inextensible(2.0e-4, 1.3e-4))
# A full stiffness: of a rod as soft in stretch as coils and bellows are.
ROOTS, MIXED = (
    np.sqrt((3e-4, 2e-4, 4e-4, 1.0, 0.5, 0.8)),
    0.1 * np.sin(np.arange(36.0).reshape(6, 6)),
)
SIX = Section(np.outer(ROOTS, ROOTS) * (np.eye(6) + MIXED + MIXED.T))
# Twist and bending coupled as much as they may be, and two unlike bendings.
COUPLED = Section.inextensible(bending=6.0e-4, torsional=5.0e-4, sideways=2.0e-4, coupling=4.0e-4)
HELICAL = Rod(0.36, COUPLED, rest_strain=(-9.0, 0.0, 18.0))
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


def round_rod(ratio):
    """Return a helix that resists torsion so many times as much as bending."""
    section = Section.inextensible(2.5e-4, ratio * 2.5e-4)
    return Rod(0.36, section, rest_strain=(-5.0, 0.0, 11.0))


RODS = {
    "straight": RodProblem(STRAIGHT, RodLoad((0.0, 0.02, -0.01), (1e-3, 2e-3, 0.0))),
    "soft in torsion": RodProblem(round_rod(0.1), RodLoad((0.1, 0.1, 0.0))),
    "tip moment": gripper_rod(tip_moment=(5e-4, 1e-3, -2.5e-4)),
    "coupled": RodProblem(HELICAL, RodLoad((0.07, 0.19, -0.12), (0.004, -0.006, 0.003))),
    "coupled, straight": RodProblem(
        Rod(0.36, COUPLED), RodLoad((0.24, 0.0, 0.0), (0.004, -0.006, 0.003))
    ),
    "varied": RodProblem(
        VARIED,
        RodLoad(
            lambda s: np.column_stack((0.2 + 0.3 * np.cos(8.0 * s), 0.3 * s, -0.2 + s * s)),
            tip_force=(0.01, -0.02, 0.015),
            tip_moment=(3e-4, 2e-4, -5e-4),
        ),
    ),
    "varied, evenly loaded": RodProblem(VARIED, RodLoad((0.1, 0.15, -0.1))),
    # Of other stiffness and rest strain.
    "two tubes": RodProblem(
        Rod(
            0.36,
            lambda s: np.where(s[:, None] < 0.131, (1.7e-4, 2.5e-4, 2.5e-4), (3.3e-3, 5e-3, 5e-3)),
            rest_strain=lambda s: np.where(s[:, None] < 0.131, (-13.5, 0, 21), (4, 0, -10)),
            breaks=(0.131,),
        ),
        RodLoad((0.24, 0.05, 0.0), (0.01, 0.0, 0.02)),
    ),
    "stretching": RodProblem(
        Rod(0.5, SIX, rest_strain=(2.0, 1.0, -4.0)),
        RodLoad((2e-3, 1e-3, -8e-3), (2e-3, 3e-3, -1e-3), (2e-4, -1e-4, 3e-4)),
    ),
}


def vectors_at(given, sites):
    """Return a profile's vectors (n, 3) at sites."""
    return given(sites) if callable(given) else np.array([given] * len(sites))


def stiffness_at(section, sites):
    """Return a section's matrices at sites, (n, 3, 3) or (n, 6, 6)."""
    given = vectors_at(section if callable(section) else section.stiffness, sites)
    return given[:, :, None] * np.eye(3) if given.ndim == 2 else given


def image(problem, turn, size=1.0, varied=False):
    """Return a problem with its places turned and so many times as far, without functions in loads.

    Its stiffness is size^4 times as large against bending, and its forces are size^2. What is
    constant is so again, unless it is to be a function.
    """
    axial, rod, load = np.linalg.det(turn) * turn, problem.rod, problem.load

    def section(s):
        given = stiffness_at(rod.section, s / size)
        both = block_diag(size**2 * axial, size * turn)[: len(given[0]), : len(given[0])]
        return (both @ given @ both.T).round(18)

    def rest(s):
        return vectors_at(rod.rest_strain, s / size) @ axial.T / size

    if not (varied or callable(rod.section)):
        section, rest = Section(section(np.zeros(1))[0]), rest(np.zeros(1))[0]
    length, *breaks = size * np.array((rod.length, *rod.breaks))
    loads = size * turn, size**2 * turn, size**3 * axial
    given = load.distributed, load.tip_force, load.tip_moment
    return RodProblem(
        Rod(length, section, rod.radius, rest, breaks=(*breaks,)),
        RodLoad(*map(np.matmul, loads, given)),
    )


IMAGES = {
    "as functions": (np.eye(3), 1.0, True),
    "mirrored and larger": (np.diag((1.0, 1.0, -1.0)), 2.5),
    "rolled": (Rotation.from_rotvec((2.9, 0.0, 0.0)).as_matrix(),),
}
