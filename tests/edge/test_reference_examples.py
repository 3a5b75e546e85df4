# SPDX-License-Identifier: Apache-2.0
"""Every public name has an example in the reference, and the examples are true."""

import doctest
import re

import pytest
from repo.source_tree import ROOT

import spiral_core
import spiral_gripper

pytestmark = pytest.mark.long

FILES = sorted((ROOT / "docs" / "reference_examples").glob("*.txt"))
# What computes for long.
SLOW = {"calibration", "design", "grip", "motion"}


def run_example(code, names, title):
    """Run what a file shows; the names that it makes are added."""
    case = doctest.DocTestParser().get_doctest(code, {}, title, None, 0)
    case.globs = names
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    assert runner.run(case, clear_globs=False).failed == 0, title
    return names


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=pytest.mark.slow if path.stem in SLOW else (), id=path.stem)
        for path in FILES
    ],
)
def test_each_example_runs_after_its_setup_alone(path):
    pieces = re.split(r"^(.+)\n-+\n", path.read_text("utf-8"), flags=re.MULTILINE)[1:]
    examples = dict(zip(pieces[::2], pieces[1::2], strict=True))
    names = run_example(examples.pop("Setup"), {}, f"Setup of {path.name}")
    for title, code in examples.items():
        run_example(code, dict(names), title)


@pytest.mark.parametrize("package", [spiral_core, spiral_gripper])
def test_every_public_name_has_an_example(package):
    """In its docstring, or in a line of an example that uses it."""
    texts = "\n".join(path.read_text(encoding="utf-8") for path in FILES)
    lines = re.findall(r"^(?:>>>|\.\.\.) (?!.*import ).*", texts, re.MULTILINE)
    used = set(re.findall(r"\w+", "\n".join(lines)))
    unused = [name for name in package.__all__ if name not in used]
    assert [n for n in unused if ">>> " not in (getattr(package, n).__doc__ or "")] == []


def test_every_public_name_of_the_core_has_a_page():
    conf = (ROOT / "docs" / "conf.py").read_text(encoding="utf-8")
    table = conf.split("FOLDERS = {")[1].split("\n}")[0]
    pages = set(re.findall(r'^    "(\w+)":', table, re.MULTILINE))
    assert {module.split(".")[1] for module in spiral_core.MODULES.values()} == pages
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    assert all(f"\nreference/{page}\n" in index for page in pages)
