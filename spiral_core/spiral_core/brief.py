# SPDX-License-Identifier: Apache-2.0
"""Values shown on a few lines: arrays by their shape, long tuples by their length."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from enum import Enum
from inspect import isfunction

import numpy as np

# More items, or nested values, are counted instead of shown.
_MOST_ITEMS = 4


def brief_repr(value: object) -> str:
    """Return a dataclass's fields, short enough to read; SI units, six digits.

    To be a class's ``__repr__``. Private fields and those that the class keeps out of its repr are
    left out.

    Example:
        >>> from spiral_core import Rod, RodLoad, Section, solve_rod
        >>> state = solve_rod(Rod(0.3, Section.inextensible(3e-4, 2e-4)), RodLoad())
        >>> print(repr(state)[:62])
        RodState(status=CONVERGED, arc_lengths=<array (25,)>, position
    """
    shown = (
        f"{one.name}={_brief(getattr(value, one.name))}"
        for one in fields(value)  # type: ignore[arg-type]
        if one.repr and not one.name.startswith("_")
    )
    return f"{type(value).__name__}({', '.join(shown)})"


def _brief(value: object) -> str:
    """Return one field's value."""
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, np.ndarray):
        return f"<array {value.shape}>"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple):
        plain = not any(isinstance(item, tuple) or is_dataclass(item) for item in value)
        if plain and len(value) <= _MOST_ITEMS:
            inner = ", ".join(_brief(item) for item in value)
            return f"({inner},)" if len(value) == 1 else f"({inner})"
        return f"<{len(value)} of {type(value[0]).__name__}>"
    if is_dataclass(value):
        name = getattr(value, "name", "")
        return f"<{type(value).__name__}{f' {name}' if isinstance(name, str) and name else ''}>"
    if isfunction(value):
        return f"<function {value.__name__}>"
    text = repr(value)
    return text if len(text) <= 60 else f"<{type(value).__name__}>"
