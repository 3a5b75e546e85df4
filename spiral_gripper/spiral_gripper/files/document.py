# SPDX-License-Identifier: Apache-2.0
"""YAML text to entries with their line and column; values are not interpreted here.

Only the syntax tree is used: scalars keep the text the user wrote, and no YAML type is constructed.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import TYPE_CHECKING

from spiral_gripper.files.errors import DescriptionError, Problem, ProblemKind

if TYPE_CHECKING:
    from ruamel.yaml.error import MarkedYAMLError
    from ruamel.yaml.nodes import MappingNode, Node

_LONGEST_QUOTE = 60
_CORE_TAG = "tag:yaml.org,2002:"


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of a file.

    Attributes:
        line: line in the file, from 1.
        column: column in that line, from 1.
        raw: the file's own text, shortened to one line, to quote in messages.
        tag: YAML's type: "str", "int", "float", "bool", "null", "seq", "map", or another tag.
        text: a scalar's text; empty for a list or a mapping.
        items: the items of a list; empty for anything else.
    """

    line: int
    column: int
    raw: str
    tag: str
    text: str = ""
    items: tuple[Entry, ...] = ()


@dataclass(frozen=True, slots=True)
class Document:
    """The entries of one file by dotted name, its sections, and the problems found so far.

    Attributes:
        file: the file's name for messages.
        fields: the dotted names allowed; what stands before a dot is a section.
        entries: what the file holds, by dotted name.
        sections: where each section begins.
        problems: what is wrong.
    """

    file: str
    fields: Collection[str]
    entries: dict[str, Entry] = field(default_factory=dict)
    sections: dict[str, Entry] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def note(
        self,
        kind: ProblemKind,
        name: str,
        place: Entry | None,
        requirement: str,
        value: str | None = None,
    ) -> None:
        """Note a problem with a field, at a place in the file or at the file as a whole."""
        line, column = (None, None) if place is None else (place.line, place.column)
        self.problems.append(Problem(kind, self.file, line, column, name, value, requirement))

    def raise_problems(self) -> None:
        """Raise everything noted so far as one DescriptionError, if there is anything."""
        if self.problems:
            raise DescriptionError(self.problems)

    def walk(self, node: MappingNode, section: str = "") -> None:
        """Sort the keys of one mapping into entries, sections and problems."""
        for key_node, value_node in node.value:
            key, value = _entry(key_node), _entry(value_node)
            name = f"{section}.{key.text or key.raw}" if section else key.text or key.raw
            first = self.entries.get(name) or self.sections.get(name)
            if first is not None:
                advice = f"keep one of the two, here and on line {first.line}"
                self.note(ProblemKind.DUPLICATE, name, key, advice)
            elif name in self.fields and "." not in key.text:
                self.entries[name] = value
            elif members := self._members(name):
                self.sections[name] = key
                if value.tag == "map":
                    self.walk(value_node, name)
                elif value.tag != "null":
                    wanted = f"a section with the fields {', '.join(members)}"
                    self.note(ProblemKind.WRONG, name, value, wanted, value.raw)
            else:
                self.note(ProblemKind.UNKNOWN, name, key, self._advice(name, section))

    def _members(self, section: str) -> list[str]:
        """Return the names a section may hold; at the top, the sections and the fields in none."""
        if not section:
            return list(dict.fromkeys(name.split(".")[0] for name in self.fields))
        return [name.split(".")[1] for name in self.fields if name.startswith(f"{section}.")]

    def _advice(self, name: str, section: str) -> str:
        """Return the nearest field to an unknown name, or the list of what would be allowed."""
        prefix = f"{section}." if section else ""
        key, members = name.removeprefix(prefix), self._members(section)
        if name in self.fields:  # written with its dot
            return f"write {' in the section '.join(reversed(name.split('.')))}"
        if key.endswith("diameter") and f"{prefix}{key[:-8]}radius" in self.fields:
            return f"give {prefix}{key[:-8]}radius, half of it"
        elsewhere = [known for known in self.fields if known.split(".")[-1] == key]
        nearest = [f"{prefix}{near}" for near in get_close_matches(key, members, n=1)]
        for meant in (*elsewhere, *nearest):
            return f"did you mean {meant}?"
        where = f"the fields of {section}" if section else "the fields"
        return f"{where} are {', '.join(members)}"

    def looks_like_a_file_of_its_kind(self) -> bool:
        """Return whether an unknown name is a known one with a mistake: it may be quoted."""
        known = {part for name in self.fields for part in (name, name.partition(".")[0])}
        return any(get_close_matches(problem.field, known) for problem in self.problems)


def read_document(
    text: str, file: str, fields: Collection[str], required: Collection[str] = ()
) -> Document:
    """Return the entries of a YAML text; unknown and repeated fields are noted as problems.

    Args:
        text: the file's text.
        file: the file's name for messages.
        fields: the dotted names allowed; what stands before a dot is a section.
        required: those that a file must have, for the message about a file without any.

    Raises:
        DescriptionError: the text is empty, is not YAML, or is not a mapping of fields.

    Example:
        >>> document = read_document("tube: {length: 500 mm}", "mine.yaml", ["tube.length"])
        >>> entry = document.entries["tube.length"]
        >>> entry.text, entry.line, entry.column
        ('500 mm', 1, 16)
    """
    from ruamel.yaml.nodes import MappingNode

    document = Document(file, fields)
    root = _compose(text, file)
    if isinstance(root, MappingNode):
        document.walk(root)
        if document.entries or document.sections or document.looks_like_a_file_of_its_kind():
            return document
    # What it holds instead is not quoted: it may be any file, named by who may not read it.
    found = "is empty" if root is None else "holds none of a description's fields"
    advice = "`spiral-gripper grippers show paper_design_70` prints one to begin with"
    reason = f"it {found}, and must hold fields such as {', '.join(required)}; {advice}"
    raise DescriptionError([Problem(ProblemKind.UNREADABLE, file, None, None, "", None, reason)])


def _compose(text: str, file: str) -> Node | None:
    """Return the root node of a YAML text, None if there is none; raise what is not YAML."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError
    from ruamel.yaml.reader import ReaderError

    place: tuple[int | None, int | None] = (None, None)
    try:
        root: Node | None = YAML(typ="safe", pure=True).compose(text)
        return root
    except MarkedYAMLError as error:
        reason = " ".join(part for part in (error.context, error.problem) if part)
        missing = _missing_colon(error, text.splitlines())
        if missing is not None:
            place, reason = missing, "a colon is missing here"
        elif mark := error.problem_mark or error.context_mark:
            place = (mark.line + 1, mark.column + 1)
    except ReaderError as error:
        place = (text.count("\n", 0, error.position) + 1, None)
        reason = f"character {error.position} is not allowed: {error.reason}"
    except RecursionError:
        reason = "lists or mappings are nested too deep"
    except YAMLError as error:
        reason = str(error)
    # Names of aliases and tags are words of the file, which may be any.
    reason = re.sub(r" '[\w!%&*][^']+'", "", " ".join(reason.split()))
    raise DescriptionError([Problem(ProblemKind.NOT_YAML, file, *place, "", None, reason)])


def _missing_colon(error: MarkedYAMLError, lines: list[str]) -> tuple[int, int] | None:
    """Return the line and column after a key without its colon; None if that is not the problem."""
    if error.problem == "could not find expected ':'" and error.context_mark is not None:
        line = error.context_mark.line
    elif error.problem == "mapping values are not allowed here" and error.problem_mark is not None:
        mark = error.problem_mark
        if mark.line == 0 or ":" in lines[mark.line][: mark.column]:
            return None
        line = mark.line - 1
        while line > 0 and not lines[line].strip():
            line -= 1
    else:
        return None
    return line + 1, len(lines[line].rstrip()) + 1


def _entry(node: Node, *, is_item: bool = False) -> Entry:
    """Return what one node holds; a list or a mapping in a list is its raw text alone."""
    mark = node.start_mark
    raw = " ".join(mark.buffer[mark.index : node.end_mark.index].split())
    raw = raw if len(raw) <= _LONGEST_QUOTE else f"{raw[: _LONGEST_QUOTE - 3]}..."
    tag = str(node.tag).removeprefix(_CORE_TAG)
    place = (mark.line + 1, mark.column + 1, raw, tag)
    if not isinstance(node.value, list):
        return Entry(*place, text=node.value)
    items = node.value if tag == "seq" and not is_item else ()
    return Entry(*place, items=tuple(_entry(item, is_item=True) for item in items))
