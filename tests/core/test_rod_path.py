# SPDX-License-Identifier: Apache-2.0
"""Paths with folds, other equilibria, and batches: against single solves and each other."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from core.rod_cases import gripper_rod, random_direction
from numpy.linalg import norm
from numpy.testing import assert_allclose, assert_array_equal

from spiral_core import Rod, RodLoad, Section, solve_rod
from spiral_core.rod.batch import solve_rods
from spiral_core.rod.equilibria import find_equilibria
from spiral_core.rod.path import follow_path

# Found among random rods: snaps once while its rest strain grows.
SNAPPING = gripper_rod(
    length=0.55, modulus=1.244e6, curvature=38.94, torsion=6.46, gravity=(0.544, -0.393, -0.741)
)
STATIONS = 41
COUNT = 90


def ramp(case):
    """Return the rod with its rest strain growing from nothing."""
    shares = np.linspace(0.0, 1.0, STATIONS)[:, None]
    return [replace(case.rod, rest_strain=each) for each in shares * case.rod.rest_strain]


def test_a_fold_is_located_releases_energy_and_leaves_two_states():
    rods, load, near = ramp(SNAPPING), SNAPPING.load, 0.01 * SNAPPING.rod.length
    path = follow_path(rods, load, elements=COUNT)
    (fold,), last = path.events, path.states[-1]
    assert all(state.stable for state in path.states)
    assert fold.before.energy > fold.after.energy
    assert norm(fold.after.tip_position - fold.before.tip_position) > near
    # The branch's last pivot is small where it ends, and the next one stands firm.
    assert fold.before.smallest_pivot < 0.2 * fold.after.smallest_pivot
    at = int(fold.position)
    behind = path.states[at + 1]
    assert sum(state.folds for state in path.states) == behind.folds == fold.after.folds == 1
    # Behind the fold the path goes on to the station.
    assert solve_rod(rods[at + 1], load, elements=COUNT, start=behind).iterations == 0
    # The loading path passes the same fold; from its end nothing snaps.
    alone = solve_rod(rods[-1], load, elements=COUNT)
    assert alone.folds == 1
    assert last.energy == pytest.approx(alone.energy, rel=1e-6)
    assert solve_rod(rods[-1], load, start=alone).folds == 0
    # On the way back it holds on for longer: between the folds there are two stable states.
    down = follow_path(rods[::-1], load, elements=COUNT, start=last)
    assert all(STATIONS - 1 - other.position < fold.position for other in down.events)
    states = find_equilibria(rods[at], load, starts=24, elements=COUNT)
    assert len(states) >= 2
    for a, b in pairwise(states):
        assert a.stable
        assert a.energy <= b.energy
        assert np.abs(a.positions - b.positions).max() > 0.01 * near


def test_a_fold_between_stations_close_together_is_left_too():
    # Right behind the fold the energy is so flat that the state there is all but in equilibrium.
    load = RodLoad((-0.08335639541607781, -0.05046832983653, 0.21911074192840144))
    ends = np.array(((-27.940276, 0.0, 40.295417), (-28.087614, 0.0, 40.484126)))
    section = Section.inextensible(2.998307564873586e-4, 1.9988717099157243e-4)
    start = None
    for _ in range(2):
        rods = [Rod(0.5, section, rest_strain=strain) for strain in ends]
        path = follow_path(rods, load, elements=176, start=start)
        (fold,) = path.events
        start = fold.before
        near = fold.position + np.array(((-1.0,), (1.0,))) / 512.0
        ends = ends[0] + near * (ends[1] - ends[0])
        assert norm(fold.after.tip_position - start.tip_position) > 0.05
        assert start.energy > fold.after.energy
        assert path.states[-1].stable


def test_a_path_without_a_fold_runs_both_ways_through_the_same_states():
    rods, load = ramp(gripper_rod()), gripper_rod().load
    there = follow_path(rods, load, elements=40)
    home = follow_path(rods[::-1], load, elements=40, start=there.states[-1])
    assert there.events == home.events == ()
    for one, other in zip(there.states, home.states[::-1], strict=True):
        assert_allclose(one.positions, other.positions, atol=1e-9)


def test_a_batch_is_its_rods_bit_by_bit_and_in_threads():
    rng, count = np.random.default_rng(3), 40  # more than a task's
    lengths = rng.uniform(0.15, 0.6, count)
    strains = rng.uniform((-15.0, 0.0, 5.0), (15.0, 0.0, 30.0), (count, 3))
    weights = 0.24 * np.array([random_direction(rng) for _ in range(count)])
    data = (lengths, 2.7e-4, 1.8e-4, strains, weights)
    batch = solve_rods(*data, elements=40)
    assert batch.stable.all()
    with ThreadPoolExecutor(2) as executor:
        threaded = solve_rods(*data, elements=40, executor=executor)
    assert_array_equal(batch.positions, threaded.positions)
    section = Section.inextensible(2.7e-4, 1.8e-4)
    names = {
        "positions": "positions", "energies": "energy",
        "residuals": "residual", "smallest_pivots": "smallest_pivot", "iterations": "iterations",
        "folds": "folds", "statuses": "status",
    }  # fmt: skip
    for i in range(count):
        rod = Rod(float(lengths[i]), section, rest_strain=strains[i])
        state = solve_rod(rod, RodLoad(weights[i]), elements=40, estimate_error=False)
        for many, one in names.items():
            assert_array_equal(getattr(batch, many)[i], getattr(state, one))
