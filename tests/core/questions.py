# SPDX-License-Identifier: Apache-2.0
"""Tables of calls, their good arguments, and what each argument must not be."""

from __future__ import annotations

from collections.abc import Callable, Iterator

Question = tuple[Callable[..., object], dict[str, object], dict[str, tuple[object, ...]]]


def wrong_arguments(table: list[Question]) -> Iterator[tuple[int, str, object]]:
    """Return every wrong value, with the number of its call and its argument."""
    for number, (_, _, wrong) in enumerate(table):
        for field, values in wrong.items():
            yield from ((number, field, value) for value in values)
