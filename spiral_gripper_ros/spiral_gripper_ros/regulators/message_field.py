# SPDX-License-Identifier: Apache-2.0
"""One number in a message of any type: ``data``, ``fluid_pressure``, ``data[2]``, ``a[0].b``."""

from __future__ import annotations

import importlib
import re
from collections.abc import Sequence
from typing import Any

from spiral_core.errors import InvalidInputError

_TYPE = re.compile(r"(\w+)/(?:msg/)?(\w+)")
_STEP = re.compile(r"([a-z]\w*)(?:\[(\d{1,3})\])?")
# "double", "sequence<double>", "sequence<double, 8>", "double[8]", the same of messages.
_ELEMENT = re.compile(r"(?:sequence<)?([\w/]+)")
_FLOATS = ("float", "double")


def message_type(parameter: str, name: str) -> Any:  # noqa: ANN401
    """Return the class of a message type such as ``std_msgs/msg/Float64``.

    Args:
        parameter: that names it, for the error.
        name: of the type.

    Raises:
        InvalidInputError: there is none of that name here.
    """
    requirement = "a message type that is installed here, such as std_msgs/msg/Float64"
    match = _TYPE.fullmatch(name)
    try:
        if match is None:
            raise InvalidInputError(parameter, name, requirement)
        return getattr(importlib.import_module(f"{match[1]}.msg"), match[2])
    except (ImportError, AttributeError) as error:
        raise InvalidInputError(parameter, name, f"{requirement} ({error})") from None


class MessageField:
    """A floating-point number in messages of one type.

    Args:
        parameter: that names the field, for the error.
        kind: class of the messages.
        path: names of fields, separated by dots, each with an index if it is an array.
        length: elements of the arrays on the way; at least up to the index.

    Raises:
        InvalidInputError: messages of this type have no such number.
    """

    def __init__(self, parameter: str, kind: Any, path: str, length: int = 0) -> None:  # noqa: ANN401
        self._kind, self._length = kind, length
        matches = [_STEP.fullmatch(part) for part in path.split(".")]
        # Names of fields, and which of its elements if it is an array.
        self._steps = [(m[1], None if m[2] is None else int(m[2])) for m in matches if m]
        try:
            if len(self._steps) != len(matches):
                raise ValueError("names separated by dots, each with [index] if it is an array")
            self.number(self.message(0.0, 0.0))
        except (AssertionError, AttributeError, LookupError, TypeError, ValueError) as error:
            requirement = f"the path of a floating-point number in {kind.__name__} ({error})"
            raise InvalidInputError(parameter, path, requirement) from None

    def message(self, number: float, others: float) -> Any:  # noqa: ANN401
        """Return a message with the number; other elements of its array hold ``others``."""
        return self._filled(self._kind(), self._steps, number, others)

    def number(self, message: Any) -> float:  # noqa: ANN401
        """Return the number of a message; any float.

        Raises:
            IndexError: the message's array is too short.
        """
        for name, element in self._steps:
            message = getattr(message, name)
            if element is not None:
                message = message[element]
        return float(message)

    def _filled(
        self,
        message: Any,  # noqa: ANN401
        steps: Sequence[tuple[str, int | None]],
        number: float,
        others: float,
    ) -> Any:  # noqa: ANN401
        (name, index), *rest = steps
        (kind,) = _ELEMENT.match(message.get_fields_and_field_types()[name]).groups()  # type: ignore[union-attr]
        if not rest and kind not in _FLOATS:
            raise TypeError(f"{name} holds {kind}")

        def element(value: float) -> Any:  # noqa: ANN401
            if not rest:
                return value
            return self._filled(message_type("type", kind)(), rest, value, others)

        if index is None:
            setattr(message, name, element(number))
        else:
            length = max(index + 1, self._length, len(getattr(message, name)))
            values = (number if i == index else others for i in range(length))
            setattr(message, name, [element(value) for value in values])
        return message
