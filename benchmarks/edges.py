# SPDX-License-Identifier: Apache-2.0
"""Rods that random ones never meet: jumps, few elements, any stiffness ratio, symmetric directions.

Each is solved and certified with an error estimate that holds, or refused with a reason. What is
counted as wrong: a certified shape that is off by more than three times its estimate.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.cases import SEED, Array, random_direction
from benchmarks.results import Effort, Section, Table
from spiral_core import InvalidInputError, Rod, RodLoad, RodState, solve_rod
from spiral_core import Section as CrossSection
from spiral_core.rod._mesh import element_count
from spiral_core.rod.types import SectionProfile

# A certified shape may be off by this many times its estimate, and this fraction of the length.
FACTOR = 3.0
SLACK = 1e-6
# Elements of the reference, relative to those that the solver takes by itself.
# Rounding errors grow with them: where one does not come to rest, the next is taken.
REFINEMENTS = (2.0, 1.5, 3.0)
# A reference whose last Newton step [rad] is below this rests, though rounding errors leave an
# imbalance above the tolerance: GJ/EI near 1e4 on thousands of elements.
ROUNDING = 1e-9
CLASSES = (
    "stiffness jumps, declared",
    "rest strain and load jump, declared",
    "a jump, not declared",
    "2 to 8 elements",
    "jumps on few elements",
    "GJ/EI from 1e-4 to 1e4",
    "load along an axis",
    "load next to an axis",
)


class EdgeCase(NamedTuple):
    """A rod to solve, of one of the classes."""

    kind: str
    rod: Rod
    load: RodLoad
    elements: int | None


class Verdict(NamedTuple):
    """How it went: right, refused or wrong; the error's ratio to what was claimed for it."""

    rod: int
    kind: str
    verdict: str
    reason: str
    ratio: float


def stepped(
    values: tuple[float, ...] | Array, places: tuple[float, ...]
) -> Callable[[Array], Array]:
    """Return a function of arc length that takes one value after the other."""
    table = np.asarray(values, dtype=np.float64)

    def value(s: Array) -> Array:
        return np.asarray(table[np.searchsorted(places, s, side="right")])

    return value


def edge_case(index: int) -> EdgeCase:
    """Return one rod of the sample; the same index gives the same rod. Lengths and EI near one."""
    rng = np.random.default_rng([SEED, 1, index])
    kind = CLASSES[index % len(CLASSES)]
    length, bending = rng.uniform(0.2, 1.0), 10.0 ** rng.uniform(-4.0, -2.0)
    ratio = rng.uniform(0.4, 1.2)
    if kind == "GJ/EI from 1e-4 to 1e4":
        ratio = 10.0 ** rng.uniform(-4.0, 4.0)
    turned = rng.uniform(0.5, 18.0) / length
    torsion = rng.uniform(-0.9, 0.9) * turned
    strain = (torsion, 0.0, turned)
    heaviness = 10.0 ** rng.uniform(0.0, 2.5)
    weight = heaviness * bending / length**3
    direction = np.array(random_direction(rng))
    tip = rng.uniform(0.0, 1.0) * weight * length * np.array(random_direction(rng))
    if kind.startswith("load"):
        direction = along_an_axis(rng)
        heaviness = 10.0 ** rng.uniform(0.0, 3.0)
        weight = heaviness * bending / length**3
        tip = rng.choice([-1.0, 0.0, 1.0]) * weight * length * rng.uniform() * along_an_axis(rng)
        strains = ((0.0, 0.0, 0.0), (torsion, 0.0, 0.0), (0.0, 0.0, turned), strain)
        strain = strains[rng.integers(4)]
    if kind == "load next to an axis":
        direction = direction + 10.0 ** rng.uniform(-12.0, -3.0) * rng.normal(size=3)
    load = RodLoad(tuple((weight * direction).tolist()), tuple(tip.tolist()))
    elements = int(rng.integers(2, 9)) if kind == "2 to 8 elements" else None
    if "jump" not in kind:
        return EdgeCase(
            kind,
            Rod(length, CrossSection.inextensible(bending, ratio * bending), rest_strain=strain),
            load,
            elements,
        )
    return jumping(kind, rng, length, bending, ratio, strain, load)


def along_an_axis(rng: np.random.Generator) -> Array:
    """Return one of the six unit vectors along an axis."""
    direction = np.zeros(3)
    direction[rng.integers(3)] = rng.choice([-1.0, 1.0])
    return direction


def jumping(
    kind: str,
    rng: np.random.Generator,
    length: float,
    bending: float,
    ratio: float,
    strain: tuple[float, float, float],
    load: RodLoad,
) -> EdgeCase:
    """Return a rod of two or three pieces, stiffness or rest strain and load jumping between."""
    count = int(rng.integers(2, 4))
    places = tuple(np.sort(rng.uniform(0.05, 0.95, count - 1) * length).tolist())
    strain_values = np.array(strain) * rng.uniform(-1.0, 1.0, (count, 1))
    stiff = bending * 10.0 ** rng.uniform(-1.0, 1.5, count)
    strains: object = stepped(strain_values, places)
    weights: object = load.distributed
    section: SectionProfile = CrossSection.varying(
        stepped(stiff, places), stepped(ratio * stiff, places)
    )
    if kind == "rest strain and load jump, declared":
        section = CrossSection.inextensible(bending, ratio * bending)
        weights = stepped(np.array(load.distributed) * rng.uniform(0.0, 1.0, (count, 1)), places)
    elif rng.uniform() < 0.5:
        strains = strain
    breaks = () if kind == "a jump, not declared" else places
    elements = int(rng.integers(count + 1, 24)) if kind == "jumps on few elements" else None
    rod = Rod(length, section, rest_strain=strains, breaks=breaks)  # type: ignore[arg-type]
    return EdgeCase(kind, rod, RodLoad(weights, load.tip_force), elements)  # type: ignore[arg-type]


def true_error(case: EdgeCase, state: RodState) -> float:
    """Return the largest distance [m] of a node from a much finer solution next to the state."""
    enough = max(element_count(case.rod, case.load), len(state.arc_lengths) - 1)
    for refinement in REFINEMENTS:
        count = int(refinement * enough)
        fine = solve_rod(case.rod, case.load, elements=count, start=state, throw=False)
        if fine.stable or (fine.smallest_pivot > 0.0 and fine.last_step < ROUNDING):
            break
    else:
        return case.rod.length
    arcs = fine.arc_lengths
    shape = np.column_stack(
        [np.interp(state.arc_lengths, arcs, column) for column in fine.positions.T]
    )
    # Between nodes the chord is off by an eighth of the turn; only where the meshes do not nest.
    nested = np.abs(state.arc_lengths[:, None] - arcs).min(axis=1) < 1e-9 * case.rod.length
    apart = state.positions[nested] - shape[nested]
    if state.neutral_modes:
        turn = Rotation.align_vectors(state.positions, shape)[0].as_rotvec()
        apart = (state.positions - Rotation.from_rotvec([turn[0], 0.0, 0.0]).apply(shape))[nested]
    return float(np.linalg.norm(apart, axis=1).max())


def judge(index: int) -> Verdict:
    """Solve one rod and compare its error with what was claimed."""
    case = edge_case(index)
    try:
        state = solve_rod(case.rod, case.load, elements=case.elements, throw=False)
    except InvalidInputError as error:
        return Verdict(index, case.kind, "refused", error.field, 0.0)
    if not state.stable:
        return Verdict(index, case.kind, "refused", state.status.name, 0.0)
    claimed = state.discretization_error or 0.0
    off = true_error(case, state)
    allowed = FACTOR * claimed + SLACK * case.rod.length
    return Verdict(
        index,
        case.kind,
        "right" if off <= allowed else "wrong",
        state.certificate.name,
        off / (claimed + SLACK / FACTOR * case.rod.length),
    )


def table(verdicts: list[Verdict]) -> tuple[Table, dict[str, float]]:
    """Return the table and the figures of the sample."""
    rows = []
    for kind in CLASSES:
        some = [v for v in verdicts if v.kind == kind]
        counts = Counter(v.verdict for v in some)
        reasons = Counter(v.reason for v in some if v.verdict == "refused")
        neutral = sum(v.reason == "STABLE_UP_TO_ROTATION" for v in some)
        ratios = [v.ratio for v in some if v.verdict != "refused"]
        rows.append(
            (
                kind,
                f"{len(some):,}",
                f"{counts['right']:,}",
                f"{neutral:,}",
                ", ".join(f"{count:,} {reason}" for reason, count in reasons.items()) or "-",
                f"{counts['wrong']:,}",
                f"{max(ratios):.2f}" if ratios else "-",
            )
        )
    wrong = [v for v in verdicts if v.verdict == "wrong"]
    note = (
        "Right: certified, and off by at most three times the estimated error and 1e-6 of the "
        "length, against a solution on twice as many elements. Refused: an error "
        "that names the input, or a status. "
        + "; ".join(f"rod {v.rod}: {v.ratio:.1f} times the estimate" for v in wrong[:20])
    )
    columns = ("class", "rods", "right", "of these up to a rotation", "refused", "wrong", "error")
    values = {"edge_rods": float(len(verdicts)), "edge_wrong": float(len(wrong))}
    return Table(
        f"Robustness at the edges: {len(verdicts):,} rods", columns, tuple(rows), note.strip()
    ), values


def measure(effort: Effort) -> Section:
    """Judge the whole sample."""
    sample, values = table([judge(index) for index in range(effort.rods)])
    return Section((sample,), values)
