# SPDX-License-Identifier: Apache-2.0
"""A result as a table of fields, from which its rows for people and its JSON are made."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from enum import Enum
from operator import attrgetter
from typing import Any, NamedTuple, TypeAlias

from spiral_gripper.files.shown import shown

# From a result to something; an attribute's dotted name stands for its value.
Getter: TypeAlias = Callable[[Any], Any]
Rows: TypeAlias = list[tuple[str, str]]
# A result for programs, in SI.
Json: TypeAlias = dict[str, Any]
# Told the number of steps that are done, and of all.
Progress: TypeAlias = Callable[[int, int], None]


class Field(NamedTuple):
    """One figure of a result.

    Attributes:
        key: in JSON; empty for what only people see.
        label: of the row; empty for what only programs see.
        get: dotted name of the attribute, or a function of the result.
        show: the figure's SI unit; or the row's text, with a place in braces for each figure; or a
            function from the result to that text, or to several rows. A row whose text is None is
            left out.
    """

    key: str
    label: str | Callable[[Any], str]
    get: str | Getter
    show: str | Callable[[Any], str | Rows | None] = "1"

    def value(self, result: object) -> Any:  # noqa: ANN401
        """Return the figure in SI."""
        return attrgetter(self.get)(result) if isinstance(self.get, str) else self.get(result)

    def text(self, result: object) -> str | Rows | None:
        """Return the row's text, or several rows; a figure that does not exist has an empty one."""
        if not isinstance(self.show, str):
            return self.show(result)
        value = self.value(result)
        if value is None:
            return ""
        figures = value if hasattr(value, "__len__") and not isinstance(value, str) else (value,)
        if "{" in self.show:
            return self.show.format(*figures)
        return ", ".join(shown(float(figure), self.show) for figure in figures)


def data(**figures: str | Getter) -> list[Field]:
    """Return fields that only programs see, by their keys."""
    return [Field(key, "", get) for key, get in figures.items()]


def rows_of(fields: Sequence[Field], result: object) -> Rows:
    """Return the rows of a result: names and texts."""
    found: Rows = []
    for field in fields:
        label = field.label if isinstance(field.label, str) else field.label(result)
        text = field.text(result) if label or callable(field.show) else None
        if isinstance(text, list):
            found += text
        elif text is not None:
            found.append((label, text))
    return found


def document_of(fields: Sequence[Field], result: object) -> Json:
    """Return a result for programs, in SI."""
    return {field.key: plain(field.value(result)) for field in fields if field.key}


def plain(value: object) -> Any:  # noqa: ANN401
    """Return a value as plain data for JSON: dictionaries, lists, text, numbers, null for NaN, inf.

    Dataclasses become dictionaries of their fields, enumerations their names in lower case, arrays
    lists.

    Example:
        >>> from spiral_core.design.margin import Constraint
        >>> plain({"bound": math.inf, "by": Constraint.STRAIN, "at": (1, 2.5)})
        {'bound': None, 'by': 'strain', 'at': [1, 2.5]}
    """
    if isinstance(value, Enum):
        return value.name.lower()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if hasattr(value, "tolist"):  # numpy's arrays and scalars
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    raise TypeError(f"no plain form for {type(value).__name__}")
