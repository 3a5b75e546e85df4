# SPDX-License-Identifier: Apache-2.0
"""Random misplacements closed on twice the elements: are they held where the region says so?

``python -m benchmarks.capture --count 300`` finds the region of capture of one gripper and object,
then closes on random misplacements: a third in the plane of the shifts, a third in that of the
tilts, within 1.3 times the limits, and a third in the ellipsoid of five errors at once. Those in a
plane within 0.5 mm or 1.25 degrees of the outline are not taken. Those between two neighbors of the
outline whose distances from the center differ by more than 2 mm or 5 degrees stand in a row of
their own. Closings are kept in ``benchmarks/results/capture.jsonl``: a run that was interrupted
goes on; delete it to begin anew. ``--page`` writes the counts and the picture of docs/capture.md.
"""

from __future__ import annotations

import argparse
from concurrent.futures import as_completed
from dataclasses import asdict, replace

import numpy as np
from matplotlib.path import Path
from rich.progress import track

from benchmarks.cases import SEED, Array
from benchmarks.command import wide_console
from benchmarks.report import END, RESULTS, ROOT, markdown_table, show
from benchmarks.results import Table
from spiral_core import capture_region, close_misplaced, lay_into_coil
from spiral_core.grip.capture import (
    BENT,
    RESOLUTION,
    SHIFTS,
    TILTS,
    CaptureOutcome,
    CaptureRegion,
    Misplacement,
)
from spiral_core.grip.grip import recommended_grip
from spiral_core.grip.setup import GripSetup
from spiral_gripper import load_gripper
from spiral_gripper.cli.workers import core_count, process_pool
from spiral_gripper.reports.grip.plots import capture_figure
from spiral_gripper.reports.grip.study import capture_file
from spiral_gripper.reports.style import DPI

GRIPPER, RADIUS, PAYLOAD = "paper_design_70", 0.015, 0.020
KEPT = RESULTS / "capture.jsonl"
PAGE = ROOT / "docs" / "capture.md"
BEGIN = "<!-- From python -m benchmarks.capture --page -->"
# Misplacements are taken from the box of the limits times this, within this part of the reach.
WIDER, WITHIN = 1.3, 0.95
# The outline jumps where neighbors differ by so many resolutions.
JUMP = 4.0 * BENT


def to_outline(region: CaptureRegion, place: Array, plane: tuple[int, int]) -> float:
    """Return the distance of a misplacement in a plane to the outline, in resolutions."""
    chosen = list(plane)
    boundaries = region.shifts if plane == SHIFTS else region.tilts
    corners = region.outline(boundaries)[:, chosen] / RESOLUTION[chosen]
    ways = np.roll(corners, -1, axis=0) - corners
    offsets = place[chosen] / RESOLUTION[chosen] - corners
    along = np.sum(offsets * ways, axis=1) / np.maximum(np.sum(ways * ways, axis=1), 1e-300)
    feet = np.clip(along, 0.0, 1.0)[:, None] * ways
    return float(np.linalg.norm(offsets - feet, axis=1).min())


def side_of(region: CaptureRegion, place: Array, plane: tuple[int, int]) -> str:
    """Return on which side of an outline a misplacement in its plane lies, in words."""
    chosen = list(plane)
    boundaries = region.shifts if plane == SHIFTS else region.tilts
    sizes = np.linalg.norm(region.outline(boundaries) / RESOLUTION, axis=1)
    ways = np.array([each.direction for each in boundaries])[:, chosen]
    angles = np.mod(np.arctan2(ways[:, 1], ways[:, 0]), 2.0 * np.pi)
    away, across = (place / np.array(region.reach))[chosen]
    after = int(np.searchsorted(angles, np.mod(np.arctan2(across, away), 2.0 * np.pi)))
    if abs(sizes[after % len(sizes)] - sizes[after - 1]) > JUMP:
        return "beside a jump"
    corners, (x, y) = region.outline(boundaries)[:, chosen], place[chosen].tolist()
    return "inside" if Path(corners).contains_point((x, y)) else "outside"


def samples(region: CaptureRegion, count: int) -> list[tuple[str, Array]]:
    """Return misplacements that are judged, each with where it lies."""
    rng = np.random.default_rng(SEED)
    found: list[tuple[str, Array]] = []
    limits, reach = region.limits, np.array(region.reach)
    while len(found) < count:
        name = ("shifts", "tilts", "ellipsoid")[len(found) % 3]
        if name == "ellipsoid":
            way = rng.standard_normal(5)
            size = rng.uniform() ** 0.2 / np.linalg.norm(way)
            found.append(("inside, all five errors", size * way * region.semi_axes))
            continue
        plane = SHIFTS if name == "shifts" else TILTS
        place = np.zeros(5)
        place[list(plane)] = WIDER * rng.uniform(*limits[list(plane)].T)
        near = to_outline(region, place, plane) < BENT
        if near or np.linalg.norm(place / reach) > WITHIN:
            continue
        found.append((f"{side_of(region, place, plane)}, {name}", place))
    return found


def closed(
    setup: GripSetup, pressure: float, misplacement: Misplacement
) -> tuple[Misplacement, CaptureOutcome]:
    """Return a misplacement and what closing on it ends in."""
    return misplacement, close_misplaced(setup, pressure, misplacement, PAYLOAD).outcome


def measure(count: int) -> tuple[Table, CaptureRegion]:
    """Return how many random misplacements are held where they should be, and the region."""
    setup = lay_into_coil(load_gripper(GRIPPER), RADIUS)
    pressure = recommended_grip(setup, PAYLOAD).pressure
    store = capture_file(KEPT, setup, pressure, PAYLOAD)
    finer = replace(setup, elements=2 * setup.element_count)
    fine = capture_file(KEPT, finer, pressure, PAYLOAD)
    with process_pool(core_count()) as pool:
        region = capture_region(
            setup, pressure, PAYLOAD, executor=pool, known=store.known, keep=store.keep
        )
        places = [(name, tuple(place.tolist())) for name, place in samples(region, count)]
        jobs = [
            pool.submit(closed, finer, pressure, place)
            for _, place in places
            if place not in fine.known
        ]
        for job in track(as_completed(jobs), "closing", total=len(jobs)):
            place, outcome = job.result()
            fine.known[place] = outcome
            fine.keep(place, outcome)
    rows = []
    for name in sorted({name for name, _ in places}):
        outcomes = [fine.known[place] for where, place in places if where == name]
        counts = [outcomes.count(outcome) for outcome in CaptureOutcome]
        rows.append((name, f"{len(outcomes)}", *(f"{number}" for number in counts)))
    table = Table(
        f"{count} random misplacements closed on {finer.element_count} elements",
        ("where", "closed", *(outcome.value.partition(":")[0] for outcome in CaptureOutcome)),
        tuple(rows),
        f"{GRIPPER}, {1e3 * RADIUS:g} mm, {1e3 * PAYLOAD:g} g, {1e-3 * pressure:.2f} kPa; the "
        f"region took {region.closings} closings on {setup.element_count} elements.",
    )
    return table, region


def main() -> None:
    """Print the counts, and put them into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=300, help="random misplacements")
    parser.add_argument(
        "--page", action="store_true", help="write counts and picture of docs/capture.md"
    )
    given = parser.parse_args()
    table, region = measure(given.count)
    show(table, wide_console())
    if given.page:
        text = PAGE.read_text(encoding="utf-8")
        before, rest = text.split(BEGIN)
        counts = f"{BEGIN}\n\n{markdown_table(asdict(table))}"
        PAGE.write_text(before + counts + END + rest.split(END)[1], encoding="utf-8")
        title = f"{GRIPPER} on radius {1e3 * RADIUS:g} mm"
        picture = PAGE.parent / "figures" / "capture.png"
        capture_figure(region, title).savefig(picture, dpi=DPI // 2)


if __name__ == "__main__":
    main()
