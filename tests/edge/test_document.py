# SPDX-License-Identifier: Apache-2.0
"""The YAML layer: places, quotes and mistakes, whatever the fields mean."""

import pytest
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


# A text -> a part of its problem, whose sentence is that of its kind.
MISTAKES = {
    "tube:\n  lenght: 5 mm\n": "2:3: tube.lenght is not a field here; did you mean",
    "nam: x\n": "1:1: nam is not a field here; did you mean name?",
    "name: a\nlength: 5 mm\n": "2:1: length is not a field here; did you mean",
    "tube: {xyzzy: 1}\n": "here; the fields of tube are length, inner_radius",
    "name: a\n<<: {name: a}\n": "2:1: << is not a field here; the fields are name",
    "name: a\n? [a, b]\n: 1\n": "2:3: [a, b] is not a field here; the fields are",
    "tube.length: 3 mm\n": "1:1: tube.length is not a field here; write length i",
    "tube: {inner_diameter: 1}": "here; give tube.inner_radius, half of it",
    "tube:\n  length: 3\n  length: 4\n": "3:3: tube.length is given twice; keep",
    "tube: {}\nname: a\ntube: {}\n": "one of the two, here and on line 1",
    "tube: 500 mm\n": "1:7: tube must be a section with the fields length, inner_r",
    "# a comment\n": "mine.yaml: this file cannot be read: it is empty, and must",
    "- name\n": "holds none of a description's fields, and must hold fields such",
    "name: [1": "1:9: this is not valid YAML: while parsing a flow sequence ",
    "name: a: b": "1:8: this is not valid YAML: mapping values are not allowed",
    "name: a\n\ttube: 1": "2:1: this is not valid YAML: while scanning for the nex",
    "name: a\n---\nname: b": "2:1: this is not valid YAML: expected a single",
    "name: *nowhere": "1:7: this is not valid YAML: found undefined alias",
    "name: a\ntube:\x00": "mine.yaml:2: this is not valid YAML: character 13 is no",
    "name: " + "[" * 1000: "lists or mappings are nested too deep",
    "name: a\ntube\n  length: 1": "2:5: this is not valid YAML: a colon is missing",
    "# a\ntube\n\n  length: 1": "2:5: this is not valid YAML: a colon is missing",
}


@pytest.mark.parametrize("text", MISTAKES)
def test_mistakes_are_named_with_their_place(text):
    (problem,) = problems_of(text)
    assert MISTAKES[text] in str(problem)


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
