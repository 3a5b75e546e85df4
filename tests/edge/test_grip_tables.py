# SPDX-License-Identifier: Apache-2.0
"""Tables of grips in files beside the descriptions that they are of."""

import json
import math
from concurrent.futures import ThreadPoolExecutor

import pytest
from core.grip_cases import DOWN, figures, solved_table, table_of

from spiral_core.grip import tabulate
from spiral_core.grip.curve import GripQuestion
from spiral_core.grip.table import GripTable
from spiral_gripper import available_grippers, load_description
from spiral_gripper.cli.gripper import RAMP
from spiral_gripper.cli.workers import process_pool
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper.files.grips import grips_path, read_grips, write_grips
from spiral_gripper.files.storage import LARGEST_FILE, FileError

RADII = (0.01, 0.02, 0.03, 0.04)
GRIPS = (figures(), figures(curling=None, loss=None), figures(tip=3.2e4, loss=4.9e4), None)


@pytest.fixture
def mine(tmp_path):
    """A description file of our own, with a blank in its path."""
    path = tmp_path / "my gripper.yaml"
    path.write_text((GRIPPERS.path / "prototype_p1.yaml").read_text(encoding="utf-8"))
    return path


@pytest.fixture
def written(mine):
    """A description with a table of grips beside it."""
    write_grips(table_of(RADII, GRIPS, error=0.02), load_description(mine))
    return mine


def changed(path, before, after):
    text = path.read_text(encoding="utf-8")
    assert before in text
    path.write_text(text.replace(before, after), encoding="utf-8")


def test_a_file_gives_the_same_answers_as_the_table_in_it(written):
    description = load_description(written)
    path = grips_path(description)
    assert path.name == "my gripper.grips.json"
    table, read = table_of(RADII, GRIPS, error=0.02), read_grips(description)
    assert (read.radii, read.errors, read.gravity, read.rate) == (RADII, (0.02,) * 3, DOWN, 1.5e4)
    for radius in (0.01, 0.012, 0.02, 0.025, 0.03, 0.035):
        window, told = (each.window(radius, 4.0e4) for each in (table, read))
        assert told == (window and pytest.approx(window))
        for pressure in (3.0e4, 4.1e4, 5.0e4, 7.0e4):
            told, exact = (each.answer(radius, 4.0e4, pressure) for each in (read, table))
            for name in exact.__slots__ if exact else ():
                value = getattr(exact, name)
                if isinstance(value, float):
                    value = pytest.approx(value, nan_ok=True)
                assert getattr(told, name) == value
            assert (told is None) is (exact is None)
    before = path.read_bytes()
    assert write_grips(read, description).read_bytes() == before
    assert json.loads(before)["grips"][1]["loss"] is None


def test_a_description_that_says_the_same_in_other_words_keeps_its_table(written):
    changed(written, "name: prototype_p1", "name: mine")
    changed(written, "4.7625 mm", "0.1875 in")
    assert read_grips(load_description(written)).radii == RADII


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("500 mm", "501 mm"),
        ("16 psi", "15 psi"),
        ("[1, 0, 0]", "[0, 0, 1]"),
        ("object_axis: fitted", "object_axis: [0, 0, 1]"),
        ("turns_required: 1.05", "turns_required: 1.05\n  friction_coefficient: 0.4"),
    ],
)
def test_a_table_of_another_content_is_refused_with_the_command_to_run(written, before, after):
    changed(written, before, after)
    with pytest.raises(FileError, match="--table makes it anew") as caught:
        read_grips(load_description(written))
    assert caught.value.action == "used"
    assert f"spiral-gripper grip '{written}' --table" in str(caught.value)


DAMAGED = {
    "a number": lambda text: text.replace("49000.0", "49001.0"),
    "no key": lambda text: text.replace('"key"', '"clue"'),
    "cut off": lambda text: text[: len(text) // 2],
    "empty": lambda _: "",
    "a list": lambda _: "[1]",
    "a text": lambda _: '"key"',
    "too deep": lambda _: "[" * 100_000,
    "too large": lambda _: " " * (LARGEST_FILE + 1),
    "a long number": lambda _: "9" * 5000,
}


@pytest.mark.parametrize("damage", DAMAGED)
def test_a_damaged_file_is_refused(written, damage):
    path = grips_path(load_description(written))
    path.write_text(DAMAGED[damage](path.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(FileError, match=r"cannot be used: .*--table makes it anew"):
        read_grips(load_description(written))


def test_a_file_that_is_not_there_or_cannot_be_read_is_told(mine):
    description = load_description(mine)
    with pytest.raises(FileError, match=r"there is no such file; .*--table makes it") as caught:
        read_grips(description)
    assert caught.value.action == "read"
    grips_path(description).mkdir()
    with pytest.raises(FileError, match="cannot be used: it is a folder"):
        read_grips(description)


def test_a_file_of_another_format_is_refused(written, monkeypatch):
    monkeypatch.setattr("spiral_gripper.files.beside.FORMAT", 2)
    with pytest.raises(FileError, match="another description or version"):
        read_grips(load_description(written))


# --- shipped tables --------------------------------------------------------------------------


@pytest.mark.parametrize("name", available_grippers())
def test_every_shipped_gripper_has_its_table(name):
    """If it fails: make grip-tables."""
    table = read_grips(load_description(name))
    assert len(table.radii) >= 12
    assert table.rate == RAMP
    assert grips_path(load_description(name)).stat().st_size < 100_000


@pytest.mark.slow
def test_a_shipped_table_is_what_is_computed_now():
    description = load_description("prototype_p1")
    table = read_grips(description)
    radius, told = table.radii[len(table.radii) // 2], table.grips[len(table.radii) // 2]
    solved = tabulate.solve_curve(GripQuestion(description.gripper, radius, rate=table.rate))
    # On another processor a snap may come within other bounds of its location.
    for name in ("tip_pressure", "onset_wrap", "onset_curling", "loss", "highest_good"):
        assert getattr(told, name) == pytest.approx(getattr(solved, name), rel=1e-3), name
    for name in ("normal_forces", "away", "towards", "down"):
        assert getattr(told, name) == pytest.approx(getattr(solved, name), rel=1e-2), name


# --- the command -----------------------------------------------------------------------------


def text_of(table, description):
    return write_grips(table, description).read_text(encoding="utf-8")


def test_threads_make_the_same_file_in_whatever_order_they_end(mine, monkeypatch):
    description = load_description(mine)
    texts = [text_of(solved_table(monkeypatch, lambda radius: 1.0 / radius), description)]
    for workers in (1, 3):
        with ThreadPoolExecutor(workers) as pool:
            table = solved_table(monkeypatch, lambda radius: 1.0 / radius, executor=pool)
        texts.append(text_of(table, description))
    assert len(set(texts)) == 1


@pytest.mark.slow
def test_one_and_two_processes_make_the_same_file_byte_for_byte(mine, monkeypatch):
    monkeypatch.setattr(tabulate, "MOST_REFINED", 2)
    description, texts = load_description(mine), []
    for workers in (1, 2):
        with process_pool(workers) as pool:
            table = tabulate.solve_table(description.gripper, 2, RAMP, pool)
        texts.append(text_of(table, description))
    assert texts[0] == texts[1]
    assert len(table.radii) == 4


def tabulated(monkeypatch, *grips):
    """Let the command find these grips at once; return what it asked for."""
    asked = []

    def solve(gripper, count, rate, executor, progress):
        assert executor is not None
        asked.append((gripper.name, count, rate))
        progress(1, 1)
        radii = (0.01, 0.02, 0.03)[: len(grips)]
        errors = (0.034, math.inf)[: len(grips) - 1]
        return GripTable(radii, grips, errors, gripper.gravity, rate)

    monkeypatch.setattr(tabulate, "solve_table", solve)
    return asked


def test_the_command_writes_the_table_beside_the_file_and_says_how_good_it_is(
    mine, said, answer, monkeypatch
):
    asked = tabulated(monkeypatch, figures(), figures(), None)
    text = said("grip", str(mine), "--table", "--units", "cm")
    path = grips_path(load_description(mine))
    for part in ("3 radii 1 cm to 3 cm", "at most 3.4 %", "not held: 3 cm", f"wrote {path}"):
        assert part in text
    found = answer("grip", str(mine), "--table", "--table-radii", "4")
    assert found == {
        "path": str(path), "radii": [0.01, 0.02, 0.03], "error": 0.034, "not_held": [0.03]
    }  # fmt: skip
    assert [(count, rate) for _, count, rate in asked] == [(6, RAMP), (4, RAMP)]
    assert read_grips(load_description(mine)).radii == (0.01, 0.02, 0.03)
    tabulated(monkeypatch, None, None)
    assert "not held: 1 cm, 2 cm" in said("grip", str(mine), "--table", "--units", "cm", code=1)


def test_before_anything_is_computed_the_place_is_tried(mine, said, monkeypatch):
    asked = tabulated(monkeypatch, figures(), figures())
    grips_path(load_description(mine)).mkdir()
    assert "is not a plain file" in said("grip", str(mine), "--table", code=2)
    assert not asked
