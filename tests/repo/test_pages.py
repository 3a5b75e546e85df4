# SPDX-License-Identifier: Apache-2.0
"""The pages of the documentation: tables, links, commands, length, navigation."""

import re

import click
import pytest
from repo.source_tree import ROOT

from docs.tables import BLOCK, tables, with_tables
from spiral_gripper.cli.main import spiral_gripper
from spiral_gripper_ros.parameters.table import PARAMETERS
from spiral_gripper_ros.regulators.parameters import REGULATOR_PARAMETERS
from spiral_gripper_ros.simulation.radius_estimator import RadiusParameters
from spiral_gripper_ros.simulation.regulator import SimulatedRegulatorParameters

DOCS = ROOT / "docs"
PAGES = sorted([*DOCS.glob("*.md"), *DOCS.glob("derivations/*.md")])
LINK = re.compile(r"""(?:\]\(|src=")([^)"\s#]*)(?:#([^)\s]*))?[)"]""")
FENCED = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
# Longest page [words], without what programs write into it.
LONGEST = 1500
WRITTEN = re.compile(r"<!-- (?:table|From) .*?<!-- end -->", re.DOTALL)
# Parameters that a command may set.
SPECS = (RadiusParameters.specs(), SimulatedRegulatorParameters.specs())
SET = {spec.name for specs in (*SPECS, PARAMETERS, REGULATOR_PARAMETERS) for spec in specs}
SET |= {"use_sim_time"}
# Written by Sphinx.
BUILT = {"gallery", "reference"}


def names(paths):
    return pytest.mark.parametrize("path", paths, ids=lambda path: path.name)


def anchors(path):
    """Return what forge and site make of a page's headings."""
    headings = re.findall(r"^#+ (.*)$", FENCED.sub("", path.read_text("utf-8")), re.MULTILINE)
    kept = (re.sub(r"[^\w\- ]", "", heading.lower()) for heading in headings)
    return {heading.strip().replace(" ", "-") for heading in kept}


@names(PAGES)
def test_the_tables_are_as_the_code_states_them(path):
    """If this fails: python docs/tables.py."""
    page = path.read_text(encoding="utf-8")
    assert page == with_tables(page)


def test_every_table_has_its_page():
    pages = "".join(path.read_text(encoding="utf-8") for path in PAGES)
    assert sorted(name for _, name, _ in BLOCK.findall(pages)) == sorted(tables())


@names([*PAGES, *ROOT.glob("*.md")])
def test_every_link_leads_to_a_file_and_its_heading(path):
    for target, anchor in LINK.findall(FENCED.sub("", path.read_text(encoding="utf-8"))):
        if re.match(r"\w+:", target):
            continue
        linked = path.parent / target if target else path
        assert linked.exists(), target
        if path in PAGES:  # Sphinx links to files, and among pages to its own only
            assert linked.is_file(), target
            assert linked.suffix != ".md" or DOCS in linked.resolve().parents, target
        if anchor:
            assert anchor in anchors(linked), f"{target}#{anchor}"


@names([*PAGES, ROOT / "README.md"])
def test_the_options_of_every_command_exist(path):
    page = path.read_text(encoding="utf-8").replace("\\\n", " ")
    for line in re.findall(r"spiral-gripper ([a-z].*?)(?:`|#|$)", page, re.MULTILINE):
        command, context = spiral_gripper, click.Context(spiral_gripper)
        words = line.split()
        while words and isinstance(command, click.Group):
            command = command.get_command(context, words.pop(0))
            assert command is not None, line
        known = {option for parameter in command.params for option in parameter.opts}
        assert {word for word in words if word.startswith("--")} <= known, line


@names([*PAGES, ROOT / "README.md"])
def test_every_parameter_that_is_set_exists(path):
    launch = "".join(
        file.read_text(encoding="utf-8") for file in ROOT.glob("spiral_gripper_ros/launch/*.py")
    )
    for name in re.findall(r"(?:-p |`)(\w[\w.]*):=", path.read_text(encoding="utf-8")):
        assert name in SET or f'"{name}"' in launch, name


@names([path for path in PAGES if path.parent == DOCS])
def test_a_page_is_read_in_a_few_minutes(path):
    text = WRITTEN.sub("", path.read_text(encoding="utf-8"))
    assert len(re.findall(r"\S*\w\S*", text)) <= LONGEST


def test_every_page_is_in_the_navigation():
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    listed = "\n".join(re.findall(r"```{toctree}.*?```", index, re.DOTALL))
    found = set(re.findall(r"^([\w/]+)$", listed, re.MULTILINE))
    pages = {path.relative_to(DOCS).with_suffix("").as_posix() for path in PAGES}
    assert {page for page in found if page.split("/")[0] not in BUILT} == pages - {"index"}
