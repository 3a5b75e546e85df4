# SPDX-License-Identifier: Apache-2.0
"""Tables of grips in files beside the descriptions that they are of."""

import math
from dataclasses import asdict, replace

import pytest
from core.grip_cases import figures, table_of
from edge.recorded import cases, changed, check
from numpy.testing import assert_allclose, assert_equal

from spiral_core.grip import tabulate
from spiral_core.grip.curve import GripQuestion
from spiral_core.grip.table import GripTable
from spiral_gripper import available_grippers, load_description
from spiral_gripper.cli.gripper import RAMP
from spiral_gripper.cli.workers import process_pool
from spiral_gripper.files.grips import grips_path, read_grips, write_grips
from spiral_gripper.files.storage import FileError

RADII = (0.01, 0.02, 0.03, 0.04)
GRIPS = (figures(), figures(curling=None, loss=None), figures(tip=3.2e4, loss=4.9e4), None)


@pytest.fixture
def written(mine):
    """A description with a table of grips beside it."""
    path = mine.rename("my gripper.yaml")
    write_grips(table_of(RADII, GRIPS, error=0.02), load_description(path))
    return path


def test_a_file_gives_the_table_that_was_written(written):
    description = load_description(written)
    path, read = grips_path(description), read_grips(description)
    table = table_of(RADII, [grip and replace(grip, shapes=None) for grip in GRIPS], error=0.02)
    assert_equal(asdict(read), asdict(replace(table, rate=1.5e4)))
    before = path.read_bytes()
    assert write_grips(read, description).read_bytes() == before


@pytest.mark.parametrize("change", cases("descriptions_of_tables.txt"))
def test_a_table_is_of_what_its_description_says_in_any_words(written, change):
    written.write_text(changed(written.read_text("utf-8"), change), "utf-8")
    said = "as before"
    try:
        assert read_grips(load_description(written)).radii == RADII
    except FileError as error:
        said = str(error)
    check("descriptions_of_tables.txt", change, [said])


def test_a_file_that_is_damaged_of_another_format_or_not_there_is_refused(written, monkeypatch):
    description = load_description(written)
    path = grips_path(description)
    text = path.read_text("utf-8")
    for damaged in (
        *(text.replace("49000.0", "49001.0"), text.replace('"key"', '"clue"')),
        *(text[: len(text) // 2], '"key"', "[" * 100_000, "9" * 5000),
    ):
        path.write_text(damaged)
        with pytest.raises(FileError, match=r"or is damaged; .*--table makes it anew"):
            read_grips(description)
    path.write_text(text)
    monkeypatch.setattr("spiral_gripper.files.beside.FORMAT", 3)
    with pytest.raises(FileError, match="another description or version"):
        read_grips(description)
    path.unlink()
    with pytest.raises(FileError, match=r"there is no such file; .*--table makes it") as caught:
        read_grips(description)
    assert caught.value.action == "read"
    path.mkdir()
    with pytest.raises(FileError, match="cannot be used: it is a folder"):
        read_grips(description)


# --- shipped tables --------------------------------------------------------------------------


def test_every_shipped_gripper_has_its_table():
    """If it fails: make grip-tables."""
    for name in available_grippers():
        table = read_grips(load_description(name))
        assert len(table.radii) >= 12
        assert table.rate == RAMP


@pytest.mark.slow
def test_a_shipped_table_is_what_is_computed_now():
    description = load_description("prototype_p1")
    table = read_grips(description)
    middle = len(table.radii) // 2
    radius, told = table.radii[middle], table.grips[middle]
    solved = tabulate.solve_curve(GripQuestion(description.gripper, radius, rate=table.rate))
    for names, rel in (
        # On another processor a snap may come within other bounds of its location.
        (("tip_pressure", "onset_wrap", "onset_curling", "loss", "highest_good"), 1e-3),
        (("normal_forces", "away", "towards", "down"), 1e-2),
    ):
        for name in names:
            assert_allclose(getattr(told, name), getattr(solved, name), rel, err_msg=name)


# --- the command -----------------------------------------------------------------------------


@pytest.mark.slow
def test_one_and_two_processes_make_the_same_file_byte_for_byte(mine, monkeypatch):
    monkeypatch.setattr(tabulate, "MOST_REFINED", 2)
    description, texts = load_description(mine), []
    for workers in (1, 2):
        with process_pool(workers) as pool:
            table = tabulate.solve_table(description.gripper, 2, RAMP, pool)
        texts.append(write_grips(table, description).read_bytes())
    assert texts[0] == texts[1]
    assert len(table.radii) == 4


def test_the_command_writes_the_table_beside_the_file_and_says_how_good_it_is(
    mine, said, recorded, monkeypatch
):
    asked, grips = [], [figures(), figures(), None]

    def solve(gripper, count, rate, _, progress):
        asked.append((count, rate))
        progress(1, 1)
        errors = (0.034, math.inf)[: len(grips) - 1]
        return GripTable(RADII[: len(grips)], (*grips,), errors, gripper.gravity, rate)

    monkeypatch.setattr(tabulate, "solve_table", solve)
    path = mine.with_suffix(".grips.json")
    for command in cases("grip_tables.txt"):
        recorded("grip_tables.txt", command)
    assert read_grips(load_description(mine)).radii == RADII[:3]
    grips[:] = None, None
    assert "not held: 10 mm, 20 mm" in said("grip mine.yaml --table", code=1)
    # Before anything is computed the place is tried.
    path.unlink()
    path.mkdir()
    assert "is not a plain file" in said("grip mine.yaml --table", code=2)
    assert asked == [(6, RAMP), (4, RAMP), (6, RAMP)]
