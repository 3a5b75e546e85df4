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


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=[pytest.mark.slow] * (path.stem in SLOW), id=path.stem)
        for path in FILES
    ],
)
def test_each_example_runs_after_its_setup_alone(path):
    text = path.read_text("utf-8")
    _, setup, *examples = re.split(r"^.+\n-+\n", text, flags=re.MULTILINE)
    for example in examples:
        case = doctest.DocTestParser().get_doctest(setup + example, {}, path.name, None, 0)
        runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
        assert runner.run(case).failed == 0


@pytest.mark.parametrize("package", [spiral_core, spiral_gripper])
def test_every_public_name_has_an_example(package):
    """In its docstring, or in a line of an example that uses it."""
    texts = "\n".join(path.read_text("utf-8") for path in FILES)
    lines = re.findall(r"^(?:>>>|\.\.\.) (?!.*import ).*", texts, re.MULTILINE)
    used = set(re.findall(r"\w+", "\n".join(lines)))
    unused = [name for name in package.__all__ if name not in used]
    assert [n for n in unused if ">>> " not in (getattr(package, n).__doc__ or "")] == []


def test_every_public_name_of_the_core_has_a_page():
    folders = {module.split(".")[1] for module in spiral_core.MODULES.values()}
    for name, entry in (("conf.py", r'^    "(\w+)": '), ("index.md", r"^reference/(\w+)$")):
        text = (ROOT / "docs" / name).read_text("utf-8")
        assert folders <= set(re.findall(entry, text, re.MULTILINE))
