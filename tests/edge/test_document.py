# SPDX-License-Identifier: Apache-2.0
"""The YAML layer: places, quotes and mistakes, whatever the fields mean."""

import pytest
from edge.recorded import cases, check, written
from hypothesis import given
from hypothesis import strategies as st

from spiral_gripper import DescriptionError
from spiral_gripper.files.document import read_document

FIELDS = ("name", "tube.length", "tube.inner_radius", "mount.axis")


def read(text):
    return read_document(text, "mine.yaml", FIELDS, ["name"])


def problems_of(text):
    try:
        return read(text).problems
    except DescriptionError as error:
        return error.problems


def test_entries_know_their_place_and_their_text():
    text = "# first\nname: 'a b'\ntube:\n  length:   500 mm  # note\nmount: {axis: [1, 0.50]}\n"
    document = read(text)
    name, length, axis = (document.entries[key] for key in ("name", "tube.length", "mount.axis"))
    assert (name.line, name.column, name.text, name.raw) == (2, 7, "a b", "'a b'")
    assert (length.line, length.column, length.text, length.tag) == (4, 13, "500 mm", "str")
    items = [(item.text, item.tag, item.column) for item in axis.items]
    assert items == [("1", "int", 16), ("0.50", "float", 19)]
    long = read("name: >\n  " + "word \n  " * 50).entries["name"]
    assert long.raw == "> " + "word " * 11 + "..."
    # An entry that refers to itself is no endless loop.
    assert read("tube: &tube\n  length: *tube\n").entries["tube.length"].tag == "map"


@pytest.mark.parametrize("case", cases("documents.txt"))
def test_mistakes_are_named_with_their_place(case):
    check("documents.txt", case, [str(problem) for problem in problems_of(written(case))])


@given(st.text(alphabet="abz01.:-[]{}'\"\n \t#&*!|>%@`?,<~\\\x00é", max_size=60))
def test_any_text_is_read_or_refused_as_a_description(text):
    for problem in problems_of(text):
        assert str(problem).startswith("mine.yaml")


SECRETS = ("secret line", "secret: 1\nroot: *x", "secret:*:1:2:", "- secret")


@pytest.mark.parametrize("text", [*SECRETS, "a: *secret", "a: !secret b"])
def test_nothing_of_another_file_is_quoted(text):
    """The node may read files that whoever sets its parameter `gripper` may not."""
    with pytest.raises(DescriptionError) as caught:
        read(text)
    assert "secret" not in str(caught.value)
