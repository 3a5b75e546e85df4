# SPDX-License-Identifier: Apache-2.0
"""Messages that keep their quantities: sentences in SI that can be shown in other units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Quantity:
    """A figure of a message, written in SI; angles in degrees.

    Attributes:
        value: in SI.
        unit: its SI unit; ``"1"`` for a plain number.
        rounded: rounds it to a number of significant digits, such as a limit to its inside; None
            rounds to the nearest.

    Example:
        >>> print(Quantity(0.0378219, "m"), Quantity(1.05, "1"), Quantity(math.pi / 3.0, "rad"))
        0.0378219 m 1.05 60 deg
    """

    value: float
    unit: str
    rounded: Callable[[float, int], float] | None = None

    def __str__(self) -> str:
        if self.unit == "rad":
            return self.text(180.0 / math.pi, "deg", 6)
        return self.text(1.0, "" if self.unit == "1" else self.unit, 6)

    def text(self, factor: float, unit: str, digits: int) -> str:
        """Return it in a unit in which one of SI is ``factor``, with at most six digits."""
        value = factor * self.value
        if self.rounded is not None:  # a factor's rounding error is no reason to round a digit
            value = self.rounded(float(f"{value:.12g}"), digits)
        return f"{float(f'{value:.{digits}g}'):.6g} {unit}".rstrip()  # 10000, not 1e+04


class Message(str):
    """A sentence in SI, made of a template and its parts.

    It is a string like any other; only :meth:`told` looks at the parts.

    Args:
        template: the sentence with a place in braces for each part, as in :meth:`str.format`.
        parts: quantities, other messages, and anything else that is written as it is.

    Example:
        >>> message = Message("{} must be below {}", "pressure", Quantity(55.0e3, "Pa"))
        >>> message
        'pressure must be below 55000 Pa'
        >>> message.told(lambda quantity: f"{quantity.value / 1e3:g} kPa")
        'pressure must be below 55 kPa'
    """

    __slots__ = ("parts", "template")
    template: str
    parts: tuple[object, ...]

    def __new__(cls, template: str, *parts: object) -> Message:
        """Write the sentence in SI."""
        message = super().__new__(cls, template.format(*parts))
        message.template, message.parts = template, parts
        return message

    def __str__(self) -> str:
        return self  # str() would forget the parts

    def __reduce__(self) -> tuple[Any, ...]:
        return Message, (self.template, *self.parts)

    def told(self, show: Callable[[Quantity], str]) -> str:
        """Return the sentence with each quantity written by a function."""

        def text(part: object) -> object:
            if isinstance(part, Message):
                return part.told(show)
            return show(part) if isinstance(part, Quantity) else part

        return self.template.format(*map(text, self.parts))


def joined(separator: str, parts: Iterable[object]) -> Message:
    """Return parts as one message, with a separator between them.

    Example:
        >>> joined("; ", ["the coil closes", Message("at {}", Quantity(0.5, "m"))])
        'the coil closes; at 0.5 m'
    """
    each = tuple(parts)
    return Message(separator.join("{}" for _ in each), *each)
