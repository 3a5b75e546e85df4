# SPDX-License-Identifier: Apache-2.0
"""The YAML layer: places, quotes and mistakes, whatever the fields mean."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiral_gripper import DescriptionError, ProblemKind
from spiral_gripper.files.document import read_document

FIELDS = ("name", "tube.length", "tube.inner_radius", "mount.axis")


def read(text):
    return read_document(text, "mine.yaml", FIELDS, ["name"])


def problems_of(text):
    try:
        return read(text).problems
    except DescriptionError as error:
        return list(error.problems)


def test_entries_know_their_place_and_their_text():
    text = "# first\nname: 'a b'\ntube:\n  length:   500 mm  # note\nmount: {axis: [1, 0.50]}\n"
    document = read(text)
    assert not document.problems
    name, length, axis = (document.entries[key] for key in ("name", "tube.length", "mount.axis"))
    assert (name.line, name.column, name.text, name.raw) == (2, 7, "a b", "'a b'")
    assert (length.line, length.column, length.text, length.tag) == (4, 13, "500 mm", "str")
    items = [(item.text, item.tag, item.column) for item in axis.items]
    assert items == [("1", "int", 16), ("0.50", "float", 19)]
    assert (document.sections["tube"].line, document.sections["tube"].column) == (3, 1)
    long = read("name: >\n  " + "word \n  " * 50).entries["name"]
    assert long.raw == "> " + "word " * 11 + "..."
    # An entry that refers to itself is no endless loop.
    assert read("tube: &tube\n  length: *tube\n").entries["tube.length"].tag == "map"


UNKNOWN, DUPLICATE, WRONG = ProblemKind.UNKNOWN, ProblemKind.DUPLICATE, ProblemKind.WRONG
UNREADABLE, NOT_YAML = ProblemKind.UNREADABLE, ProblemKind.NOT_YAML


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        (
            "tube:\n  lenght: 5 mm\n",
            UNKNOWN,
            "2:3: tube.lenght is not a field here; did you mean",
        ),
        ("nam: x\n", UNKNOWN, "1:1: nam is not a field here; did you mean name?"),
        ("name: a\nlength: 5 mm\n", UNKNOWN, "2:1: length is not a field here; did you mean"),
        ("tube: {xyzzy: 1}\n", UNKNOWN, "here; the fields of tube are length, inner_radius"),
        ("name: a\nxyzzy: 1\n", UNKNOWN, "2:1: xyzzy is not a field here; the fields are name, tu"),
        ("name: a\n<<: {name: a}\n", UNKNOWN, "2:1: << is not a field here; the fields are name"),
        ("name: a\n? [a, b]\n: 1\n", UNKNOWN, "2:3: [a, b] is not a field here; the fields are"),
        ("tube.length: 3 mm\n", UNKNOWN, "1:1: tube.length is not a field here; write length i"),
        ("tube: {inner_diameter: 1}", UNKNOWN, "here; give tube.inner_radius, half of it"),
        (
            "tube:\n  length: 3\n  length: 4\n",
            DUPLICATE,
            "3:3: tube.length is given twice; keep",
        ),
        ("tube: {}\nname: a\ntube: {}\n", DUPLICATE, "one of the two, here and on line 1"),
        (
            "tube: 500 mm\n",
            WRONG,
            "1:7: tube must be a section with the fields length, inner_r",
        ),
        ("# a comment\n", UNREADABLE, "mine.yaml: this file cannot be read: it is empty, and must"),
        ("- name\n", UNREADABLE, "holds none of a description's fields, and must hold fields such"),
        ("name: [1", NOT_YAML, "1:9: this is not valid YAML: while parsing a flow sequence "),
        ("name: a: b", NOT_YAML, "1:8: this is not valid YAML: mapping values are not allowed"),
        ("name: a\n\ttube: 1", NOT_YAML, "2:1: this is not valid YAML: while scanning for the nex"),
        ("name: a\n---\nname: b", NOT_YAML, "2:1: this is not valid YAML: expected a single"),
        ("name: *nowhere", NOT_YAML, "1:7: this is not valid YAML: found undefined alias"),
        ("name: a\ntube:\x00", NOT_YAML, "mine.yaml:2: this is not valid YAML: character 13 is no"),
        ("name: " + "[" * 5000, NOT_YAML, "lists or mappings are nested too deep"),
        ("name: a\ntube\n  length: 1", NOT_YAML, "2:5: this is not valid YAML: a colon is missing"),
        (
            "name: a\ntube\n\n  length: 1",
            NOT_YAML,
            "2:5: this is not valid YAML: a colon is missing",
        ),
    ],
)
def test_mistakes_are_named_with_their_place_and_their_kind(text, kind, message):
    (problem,) = problems_of(text)
    assert message in str(problem)
    assert problem.kind is kind


def test_all_unknown_fields_are_named():
    assert [problem.field for problem in problems_of("name: a\na: 1\nb: 2\n")] == ["a", "b"]


@given(st.text(alphabet="abz01.:-[]{}'\"\n \t#&*!|>%@`?,<~\\\x00é", max_size=60))
def test_any_text_is_read_or_refused_as_a_description(text):
    for problem in problems_of(text):
        assert str(problem).startswith("mine.yaml")


@pytest.mark.parametrize(
    "text",
    [
        "secret line\n",
        "secret: 1\nroot: *x\n",
        "secret:*:1:2:\n",
        "- secret\n",
        "secret: 1\n",
        "a: *secret\n",
        "a: !secret b\n",
    ],
)
def test_nothing_of_another_file_is_quoted(text):
    """The node may read files that whoever sets its parameter `gripper` may not."""
    with pytest.raises(DescriptionError) as caught:
        read(text)
    assert "secret" not in str(caught.value)
