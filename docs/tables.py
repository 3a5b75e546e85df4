# SPDX-License-Identifier: Apache-2.0
"""The tables of these pages that the code states: python docs/tables.py writes them.

Each stands between two comments of its page, ``<!-- table NAME -->`` and ``<!-- end -->``.
"""

import math
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from spiral_gripper.files.fields import FIELDS, LAWS, constants_of
from spiral_gripper.files.units import Dimension
from spiral_gripper_ros.control.states import TRANSITIONS, State
from spiral_gripper_ros.parameters.spec import ParameterSpec
from spiral_gripper_ros.parameters.table import PARAMETERS

PAGES = Path(__file__).parent
BLOCK = re.compile(r"(<!-- table (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def tables() -> dict[str, str]:
    """Return each table in Markdown, by its name."""
    return {
        "fields": _fields(),
        "transitions": _transitions(),
        "quantities": _quantities(),
        "node_parameters": _parameters(PARAMETERS),
    }


def with_tables(page: str) -> str:
    """Return the text of a page with its tables as the code states them."""
    stated = tables()
    return BLOCK.sub(lambda block: f"{block[1]}{stated[block[2]]}{block[3]}", page)


def _fields() -> str:
    """Return the fields of a gripper file; a constant is required by the laws that have it."""
    rows = []
    for name, field in FIELDS.items():
        laws = [f"`{law}`" for law in LAWS if name.removeprefix("material.") in constants_of(law)]
        required = f"**required** by {', '.join(laws)}" if laws else "**required**"
        left_out = required if laws or field.required else field.default
        rows.append((f"`{name}`", field.kind, field.allowed, left_out))
    return _table(("field", "kind", "allowed", "if left out"), rows)


def _transitions() -> str:
    """Return what each event leads to; states that it leads to the same stand in one row."""
    sources: dict[tuple[str, str, str], list[State]] = {}
    for (state, event), (new, rule) in TRANSITIONS.items():
        sources.setdefault((event.value, new.name, rule.value), []).append(state)
    rows = []
    for (happens, target, command), states in sources.items():
        names = ", ".join(state.name for state in State if state in states)
        if len(states) >= len(State) - 2:
            others = [state.name for state in State if state not in states]
            names = f"every state but {' and '.join(others)}" if others else "every state"
        rows.append((happens, names, target, command))
    return _table(("event", "from", "to", "command"), rows)


def _quantities() -> str:
    """Return what the quantities of a gripper file are written like."""
    used = {field.dimension for field in FIELDS.values()}
    rows = [
        (kind.quantity, f"`{kind.example}`", ", ".join(f"`{unit}`" for unit in kind.usual_units))
        for kind in Dimension
        if kind in used
    ]
    return _table(("quantity", "written as", "usual units"), rows)


def _parameters(specs: Sequence[ParameterSpec]) -> str:
    """Return a table of parameters; those that cannot be set say so."""
    rows = []
    for spec in specs:
        fixed = " Fixed at the start." if spec.read_only else ""
        rows.append((f"`{spec.name}`", _default(spec), spec.span, f"{spec.description}{fixed}"))
    return _table(("name", "default", "range", "meaning"), rows)


def _default(spec: ParameterSpec) -> str:
    """Return a default as it must be typed: rclpy takes 1 for another type than 1.0."""
    default = spec.default
    if isinstance(default, bool):
        return str(default).lower()
    if isinstance(default, float):
        return ".nan" if math.isnan(default) else repr(default)
    return "not set" if default in ((), "") else str(default)


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(cells)} |\n".replace("|  |", "| |") for cells in (head, *rows)]
    return "".join((lines[0], "|---" * len(head), "|\n", *lines[1:]))


if __name__ == "__main__":
    for path in PAGES.glob("*.md"):
        text = path.read_text(encoding="utf-8")
        path.write_text(with_tables(text), encoding="utf-8")
