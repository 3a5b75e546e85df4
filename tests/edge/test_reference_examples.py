# SPDX-License-Identifier: Apache-2.0
"""Every public name has an example in the reference, and the examples are true."""

import doctest
import re
from pathlib import Path

import pytest

import spiral_core
import spiral_gripper

pytestmark = pytest.mark.long

FOLDER = Path(__file__).parents[2] / "docs" / "reference_examples"
FILES = sorted(FOLDER.glob("*.txt"))
SETUP = "Setup\n-----\n"


def sections(path: Path) -> tuple[str, dict[str, str]]:
    """Return what all examples of a file begin with, and the examples by title."""
    pieces = re.split(r"^(.+)\n-+\n", path.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    titled = dict(zip(pieces[::2], pieces[1::2], strict=True))
    return titled.pop("Setup"), titled


def run_example(code: str, names: dict[str, object], title: str) -> None:
    """Run what a file shows; the names that it makes are added."""
    case = doctest.DocTestParser().get_doctest(code, {}, title, None, 0)
    case.globs = names
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    assert runner.run(case, clear_globs=False).failed == 0, title


# What computes for long.
SLOW = {"calibration", "design", "grip", "motion"}
CASES = [
    pytest.param(path, marks=pytest.mark.slow if path.stem in SLOW else (), id=path.stem)
    for path in FILES
]


@pytest.mark.parametrize("path", CASES)
def test_each_example_runs_after_its_setup_alone(path: Path) -> None:
    setup, examples = sections(path)
    names: dict[str, object] = {}
    run_example(setup, names, f"Setup of {path.name}")
    for title, code in examples.items():
        run_example(code, dict(names), title)


def names_without_example(package) -> list[str]:
    """Return the public names that no docstring of theirs and no example shows in use."""
    lines = [
        line
        for path in FILES
        for line in path.read_text(encoding="utf-8").splitlines()
        if line.startswith((">>> ", "... ")) and "import " not in line
    ]
    used = set(re.findall(r"\w+", "\n".join(lines)))
    return [
        name
        for name in package.__all__
        if name not in used and ">>> " not in (getattr(package, name).__doc__ or "")
    ]


@pytest.mark.parametrize("package", [spiral_core, spiral_gripper])
def test_every_public_name_has_an_example(package) -> None:
    assert names_without_example(package) == []


def test_every_public_name_of_the_core_has_a_page() -> None:
    conf = (FILES[0].parents[1] / "conf.py").read_text(encoding="utf-8")
    table = conf.split("FOLDERS = {")[1].split("\n}")[0]
    pages = set(re.findall(r'^    "(\w+)":', table, re.MULTILINE))
    assert {module.split(".")[1] for module in spiral_core.MODULES.values()} == pages
    index = (FILES[0].parents[1] / "index.md").read_text(encoding="utf-8")
    assert all(f"\nreference/{page}\n" in index for page in pages)
