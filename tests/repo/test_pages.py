# SPDX-License-Identifier: Apache-2.0
"""The pages are true: tables, links, commands, length; the README's Python prints what it says.

That every page is in the navigation is Sphinx's to say: ``make docs``.
"""

import re
from itertools import pairwise

import click
import pytest
from repo.source_tree import FENCED, ROOT, printed_by_python

from docs.tables import BLOCK, tables, with_tables
from spiral_gripper.cli.main import spiral_gripper
from spiral_gripper_ros.parameters.table import PARAMETERS
from spiral_gripper_ros.regulators.parameters import REGULATOR_PARAMETERS
from spiral_gripper_ros.simulation.radius_estimator import RadiusParameters
from spiral_gripper_ros.simulation.regulator import SimulatedRegulatorParameters

DOCS = ROOT / "docs"
PATHS = sorted([*DOCS.glob("*.md"), *DOCS.glob("derivations/*.md"), *ROOT.glob("*.md")])
TEXTS = {path: path.read_text("utf-8") for path in PATHS}
LINK = re.compile(r"""(?:\]\(|src=")(?!\w+:)([^)"\s#]*)(?:#([^)\s]*))?[)"]""")
# Longest page [words], without what programs write into it.
LONGEST = 1500
WRITTEN = re.compile(r"<!-- (?:table|From) .*?<!-- end -->", re.DOTALL)
# Parameters that a command may set.
SPECS = (RadiusParameters.specs(), SimulatedRegulatorParameters.specs())
SET = {spec.name for specs in (*SPECS, PARAMETERS, REGULATOR_PARAMETERS) for spec in specs}


def anchors(page):
    """Return what forge and site make of a page's headings."""
    headings = re.findall(r"^#+ (.*)$", FENCED.sub("", page).lower(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading).strip().replace(" ", "-") for heading in headings}


def test_the_tables_are_as_the_code_states_them():
    """If this fails: python docs/tables.py."""
    for page in TEXTS.values():
        assert page == with_tables(page)
    assert sorted(name for _, name, _ in BLOCK.findall("".join(TEXTS.values()))) == sorted(tables())


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.name)
def test_links_lead_to_headings_and_commands_have_the_options_parameters_and_targets(path):
    for target, anchor in LINK.findall(FENCED.sub("", TEXTS[path])):
        linked = (path.parent / target).resolve() if target else path
        assert linked.exists(), target
        if path.parent != ROOT:  # Sphinx links to files, and among pages to its own only
            assert linked.is_file(), target
            assert linked.suffix != ".md" or DOCS in linked.parents, target
        if anchor:
            assert anchor in anchors(TEXTS[linked]), f"{target}#{anchor}"
    # A changelog tells of yesterday's commands.
    page = TEXTS[path].replace("\\\n", " ") if path.stem != "CHANGELOG" else ""
    for line in re.findall(r"spiral-gripper ([a-z].*?)(?:`|#|$)", page, re.MULTILINE):
        command, context = spiral_gripper, click.Context(spiral_gripper)
        words = line.split()
        while words and isinstance(command, click.Group):
            command = command.get_command(context, words.pop(0))
            assert command is not None, line
        known = {option for parameter in command.params for option in parameter.opts}
        assert {word for word in words if word.startswith("--")} <= known, line
    launch = "".join(file.read_text("utf-8") for file in ROOT.glob("*/launch/*.py"))
    for name in re.findall(r"(?:-p |`)(\w[\w.]*):=", page):
        assert name in {*SET, "use_sim_time"} or f'"{name}"' in launch, name
    makefile = (ROOT / "Makefile").read_text("utf-8")
    targets = set(re.findall(r"^([\w-]+):", makefile, re.MULTILINE))
    assert {*re.findall(r"(?:`|^)make ([a-z-]+)", page, re.MULTILINE)} <= targets


def test_a_page_is_read_in_a_few_minutes():
    for path in DOCS.glob("*.md"):
        assert len(re.findall(r"\S*\w\S*", WRITTEN.sub("", TEXTS[path]))) <= LONGEST, path


def test_the_python_of_a_page_prints_what_it_says():
    for page in ("README.md", "docs/derivations/derivatives.md"):
        blocks = FENCED.findall(TEXTS[ROOT / page])
        programs = [(text, *after) for (kind, text), after in pairwise(blocks) if kind == "python"]
        assert programs
        for text, kind, output in programs:
            assert (kind, output.strip()) == ("text", printed_by_python(text).strip())
