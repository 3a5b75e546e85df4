# SPDX-License-Identifier: Apache-2.0
"""The YAML layer: places, quotes and mistakes, whatever the fields mean."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiral_gripper import DescriptionError, ProblemKind
from spiral_gripper.files.document import read_document

FIELDS = ("name", "tube.length", "tube.inner_radius", "mount.axis")
FILE = "mine.yaml"


def problems_of(text):
    try:
        document = read_document(text, FILE, FIELDS, ["name"])
    except DescriptionError as error:
        return list(error.problems)
    return document.problems


def test_entries_know_their_place_and_their_text():
    document = read_document(
        "# first\nname: 'a b'\ntube:\n  length:   500 mm  # note\nmount: {axis: [1, 0.50]}\n",
        FILE,
        FIELDS,
    )
    assert not document.problems
    name, length, axis = (document.entries[key] for key in ("name", "tube.length", "mount.axis"))
    assert (name.line, name.column, name.text, name.raw) == (2, 7, "a b", "'a b'")
    assert (length.line, length.column, length.text, length.tag) == (4, 13, "500 mm", "str")
    assert [(item.text, item.tag, item.column) for item in axis.items] == [
        ("1", "int", 16),
        ("0.50", "float", 19),
    ]
    assert (document.sections["tube"].line, document.sections["tube"].column) == (3, 1)


def test_long_values_are_quoted_on_one_short_line():
    document = read_document("name: >\n  " + "word \n  " * 50, FILE, FIELDS)
    assert document.entries["name"].raw == "> " + "word " * 11 + "..."


@pytest.mark.parametrize(
    ("text", "messages"),
    [
        (
            "tube:\n  lenght: 5 mm\n",
            ["mine.yaml:2:3: tube.lenght is not a field here; did you mean tube.length?"],
        ),
        ("nam: x\n", ["mine.yaml:1:1: nam is not a field here; did you mean name?"]),
        (
            "name: a\nlength: 5 mm\n",
            ["mine.yaml:2:1: length is not a field here; did you mean tube.length?"],
        ),
        (
            "tube: {xyzzy: 1}\n",
            [
                (
                    "mine.yaml:1:8: tube.xyzzy is not a field here; "
                    "the fields of tube are length, inner_radius"
                )
            ],
        ),
        (
            "name: a\nxyzzy: 1\n",
            ["mine.yaml:2:1: xyzzy is not a field here; the fields are name, tube, mount"],
        ),
        (
            "name: a\n<<: {name: a}\n",
            ["mine.yaml:2:1: << is not a field here; the fields are name, tube, mount"],
        ),
        (
            "name: a\n? [a, b]\n: 1\n",
            ["mine.yaml:2:3: [a, b] is not a field here; the fields are name, tube, mount"],
        ),
        (
            "tube.length: 3 mm\n",
            ["mine.yaml:1:1: tube.length is not a field here; write length in the section tube"],
        ),
        (
            "tube:\n  length: 3 mm\n  length: 4 mm\n",
            ["mine.yaml:3:3: tube.length is given twice; keep one of the two, here and on line 2"],
        ),
        (
            "tube: {}\nname: a\ntube: {}\n",
            ["mine.yaml:3:1: tube is given twice; keep one of the two, here and on line 1"],
        ),
        (
            "tube: 500 mm\n",
            [
                (
                    "mine.yaml:1:7: tube must be a section with the fields length, inner_radius, "
                    "got 500 mm"
                )
            ],
        ),
        (
            "name: a\na: 1\nb: 2\n",
            [
                "mine.yaml:2:1: a is not a field here; the fields are name, tube, mount",
                "mine.yaml:3:1: b is not a field here; the fields are name, tube, mount",
            ],
        ),
        (
            "",
            [
                (
                    "mine.yaml: this file cannot be read: "
                    "it is empty, and must hold fields such as name; "
                    "`spiral-gripper grippers show paper_design_70` prints one to begin with"
                )
            ],
        ),
        (
            "# only a comment\n",
            [
                (
                    "mine.yaml: this file cannot be read: "
                    "it is empty, and must hold fields such as name; "
                    "`spiral-gripper grippers show paper_design_70` prints one to begin with"
                )
            ],
        ),
        (
            "- name\n",
            [
                (
                    "mine.yaml: this file cannot be read: "
                    "it holds none of a description's fields, and must hold fields such as name; "
                    "`spiral-gripper grippers show paper_design_70` prints one to begin with"
                )
            ],
        ),
        ("name: [1", ["mine.yaml:1:9: this is not valid YAML: while parsing a flow sequence "]),
        ("name: a: b", ["mine.yaml:1:8: this is not valid YAML: mapping values are not allowed"]),
        (
            "name: a\n\ttube: 1",
            [
                (
                    "mine.yaml:2:1: this is not valid YAML: while scanning for the next token "
                    "found character '\\t' that cannot start any token"
                )
            ],
        ),
        ("name: a\n---\nname: b", ["mine.yaml:2:1: this is not valid YAML: expected a single"]),
        ("name: *nowhere", ["mine.yaml:1:7: this is not valid YAML: found undefined alias"]),
        (
            "name: a\ntube:\x00",
            ["mine.yaml:2: this is not valid YAML: character 13 is not allowed"],
        ),
        (
            "name: " + "[" * 5000,
            ["mine.yaml: this is not valid YAML: lists or mappings are nested too deep"],
        ),
    ],
)
def test_mistakes_are_named_with_their_place(text, messages):
    found = [str(problem) for problem in problems_of(text)]
    assert len(found) == len(messages)
    for problem, message in zip(found, messages, strict=True):
        assert problem.startswith(message)


def test_an_entry_that_refers_to_itself_is_no_endless_loop():
    document = read_document("tube: &tube\n  length: *tube\n", FILE, FIELDS)
    assert document.entries["tube.length"].tag == "map"


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("name: a\nxyzzy: 1", ProblemKind.UNKNOWN),
        ("name: a\nname: b", ProblemKind.DUPLICATE),
        ("tube: a", ProblemKind.WRONG),
        ("", ProblemKind.UNREADABLE),
        ("'", ProblemKind.NOT_YAML),
    ],
)
def test_programs_can_tell_the_mistakes_apart(text, kind):
    assert [problem.kind for problem in problems_of(text)] == [kind]


@given(st.text(alphabet="abz01.:-[]{}'\"\n \t#&*!|>%@`?,<~\\\x00é", max_size=60))
def test_any_text_is_read_or_refused_as_a_description(text):
    for problem in problems_of(text):
        assert str(problem).startswith(FILE)


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
        read_document(text, "passwd", ["name", "tube.length"])
    assert "secret" not in str(caught.value)
