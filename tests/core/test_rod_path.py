# SPDX-License-Identifier: Apache-2.0
"""Paths with folds, other equilibria, and batches: against single solves and each other."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.testing import assert_allclose, assert_array_equal

from spiral_core import Rod, RodLoad, RodProblem, Section, solve_rod
from spiral_core.rod.batch import solve_rods
from spiral_core.rod.equilibria import find_equilibria
from spiral_core.rod.path import follow_path, follow_rod

# Found among random rods: snaps once while its rest strain grows, between these two.
CLOSE = np.array(((-27.940276, 0.0, 40.295417), (-28.087614, 0.0, 40.484126)))
LOAD = RodLoad((-0.08335639541607781, -0.05046832983653, 0.21911074192840144))
STATIONS, COUNT = 41, 176


def followed(strains, start=None):
    """Return rods of these rest strains, and their path."""
    section = Section.inextensible(2.998307564873586e-4, 1.9988717099157243e-4)
    rods = [Rod(0.5, section, rest_strain=strain) for strain in strains]
    return rods, follow_path([(rod, LOAD) for rod in rods], elements=COUNT, start=start)


def test_a_fold_is_located_releases_energy_and_leaves_two_states():
    rods, path = followed(np.linspace(np.zeros(3), 1.2 * CLOSE[1], STATIONS))
    (fold,), last = path.events, path.states[-1]
    assert all(state.stable for state in path.states)
    assert fold.before.energy > fold.after.energy
    assert norm(fold.after.tip_position - fold.before.tip_position) > 0.005
    # The branch's last pivot is small where it ends, and the next one stands firm.
    assert fold.before.smallest_pivot < 0.2 * fold.after.smallest_pivot
    at = int(fold.position)
    behind = path.states[at + 1]
    assert sum(state.folds for state in path.states) == behind.folds == fold.after.folds == 1
    # Behind the fold the path goes on to the station.
    assert solve_rod(rods[at + 1], LOAD, elements=COUNT, start=behind).iterations == 0
    # The loading path passes the same fold; from its end nothing snaps.
    alone = solve_rod(rods[-1], LOAD, elements=COUNT)
    again = solve_rod(rods[-1], LOAD, start=alone)
    assert (alone.folds, again.folds) == (1, 0)
    assert last.energy == pytest.approx(alone.energy, rel=1e-6)
    # On the way back it holds on for longer: between the folds there are two stable states.
    down = follow_path([(rod, LOAD) for rod in rods[::-1]], elements=COUNT, start=last)
    assert all(STATIONS - 1 - other.position < fold.position for other in down.events)
    # Before both, it runs through the same states both ways.
    for one, other in zip(path.states[:20], down.states[:-21:-1], strict=True):
        assert_allclose(one.positions, other.positions, atol=1e-9)
    one, *others = find_equilibria(rods[at], LOAD, starts=24, elements=COUNT)
    assert others
    for other in others:
        assert one.stable
        assert one.energy <= other.energy
        assert np.abs(one.positions - other.positions).max() > 0.005
        one = other


def test_a_column_that_buckles_to_any_side_has_one_state():
    rod = Rod(0.4, Section.inextensible(3e-4, 2e-4))
    (state,) = find_equilibria(rod, RodLoad(tip_force=(-0.08, 0.0, 0.0)), starts=6)
    assert state.neutral_modes == 1


def test_a_fold_between_stations_close_together_is_left_too():
    """Right behind it the energy is so flat that the state there is all but in equilibrium."""
    ends, start = CLOSE, None
    for _ in range(2):
        _, path = followed(ends, start)
        (fold,) = path.events
        start = fold.before
        ends = ends[0] + (fold.position + np.array(((-1,), (1,))) / 512) * (ends[1] - ends[0])
        assert norm(fold.after.tip_position - start.tip_position) > 0.05
        assert start.energy > fold.after.energy
        assert path.states[-1].stable


def test_a_batch_is_its_rods_bit_by_bit_and_in_threads():
    rng, count = np.random.default_rng(3), 40  # more than a task's
    lengths = rng.uniform(0.15, 0.6, count)
    strains = rng.uniform((-15.0, 0.0, 5.0), (15.0, 0.0, 30.0), (count, 3))
    weights = rng.normal(0.0, 0.14, (count, 3))
    data = (lengths, 2.7e-4, 1.8e-4, strains, weights)
    batch = solve_rods(*data, elements=40)
    assert batch.stable.all()
    with ThreadPoolExecutor(2) as executor:
        threaded = solve_rods(*data, elements=40, executor=executor)
    section = Section.inextensible(2.7e-4, 1.8e-4)
    alone = [
        solve_rod(Rod(length, section, rest_strain=strain), RodLoad(weight), elements=40)
        for length, strain, weight in zip(lengths, strains, weights, strict=True)
    ]
    names = ["status", "positions", "orientations", "energy"]
    names += ["residual", "smallest_pivot", "iterations", "folds"]
    for field, name in zip(fields(batch), names, strict=True):
        many = getattr(batch, field.name)
        assert_array_equal(many, getattr(threaded, field.name))
        assert_array_equal(many, [getattr(state, name) for state in alone])


def test_a_rod_that_leaves_its_plane_has_not_snapped():
    """At a bifurcation it goes on, as the mixed element says: no event."""
    rod = Rod(0.36, Section.inextensible(2.7e-4, 1.8e-4), rest_strain=(0.0, 3.0, 0.0))
    angles = np.linspace(0.5 * np.pi, 2.95, 50)
    problems = [RodProblem(rod, RodLoad((0.6 * np.cos(a), 0.0, 0.6 * np.sin(a)))) for a in angles]
    path = follow_rod(problems, elements=60)
    assert path.events == ()
    assert abs(path.states[-1].tip_position[1]) > 0.01
