# SPDX-License-Identifier: Apache-2.0
"""The pages of the documentation: generated tables, links, headings, length, navigation."""

import re

import pytest
from repo.source_tree import ROOT

from docs.tables import BLOCK, tables, with_tables

DOCS = ROOT / "docs"
PAGES = sorted([*DOCS.glob("*.md"), *DOCS.glob("derivations/*.md")])
LINK = re.compile(r"""(?:\]\(|src=")([^)"\s#]*)(?:#([^)\s]*))?[)"]""")
FENCED = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
# Longest page [words], without what programs write into it.
LONGEST = 1500
WRITTEN = re.compile(r"<!-- (?:table|From) .*?<!-- end -->", re.DOTALL)
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
        if anchor:
            assert anchor in anchors(linked), f"{target}#{anchor}"


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
