# SPDX-License-Identifier: Apache-2.0
"""Where a rod touches itself: the distance between elements, and what passes on the way.

Unloaded rods have the shape that their rest strain gives them: any curve can be asked for.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

from benchmarks.contact_paths import moved
from spiral_core import Rod, RodProblem, RodStatus, Section
from spiral_core.rod.contact.solve import follow_contact, solve_contact

pytestmark = pytest.mark.long

RADIUS = 0.01
SECTION = Section((1e-3, 1e-3, 1e-3))


def bent(length, rest_strain, radius=RADIUS):
    """Return an unloaded rod."""
    return RodProblem(Rod(length, SECTION, radius, rest_strain))


def brute_force(state):
    """Return the least distance of places on elements apart: all pairs of 21 points on each."""
    curve, sites = state.positions, state.arc_lengths
    points = curve[:-1, None] + np.linspace(0.0, 1.0, 21)[:, None] * np.diff(curve, axis=0)[:, None]
    apart = sites[:-1] - sites[1:, None] > np.pi * RADIUS
    away = cdist(*2 * (points.reshape(-1, 3),))[np.kron(apart, np.ones((21, 21), dtype=bool))]
    nodes = cdist(curve, curve)[np.abs(sites[:, None] - sites) > np.pi * RADIUS]
    return np.concatenate((away, nodes)).min(initial=np.inf)


def wavering(seed, turns):
    """Return a coil of 5 cm radius whose rest strain wavers."""
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, 3)

    def strain(s):
        waves = np.sin(2.0 * np.pi * np.outer(s, (7.0, 5.0, 3.0)) + phase)
        return (1.5 - 0.12 * seed, 0.0, 20.0) + 0.3 * waves

    return bent(0.1 * np.pi * turns, strain)


# Four turns at 2.04 radii.
TIGHT = bent(8.0 * np.pi / math.hypot(2.04, 25.0), (2.04, 0.0, 25.0))
CURVES = [
    # Elements of 0.8 to 4 radii.
    *((wavering(*one), n) for one in enumerate((0.3, 3.0, 3.5, 4.0, 4.5)) for n in (40, 121)),
    # Neighbors do not touch: straight, and in an arc of at least two radii.
    *(
        (bent(11 * h * RADIUS, (0.0, 0.0, bend / h)), 11)
        for h in (0.05, 0.4, 1.6, 40.0)
        for bend in (0.0, 20.0)
    ),
    # Parallel elements, their nodes opposite or not.
    (TIGHT, 80),
    (TIGHT, 91),
]


@pytest.mark.parametrize(("problem", "elements"), CURVES)
def test_clearance_is_that_of_all_places_on_elements_apart(problem, elements):
    """What is far counts as two radii; a rod shorter than pi radii cannot touch itself.

    Points miss the nearest place by at most half of their distance h / 20 on both: its square
    adds at most h^2 / 800 to that of the least distance.
    """
    state = solve_contact(problem, elements=elements, throw=False)
    expected, clearance = brute_force(state), state.self_clearance
    found = clearance + 2.0 * RADIUS
    assert found <= expected + 1e-12
    missed = np.diff(state.arc_lengths).max() ** 2 / 800.0
    assert found >= min(math.sqrt(max(0.0, expected**2 - missed)), 4.0 * RADIUS)
    assert (clearance == math.inf) == (problem.rod.length < np.pi * RADIUS)
    assert (state.status is RodStatus.SELF_CONTACT) == (clearance < 0.0)
    thin = replace(problem, rod=replace(problem.rod, radius=0.0))
    assert solve_contact(thin, elements=elements).self_clearance == math.inf


@pytest.mark.parametrize("axis", np.eye(3).tolist())
def test_coil_that_turns_as_a_whole_does_not_cross_itself(axis):
    """Nodes move straight, which brings turns that nearly touch nearer by a tenth."""
    turned = moved(TIGHT, np.zeros(3), Rotation.from_rotvec(np.multiply(0.9, axis)))
    path = follow_contact([TIGHT, turned], elements=160)
    start, last = (state.self_clearance for state in path.states)
    assert path.self_contact is None
    assert 0.0 < start < 0.1 * RADIUS
    assert last == pytest.approx(start, abs=1e-9)


@pytest.mark.parametrize(
    ("radius", "elements", "stations", "place", "off"),
    [
        # Turns of one pitch touch where it is two radii: torsion / curvature^2 = radius / pi or so.
        (3e-3, 80, 5, 0.45, 0.05),
        # Thin ones are found at the end of the increment in which they passed.
        (1e-4, 120, 2, 0.5, 0.06),
    ],
)
def test_rod_that_passes_through_itself_between_two_stations_is_reported(
    radius, elements, stations, place, off
):
    """A coil whose pitch changes its sign: clear at both ends of the way, and between nodes."""
    pitches = np.linspace(30.0, -30.0, stations)
    coils = [bent(0.4, (torsion, 0.0, 60.0), radius) for torsion in pitches]
    path = follow_contact(coils, elements=elements)
    last = path.states[-1]
    assert last.self_clearance > 0.0
    assert last.status is RodStatus.SELF_CONTACT
    assert path.self_contact.position / (stations - 1) == pytest.approx(place, abs=off)
    assert np.diff(path.self_contact.places) == pytest.approx(2.0 * np.pi / 60.0, rel=0.15)
