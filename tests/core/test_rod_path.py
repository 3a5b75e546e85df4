# SPDX-License-Identifier: Apache-2.0
"""Paths with folds, other equilibria, and batches: against single solves and each other."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest
from core.rod_cases import Case, gripper_rod, random_direction

from spiral_core import Rod, RodLoad, Section, solve_rod
from spiral_core.rod.batch import solve_rods
from spiral_core.rod.equilibria import find_equilibria
from spiral_core.rod.path import RodEvent, follow_path

# Found among random rods: snaps once while its rest strain grows.
SNAPPING = gripper_rod(
    length=0.55, modulus=1.244e6, curvature=38.94, torsion=6.46, gravity=(0.544, -0.393, -0.741)
)
STATIONS = 41
COUNT = 90


def ramp(case: Case) -> list[Rod]:
    """Return the rod with its rest strain growing from nothing."""
    assert not callable(case.rod.rest_strain)
    tx, ty, tz = case.rod.rest_strain
    rod = case.rod
    return [
        Rod(
            rod.length,
            rod.section,
            rest_strain=(x * tx, x * ty, x * tz),
        )
        for x in np.linspace(0.0, 1.0, STATIONS).tolist()
    ]


def jump(fold: RodEvent) -> float:
    return float(np.linalg.norm(fold.after.tip_position - fold.before.tip_position))


def test_a_fold_is_located_and_releases_energy() -> None:
    path = follow_path(ramp(SNAPPING), SNAPPING.load, elements=COUNT)
    assert len(path.states) == STATIONS
    assert all(state.stable for state in path.states)
    assert len(path.events) == 1
    fold = path.events[0]
    assert 0.0 < fold.position < STATIONS - 1
    assert fold.before.energy > fold.after.energy
    assert jump(fold) > 0.01 * SNAPPING.rod.length
    # The branch's last pivot is small where it ends, and the next one stands firm.
    assert fold.before.smallest_pivot < 0.2 * fold.after.smallest_pivot
    assert [s.folds for s in path.states] == [
        1 if i == int(fold.position) + 1 else 0 for i in range(STATIONS)
    ]
    # The loading path passes the same fold; from its end nothing snaps.
    alone = solve_rod(SNAPPING.rod, SNAPPING.load, elements=COUNT)
    assert alone.folds == 1
    assert path.states[-1].energy == pytest.approx(alone.energy, rel=1e-6)
    assert solve_rod(SNAPPING.rod, SNAPPING.load, start=alone).folds == 0


@pytest.mark.parametrize("zooms", [1, 2])
def test_a_fold_between_stations_close_together_is_left_too(zooms: int) -> None:
    # Right behind the fold the energy is so flat that the state there is all but in equilibrium.
    load = RodLoad((-0.08335639541607781, -0.05046832983653, 0.21911074192840144))
    begin, end = np.array((-27.940276, 0.0, 40.295417)), np.array((-28.087614, 0.0, 40.484126))

    def rod(fraction: float) -> Rod:
        x, y, z = (begin + fraction * (end - begin)).tolist()
        return Rod(
            0.5,
            Section.inextensible(2.998307564873586e-4, 1.9988717099157243e-4),
            rest_strain=(x, y, z),
        )

    low, high, start = 0.0, 1.0, None
    for _ in range(zooms):
        path = follow_path([rod(low), rod(high)], load, elements=176, start=start)
        (fold,) = path.events
        start = fold.before
        low, high = (
            low + (fold.position - 1.0 / 512.0) * (high - low),
            low + (fold.position + 1.0 / 512.0) * (high - low),
        )
        assert jump(fold) > 0.05
        assert fold.before.energy > fold.after.energy
        assert path.states[-1].stable


def test_there_and_back_is_a_hysteresis() -> None:
    rods = ramp(SNAPPING)
    up = follow_path(rods, SNAPPING.load, elements=COUNT)
    down = follow_path(rods[::-1], SNAPPING.load, elements=COUNT, start=up.states[-1])
    back = [STATIONS - 1 - fold.position for fold in down.events]
    assert all(place < up.events[0].position for place in back)
    # A path without a fold runs both ways through the same states.
    plain = gripper_rod()
    there = follow_path(ramp(plain), plain.load, elements=40)
    home = follow_path(ramp(plain)[::-1], plain.load, elements=40, start=there.states[-1])
    assert there.events == home.events == ()
    for a, b in zip(there.states, home.states[::-1], strict=True):
        np.testing.assert_allclose(a.positions, b.positions, atol=1e-9)


def test_several_stable_states_are_found_and_ordered() -> None:
    """Between the folds of a snap there are two stable states at least."""
    path = follow_path(ramp(SNAPPING), SNAPPING.load, elements=COUNT)
    rod = ramp(SNAPPING)[int(path.events[0].position)]
    states = find_equilibria(rod, SNAPPING.load, starts=24, elements=COUNT)
    assert len(states) >= 2
    assert all(state.stable for state in states)
    assert all(a.energy <= b.energy for a, b in pairwise(states))
    again = find_equilibria(rod, SNAPPING.load, starts=24, elements=COUNT)
    assert [s.energy for s in again] == [s.energy for s in states]
    for a, b in pairwise(states):
        assert np.abs(a.positions - b.positions).max() > 1e-4 * rod.length


def test_a_batch_is_its_rods_bit_by_bit_and_in_threads() -> None:
    rng = np.random.default_rng(3)
    count = 24
    lengths = rng.uniform(0.15, 0.6, count)
    strains = np.column_stack(
        (rng.uniform(-15.0, 15.0, count), np.zeros(count), rng.uniform(5.0, 30.0, count))
    )
    weights = 0.24 * np.array([random_direction(rng) for _ in range(count)])
    data = (lengths, 2.7e-4, 1.8e-4, strains, weights)
    batch = solve_rods(*data, elements=40)
    assert batch.stable.all()
    with ThreadPoolExecutor(2) as executor:
        threaded = solve_rods(*data, elements=40, executor=executor)
    np.testing.assert_array_equal(batch.positions, threaded.positions)
    for i in range(count):
        rod = Rod(
            float(lengths[i]),
            Section.inextensible(2.7e-4, 1.8e-4),
            rest_strain=tuple(strains[i].tolist()),
        )
        load = RodLoad(tuple(weights[i].tolist()))
        state = solve_rod(rod, load, elements=40, estimate_error=False)
        np.testing.assert_array_equal(batch.positions[i], state.positions)
        np.testing.assert_array_equal(batch.orientations[i], state.orientations)
        assert batch.energies[i] == pytest.approx(state.energy, rel=1e-12)
        assert batch.folds[i] == state.folds
        assert batch.statuses[i] is state.status
